//! Derivatives in motion, with friction and dissipation.

use super::Shapes;
use crate::support::moving::{COLUMNS, Jacobian, Scene, numbers};
use crate::support::scenes::Random;
use hydroelastic::contact::ContactPair;
use hydroelastic::scalar::DenseDual;
use hydroelastic::spatial::Twist;
use nalgebra::SVector;

/// Round-off of derivatives through slices and clips of generic pairs, of the largest entry.
const TWO_WAYS: f64 = 1e-10;

/// Differences with the best of three steps: where a step straddles a polygon's change of topology,
/// or its wrench is rounded, another does not.
const DIFFERENCES: f64 = 1e-6;
const STEPS: [f64; 3] = [1e-5, 1e-6, 1e-7];

type Wide = DenseDual<COLUMNS>;

fn scene<'a>(pair: &ContactPair<'a>, random: &mut Random) -> Scene<'a> {
    let mut number = || random.between(-0.5, 0.5);
    let twists = [0, 1].map(|_| Twist::from_vector(&SVector::from_fn(|_, _| number())));
    Scene {
        twists,
        dissipation: random.between(0.0, 0.8),
        friction: random.between(0.0, 1.0),
        slip_tolerance: 0.05,
        missed: f64::INFINITY,
        pair: *pair,
    }
}

#[test]
fn the_linearised_contact_is_that_of_the_generic_pipeline() {
    let shapes = Shapes::mixed();
    let mut worst = 0.0_f64;
    shapes.for_pairs(200, 51, |pair, random| {
        let scene = scene(pair, random);
        let seeds = SVector::<Wide, COLUMNS>::from_fn(|i, _| Wide::variable(0.0, i));
        let (moved, law, twists) = scene.changed(&seeds);
        let through_clips = numbers(&moved.pipeline().wrench_in_motion(&law, twists));
        let expected = Jacobian::from_fn(|i, j| through_clips[i].eps[j]);
        let found = scene.linearised();
        worst = worst.max((found - expected).amax() / expected.amax());
        let carried = numbers(&moved.wrench_in_motion(&law, twists));
        let carried = Jacobian::from_fn(|i, j| carried[i].eps[j]);
        worst = worst.max((carried - expected).amax() / expected.amax());
    });
    println!("worst: {worst:.1e}");
    assert!(worst <= TWO_WAYS, "{worst:e}");
}

#[test]
fn the_linearised_contact_is_what_differences_say() {
    let shapes = Shapes::mixed();
    let mut worst = 0.0_f64;
    shapes.for_pairs(200, 52, |pair, random| {
        let scene = scene(pair, random);
        let direction = SVector::<f64, COLUMNS>::from_fn(|_, _| random.between(-1.0, 1.0));
        let expected = scene.linearised() * direction;
        let error = |step: f64| {
            let ahead = scene.wrenches(&(direction * step));
            let difference = (ahead - scene.wrenches(&(direction * -step))) / (2.0 * step);
            (difference - expected).amax() / expected.amax()
        };
        let errors = STEPS.map(error);
        worst = worst.max(errors.into_iter().fold(f64::INFINITY, f64::min));
        assert!(worst <= DIFFERENCES, "{worst:e}");
    });
    println!("worst: {worst:.1e}");
}
