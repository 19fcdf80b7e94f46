//! Diagonally implicit Runge–Kutta methods, stiffly accurate: the last stage is the end of the step.

use crate::scalar::Scalar;
use nalgebra::Vector6;
use std::f64::consts::FRAC_1_SQRT_2;

/// A method by its coefficients.
#[derive(Debug)]
pub(in crate::dynamics) struct Scheme {
    /// For each stage the weights of the stages before it, and its own.
    stages: &'static [(&'static [f64], f64)],
    /// Whether steps are halved where forces change much in them.
    pub is_adaptive: bool,
}

/// γ = 1 − 1/√2, with which two stages are of second order and L-stable.
const GAMMA: f64 = 1.0 - FRAC_1_SQRT_2;

pub(in crate::dynamics) const SDIRK2: Scheme = Scheme {
    stages: &[(&[], GAMMA), (&[1.0 - GAMMA], GAMMA)],
    is_adaptive: true,
};

pub(in crate::dynamics) const IMPLICIT_EULER: Scheme = Scheme {
    stages: &[(&[], 1.0)],
    is_adaptive: false,
};

/// A stage of a step of some duration.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct Stage {
    /// The part of the step that each stage before it counts for.
    before: &'static [f64],
    /// The step (s).
    step: f64,
    /// The time (s) of its own velocities and wrenches.
    pub duration: f64,
    /// When they act, from the start of the step (s).
    pub offset: f64,
}

impl Scheme {
    pub(super) fn stages(&self, step: f64) -> impl Iterator<Item = Stage> {
        self.stages.iter().map(move |&(before, own)| Stage {
            before,
            step,
            duration: own * step,
            offset: (before.iter().sum::<f64>() + own) * step,
        })
    }

    /// The weights (s) by which the stages make up a step.
    pub(super) fn weights(&self, step: f64) -> impl Iterator<Item = f64> {
        let (before, own) = self.stages.last().copied().unwrap_or_default();
        before
            .iter()
            .copied()
            .chain([own])
            .map(move |weight| weight * step)
    }
}

impl Stage {
    /// The time (s) for which each stage before it counts.
    pub fn before(&self) -> impl Iterator<Item = f64> {
        self.before.iter().map(|weight| weight * self.step)
    }

    /// The sum that the rates of the stages before it give.
    pub fn accumulated<T: Scalar>(&self, rates: impl Iterator<Item = Vector6<T>>) -> Vector6<T> {
        let terms = self.before().zip(rates);
        terms.fold(super::rigid::none(), |sum, (time, rate)| {
            sum + rate.map(|number| number * time)
        })
    }
}
