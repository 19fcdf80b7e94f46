//! This library's side of `compare.py`: answers questions on stdin, one JSON line each.
//!
//! Helps to decide whether contact in this library is faster than in Drake, and as accurate. The script runs this program with `--serve`.
//! Without `--serve`, the program prints a hint and exits.
//!
//! `wrench` and `jacobian` time the whole computation from poses to the result: bodies, pair and contact. `steps` times a rollout of a ball
//! at rest on a box, or the Jacobian of the rollout.

use hydroelastic::contact::{
    ContactBody, ContactPair, HalfSpace, LinearizedContact, RigidShape, Shape,
};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, FinalState, Parameter};
use hydroelastic::io::{MeshOptions, read_mesh};
use hydroelastic::mesh::{PressureField, TriangleSurface};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write, stdin, stdout};
use std::sync::Arc;
use std::time::Instant;

type Answer<T> = Result<T, Box<dyn Error>>;

/// Nine entries of the rotation, row by row, and three of the translation (m).
type PoseNumbers = [f64; 12];

#[derive(Deserialize)]
#[serde(tag = "ask", rename_all = "lowercase")]
enum Question {
    Wrench {
        scene: TwoMeshes,
        poses: Vec<[PoseNumbers; 2]>,
    },
    Jacobian {
        scene: TwoMeshes,
        poses: Vec<[PoseNumbers; 2]>,
    },
    Steps {
        scene: BallOnFloor,
        steps: usize,
        derivatives: usize,
    },
}

#[derive(Deserialize)]
struct TwoMeshes {
    meshes: [String; 2],
    modulus: f64,
}

#[derive(Deserialize)]
struct BallOnFloor {
    ball: String,
    #[serde(rename = "box")]
    slab: String,
    floor: Floor,
    start: PoseNumbers,
    mass: f64,
    modulus: f64,
    dissipation: f64,
    friction: f64,
    time_step: f64,
    settling_steps: usize,
}

/// Floor under the ball: a cube of edge 1 m, or a half-space at the height of the cube.
#[derive(Deserialize, Clone, Copy, PartialEq, Eq, Hash)]
enum Floor {
    #[serde(rename = "soft box")]
    SoftBox,
    #[serde(rename = "rigid box")]
    RigidBox,
    #[serde(rename = "half-space")]
    HalfSpace,
}

/// Results with one entry per pose.
#[derive(Default, Serialize)]
struct ContactTimes {
    seconds: Vec<f64>,
    polygons: Vec<usize>,
    /// Wrenches on A about A's origin: torque, force.
    wrenches: Vec<Vec<f64>>,
    /// Rows are the components of the wrench; columns are derivatives with respect to the pose of A, then of B, angular before linear.
    jacobians: Vec<Vec<Vec<f64>>>,
}

/// Time of one step, and the ball after the last step.
#[derive(Serialize)]
struct StepTime {
    seconds: f64,
    height: f64,
    polygons: usize,
}

/// Meshes and worlds of earlier questions.
#[derive(Default)]
struct Server {
    shapes: HashMap<String, Arc<Shape>>,
    settled: HashMap<(String, Floor), World>,
}

impl Server {
    fn answer(&mut self, line: &str) -> Answer<String> {
        let answer = match serde_json::from_str(line)? {
            Question::Wrench { scene, poses } => {
                serde_json::to_string(&self.wrenches(&scene, &poses)?)
            }
            Question::Jacobian { scene, poses } => {
                serde_json::to_string(&self.jacobians(&scene, &poses)?)
            }
            Question::Steps {
                scene,
                steps,
                derivatives,
            } => {
                let world = self.settled(&scene)?;
                serde_json::to_string(&step_time(world, scene.time_step, steps, derivatives)?)
            }
        };
        Ok(answer?)
    }

    fn wrenches(&mut self, scene: &TwoMeshes, poses: &[[PoseNumbers; 2]]) -> Answer<ContactTimes> {
        let shapes = self.shapes(scene)?;
        let mut times = ContactTimes::default();
        for numbers in poses {
            let poses = both_poses(numbers)?;
            let work = || Ok(pair(&shapes, black_box(poses), scene.modulus)?.wrench());
            let (seconds, wrench) = timed(work)?;
            times.push(seconds, &wrench.on_a);
        }
        times.with_polygons(&shapes, scene.modulus, poses)
    }

    fn jacobians(&mut self, scene: &TwoMeshes, poses: &[[PoseNumbers; 2]]) -> Answer<ContactTimes> {
        let shapes = self.shapes(scene)?;
        let mut times = ContactTimes::default();
        for numbers in poses {
            let poses = both_poses(numbers)?;
            let work = || Ok(pair(&shapes, black_box(poses), scene.modulus)?.linearized());
            let (seconds, contact) = timed(work)?;
            times.push(seconds, &contact.wrench.on_a);
            times.jacobians.push(rows_by_poses(&contact));
        }
        times.with_polygons(&shapes, scene.modulus, poses)
    }

    fn shapes(&mut self, scene: &TwoMeshes) -> Answer<[Arc<Shape>; 2]> {
        let [a, b] = &scene.meshes;
        Ok([self.shape(a)?, self.shape(b)?])
    }

    /// Returns the mesh of a file with its distance field.
    fn shape(&mut self, path: &str) -> Answer<Arc<Shape>> {
        if let Some(shape) = self.shapes.get(path) {
            return Ok(Arc::clone(shape));
        }
        let field = PressureField::from_distance(&read_mesh(path, &MeshOptions::default())?.mesh)?;
        let shape = Arc::new(Shape::new(field));
        self.shapes.insert(path.to_owned(), Arc::clone(&shape));
        Ok(shape)
    }

    /// Returns the world in which the ball has come to rest, cached for each mesh and floor.
    fn settled(&mut self, scene: &BallOnFloor) -> Answer<&World> {
        let key = (scene.ball.clone(), scene.floor);
        if !self.settled.contains_key(&key) {
            let (ball, slab) = (self.shape(&scene.ball)?, self.shape(&scene.slab)?);
            let (ball, slab) = scene.bodies(ball, slab)?;
            let falling = world(ball.clone(), slab.clone())?;
            let rest = last_state(&falling, scene.time_step, scene.settling_steps)?.bodies[0];
            let ball = ball
                .with_pose(rest.pose)
                .with_velocity(rest.twist.linear)
                .with_angular_velocity(rest.twist.angular);
            self.settled.insert(key.clone(), world(ball, slab)?);
        }
        Ok(&self.settled[&key])
    }
}

impl ContactTimes {
    fn push(&mut self, seconds: f64, wrench: &Wrench) {
        self.seconds.push(seconds);
        self.wrenches.push(wrench.to_vector().as_slice().to_vec());
    }

    /// Adds polygon counts after all timing, so that no timed pose is in the caches.
    fn with_polygons(
        mut self,
        shapes: &[Arc<Shape>; 2],
        modulus: f64,
        poses: &[[PoseNumbers; 2]],
    ) -> Answer<Self> {
        for numbers in poses {
            let count = pair(shapes, both_poses(numbers)?, modulus)?.work_count();
            self.polygons.push(count.polygons);
        }
        Ok(self)
    }
}

impl BallOnFloor {
    /// Returns ball and floor, with friction and dissipation. A compliant box has the material of the ball.
    fn bodies(&self, ball: Arc<Shape>, slab: Arc<Shape>) -> Answer<(Body, Body)> {
        let skin = Material::elastic(self.modulus)
            .with_dissipation(self.dissipation)
            .with_friction(self.friction);
        let ball = Body::dynamic("ball", ball, skin, Mass::Total(self.mass))?;
        let hard = Material {
            modulus: None,
            ..skin
        };
        let floor = match self.floor {
            Floor::SoftBox => Body::fixed("floor", slab, skin)?,
            Floor::RigidBox => {
                let surface = TriangleSurface::around(slab.field().mesh())?;
                Body::fixed("floor", RigidShape::new(surface), hard)?
            }
            Floor::HalfSpace => Body::fixed("floor", HalfSpace::rigid(), hard)?
                .with_pose(Pose::from_translation(Vector3::new(0.0, 0.0, 0.5))),
        };
        Ok((ball.with_pose(pose(&self.start)?), floor))
    }
}

fn world(ball: Body, slab: Body) -> Answer<World> {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    Ok(World::new(vec![ball, slab])?.with_gravity(gravity)?)
}

fn last_state(world: &World, time_step: f64, steps: usize) -> Answer<State> {
    let plan = Plan::new(time_step, steps)?.recording_every(steps);
    Ok(world.rollout(&plan).run()?.last().clone())
}

/// Measures a rollout, or the Jacobian of its final state with respect to `derivatives` components of the initial state.
fn step_time(world: &World, time_step: f64, steps: usize, derivatives: usize) -> Answer<StepTime> {
    let start = [
        Parameter::initial_velocity("ball"),
        Parameter::initial_angular_velocity("ball"),
        Parameter::initial_position("ball"),
        Parameter::initial_orientation("ball"),
    ];
    let (mut seconds, state) = timed(|| last_state(black_box(world), time_step, steps))?;
    if derivatives > 0 {
        let experiment =
            Experiment::new(world, &Plan::new(time_step, steps)?.recording_every(steps));
        let end = FinalState::of_body(world, "ball")?;
        let parameters = &start[..derivatives / 3];
        (seconds, _) = timed(|| Ok(experiment.jacobian(black_box(parameters), &end)?))?;
    }
    Ok(StepTime {
        seconds: seconds / steps as f64,
        height: state.bodies[0].position().z,
        polygons: world.topology(&state).unwrap().polygon_count(),
    })
}

/// Returns the time (s) and the result of the work.
fn timed<T>(work: impl FnOnce() -> Answer<T>) -> Answer<(f64, T)> {
    let start = Instant::now();
    let result = black_box(work()?);
    Ok((start.elapsed().as_secs_f64(), result))
}

fn pair(shapes: &[Arc<Shape>; 2], poses: [Pose; 2], modulus: f64) -> Answer<ContactPair<'_>> {
    let a = ContactBody::new(&shapes[0], poses[0], modulus)?;
    let b = ContactBody::new(&shapes[1], poses[1], modulus)?;
    Ok(ContactPair::new(a, b))
}

fn both_poses(numbers: &[PoseNumbers; 2]) -> Answer<[Pose; 2]> {
    Ok([pose(&numbers[0])?, pose(&numbers[1])?])
}

fn pose(numbers: &PoseNumbers) -> Answer<Pose> {
    let rotation = Matrix3::from_row_slice(&numbers[..9]);
    Ok(Pose::new(
        rotation,
        Vector3::from_column_slice(&numbers[9..]),
    )?)
}

/// Returns the rows of the derivatives of the wrench on A with respect to both poses.
fn rows_by_poses(contact: &LinearizedContact) -> Vec<Vec<f64>> {
    (0..6)
        .map(|row| contact.by_poses.row(row).iter().copied().collect())
        .collect()
}

fn main() -> Answer<()> {
    if !std::env::args().any(|argument| argument == "--serve") {
        println!("run benches/peers/compare.py, which runs this beside Drake");
        return Ok(());
    }
    let mut server = Server::default();
    for line in stdin().lock().lines() {
        let answer = server.answer(&line?)?;
        writeln!(stdout(), "{answer}")?;
        stdout().flush()?;
    }
    Ok(())
}
