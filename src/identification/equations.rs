//! Normal equations of the measurements, and their Schur complement.
//!
//! The equations of a measurement with the shared coordinates θ and its local coordinates x are
//!
//! | A  C | |δθ|     |g|
//! | Cᵀ B | |δx| = − |h|
//!
//! Elimination of x leaves (A − C B⁻¹ Cᵀ) δθ = −(g − C B⁻¹ h). These reduced equations of all measurements are added.

use super::RobustLoss;
use super::coordinates::Coordinates;
use super::deviations::PER_POSE;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Smallest diagonal entry that scales the damping of the shared coordinates, relative to the largest entry.
const DAMPING_FLOOR: f64 = 1e-12;

/// Quadratic model of a cost: gradient and Gauss–Newton matrix.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct QuadraticModel {
    pub gradient: DVector<f64>,
    pub matrix: DMatrix<f64>,
}

/// Cost of one measurement, and its quadratic model in the coordinates of the unknowns and of its nuisances. The memory is proportional to
/// the square of the number of these coordinates, and does not depend on the number of states.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Equations {
    pub(super) cost: f64,
    /// Model in the shared coordinates.
    pub(super) shared: QuadraticModel,
    /// Model in the coordinates of the nuisances.
    pub(super) local: QuadraticModel,
    /// C: rows for the shared coordinates, columns for its own.
    pub(super) coupling: DMatrix<f64>,
}

/// Solution of the damped equations: changes of all coordinates.
pub(super) struct Step {
    pub shared: DVector<f64>,
    pub local: Vec<DVector<f64>>,
    /// Decrease of the cost that the quadratic model predicts.
    pub predicted_decrease: f64,
}

impl QuadraticModel {
    /// Adds the priors of coordinates. Returns their cost.
    pub fn add_priors(&mut self, coordinates: &Coordinates, at: &DVector<f64>) -> f64 {
        let mut cost = 0.0;
        for (index, prior) in coordinates.priors().enumerate() {
            let Some([mean, deviation]) = prior else {
                continue;
            };
            let weight = 1.0 / (deviation * deviation);
            let offset = at[index] - mean;
            cost += 0.5 * weight * offset * offset;
            self.gradient[index] += weight * offset;
            self.matrix[(index, index)] += weight;
        }
        cost
    }

    /// Zero model of `count` coordinates.
    pub fn zeros(count: usize) -> Self {
        Self {
            gradient: DVector::zeros(count),
            matrix: DMatrix::zeros(count, count),
        }
    }

    /// Adds another model.
    pub fn add(&mut self, other: &Self) {
        self.gradient += &other.gradient;
        self.matrix += &other.matrix;
    }

    /// Decrease of the model along a step.
    fn decrease(&self, step: &DVector<f64>) -> f64 {
        -self.gradient.dot(step) - 0.5 * step.dot(&(&self.matrix * step))
    }
}

impl Equations {
    /// Equations for deviations and their derivatives with respect to shared and local coordinates. The loss weights each pose.
    pub(super) fn new(
        loss: RobustLoss,
        deviations: &DVector<f64>,
        by_shared: &DMatrix<f64>,
        by_local: &DMatrix<f64>,
    ) -> Self {
        let mut weights = DVector::zeros(deviations.len());
        let mut cost = 0.0;
        for (pose, [loss, weight]) in loss.of_poses(deviations.as_slice()).enumerate() {
            cost += 0.5 * loss;
            weights.rows_mut(pose * PER_POSE, PER_POSE).fill(weight);
        }
        let weighted = |matrix: &DMatrix<f64>| {
            let mut weighted = matrix.clone();
            for mut column in weighted.column_iter_mut() {
                column.component_mul_assign(&weights);
            }
            weighted
        };
        let [shared, local] = [weighted(by_shared), weighted(by_local)];
        Self {
            cost,
            shared: QuadraticModel {
                gradient: shared.tr_mul(deviations),
                matrix: shared.tr_mul(by_shared),
            },
            coupling: shared.tr_mul(by_local),
            local: QuadraticModel {
                gradient: local.tr_mul(deviations),
                matrix: local.tr_mul(by_local),
            },
        }
    }

    /// Reduced equations of the shared coordinates, with the local coordinates damped and eliminated. `None` if the equations of the local
    /// coordinates are singular.
    pub(super) fn reduced(&self, damping: f64) -> Option<QuadraticModel> {
        let factor = damped(&self.local.matrix, damping)?;
        Some(QuadraticModel {
            gradient: &self.shared.gradient - &self.coupling * factor.solve(&self.local.gradient),
            matrix: &self.shared.matrix - &self.coupling * factor.solve(&self.coupling.transpose()),
        })
    }

    /// Step of the local coordinates for a step of the shared coordinates.
    fn local_step(&self, shared: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
        let factor = damped(&self.local.matrix, damping)?;
        Some(-factor.solve(&(&self.local.gradient + self.coupling.tr_mul(shared))))
    }

    /// Decrease of the quadratic model along a step.
    fn decrease(&self, shared: &DVector<f64>, local: &DVector<f64>) -> f64 {
        self.shared.decrease(shared) + self.local.decrease(local)
            - shared.dot(&(&self.coupling * local))
    }
}

impl Step {
    /// Solves the damped equations of all measurements with the priors of the shared coordinates. `None` if they are singular.
    pub fn new(equations: &[Equations], priors: &QuadraticModel, damping: f64) -> Option<Self> {
        let mut reduced = priors.clone();
        let mut diagonal = priors.matrix.diagonal();
        for measurement in equations {
            reduced.add(&measurement.reduced(damping)?);
            diagonal += measurement.shared.matrix.diagonal();
        }
        // Without any information, each gradient is zero and each step, too.
        let largest = Some(diagonal.max()).filter(|&largest| largest > 0.0);
        let floor = DAMPING_FLOOR * largest.unwrap_or(1.0);
        for (index, &entry) in diagonal.iter().enumerate() {
            reduced.matrix[(index, index)] += damping * entry.max(floor);
        }
        let shared = if reduced.gradient.is_empty() {
            DVector::zeros(0)
        } else {
            -Cholesky::new(reduced.matrix)?.solve(&reduced.gradient)
        };
        let local = equations
            .iter()
            .map(|measurement| measurement.local_step(&shared, damping));
        let local = local.collect::<Option<Vec<_>>>()?;
        let decreases = equations
            .iter()
            .zip(&local)
            .map(|(measurement, local)| measurement.decrease(&shared, local));
        let predicted_decrease = priors.decrease(&shared) + decreases.sum::<f64>();
        Some(Self {
            shared,
            local,
            predicted_decrease,
        })
    }
}

/// Cholesky factor of a matrix with a multiple of its diagonal added. `None` if the sum is not positive definite.
fn damped(matrix: &DMatrix<f64>, damping: f64) -> Option<Cholesky<f64, Dyn>> {
    let mut damped = matrix.clone();
    for index in 0..matrix.nrows() {
        damped[(index, index)] *= 1.0 + damping;
    }
    Cholesky::new(damped)
}
