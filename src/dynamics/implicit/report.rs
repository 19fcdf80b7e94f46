use crate::dynamics::Accuracy;
use std::ops::AddAssign;

/// Report of an implicit time step.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct StepReport {
    /// Number of islands: groups of bodies that were solved separately.
    pub islands: usize,
    /// Work of the solver, summed over all islands.
    pub work: Work,
    /// Energy balance, summed over all bodies.
    pub energy: EnergyBalance,
    /// Estimated errors of each body of the world. They are 0 for bodies that are not dynamic, and without error control.
    pub errors: Vec<BodyErrors>,
}

/// Magnitudes of the estimated errors of a body, summed over substeps. The errors of the motion are
/// usually smaller, because errors of different signs cancel. They are larger if the motion
/// amplifies errors.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BodyErrors {
    /// Error of the velocity: the sum of error divided by tolerance, times [`Accuracy::values`].
    pub values: f64,
    /// Error of the derivatives of the motion: the sum of error divided by tolerance, times
    /// [`Accuracy::slopes`].
    pub slopes: f64,
    /// Number of substeps in which an error of the body exceeds its tolerance.
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

/// Work of a solver.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Work {
    /// Number of accepted substeps of all islands.
    pub substeps: usize,
    /// Number of accepted substeps whose error exceeds the tolerance. Such a substep is as short as allowed, or the step is near the end of
    /// its budget ([`Accuracy`]).
    pub missed: usize,
    /// Number of systems of equations: one for each stage of each substep, including rejected substeps. A stage counts twice if its first
    /// guess does not lead to a solution.
    pub solves: usize,
    /// Number of evaluations of an island that has contacts, including the evaluation at the start of a rollout. An evaluation with exact
    /// derivatives of friction and dissipation takes twice the time, and counts once.
    pub evaluations: usize,
    /// Number of contact queries, including queries that find no contact.
    pub looks: usize,
    /// Number of iterations of Newton's method. Most of them use frozen contact polygons.
    pub iterations: usize,
    /// Number of exact linearizations of the contacts of an island, for error estimates.
    pub linearizations: usize,
    /// Number of substeps that were rejected because an error exceeded its tolerance, or because
    /// bodies might have passed through each other.
    pub rejections: usize,
    /// Number of substeps that were repeated with a shorter duration because a system was not solved.
    pub failures: usize,
}

/// Energy balance of the bodies in a step (J).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct EnergyBalance {
    /// Change of the kinetic energy.
    pub kinetic: f64,
    /// Work of gravity and controls.
    pub given: f64,
    /// Work of contacts, other forces and loop joints: of their wrenches along the motion, at the stages of the steps.
    pub acting: f64,
}

impl EnergyBalance {
    /// Energy (J) that the integrator has lost, or created if negative: work minus the change of kinetic energy. The work of contacts is
    /// evaluated at the stages, so it differs slightly from the change of their potential energy.
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
