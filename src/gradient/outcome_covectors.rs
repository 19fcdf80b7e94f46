//! The derivatives of a number by recorded states: given, or those of a loss by the states that it looks at.

use super::GradientError;
use super::error::check_outcome;
use super::widths::{DifferentiableOutcome, NARROW, OutcomeIn, WIDE};
use crate::dynamics::{
    BodyState, Model, ReverseSweep, STATE_DIM, State, StateGradient, Trajectory,
};
use crate::scalar::{DenseDual, Scalar, SplitMix64};
use crate::spatial::Twist;
use nalgebra::{SVector, Vector6};

/// States of a body that fit into the widest dual numbers.
const AT_ONCE: usize = WIDE / STATE_DIM;

/// The state of a body at a recorded time.
#[derive(Debug, Clone, Copy)]
struct Seen {
    record: usize,
    body: usize,
}

/// The derivatives of a number by states of bodies at recorded times, in the order of time.
pub(super) struct RecordedCovectors(Vec<(Seen, StateGradient)>);

impl RecordedCovectors {
    /// Of a number that depends on none.
    pub fn none() -> Self {
        Self(Vec::new())
    }

    /// From those by all recorded states, of all bodies each.
    pub fn new(
        by_states: Vec<Vec<StateGradient>>,
        trajectory: &Trajectory,
    ) -> Result<Self, GradientError> {
        let counts = by_states.iter().map(Vec::len);
        let expected = trajectory.states().iter().map(|state| state.bodies.len());
        if !counts.eq(expected) {
            return Err(GradientError::CovectorCount {
                found: by_states.iter().map(Vec::len).collect(),
                states: trajectory.states().len(),
                bodies: trajectory.last().bodies.len(),
            });
        }
        let of_state = |(record, bodies): (usize, Vec<StateGradient>)| {
            let bodies = bodies.into_iter().enumerate();
            bodies.map(move |(body, by_state)| (Seen { record, body }, by_state))
        };
        Ok(Self(
            by_states
                .into_iter()
                .enumerate()
                .flat_map(of_state)
                .collect(),
        ))
    }

    /// Takes out those by the recorded state `record` and later ones, and adds them to the sweep.
    pub fn add_to(&mut self, record: usize, reversal: &mut ReverseSweep) {
        while let Some((seen, by_state)) = self.0.pop_if(|(seen, _)| seen.record >= record) {
            reversal.add(seen.body, &by_state);
        }
    }
}

/// A loss, and its derivatives by the states of bodies that forces move or that stay where they are. Which of them matter is
/// found out first: by derivatives along one generic direction for many of them together.
pub(super) fn of_outcome(
    loss: &dyn DifferentiableOutcome,
    system: &Model,
    trajectory: &Trajectory,
) -> Result<(f64, RecordedCovectors), GradientError> {
    let value = OutcomeIn::<f64>::of_trajectory(loss, trajectory);
    let [value] = value[..] else {
        return Err(GradientError::NotALoss { count: value.len() });
    };
    check_outcome(&[value])?;
    let moves = |body: &usize| !system.bodies[*body].motion.is_kinematic();
    let bodies: Vec<usize> = (0..system.bodies.len()).filter(moves).collect();
    let looked = Looked {
        loss,
        trajectory,
        times: trajectory.states().iter().map(|state| state.time).collect(),
    };
    let (mut found, mut all) = (Vec::new(), Vec::new());
    for record in 0..trajectory.states().len() {
        let states: Vec<Seen> = bodies.iter().map(|&body| Seen { record, body }).collect();
        if looked.look_at_share(&states, &mut found).is_none() {
            all.extend(states);
        }
    }
    looked.look(&all, &mut found);
    // The loss may have shares of some records, and not of others.
    found.sort_by_key(|(seen, _)| seen.record);
    Ok((value, RecordedCovectors(found)))
}

/// A loss of a trajectory, to be differentiated by its states.
struct Looked<'a> {
    loss: &'a dyn DifferentiableOutcome,
    trajectory: &'a Trajectory,
    times: Vec<f64>,
}

impl Looked<'_> {
    /// Adds the derivatives by those of the states that matter to those found.
    fn look(&self, states: &[Seen], found: &mut Vec<(Seen, StateGradient)>) {
        if states.len() <= AT_ONCE {
            let slopes = self.slopes::<WIDE>(self.loss, states.iter().copied().enumerate(), seeds);
            keep(states, &slopes, found);
            return;
        }
        let size = states.len().div_ceil(NARROW);
        let parts = || states.chunks(size).enumerate();
        let members =
            parts().flat_map(|(part, members)| members.iter().map(move |&seen| (part, seen)));
        let mut direction = SplitMix64::default();
        let seeds = |part: usize| {
            let along = |slope: f64| DenseDual::<NARROW>::variable(0.0, part) * slope;
            SVector::from_fn(|_, _| along(direction.next()))
        };
        let slopes = self.slopes::<NARROW>(self.loss, members, seeds);
        for (part, members) in parts() {
            if slopes[part] != 0.0 {
                self.look(members, found);
            }
        }
    }

    /// [`Self::look`] for states of one record, by the share of that record in the loss; none if the loss has no such shares.
    fn look_at_share(&self, states: &[Seen], found: &mut Vec<(Seen, StateGradient)>) -> Option<()> {
        let loss: &dyn OutcomeIn<DenseDual<WIDE>> = self.loss;
        for states in states.chunks(AT_ONCE) {
            let record = states[0].record;
            let mut state = self.trajectory.states()[record].lifted();
            for (place, seen) in states.iter().enumerate() {
                displace(&mut state, seen.body, &seeds(place));
            }
            let numbers = loss.share_of(&self.times, record, &state)?;
            keep(states, &numbers.first()?.eps, found);
        }
        Some(())
    }

    /// The derivatives of the loss, where the states in a list are seeded.
    fn slopes<const WIDTH: usize>(
        &self,
        loss: &dyn OutcomeIn<DenseDual<WIDTH>>,
        states: impl Iterator<Item = (usize, Seen)>,
        mut seeds: impl FnMut(usize) -> SVector<DenseDual<WIDTH>, STATE_DIM>,
    ) -> [f64; WIDTH] {
        let mut trajectory = self.trajectory.lifted();
        for (place, Seen { record, body }) in states {
            displace(trajectory.state_mut(record), body, &seeds(place));
        }
        let numbers = loss.of_trajectory(&trajectory);
        numbers.first().map_or([0.0; WIDTH], |number| number.eps)
    }
}

/// Seeds for the state of one body among several.
fn seeds(place: usize) -> SVector<DenseDual<WIDE>, STATE_DIM> {
    SVector::from_fn(|i, _| DenseDual::variable(0.0, STATE_DIM * place + i))
}

/// Keeps the derivatives by states, seeded one after the other, that are not all zero.
fn keep(states: &[Seen], slopes: &[f64; WIDE], found: &mut Vec<(Seen, StateGradient)>) {
    for (place, &seen) in states.iter().enumerate() {
        let by_state = SVector::<f64, STATE_DIM>::from_fn(|i, _| slopes[STATE_DIM * place + i]);
        if by_state.iter().any(|&slope| slope != 0.0) {
            found.push((seen, StateGradient::from_vector(&by_state)));
        }
    }
}

/// Displaces the state of a body by numbers with real part zero.
fn displace<T: Scalar>(state: &mut State<T>, body: usize, change: &SVector<T, STATE_DIM>) {
    let part = |row: usize| -> Vector6<T> { change.fixed_rows::<6>(row).into_owned() };
    let BodyState { pose, twist } = &mut state.bodies[body];
    *pose = pose.moved_by(&Twist::from_vector(&part(0)));
    *twist = Twist::from_vector(&(twist.to_vector() + part(6)));
}
