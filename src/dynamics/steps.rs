//! Steps of a rollout.
//!
//! An explicit step is a function from state to state: *drifts*, in which bodies move freely (`free_rotation.rs`: one splitting, continuous
//! in the moments of inertia), and one *kick*, in which wrenches act at fixed poses. The kick sums the wrenches of all close pairs, then
//! those of the controls at the middle of the step and of the forces, which see the contacts. Gravity acts by itself. Close pairs are
//! those whose boxes overlap, by sort and sweep. The wrenches are summed in the order of the pairs, so that threads change no bit.
//!
//! Angular momentum is the state of rotation. Drifts keep it to rounding errors, and the angular velocity follows from the angular momentum
//! and the rotated inertia.

use super::dyn_world::DynWorld;
use super::implicit::{ImplicitIntegratorState, IslandRecord, LastStep, Scheme, Step};
use super::integrator::{Kind, Splitting};
use super::model::Model;
use super::stability::{ContactBalances, Instability, Kick};
use super::workspace::Workspace;
use super::{Body, Plan, RolloutError, State};
use crate::scalar::Scalar;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The least slip tolerance (m/s) of implicit steps. With 1e-7 m/s, impacts with friction are not solved any more here and there.
const LEAST_SLIP_TOLERANCE: f64 = 1e-6;

/// The state that a world's steps have led to.
#[derive(Debug, Clone)]
pub(crate) struct Stepper<T> {
    pub(super) state: State<T>,
    /// The next state while it is computed; `state` stays until that one is known to be finite.
    next: State<T>,
    workspace: Workspace<T>,
    /// The contacts of explicit steps that are checked.
    balances: ContactBalances,
    /// What implicit steps keep; none before the first.
    pub(super) integrator_state: Option<ImplicitIntegratorState>,
    /// Time (s) of the state that steps are counted from.
    start: f64,
    /// Steps taken since then.
    step_count: usize,
    pub(super) has_failed: bool,
    /// Stop flag. Once it is true, steps end, also an implicit step in progress.
    pub(super) stop: Arc<AtomicBool>,
}

/// What steps need to go on with the same bits.
#[derive(Debug, Clone)]
pub(crate) struct Checkpoint {
    pub state: State,
    /// What the last implicit step carries on to the next; none before the first.
    last: Option<LastStep>,
}

impl<T: Scalar> From<State<T>> for Stepper<T> {
    fn from(state: State<T>) -> Self {
        Self {
            next: state.clone(),
            start: state.time,
            state,
            workspace: Workspace::default(),
            balances: ContactBalances::default(),
            integrator_state: None,
            step_count: 0,
            has_failed: false,
            stop: Arc::default(),
        }
    }
}

impl Stepper<f64> {
    /// The steps of a world's rollout, so many of which have led here.
    pub(super) fn resumed(
        checkpoint: &Checkpoint,
        world: &dyn DynWorld<f64>,
        step_count: usize,
    ) -> Self {
        let last = checkpoint.last.as_ref();
        let integrator_state =
            last.map(|last| ImplicitIntegratorState::of(world, Arc::default()).after(last.clone()));
        Self {
            start: world.model().start,
            integrator_state,
            step_count,
            ..Self::from(checkpoint.state.clone())
        }
    }

    pub(super) fn checkpoint(&self) -> Checkpoint {
        let integrator_state = self.integrator_state.as_ref();
        Checkpoint {
            state: self.state.clone(),
            last: integrator_state.map(|integrator_state| integrator_state.last.clone()),
        }
    }

    /// The ways that the islands of an implicit step have gone in the last one.
    pub(super) fn island_records(&self) -> &[IslandRecord] {
        self.integrator_state
            .as_ref()
            .map_or(&[], |integrator_state| &integrator_state.island_records)
    }
}

impl<T: Scalar> Stepper<T> {
    /// Ends the steps with [`RolloutError::Stopped`] once the flag is true.
    pub(super) fn with_cancel_flag(mut self, stop: Arc<AtomicBool>) -> Self {
        if let Some(integrator_state) = &mut self.integrator_state {
            integrator_state.stop = Arc::clone(&stop);
        }
        Self { stop, ..self }
    }

    pub(super) fn advance(
        &mut self,
        world: &dyn DynWorld<T>,
        plan: &Plan,
    ) -> Result<&State<T>, RolloutError> {
        let is_stopped = self.stop.load(Ordering::Relaxed);
        self.stop_at(is_stopped.then_some(RolloutError::Stopped))?;
        let model = world.model();
        let step = self.step_count + 1;
        if self.step_count == 0 {
            self.stop_at(model.below_half_space(&self.state.bodies))?;
        }
        self.next.time = self.state.time;
        self.next.bodies.clone_from(&self.state.bodies);
        // From the count of steps: a sum of 10⁶ time steps would have drifted.
        let end = self.start + step as f64 * plan.time_step();
        match plan.integrator().kind() {
            Kind::Explicit(splitting) => self.advance_explicitly(world, (plan, splitting), step)?,
            Kind::Implicit(scheme) => self.advance_implicitly(world, (plan, scheme), end)?,
        }
        self.next.time = end;
        let path_error = self.path_error(model, step);
        self.stop_at(path_error.or_else(|| self.state_error(model, step)))?;
        mem::swap(&mut self.state, &mut self.next);
        self.balances.accept();
        self.step_count = step;
        Ok(&self.state)
    }

    fn advance_explicitly(
        &mut self,
        world: &dyn DynWorld<T>,
        (plan, splitting): (&Plan, Splitting),
        step: usize,
    ) -> Result<(), RolloutError> {
        let (model, time_step) = (world.model(), plan.time_step());
        splitting.approach(model, &mut self.next, time_step);
        self.stop_at(self.path_error(model, step))?;
        if plan.checks_stability() {
            let twists = &mut self.workspace.before_kick;
            twists.clear();
            twists.extend(self.next.bodies.iter().map(|state| state.real().twist));
        }
        splitting.kick(world, &mut self.next, time_step, &mut self.workspace);
        if plan.checks_stability() {
            let error = self.instability(model, time_step, step);
            self.stop_at(error)?;
        }
        splitting.depart(model, &mut self.next, time_step);
        Ok(())
    }

    fn advance_implicitly(
        &mut self,
        world: &dyn DynWorld<T>,
        (plan, scheme): (&Plan, &'static Scheme),
        end: f64,
    ) -> Result<(), RolloutError> {
        let found = world.model().slip_tolerance;
        let error = RolloutError::SlipTolerance {
            found,
            least: LEAST_SLIP_TOLERANCE,
        };
        self.stop_at((found < LEAST_SLIP_TOLERANCE).then_some(error))?;
        let new = || ImplicitIntegratorState::of(world, Arc::clone(&self.stop));
        let integrator_state = self.integrator_state.get_or_insert_with(new);
        let step = Step {
            scheme,
            tolerance: plan.solver_tolerance(),
            accuracy: plan.accuracy(),
            duration: plan.time_step(),
            end,
        };
        let error = integrator_state.advance(world, &mut self.next, &step).err();
        let (step, start) = (self.step_count + 1, self.state.time);
        self.stop_at(error.map(|error| error.into_error(world.model(), (step, start))))
    }

    /// Ends the rollout by an error, if there is one.
    fn stop_at(&mut self, error: Option<RolloutError>) -> Result<(), RolloutError> {
        self.has_failed |= error.is_some();
        error.map_or(Ok(()), Err)
    }

    /// An error, if a path is not finite at the time of the next state.
    fn path_error(&self, model: &Model<T>, step: usize) -> Option<RolloutError> {
        let is_kinematic = |body: &Body<T>| body.motion.is_kinematic();
        let (time, body) = (self.next.time, self.non_finite_body(model, is_kinematic)?);
        Some(RolloutError::PathNotFinite { step, time, body })
    }

    /// An error, if the next state is not finite.
    fn state_error(&self, model: &Model<T>, step: usize) -> Option<RolloutError> {
        let (time, body) = (self.next.time, self.non_finite_body(model, |_| true)?);
        Some(RolloutError::NotFinite { step, time, body })
    }

    /// The name of the first of such bodies whose next state is not finite.
    fn non_finite_body(
        &self,
        model: &Model<T>,
        is_checked: impl Fn(&Body<T>) -> bool,
    ) -> Option<String> {
        let mut bodies = model.bodies.iter().zip(&self.next.bodies);
        let (body, _) = bodies.find(|(body, state)| is_checked(body) && !state.is_finite())?;
        Some(body.name().to_owned())
    }

    /// Returns an error if the step is too long for the contacts at the kick, or if contact has created energy.
    fn instability(
        &mut self,
        model: &Model<T>,
        time_step: f64,
        step: usize,
    ) -> Option<RolloutError> {
        let time = self.state.time;
        let Workspace {
            sweep,
            pair_wrenches,
            contact,
            all,
            before_kick,
        } = &self.workspace;
        let kick = Kick {
            time_step,
            before: before_kick,
            after: &self.next.bodies,
            pairs: sweep.pairs(),
            contacts: pair_wrenches,
            contact,
            all,
        };
        let names = |bodies: [usize; 2]| bodies.map(|index| model.bodies[index].name().to_owned());
        let instability = self.balances.check(model, &kick, &self.state.bodies)?;
        Some(match instability {
            Instability::AboveLimit { bodies, limit } => RolloutError::TimeStepTooLong {
                step,
                time,
                time_step,
                limit,
                bodies: names(bodies),
            },
            Instability::EnergyGain {
                bodies,
                absorbed,
                returned,
            } => RolloutError::EnergyGained {
                step,
                time,
                time_step,
                bodies: names(bodies),
                absorbed,
                returned,
            },
        })
    }
}
