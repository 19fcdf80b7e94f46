//! This library's side of `accuracy.py`: answers questions on stdin, a JSON line each.
//!
//! Serves the decision which step and integrator to take, here or in Drake, for an error that is
//! small enough. The script runs it with `--serve`; run by hand, it says so and ends.
//!
//! A question is a scene, a time step, their number and the name of an integrator. The answer is the
//! processor time that the rollout took and where the bodies are after it.

use cpu_time::ProcessTime;
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Body, BodyState, Integrator, Mass, Material, Plan, PrescribedPath, World,
};
use hydroelastic::io::read_mesh;
use hydroelastic::mesh::PressureField;
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
}

/// Bodies whose skins differ in the modulus only.
#[derive(Deserialize)]
struct Scene {
    bodies: Vec<SceneBody>,
    dissipation: f64,
    friction: f64,
    slip_tolerance: f64,
    gravity: f64,
}

/// With a mass it falls, with moves it follows a path, otherwise it is fixed.
#[derive(Deserialize)]
struct SceneBody {
    name: String,
    mesh: String,
    modulus: f64,
    /// Nine entries of the rotation, row by row, and three of the translation (m).
    pose: [f64; 12],
    velocity: Option<[f64; 3]>,
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
    /// Of each body (m); nothing if the rollout failed.
    positions: Option<Vec<[f64; 3]>>,
    failure: Option<String>,
}

impl Question {
    fn answer(&self) -> Answer<Rollout> {
        let world = self.scene.world()?;
        let plan = Plan::new(self.time_step, self.steps)?
            .with_integrator(integrator(&self.method)?)
            .recording_every(self.steps);
        let start = ProcessTime::now();
        let result = world.rollout(&plan).recorded();
        let seconds = start.elapsed().as_secs_f64();
        let (positions, failure) = match result {
            Ok(trajectory) => {
                let bodies = &trajectory.last().bodies;
                let positions = bodies.iter().map(|body| (*body.position()).into());
                (Some(positions.collect()), None)
            }
            Err(error) => (None, Some(error.to_string())),
        };
        Ok(Rollout {
            seconds,
            positions,
            failure,
        })
    }
}

/// The integrator of a name; the script has the same names.
fn integrator(name: &str) -> Answer<Integrator> {
    match name {
        "leapfrog" => Ok(Integrator::Leapfrog),
        "symplectic_euler" => Ok(Integrator::SymplecticEuler),
        "sdirk3" => Ok(Integrator::Sdirk3),
        "implicit_euler" => Ok(Integrator::ImplicitEuler),
        other => Err(format!("there is no integrator called {other}").into()),
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
        let shape = Shape::new(PressureField::from_distance(&read_mesh(&body.mesh)?.mesh)?);
        let skin = Material::elastic(body.modulus)
            .with_dissipation(self.dissipation)
            .with_friction(self.friction);
        let (name, pose) = (&body.name, pose(&body.pose)?);
        if let Some(moves) = body.moves.clone() {
            return Ok(Body::prescribed(name, shape, skin, path(pose, moves))?);
        }
        let Some(mass) = body.mass else {
            return Ok(Body::fixed(name, shape, skin)?.at(pose));
        };
        let velocity = Vector3::from(body.velocity.unwrap_or_default());
        let body = Body::dynamic(name, shape, skin, Mass::Total(mass))?;
        Ok(body.at(pose).with_velocity(velocity))
    }
}

fn pose(numbers: &[f64; 12]) -> Answer<Pose> {
    let rotation = Matrix3::from_row_slice(&numbers[..9]);
    let translation = Vector3::from_column_slice(&numbers[9..]);
    Ok(Pose::new(rotation, translation)?)
}

/// The path that starts at a pose and makes the moves.
fn path(start: Pose, moves: Vec<Move>) -> Arc<PrescribedPath> {
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
    /// Displacement (m) until a time (s), and its rate (m/s): 3s² − 2s³ of the whole, where s is the
    /// part of the interval that is over.
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
        println!("run benches/peers/accuracy.py, which runs this beside Drake");
        return Ok(());
    }
    for line in stdin().lock().lines() {
        let question: Question = serde_json::from_str(&line?)?;
        writeln!(stdout(), "{}", serde_json::to_string(&question.answer()?)?)?;
        stdout().flush()?;
    }
    Ok(())
}
