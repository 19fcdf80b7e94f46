use crate::dynamics::Accuracy;
use std::ops::AddAssign;

/// What an implicit time step took.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct StepReport {
    /// Groups of bodies that were solved by themselves.
    pub islands: usize,
    /// What the solver did, all islands together.
    pub work: Work,
    /// Where the energy went, all bodies together.
    pub energy: EnergyBalance,
    /// The estimated errors of each body of the world: 0 for bodies that forces do not move, and without error control.
    pub errors: Vec<BodyErrors>,
}

/// The magnitudes of the estimated errors of a body, summed over substeps. The errors of the motion are mostly smaller, because errors
/// of different signs cancel. They are larger if the motion amplifies them.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyErrors {
    /// Of its velocity: the sum of error over tolerance, times [`Accuracy::values`].
    pub values: f64,
    /// Of the derivatives of its motion: the sum of error over tolerance, times [`Accuracy::slopes`].
    pub slopes: f64,
    /// Substeps in which one of its errors exceeds the tolerance.
    pub missed: usize,
}

impl BodyErrors {
    /// Adds the errors of values and of slopes of a substep, given relative to their tolerances. Returns whether one of them
    /// exceeds its tolerance.
    pub(super) fn add(&mut self, [values, slopes]: &[f64; 2], accuracy: &Accuracy) -> bool {
        let is_missed = values.max(*slopes) > 1.0;
        self.values += values * accuracy.values();
        self.slopes += slopes * accuracy.slopes();
        self.missed += usize::from(is_missed);
        is_missed
    }
}

/// What a solver did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Work {
    /// Substeps that were taken, of all islands.
    pub substeps: usize,
    /// Accepted substeps whose error exceeds the tolerance. Such a substep is as short as allowed, or the step is near the end of its
    /// budget ([`Accuracy`]).
    pub missed: usize,
    /// Systems of equations: one for each stage of each substep, rejected ones included, and two if the first guess does not lead to a
    /// solution.
    pub solves: usize,
    /// Evaluations of an island that has contacts, including the one at the start of a rollout. One with exact derivatives of friction
    /// and dissipation takes twice the time, and counts once.
    pub evaluations: usize,
    /// Looks at the contacts, whether anything is near or not.
    pub looks: usize,
    /// Iterations of Newton's method, most of them on contact polygons as they are.
    pub iterations: usize,
    /// Exact linearizations of an island's contacts, for the errors of its substeps.
    pub linearizations: usize,
    /// Substeps that were rejected: an error exceeded its tolerance, or bodies might have passed through each other.
    pub rejections: usize,
    /// Substeps that were repeated with a shorter duration because a system was not solved.
    pub failures: usize,
}

/// Where the energy of a step's bodies went (J).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct EnergyBalance {
    /// Change of the kinetic energy.
    pub kinetic: f64,
    /// The work of gravity and controls.
    pub given: f64,
    /// The work of contacts and other forces: of their wrenches along the motion, at the stages of the steps.
    pub acting: f64,
}

impl EnergyBalance {
    /// Work minus the change of kinetic energy: what the integrator has lost, or made if negative. The work of contacts is that at the
    /// stages, and so differs slightly from the change of their potential energy.
    #[must_use]
    pub fn numerical_loss(&self) -> f64 {
        self.given + self.acting - self.kinetic
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.solves += other.solves;
        self.evaluations += other.evaluations;
        self.looks += other.looks;
        self.iterations += other.iterations;
        self.substeps += other.substeps;
        self.missed += other.missed;
        self.linearizations += other.linearizations;
        self.rejections += other.rejections;
        self.failures += other.failures;
    }
}

impl AddAssign for EnergyBalance {
    fn add_assign(&mut self, other: Self) {
        self.kinetic += other.kinetic;
        self.given += other.given;
        self.acting += other.acting;
    }
}

impl AddAssign for StepReport {
    fn add_assign(&mut self, other: Self) {
        self.islands += other.islands;
        self.work += other.work;
        self.energy += other.energy;
        let count = self.errors.len().max(other.errors.len());
        self.errors.resize(count, BodyErrors::default());
        for (sum, errors) in self.errors.iter_mut().zip(other.errors) {
            *sum += errors;
        }
    }
}

impl AddAssign for BodyErrors {
    fn add_assign(&mut self, other: Self) {
        self.values += other.values;
        self.slopes += other.slopes;
        self.missed += other.missed;
    }
}
