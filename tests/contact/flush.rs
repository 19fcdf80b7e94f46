//! Bodies with flush faces, for example stacked blocks. The wrench is differentiable there, although every contact polygon is in a
//! degenerate position.

use crate::support::differences::{at_rest, by_motion, central_difference};
use crate::support::hostile::kinks::kink_of;
use crate::support::hostile::measures::Measures;
use crate::support::hostile::{Family, Hostile};
use crate::support::moving::{Scene, jacobian_of, seeds};
use crate::support::scenes::{Random, pair};
use crate::support::worlds::{at, cuboid};
use hydroelastic::contact::Shape;
use hydroelastic::gradient::dual_wrench_jacobian;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{SMatrix, Vector3, vector};

/// Error of differences. Second derivatives jump at flush poses, so the error of a difference is its step of 1e-7 times the jump.
const DIFFERENCES: f64 = 1e-5;

const STEP: f64 = 1e-7;

/// Largest fraction of pairs whose derivatives through the clips may differ. If a vertex lies in a face of the other body's tetrahedra,
/// several planes meet in one corner. The clips do not consider all sides of this corner.
const MANY_SIDED: f64 = 0.03;

/// Relative tolerance of derivatives, compared with pressure times size.
const SAME: f64 = 1e-6;

/// Rounding error of a sum of areas.
const EXACT: f64 = 1e-12;

fn assert_equal_differences(shape: &Shape, pose: Pose, moduli: [f64; 2]) {
    let pair = pair(
        (shape, pose, moduli[0]),
        (shape, Pose::identity(), moduli[1]),
    );
    let differences = central_difference(&pair, STEP);
    let closed = by_motion(&at_rest(&pair.linearized().jacobian()), &pair);
    let scene = Scene::at_random(&pair, &mut Random::new(1));
    let first_order = jacobian_of(&scene.changed(&seeds()).0.wrench());
    let first_order = by_motion(&at_rest(&first_order), &pair);
    for (name, found) in [("closed form", closed), ("first order", first_order)] {
        let error: SMatrix<f64, 6, 14> = found - differences;
        let (row, column) = error.iamax_full();
        assert!(
            error.norm() <= DIFFERENCES * differences.norm(),
            "{name} at {moduli:?}, entry {row} {column}: {} instead of {}",
            found[(row, column)],
            differences[(row, column)],
        );
    }
}

#[test]
fn stacked_boxes_with_flush_sides_have_the_jacobian_of_differences() {
    let cube = cuboid([1.0; 3]);
    let block = Shape::new(shapes::distance_cuboid([1.0, 0.6, 0.4]).unwrap());
    for (shape, place, moduli) in [
        (
            &cube,
            at(0.0, 0.0, 0.9),
            &[[1.0, 2.0], [2.0, 1.0], [1.0, 30.0]][..],
        ),
        (
            &cube,
            at(0.7, 0.0, 0.0),
            &[[1.0, 2.0], [2.0, 1.0], [1.0, 30.0]],
        ),
        (&block, at(0.0, 0.0, 0.35), &[[1.0, 2.0], [3.0, 1.0]]),
    ] {
        for moduli in moduli {
            assert_equal_differences(shape, place, *moduli);
        }
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
