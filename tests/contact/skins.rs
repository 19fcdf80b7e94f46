//! Bodies with a skin around a plateau, pressed together by less and by more than the depth of their skins.

use crate::support::scenes::pair;
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Rounding error of some hundred polygons.
const SAME: f64 = 1e-11;

/// Width of the block and depth of all skins (m).
const WIDTH: f64 = 0.2;
const DEPTH: f64 = 0.004;
const HEIGHTS: [f64; 2] = [0.1, 0.4];

pub(super) fn with_skin(field: &PressureField, depth: f64) -> Shape {
    Shape::new(PressureField::from_distance_up_to(field.mesh(), depth).unwrap())
}

/// Returns the force (N) between a block and a wide floor that overlap by δ, of moduli E_A and E_B.
///
/// With κ = E/depth, the fields balance at p = κ_A·min(s, h). Here s is the distance to the nearest side of the block, and h is the block's
/// part of the overlap. h is κ_B·δ/(κ_A + κ_B) until one of the skins is fully compressed: the block's (h = depth) or the floor's (κ_A·h =
/// E_B). The integral over the square is κ_A times the volume of a frustum with sides at 45°.
fn closed_form(overlap: f64, [modulus_a, modulus_b]: [f64; 2]) -> f64 {
    let share = overlap * modulus_b / (modulus_a + modulus_b);
    let height = share.min(DEPTH).min(DEPTH * modulus_b / modulus_a);
    modulus_a / DEPTH * (WIDTH.powi(3) - (WIDTH - 2.0 * height).powi(3)) / 6.0
}

fn block_on_floor(shapes: &[Shape; 2], overlap: f64, moduli: [f64; 2]) -> ContactPair<'_> {
    let above = vector![0.01, -0.02, f64::midpoint(HEIGHTS[0], HEIGHTS[1]) - overlap];
    let turned = Pose::from_rotation_vector(&vector![0.0, 0.0, 0.3], above);
    let [block, floor] = shapes;
    pair(
        (block, turned, moduli[0]),
        (floor, Pose::identity(), moduli[1]),
    )
}

#[test]
fn a_block_is_pressed_by_the_closed_form_within_its_skin_at_its_end_and_beyond() {
    let boxes = [[WIDTH, WIDTH, HEIGHTS[0]], [1.0, 1.0, HEIGHTS[1]]];
    let shapes = boxes.map(|edges| with_skin(&shapes::distance_cuboid(edges).unwrap(), DEPTH));
    for moduli in [[1e5_f64, 1e5], [1e5, 3e5], [3e5, 1e5]] {
        let [soft, hard] = [moduli[0].min(moduli[1]), moduli[0].max(moduli[1])];
        // Overlap at which the skin of the softer body is fully compressed.
        let end = DEPTH * (1.0 + soft / hard);
        for share in [0.1, 0.5, 0.9, 1.0 - 1e-6, 1.0, 1.0 + 1e-6, 1.1, 2.0, 3.0] {
            let pair = block_on_floor(&shapes, end * share, moduli);
            let expected = closed_form(end * share, moduli);
            let found = pair.wrench().on_a.force;
            let error = (found - vector![0.0, 0.0, expected]).amax() / expected;
            assert!(error <= SAME, "{moduli:?} at {share}: {found:?} {expected}");
            assert_pressures(&pair, soft);
        }
    }
}

/// Checks that no pressure is below 0 or above the softer body's modulus (Pa), which is the pressure of its plateau.
fn assert_pressures(pair: &ContactPair, highest: f64) {
    for polygon in pair.surface().polygons {
        for corner in polygon.outline.corners() {
            let pressure =
                polygon.pressure + polygon.pressure_gradient.dot(&(corner - polygon.centroid));
            assert!(pressure >= -SAME * highest && pressure <= (1.0 + 1e-9) * highest);
        }
    }
}

#[test]
fn skins_are_followed_and_where_equal_plateaus_overlap_culled_as_well() {
    let ball = with_skin(&shapes::icosphere(1.0, 3).unwrap(), 0.1);
    let looked_at = |overlap: f64, modulus: f64| {
        let above = Pose::from_translation(Vector3::new(0.01, 0.02, 2.0 - overlap));
        let pair = pair((&ball, above, modulus), (&ball, Pose::identity(), 1.0));
        let culled = pair.with_search(Search::Culling(Culling::default()));
        let counts = [&pair, &culled].map(ContactPair::work_count);
        assert_eq!(counts[0].polygons, counts[1].polygons);
        counts.map(|count| count.candidate_pairs)
    };
    // Overlaps within the skins, and beyond the skins with a higher pressure on one plateau.
    for (overlap, modulus) in [(0.1, 1.0), (0.1, 2.0), (0.4, 2.0)] {
        let [followed, culled] = looked_at(overlap, modulus);
        assert!(followed < culled, "{overlap}: {followed} of {culled}");
    }
    let [followed, culled] = looked_at(0.4, 1.0);
    assert!(followed >= culled, "{followed} of {culled}");
}
