//! A mesh layer across which the field does not change its gradient has no effect, no matter how near the contact surface is.

use crate::support::scenes::{layered, pair};
use crate::support::worlds::cuboid;
use hydroelastic::contact::{Kinks, Shape, SurfaceLaw};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix6, Vector3, Vector6, vector};

/// Edge (m) of a cube of modulus 1 about the origin.
const LARGE: f64 = 2.0;

/// Position of the middle of a small cube in the large cube: below its center, off the diagonals of its sides.
const PLACE: Vector3<f64> = vector![0.2, 0.05, -0.6];

/// Tolerance of the derivatives, relative to the contribution of one side of the small cube, because those of all sides nearly cancel.
/// Corners within 4.3e-10 m of each other may count as one corner. If the slopes of the fields differ by a factor of 800, the contact
/// surface moves 800 times as far as the bodies.
const SAME: f64 = 2e-4;

/// Returns the derivatives of the wrench on the large cube with respect to motions of a small cube, relative to the contribution of its
/// upper side. The first result is without a layer halfway inside the small cube, and the second with the layer at distance `gap` (m) from
/// the contact surface.
fn by_motions(edge: f64, gap: f64) -> [(Matrix6<f64>, Kinks); 2] {
    let whole = shapes::cuboid([edge; 3]).unwrap();
    let with_layer = layered(&whole, [1.0, 0.5]);
    // Halfway inside, at the upper side, both pressures are equal.
    let modulus = 2.0 * (1.0 + PLACE.z + 0.25 * edge);
    let slope = 2.0 * modulus / edge;
    let up = Vector3::z() * gap * (slope + 1.0);
    let law = SurfaceLaw::new(0.5, 0.4, 0.1).unwrap();
    let twists = [
        [0.1, 0.2, -0.3, 0.4, 0.1, 0.2],
        [-0.2, 0.1, 0.1, 0.3, 0.2, -0.1],
    ]
    .map(|numbers| Twist::from_vector(&Vector6::from(numbers)));
    let large = cuboid([LARGE; 3]);
    [whole, with_layer].map(|field| {
        let small = Shape::new(field);
        let bodies = (
            (&large, Pose::identity(), 1.0),
            (&small, Pose::from_translation(PLACE + up), modulus),
        );
        let contact = pair(bodies.0, bodies.1).moving(law, twists).linearized();
        let by_motions = contact.by_poses.fixed_view::<6, 6>(0, 6) / (0.5 * modulus * edge);
        (by_motions, contact.kinks)
    })
}

#[test]
fn a_layer_between_equal_gradients_changes_no_derivative_however_near_the_contact_surface_is() {
    for edge in [1.0 / 4.0, 1.0 / 64.0, 1.0 / 512.0] {
        for exponent in (-28..=-12).map(|halves| 0.5 * f64::from(halves)) {
            for side in [1.0, -1.0] {
                let gap = side * 10_f64.powf(exponent);
                let [(expected, _), (actual, kinks)] = by_motions(edge, gap);
                let error = (actual - expected).amax();
                assert!(error <= SAME, "edge {edge}, gap {gap:e}: {error:e}");
                assert!(kinks.are_flush || gap.abs() > 1e-10);
            }
        }
    }
}
