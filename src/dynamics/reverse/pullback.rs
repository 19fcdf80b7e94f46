use super::contact::{LinearizedPair, WrenchCovector};
use super::forces::SeededForces;
use super::{ModelGradient, StateGradient};
use crate::dynamics::BodyState;
use crate::dynamics::TimeSpan;
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::model::Model;
use crate::spatial::Wrench;

/// The derivatives of a number by the state that a sweep has come to, and by all else as far as later steps depend on it; and how
/// those by wrenches lead to them, whatever the steps are.
pub(super) struct Pullback<'w> {
    pub world: &'w dyn DynWorld<f64>,
    pub forces: Option<SeededForces>,
    /// By the state of each body.
    pub states: Vec<StateGradient>,
    pub gradient: ModelGradient,
    /// The step that is taken back, counted from 1.
    pub step: usize,
    /// The body of each control.
    controlled: Vec<Option<usize>>,
}

/// Where wrenches act.
#[derive(Clone, Copy)]
pub(super) struct EvaluationPoint<'a> {
    /// Time (s) at which forces act.
    pub time: f64,
    /// The time step over which controls are averaged.
    pub span: TimeSpan,
    /// The states of all bodies.
    pub states: &'a [BodyState],
    /// The bodies whose states are looked at.
    pub bodies: &'a [usize],
    pub contacts: &'a [LinearizedPair<'a>],
    /// The net wrench of these on each body, about its center of mass; nothing is there if there are no forces.
    pub net: &'a [Wrench],
}

impl<'w> Pullback<'w> {
    pub fn of(world: &'w dyn DynWorld<f64>) -> Self {
        let model = world.model();
        let controls = model.controls.iter();
        Self {
            world,
            forces: SeededForces::of(world),
            states: vec![StateGradient::zero(); model.bodies.len()],
            gradient: ModelGradient::zero(model),
            step: 0,
            controlled: controls
                .map(|control| model.index_of(control.body()).ok())
                .collect(),
        }
    }

    pub fn model(&self) -> &'w Model {
        self.world.model()
    }

    /// Whether derivatives by shapes are asked for.
    pub fn wants_shapes(&self) -> bool {
        !self.gradient.shapes.is_empty()
    }

    /// Forgets derivatives by the states of bodies that follow paths: where a path leads, nothing else does.
    pub fn clear_kinematic(&mut self) {
        for (body, by_state) in self.world.model().bodies.iter().zip(&mut self.states) {
            if body.motion.is_kinematic() {
                *by_state = StateGradient::zero();
            }
        }
    }

    /// Adds what follows from the derivatives by the wrenches of all but gravity about the centers of mass.
    pub fn pull_back_wrenches(&mut self, here: EvaluationPoint, by_wrenches: &[WrenchCovector]) {
        self.pull_back_controls(here.span, by_wrenches);
        let mut by_contact = by_wrenches.to_vec();
        self.pull_back_forces(here, by_wrenches, &mut by_contact);
        self.pull_back_contacts(here.states, here.contacts, &by_contact);
    }

    fn pull_back_controls(&mut self, span: TimeSpan, by_wrenches: &[WrenchCovector]) {
        let controls = self.model().controls.iter().zip(&self.controlled);
        for ((control, &body), by_intervals) in controls.zip(&mut self.gradient.controls) {
            let Some(body) = body else { continue };
            for (interval, share) in control.shares_of(span) {
                by_intervals[interval] += by_wrenches[body].to_vector() * share;
            }
        }
    }
}
