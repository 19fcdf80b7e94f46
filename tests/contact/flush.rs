//! Bodies with flush faces, for example stacked blocks. The wrench is differentiable there, although every contact polygon is in a
//! degenerate position.

use crate::support::differences::{at_rest, by_motion, central_difference};
use crate::support::hostile::kinks::kink_of;
use crate::support::hostile::measures::Measures;
use crate::support::hostile::{Family, Hostile};
use crate::support::scenes::{Random, mixed_shapes, pair, random_pair};
use crate::support::worlds::{at, cuboid};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SMatrix, SVector, Vector3, vector};
use num_dual::{DualSVec64, jacobian};

/// Error of differences. Second derivatives jump at flush poses, so the error of a difference is its step of 1e-7 times the jump.
const DIFFERENCES: f64 = 1e-5;

const STEP: f64 = 1e-7;

/// Rounding error between two methods for the same derivative at generic poses.
const TWO_WAYS: f64 = 1e-10;

/// Largest fraction of pairs whose derivatives through the clips may differ. If a vertex lies in a face of the other body's tetrahedra,
/// several planes meet in one corner. The clips do not consider all sides of this corner.
const MANY_SIDED: f64 = 0.03;

/// Relative tolerance of derivatives, compared with pressure times size.
const SAME: f64 = 1e-6;

/// Rounding error of a sum of areas.
const EXACT: f64 = 1e-12;

/// Returns the Jacobian of the wrench in first-order numbers.
fn first_order_jacobian(pair: &ContactPair) -> SMatrix<f64, 6, 14> {
    let wrench = |motion: SVector<DualSVec64<14>, 14>| {
        let body = |body: &ContactBody<'_>, row: usize, modulus_row: usize| {
            let twist = Twist::from_vector(&motion.fixed_rows::<6>(row).into_owned());
            let pose = Pose::lifted(body.pose()).moved_by(&twist);
            let modulus = (motion[modulus_row] + 1.0) * body.modulus();
            (pose, modulus)
        };
        let ((pose_a, modulus_a), (pose_b, modulus_b)) = (
            body(pair.a(), 0, 12),
            body(&pair.b().body().unwrap(), 6, 13),
        );
        let a = ContactBody::new(pair.a().shape(), pose_a, modulus_a).unwrap();
        let b = ContactBody::new(pair.b().shape().unwrap(), pose_b, modulus_b).unwrap();
        ContactPair::new(a, b).wrench().on_a.to_vector()
    };
    jacobian(wrench, &SVector::zeros()).1
}

#[test]
fn a_wrench_of_first_order_has_the_derivatives_of_the_generic_pipeline() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(71));
    for _ in 0..200 {
        let pair = random_pair(&shapes, &mut random);
        let dual = by_motion(&at_rest(&dual_wrench_jacobian(&pair).1), &pair);
        let error = (first_order_jacobian(&pair) - dual).amax();
        assert!(
            error <= TWO_WAYS * dual.amax(),
            "{error:e} of {:e}",
            dual.amax()
        );
    }
}

fn assert_equal_differences(shape: &Shape, pose: Pose, moduli: [f64; 2]) {
    let pair = pair(
        (shape, pose, moduli[0]),
        (shape, Pose::identity(), moduli[1]),
    );
    let differences = central_difference(&pair, STEP);
    let closed = by_motion(&at_rest(&pair.linearized().jacobian()), &pair);
    let ways = [
        ("closed form", closed, DIFFERENCES),
        ("first order", first_order_jacobian(&pair), DIFFERENCES),
    ];
    for (name, found, tolerance) in ways {
        let error: SMatrix<f64, 6, 14> = found - differences;
        let (row, column) = error.iamax_full();
        assert!(
            error.norm() <= tolerance * differences.norm(),
            "{name} at {moduli:?}, entry {row} {column}: {} instead of {}",
            found[(row, column)],
            differences[(row, column)],
        );
    }
}

#[test]
fn stacked_cubes_with_flush_sides_have_the_jacobian_of_differences() {
    let cube = cuboid([1.0; 3]);
    for moduli in [[1.0, 2.0], [2.0, 1.0], [1.0, 30.0]] {
        for offset in [vector![0.0, 0.0, 0.9], vector![0.7, 0.0, 0.0]] {
            assert_equal_differences(&cube, Pose::from_translation(offset), moduli);
        }
    }
}

#[test]
fn stacked_boxes_with_true_distances_have_the_jacobian_of_differences() {
    let block = Shape::new(shapes::distance_cuboid([1.0, 0.6, 0.4]).unwrap());
    for moduli in [[1.0, 2.0], [3.0, 1.0]] {
        let above = at(0.0, 0.0, 0.35);
        assert_equal_differences(&block, above, moduli);
    }
}

/// The cubes have edge 1, and the upper cube is pressed in by a depth, which presses the softer cube in by δ. The contact surface is flat
/// except for a rim of width δ, which leads up or down to the edges of the stiffer cube.
#[test]
fn flush_sides_belong_to_no_contact_surface() {
    let cube = cuboid([1.0; 3]);
    let depth = 0.1;
    let above = at(0.0, 0.0, 1.0 - depth);
    for [a, b] in [[1.0, 2.0], [2.0, 1.0], [1.0, 5.0]] {
        let pair = pair((&cube, above, a), (&cube, Pose::identity(), b));
        let (softer, stiffer) = (f64::min(a, b), f64::max(a, b));
        let delta = depth * stiffer / (softer + stiffer);
        let flat = (1.0 - 2.0 * delta).powi(2);
        // On the rim, the softer pressure grows inward at the same rate as the stiffer pressure grows toward the flat part.
        let expected = flat + (1.0 - flat) * (1.0 + (softer / stiffer).powi(2)).sqrt();
        let surface = pair.surface();
        let area = surface.area();
        assert!((area - expected).abs() <= EXACT, "{area} {expected}");
        let touching = pair.touching_tets();
        assert_eq!(touching.len(), surface.polygons.len());
    }
}

/// Opposite faces lie in one plane, so the bodies touch without pressure.
#[test]
fn cubes_that_only_touch_have_no_contact() {
    let cube = cuboid([1.0; 3]);
    for offset in [vector![0.0, 0.0, 1.0], vector![-1.0, 0.25, 0.0]] {
        for [a, b] in [[1.0, 2.0], [2.0, 1.0], [1.0, 1.0]] {
            let place = Pose::from_translation(offset);
            let pair = pair((&cube, place, a), (&cube, Pose::identity(), b));
            let contact = pair.linearized();
            assert!(pair.surface().is_empty() && pair.touching_tets().is_empty());
            assert!(contact.wrench.on_a.to_vector().amax() <= 0.0);
            assert!(contact.jacobian().amax() <= 0.0);
        }
    }
}

/// Returns two counts for a family: the pairs in contact and not at a kink, and those of them whose Jacobian through the clips differs from
/// the closed form.
fn two_ways(family: Family, numbers: std::ops::Range<u64>) -> [usize; 2] {
    let hostile = Hostile::new(1);
    let (mut pairs, mut differing) = (0, 0);
    for number in numbers {
        let pair = hostile.pair(family, number);
        let contact = pair.linearized();
        if kink_of(&pair).is_some() || contact.wrench.on_a.force == Vector3::zeros() {
            continue;
        }
        let through_clips = dual_wrench_jacobian(&pair).1;
        let [closed, through_clips] = [contact.jacobian(), through_clips]
            .map(|jacobian| by_motion(&at_rest(&jacobian), &pair));
        let scale = closed.amax().max(Measures::of(&pair).force());
        pairs += 1;
        // NaN counts as different.
        let is_same = (closed - through_clips).norm() <= SAME * scale;
        differing += usize::from(!is_same);
    }
    println!("{family:?}: {differing} of {pairs} pairs differ");
    [pairs, differing]
}

#[test]
fn both_jacobians_are_the_same_at_aligned_poses() {
    for (family, part) in [
        (Family::Coplanar, 0.0),
        (Family::Shared, MANY_SIDED),
        (Family::Nested, MANY_SIDED),
    ] {
        let [pairs, differing] = two_ways(family, 0..600);
        assert!(pairs > 200);
        assert!(differing as f64 <= part * pairs as f64, "{family:?}");
    }
}
