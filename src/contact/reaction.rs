use super::add_block;
use crate::scalar::{Scalar, lift};
use crate::spatial::skew;
use nalgebra::{Matrix6, SMatrix, Vector3};

/// From the wrench on A to that on B: force −F, torque −(τ − r × F) about a point r away, which moves with B against A.
pub(super) struct Reaction<T> {
    pub from_a_to_b: Vector3<T>,
    pub force: Vector3<T>,
}

impl<T: Scalar> Reaction<T> {
    pub fn of_columns<const C: usize>(&self, on_a: &SMatrix<T, 6, C>) -> SMatrix<T, 12, C> {
        on_both(&self.from_a_to_b, on_a)
    }

    pub fn of_blocks(&self, [by_a, by_b]: &[Matrix6<T>; 2]) -> SMatrix<T, 12, 12> {
        let [by_a, by_b] = [by_a, by_b].map(|by| self.of_columns(by));
        SMatrix::from_fn(|row, column| match column {
            0..6 => by_a[(row, column)],
            _ => by_b[(row, column - 6)],
        })
    }

    /// As the bodies move, r does: δr × F = −F × δr with δr = δp_B − δp_A.
    pub fn of_poses(&self, by_poses: &[Matrix6<T>; 2]) -> SMatrix<T, 12, 12> {
        let mut whole = self.of_blocks(by_poses);
        add_block(&mut whole, [6, 3], skew(&self.force));
        add_block(&mut whole, [6, 9], -skew(&self.force));
        whole
    }
}

/// Rows of the wrenches on A and on B about their origins, from those of the one on A, in axes that do not move.
pub(super) fn on_both<T: Scalar, const C: usize>(
    from_a_to_b: &Vector3<T>,
    on_a: &SMatrix<T, 6, C>,
) -> SMatrix<T, 12, C> {
    let mut shift = Matrix6::identity() * lift::<T>(-1.0);
    add_block(&mut shift, [0, 3], skew(from_a_to_b));
    let on_b = shift * on_a;
    SMatrix::from_fn(|row, column| {
        if row < 6 {
            on_a[(row, column)]
        } else {
            on_b[(row - 6, column)]
        }
    })
}
