//! Steps of a rollout.
//!
//! An explicit step is a function from state to state. In *drifts*, bodies move freely (`free_rotation.rs`: one splitting, continuous in
//! the moments of inertia). In one *kick*, wrenches act at fixed poses. The kick sums the wrenches of all close pairs, then the mean
//! controls over the step, then the other forces, which can depend on the contacts. Gravity is added separately. Close pairs are pairs
//! whose bounding boxes overlap, found by sort and sweep. The wrenches are summed in the order of the pairs, so that the number of threads
//! changes no bit.
//!
//! Drifts keep the angular momentum to rounding errors. The angular velocity follows from the angular momentum and the rotated inertia.

use super::dyn_world::DynWorld;
use super::implicit::{ImplicitIntegratorState, IslandRecord, LastStep, Scheme, StepSettings};
use super::integrator::{Kind, Splitting};
use super::model::Model;
use super::stability::{ContactBalances, Instability, Kick};
use super::workspace::Workspace;
use super::{Body, Plan, RolloutError, State};
use crate::scalar::Scalar;
use std::mem;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Smallest slip tolerance (m/s) of implicit steps. With 1e-7 m/s, some impacts with friction are not solved.
const LEAST_SLIP_TOLERANCE: f64 = 1e-6;

/// Stepping state of a rollout: the current state, the next state, and the data that a step passes
/// to the next step.
#[derive(Debug, Clone)]
pub(crate) struct Stepper<T> {
    pub(super) state: State<T>,
    /// Next state while it is computed. It replaces `state` only after it is known to be finite.
    next: State<T>,
    workspace: Workspace<T>,
    /// Energy balances of contacts, for the stability check of explicit steps.
    balances: ContactBalances,
    /// Solver state of implicit steps, or `None` before the first step.
    pub(super) integrator_state: Option<ImplicitIntegratorState>,
    /// Time (s) at which the step count is zero.
    start: f64,
    /// Number of steps taken since `start`.
    step_count: usize,
    pub(super) has_failed: bool,
    /// Cancel flag. Once it is true, the steps end, including an implicit step in progress.
    pub(super) stop: Arc<AtomicBool>,
}

/// Data that later steps need to continue with the same bits.
#[derive(Debug, Clone)]
pub(crate) struct Checkpoint {
    pub state: State,
    /// State that the last implicit step passes to the next step, or `None` before the first step.
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
    /// Steps of a rollout that continue from a checkpoint after `step_count` steps.
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

    /// Records of the islands in the last implicit step.
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
        self.next.joints.clone_from(&self.state.joints);
        // The time is computed from the step count, because a sum of 10⁶ time steps would drift.
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
        let error = model.body_on_joint().map(|body| RolloutError::Joints {
            integrator: plan.integrator(),
            body: body.name().to_owned(),
        });
        self.stop_at(error)?;
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
        let step = StepSettings {
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

    /// Ends the rollout if there is an error.
    fn stop_at(&mut self, error: Option<RolloutError>) -> Result<(), RolloutError> {
        self.has_failed |= error.is_some();
        error.map_or(Ok(()), Err)
    }

    /// Returns an error if a path is not finite at the time of the next state.
    fn path_error(&self, model: &Model<T>, step: usize) -> Option<RolloutError> {
        let is_kinematic = |body: &Body<T>| body.motion.is_kinematic();
        let (time, body) = (self.next.time, self.non_finite_body(model, is_kinematic)?);
        Some(RolloutError::PathNotFinite { step, time, body })
    }

    /// Returns an error if the next state is not finite.
    fn state_error(&self, model: &Model<T>, step: usize) -> Option<RolloutError> {
        let (time, body) = (self.next.time, self.non_finite_body(model, |_| true)?);
        Some(RolloutError::NotFinite { step, time, body })
    }

    /// Name of the first checked body whose next state is not finite.
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
