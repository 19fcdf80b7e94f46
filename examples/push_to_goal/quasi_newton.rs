//! L-BFGS over all pushes as one vector, with a separate push in each step.

use crate::scene::{
    BY_ANGLE, BY_PLACE, BY_SPIN, BY_VELOCITY, Found, PUSHES, Pushed, STEPS, Scene, TIME_STEP,
    efforts, wrench_numbers,
};
use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{CostFunction, Error, Executor, Gradient, IterState, KV, State as _};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use hydroelastic::dynamics::{Plan, State, Trajectory, World};
use hydroelastic::gradient::{Experiment, Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift_vector};
use indicatif::ProgressBar;
use nalgebra::Vector3;
use std::cell::RefCell;
use std::rc::Rc;

/// Initial guess: a force (N) toward the goal that exceeds friction. Without a force the block would stick, and its motion would hardly
/// depend on pushes.
const GUESS: f64 = 4.0;
/// Fraction of the time during which the guess pushes.
const GUESSED: f64 = 0.5;

/// Number of pairs of steps and gradient changes that L-BFGS stores.
const MEMORY: usize = 20;
/// Largest number of iterations.
const ITERATIONS: u64 = 60;
/// Change of the cost at which the iteration ends.
const ENOUGH: f64 = 1e-6;

/// Cost of the final distance from the goal.
struct Missed<'a>(&'a State);

impl Outcome for Missed<'_> {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let (goal, end) = (&self.0.bodies[0], &trajectory.last().bodies[0]);
        let away = end.position() - lift_vector::<T>(goal.position());
        let (velocity, spin) = (end.velocity(), end.twist.angular.z);
        // 1 − cos φ = φ²/2 to the third order: half the square of the angle about the vertical.
        let x_axis = lift_vector::<T>(&goal.pose.rotation().column(0).into_owned());
        let cosine = x_axis.dot(&end.pose.rotation().column(0));
        let place = (away.x * away.x + away.y * away.y) * (BY_PLACE / 2.0);
        let speed = (velocity.x * velocity.x + velocity.y * velocity.y) * (BY_VELOCITY / 2.0);
        vec![place + speed + (cosine * -1.0 + 1.0) * BY_ANGLE + spin * spin * (BY_SPIN / 2.0)]
    }
}

/// Cost as a function of pushes. The units are scaled so that equal numbers have equal cost.
struct Pushing {
    world: World,
    goal: State,
    plan: Plan,
    parameters: Vec<Parameter>,
    /// Cost of half the square of a number.
    effort: f64,
    /// Units of the three components of a push: torque (N m), forces (N).
    units: Vector3<f64>,
}

impl Pushing {
    fn new(scene: &Scene) -> Found<Self> {
        let efforts = efforts(TIME_STEP);
        let effort = efforts.max();
        let block = |step| Parameter::control("block", step);
        Ok(Self {
            world: scene.with_intervals(STEPS)?,
            goal: scene.goal.clone(),
            plan: Plan::new(TIME_STEP, STEPS)?.recording_every(STEPS),
            parameters: (0..STEPS).map(block).collect(),
            effort,
            units: efforts.map(|own| (effort / own).sqrt()),
        })
    }

    /// Returns the initial parameters of L-BFGS.
    fn guess(&self) -> Vec<f64> {
        let away =
            self.goal.bodies[0].position() - self.world.bodies()[0].initial_state().position();
        let force = Vector3::new(away.x, away.y, 0.0).normalize() * GUESS;
        let push = Vector3::new(0.0, force.x, force.y).component_div(&self.units);
        let pushed = (0..STEPS).map(|step| (step as f64) < GUESSED * STEPS as f64);
        let pushes = pushed.map(|is_pushed| if is_pushed { push } else { Vector3::zeros() });
        pushes.flat_map(<[f64; 3]>::from).collect()
    }

    /// Returns the components of the control's wrenches (N m, N).
    fn wrenches(&self, numbers: &[f64]) -> Vec<f64> {
        let push = |numbers: &[f64]| Vector3::from_column_slice(numbers).component_mul(&self.units);
        let wrenches = numbers
            .chunks(PUSHES.len())
            .map(|it| wrench_numbers(&push(it)));
        wrenches.flat_map(<[f64; 6]>::from).collect()
    }

    /// Returns the world with these pushes.
    fn pushed(&self, numbers: &[f64]) -> Result<World, Error> {
        Ok(self
            .world
            .perturbed(&self.parameters, &self.wrenches(numbers))?)
    }
}

impl CostFunction for Pushing {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, numbers: &Vec<f64>) -> Result<f64, Error> {
        let experiment = Experiment::new(&self.world, &self.plan);
        let missed = experiment.value_perturbed(
            &self.parameters,
            &self.wrenches(numbers),
            &Missed(&self.goal),
        )?;
        let squares: f64 = numbers.iter().map(|number| number * number).sum();
        Ok(missed[0] + self.effort * squares / 2.0)
    }
}

impl Gradient for Pushing {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, numbers: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let world = self.pushed(numbers)?;
        let experiment = Experiment::new(world, &self.plan);
        let (_, by_wrenches) = experiment.gradient(&self.parameters, &Missed(&self.goal))?;
        let by_pushes = by_wrenches.as_slice().chunks(6).flat_map(|by_wrench| {
            let by_push = PUSHES.map(|place| by_wrench[place]);
            <[f64; 3]>::from(Vector3::from(by_push).component_mul(&self.units))
        });
        let with_effort = by_pushes
            .zip(numbers)
            .map(|(slope, number)| slope + self.effort * number);
        Ok(with_effort.collect())
    }
}

/// Records the cost of each iteration.
struct Costs(Rc<RefCell<Vec<f64>>>, ProgressBar);

type Iteration = IterState<Vec<f64>, Vec<f64>, (), (), (), f64>;

impl Observe<Iteration> for Costs {
    fn observe_init(&mut self, _: &str, state: &Iteration, _: &KV) -> Result<(), Error> {
        self.0.borrow_mut().push(state.get_cost());
        Ok(())
    }

    fn observe_iter(&mut self, state: &Iteration, _: &KV) -> Result<(), Error> {
        self.0.borrow_mut().push(state.get_cost());
        self.1.inc(1);
        Ok(())
    }
}

/// Returns the pushes found by L-BFGS.
pub fn pushed(scene: &Scene) -> Found<Pushed> {
    let pushing = Pushing::new(scene)?;
    let solver = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY).with_tolerance_cost(ENOUGH)?;
    let (costs, bar) = (Rc::default(), ProgressBar::new(ITERATIONS));
    let guess = pushing.guess();
    let found = Executor::new(pushing, solver)
        .configure(|state| state.param(guess).max_iters(ITERATIONS))
        .add_observer(Costs(Rc::clone(&costs), bar.clone()), ObserverMode::Always)
        .run()?;
    bar.finish_and_clear();
    let best = found.state.get_best_param().ok_or("no pushes were found")?;
    let pushing = found.problem.problem.as_ref().ok_or("no problem is left")?;
    let (world, costs) = (pushing.pushed(best)?, costs.take());
    Ok(Pushed { world, costs })
}
