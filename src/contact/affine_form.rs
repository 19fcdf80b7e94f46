use crate::geometry::AffineField;
use nalgebra::Vector3;
use std::ops::{Add, Mul};

/// A linear function of affine functions f: `value`·f(0) + `slope`·∇f, with 0 at A's origin.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct AffineForm {
    value: f64,
    slope: Vector3<f64>,
}

impl AffineForm {
    /// Creates f ↦ `value`·f(`at`) + `slope`·∇f.
    pub fn about(at: &Vector3<f64>, value: f64, slope: Vector3<f64>) -> Self {
        Self {
            value,
            slope: slope + at * value,
        }
    }

    pub fn of(&self, f: &AffineField) -> f64 {
        self.value * f.offset + self.slope.dot(&f.gradient)
    }
}

impl Add for AffineForm {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            slope: self.slope + other.slope,
        }
    }
}

impl Mul<f64> for AffineForm {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            slope: self.slope * factor,
        }
    }
}
