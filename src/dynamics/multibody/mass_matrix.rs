//! Mass matrix of each tree, and its factorization.
//!
//! The entry of the columns j and k of a chain is S_jᵀ·I·S_k, with the composite inertia I of the lower of the two links. Entries of columns
//! in different branches are zero. The diagonal contains the armatures \[Featherstone 2008, Rigid Body Dynamics Algorithms, section 6.2\].
//!
//! The factorization M = LᵀDL eliminates the columns from the leaves to the root. It preserves the branch-induced sparsity \[section 6.5\].
//! The pivot D of a column is the inertia along the column if all joints of descendants move freely.

use super::screw::{SpatialInertia, dot};
use super::{Column, Coupling, Kinematics, Multibody};
use crate::scalar::{Scalar, lift, real_part};
use nalgebra::{DMatrix, DVector};
use std::iter::successors;
use std::ops::Range;

/// Smallest pivot of the mass matrix, relative to the terms of its diagonal. Smaller pivots can be round-off.
const SMALLEST_PIVOT: f64 = 1e-12;

/// Factors of the mass matrix of each tree.
pub(in crate::dynamics) struct MassFactors<T = f64>(Vec<TreeFactors<T>>);

/// Factors LᵀDL of the mass matrix of a tree.
struct TreeFactors<T> {
    columns: Range<usize>,
    /// D on the diagonal, and L below it.
    factors: DMatrix<T>,
    /// Parent column of each column.
    previous: Vec<Option<usize>>,
    couplings: Vec<Coupling>,
}

impl<T: Scalar> MassFactors<T> {
    /// Velocity changes that generalized impulses cause. The changes are NaN for a tree with a motion without inertia.
    pub fn velocities(&self, impulses: DVector<T>) -> DVector<T> {
        let mut velocities = impulses;
        for tree in &self.0 {
            tree.solve(&mut velocities.as_mut_slice()[tree.columns.clone()]);
        }
        velocities
    }

    /// [`Self::velocities`] for each column of a matrix.
    pub fn velocities_of(&self, impulses: &DMatrix<T>) -> DMatrix<T> {
        let mut velocities = impulses.clone();
        for mut column in velocities.column_iter_mut() {
            column.copy_from(&self.velocities(column.clone_owned()));
        }
        velocities
    }
}

impl<T: Scalar> TreeFactors<T> {
    fn new(
        columns: Range<usize>,
        mut matrix: DMatrix<T>,
        mut previous: Vec<Option<usize>>,
        couplings: &[Coupling],
    ) -> Self {
        let couplings = couplings.iter();
        let couplings: Vec<_> = couplings.filter_map(|c| c.within(&columns)).collect();
        for coupling in &couplings {
            coupling.fold(&mut matrix);
        }
        if !couplings.is_empty() {
            // A coupling connects branches.
            previous = (0..columns.len())
                .map(|column| column.checked_sub(1))
                .collect();
        }
        let mut tree = Self {
            columns,
            factors: matrix,
            previous,
            couplings,
        };
        for pivot in (0..tree.columns.len()).rev() {
            let chain: Vec<usize> = tree.above(pivot).collect();
            let matrix = &mut tree.factors;
            for (position, &row) in chain.iter().enumerate() {
                let factor = matrix[(pivot, row)] / matrix[(pivot, pivot)];
                for &column in &chain[position..] {
                    let update = matrix[(pivot, column)] * factor;
                    matrix[(row, column)] -= update;
                }
                matrix[(pivot, row)] = factor;
            }
        }
        tree
    }

    /// Ancestors of a column, the parent first.
    fn above(&self, column: usize) -> impl Iterator<Item = usize> {
        successors(self.previous[column], |&column| self.previous[column])
    }

    fn pivots(&self) -> impl Iterator<Item = f64> {
        let columns = 0..self.columns.len();
        columns.map(|column| real_part(self.factors[(column, column)]))
    }

    fn solve(&self, vector: &mut [T]) {
        if !self.pivots().all(|pivot| pivot > 0.0) {
            vector.fill(lift(f64::NAN));
            return;
        }
        for coupling in &self.couplings {
            coupling.fold_vector(vector);
        }
        for row in (0..vector.len()).rev() {
            for column in self.above(row) {
                let update = self.factors[(row, column)] * vector[row];
                vector[column] -= update;
            }
        }
        for row in 0..vector.len() {
            vector[row] /= self.factors[(row, row)];
            for column in self.above(row) {
                let update = self.factors[(row, column)] * vector[column];
                vector[row] -= update;
            }
        }
        for coupling in &self.couplings {
            coupling.unfold_vector(vector);
        }
    }
}

impl<T: Scalar> Multibody<T> {
    /// Inertia of each link and its descendants.
    pub(super) fn composite_inertias(&self, kinematics: &Kinematics<T>) -> Vec<SpatialInertia<T>> {
        self.summed_over_subtrees(self.inertias(kinematics), |sum, inertia| sum + inertia)
    }

    /// Inertia of each link about the reference point.
    pub(super) fn inertias(&self, kinematics: &Kinematics<T>) -> Vec<SpatialInertia<T>> {
        let links = self.links.iter().zip(&kinematics.frames);
        let inertias = links.map(|(link, frame)| {
            SpatialInertia::of(&link.inertia, frame.pose.rotation(), &frame.center_of_mass)
        });
        inertias.collect()
    }

    /// Mass matrix of each tree.
    pub fn mass_matrices(&self, kinematics: &Kinematics<T>) -> Vec<DMatrix<T>> {
        let zeros = |width| DMatrix::from_element(width, width, lift(0.0));
        let mut matrices: Vec<_> = self.trees.iter().map(|c| zeros(c.len())).collect();
        let composites = self.composite_inertias(kinematics);
        for (link, composite) in self.links.iter().zip(&composites) {
            let (matrix, first) = (&mut matrices[link.tree], self.trees[link.tree].start);
            for column in link.columns.clone() {
                let momentum = composite.times(&kinematics.columns[column].axis);
                for &row in link.moving_columns.iter().take_while(|row| **row <= column) {
                    let entry = dot(&kinematics.columns[row].axis, &momentum);
                    matrix[(row - first, column - first)] = entry;
                    matrix[(column - first, row - first)] = entry;
                }
                matrix[(column - first, column - first)] += link.law.armature;
            }
        }
        matrices
    }

    /// Factors of the mass matrices.
    pub fn mass_factors(&self, kinematics: &Kinematics<T>) -> MassFactors<T> {
        let matrices = self.mass_matrices(kinematics).into_iter();
        let mut previous: Vec<_> = self.trees.iter().map(|c| vec![None; c.len()]).collect();
        for link in &self.links {
            let first = self.trees[link.tree].start;
            for pair in link.moving_columns.windows(2) {
                previous[link.tree][pair[1] - first] = Some(pair[0] - first);
            }
        }
        let couplings = self.couplings();
        let trees = self.trees.iter().zip(matrices).zip(previous);
        let factors = trees.map(|((columns, matrix), above)| {
            TreeFactors::new(columns.clone(), matrix, above, &couplings)
        });
        MassFactors(factors.collect())
    }

    /// Factors of the mass matrices, which are positive definite.
    ///
    /// # Errors
    /// The link whose joint allows a motion without inertia, if a mass matrix is not positive definite. Joints of descendants move freely
    /// in this motion. The result is the last link if a chain of links has no mass.
    pub fn positive_mass_factors(
        &self,
        kinematics: &Kinematics<T>,
    ) -> Result<MassFactors<T>, usize> {
        let composites = self.composite_inertias(kinematics);
        let factors = self.mass_factors(kinematics);
        let pivots = factors.0.iter().flat_map(TreeFactors::pivots);
        let columns = kinematics.columns.iter().zip(pivots);
        let has_inertia = |column: &Column<T>, pivot: f64| {
            let armature = real_part(self.links[column.link].law.armature);
            let terms = composites[column.link].scale(&column.axis) + armature;
            // NaN fails the comparison.
            pivot > SMALLEST_PIVOT * terms
        };
        let massless = columns.filter(|(column, pivot)| !has_inertia(column, *pivot));
        match massless.map(|(column, _)| column.link).last() {
            Some(link) => Err(link),
            None => Ok(factors),
        }
    }
}
