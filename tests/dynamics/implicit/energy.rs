//! Elastic falls create no energy.

use super::scenes::{IMPLICIT, Numbers, ball, brick, energy, ground, on_slope, rollout, steps};
use crate::scenes::GRAVITY;
use hydroelastic::dynamics::{Material, Work};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

fn check_gain(seed: u64, count: usize) {
    let mut numbers = Numbers(seed);
    let mut worst = [f64::NEG_INFINITY; 2];
    let mut work = [Work::default(); 2];
    for attempt in 0..count {
        let skin = Material::elastic(10_f64.powf(numbers.between(5.0, 9.0)));
        let time_step = 10_f64.powf(numbers.between(-4.0, -2.0));
        let start = Pose::from_rotation_vector(&numbers.vector(3.0), vector![0.03, 0.02, 0.3]);
        let body = if attempt % 2 == 0 {
            ball(0.1, 1, skin)
        } else {
            brick("brick", [0.2, 0.14, 0.1], skin)
        };
        let velocity = numbers.vector(0.5) - vector![0.0, 0.0, 0.5];
        let body = body
            .with_pose(start)
            .with_velocity(velocity)
            .with_angular_velocity(numbers.vector(5.0));
        let stiffer = Material {
            modulus: skin.modulus.map(|modulus| 1.3 * modulus),
            ..skin
        };
        let world = on_slope(vec![body, ground([3.0, 3.0, 0.4], stiffer)], 0.0, 1e-3);
        for (index, integrator) in IMPLICIT.into_iter().enumerate() {
            let mut rollout = rollout(&world, integrator, time_step);
            let before = energy(&world, &rollout);
            let count = steps(0.6, time_step);
            for step in 0..count {
                rollout.advance().unwrap();
                work[index] += rollout.step_report().unwrap().work;
                if step % (count / 60).max(1) == 0 {
                    let gain = (energy(&world, &rollout) - before) / (GRAVITY * 0.3);
                    if gain > worst[index].max(1e-4) {
                        println!(
                            "{integrator:?} {attempt}: E {:.1e} h {time_step:.1e}: gain {gain:.1e}",
                            skin.modulus.unwrap()
                        );
                    }
                    worst[index] = worst[index].max(gain);
                }
            }
        }
    }
    println!("{count} falls: gain of mgh {worst:?} ({IMPLICIT:?}), {work:?}");
    assert!(worst[0] < GAIN && worst[1] < ROUND_OFF);
}

/// Energy gain of impacts, relative to m g h.
const GAIN: f64 = 1e-3;
const ROUND_OFF: f64 = 1e-12;

#[test]
fn elastic_falls_gain_next_to_no_energy() {
    check_gain(12345, 30);
}

#[test]
#[ignore = "minutes: 300 falls"]
fn many_elastic_falls_gain_next_to_no_energy() {
    check_gain(54321, 300);
}
