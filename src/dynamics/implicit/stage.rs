//! One implicit stage: the velocities u of the bodies of an island that solve
//!
//! P(q̃ ⊕ τu, u) = p̃ + τ f(q̃ ⊕ τu, u, t).
//!
//! Here q̃ and p̃ are the poses and momenta at the start, τ is the duration, and f are all wrenches about the centers of mass. The equation
//! is between momenta P, not velocities, so it needs no gyroscopic term, and free bodies keep their momentum.

use super::island_step::{IslandStep, StepError};
use super::scheme::Stage;
use crate::dynamics::{BodyState, Inertia};
use crate::scalar::{Scalar, real_part};
use crate::spatial::{Pose, Twist};
use nalgebra::{DVector, Vector6};

/// Start of a stage.
#[derive(Clone)]
pub(in crate::dynamics) struct StageStart<T = f64> {
    /// Displacements of the dynamic bodies (turn and shift about the center of mass) since the start of the substep.
    pub displacements: Vec<Vector6<T>>,
    /// q̃ of the dynamic bodies.
    pub poses: Vec<Pose<T>>,
    /// p̃ (N m s, N s) of the dynamic bodies.
    pub momenta: Vec<Vector6<T>>,
    /// τ (s).
    pub duration: f64,
    /// Time (s) at which the wrenches of the stage act.
    pub time: f64,
}

/// Equations of a stage of an island, in the scalar of a pass: see the module.
pub(super) struct StageEquations<'a, T = f64> {
    pub step: &'a IslandStep<'a>,
    /// Inertias of the dynamic bodies.
    pub inertias: &'a [&'a Inertia<T>],
    /// Weight and control of each body of the world.
    pub applied: &'a [Vector6<T>],
    pub start: StageStart<T>,
    /// States of the neighbors at the time of the stage.
    pub neighbors: Vec<BodyState<T>>,
}

/// Stages of a substep, in the scalar of a pass. The start of each stage follows from the rates of the earlier stages.
///
/// The real pass, the derivative pass and the reverse sweep take poses, momenta and times from this type. A different order of these sums
/// would change the last bit, which can decide whether a switched force acts.
pub(super) struct Stages<'a, T = f64> {
    pub step: &'a IslandStep<'a>,
    inertias: &'a [&'a Inertia<T>],
    offset: f64,
    /// The dynamic bodies at the start of the substep.
    pub from: Vec<BodyState<T>>,
    momenta: Vec<Vector6<T>>,
    rates: Vec<StageRates<T>>,
}

/// Velocities of the dynamic bodies, and the wrenches on them, in a stage.
pub(super) struct StageRates<T = f64> {
    pub velocities: Vec<Vector6<T>>,
    pub wrenches: Vec<Vector6<T>>,
}

impl<T: Scalar> StageEquations<'_, T> {
    /// States of all participants at the end of the stage, from the velocities of each dynamic body.
    pub fn states_with(&self, velocities: impl Fn(usize) -> Vector6<T>) -> Vec<BodyState<T>> {
        let moved = self.start.poses.iter().enumerate().map(|(index, pose)| {
            let velocities_of_body = velocities(index);
            let displacement = velocities_of_body.map(|number| number * self.start.duration);
            BodyState {
                pose: self.inertias[index].displaced(pose, &displacement),
                twist: Twist::from_vector(&velocities_of_body),
            }
        });
        moved.chain(self.neighbors.iter().copied()).collect()
    }

    /// Residual P − p̃ − τf of each dynamic body, from the states and the wrenches of contacts and forces at the end.
    pub fn residual(&self, states: &[BodyState<T>], wrenches: &[Vector6<T>]) -> Vec<Vector6<T>> {
        let of_body = |index: usize| {
            let force = self.applied_wrench(index) + wrenches[index];
            let impulse = force.map(|number| number * self.start.duration);
            self.inertias[index].momentum(&states[index]) - self.start.momenta[index] - impulse
        };
        (0..self.inertias.len()).map(of_body).collect()
    }

    /// Gravity and controls on a dynamic body.
    pub fn applied_wrench(&self, index: usize) -> Vector6<T> {
        self.applied[self.step.island.dynamic[index]]
    }

    /// The equations without derivatives.
    pub fn real(&self) -> StageEquations<'_> {
        let real = |vectors: &[Vector6<T>]| vectors.iter().map(|six| six.map(real_part)).collect();
        let StageStart {
            displacements,
            poses,
            momenta,
            duration,
            time,
        } = &self.start;
        StageEquations {
            step: self.step,
            inertias: &self.step.inertias,
            applied: &self.step.context.applied,
            start: StageStart {
                displacements: real(displacements),
                poses: poses.iter().map(Pose::real).collect(),
                momenta: real(momenta),
                duration: *duration,
                time: *time,
            },
            neighbors: self.neighbors.iter().map(BodyState::real).collect(),
        }
    }
}

impl<'a> StageEquations<'a> {
    /// Equations in `f64`.
    pub fn new(step: &'a IslandStep<'a>, start: StageStart) -> Self {
        Self {
            step,
            inertias: &step.inertias,
            applied: &step.context.applied,
            neighbors: step.context.neighbors_at(step.island, start.time),
            start,
        }
    }
}

impl IslandStep<'_> {
    /// Equations of a stage in `f64`.
    ///
    /// # Errors
    /// If the path of a neighbor is not finite.
    pub(super) fn equations(&self, start: StageStart) -> Result<StageEquations<'_>, StepError> {
        let equations = StageEquations::new(self, start);
        let lost = equations
            .neighbors
            .iter()
            .position(|state| !state.is_finite());
        match lost {
            Some(index) => Err(StepError::Path {
                body: self.island.neighbors[index],
                time: equations.start.time,
            }),
            None => Ok(equations),
        }
    }
}

impl<'a, T: Scalar> Stages<'a, T> {
    /// Stages of a substep that begins at an offset (s) from the start of the step.
    pub fn new(
        step: &'a IslandStep<'a>,
        inertias: &'a [&'a Inertia<T>],
        offset: f64,
        from: Vec<BodyState<T>>,
    ) -> Self {
        let bodies = inertias.iter().zip(&from);
        Self {
            step,
            inertias,
            offset,
            momenta: bodies
                .map(|(inertia, state)| inertia.momentum(state))
                .collect(),
            from,
            rates: Vec::new(),
        }
    }

    /// Start of the next stage.
    pub fn start(&self, stage: &Stage) -> StageStart<T> {
        let indices = 0..self.from.len();
        let displacements: Vec<_> = indices
            .clone()
            .map(|i| stage.accumulated(self.rates.iter().map(|rates| rates.velocities[i])))
            .collect();
        let impulse =
            |i: usize| stage.accumulated(self.rates.iter().map(|rates| rates.wrenches[i]));
        StageStart {
            poses: indices
                .clone()
                .map(|i| self.inertias[i].displaced(&self.from[i].pose, &displacements[i]))
                .collect(),
            momenta: indices.map(|i| self.momenta[i] + impulse(i)).collect(),
            displacements,
            duration: stage.duration,
            time: self.step.start + (self.offset + stage.offset),
        }
    }

    /// Adds the rates of a stage, from its start and the states at its end.
    pub fn push(&mut self, start: &StageStart<T>, states: &[BodyState<T>]) -> &StageRates<T> {
        let per_duration = start.duration.recip();
        let bodies = self.inertias.iter().zip(states).zip(&start.momenta);
        let wrenches = bodies.map(|((inertia, state), momentum)| {
            (inertia.momentum(state) - momentum).map(|number| number * per_duration)
        });
        let rates = StageRates {
            velocities: states[..self.from.len()]
                .iter()
                .map(|state| state.twist.to_vector())
                .collect(),
            wrenches: wrenches.collect(),
        };
        self.rates.push(rates);
        &self.rates[self.rates.len() - 1]
    }

    /// Rates of the stages so far.
    pub fn rates(&self) -> &[StageRates<T>] {
        &self.rates
    }
}

/// Six numbers of one body in the vector of all bodies.
pub(super) fn six_of(vector: &DVector<f64>, index: usize) -> Vector6<f64> {
    vector.fixed_rows::<6>(6 * index).into_owned()
}

/// Vector of the six numbers of all bodies.
pub(super) fn concatenated(bodies: impl IntoIterator<Item = Vector6<f64>>) -> DVector<f64> {
    let mut numbers = Vec::new();
    for six in bodies {
        numbers.extend_from_slice(six.as_slice());
    }
    DVector::from_vec(numbers)
}
