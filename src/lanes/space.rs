//! Vectors in space: one vector, or one in each lane.

use super::traits::{Lanes, Linear, Numbers, Row};
use nalgebra::Vector3;

/// Gathers one vector for each lane.
#[inline(always)]
pub(crate) fn gathered<'v, L: Lanes>(
    lanes: L,
    vector: impl Fn(usize) -> &'v Vector3<f64>,
) -> [L::Numbers; 3] {
    [
        lanes.gathered(|lane| vector(lane).x),
        lanes.gathered(|lane| vector(lane).y),
        lanes.gathered(|lane| vector(lane).z),
    ]
}

/// Loads the vectors of consecutive items, beginning with item `first`.
#[inline(always)]
pub(crate) fn loaded<L: Lanes>(lanes: L, rows: &[Row; 3], first: usize) -> [L::Numbers; 3] {
    [
        lanes.load(&rows[0], first),
        lanes.load(&rows[1], first),
        lanes.load(&rows[2], first),
    ]
}

/// Stores the vectors of consecutive items, beginning with item `first`.
#[inline(always)]
pub(crate) fn store<N: Numbers>(rows: &mut [Row; 3], first: usize, numbers: [N; 3]) {
    for (row, number) in rows.iter_mut().zip(numbers) {
        number.store(row, first);
    }
}

/// Returns the vector at index `index` of the rows.
#[inline]
pub(crate) fn vector_at(rows: &[Row; 3], index: usize) -> Vector3<f64> {
    Vector3::new(rows[0][index], rows[1][index], rows[2][index])
}

/// Returns one vector in all lanes.
#[inline(always)]
pub(crate) fn splat<L: Lanes>(lanes: L, [x, y, z]: &[f64; 3]) -> [L::Numbers; 3] {
    [lanes.splat(*x), lanes.splat(*y), lanes.splat(*z)]
}

/// Returns the components of a vector along three axes.
#[inline(always)]
pub(crate) fn components<N: Linear>([e1, e2, n]: &[[N; 3]; 3], vector: [N; 3]) -> [N; 3] {
    [dot(*e1, vector), dot(*e2, vector), dot(*n, vector)]
}

#[inline(always)]
pub(crate) fn dot<N: Linear>(a: [N; 3], b: [N; 3]) -> N {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross<N: Linear>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
pub(crate) fn sum<N: Linear>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn difference<N: Linear>(a: [N; 3], b: [N; 3]) -> [N; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scaled<N: Linear>(a: [N; 3], factor: N) -> [N; 3] {
    [a[0] * factor, a[1] * factor, a[2] * factor]
}
