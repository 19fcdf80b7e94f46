//! Sample rotation vectors and tolerances.

use nalgebra::{Vector3, vector};
use std::f64::consts::PI;

/// A few rounding errors of numbers of order one.
pub const ROUND_OFF: f64 = 2e-15;

/// Error of the exponential map and its derivatives for angles up to one turn.
pub const EXACT: f64 = 1e-14;

/// Returns rotation vectors on both sides of the limit of the series (0.5 rad), small, large, and along an axis.
pub fn rotation_vectors() -> Vec<Vector3<f64>> {
    let axes = [
        vector![1.0, 0.0, 0.0],
        vector![0.0, 0.0, -1.0],
        vector![0.48, -0.6, 0.64],
        vector![-2.0, 1.0, 2.0] / 3.0,
    ];
    let angles = [
        1e-12,
        1e-8,
        1e-4,
        0.1,
        0.499_999_999,
        0.5 - f64::EPSILON,
        0.5,
        0.5 + f64::EPSILON,
        0.500_000_001,
        1.0,
        3.0,
        PI,
        6.0,
        20.0,
    ];
    axes.iter()
        .flat_map(|axis| angles.map(|angle| axis * angle))
        .collect()
}
