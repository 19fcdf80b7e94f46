use super::scenes::{IMPLICIT, rollout};
use crate::scenes::{SKIN, asymmetric, box_shape};
use hydroelastic::dynamics::{Body, Mass, World};
use nalgebra::vector;

/// Relative error after 10,000 steps of three stages. Each stage adds the rates of the previous stages, with about five rounding errors
/// each.
const MOMENTUM: f64 = 2e-11;

#[test]
fn a_free_body_keeps_its_momenta() {
    let body = Body::dynamic(
        "body",
        box_shape([0.2, 0.3, 0.4]),
        SKIN,
        Mass::Properties(asymmetric()),
    )
    .unwrap();
    let body = body
        .with_angular_velocity(vector![3.0, 7.0, -5.0])
        .with_velocity(vector![0.3, -0.2, 0.1]);
    let world = World::new(vec![body]).unwrap();
    for integrator in IMPLICIT {
        let mut rollout = rollout(&world, integrator, 5e-3);
        let before = world.diagnostics(rollout.state()).unwrap();
        for _ in 0..10_000 {
            rollout.advance().unwrap();
        }
        let after = world.diagnostics(rollout.state()).unwrap();
        let off = [
            (after.momentum.linear - before.momentum.linear).norm() / before.momentum.linear.norm(),
            (after.momentum.angular - before.momentum.angular).norm()
                / before.momentum.angular.norm(),
        ];
        println!(
            "{integrator:?}: momenta off by {off:?}, energy {:.1e}",
            after.kinetic_energy / before.kinetic_energy - 1.0
        );
        assert!(off.iter().all(|&off| off < MOMENTUM));
    }
}
