//! Does the Panda robot lift a carton, and how does the slip of the carton depend on the grip force?
//!
//! `cargo run --release -p hydroelastic-examples --example gripper [-- --record FILE.glb --plot FILE.svg]`
//!
//! The robot comes from a URDF file. It has an arm of seven joints and two coupled fingers with pads, and a column lifts it. Regularized
//! friction lets the carton creep. While the robot holds the carton, the friction law gives the creep speed and its derivative with respect to
//! the grip force.

mod show;

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, Integrator, Joint, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, JointQuantity, Outcome, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::io::urdf::{Base, MeshShape, Robot, RobotOptions, ShapeOptions};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use show::{Curve, Panel};
use std::error::Error;

type Answer<T> = Result<T, Box<dyn Error>>;

const ROBOT: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../tests/data/robots/panda.urdf"
);
/// Time step (s), number of steps before the slip is measured, and number of all steps.
const TIME_STEP: f64 = 5e-3;
const LIFT_STEPS: usize = 160;
const STEPS: usize = 240;
/// Angles (rad) of the seven joints of the arm. The hand points down.
const ARM: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
/// Half the width, height (m) and mass (kg) of the carton.
const CARTON: [f64; 3] = [0.035, 0.1, 0.3];
/// Grip force (N) of each finger.
const GRIP_FORCE: f64 = 20.0;
const FRICTION: f64 = 0.8;
/// Slip tolerance (m/s) of contacts.
const SLIP_TOLERANCE: f64 = 1e-3;
const GRAVITY: f64 = 9.81;
/// Height (m) of the lift.
const RISE: f64 = 0.1;
/// Relative tolerances of the creep speed and of its derivative.
const CREEP_ERROR: f64 = 0.01;
const SLOPE_ERROR: f64 = 0.02;

/// Distance (m) by which the carton slips down in the hand, from step `LIFT_STEPS` to the end.
struct Slip {
    carton: usize,
    hand: usize,
}

impl Outcome for Slip {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let height = |state: &State<T>| {
            let [carton, hand] =
                [self.carton, self.hand].map(|body| state.bodies[body].position().z);
            carton - hand
        };
        let states = trajectory.states();
        let last = states.len() - 1;
        vec![height(&states[last * LIFT_STEPS / STEPS]) - height(&states[last])]
    }
}

fn main() -> Answer<()> {
    let wanted = show::wanted()?;
    let world = world()?;
    let plan = Plan::new(TIME_STEP, STEPS)?.with_integrator(Integrator::Sdirk3);
    let trajectory = world.rollout(&plan.recording_every(4)).run()?;
    let carton = world.index_of("carton")?;
    let height = |state: &State| state.bodies[carton].position().z;
    let rise = height(trajectory.last()) - height(&trajectory.states()[0]);
    println!("The robot lifts the carton by {:.1} mm.", 1e3 * rise);
    assert!((rise - RISE).abs() < 1e-3);

    let slip = Slip {
        carton,
        hand: world.index_of("panda_hand")?,
    };
    let grip_force = [Parameter::joint(
        "panda_finger_joint1",
        JointQuantity::Torque,
    )];
    let experiment = Experiment::new(world.clone(), &plan.recording_every(LIFT_STEPS / 4));
    let (distance, gradient) = experiment.gradient(&grip_force, &slip)?;
    let hold_duration = TIME_STEP * (STEPS - LIFT_STEPS) as f64;
    let (creep_speed, creep_slope) = creep();
    let speed = distance / hold_duration;
    println!(
        "The carton creeps at {speed:.3e} m/s. The friction law predicts {creep_speed:.3e} m/s."
    );
    // The force of the leading joint is the negative sum of both grip forces.
    let slope = -2.0 * gradient[0] / hold_duration;
    println!(
        "Its derivative with respect to the grip force is {slope:.3e} m/(N s). The friction law predicts {creep_slope:.3e} m/(N s)."
    );
    assert!((speed / creep_speed - 1.0).abs() < CREEP_ERROR);
    assert!((slope / creep_slope - 1.0).abs() < SLOPE_ERROR);

    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory);
        Ok(recording.seen_from(vector![1.5, -1.2, 0.9], vector![0.3, 0.0, 0.4]))
    })?;
    wanted.plot(|| {
        let heights = trajectory
            .states()
            .iter()
            .map(|state| (state.time, height(state)));
        vec![Panel {
            x_label: "time (s)",
            y_label: "height (m)",
            is_log: false,
            curves: vec![Curve::new("carton", heights)],
        }]
    })
}

/// Speed (m/s) at which the carton creeps in the pads, and its derivative with respect to the grip force, by the friction law.
fn creep() -> (f64, f64) {
    let load = CARTON[2] * GRAVITY / (2.0 * FRICTION * GRIP_FORCE);
    let root = (1.0 - load * load).sqrt();
    let speed = SLIP_TOLERANCE * load / root;
    (speed, -SLIP_TOLERANCE * load / GRIP_FORCE / root.powi(3))
}

/// World with the robot on a column, and a carton on a table between the fingers.
fn world() -> Answer<World> {
    let robot = Robot::read(ROBOT)?;
    let rubber = Material::elastic(1e7)
        .with_dissipation(0.5)
        .with_friction(FRICTION);
    let column = Joint::prismatic("column", Vector3::z_axis())
        .with_servo(1e6, 1e4)
        .with_targets(
            0.1,
            vec![0.0, 0.0, 0.0, 0.2 * RISE, 0.5 * RISE, 0.8 * RISE, RISE],
        );
    let options = RobotOptions {
        base: Base::Joint(Box::new(column)),
        shapes: ShapeOptions {
            // The pads of the fingers are boxes, and all other geometries are meshes.
            meshes: MeshShape::None,
            ..ShapeOptions::default()
        },
        ..RobotOptions::new(rubber)
    };
    let mut mechanism = robot.mechanism(&options)?;
    for (number, angle) in (1..).zip(ARM) {
        mechanism = mechanism.with_joint(&format!("panda_joint{number}"), |joint| {
            joint
                .with_position(angle)
                .with_servo(1e5, 1e3)
                .with_target(angle, 0.0)
        })?;
    }
    let open = CARTON[0] + 2e-3;
    let mechanism = mechanism.with_joint("panda_finger_joint1", |joint| {
        joint.with_position(open).with_torque(-2.0 * GRIP_FORCE)
    })?;
    let robot_alone = World::builder().mechanism(mechanism.clone()).build()?;
    let state = robot_alone.initial_state();
    let hand = state.bodies[robot_alone.index_of("panda_hand_tcp")?].position();
    let [half_width, height, mass] = CARTON;
    let carton = shapes::cuboid([2.0 * half_width, 2.0 * half_width, height])?;
    let table = Pose::from_translation(hand - Vector3::z() * (height / 2.0));
    let carton = Body::dynamic("carton", Shape::new(carton), rubber, Mass::Total(mass))?
        .with_pose(Pose::from_translation(*hand));
    Ok(World::builder()
        .mechanism(mechanism)
        .body(Body::fixed("table", HalfSpace::rigid(), Material::rigid())?.with_pose(table))
        .body(carton)
        .gravity(vector![0.0, 0.0, -GRAVITY])
        .slip_tolerance(SLIP_TOLERANCE)
        .build()?)
}
