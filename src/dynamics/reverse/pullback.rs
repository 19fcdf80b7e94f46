use super::linearized_pair::{LinearizedPair, WrenchGradient};
use super::seeded_forces::SeededForces;
use super::{BodyStateGradient, JointStateGradient, ModelGradient};
use crate::dynamics::BodyState;
use crate::dynamics::TimeSpan;
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::joint::{JointKind, NUMBER_COUNT};
use crate::dynamics::joint_schedule::ScheduleShare;
use crate::dynamics::model::Model;
use crate::dynamics::multibody::{Kinematics, Multibody};
use crate::spatial::{Twist, Wrench};
use nalgebra::{DVector, Vector3, Vector6};
use std::mem;

/// Adjoint state of the reverse sweep: the gradient with respect to the current state and to all other inputs of the later steps. It also
/// propagates gradients with respect to wrenches, in the same way for explicit and implicit steps.
pub(super) struct Pullback<'w> {
    pub world: &'w dyn DynWorld<f64>,
    pub forces: Option<SeededForces>,
    /// Gradient with respect to the state of each body.
    pub states: Vec<BodyStateGradient>,
    /// Gradient with respect to the state of each joint.
    pub joints: Vec<JointStateGradient>,
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
            states: vec![BodyStateGradient::zero(); model.bodies.len()],
            joints: vec![JointStateGradient::zero(); model.joint_count()],
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
                *by_state = BodyStateGradient::zero();
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

    /// Adds the gradient with respect to the numbers of the law of a joint during a time step.
    pub fn add_by_joint_law(
        &mut self,
        body: usize,
        mut by_numbers: [f64; NUMBER_COUNT],
        step: TimeSpan,
    ) {
        let gradient = &mut self.gradient.bodies[body];
        if let Some(joint) = self.world.model().bodies[body].joint() {
            let share = |share: &ScheduleShare| {
                let products = share.weights.iter().zip(&by_numbers);
                products
                    .map(|(weight, number)| weight * number)
                    .sum::<f64>()
            };
            for torque in joint.torque_shares(step) {
                gradient.torques[torque.index] += share(&torque);
            }
            for target in joint.target_shares(step) {
                gradient.targets[target.index] += share(&target);
            }
            // Scheduled targets replace the target of the law.
            if joint.targets().is_some() {
                by_numbers[1..3].fill(0.0);
            }
        }
        for (sum, number) in gradient.joint_law.iter_mut().zip(by_numbers) {
            *sum += number;
        }
    }

    /// Converts the gradient with respect to the initial states of bodies on joints to the joints.
    pub fn take_initial_bodies_on_joints(&mut self) {
        let model = self.model();
        if model.has_joints() {
            let (multibody, kinematics) = model.kinematics_at(&model.initial_state());
            let gradients = self.take_gradient(&multibody, &kinematics);
            self.add_gradient(&multibody, &kinematics, gradients);
        }
    }

    /// Takes the gradients with respect to the states of the dynamic bodies and their joints, and replaces them by 0. Returns the gradient
    /// with respect to positions, as displacements, and to velocities.
    pub fn take_gradient(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
    ) -> [DVector<f64>; 2] {
        let directions = kinematics.position_directions(0.0);
        let mut gradients = [
            DVector::zeros(multibody.width()),
            DVector::zeros(multibody.width()),
        ];
        let mut by_twists = Vec::new();
        for (index, link) in multibody.links.iter().enumerate() {
            let [by_pose, by_twist] =
                self.take_state_gradient(link.body, &kinematics.states[index]);
            by_twists.push(by_twist);
            if let Some(neighbor) = multibody.carrier(index) {
                let carrier = &kinematics.states[multibody.links.len() + neighbor];
                let center = kinematics.states[index]
                    .pose
                    .transformed_constant(&link.inertia.center_of_mass);
                let arm = center - carrier.pose.translation();
                let by_carrier = &mut self.states[multibody.neighbors[neighbor]];
                by_carrier.turn += turn_gradient(&kinematics.states[index].twist, &by_twist);
                by_carrier.turn +=
                    by_pose.fixed_rows::<3>(0) + arm.cross(&by_pose.fixed_rows::<3>(3));
                by_carrier.shift += by_pose.fixed_rows::<3>(3);
            }
            for motion in multibody.body_columns(kinematics, &directions, index) {
                gradients[0][motion.column] +=
                    motion.displacement.dot(&by_pose) + motion.velocity.dot(&by_twist);
                gradients[1][motion.column] += motion.axis.dot(&by_twist);
            }
            if let Some(state_index) = link.state_index {
                let joint = &mut self.joints[state_index];
                let by_joint = mem::replace(joint, JointStateGradient::zero());
                for (gradient, by_joint) in gradients
                    .iter_mut()
                    .zip([by_joint.position, by_joint.velocity])
                {
                    for (i, column) in link.columns.clone().enumerate() {
                        gradient[column] += by_joint[i];
                    }
                }
            }
        }
        self.add_by_centers_in_states(multibody, kinematics, &by_twists, &gradients);
        gradients
    }

    /// Adds gradients with respect to the states of the dynamic bodies and their joints.
    pub fn add_gradient(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        [by_position, by_velocity]: [DVector<f64>; 2],
    ) {
        for (link, state) in multibody.links.iter().zip(&kinematics.states) {
            let first = link.columns.start;
            if link.kind == JointKind::Free {
                let parts = [&by_position, &by_velocity]
                    .map(|gradient| gradient.fixed_rows::<6>(first).into_owned());
                let about_center = BodyStateGradient::from_parts(parts);
                let arm = self.model().arm(link.body, state);
                self.states[link.body].add(&about_center.about(&-arm));
                self.add_by_center(link.body, state, &about_center.shift);
            }
            let mimic = link.mimic;
            let state_index = mimic.map_or(link.state_index, |mimic| {
                multibody.links[mimic.leader].state_index
            });
            if let Some(state_index) = state_index {
                let multiplier = mimic.map_or(1.0, |mimic| mimic.multiplier);
                let of_joint = |gradient: &DVector<f64>| {
                    let number = |i: usize| {
                        if i < link.columns.len() {
                            gradient[first + i] * multiplier
                        } else {
                            0.0
                        }
                    };
                    Vector3::from_fn(|i, _| number(i))
                };
                let joint = &mut self.joints[state_index];
                joint.position += of_joint(&by_position);
                joint.velocity += of_joint(&by_velocity);
            }
        }
    }

    /// Takes the gradient with respect to the state of a body, and replaces it by 0. Returns the parts with respect to a displacement about
    /// the center of mass and to the velocities.
    fn take_state_gradient(&mut self, body: usize, state: &BodyState) -> [Vector6<f64>; 2] {
        let arm = self.model().arm(body, state);
        let by_state = mem::replace(&mut self.states[body], BodyStateGradient::zero());
        by_state.about(&arm).parts()
    }

    /// Adds the gradient with respect to the position of the center of mass of a body, at a constant origin.
    pub(super) fn add_by_center(
        &mut self,
        body: usize,
        state: &BodyState,
        by_position: &Vector3<f64>,
    ) {
        self.gradient.bodies[body].center += state.pose.rotation().tr_mul(by_position);
    }
}

/// Gradient of a dot product with respect to a turn of the twist.
pub(super) fn turn_gradient(twist: &Twist, by_twist: &Vector6<f64>) -> Vector3<f64> {
    let Twist { angular, linear } = Twist::from_vector(by_twist);
    twist.angular.cross(&angular) + twist.linear.cross(&linear)
}
