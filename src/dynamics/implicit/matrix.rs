//! Matrix of Newton's method, with a 6×6 block for each pair of bodies that interact: dense for few bodies, sparse for many.

#[cfg(feature = "sparse")]
use super::sparse::{SparseFactors, SparseMatrix};
use nalgebra::{DMatrix, DVector, Dyn, LU, Matrix6};

#[cfg(feature = "sparse")]
pub(super) use super::sparse::SymbolicCache;

/// Empty cache, because dense matrices have no symbolic factors.
#[cfg(not(feature = "sparse"))]
#[derive(Debug, Clone, Default)]
pub(super) struct SymbolicCache(());

/// Number of bodies from which a matrix is sparse. The time of dense factorization grows with the cube of this number.
#[cfg(feature = "sparse")]
const SPARSE_FROM: usize = 16;

/// Square matrix of 6×6 blocks.
#[derive(Debug)]
pub(super) enum BlockMatrix {
    Dense(DMatrix<f64>),
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

    /// Factorizes the matrix. The cache provides the symbolic factors of a known pattern, and stores new ones.
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
    /// Solution, or `None` if the matrix is singular.
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
