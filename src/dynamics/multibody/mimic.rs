//! Joints that mimic other joints.
//!
//! The velocity of a mimicking joint, the follower, is a multiple of the velocity of its leader. Let w be the velocities of all other
//! columns. Then all velocities are u = E·w. Followers keep their columns in vectors and matrices. Linear systems are solved in the range
//! of E: the solution of A·u = b is E(EᵀAE)⁻¹Eᵀb. All velocities are sums of these solutions, so they are in the range of E.
//! [`Coupling::fold`] computes EᵀAE, and sets the row and the column of the follower to those of the identity matrix.

use super::{Link, Multibody};
use crate::scalar::{Scalar, lift};
use nalgebra::DMatrix;
use std::ops::Range;

/// Dependence of the joint of a link on the joint of another link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::dynamics) struct LinkMimic {
    /// Index of the link of the leader.
    pub leader: usize,
    pub multiplier: f64,
    /// Position (rad or m) if the position of the leader is zero.
    pub offset: f64,
}

/// Dependence of a column on another column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::dynamics) struct Coupling {
    pub follower: usize,
    pub leader: usize,
    pub multiplier: f64,
}

impl<T> Multibody<T> {
    /// Dependences between columns.
    pub fn couplings(&self) -> Vec<Coupling> {
        let couplings = self.links.iter().filter_map(|link| {
            let mimic = link.mimic?;
            Some(Coupling {
                follower: link.columns.start,
                leader: self.links[mimic.leader].columns.start,
                multiplier: mimic.multiplier,
            })
        });
        couplings.collect()
    }
}

impl Coupling {
    /// Coupling with indices relative to the first of these columns, or `None` if the follower is in another column.
    pub fn within(&self, columns: &Range<usize>) -> Option<Self> {
        columns.contains(&self.follower).then(|| Self {
            follower: self.follower - columns.start,
            leader: self.leader - columns.start,
            multiplier: self.multiplier,
        })
    }

    /// Adds the row and the column of the follower, times the multiplier, to the row and the column of the leader. Then sets the row and
    /// the column of the follower to those of the identity matrix.
    pub fn fold<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        self.fold_rows(matrix);
        self.fold_columns(matrix);
        matrix[(self.follower, self.follower)] = lift(1.0);
    }

    /// Adds the row of the follower, times the multiplier, to the row of the leader. Then sets the row of the follower to zero.
    pub fn fold_rows<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        for column in 0..matrix.ncols() {
            let follower = matrix[(self.follower, column)];
            matrix[(self.leader, column)] += follower * self.multiplier;
            matrix[(self.follower, column)] = lift(0.0);
        }
    }

    /// Adds the column of the follower, times the multiplier, to the column of the leader. Then sets the column of the follower to zero.
    pub fn fold_columns<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        for row in 0..matrix.nrows() {
            let follower = matrix[(row, self.follower)];
            matrix[(row, self.leader)] += follower * self.multiplier;
            matrix[(row, self.follower)] = lift(0.0);
        }
    }

    /// Multiplies a vector by Eᵀ.
    pub fn fold_vector<T: Scalar>(&self, vector: &mut [T]) {
        let follower = vector[self.follower];
        vector[self.leader] += follower * self.multiplier;
        vector[self.follower] = lift(0.0);
    }

    /// Multiplies a vector by E.
    pub fn unfold_vector<T: Scalar>(&self, vector: &mut [T]) {
        vector[self.follower] = vector[self.leader] * self.multiplier;
    }

    /// Replaces a matrix A by E·A·Eᵀ.
    pub fn unfold(&self, matrix: &mut DMatrix<f64>) {
        for column in 0..matrix.ncols() {
            matrix[(self.follower, column)] = matrix[(self.leader, column)] * self.multiplier;
        }
        for row in 0..matrix.nrows() {
            matrix[(row, self.follower)] = matrix[(row, self.leader)] * self.multiplier;
        }
    }
}

/// Merges the trees that a mimicking joint couples, because they share one block in each matrix. Returns the number of trees.
pub(super) fn join_coupled_trees<T>(links: &mut [Link<T>]) -> usize {
    for link in 0..links.len() {
        let Some(mimic) = links[link].mimic else {
            continue;
        };
        let [one, other] = [links[link].tree, links[mimic.leader].tree];
        let (kept, joined) = (one.min(other), one.max(other));
        for link in links.iter_mut().filter(|link| link.tree == joined) {
            link.tree = kept;
        }
    }
    let mut kept: Vec<usize> = links.iter().map(|link| link.tree).collect();
    kept.sort_unstable();
    kept.dedup();
    for link in links {
        link.tree = kept.partition_point(|tree| *tree < link.tree);
    }
    kept.len()
}
