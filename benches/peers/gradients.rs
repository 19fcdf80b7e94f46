//! This library's side of `gradients.py`: answers questions on stdin, one JSON line each.
//!
//! Helps to decide whether to differentiate long rollouts with respect to many controls here or in MJX. The script runs this program with
//! `--serve`. Without `--serve`, the program prints a hint and exits.
//!
//! The first line is the scene, and its answer is the height (m) at which the block rests. Every further question is a list of pushes, one
//! for each interval of the control, and whether to compute derivatives. The answer is the loss, its derivatives with respect to the pushes
//! if requested, and the processor time (s).

use cpu_time::ProcessTime;
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, Control, Mass, Material, Plan, State, Trajectory, World, WorldError,
};
use hydroelastic::gradient::{Experiment, Mode, Outcome, Parameter};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write, stdin, stdout};

type Answer<T> = Result<T, Box<dyn Error>>;

/// The block's edges (m), mass (kg) and material (Pa, s/m, m/s), gravity (m/s²), time step (s), numbers of steps and of control intervals,
/// and the goal of the block (m).
#[derive(Deserialize)]
struct Scene {
    size: [f64; 3],
    mass: f64,
    modulus: f64,
    dissipation: f64,
    friction: f64,
    slip_tolerance: f64,
    gravity: f64,
    time_step: f64,
    steps: usize,
    settling_steps: usize,
    intervals: usize,
    goal: [f64; 2],
}

/// Forces (N) along x and y.
#[derive(Deserialize)]
struct Question {
    pushes: Vec<[f64; 2]>,
    derivatives: bool,
}

#[derive(Serialize)]
struct Reply {
    /// Processor time (s).
    seconds: f64,
    /// Squared distance (m²).
    loss: f64,
    /// Final position of the block (m).
    end: [f64; 3],
    /// Derivatives with respect to the pushes (m²/N); empty if not requested.
    gradient: Vec<[f64; 2]>,
}

/// Squared final horizontal distance (m²) from the goal.
struct Miss([f64; 2]);

impl Outcome for Miss {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let position = trajectory.last().bodies[0].position();
        let [x, y] = self.0.map(lift::<T>);
        vec![(position.x - x) * (position.x - x) + (position.y - y) * (position.y - y)]
    }
}

impl Scene {
    /// Returns a world with the block settled on the floor.
    fn settled(&self) -> Answer<World> {
        let skin = Material::elastic(self.modulus)
            .with_dissipation(self.dissipation)
            .with_friction(self.friction);
        let hard = Material {
            modulus: None,
            ..skin
        };
        let shape = Shape::new(shapes::cuboid(self.size)?);
        let block = Body::dynamic("block", shape, skin, Mass::Total(self.mass))?;
        let height = Vector3::z() * (self.size[2] / 2.0);
        let floor = Body::fixed("floor", HalfSpace::rigid(), hard)?;
        let world = World::new(vec![block.with_pose(Pose::from_translation(height)), floor])?
            .with_gravity(vector![0.0, 0.0, -self.gravity])?
            .with_slip_tolerance(self.slip_tolerance)?;
        let mut rest = last_state(&world, &self.plan(self.settling_steps)?)?;
        rest.time = 0.0;
        Ok(world.with_initial_state(&rest)?)
    }

    /// Returns a plan with `steps` steps that records only the last state.
    fn plan(&self, steps: usize) -> Result<Plan, WorldError> {
        Ok(Plan::new(self.time_step, steps)?.recording_every(steps))
    }

    /// Returns the world with these pushes, one for each interval.
    fn pushed(&self, world: &World, pushes: &[[f64; 2]]) -> Answer<World> {
        let wrench = |[x, y]: &[f64; 2]| Wrench {
            torque: Vector3::zeros(),
            force: vector![*x, *y, 0.0],
        };
        let interval = self.time_step * (self.steps / self.intervals) as f64;
        let control = Control::new("block", interval, pushes.iter().map(wrench).collect())?;
        Ok(world.clone().with_control(control)?)
    }

    /// Returns the loss or its gradient, with its time. The final position of the block is computed outside the measured time.
    fn answer(&self, world: &World, question: &Question) -> Answer<Reply> {
        let world = self.pushed(world, &question.pushes)?;
        let plan = self.plan(self.steps)?;
        let end = *last_state(&world, &plan)?.bodies[0].position();
        let (experiment, miss) = (Experiment::new(world, &plan), Miss(self.goal));
        let intervals = 0..question.pushes.len();
        let pushes: Vec<_> = intervals
            .map(|interval| Parameter::control("block", interval))
            .collect();
        let start = ProcessTime::now();
        let (loss, gradient) = if question.derivatives {
            let (loss, slope) =
                experiment.gradient_with_mode(Mode::Reverse, black_box(&pushes), &miss)?;
            let forces = slope.as_slice().chunks(6).map(|by| [by[3], by[4]]);
            (loss, forces.collect())
        } else {
            (black_box(&experiment).value(&miss)?[0], Vec::new())
        };
        Ok(Reply {
            seconds: start.elapsed().as_secs_f64(),
            loss,
            end: end.into(),
            gradient,
        })
    }
}

fn last_state(world: &World, plan: &Plan) -> Answer<State> {
    Ok(world.rollout(plan).run()?.last().clone())
}

fn main() -> Answer<()> {
    if !std::env::args().any(|argument| argument == "--serve") {
        println!("run benches/peers/gradients.py, which runs this beside MJX");
        return Ok(());
    }
    let mut lines = stdin().lock().lines();
    let scene: Scene = serde_json::from_str(&lines.next().ok_or("no scene")??)?;
    let world = scene.settled()?;
    let height = world.initial_state().bodies[0].position().z;
    writeln!(stdout(), "{}", serde_json::json!({ "height": height }))?;
    for line in lines {
        let reply = scene.answer(&world, &serde_json::from_str(&line?)?)?;
        writeln!(stdout(), "{}", serde_json::to_string(&reply)?)?;
        stdout().flush()?;
    }
    Ok(())
}
