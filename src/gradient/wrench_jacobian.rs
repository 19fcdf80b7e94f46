use crate::contact::{ContactJacobian, ContactPair, ContactWrench, WrenchJacobian};
use crate::spatial::Twist;
use nalgebra::{SMatrix, SVector};
use num_dual::{DualSVec64, jacobian};

/// The wrenches of a pair and their 6×14 Jacobians, by dual numbers through the whole pipeline.
///
/// Slower than the closed form, and less accurate where edges of a polygon nearly coincide.
#[must_use]
pub fn dual_wrench_jacobian(pair: &ContactPair) -> (ContactWrench, ContactJacobian) {
    let (_, derivatives) = jacobian(|motion| wrenches_after(pair, &motion), &SVector::zeros());
    let by_rows = |row| {
        let rows: SMatrix<f64, 6, 14> = derivatives.fixed_rows::<6>(row).into_owned();
        WrenchJacobian::from_matrix(&rows)
    };
    let jacobian = ContactJacobian {
        on_a: by_rows(0),
        on_b: by_rows(6),
    };
    (pair.wrench(), jacobian)
}

/// Both wrenches after a motion: twist of A, twist of B, changes of the moduli.
fn wrenches_after(
    pair: &ContactPair,
    motion: &SVector<DualSVec64<14>, 14>,
) -> SVector<DualSVec64<14>, 12> {
    let twist = |row| Twist::from_vector(&motion.fixed_rows::<6>(row).into_owned());
    let moved = ContactPair::new(
        pair.a().perturbed(&twist(0), motion[12]),
        pair.b().perturbed(&twist(6), motion[13]),
    );
    let wrench = moved.wrench();
    let (on_a, on_b) = (wrench.on_a.to_vector(), wrench.on_b.to_vector());
    SVector::from_fn(|row, _| if row < 6 { on_a[row] } else { on_b[row - 6] })
}
