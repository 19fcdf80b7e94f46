use super::Kinks;
use super::sums::PartialSum;
use crate::scalar::{Scalar, lift};
use crate::spatial::Wrench;
use nalgebra::{Matrix6, Matrix6x2, Vector3, Vector6};

/// The wrench on A and its derivatives, in A's axes about A's origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeLinearization {
    pub wrench: Vector6<f64>,
    /// Derivative with respect to a motion of B (angular, linear, of the point at A's origin).
    pub by_motion: Matrix6<f64>,
    pub by_moduli: Matrix6x2<f64>,
    /// Derivative with respect to the velocity of A relative to B (angular, linear at A's origin).
    pub by_twist: Matrix6<f64>,
    /// Derivatives with respect to dissipation and friction.
    pub by_law: Matrix6x2<f64>,
    pub kinks: Kinks,
}

impl PartialSum for RelativeLinearization {
    fn empty() -> Self {
        Self {
            wrench: Vector6::zeros(),
            by_motion: Matrix6::zeros(),
            by_moduli: Matrix6x2::zeros(),
            by_twist: Matrix6::zeros(),
            by_law: Matrix6x2::zeros(),
            kinks: Kinks::default(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.wrench += next.wrench;
        self.by_motion += next.by_motion;
        self.by_moduli += next.by_moduli;
        self.by_twist += next.by_twist;
        self.by_law += next.by_law;
        self.kinks.merge(next.kinks);
    }
}

impl RelativeLinearization {
    /// Applies the chain rule: returns the wrench after `changes` of the inputs that `ContactPair::tangent` lists. The real parts of
    /// `changes` are zero.
    pub fn pushforward<T: Scalar>(&self, changes: &[T; 16]) -> Wrench<T> {
        let number = |row: usize| {
            let slope = |column: usize| match column {
                0..6 => self.by_motion[(row, column)],
                6..8 => self.by_moduli[(row, column - 6)],
                8..14 => self.by_twist[(row, column - 8)],
                _ => self.by_law[(row, column - 14)],
            };
            let mut sum = lift::<T>(self.wrench[row]);
            for (column, change) in changes.iter().enumerate() {
                sum += *change * slope(column);
            }
            sum
        };
        Wrench {
            torque: Vector3::from_fn(|i, _| number(i)),
            force: Vector3::from_fn(|i, _| number(3 + i)),
        }
    }
}
