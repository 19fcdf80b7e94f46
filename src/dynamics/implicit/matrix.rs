//! The matrix of Newton's method, of a 6×6 block for each two bodies that act on each other: dense for a few bodies, sparse for
//! many.

#[cfg(feature = "sparse")]
use super::sparse::{SparseFactors, SparseMatrix};
use nalgebra::{DMatrix, DVector, Dyn, LU, Matrix6};

#[cfg(feature = "sparse")]
pub(super) use super::sparse::SymbolicCache;

/// Without sparse matrices there is nothing to keep of their patterns.
#[cfg(not(feature = "sparse"))]
#[derive(Debug, Clone, Default)]
pub(super) struct SymbolicCache(());

/// From so many bodies on, a matrix is sparse: the time of dense factors grows with the cube of their number.
#[cfg(feature = "sparse")]
const SPARSE_FROM: usize = 16;

/// A square matrix.
#[derive(Debug)]
pub(super) enum BlockMatrix {
    Dense(DMatrix<f64>),
    #[cfg(feature = "sparse")]
    Sparse(SparseMatrix),
}

/// A factorized matrix, of which there is none if it is singular.
pub(super) enum Factors {
    Dense(LU<f64, Dyn, Dyn>),
    #[cfg(feature = "sparse")]
    Sparse(Option<Box<SparseFactors>>),
}

impl BlockMatrix {
    pub fn zeros(bodies: usize) -> Self {
        #[cfg(feature = "sparse")]
        if bodies >= SPARSE_FROM {
            return Self::Sparse(SparseMatrix::zeros(bodies));
        }
        Self::Dense(DMatrix::zeros(6 * bodies, 6 * bodies))
    }

    pub fn add(&mut self, row: usize, column: usize, block: &Matrix6<f64>) {
        match self {
            Self::Dense(matrix) => {
                let mut view = matrix.fixed_view_mut::<6, 6>(6 * row, 6 * column);
                view += block;
            }
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => matrix.add(row, column, block),
        }
    }

    pub fn transposed(self) -> Self {
        match self {
            Self::Dense(matrix) => Self::Dense(matrix.transpose()),
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => Self::Sparse(matrix.transposed()),
        }
    }

    /// By patterns that are known from other matrices, or become so.
    pub fn factorized(self, symbolic_cache: &SymbolicCache) -> Factors {
        #[cfg(not(feature = "sparse"))]
        let _ = symbolic_cache;
        match self {
            Self::Dense(matrix) => Factors::Dense(matrix.lu()),
            #[cfg(feature = "sparse")]
            Self::Sparse(matrix) => {
                Factors::Sparse(matrix.factorized(symbolic_cache).map(Box::new))
            }
        }
    }
}

impl Factors {
    /// The solution, unless the matrix is singular.
    pub fn solve(&self, right: &DVector<f64>) -> Option<DVector<f64>> {
        match self {
            Self::Dense(lu) => lu.solve(right),
            #[cfg(feature = "sparse")]
            Self::Sparse(factors) => factors.as_ref().map(|factors| factors.solve(right)),
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
