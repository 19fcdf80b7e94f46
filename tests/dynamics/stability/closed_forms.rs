//! The largest stable time step against closed forms.

use super::scenes::{EDGE, FOUND, REST, assert_close, cube, cube_on_slab, limit, slab, slab_skin};
use crate::scenes::{GRAVITY, at, box_shape};
use crate::support::balls::fine_ball;
use crate::support::worlds::dynamic;
use hydroelastic::dynamics::{Body, Mass, Material, World};
use nalgebra::DMatrix;
use std::sync::Arc;

/// κ(a − 2δ)² for a cube of edge a pressed in by x = 0.01 m, as in the closed forms of the wrench.
const STIFFNESS_AT_A_CENTIMETRE: f64 = 138_960.937_5;

#[test]
fn a_flat_cube_on_a_flat_slab_has_the_limit_of_its_heave() {
    let skin = Material::elastic(1e6);
    let world = cube_on_slab(skin, 0.01);
    assert_close(limit(&world), 2.0 / STIFFNESS_AT_A_CENTIMETRE.sqrt(), FOUND);
    // ω = 387.203326 rad/s.
    assert_close(limit(&cube_on_slab(skin, REST)), 2.0 / 387.203_326, FOUND);
}

#[test]
fn two_free_bodies_of_equal_mass_have_half_the_effective_mass() {
    let skin = Material::elastic(1e6);
    let free = Body::dynamic(
        "slab",
        box_shape([2.0, 2.0, 1.0]),
        slab_skin(skin),
        Mass::Total(1.0),
    );
    let bodies = vec![
        cube("cube", EDGE, skin).with_pose(at(0.0, 0.0, EDGE / 2.0 - 0.01)),
        free.unwrap().with_pose(at(0.0, 0.0, -0.5)),
    ];
    let world = World::new(bodies).unwrap();
    assert_close(
        limit(&world),
        2.0 / (2.0 * STIFFNESS_AT_A_CENTIMETRE).sqrt(),
        FOUND,
    );
}

/// Relative tolerance, because the cube's sides also have contact at the rim, on a bevel as wide as the depth, 7e-4 of the cube's edge.
const BEVEL: f64 = 1e-3;

#[test]
fn dissipation_enters_with_the_force_and_beside_the_stiffness() {
    for dissipation in [0.01_f64, 1.0, 100.0] {
        let skin = Material::elastic(1e6).with_dissipation(dissipation);
        let (k, c) = (387.203_326_f64.powi(2), dissipation * GRAVITY);
        let expected = 4.0 / (c + (c * c + 4.0 * k).sqrt());
        assert_close(limit(&cube_on_slab(skin, REST)), expected, BEVEL);
    }
}

/// Relative error of the estimate, which evaluates the pressure of a ball and its moments at one point. The error is the depth over the
/// radius, a few percent.
const BY_HAND: f64 = 3e-2;

#[test]
fn friction_of_a_ball_at_rest_enters_with_its_force_over_the_slip_tolerance() {
    let skin = Material::elastic(1e6).with_friction(0.5);
    let ball = Arc::new(fine_ball(0.1, 24, 12));
    let ball = dynamic("ball", ball, skin, 1.0);
    let bodies = vec![ball.with_pose(at(0.0, 0.0, 0.098)), slab(skin)];
    for slip_tolerance in [1e-4, 1e-3] {
        let world = World::new(bodies.clone()).unwrap();
        let world = world.with_slip_tolerance(slip_tolerance).unwrap();
        let state = world.initial_state();
        let pair = world.contact_between(&state, "ball", "slab").unwrap();
        // The compliance of a ball's surface includes its rotation: 1/m + r²/(0.4 m r²).
        let rate = 0.5 * pair.wrench().on_a.force.z / slip_tolerance * 3.5;
        assert_close(limit(&world), 2.0 / rate, BY_HAND);
    }
}

/// Returns blocks of decreasing width on a slab, each at rest under the blocks above.
fn stack(count: usize) -> World {
    let skin = Material::elastic(1e6);
    let (mut top, mut bodies) = (0.0, vec![slab(skin)]);
    for index in 0..count {
        let edge = EDGE - 0.02 * index as f64;
        let name = format!("block {index}");
        // With equal moduli, each body is pressed in by half the overlap.
        top += edge - 1e-4;
        bodies.push(cube(&name, edge, skin).with_pose(at(0.03, 0.05, top - edge / 2.0)));
    }
    World::new(bodies).unwrap()
}

/// Returns the limit of a chain of unit masses on springs, the first of which is fixed to the ground.
fn limit_of_chain(springs: &[f64]) -> f64 {
    let mut stiffness = DMatrix::<f64>::zeros(springs.len(), springs.len());
    for (index, &spring) in springs.iter().enumerate() {
        stiffness[(index, index)] += spring;
        if index > 0 {
            stiffness[(index - 1, index - 1)] += spring;
            stiffness[(index - 1, index)] -= spring;
            stiffness[(index, index - 1)] -= spring;
        }
    }
    2.0 / stiffness.symmetric_eigenvalues().max().sqrt()
}

#[test]
fn a_stack_has_the_limit_of_a_chain_of_springs() {
    let mut before = f64::INFINITY;
    for count in 1..=6 {
        let world = stack(count);
        let state = world.initial_state();
        let spring = |index: usize| {
            let below = match index {
                0 => "slab".to_owned(),
                _ => format!("block {}", index - 1),
            };
            let pair = world.contact_between(&state, &format!("block {index}"), &below);
            -pair.unwrap().linearized().by_poses[(5, 5)]
        };
        let springs: Vec<f64> = (0..count).map(spring).collect();
        assert_close(limit(&world), limit_of_chain(&springs), FOUND);
        assert!(limit(&world) < before, "{count}");
        before = limit(&world);
    }
}
