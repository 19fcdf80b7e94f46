//! A part of a step, taken as a whole.

use super::newton::{Root, Unsolved};
use super::problem::own;
use super::report::{EnergyBalance, Work};
use super::scheme::Stage;
use super::steps::{Moving, Part, Stepper, Stuck, velocities_of};
use crate::dynamics::BodyState;
use crate::geometry::Aabb;
use nalgebra::{DVector, Vector6};

/// How many times what velocities are known to a change may always be: where nothing moves and nothing weighs, it is round-off.
const UNKNOWN: f64 = 100.0;

/// A step is halved where a body whose moments differ turns by more (rad) in it: free rotation is of second order too.
const LARGEST_TURN: f64 = 0.3;

/// A part that was tried, stage by stage.
pub(super) struct Attempt<'s, 'a> {
    of: &'s Stepper<'a>,
    from: &'s [Moving],
    offset: f64,
    duration: f64,
    /// The momenta at the start.
    momenta: Vec<Vector6<f64>>,
    /// Of each stage, what later ones are made of.
    rates: Vec<StageRates>,
    tried: Tried,
    work: Work,
}

/// What came of it.
pub(super) struct Tried {
    pub stages: Vec<DVector<f64>>,
    pub bodies: Vec<Moving>,
    pub energy: EnergyBalance,
    pub swept: Vec<Aabb>,
    /// The greatest change of a body's forces, or turn, over what is allowed.
    pub change: f64,
}

/// For each body, its velocities and the wrench on it.
struct StageRates {
    velocities: Vec<Vector6<f64>>,
    wrenches: Vec<Vector6<f64>>,
}

impl<'s, 'a> Attempt<'s, 'a> {
    pub fn new(of: &'s Stepper<'a>, offset: f64, duration: f64) -> Self {
        let from = &of.way.bodies;
        let bodies = of.inertias.iter().zip(from);
        Self {
            of,
            from,
            offset,
            duration,
            momenta: bodies
                .map(|(inertia, body)| inertia.momentum(&body.state))
                .collect(),
            rates: Vec::new(),
            tried: Tried {
                stages: Vec::new(),
                bodies: from.clone(),
                energy: EnergyBalance::default(),
                swept: Vec::new(),
                change: 0.0,
            },
            work: Work::default(),
        }
    }

    /// All stages, and what they took.
    pub fn finished(mut self) -> (Result<Tried, Stuck>, Work) {
        let scheme = self.of.scheme;
        let weights = scheme.weights(self.duration);
        for (stage, weight) in scheme.stages(self.duration).zip(weights) {
            if let Err(stuck) = self.take(stage, weight) {
                return (Err(stuck), self.work);
            }
        }
        self.tried.energy.kinetic =
            self.of.kinetic(&self.tried.bodies) - self.of.kinetic(self.from);
        (Ok(self.tried), self.work)
    }

    /// Solves a stage, which counts for a time (s).
    fn take(&mut self, stage: Stage, weight: f64) -> Result<(), Stuck> {
        let before = |place: usize| {
            let rates = self.rates.iter();
            let both = rates.map(|rates| (rates.velocities[place], rates.wrenches[place]));
            let (velocities, wrenches): (Vec<_>, Vec<_>) = both.unzip();
            (stage.accumulated(&velocities), stage.accumulated(&wrenches))
        };
        let places = self.from.iter().enumerate();
        let starts = places.map(|(place, body)| {
            let (displacement, impulse) = before(place);
            let pose = self.of.inertias[place].displaced(&body.state.pose, &displacement);
            (pose, self.momenta[place] + impulse)
        });
        let (poses, momenta) = starts.unzip();
        let time = Part::time(self.of.start, self.offset, &stage);
        let when = [time, stage.duration];
        let problem = self.of.problem(poses, momenta, when)?;
        let guess = velocities_of(&self.tried.bodies);
        let solved = problem.solved(&guess, self.of.tolerance, &mut self.work);
        if self.of.scene.is_stopped() {
            return Err(Stuck::Stopped);
        }
        let Root { velocities, least } = solved.map_err(|Unsolved(left)| Stuck::Unsolved {
            body: problem.fastest(&left),
            duration: self.duration,
        })?;
        let states = problem.states_with(&velocities);
        self.of
            .scene
            .sweep(self.of.island, &states, &mut self.tried.swept);
        let mut rates = StageRates {
            velocities: Vec::new(),
            wrenches: Vec::new(),
        };
        for (place, state) in states.iter().take(self.from.len()).enumerate() {
            let gained = self.of.inertias[place].momentum(state) - problem.momenta[place];
            let wrench = gained / stage.duration;
            let (velocity, given) = (own(&velocities, place), problem.given(place));
            let acting = wrench - given;
            self.tried.energy.given += weight * given.dot(&velocity);
            self.tried.energy.acting += weight * acting.dot(&velocity);
            rates.velocities.push(velocity);
            rates.wrenches.push(wrench);
            self.reach(place, state, (acting, least));
        }
        self.rates.push(rates);
        self.tried.stages.push(velocities);
        Ok(())
    }

    /// Takes a body to where a stage leads, and finds how much what acts on it has changed.
    fn reach(&mut self, place: usize, state: &BodyState, (acting, least): (Vector6<f64>, f64)) {
        let body = &mut self.tried.bodies[place];
        if let Some(before) = body.acting {
            let inertia = self.of.inertias[place];
            let rotation = state.pose.rotation();
            let change = inertia.velocities(rotation, &((acting - before) * self.duration));
            let allowed = self.of.largest_changes[place] + UNKNOWN * least;
            let found = inertia.speed(&change);
            let turned = inertia.wobble(&state.twist) * self.duration / LARGEST_TURN;
            if self.of.scheme.is_adaptive {
                // Nothing over nothing is no number, which `max` passes over.
                self.tried.change = self.tried.change.max(found / allowed).max(turned);
            }
        }
        *body = Moving {
            state: *state,
            acting: Some(acting),
        };
    }
}
