use super::Checkpoint;
use super::coordinates::Coordinates;
use super::minimizer::{FittedMeasurement, Minimizer, Termination};
use nalgebra::{DMatrix, SymmetricEigen};
use std::fmt;

/// Half-width of a 95 % interval in standard deviations of a normal distribution.
const NORMAL_QUANTILE: f64 = 1.959_963_984_540_054;
/// Smallest weight of an unknown that the text of a direction lists.
const SMALLEST_LISTED_WEIGHT: f64 = 0.1;

/// Result of an identification. With the feature `serde`, it can be serialized, but not as JSON, because numbers may be infinite.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Fit {
    /// Estimates of the unknowns, in their order.
    pub estimates: Vec<Estimate>,
    /// Covariance of the coordinates of the unknowns, for noise with the stated deviations and a correct model. It is the inverse of the
    /// Gauss–Newton matrix, with the nuisances eliminated. An unknown that does not change the residuals has an infinite variance, and
    /// covariances of 0. If the matrix of the other unknowns is singular, all their variances and covariances are infinite.
    pub covariance: DMatrix<f64>,
    /// Covariance of the coordinates from the spread between measurements (sandwich estimator). It remains valid if the model is only
    /// approximate or the deviations of the noise are not known, and needs many more measurements than unknowns.
    pub sandwich_covariance: DMatrix<f64>,
    /// Principal directions of the information about the coordinates, the least known first.
    pub directions: Vec<Direction>,
    /// Results for each measurement, in their order.
    pub measurements: Vec<FittedMeasurement>,
    /// Cost at the estimates, in units of ½χ²: see the [module](super).
    pub cost: f64,
    /// Number of iterations, over all horizons.
    pub iterations: usize,
    /// Reason why the fit of the last horizon ended.
    pub termination: Termination,
    /// Coordinates at the estimates.
    pub checkpoint: Checkpoint,
}

/// Estimate of an unknown.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Estimate {
    /// Name of the unknown.
    pub name: String,
    /// Value.
    pub value: f64,
    /// 95 % interval of the value, from [`Fit::covariance`]. Its ends are infinite, or bounds of the unknown, if the variance is infinite.
    pub interval: [f64; 2],
    /// 95 % interval of the value, from [`Fit::sandwich_covariance`].
    pub sandwich_interval: [f64; 2],
}

/// Principal direction of the information about the coordinates of the unknowns.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Direction {
    /// Standard deviation along the direction (unit of the coordinates). Infinity if the data do not determine the direction.
    /// For logarithmic unknowns, a deviation of 1 is an uncertainty by a factor of e.
    pub standard_deviation: f64,
    /// Names of the unknowns, with the components of the unit vector along the direction.
    pub weights: Vec<(String, f64)>,
}

impl Fit {
    /// Estimates with their uncertainty, at the end of a minimization.
    pub(super) fn new(unknowns: &Coordinates, end: Minimizer, termination: Termination) -> Self {
        let names: Vec<String> = unknowns.names().map(str::to_owned).collect();
        let mut information = end.priors.matrix.clone();
        let mut spread = DMatrix::zeros(names.len(), names.len());
        for reduced in end.equations.iter().filter_map(|at| at.reduced(0.0)) {
            information += reduced.matrix;
            spread += &reduced.gradient * reduced.gradient.transpose();
        }
        let [covariance, sandwich_covariance] = covariances(&information, &spread);
        let at = &end.point.unknowns;
        let intervals = [&covariance, &sandwich_covariance].map(|covariance| {
            let half = covariance
                .diagonal()
                .map(|variance| NORMAL_QUANTILE * variance.sqrt());
            [
                unknowns.values(&(at - &half)),
                unknowns.values(&(at + half)),
            ]
        });
        let estimate = |(index, (name, value)): (usize, (&String, f64))| {
            let [interval, sandwich_interval] =
                [0, 1].map(|kind| [0, 1].map(|end| intervals[kind][end][index]));
            Estimate {
                name: name.clone(),
                value,
                interval,
                sandwich_interval,
            }
        };
        let values = names.iter().zip(unknowns.values(at));
        Self {
            estimates: values.enumerate().map(estimate).collect(),
            directions: directions(&information, &names),
            covariance,
            sandwich_covariance,
            measurements: end.measurements,
            cost: end.cost,
            iterations: end.iterations,
            termination,
            checkpoint: end.point,
        }
    }

    /// Values of the unknowns.
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        self.estimates
            .iter()
            .map(|estimate| estimate.value)
            .collect()
    }
}

/// Returns [`Fit::covariance`] and [`Fit::sandwich_covariance`].
fn covariances(information: &DMatrix<f64>, spread: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let count = information.nrows();
    let with_effect: Vec<_> = (0..count)
        .filter(|&unknown| information[(unknown, unknown)] > 0.0)
        .collect();
    let among = |matrix: &DMatrix<f64>| {
        matrix
            .select_rows(&with_effect)
            .select_columns(&with_effect)
    };
    let inverse = among(information).try_inverse();
    let sandwich = inverse
        .as_ref()
        .map(|inverse| inverse * among(spread) * inverse);
    [inverse, sandwich].map(|of_effective| {
        let mut covariance = DMatrix::from_diagonal_element(count, count, f64::INFINITY);
        for (i, &row) in with_effect.iter().enumerate() {
            for (j, &column) in with_effect.iter().enumerate() {
                let entry = of_effective.as_ref().map(|matrix| matrix[(i, j)]);
                covariance[(row, column)] = entry.unwrap_or(f64::INFINITY);
            }
        }
        covariance
    })
}

/// Principal directions of an information matrix, the least known first.
pub(super) fn directions(information: &DMatrix<f64>, names: &[String]) -> Vec<Direction> {
    if names.is_empty() {
        return Vec::new();
    }
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = information.clone().symmetric_eigen();
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&i, &j| eigenvalues[i].total_cmp(&eigenvalues[j]));
    let direction = |index: usize| {
        let largest = eigenvectors.column(index).iamax();
        let sign = eigenvectors[(largest, index)].signum();
        let weights = eigenvectors.column(index) * sign;
        Direction {
            standard_deviation: 1.0 / eigenvalues[index].max(0.0).sqrt(),
            weights: names.iter().cloned().zip(weights.iter().copied()).collect(),
        }
    };
    order.into_iter().map(direction).collect()
}

impl fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            value,
            interval: [lower, upper],
            ..
        } = self;
        write!(
            formatter,
            "{name}: {value:.4} (95 %: {lower:.4} to {upper:.4})"
        )
    }
}

impl fmt::Display for Direction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "standard deviation {:.3} along",
            self.standard_deviation
        )?;
        let listed = self
            .weights
            .iter()
            .filter(|(_, weight)| weight.abs() >= SMALLEST_LISTED_WEIGHT);
        for (name, weight) in listed {
            write!(formatter, " {weight:+.2} {name}")?;
        }
        Ok(())
    }
}
