//! Matrix of Newton's method, with a block for each pair of trees that interact: dense for few columns, sparse for many.

#[cfg(feature = "sparse")]
use super::sparse::{SparseFactors, SparseMatrix};
use nalgebra::{DMatrix, DMatrixViewMut, DVector, Dyn, LU};
use std::ops::Range;

#[cfg(feature = "sparse")]
pub(super) use super::sparse::SymbolicCache;

/// Empty cache, because dense matrices have no symbolic factors.
#[cfg(not(feature = "sparse"))]
#[derive(Debug, Clone, Default)]
pub(super) struct SymbolicCache(());

/// Number of columns from which a matrix is sparse. The time of dense factorization grows with the cube of this number.
#[cfg(feature = "sparse")]
const SPARSE_FROM: usize = 96;

/// Square matrix of blocks: one row and one column of blocks for each tree.
#[derive(Debug)]
pub(super) enum BlockMatrix {
    Dense {
        /// Columns of each tree.
        trees: Vec<Range<usize>>,
        matrix: DMatrix<f64>,
    },
    #[cfg(feature = "sparse")]
    Sparse(SparseMatrix),
}

/// Factors of a matrix. A singular matrix may have none.
pub(super) enum Factors {
    Dense(LU<f64, Dyn, Dyn>),
    #[cfg(feature = "sparse")]
    Sparse(Option<Box<SparseFactors>>),
}

impl BlockMatrix {
    /// Zero matrix for trees with these columns.
    pub fn zeros(trees: &[Range<usize>]) -> Self {
        let size = trees.last().map_or(0, |columns| columns.end);
        #[cfg(feature = "sparse")]
        if size >= SPARSE_FROM {
            return Self::Sparse(SparseMatrix::zeros(trees));
        }
        Self::Dense {
            trees: trees.to_vec(),
            matrix: DMatrix::zeros(size, size),
        }
    }

    /// Block of the rows of one tree and the columns of another.
    pub fn block(&mut self, row: usize, column: usize) -> DMatrixViewMut<'_, f64> {
        match self {
            Self::Dense { trees, matrix } => {
                let [rows, columns] = [&trees[row], &trees[column]];
                matrix.view_mut((rows.start, columns.start), (rows.len(), columns.len()))
            }
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => matrix.block(row, column),
        }
    }

    pub fn transposed(self) -> Self {
        match self {
            Self::Dense { trees, matrix } => Self::Dense {
                trees,
                matrix: matrix.transpose(),
            },
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => Self::Sparse(matrix.transposed()),
        }
    }

    /// Factorizes the matrix. The cache provides the symbolic factors of a known pattern, and stores new ones.
    pub fn factorized(self, symbolic_cache: &SymbolicCache) -> Factors {
        #[cfg(not(feature = "sparse"))]
        let _ = symbolic_cache;
        match self {
            Self::Dense { matrix, .. } => Factors::Dense(matrix.lu()),
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => {
                Factors::Sparse(matrix.factorized(symbolic_cache).map(Box::new))
            }
        }
    }
}

impl Factors {
    /// Solution, or `None` if the matrix is singular.
    pub fn solve(&self, mut right: DVector<f64>) -> Option<DVector<f64>> {
        match self {
            Self::Dense(lu) => lu.solve_mut(&mut right).then_some(right),
            #[cfg(feature = "sparse")]
            Self::Sparse(factors) => factors.as_ref().map(|factors| factors.solve(&right)),
        }
    }

    pub fn inverse(&self) -> Option<DMatrix<f64>> {
        match self {
            Self::Dense(lu) => lu.try_inverse(),
            #[cfg(feature = "sparse")]
            Self::Sparse(factors) => factors.as_ref().map(|factors| factors.inverse()),
        }
    }
}
