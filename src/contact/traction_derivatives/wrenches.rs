//! Wrenches of tractions, from their moments.

use crate::contact::polygon_fields::Six;
use crate::lanes::{Lanes, Linear, Numbers, Row};

/// Returns the wrench of a traction from its moments by 1, y₁ and y₂ along each axis.
#[inline(always)]
pub(super) fn wrench_of<N: Linear>([t1, t2, t3]: &[[N; 3]; 3]) -> Six<N> {
    [t3[2], -t3[1], t2[1] - t1[2], t1[0], t2[0], t3[0]]
}

/// Returns the wrenches of a traction times 1, y₁ and y₂.
#[inline(always)]
pub(super) fn wrenches<N: Linear>([t1, t2, t3]: &[[N; 6]; 3]) -> [Six<N>; 3] {
    [
        wrench_of(&[
            [t1[0], t1[1], t1[2]],
            [t2[0], t2[1], t2[2]],
            [t3[0], t3[1], t3[2]],
        ]),
        wrench_of(&[
            [t1[1], t1[3], t1[4]],
            [t2[1], t2[3], t2[4]],
            [t3[1], t3[3], t3[4]],
        ]),
        wrench_of(&[
            [t1[2], t1[4], t1[5]],
            [t2[2], t2[4], t2[5]],
            [t3[2], t3[4], t3[5]],
        ]),
    ]
}

/// Returns the contribution of the speed h₀ + h₁y₁ + h₂y₂, from the contributions of the speeds 1, y₁ and y₂.
#[inline(always)]
pub(super) fn by_affine<N: Linear>([k0, k1, k2]: &[Six<N>; 3], [h0, h1, h2]: [N; 3]) -> Six<N> {
    plus(&plus(&times(k0, h0), &times(k1, h1)), &times(k2, h2))
}

#[inline(always)]
pub(super) fn times<N: Linear, const K: usize>(numbers: &[N; K], factor: N) -> [N; K] {
    let mut products = *numbers;
    for product in &mut products {
        *product = *product * factor;
    }
    products
}

#[inline(always)]
pub(super) fn negated<N: Linear, const K: usize>(numbers: &[N; K]) -> [N; K] {
    let mut negated = *numbers;
    for number in &mut negated {
        *number = -*number;
    }
    negated
}

#[inline(always)]
pub(super) fn plus<N: Linear, const K: usize>(numbers: &[N; K], others: &[N; K]) -> [N; K] {
    let mut sums = *numbers;
    for (sum, addend) in sums.iter_mut().zip(others) {
        *sum = *sum + *addend;
    }
    sums
}

#[inline(always)]
pub(super) fn minus<N: Linear, const K: usize>(numbers: &[N; K], others: &[N; K]) -> [N; K] {
    let mut differences = *numbers;
    for (difference, subtrahend) in differences.iter_mut().zip(others) {
        *difference = *difference - *subtrahend;
    }
    differences
}

/// Adds columns of six numbers, for the lanes from `first` on, to the rows of their entries.
#[inline(always)]
pub(super) fn add_columns<L: Lanes>(
    lanes: L,
    rows: &mut [Row],
    first: usize,
    columns: &[Six<L::Numbers>],
) {
    for (rows, column) in rows.chunks_exact_mut(6).zip(columns) {
        for (row, number) in rows.iter_mut().zip(column) {
            (lanes.load(row, first) + *number).store(row, first);
        }
    }
}
