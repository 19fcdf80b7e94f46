//! Does the Panda robot lift a mug, and how does the slip of the mug depend on the squeeze?
//!
//! `cargo run --release -p hydroelastic-examples --example gripper [-- --record FILE.glb --plot FILE.svg]`
//!
//! The robot is a URDF file with eleven links that move: a column, an arm of seven joints, and two coupled fingers with pads. In a steady
//! hold, the law of friction gives the speed at which the mug creeps, and the derivative of this speed with respect to the squeeze.

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
/// Time step (s), and number of steps until the slip is measured, and until the end.
const TIME_STEP: f64 = 5e-3;
const HELD: usize = 160;
const STEPS: usize = 240;
/// Angles (rad) of the seven joints of the arm. The hand points down.
const ARM: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];
/// Radius, height (m) and mass (kg) of the mug.
const MUG: [f64; 3] = [0.035, 0.1, 0.3];
/// Force (N) of each finger.
const SQUEEZE: f64 = 20.0;
const FRICTION: f64 = 0.8;
/// Slip tolerance (m/s) of contacts.
const SLIP_TOLERANCE: f64 = 1e-3;
const GRAVITY: f64 = 9.81;
/// Height (m) of the lift.
const RISE: f64 = 0.1;
/// Relative tolerances of the speed of creep and of its derivative.
const CREEP_ERROR: f64 = 0.01;
const SLOPE_ERROR: f64 = 0.02;

/// Height (m) of the mug relative to the hand, after the lift and at the end.
struct Slip {
    mug: usize,
    hand: usize,
}

impl Outcome for Slip {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let height = |state: &State<T>| {
            let [mug, hand] = [self.mug, self.hand].map(|body| state.bodies[body].position().z);
            mug - hand
        };
        let states = trajectory.states();
        let last = states.len() - 1;
        vec![height(&states[last * HELD / STEPS]) - height(&states[last])]
    }
}

fn main() -> Answer<()> {
    let wanted = show::wanted()?;
    let world = world()?;
    let plan = Plan::new(TIME_STEP, STEPS)?.with_integrator(Integrator::Sdirk3);
    let trajectory = world.rollout(&plan.clone().recording_every(4)).run()?;
    let mug = world.index_of("mug")?;
    let height = |state: &State| state.bodies[mug].position().z;
    let rise = height(trajectory.last()) - height(&trajectory.states()[0]);
    println!("The robot lifts the mug by {:.1} mm.", 1e3 * rise);
    assert!((rise - RISE).abs() < 1e-3);

    let slip = Slip {
        mug,
        hand: world.index_of("panda_hand")?,
    };
    let squeeze = [Parameter::joint(
        "panda_finger_joint1",
        JointQuantity::Torque,
    )];
    let experiment = Experiment::new(world.clone(), &plan.recording_every(HELD / 4));
    let (found, slope) = experiment.gradient(&squeeze, &slip)?;
    let held = TIME_STEP * (STEPS - HELD) as f64;
    let (speed, by_squeeze) = creep();
    println!(
        "While it holds the mug, it slips at {:.3e} m/s; the law of friction gives {speed:.3e} m/s.",
        found / held
    );
    // The force of the leader is shared by both fingers, and it is negative.
    let slope = -2.0 * slope[0] / held;
    println!(
        "Per newton of squeeze, the speed changes by {slope:.3e} m/s; the law gives {by_squeeze:.3e} m/s."
    );
    assert!((found / held / speed - 1.0).abs() < CREEP_ERROR);
    assert!((slope / by_squeeze - 1.0).abs() < SLOPE_ERROR);

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
            curves: vec![Curve::new("mug", heights)],
        }]
    })
}

/// Speed (m/s) at which the mug creeps in the pads, and its derivative with respect to the force of each finger.
fn creep() -> (f64, f64) {
    let load = MUG[2] * GRAVITY / (2.0 * FRICTION * SQUEEZE);
    let root = (1.0 - load * load).sqrt();
    let speed = SLIP_TOLERANCE * load / root;
    (speed, -SLIP_TOLERANCE * load / SQUEEZE / root.powi(3))
}

/// The robot on a column, and a mug on a table below its hand.
fn world() -> Answer<World> {
    let robot = Robot::read(ROBOT)?;
    let rubber = Material::elastic(1e6)
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
            // Only the fingers have shapes that are not meshes.
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
    let open = MUG[0] + 2e-3;
    let mechanism = mechanism.with_joint("panda_finger_joint1", |joint| {
        joint.with_position(open).with_torque(-2.0 * SQUEEZE)
    })?;
    let robot_alone = World::builder().mechanism(mechanism.clone()).build()?;
    let state = robot_alone.initial_state();
    let hand = state.bodies[robot_alone.index_of("panda_hand_tcp")?].position();
    let [radius, length, mass] = MUG;
    let mug = Shape::new(shapes::cylinder(radius, length, 32)?);
    let table = Pose::from_translation(hand - Vector3::z() * (length / 2.0));
    // A flat side faces each pad.
    let half_side = Vector3::z() * (std::f64::consts::PI / 32.0);
    let mug = Body::dynamic("mug", mug, rubber, Mass::Total(mass))?
        .with_pose(Pose::from_rotation_vector(&half_side, *hand));
    Ok(World::builder()
        .mechanism(mechanism)
        .body(Body::fixed("table", HalfSpace::rigid(), Material::rigid())?.with_pose(table))
        .body(mug)
        .gravity(vector![0.0, 0.0, -GRAVITY])
        .slip_tolerance(SLIP_TOLERANCE)
        .build()?)
}
