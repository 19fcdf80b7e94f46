//! This library's side of `accuracy.py`: answers questions on stdin, one JSON line each.
//!
//! Helps to choose a program, a step and an integrator for a given error. The script runs this program with `--serve`. Without `--serve`,
//! the program prints a hint and exits.
//!
//! A question is a scene, a time step, the number of steps, the name of an integrator, and the parameters of a Jacobian, if any. The answer
//! is the processor time of the rollout or of the Jacobian, and the final positions of the bodies.

use cpu_time::ProcessTime;
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Accuracy, Body, BodyState, Integrator, KinematicPath, Mass, Material, Plan, Trajectory, World,
};
use hydroelastic::gradient::{Experiment, Outcome, Parameter};
use hydroelastic::io::{MeshOptions, read_mesh};
use hydroelastic::mesh::PressureField;
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::io::{BufRead, Write, stdin, stdout};
use std::sync::Arc;

type Answer<T> = Result<T, Box<dyn Error>>;

#[derive(Deserialize)]
struct Question {
    scene: Scene,
    method: String,
    time_step: f64,
    steps: usize,
    /// Tolerances of values and slopes, and the resting speed (m/s) if it is not the default.
    accuracy: Option<(f64, f64, Option<f64>)>,
    parameters: Vec<ScalarParameter>,
}

/// A scalar property of a body.
#[derive(Deserialize)]
struct ScalarParameter {
    kind: String,
    /// Axis, if the property is a vector.
    axis: Option<usize>,
    /// Index of the body.
    body: usize,
}

/// Bodies with a common dissipation and slip tolerance; their moduli and friction differ.
#[derive(Deserialize)]
struct Scene {
    bodies: Vec<SceneBody>,
    dissipation: f64,
    slip_tolerance: f64,
    gravity: f64,
}

/// A body with a mass falls, a body with moves follows a path, and any other body is fixed.
#[derive(Deserialize)]
struct SceneBody {
    name: String,
    /// Mesh file; without a mesh, the body is a rigid half-space.
    mesh: Option<String>,
    modulus: f64,
    friction: f64,
    /// Nine entries of the rotation, row by row, and three of the translation (m).
    pose: [f64; 12],
    velocity: [f64; 3],
    mass: Option<f64>,
    moves: Option<Vec<Move>>,
}

/// A smooth displacement (m) within an interval of time (s).
#[derive(Deserialize, Clone, Copy)]
struct Move {
    by: [f64; 3],
    from: f64,
    until: f64,
}

#[derive(Serialize)]
struct Rollout {
    seconds: f64,
    /// Three coordinates per body (m); `None` if the rollout failed.
    positions: Option<Vec<f64>>,
    /// Derivatives of the positions, row by row.
    jacobian: Vec<Vec<f64>>,
    failure: Option<String>,
}

/// Final positions of all bodies.
struct FinalPositions;

impl Outcome for FinalPositions {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = trajectory.last().bodies.iter();
        bodies
            .flat_map(|body| body.position().iter().copied().collect::<Vec<_>>())
            .collect()
    }
}

impl Question {
    fn answer(&self) -> Answer<Rollout> {
        let (world, plan) = (self.scene.world()?, self.plan()?);
        let start = ProcessTime::now();
        let result = self.positions(&world, &plan);
        let seconds = start.elapsed().as_secs_f64();
        let (positions, jacobian, failure) = match result {
            Ok((positions, jacobian)) => (Some(positions), jacobian, None),
            Err(error) => (None, vec![], Some(error.to_string())),
        };
        Ok(Rollout {
            seconds,
            positions,
            jacobian,
            failure,
        })
    }

    fn plan(&self) -> Answer<Plan> {
        let plan = Plan::new(self.time_step, self.steps)?
            .with_integrator(integrator(&self.method)?)
            .recording_every(self.steps);
        let Some((values, slopes, resting_speed)) = self.accuracy else {
            return Ok(plan);
        };
        let accuracy = Accuracy::new(values, slopes)?;
        Ok(plan.with_accuracy(match resting_speed {
            Some(speed) => accuracy.with_resting_speed(speed)?,
            None => accuracy,
        }))
    }

    /// Returns the final positions, and their derivatives with respect to the parameters, if any.
    fn positions(&self, world: &World, plan: &Plan) -> Answer<(Vec<f64>, Vec<Vec<f64>>)> {
        if self.parameters.is_empty() {
            let trajectory = world.rollout(plan).run()?;
            return Ok((FinalPositions.of(&trajectory), vec![]));
        }
        let (mut by, mut columns, mut count) = (vec![], vec![], 0);
        for scalar in &self.parameters {
            let parameter = self.named(scalar)?;
            columns.push(count + scalar.axis.unwrap_or(0));
            count += parameter.dimension();
            by.push(parameter);
        }
        let outcome = Experiment::new(world, plan).jacobian(&by, &FinalPositions)?;
        let rows = outcome.jacobian.row_iter();
        let jacobian = rows.map(|row| columns.iter().map(|&column| row[column]).collect());
        Ok((outcome.value.iter().copied().collect(), jacobian.collect()))
    }

    fn named(&self, parameter: &ScalarParameter) -> Answer<Parameter> {
        let name = self.scene.bodies[parameter.body].name.as_str().into();
        match parameter.kind.as_str() {
            "position" => Ok(Parameter::InitialPosition(name)),
            "velocity" => Ok(Parameter::InitialVelocity(name)),
            "friction" => Ok(Parameter::Friction(name)),
            "mass" => Ok(Parameter::Mass(name)),
            unknown => Err(format!("there is no parameter called {unknown}").into()),
        }
    }
}

/// Returns the integrator with a name, which is the same in the script.
fn integrator(name: &str) -> Answer<Integrator> {
    match name {
        "leapfrog" => Ok(Integrator::Leapfrog),
        "sdirk3" => Ok(Integrator::Sdirk3),
        "implicit_euler" => Ok(Integrator::ImplicitEuler),
        unknown => Err(format!("there is no integrator called {unknown}").into()),
    }
}

impl Scene {
    fn world(&self) -> Answer<World> {
        let bodies: Answer<Vec<Body>> = self.bodies.iter().map(|body| self.body(body)).collect();
        let gravity = Vector3::new(0.0, 0.0, -self.gravity);
        let world = World::new(bodies?)?.with_gravity(gravity)?;
        Ok(world.with_slip_tolerance(self.slip_tolerance)?)
    }

    fn body(&self, body: &SceneBody) -> Answer<Body> {
        let (name, pose) = (&body.name, pose(&body.pose)?);
        let Some(mesh) = &body.mesh else {
            let skin = Material::rigid().with_friction(body.friction);
            return Ok(Body::fixed(name, HalfSpace::rigid(), skin)?.with_pose(pose));
        };
        let shape = Shape::new(PressureField::from_distance(
            &read_mesh(mesh, &MeshOptions::default())?.mesh,
        )?);
        let skin = Material::elastic(body.modulus)
            .with_dissipation(self.dissipation)
            .with_friction(body.friction);
        if let Some(moves) = body.moves.clone() {
            return Ok(Body::kinematic(name, shape, skin, path(pose, moves))?);
        }
        let Some(mass) = body.mass else {
            return Ok(Body::fixed(name, shape, skin)?.with_pose(pose));
        };
        let velocity = Vector3::from(body.velocity);
        let body = Body::dynamic(name, shape, skin, Mass::Total(mass))?;
        Ok(body.with_pose(pose).with_velocity(velocity))
    }
}

fn pose(numbers: &[f64; 12]) -> Answer<Pose> {
    let rotation = Matrix3::from_row_slice(&numbers[..9]);
    let translation = Vector3::from_column_slice(&numbers[9..]);
    Ok(Pose::new(rotation, translation)?)
}

/// Returns the path that starts at a pose and makes the moves.
fn path(start: Pose, moves: Vec<Move>) -> Arc<KinematicPath> {
    Arc::new(move |time| {
        let (mut pose, mut twist) = (start, Twist::zero());
        for each in &moves {
            let (by, velocity) = each.at(time);
            pose = Pose::from_translation(by) * pose;
            twist.linear += velocity;
        }
        BodyState { pose, twist }
    })
}

impl Move {
    /// Returns the displacement (m) up to a time (s), and its rate (m/s). The displacement is 3s² − 2s³ of the whole, where s is the
    /// elapsed fraction of the interval.
    fn at(&self, time: f64) -> (Vector3<f64>, Vector3<f64>) {
        let duration = self.until - self.from;
        let over = ((time - self.from) / duration).clamp(0.0, 1.0);
        let whole = Vector3::from(self.by);
        let displacement = whole * (over * over * (3.0 - 2.0 * over));
        (displacement, whole * (6.0 * over * (1.0 - over) / duration))
    }
}

fn main() -> Answer<()> {
    if !std::env::args().any(|argument| argument == "--serve") {
        println!("run benches/peers/accuracy.py, which runs this beside Drake and MuJoCo");
        return Ok(());
    }
    for line in stdin().lock().lines() {
        let question: Question = serde_json::from_str(&line?)?;
        writeln!(stdout(), "{}", serde_json::to_string(&question.answer()?)?)?;
        stdout().flush()?;
    }
    Ok(())
}
