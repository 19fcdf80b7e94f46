//! A trial of a substep: its stages, one after another.

use super::advance::{BodyProgress, IslandSolver, velocities_of};
use super::island_step::StepError;
use super::newton::{Root, Unsolved};
use super::report::{EnergyBalance, Work};
use super::scheme::Stage;
use super::stage::{Stages, six_of};
use crate::dynamics::{BodyState, Inertia};
use crate::geometry::Aabb;
use nalgebra::{DVector, Vector6};

/// A change of velocity up to this many times the solver's tolerance is always allowed. Without motion and weight the change is
/// round-off.
const UNKNOWN: f64 = 100.0;

/// Largest turn (rad) in a substep of a body with different moments: free rotation is of second order, too.
const LARGEST_TURN: f64 = 0.3;

/// A substep that was tried.
pub(super) struct Trial {
    /// Velocities that solve the stages.
    pub roots: Vec<DVector<f64>>,
    pub bodies: Vec<BodyProgress>,
    pub energy: EnergyBalance,
    pub swept: Vec<Aabb>,
    /// The largest change of a body's forces, or turn, relative to the allowed one.
    pub change: f64,
}

impl IslandSolver<'_> {
    /// Tries a substep. Returns the work of its stages, too.
    pub fn try_substep(&self, offset: f64, duration: f64) -> (Result<Trial, StepError>, Work) {
        let mut work = Work::default();
        let trial = self.trial(offset, duration, &mut work);
        (trial, work)
    }

    fn trial(&self, offset: f64, duration: f64, work: &mut Work) -> Result<Trial, StepError> {
        let before = &self.solved.bodies;
        let scheme = self.step.scheme;
        let from = before.iter().map(|body| body.state).collect();
        let mut stages = Stages::new(self.step, &self.step.inertias, offset, from);
        let mut trial = Trial {
            roots: Vec::new(),
            bodies: before.clone(),
            energy: EnergyBalance::default(),
            swept: Vec::new(),
            change: 0.0,
        };
        let weights = scheme.weights(duration);
        for (stage, weight) in scheme.stages(duration).zip(weights) {
            self.try_stage((stage, weight), duration, (&mut stages, &mut trial), work)?;
        }
        trial.energy.kinetic = self.kinetic(&trial.bodies) - self.kinetic(before);
        Ok(trial)
    }

    /// Solves a stage with a weight (s) in the substep.
    fn try_stage(
        &self,
        (stage, weight): (Stage, f64),
        duration: f64,
        (stages, trial): (&mut Stages, &mut Trial),
        work: &mut Work,
    ) -> Result<(), StepError> {
        let (scene, island) = (self.step.scene, self.step.island);
        let equations = self.step.equations(stages.start(&stage))?;
        let guess = velocities_of(&trial.bodies);
        let root = equations.solved(&guess, self.tolerance, work);
        if scene.is_stopped() {
            return Err(StepError::Stopped);
        }
        let Root { velocities, least } = root.map_err(|Unsolved(left)| StepError::Unsolved {
            body: equations.fastest(&left),
            duration,
        })?;
        let states = equations.states_with(|place| six_of(&velocities, place));
        scene.sweep(island, &states, &mut trial.swept);
        let rates = stages.push(&equations.start, &states);
        for (place, wrench) in rates.wrenches.iter().enumerate() {
            let (velocity, given) = (&rates.velocities[place], equations.given(place));
            let acting = wrench - given;
            trial.energy.given += weight * given.dot(velocity);
            trial.energy.acting += weight * acting.dot(velocity);
            let body = &mut trial.bodies[place];
            if let Some(last) = body.acting
                && self.step.scheme.is_adaptive
            {
                let impulse = (acting - last) * duration;
                let allowed = self.largest_changes[place] + UNKNOWN * least;
                let inertia = self.step.inertias[place];
                let change = relative_change(inertia, &states[place], &impulse, allowed);
                let turn = inertia.wobble(&states[place].twist) * duration / LARGEST_TURN;
                // `max` ignores NaN, which is zero over zero here.
                trial.change = trial.change.max(change).max(turn);
            }
            *body = BodyProgress {
                state: states[place],
                acting: Some(acting),
            };
        }
        trial.roots.push(velocities);
        Ok(())
    }

    /// The kinetic energy (J).
    fn kinetic(&self, bodies: &[BodyProgress]) -> f64 {
        let of_body = |(inertia, body): (&&Inertia, &BodyProgress)| {
            let twist = body.state.twist.to_vector();
            inertia.momentum(&body.state).dot(&twist) / 2.0
        };
        self.step.inertias.iter().zip(bodies).map(of_body).sum()
    }
}

/// The speed that an impulse gives to a body, relative to an allowed speed (m/s).
fn relative_change(
    inertia: &Inertia,
    state: &BodyState,
    impulse: &Vector6<f64>,
    allowed: f64,
) -> f64 {
    let change = inertia.velocities(state.pose.rotation(), impulse);
    inertia.speed(&change) / allowed
}
