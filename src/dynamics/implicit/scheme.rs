//! Stiffly accurate, diagonally implicit Runge–Kutta methods. The last stage is the end of the substep.

use crate::dynamics::multibody::zeros;
use crate::scalar::Scalar;
use nalgebra::DVector;

/// Coefficients of a method.
#[derive(Debug)]
pub(in crate::dynamics) struct Scheme {
    /// Weights of the earlier stages and diagonal coefficient, for each stage.
    stages: &'static [(&'static [f64], f64)],
    /// Estimate of the local error, or `None` for a method without error control.
    pub estimate: Option<ErrorEstimate>,
}

/// Difference from an embedded formula of lower order.
#[derive(Debug)]
pub(in crate::dynamics) struct ErrorEstimate {
    /// Weights of the rates of the stages.
    weights: &'static [f64],
    /// Power of the duration with which the estimate decreases.
    pub order: f64,
}

/// Diagonal coefficient γ with which three stages have third order and are L-stable: the middle root of 6γ³ − 18γ² + 9γ − 1 = 0.
const GAMMA: f64 = 0.435_866_521_508_459;

/// Weights of the first two stages in the third.
const LAST: [f64; 2] = [
    -(6.0 * GAMMA * GAMMA - 16.0 * GAMMA + 1.0) / 4.0,
    (6.0 * GAMMA * GAMMA - 20.0 * GAMMA + 5.0) / 4.0,
];

/// SDIRK method of third order \[Alexander 1977\]. The first two stages give the embedded formula of second order.
pub(in crate::dynamics) const SDIRK3: Scheme = Scheme {
    stages: &[
        (&[], GAMMA),
        (&[(1.0 - GAMMA) / 2.0], GAMMA),
        (&LAST, GAMMA),
    ],
    estimate: Some(ErrorEstimate {
        weights: &[
            LAST[0] - GAMMA / (1.0 - GAMMA),
            LAST[1] - (1.0 - 2.0 * GAMMA) / (1.0 - GAMMA),
            GAMMA,
        ],
        order: 3.0,
    }),
};

pub(in crate::dynamics) const IMPLICIT_EULER: Scheme = Scheme {
    stages: &[(&[], 1.0)],
    estimate: None,
};

/// Stage of a substep.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct Stage {
    /// Weight of each earlier stage.
    before: &'static [f64],
    /// Duration of the substep (s).
    substep: f64,
    /// Diagonal coefficient times the duration of the substep (s).
    pub duration: f64,
    /// Abscissa times the duration of the substep (s).
    pub offset: f64,
}

impl Scheme {
    pub(super) fn stages(&self, substep: f64) -> impl Iterator<Item = Stage> {
        self.stages.iter().map(move |&(before, diagonal)| Stage {
            before,
            substep,
            duration: diagonal * substep,
            offset: (before.iter().sum::<f64>() + diagonal) * substep,
        })
    }

    /// Weights of the stages, times the duration of the substep (s).
    pub(super) fn weights(&self, substep: f64) -> impl Iterator<Item = f64> {
        let (before, diagonal) = self.stages.last().copied().unwrap_or_default();
        before
            .iter()
            .copied()
            .chain([diagonal])
            .map(move |weight| weight * substep)
    }
}

impl ErrorEstimate {
    /// Error estimate of the displacement or the momenta, from their rates in all stages.
    pub(super) fn of<'r>(
        &self,
        width: usize,
        rates: impl Iterator<Item = &'r DVector<f64>>,
        substep: f64,
    ) -> DVector<f64> {
        sum(
            width,
            self.weights.iter().map(|weight| weight * substep),
            rates,
        )
    }
}

impl Stage {
    /// Coefficients of the earlier stages, times the duration of the substep (s).
    pub fn before(&self) -> impl Iterator<Item = f64> {
        self.before.iter().map(|weight| weight * self.substep)
    }

    /// Sum of the rates of the earlier stages, each times its coefficient.
    pub fn accumulated<'r, T: Scalar>(
        &self,
        width: usize,
        rates: impl Iterator<Item = &'r DVector<T>>,
    ) -> DVector<T> {
        sum(width, self.before(), rates)
    }
}

/// Sum of rates, each times a time (s).
fn sum<'r, T: Scalar>(
    width: usize,
    times: impl Iterator<Item = f64>,
    rates: impl Iterator<Item = &'r DVector<T>>,
) -> DVector<T> {
    times.zip(rates).fold(zeros(width), |sum, (time, rate)| {
        sum + rate.map(|number| number * time)
    })
}
