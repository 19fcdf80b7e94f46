//! How deep must a quadruped crouch to jump 5 cm high?
//!
//! `cargo run --release -p hydroelastic-examples --example jump [-- --record FILE.glb --plot FILE.svg]`
//!
//! A trunk has four legs of three joints with soft feet. The targets of the servos follow from the crouch depth. Newton's method finds the
//! depth, with the derivative of the height through the motion. The derivatives of the height before and after the landing, in steps of
//! 5 ms, agree with central differences of the converged motion.

mod show;

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Accuracy, Body, BodyShape, Integrator, Joint, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, JointQuantity, Outcome, Parameter};
use hydroelastic::io::Recording;
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{DVector, Matrix3, Vector2, Vector3, vector};
use show::{Curve, Panel};
use std::error::Error;

type Answer<T> = Result<T, Box<dyn Error>>;

/// Time step (s), number of steps to a time in flight, and number of all steps.
const TIME_STEP: f64 = 5e-3;
const FLIGHT: usize = 84;
const STEPS: usize = 168;
/// Time (s) between targets, and crouch at each target relative to the crouch depth.
const INTERVAL: f64 = 0.1;
const CROUCH: [f64; 6] = [0.0, 0.5, 1.0, 1.0, 0.0, 0.0];
/// Length (m) of thighs and shanks, height (m) of the hips above the feet before the crouch, and radius (m) of the feet.
const SEGMENT: f64 = 0.2;
const HIPS: f64 = 0.32;
const FOOT: f64 = 0.02;
/// Positions (m) of the hips in the trunk.
const LEGS: [[f64; 2]; 4] = [[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]];
const FRICTION: f64 = 0.8;
const GRAVITY: f64 = 9.81;
/// Desired height (m) of the jump, and tolerance (m).
const JUMP: f64 = 0.05;
const ERROR: f64 = 1e-5;
/// Change (m) of the depth in differences, and relative error of derivatives.
const CHANGE: f64 = 1e-4;
const SLOPE_ERROR: f64 = 1e-3;

/// Height (m) of the trunk at the top of the jump, and at the end.
struct Heights {
    trunk: usize,
}

impl Outcome for Heights {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let flight = &trajectory.states()[1].bodies[self.trunk];
        let speed = flight.velocity().z;
        let top = flight.position().z + speed * speed / lift::<T>(2.0 * GRAVITY);
        vec![top, trajectory.last().bodies[self.trunk].position().z]
    }
}

fn main() -> Answer<()> {
    let wanted = show::wanted()?;
    let plan = Plan::new(TIME_STEP, STEPS)?
        .with_integrator(Integrator::Sdirk3)
        .recording_every(FLIGHT);
    let start = HIPS + FOOT;
    let mut depth = 0.09;
    let slopes = loop {
        let (heights, slopes) = derivative(depth, &plan)?;
        let height = heights[0] - start;
        println!("A crouch of {depth:.4} m gives a jump of {height:.6} m.");
        if (height - JUMP).abs() < ERROR {
            break slopes;
        }
        depth += (JUMP - height) / slopes[0];
        // The legs cannot bend further than this.
        assert!(depth < HIPS / 2.0);
    };

    let tight = plan.with_accuracy(Accuracy::new(1e-5, 3e-4)?);
    let motion = difference(depth, &tight, CHANGE)?;
    for (index, place) in ["at the top of the jump", "after the landing"]
        .into_iter()
        .enumerate()
    {
        let [slope, converged] = [slopes, motion].map(|pair| pair[index]);
        println!(
            "The derivative of the height {place} with respect to the depth is {slope:.5}. Differences of the converged motion: {converged:.5}."
        );
        assert!((slope / converged - 1.0).abs() < SLOPE_ERROR);
    }

    let world = world(depth)?;
    let trajectory = world.rollout(&plan.recording_every(1)).run()?;
    wanted.record(|| {
        let recording = Recording::new(&world, &trajectory);
        Ok(recording.seen_from(vector![1.0, -1.2, 0.5], vector![0.0, 0.0, 0.2]))
    })?;
    wanted.plot(|| {
        let height = |state: &State| (state.time, state.bodies[0].position().z);
        let heights = trajectory.states().iter().map(height);
        vec![Panel {
            x_label: "time (s)",
            y_label: "height (m)",
            is_log: false,
            curves: vec![Curve::new("trunk", heights)],
        }]
    })
}

/// Heights of a jump, and their derivatives with respect to the crouch depth.
fn derivative(depth: f64, plan: &Plan) -> Answer<(DVector<f64>, Vector2<f64>)> {
    let world = world(depth)?;
    let mut targets = Vec::new();
    let mut rates = Vec::new();
    for leg in 0..LEGS.len() {
        let moved = (0..).zip(CROUCH).filter(|(_, crouch)| *crouch > 0.0);
        for (index, crouch) in moved {
            let [_, rate] = bend(depth * crouch);
            let [thigh, shank] = leg_angles(leg, rate * crouch);
            for (part, rate) in [("thigh", thigh), ("shank", shank)] {
                let quantity = JointQuantity::ScheduledTarget(index);
                targets.push(Parameter::joint(format!("{part} {leg}"), quantity));
                rates.push(rate);
            }
        }
    }
    let heights = Heights {
        trunk: world.index_of("trunk")?,
    };
    let jump = Experiment::new(world, plan).jacobian(&targets, &heights)?;
    let slopes = jump.jacobian * DVector::from_vec(rates);
    Ok((jump.value, Vector2::new(slopes[0], slopes[1])))
}

/// Central difference of the heights over a change (m) of the depth.
fn difference(depth: f64, plan: &Plan, change: f64) -> Answer<Vector2<f64>> {
    let heights = |depth: f64| -> Answer<Vector2<f64>> {
        let world = world(depth)?;
        let heights = Heights {
            trunk: world.index_of("trunk")?,
        };
        let value = heights.of(&world.rollout(plan).run()?);
        Ok(Vector2::new(value[0], value[1]))
    };
    Ok((heights(depth + change)? - heights(depth - change)?) / (2.0 * change))
}

/// Angle (rad) of a thigh at a crouch (m), and its derivative with respect to the crouch.
fn bend(crouch: f64) -> [f64; 2] {
    let cosine = (HIPS - crouch) / (2.0 * SEGMENT);
    [
        cosine.acos(),
        (1.0 - cosine * cosine).sqrt().recip() / (2.0 * SEGMENT),
    ]
}

/// Angles of the thigh and the shank of a leg. The knees of front and hind legs bend towards each other, and the feet stay below the hips.
fn leg_angles(leg: usize, angle: f64) -> [f64; 2] {
    let thigh = -angle * LEGS[leg][0].signum();
    [thigh, -2.0 * thigh]
}

/// World of the quadruped on a floor.
fn world(depth: f64) -> Answer<World> {
    let trunk = MassProperties {
        mass: 9.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&vector![0.07, 0.2, 0.25]),
    };
    let height = Pose::from_translation(vector![0.0, 0.0, HIPS + FOOT]);
    let ground = Material::rigid().with_friction(FRICTION);
    let mut bodies = vec![
        link("trunk", trunk)?.with_pose(height),
        Body::fixed("floor", HalfSpace::rigid(), ground)?,
    ];
    for index in 0..LEGS.len() {
        bodies.extend(leg(index, depth)?);
    }
    Ok(World::new(bodies)?.with_gravity(vector![0.0, 0.0, -GRAVITY])?)
}

/// Links and foot of a leg, with the targets of a crouch depth (m).
fn leg(index: usize, depth: f64) -> Answer<Vec<Body>> {
    let [x, y] = LEGS[index];
    let [side, down] = [vector![0.0, 0.6 * y, 0.0], vector![0.0, 0.0, -SEGMENT]];
    let angles = CROUCH.map(|crouch| leg_angles(index, bend(depth * crouch)[0]));
    let [thigh, shank] = [0, 1].map(|part| angles.map(|angles| angles[part]));
    let (mut bodies, mut parent) = (Vec::new(), "trunk".to_owned());
    for (part, axis, origin, mass, end, targets) in [
        (
            "hip",
            Vector3::x_axis(),
            vector![x, y, 0.0],
            0.6,
            side,
            [0.0; 6],
        ),
        ("thigh", Vector3::y_axis(), side, 0.9, down, thigh),
        ("shank", Vector3::y_axis(), down, 0.2, down, shank),
    ] {
        let name = format!("{part} {index}");
        let joint = Joint::revolute(&name, axis)
            .with_parent(&parent)
            .with_origin(Pose::from_translation(origin))
            .with_armature(0.01)
            .with_position(targets[0])
            .with_servo(300.0, 8.0)
            .with_targets(INTERVAL, targets.to_vec());
        bodies.push(link(&name, rod(mass, end))?.with_joint(joint)?);
        parent = name;
    }
    let name = format!("foot {index}");
    let ankle = Joint::fixed(&name)
        .with_parent(&parent)
        .with_origin(Pose::from_translation(down));
    let rubber = Material::elastic(1e6)
        .with_dissipation(0.5)
        .with_friction(FRICTION);
    let foot = Shape::new(shapes::icosphere(FOOT, 2)?);
    bodies.push(Body::dynamic(&name, foot, rubber, Mass::Total(0.05))?.with_joint(ankle)?);
    Ok(bodies)
}

/// Body without a shape.
fn link(name: &str, properties: MassProperties) -> Answer<Body> {
    let mass = Mass::Properties(properties);
    Ok(Body::dynamic(
        name,
        BodyShape::None,
        Material::rigid(),
        mass,
    )?)
}

/// Mass properties of a rod of a mass (kg) from the origin to its end (m).
fn rod(mass: f64, end: Vector3<f64>) -> MassProperties {
    let across = Matrix3::identity() * end.norm_squared() - end * end.transpose();
    MassProperties {
        mass,
        center_of_mass: end / 2.0,
        inertia: (across / 12.0 + Matrix3::identity() * 1e-4) * mass,
    }
}
