//! Derivatives of a scalar with respect to recorded states: passed in by the caller, or computed for a loss.

use super::GradientError;
use super::dual_widths::{DifferentiableOutcome, NARROW, OutcomeIn, WIDE};
use super::error::{check_outcome, loss_of};
use crate::dynamics::{
    BodyState, BodyStateGradient, JointStateGradient, Model, ReverseSweep, STATE_DIM, State,
    StateGradient, Trajectory,
};
use crate::scalar::{DenseDual, Scalar, SplitMix64};
use crate::spatial::Twist;
use nalgebra::{SVector, Vector6};

/// Number of body states that the widest dual numbers can seed at once.
const BODIES_PER_PASS: usize = WIDE / STATE_DIM;

/// Reference to the state of a body or of a joint at a recorded time.
#[derive(Debug, Clone, Copy)]
struct StateRef {
    record: usize,
    /// Index of a body, or number of bodies plus index of a joint.
    part: usize,
}

/// Derivatives of a scalar with respect to recorded states of bodies and joints, in the order of time. The fields `turn` and `spin` contain
/// the derivatives with respect to a joint.
pub(super) struct RecordedCovectors(Vec<(StateRef, BodyStateGradient)>);

impl RecordedCovectors {
    /// Creates the derivatives of a scalar that depends on no state.
    pub fn zero() -> Self {
        Self(Vec::new())
    }

    /// Creates the derivatives from one [`StateGradient`] for each recorded state.
    ///
    /// # Errors
    /// [`GradientError::CovectorCount`] if a count does not match.
    pub fn new(
        by_states: &[StateGradient],
        trajectory: &Trajectory,
    ) -> Result<Self, GradientError> {
        let found: Vec<[usize; 2]> = by_states
            .iter()
            .map(|by_state| [by_state.bodies.len(), by_state.joints.len()])
            .collect();
        let states = trajectory.states();
        let expected = states
            .iter()
            .map(|state| [state.bodies.len(), state.joints.len()]);
        if !found.iter().copied().eq(expected) {
            return Err(GradientError::CovectorCount {
                found,
                states: states.len(),
                bodies: trajectory.last().bodies.len(),
                joints: trajectory.last().joints.len(),
            });
        }
        let of_state = |(record, by_state): (usize, &StateGradient)| {
            let joints = by_state.joints.iter().map(JointStateGradient::as_body);
            let parts = by_state.bodies.iter().copied().chain(joints).enumerate();
            let of_part = |(part, by_part)| (StateRef { record, part }, by_part);
            parts.map(of_part).collect::<Vec<_>>()
        };
        let covectors = by_states.iter().enumerate().flat_map(of_state);
        Ok(Self(covectors.collect()))
    }

    /// Removes the derivatives with respect to the recorded state `record` and later states, and adds them to the reverse sweep.
    pub fn add_to(&mut self, record: usize, reversal: &mut ReverseSweep) {
        while let Some((state_ref, by_state)) =
            self.0.pop_if(|(state_ref, _)| state_ref.record >= record)
        {
            reversal.add(state_ref.part, &by_state);
        }
    }
}

/// Loss and its derivatives with respect to the recorded states of all joints and of all bodies except kinematic bodies.
///
/// Most losses depend on few states. Derivatives along one random direction per group of states first exclude the groups without
/// effect.
pub(super) fn loss_covectors(
    loss: &dyn DifferentiableOutcome,
    model: &Model,
    trajectory: &Trajectory,
) -> Result<(f64, RecordedCovectors), GradientError> {
    let value = loss_of(&OutcomeIn::<f64>::of_trajectory(loss, trajectory))?;
    check_outcome(&[value])?;
    let is_differentiable = |body: &usize| !model.bodies[*body].motion.is_kinematic();
    let bodies = (0..model.bodies.len()).filter(is_differentiable);
    let joints = (0..model.joint_count()).map(|joint| model.bodies.len() + joint);
    let parts: Vec<usize> = bodies.chain(joints).collect();
    let dependence = LossDependence {
        loss,
        trajectory,
        times: trajectory.states().iter().map(|state| state.time).collect(),
    };
    let (mut covectors, mut remaining) = (Vec::new(), Vec::new());
    for record in 0..trajectory.states().len() {
        let states: Vec<StateRef> = parts
            .iter()
            .map(|&part| StateRef { record, part })
            .collect();
        if dependence.add_from_share(&states, &mut covectors).is_none() {
            remaining.extend(states);
        }
    }
    dependence.add_from_trajectory(&remaining, &mut covectors);
    // The loss may return shares for some records only.
    covectors.sort_by_key(|(state_ref, _)| state_ref.record);
    Ok((value, RecordedCovectors(covectors)))
}

/// A loss and the trajectory whose states it is differentiated with respect to.
struct LossDependence<'a> {
    loss: &'a dyn DifferentiableOutcome,
    trajectory: &'a Trajectory,
    times: Vec<f64>,
}

impl LossDependence<'_> {
    /// Appends the nonzero derivatives with respect to states. Evaluates the loss on the whole trajectory.
    fn add_from_trajectory(
        &self,
        states: &[StateRef],
        covectors: &mut Vec<(StateRef, BodyStateGradient)>,
    ) {
        if states.len() <= BODIES_PER_PASS {
            let slopes = self.slopes::<WIDE>(self.loss, states.iter().copied().enumerate(), seeds);
            push_nonzero(states, &slopes, covectors);
            return;
        }
        let group_size = states.len().div_ceil(NARROW);
        let groups = || states.chunks(group_size).enumerate();
        let members = groups()
            .flat_map(|(group, members)| members.iter().map(move |&state_ref| (group, state_ref)));
        let mut direction = SplitMix64::default();
        let seeds = |group: usize| {
            let along = |component: f64| DenseDual::<NARROW>::variable(0.0, group) * component;
            SVector::from_fn(|_, _| along(direction.next()))
        };
        let slopes = self.slopes::<NARROW>(self.loss, members, seeds);
        for (group, members) in groups() {
            if slopes[group] != 0.0 {
                self.add_from_trajectory(members, covectors);
            }
        }
    }

    /// [`Self::add_from_trajectory`] for states of one record, which evaluates only the share of
    /// this record in the loss. Returns `None` if the loss has no share of this record.
    fn add_from_share(
        &self,
        states: &[StateRef],
        covectors: &mut Vec<(StateRef, BodyStateGradient)>,
    ) -> Option<()> {
        let loss: &dyn OutcomeIn<DenseDual<WIDE>> = self.loss;
        for states in states.chunks(BODIES_PER_PASS) {
            let record = states[0].record;
            let mut state = self.trajectory.states()[record].lifted();
            for (index, state_ref) in states.iter().enumerate() {
                displace(&mut state, state_ref.part, &seeds(index));
            }
            let numbers = loss.share_of(&self.times, record, &state)?;
            push_nonzero(states, &numbers.first()?.eps, covectors);
        }
        Some(())
    }

    /// Derivatives of the loss if the listed states are seeded. Each state is paired with the index that `seeds` gets.
    fn slopes<const WIDTH: usize>(
        &self,
        loss: &dyn OutcomeIn<DenseDual<WIDTH>>,
        states: impl Iterator<Item = (usize, StateRef)>,
        mut seeds: impl FnMut(usize) -> SVector<DenseDual<WIDTH>, STATE_DIM>,
    ) -> [f64; WIDTH] {
        let mut trajectory = self.trajectory.lifted();
        for (index, StateRef { record, part }) in states {
            displace(trajectory.state_mut(record), part, &seeds(index));
        }
        let numbers = loss.of_trajectory(&trajectory);
        numbers.first().map_or([0.0; WIDTH], |number| number.eps)
    }
}

/// Seeds of the body state with this index among the states of a pass.
fn seeds(index: usize) -> SVector<DenseDual<WIDE>, STATE_DIM> {
    SVector::from_fn(|i, _| DenseDual::variable(0.0, STATE_DIM * index + i))
}

/// Appends the nonzero derivatives with respect to consecutively seeded states.
fn push_nonzero(
    states: &[StateRef],
    slopes: &[f64; WIDE],
    covectors: &mut Vec<(StateRef, BodyStateGradient)>,
) {
    for (index, &state_ref) in states.iter().enumerate() {
        let by_state = SVector::<f64, STATE_DIM>::from_fn(|i, _| slopes[STATE_DIM * index + i]);
        if by_state.iter().any(|&slope| slope != 0.0) {
            covectors.push((state_ref, BodyStateGradient::from_vector(&by_state)));
        }
    }
}

/// Adds a tangent-space change, whose real part is zero, to the state of a body or of a joint.
fn displace<T: Scalar>(state: &mut State<T>, part_index: usize, change: &SVector<T, STATE_DIM>) {
    if let Some(joint) = part_index.checked_sub(state.bodies.len()) {
        let part = |row: usize| change.fixed_rows::<3>(row).into_owned();
        return state.joints[joint].displace(&part(0), &part(6));
    }
    let part = |row: usize| -> Vector6<T> { change.fixed_rows::<6>(row).into_owned() };
    let BodyState { pose, twist } = &mut state.bodies[part_index];
    *pose = pose.moved_by(&Twist::from_vector(&part(0)));
    *twist = Twist::from_vector(&(twist.to_vector() + part(6)));
}
