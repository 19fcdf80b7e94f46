use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::seeded_forces::SeededForces;
use super::{ModelGradient, StateGradient};
use crate::dynamics::BodyState;
use crate::dynamics::TimeSpan;
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::model::Model;
use crate::spatial::Wrench;

/// Adjoint state of the reverse sweep: the gradient with respect to the current state and to all other inputs of the later steps. It also
/// propagates gradients with respect to wrenches, in the same way for explicit and implicit steps.
pub(super) struct Pullback<'w> {
    pub world: &'w dyn DynWorld<f64>,
    pub forces: Option<SeededForces>,
    /// Gradient with respect to the state of each body.
    pub states: Vec<StateGradient>,
    pub gradient: ModelGradient,
    /// Number of the step that is reversed, counted from 1.
    pub step: usize,
    /// Index of the body of each control.
    controlled: Vec<Option<usize>>,
}

/// States, contacts and time at which wrenches are evaluated.
#[derive(Clone, Copy)]
pub(super) struct EvaluationPoint<'a> {
    /// Time (s) at which forces act.
    pub time: f64,
    /// Time step over which controls are averaged.
    pub span: TimeSpan,
    /// States of all bodies.
    pub states: &'a [BodyState],
    /// Indices of the bodies whose states receive a gradient.
    pub bodies: &'a [usize],
    pub contacts: &'a [LinearizedPair<'a>],
    /// Net contact wrench on each body, about its center of mass, or an empty list if there are no
    /// forces.
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

    /// Whether derivatives with respect to shapes are requested.
    pub fn wants_shapes(&self) -> bool {
        !self.gradient.shapes.is_empty()
    }

    /// Clears the gradient with respect to the states of kinematic bodies, because these states depend on their paths only.
    pub fn clear_kinematic(&mut self) {
        for (body, by_state) in self.world.model().bodies.iter().zip(&mut self.states) {
            if body.motion.is_kinematic() {
                *by_state = StateGradient::zero();
            }
        }
    }

    /// Propagates the gradient with respect to the wrenches of everything but gravity about the centers of mass.
    pub fn pull_back_wrenches(&mut self, point: EvaluationPoint, by_wrenches: &[WrenchGradient]) {
        self.pull_back_controls(point.span, by_wrenches);
        let mut by_contact = by_wrenches.to_vec();
        self.pull_back_forces(point, by_wrenches, &mut by_contact);
        self.pull_back_contacts(point.states, point.contacts, &by_contact);
    }

    fn pull_back_controls(&mut self, span: TimeSpan, by_wrenches: &[WrenchGradient]) {
        let controls = self.model().controls.iter().zip(&self.controlled);
        for ((control, &body), by_intervals) in controls.zip(&mut self.gradient.controls) {
            let Some(body) = body else { continue };
            for (interval, share) in control.shares_of(span) {
                by_intervals[interval] += by_wrenches[body].to_vector() * share;
            }
        }
    }
}
