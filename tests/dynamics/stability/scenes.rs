//! Cubes on a slab, their largest stable time steps, and a bisection over the time step.

use crate::scenes::{GRAVITY, at, box_shape};
use crate::support::worlds::{dynamic, fixed};
use hydroelastic::dynamics::{Body, Material, World};
use nalgebra::vector;

/// Relative error of a limit from the search for the stiffest motion.
pub const FOUND: f64 = 1e-5;

pub const EDGE: f64 = 0.2;

pub fn cube(name: &str, edge: f64, skin: Material) -> Body {
    dynamic(name, box_shape([edge; 3]), skin, 1.0)
}

pub fn slab_skin(skin: Material) -> Material {
    Material {
        modulus: Some(3e6),
        ..skin
    }
}

/// Returns the slab of the closed forms, whose top is z = 0: modulus 3e6, half depth 0.5.
pub fn slab(skin: Material) -> Body {
    let slab = fixed("slab", box_shape([2.0, 2.0, 1.0]), slab_skin(skin));
    slab.with_pose(at(0.0, 0.0, -0.5))
}

/// Returns a cube of 1 kg, pressed into a slab by a depth (m).
pub fn cube_on_slab(skin: Material, depth: f64) -> World {
    let cube = cube("cube", EDGE, skin).with_pose(at(0.03, 0.05, EDGE / 2.0 - depth));
    with_gravity(World::new(vec![cube, slab(skin)]).unwrap())
}

pub fn with_gravity(world: World) -> World {
    world.with_gravity(vector![0.0, 0.0, -GRAVITY]).unwrap()
}

pub fn limit(world: &World) -> f64 {
    world
        .largest_stable_step(&world.initial_state())
        .unwrap()
        .unwrap()
}

pub fn assert_close(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual / expected - 1.0).abs();
    assert!(
        error <= tolerance,
        "{actual:e}, not {expected:e}: {error:e}"
    );
}

/// Depth (m) of a cube of 1 kg at rest.
pub const REST: f64 = 6.541_604_590_930e-5;

/// Returns the time step between two steps at which a predicate becomes true.
pub fn bisected(
    [mut low, mut high]: [f64; 2],
    resolution: f64,
    holds: impl Fn(f64) -> bool,
) -> f64 {
    assert!(!holds(low) && holds(high), "not between {low} and {high}");
    while high / low - 1.0 > resolution {
        let middle = (low * high).sqrt();
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    (low * high).sqrt()
}

/// Returns a cube that falls 5 mm on a slab, which it touches after 32 ms.
pub fn falling_cube() -> World {
    cube_on_slab(Material::elastic(1e6), -5e-3)
}
