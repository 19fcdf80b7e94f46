use super::TaxelGrid;
use super::taxel_sums::TaxelQuantity;
use crate::scalar::{Scalar, constant_times, lift};
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// The contact in one taxel.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct TaxelContact<T = f64> {
    /// Row of the taxel.
    pub row: usize,
    /// Column of the taxel.
    pub column: usize,
    /// Wrench on the body of the grid, about the body's origin, in the body's axes.
    pub wrench: Wrench<T>,
    /// Area of the contact surface in the taxel (m²).
    pub area: T,
}

impl<T: Scalar> TaxelQuantity for TaxelContact<T> {
    fn zero([row, column]: [usize; 2]) -> Self {
        Self {
            row,
            column,
            wrench: Wrench::zero(),
            area: lift(0.0),
        }
    }

    fn taxel(&self) -> [usize; 2] {
        [self.row, self.column]
    }

    fn add(&mut self, other: &Self) {
        self.wrench += other.wrench;
        self.area += other.area;
    }
}

impl<T: Scalar> TaxelContact<T> {
    /// Returns the force (N) along the axes of the taxel.
    pub(super) fn force(&self, grid: &TaxelGrid) -> Vector3<T> {
        let axes = grid.axes(self.row, self.column);
        constant_times(&axes.transpose(), &self.wrench.force)
    }
}
