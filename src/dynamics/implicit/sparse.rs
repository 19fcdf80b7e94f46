//! Sparse matrices of Newton's method: the only user of faer. The LU factorization separates the symbolic part, which depends only on the
//! positions of the blocks, from the numeric part. It runs on one thread, so that the number of threads changes no bit.

use crate::dynamics::multibody::Coupling;
use faer::Mat;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

/// Sparse matrix. Its blocks are sorted by column, then by row.
#[derive(Debug)]
pub(in crate::dynamics) struct SparseMatrix {
    /// Columns of each tree and loop.
    ranges: Vec<Range<usize>>,
    blocks: BTreeMap<(usize, usize), DMatrix<f64>>,
}

pub(in crate::dynamics) struct SparseFactors {
    lu: Lu<usize, f64>,
    size: usize,
}

/// Columns of the trees and loops, and positions of the blocks: columns and rows.
type Pattern = (Vec<Range<usize>>, Vec<(usize, usize)>);

/// Cache of the symbolic factors of recent patterns. They are computed once while the same bodies touch.
#[derive(Clone, Default)]
pub(in crate::dynamics) struct SymbolicCache(Arc<Mutex<Vec<CacheEntry>>>);

/// Pattern with its symbolic factors.
type CacheEntry = (Pattern, SymbolicLu<usize>);

/// Number of cached patterns. The most recently used patterns are kept.
const CACHE_SIZE: usize = 16;

impl SparseMatrix {
    pub fn zeros(ranges: &[Range<usize>]) -> Self {
        Self {
            ranges: ranges.to_vec(),
            blocks: BTreeMap::new(),
        }
    }

    pub fn block(&mut self, row: usize, column: usize) -> DMatrixViewMut<'_, f64> {
        let [rows, columns] = [row, column].map(|index| self.ranges[index].len());
        let block = self.blocks.entry((column, row));
        block
            .or_insert_with(|| DMatrix::zeros(rows, columns))
            .as_view_mut()
    }

    pub fn transposed(self) -> Self {
        let blocks = self.blocks.into_iter();
        let turned = blocks.map(|((column, row), block)| ((row, column), block.transpose()));
        Self {
            ranges: self.ranges,
            blocks: turned.collect(),
        }
    }

    /// Replaces the matrix A by EᵀAE for a coupling of two columns of one tree.
    pub fn fold(&mut self, coupling: &Coupling) {
        let within = self.ranges.iter().map(|columns| coupling.within(columns));
        let within: Vec<_> = within.collect();
        for (&(column, row), block) in &mut self.blocks {
            match (within[row], within[column]) {
                (Some(coupling), Some(_)) => coupling.fold(block),
                (Some(coupling), None) => coupling.fold_rows(block),
                (None, Some(coupling)) => coupling.fold_columns(block),
                (None, None) => {}
            }
        }
    }

    fn size(&self) -> usize {
        self.ranges.last().map_or(0, |columns| columns.end)
    }

    /// Factorizes the matrix. Returns `None` if it is singular.
    pub fn factorized(&self, symbolic_cache: &SymbolicCache) -> Option<SparseFactors> {
        let matrix = self.in_columns();
        let pattern = (self.ranges.clone(), self.blocks.keys().copied().collect());
        let symbolic = symbolic_cache.symbolic(pattern, &matrix)?;
        let lu = Lu::try_new_with_symbolic(symbolic, matrix.as_ref()).ok()?;
        Some(SparseFactors {
            lu,
            size: self.size(),
        })
    }

    fn in_columns(&self) -> SparseColMat<usize, f64> {
        let size = self.size();
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for (index, columns) in self.ranges.iter().enumerate() {
            let column_blocks = || self.blocks.range((index, 0)..(index + 1, 0));
            for column in 0..columns.len() {
                for (&(_, row), block) in column_blocks() {
                    rows.extend(self.ranges[row].clone());
                    values.extend(block.column(column).iter());
                }
                starts.push(rows.len());
            }
        }
        let symbolic = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
        SparseColMat::new(symbolic, values)
    }
}

impl SymbolicCache {
    /// Symbolic factors of a matrix with this pattern.
    fn symbolic(
        &self,
        pattern: Pattern,
        matrix: &SparseColMat<usize, f64>,
    ) -> Option<SymbolicLu<usize>> {
        let mut entries = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = entries
            .iter()
            .position(|(known_pattern, _)| *known_pattern == pattern);
        let entry = match known {
            Some(index) => entries.remove(index),
            None => (pattern, SymbolicLu::try_new(matrix.symbolic()).ok()?),
        };
        let symbolic = entry.1.clone();
        entries.insert(0, entry);
        entries.truncate(CACHE_SIZE);
        Some(symbolic)
    }
}

impl fmt::Debug for SymbolicCache {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("SymbolicCache")
            .finish_non_exhaustive()
    }
}

impl SparseFactors {
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let mut solution = Mat::from_fn(self.size, 1, |row, _| right[row]);
        self.lu.solve_in_place(solution.as_mut());
        DVector::from_fn(self.size, |row, _| solution[(row, 0)])
    }

    pub fn inverse(&self) -> DMatrix<f64> {
        let mut inverse = Mat::<f64>::identity(self.size, self.size);
        self.lu.solve_in_place(inverse.as_mut());
        DMatrix::from_fn(self.size, self.size, |row, column| inverse[(row, column)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of trees with one, three or six degrees of freedom.
    fn trees(count: usize) -> Vec<Range<usize>> {
        let mut next = 0;
        let widths = (0..count).map(|tree| [6, 1, 3][tree % 3]);
        let columns = widths.map(|width| {
            let first = next;
            next += width;
            first..next
        });
        columns.collect()
    }

    /// Entry of a diagonally dominant matrix.
    fn entry(row: usize, column: usize, seed: f64) -> f64 {
        let weight = if row == column { 20.0 } else { 0.0 };
        (row as f64 * 1.3 + column as f64 * 0.7 + seed).sin() + weight
    }

    #[test]
    fn solutions_are_those_of_dense_factors_and_patterns_are_kept() {
        const COUNT: usize = 20;
        let trees = trees(COUNT);
        let size = trees[COUNT - 1].end;
        let symbolic_cache = SymbolicCache::default();
        for seed in 0..3 {
            let mut sparse = SparseMatrix::zeros(&trees);
            let mut dense = DMatrix::zeros(size, size);
            for row in 0..COUNT {
                for column in [row, (row + 1) % COUNT, (row + 7) % COUNT] {
                    let [rows, columns] = [row, column].map(|tree| trees[tree].clone());
                    let block = DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
                        entry(rows.start + i, columns.start + j, f64::from(seed))
                    });
                    let mut view = sparse.block(row, column);
                    view += &block;
                    let mut view = dense.view_mut((rows.start, columns.start), block.shape());
                    view += block;
                }
            }
            let right = DVector::from_fn(size, |row, _| (row as f64).cos());
            let factors = sparse.factorized(&symbolic_cache).unwrap();
            let expected = dense.clone().lu().solve(&right).unwrap();
            assert!((factors.solve(&right) - expected).amax() < 1e-13);
            let inverse = dense.try_inverse().unwrap();
            assert!((factors.inverse() - inverse).amax() < 1e-13);
        }
        assert_eq!(symbolic_cache.0.lock().unwrap().len(), 1);
    }

    #[test]
    fn a_singular_matrix_has_no_factors_or_no_finite_solution() {
        let mut matrix = SparseMatrix::zeros(&[0..6, 6..12]);
        matrix.block(0, 0).fill_with_identity();
        matrix.block(1, 1).fill(0.0);
        let factors = matrix.factorized(&SymbolicCache::default());
        let solution = factors.map(|factors| factors.solve(&DVector::repeat(12, 1.0)));
        assert!(solution.is_none_or(|solution| solution.iter().any(|number| !number.is_finite())));
    }
}
