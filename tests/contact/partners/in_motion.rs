//! Derivatives of moving bodies, with friction and dissipation.

use super::Shapes;
use crate::support::moving::{COLUMNS, Scene, jacobian_of, seeds};
use nalgebra::SVector;

/// Rounding error of derivatives through slices and clips of generic pairs, relative to the largest entry.
const TWO_WAYS: f64 = 1e-10;

/// Error of differences with the best of three steps.
const DIFFERENCES: f64 = 1e-6;
const STEPS: [f64; 3] = [1e-5, 1e-6, 1e-7];

#[test]
fn the_linearized_contact_is_that_of_the_generic_pipeline() {
    let shapes = Shapes::mixed();
    let mut worst = 0.0_f64;
    shapes.for_pairs(200, 51, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let (moved, law, twists) = scene.changed(&seeds());
        let expected = jacobian_of(&moved.moving(law, twists).pipeline().wrench());
        let carried = jacobian_of(&moved.moving(law, twists).wrench());
        for actual in [scene.linearized(), carried] {
            worst = worst.max((actual - expected).amax() / expected.amax());
        }
    });
    println!("worst: {worst:.1e}");
    assert!(worst <= TWO_WAYS, "{worst:e}");
}

#[test]
fn the_linearized_contact_is_what_differences_say() {
    let shapes = Shapes::mixed();
    let mut worst = 0.0_f64;
    shapes.for_pairs(200, 52, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let direction = SVector::<f64, COLUMNS>::from_fn(|_, _| random.between(-1.0, 1.0));
        worst = worst.max(scene.error_along(&direction, &scene.linearized(), &STEPS));
        assert!(worst <= DIFFERENCES, "{worst:e}");
    });
    println!("worst: {worst:.1e}");
}
