use crate::contact::{ContactPair, ContactWrench};
use crate::scalar::DenseDual;
use nalgebra::{SMatrix, SVector};

type Dual = DenseDual<28>;

/// Wrenches of a pair (N m, N) and their 12×28 Jacobian, computed with dual numbers through the whole pipeline.
///
/// Rows and columns have the order of [`LinearizedContact::jacobian`](crate::contact::LinearizedContact::jacobian). For a pair without
/// motion, the derivatives with respect to the twists and the surface law are zero.
///
/// This function is slower than the closed form. It is also less accurate if edges of a polygon nearly coincide.
#[must_use]
pub fn dual_wrench_jacobian(pair: &ContactPair) -> (ContactWrench, SMatrix<f64, 12, 28>) {
    let changes = SVector::from_fn(|index, _| Dual::variable(0.0, index));
    let wrench = pair.perturbed(&changes).pipeline().wrench();
    let on_both = [wrench.on_a, wrench.on_b].map(|wrench| wrench.to_vector());
    let jacobian = SMatrix::from_fn(|row, column| on_both[row / 6][row % 6].eps[column]);
    let values = ContactWrench {
        on_a: wrench.on_a.real(),
        on_b: wrench.on_b.real(),
    };
    (values, jacobian)
}
