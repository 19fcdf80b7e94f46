//! A bounce against the trajectory of an independent program.

use crate::support::reference::{Row, Scene, scaled_shape, scenes};
use crate::support::worlds::{at, cuboid, falling, fixed};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use std::sync::Arc;

/// Tolerance. The reference was integrated to 1e-10, and another program reproduced it to 4e-9. The rest is the error of extrapolation in
/// the squared step.
const TRAJECTORY: f64 = 2e-8;

/// Number of steps per interval of the reference (10 ms), for the longer of the two time steps.
const STEPS: usize = 500;

fn vector_at(row: &Row, first: usize) -> Vector3<f64> {
    Vector3::new(row.x[first], row.x[first + 1], row.x[first + 2])
}

fn world(scene: &Scene) -> World {
    let start = &scene.rows[0];
    let [w, i, j, k] = [0, 1, 2, 3].map(|index| start.x[index]);
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    let rotation = turn.to_rotation_matrix().into_inner();
    let pose = Pose::new(rotation, vector_at(start, 4)).unwrap();
    let mass = Mass::Properties(MassProperties {
        mass: scene.mass,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::identity() * (scene.mass * scene.unit_inertia),
    });
    let ball = Arc::new(scaled_shape(&scene.mesh, scene.scale));
    let cube = Arc::new(cuboid([1.0; 3]));
    let ball = Body::dynamic("ball", ball, Material::elastic(scene.modulus_ball), mass).unwrap();
    let cube = fixed("cube", cube, Material::elastic(scene.modulus_box));
    falling(vec![
        ball.with_pose(pose)
            .with_angular_velocity(vector_at(start, 7))
            .with_velocity(vector_at(start, 10)),
        cube.with_pose(at(0.0, 0.0, -0.5)),
    ])
}

fn states(world: &World, steps: usize, count: usize) -> Vec<State> {
    let plan = Plan::new(0.01 / steps as f64, steps * (count - 1)).unwrap();
    let rollout = world.rollout(&plan.recording_every(steps));
    let recorded = rollout.run().unwrap();
    recorded.states().to_vec()
}

#[test]
fn a_spinning_ball_bounces_as_in_an_independent_program() {
    for scene in scenes() {
        let world = world(&scene);
        let count = scene.rows.len();
        let (coarse, fine) = (
            states(&world, STEPS, count),
            states(&world, 2 * STEPS, count),
        );
        for ((row, coarse), fine) in scene.rows.iter().zip(&coarse).zip(&fine) {
            assert!((fine.time - row.t).abs() < 1e-12);
            let (coarse, fine) = (&coarse.bodies[0], &fine.bodies[0]);
            // The error of leapfrog is proportional to the square of the step.
            let limit = |coarse: &Vector3<f64>, fine: &Vector3<f64>| fine + (fine - coarse) / 3.0;
            let position = limit(coarse.pose.translation(), fine.pose.translation());
            let velocity = limit(&coarse.twist.linear, &fine.twist.linear);
            let spin = limit(&coarse.twist.angular, &fine.twist.angular);
            let position_error = (position - vector_at(row, 4)).amax();
            assert!(
                position_error <= TRAJECTORY,
                "{}: {position_error:e}",
                row.t
            );
            // The error of a velocity is the acceleration times the error of the bounce's time.
            let error = (velocity - vector_at(row, 10)).amax();
            assert!(error <= 5.0 * TRAJECTORY, "{}: {error:e}", row.t);
            let error = (spin - vector_at(row, 7)).amax();
            assert!(error <= 5.0 * TRAJECTORY, "{}: {error:e}", row.t);
        }
    }
}
