//! Normal equations of the measurements, and their Schur complement.
//!
//! The equations of a measurement with the shared coordinates θ and its own coordinates x are
//!
//! | A  C | |δθ|     |g|
//! | Cᵀ B | |δx| = − |h|
//!
//! Elimination of x leaves (A − C B⁻¹ Cᵀ) δθ = −(g − C B⁻¹ h). These reduced equations of all measurements are added.

use super::RobustLoss;
use super::coordinates::Coordinates;
use super::deviations::PER_POSE;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Smallest diagonal entry of a damped matrix, relative to the largest.
const SMALLEST_DIAGONAL: f64 = 1e-12;

/// Quadratic model of a cost: gradient and Gauss–Newton matrix.
#[derive(Debug, Clone)]
pub(super) struct Quadratic {
    pub gradient: DVector<f64>,
    pub matrix: DMatrix<f64>,
}

/// Cost of one measurement, and its quadratic model in the shared coordinates and in its own.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    pub cost: f64,
    pub shared: Quadratic,
    pub own: Quadratic,
    /// C: rows for the shared coordinates, columns for its own.
    pub coupling: DMatrix<f64>,
}

/// Change of all coordinates that the damped equations give.
pub(super) struct Step {
    pub shared: DVector<f64>,
    pub own: Vec<DVector<f64>>,
    /// Decrease of the cost that the quadratic model predicts.
    pub predicted_decrease: f64,
}

impl Quadratic {
    /// Adds the priors of coordinates. Returns their cost.
    pub fn add_priors(&mut self, coordinates: &Coordinates, at: &DVector<f64>) -> f64 {
        let mut cost = 0.0;
        for (index, prior) in coordinates.priors().enumerate() {
            let Some([mean, deviation]) = prior else {
                continue;
            };
            let weight = 1.0 / (deviation * deviation);
            let away = at[index] - mean;
            cost += 0.5 * weight * away * away;
            self.gradient[index] += weight * away;
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

    /// Decrease of the model for a step.
    fn decrease(&self, step: &DVector<f64>) -> f64 {
        -self.gradient.dot(step) - 0.5 * step.dot(&(&self.matrix * step))
    }
}

impl Equations {
    /// Equations for deviations and their derivatives with respect to shared and own coordinates. The loss weights each pose.
    pub fn new(
        loss: RobustLoss,
        deviations: &DVector<f64>,
        by_shared: &DMatrix<f64>,
        by_own: &DMatrix<f64>,
    ) -> Self {
        let mut weights = DVector::zeros(deviations.len());
        let mut cost = 0.0;
        for pose in 0..deviations.len() / PER_POSE {
            let squared = deviations.rows(pose * PER_POSE, PER_POSE).norm_squared();
            let [loss, weight] = loss.at(squared);
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
        let [shared, own] = [weighted(by_shared), weighted(by_own)];
        Self {
            cost,
            shared: Quadratic {
                gradient: shared.tr_mul(deviations),
                matrix: shared.tr_mul(by_shared),
            },
            coupling: shared.tr_mul(by_own),
            own: Quadratic {
                gradient: own.tr_mul(deviations),
                matrix: own.tr_mul(by_own),
            },
        }
    }

    /// Reduced equations of the shared coordinates, with the own coordinates damped and eliminated. `None` if the equations of the own
    /// coordinates are singular.
    pub fn reduced(&self, damping: f64) -> Option<Quadratic> {
        let factor = damped(&self.own.matrix, damping)?;
        Some(Quadratic {
            gradient: &self.shared.gradient - &self.coupling * factor.solve(&self.own.gradient),
            matrix: &self.shared.matrix - &self.coupling * factor.solve(&self.coupling.transpose()),
        })
    }

    /// Step of the own coordinates for a step of the shared coordinates.
    fn own_step(&self, shared: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
        let factor = damped(&self.own.matrix, damping)?;
        Some(-factor.solve(&(&self.own.gradient + self.coupling.tr_mul(shared))))
    }

    /// Decrease of the quadratic model for a step.
    fn decrease(&self, shared: &DVector<f64>, own: &DVector<f64>) -> f64 {
        self.shared.decrease(shared) + self.own.decrease(own) - shared.dot(&(&self.coupling * own))
    }
}

impl Step {
    /// Solves the damped equations of all measurements with the priors of the shared coordinates. `None` if they are singular.
    pub fn new(equations: &[Equations], priors: &Quadratic, damping: f64) -> Option<Self> {
        let mut reduced = priors.clone();
        let mut diagonal = priors.matrix.diagonal();
        for measurement in equations {
            reduced.add(&measurement.reduced(damping)?);
            diagonal += measurement.shared.matrix.diagonal();
        }
        let floor = SMALLEST_DIAGONAL * diagonal.max();
        for (index, &entry) in diagonal.iter().enumerate() {
            reduced.matrix[(index, index)] += damping * entry.max(floor);
        }
        let shared = if reduced.gradient.is_empty() {
            DVector::zeros(0)
        } else {
            -Cholesky::new(reduced.matrix)?.solve(&reduced.gradient)
        };
        let own = equations
            .iter()
            .map(|measurement| measurement.own_step(&shared, damping));
        let own = own.collect::<Option<Vec<_>>>()?;
        let decreases = equations
            .iter()
            .zip(&own)
            .map(|(measurement, own)| measurement.decrease(&shared, own));
        let predicted_decrease = priors.decrease(&shared) + decreases.sum::<f64>();
        Some(Self {
            shared,
            own,
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
