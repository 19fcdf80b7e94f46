//! Joints that mimic other joints.
//!
//! The velocity of such a joint is a multiple of the velocity of its leader: u = E·w, with the velocities w of all other columns. Each column
//! keeps its place in vectors and matrices, and linear systems are solved in the range of E: the solution of A·u = b is E(EᵀAE)⁻¹Eᵀb. All
//! velocities are sums of such solutions, so they are in the range of E. [`Coupling::fold`] computes EᵀAE, with an identity in the row and
//! the column of the mimicking joint.

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
    /// Position at position zero of the leader (rad or m).
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
    /// The coupling in a matrix that begins at a column, if the column of the follower is among these columns.
    pub fn within(&self, columns: &Range<usize>) -> Option<Self> {
        columns.contains(&self.follower).then(|| Self {
            follower: self.follower - columns.start,
            leader: self.leader - columns.start,
            multiplier: self.multiplier,
        })
    }

    /// Adds the row and the column of the follower to those of the leader, and replaces them by those of an identity.
    pub fn fold<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        self.fold_rows(matrix);
        self.fold_columns(matrix);
        matrix[(self.follower, self.follower)] = lift(1.0);
    }

    /// Adds the row of the follower to that of the leader, and clears it.
    pub fn fold_rows<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        for column in 0..matrix.ncols() {
            let follower = matrix[(self.follower, column)];
            matrix[(self.leader, column)] += follower * self.multiplier;
            matrix[(self.follower, column)] = lift(0.0);
        }
    }

    /// Adds the column of the follower to that of the leader, and clears it.
    pub fn fold_columns<T: Scalar>(&self, matrix: &mut DMatrix<T>) {
        for row in 0..matrix.nrows() {
            let follower = matrix[(row, self.follower)];
            matrix[(row, self.leader)] += follower * self.multiplier;
            matrix[(row, self.follower)] = lift(0.0);
        }
    }

    /// Eᵀ of a vector.
    pub fn fold_vector<T: Scalar>(&self, vector: &mut [T]) {
        let follower = vector[self.follower];
        vector[self.leader] += follower * self.multiplier;
        vector[self.follower] = lift(0.0);
    }

    /// E of a vector.
    pub fn unfold_vector<T: Scalar>(&self, vector: &mut [T]) {
        vector[self.follower] = vector[self.leader] * self.multiplier;
    }

    /// E·A·Eᵀ of a matrix.
    pub fn unfold(&self, matrix: &mut DMatrix<f64>) {
        for column in 0..matrix.ncols() {
            matrix[(self.follower, column)] = matrix[(self.leader, column)] * self.multiplier;
        }
        for row in 0..matrix.nrows() {
            matrix[(row, self.follower)] = matrix[(row, self.leader)] * self.multiplier;
        }
    }
}

/// Gives the trees that a mimicking joint couples the same index, because they have one block in each matrix. Returns the number of trees.
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
