//! Matrix of Newton's method, with a block for each pair of trees that interact: dense for few columns, sparse for many.

#[cfg(feature = "sparse")]
use super::sparse::{SparseFactors, SparseMatrix};
use crate::dynamics::multibody::{Coupling, Multibody};
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

/// Square matrix of blocks: one row and one column of blocks for each tree, then for each loop.
#[derive(Debug)]
pub(super) struct BlockMatrix {
    blocks: Blocks,
    /// Dependences between columns.
    couplings: Vec<Coupling>,
}

#[derive(Debug)]
enum Blocks {
    Dense {
        /// Columns of each tree and loop.
        ranges: Vec<Range<usize>>,
        matrix: DMatrix<f64>,
    },
    #[cfg(feature = "sparse")]
    Sparse(SparseMatrix),
}

/// LU factors of a matrix. Sparse factors of a singular matrix do not exist. Solutions satisfy the dependences between columns.
pub(super) struct Factors {
    lu: LuFactors,
    couplings: Vec<Coupling>,
}

enum LuFactors {
    Dense(LU<f64, Dyn, Dyn>),
    #[cfg(feature = "sparse")]
    Sparse(Option<Box<SparseFactors>>),
}

impl BlockMatrix {
    /// Zero matrix.
    pub fn zeros<T>(multibody: &Multibody<T>) -> Self {
        Self {
            blocks: Blocks::zeros(&block_columns(multibody)),
            couplings: multibody.couplings(),
        }
    }

    /// Block of the rows of one tree or loop and the columns of another.
    pub fn block(&mut self, row: usize, column: usize) -> DMatrixViewMut<'_, f64> {
        match &mut self.blocks {
            Blocks::Dense { ranges, matrix } => {
                let [rows, columns] = [&ranges[row], &ranges[column]];
                matrix.view_mut((rows.start, columns.start), (rows.len(), columns.len()))
            }
            #[cfg(feature = "sparse")]
            Blocks::Sparse(matrix) => matrix.block(row, column),
        }
    }

    pub fn transposed(self) -> Self {
        let blocks = match self.blocks {
            Blocks::Dense { ranges, matrix } => Blocks::Dense {
                ranges,
                matrix: matrix.transpose(),
            },
            #[cfg(feature = "sparse")]
            Blocks::Sparse(matrix) => Blocks::Sparse(matrix.transposed()),
        };
        Self { blocks, ..self }
    }

    /// Factorizes the matrix. The cache provides the symbolic factors of a known pattern, and stores new ones.
    pub fn factorized(self, symbolic_cache: &SymbolicCache) -> Factors {
        #[cfg(not(feature = "sparse"))]
        let _ = symbolic_cache;
        let couplings = self.couplings;
        let lu = match self.blocks {
            Blocks::Dense { mut matrix, .. } => {
                for coupling in &couplings {
                    coupling.fold(&mut matrix);
                }
                LuFactors::Dense(matrix.lu())
            }
            #[cfg(feature = "sparse")]
            Blocks::Sparse(mut matrix) => {
                for coupling in &couplings {
                    matrix.fold(coupling);
                }
                LuFactors::Sparse(matrix.factorized(symbolic_cache).map(Box::new))
            }
        };
        Factors { lu, couplings }
    }
}

/// Columns of the generalized velocities of each tree, then of the multipliers of each loop.
fn block_columns<T>(multibody: &Multibody<T>) -> Vec<Range<usize>> {
    let mut ranges = multibody.trees.clone();
    let width = ranges.last().map_or(0, |columns| columns.end);
    let multipliers = multibody.loops.iter().map(|joint| &joint.multipliers);
    ranges.extend(multipliers.map(|range| width + range.start..width + range.end));
    ranges
}

impl Blocks {
    /// Zero matrix with one block for each range of columns.
    fn zeros(ranges: &[Range<usize>]) -> Self {
        let size = ranges.last().map_or(0, |columns| columns.end);
        #[cfg(feature = "sparse")]
        if size >= SPARSE_FROM {
            return Self::Sparse(SparseMatrix::zeros(ranges));
        }
        Self::Dense {
            ranges: ranges.to_vec(),
            matrix: DMatrix::zeros(size, size),
        }
    }
}

impl Factors {
    /// Solution, or `None` if the matrix is singular.
    pub fn solve(&self, mut right: DVector<f64>) -> Option<DVector<f64>> {
        if right.is_empty() {
            return Some(right);
        }
        for coupling in &self.couplings {
            coupling.fold_vector(right.as_mut_slice());
        }
        let mut solution = match &self.lu {
            LuFactors::Dense(lu) => lu.solve_mut(&mut right).then_some(right),
            #[cfg(feature = "sparse")]
            LuFactors::Sparse(factors) => factors.as_ref().map(|factors| factors.solve(&right)),
        }?;
        for coupling in &self.couplings {
            coupling.unfold_vector(solution.as_mut_slice());
        }
        Some(solution)
    }

    pub fn inverse(&self) -> Option<DMatrix<f64>> {
        let mut inverse = match &self.lu {
            LuFactors::Dense(lu) => lu.try_inverse(),
            #[cfg(feature = "sparse")]
            LuFactors::Sparse(factors) => factors.as_ref().map(|factors| factors.inverse()),
        }?;
        for coupling in &self.couplings {
            coupling.unfold(&mut inverse);
        }
        Some(inverse)
    }
}
