//! Bodies of 1 kg with stiff skins, and the work of their steps.

use crate::scenes::{GRAVITY, at, box_shape};
pub use crate::support::worlds::IMPLICIT;
use crate::support::worlds::{dynamic, fixed, icosphere, rubbing, sliding_at};
use hydroelastic::dynamics::{
    Accuracy, Body, BodyState, Integrator, KinematicPath, Material, Plan, Rollout, Work, World,
};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::PI;
use std::sync::Arc;

pub fn ball(radius: f64, order: usize, skin: Material) -> Body {
    let shape = icosphere(radius, order);
    dynamic("ball", shape, skin, 1.0)
}

pub fn brick(name: &str, edges: [f64; 3], skin: Material) -> Body {
    dynamic(name, box_shape(edges), skin, 1.0)
}

/// Returns a fixed box with its top at z = 0.
pub fn ground(edges: [f64; 3], skin: Material) -> Body {
    let ground = fixed("ground", box_shape(edges), skin);
    ground.with_pose(at(0.0, 0.0, -edges[2] / 2.0))
}

/// Returns a box on a path.
pub fn finger(name: &str, edges: [f64; 3], skin: Material, path: Arc<KinematicPath>) -> Body {
    Body::kinematic(name, box_shape(edges), skin, path).unwrap()
}

/// Returns a world with gravity down a slope of an angle (rad) along x.
pub fn on_slope(bodies: Vec<Body>, angle: f64, slip_tolerance: f64) -> World {
    let gravity = vector![angle.sin(), 0.0, -angle.cos()] * GRAVITY;
    World::new(bodies)
        .and_then(|world| world.with_gravity(gravity))
        .and_then(|world| world.with_slip_tolerance(slip_tolerance))
        .unwrap()
}

/// Returns the plan without error control. Steps are still divided if a body might pass through another. Finite differences then take the
/// same substeps as derivatives.
pub fn undivided(plan: Plan) -> Plan {
    plan.with_accuracy(Accuracy::new(1e9, 1e9).unwrap())
}

pub fn rollout(world: &World, integrator: Integrator, time_step: f64) -> Rollout {
    let plan = Plan::new(time_step, 0).unwrap();
    world.rollout(&plan.with_integrator(integrator))
}

/// Takes steps for a time (s) and counts their work.
pub fn run(rollout: &mut Rollout, time_step: f64, time: f64) -> Work {
    let mut work = Work::default();
    for _ in 0..steps(time, time_step) {
        rollout.advance().unwrap();
        work += rollout
            .step_report()
            .map(|report| report.work)
            .unwrap_or_default();
    }
    work
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number"
)]
pub fn steps(time: f64, time_step: f64) -> usize {
    (time / time_step).round() as usize
}

pub fn per_solve(work: &Work) -> f64 {
    work.evaluations as f64 / work.solves as f64
}

pub fn energy(world: &World, rollout: &Rollout) -> f64 {
    world.diagnostics(rollout.state()).unwrap().total_energy()
}

/// Pseudorandom numbers between 0 and 1 from a seed \[Marsaglia 2003\].
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// Returns one of the choices with equal probability.
    pub fn one_of<'c, C>(&mut self, choices: &'c [C]) -> &'c C {
        let part = self.next() * choices.len() as f64;
        let place = (1..choices.len())
            .filter(|&place| part >= place as f64)
            .count();
        &choices[place]
    }

    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-size, size))
    }
}

/// Returns a ball of radius 0.1 m on a table, squeezed by two boxes within 50 ms, and lifted by 0.1 m between 0.1 s and 0.6 s.
pub fn grasp(modulus: f64, slip_tolerance: f64) -> World {
    let skin = |modulus| rubbing(modulus, 0.5, 0.5);
    let edges = [0.1, 0.2, 0.2];
    let finger = |name, side| {
        finger(
            name,
            edges,
            skin(1.3 * modulus),
            Arc::new(move |time| gripping(side, time)),
        )
    };
    let turned = Pose::from_rotation_vector(&vector![0.3, 0.2, 0.1], vector![0.0, 0.0, 0.1]);
    let bodies = vec![
        ball(0.1, 2, skin(modulus)).with_pose(turned),
        finger("left", -1.0),
        finger("right", 1.0),
        ground([1.0, 1.0, 0.4], skin(1.3 * modulus)).with_pose(at(0.02, 0.01, -0.2)),
    ];
    on_slope(bodies, 0.0, slip_tolerance)
}

fn gripping(side: f64, time: f64) -> BodyState {
    let [closed, closing] = smooth(time / 0.05).map(|value| value * 0.0026);
    let [lifted, lifting] = smooth((time - 0.1) / 0.5).map(|value| value * 0.1);
    let place = vector![side * (0.1505 - closed), 0.003, 0.1 + lifted];
    BodyState {
        pose: Pose::from_translation(place),
        twist: sliding_at(vector![-side * closing / 0.05, 0.0, lifting / 0.5]),
    }
}

/// Returns value and velocity of a transition from 0 at 0 to 1 at 1, with zero velocity at both ends.
fn smooth(part: f64) -> [f64; 2] {
    if (0.0..1.0).contains(&part) {
        return [
            (1.0 - (PI * part).cos()) / 2.0,
            PI / 2.0 * (PI * part).sin(),
        ];
    }
    [f64::from(u8::from(part > 0.0)), 0.0]
}

/// Returns cubes of 0.1 m on top of each other, each slightly rotated, displaced and raised by 0.1 mm.
pub fn stack(count: usize, modulus: f64, slip_tolerance: f64) -> World {
    let skin = |modulus| rubbing(modulus, 0.5, 0.5);
    let cube = |place: usize| {
        let count = place as f64;
        let shift = vector![
            0.004 * (1.7 * count).sin(),
            0.003 * count.cos(),
            0.05 + 0.1001 * count
        ];
        let turned = Pose::from_rotation_vector(&(Vector3::z() * 0.2 * count), shift);
        brick(
            &place.to_string(),
            [0.1; 3],
            skin(modulus * (1.0 + 0.17 * count)),
        )
        .with_pose(turned)
    };
    let mut bodies: Vec<_> = (0..count).map(cube).collect();
    bodies.push(ground([1.0, 1.0, 0.4], skin(2.0 * modulus)).with_pose(at(0.011, 0.007, -0.2)));
    on_slope(bodies, 0.0, slip_tolerance)
}
