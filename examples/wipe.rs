//! Does an arm of seven joints wipe a table with a force of 5 N?
//!
//! `cargo run --release -p hydroelastic-examples --example wipe [-- --record FILE.glb --plot FILE.svg]`
//!
//! Inverse kinematics gives the initial targets of the servos. The weight of the arm and friction deflect the servos, so the force is
//! wrong. Gauss–Newton corrects the targets of all joints with exact derivatives of the force, until the force is 5 N along the path.

mod show;

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, Integrator, Joint, JointState, Mass, Material, Mechanism, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, JointQuantity, Outcome, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::io::urdf::{MeshShape, Robot, RobotOptions, ShapeOptions};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Pose;
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3, Vector6, vector};
use show::{Curve, Panel};
use std::error::Error;

type Answer<T> = Result<T, Box<dyn Error>>;

const ROBOT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/data/robots/panda.urdf"
);
/// Angles (rad) of the joints at the middle of the path. The hand points down.
const ARM: [f64; 7] = [0.0, -0.3, 0.0, -2.2, 0.0, 1.9, 0.785];
/// Time step (s), steps between two targets, and number of targets.
const TIME_STEP: f64 = 5e-3;
const INTERVAL: usize = 10;
const TARGETS: usize = 11;
/// Length (m) of the path, and penetration depth (m) of the sponge along the initial path.
const LENGTH: f64 = 0.2;
const DEPTH: f64 = 4e-3;
/// Radius (m) of the sponge.
const SPONGE: f64 = 0.04;
/// Stiffness (N m/rad) and damping (N m s/rad) of the servos.
const SERVO: [f64; 2] = [4e3, 100.0];
/// Desired force (N), and tolerance (N).
const FORCE: f64 = 5.0;
const ERROR: f64 = 0.05;

/// Force (N) of the sponge on the table at the times of all targets except the first two.
struct PressingForce {
    world: World,
}

impl PressingForce {
    fn at<T: Scalar>(&self, state: &State<T>) -> T {
        let world = self.world.lifted();
        let contact = world.contact_between(state, "sponge", "table");
        // The sponge is body A, because it is compliant with a mesh.
        contact.map_or_else(|_| lift(f64::NAN), |pair| pair.wrench().on_a.force.z)
    }
}

impl Outcome for PressingForce {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let states = trajectory.states().iter().skip(2);
        states.map(|state| self.at(state)).collect()
    }
}

fn main() -> Answer<()> {
    let wanted = show::wanted()?;
    let (arm, table) = scene()?;
    let targets = path(&arm, table)?;
    let mut world = wiping(&arm, table, &targets)?;
    let parameters: Vec<Parameter> = (1..=7)
        .flat_map(|joint| {
            let target = move |index| {
                let quantity = JointQuantity::ScheduledTarget(index);
                Parameter::joint(format!("panda_joint{joint}"), quantity)
            };
            (0..TARGETS).map(target)
        })
        .collect();
    let steps = INTERVAL * (TARGETS - 1);
    let plan = Plan::new(TIME_STEP, steps)?.with_integrator(Integrator::Sdirk3);
    let mut errors = Vec::new();
    loop {
        let pressing = PressingForce {
            world: world.clone(),
        };
        let experiment = Experiment::new(world.clone(), &plan.recording_every(INTERVAL));
        let forces = experiment.jacobian(&parameters, &pressing)?;
        let force_errors = forces.value.map(|force| force - FORCE);
        errors.push(force_errors.amax());
        println!(
            "The force differs from {FORCE} N by at most {:.3} N.",
            force_errors.amax()
        );
        if force_errors.amax() < ERROR || errors.len() > 9 {
            break;
        }
        let change = smallest_change(&forces.jacobian, &force_errors)?;
        world = world.perturbed(&parameters, change.as_slice())?;
    }
    assert!(errors[0] > 20.0 * ERROR);
    assert!(errors[errors.len() - 1] < ERROR);

    let trajectory = world.rollout(&plan).run()?;
    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory);
        Ok(recording.seen_from(vector![1.5, -1.2, 0.9], vector![0.3, 0.0, 0.3]))
    })?;
    wanted.plot(|| {
        let pressing = PressingForce {
            world: world.clone(),
        };
        let forces = trajectory.states().iter();
        let forces = forces.map(|state| (state.time, pressing.at(state)));
        let largest = Curve::counted("largest error (N)", errors.iter().copied());
        vec![
            Panel {
                x_label: "time (s)",
                y_label: "force (N)",
                is_log: false,
                curves: vec![Curve::new("sponge", forces)],
            },
            Panel::counted("iteration", vec![largest]),
        ]
    })
}

/// Smallest change of the targets that removes the force errors to first order.
fn smallest_change(jacobian: &DMatrix<f64>, force_errors: &DVector<f64>) -> Answer<DVector<f64>> {
    let solution = jacobian.clone().svd(true, true).solve(force_errors, 1e-6)?;
    Ok(-solution)
}

/// Robot with a sponge in its hand, and the height (m) of the table.
fn scene() -> Answer<(Mechanism, f64)> {
    let foam = Material::elastic(2e5)
        .with_dissipation(0.5)
        .with_friction(0.3);
    let options = RobotOptions {
        shapes: ShapeOptions {
            meshes: MeshShape::None,
            ..ShapeOptions::default()
        },
        ..RobotOptions::new(foam)
    };
    let mut arm = Robot::read(ROBOT)?.mechanism(&options)?;
    for (number, angle) in (1..).zip(ARM) {
        arm = arm.with_joint(&format!("panda_joint{number}"), |joint| {
            joint.with_position(angle)
        })?;
    }
    arm = arm.with_joint("panda_finger_joint1", |joint| joint.with_servo(1e4, 1e2))?;
    let sponge = Shape::new(shapes::icosphere(SPONGE, 2)?);
    let sponge = Body::dynamic("sponge", sponge, foam, Mass::Total(0.02))?
        .with_joint(Joint::fixed("grip").with_parent("panda_hand_tcp"))?;
    let arm = arm.with_body(sponge);
    let world = World::builder().mechanism(arm.clone()).build()?;
    let height = sponge_in(&world, &world.initial_state())?.z - SPONGE + DEPTH;
    Ok((arm, height))
}

fn sponge_in(world: &World, state: &State) -> Answer<Vector3<f64>> {
    Ok(*state.bodies[world.index_of("sponge")?].position())
}

/// Joint angles (rad) at each target, by inverse kinematics. The sponge moves along y, and the hand keeps its orientation.
fn path(arm: &Mechanism, table: f64) -> Answer<Vec<[f64; 7]>> {
    let world = World::builder().mechanism(arm.clone()).build()?;
    let middle = world.initial_state();
    let sponge = world.index_of("sponge")?;
    let (mut state, orientation) = (middle.clone(), middle.bodies[sponge].pose);
    let mut targets = Vec::new();
    for index in 0..TARGETS {
        let y = LENGTH * (index as f64 / (TARGETS - 1) as f64 - 0.5);
        let mut goal = sponge_in(&world, &middle)?;
        (goal.y, goal.z) = (y, table + SPONGE - DEPTH);
        for _ in 0..20 {
            let posed = world.clone().with_initial_state(&state)?.initial_state();
            let pose = posed.bodies[sponge].pose;
            let turn = orientation.rotation() * pose.rotation().transpose();
            let turn = UnitQuaternion::from_matrix(&turn).scaled_axis();
            let shift = goal - pose.translation();
            let error = Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z);
            let jacobian = world
                .kinetics(&posed)?
                .jacobian(sponge, &Vector3::zeros())?;
            let arm_columns = jacobian.columns(0, 7).into_owned();
            let change = arm_columns.svd(true, true).solve(&error, 1e-9)?;
            for (joint, change) in state.joints.iter_mut().zip(change.iter()) {
                if let JointState::Scalar { position, .. } = joint {
                    *position += change;
                }
            }
        }
        let angles = state.joints.iter().filter_map(JointState::position);
        targets.push(std::array::from_fn(|joint| {
            angles.clone().nth(joint).unwrap_or_default()
        }));
    }
    Ok(targets)
}

/// World of the table and the arm, which follows the targets.
fn wiping(arm: &Mechanism, table: f64, targets: &[[f64; 7]]) -> Answer<World> {
    let mut arm = arm.clone();
    let [stiffness, damping] = SERVO;
    for joint in 0..7 {
        let values: Vec<f64> = targets.iter().map(|angles| angles[joint]).collect();
        arm = arm.with_joint(&format!("panda_joint{}", joint + 1), |servo| {
            servo
                .with_position(values[0])
                .with_servo(stiffness, damping)
                .with_targets(INTERVAL as f64 * TIME_STEP, values)
        })?;
    }
    let surface = Body::fixed("table", HalfSpace::rigid(), Material::rigid())?
        .with_pose(Pose::from_translation(vector![0.0, 0.0, table]));
    Ok(World::builder()
        .mechanism(arm)
        .body(surface)
        .gravity(vector![0.0, 0.0, -9.81])
        .build()?)
}
