//! Rebounds of bodies whose whole face hits a half-space at once, in steps much longer than the impact.

use super::scenes::brick;
use crate::scenes::at;
use crate::support::impacts::rebound;
use crate::support::worlds::{fixed, plan_of};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Integrator, Material, World};
use nalgebra::vector;

/// Largest error of a rebound speed, relative to the speed before the impact.
const OFF: f64 = 0.02;

/// Largest relative gain of speed in an elastic rebound.
const GAIN: f64 = 0.002;

#[test]
fn flat_faces_rebound_by_the_law() {
    let (mut worst, mut gain) = (0.0_f64, 0.0_f64);
    for edges in [[0.1, 0.1, 0.01], [0.016; 3], [0.2, 0.2, 0.1]] {
        for (modulus, dissipation) in [(1e8, 0.0), (1e8, 1.0), (1e9, 0.0), (1e9, 3.0), (1e10, 0.0)]
        {
            for (phase, time_step) in (0..8).map(|phase| (phase, [5e-3, 1e-2][phase % 2])) {
                let speed = 0.6 + 0.1 * phase as f64;
                let skin = Material::elastic(modulus).with_dissipation(dissipation);
                let distance = speed * time_step * (1.0 + phase as f64 / 8.0);
                let body =
                    brick("body", edges, skin).with_pose(at(0.0, 0.0, edges[2] / 2.0 + distance));
                let body = body.with_velocity(vector![0.0, 0.0, -speed]);
                let floor = fixed("floor", HalfSpace::rigid(), Material::rigid());
                let world = World::new(vec![body, floor]).unwrap();
                let plan = plan_of(Integrator::Sdirk3, time_step, 5);
                let end = world.rollout(&plan).run().unwrap();
                let ratio = end.last().bodies[0].velocity().z / speed;
                let off = ratio - rebound(speed, dissipation) / speed;
                worst = worst.max(off.abs());
                gain = gain.max(if dissipation == 0.0 { off } else { 0.0 });
                assert!(
                    off.abs() < OFF,
                    "{edges:?} {modulus:e} {dissipation} {phase}: {ratio}, off by {off}"
                );
            }
        }
    }
    println!("flat rebounds: off by {worst:.1e} at most, gain {gain:.1e}");
    assert!(gain < GAIN);
}
