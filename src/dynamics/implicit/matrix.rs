//! The matrix of Newton's method, of 6×6 blocks.

use nalgebra::{DMatrix, DVector, Dyn, LU, Matrix6};

/// A square matrix of a block for each two bodies.
#[derive(Debug, Clone)]
pub(super) struct BlockMatrix {
    dense: DMatrix<f64>,
}

/// A factorised matrix.
pub(super) struct Factors {
    lu: LU<f64, Dyn, Dyn>,
}

impl BlockMatrix {
    pub fn zeros(bodies: usize) -> Self {
        Self {
            dense: DMatrix::zeros(6 * bodies, 6 * bodies),
        }
    }

    pub fn add(&mut self, row: usize, column: usize, block: &Matrix6<f64>) {
        let mut view = self.dense.fixed_view_mut::<6, 6>(6 * row, 6 * column);
        view += block;
    }

    pub fn factorised(self) -> Factors {
        Factors {
            lu: self.dense.lu(),
        }
    }
}

impl Factors {
    /// The solution, unless the matrix is singular.
    pub fn solve(&self, right: &DVector<f64>) -> Option<DVector<f64>> {
        self.lu.solve(right)
    }

    pub fn inverse(&self) -> Option<DMatrix<f64>> {
        self.lu.try_inverse()
    }
}
