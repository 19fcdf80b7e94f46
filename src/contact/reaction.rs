use crate::spatial::{add_block, skew};
use nalgebra::{Matrix6, SMatrix, Vector3};

/// Conversion of the wrench on A to the wrench on B: force −F, torque −(τ − r × F) about a point at r, which moves with B relative to A.
pub(super) struct Reaction {
    pub from_a_to_b: Vector3<f64>,
    pub force: Vector3<f64>,
}

impl Reaction {
    pub fn of_columns<const C: usize>(&self, on_a: &SMatrix<f64, 6, C>) -> SMatrix<f64, 12, C> {
        on_both(&self.from_a_to_b, on_a)
    }

    pub fn of_blocks(&self, [by_a, by_b]: &[Matrix6<f64>; 2]) -> SMatrix<f64, 12, 12> {
        let [by_a, by_b] = [by_a, by_b].map(|by| self.of_columns(by));
        SMatrix::from_fn(|row, column| match column {
            0..6 => by_a[(row, column)],
            _ => by_b[(row, column - 6)],
        })
    }

    /// Converts derivatives with respect to the poses. As the bodies move, r changes too: δr × F = −F × δr with δr = δp_B − δp_A.
    pub fn of_poses(&self, by_poses: &[Matrix6<f64>; 2]) -> SMatrix<f64, 12, 12> {
        let mut whole = self.of_blocks(by_poses);
        add_block(&mut whole, [6, 3], skew(&self.force));
        add_block(&mut whole, [6, 9], -skew(&self.force));
        whole
    }
}

/// Returns the rows of the wrenches on A and on B about their origins, from the rows of the wrench on A, in axes that do not move.
pub(super) fn on_both<const C: usize>(
    from_a_to_b: &Vector3<f64>,
    on_a: &SMatrix<f64, 6, C>,
) -> SMatrix<f64, 12, C> {
    let mut shift = -Matrix6::identity();
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
