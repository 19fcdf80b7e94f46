use crate::contact::{ContactJacobian, ContactPair, ContactWrench, WrenchJacobian};
use crate::scalar::DenseDual;
use crate::spatial::{Twist, Wrench};
use nalgebra::{SMatrix, SVector};

/// The numbers a pair moves by: twist of A, twist of B, changes of the moduli.
type Motion = SVector<DenseDual<14>, 14>;

/// The wrenches of a pair and their 6×14 Jacobians, by dual numbers through the whole pipeline.
///
/// Slower than the closed form, and less accurate where edges of a polygon nearly coincide.
#[must_use]
pub fn dual_wrench_jacobian(pair: &ContactPair) -> (ContactWrench, ContactJacobian) {
    let motion = Motion::from_fn(|number, _| DenseDual::variable(0.0, number));
    let wrench = wrench_after(pair, &motion);
    let jacobian = ContactJacobian {
        on_a: derivatives(&wrench.on_a),
        on_b: derivatives(&wrench.on_b),
    };
    let values = ContactWrench {
        on_a: wrench.on_a.real(),
        on_b: wrench.on_b.real(),
    };
    (values, jacobian)
}

fn wrench_after(pair: &ContactPair, motion: &Motion) -> ContactWrench<DenseDual<14>> {
    let twist = |row| Twist::from_vector(&motion.fixed_rows::<6>(row).into_owned());
    let moved = ContactPair::new(
        pair.a().perturbed(&twist(0), motion[12]),
        pair.b().perturbed(&twist(6), motion[13]),
    );
    moved.with_search(pair.search()).pipeline().wrench()
}

fn derivatives(wrench: &Wrench<DenseDual<14>>) -> WrenchJacobian {
    let rows = wrench.to_vector();
    let matrix: SMatrix<f64, 6, 14> = SMatrix::from_fn(|row, column| rows[row].eps[column]);
    WrenchJacobian::from_matrix(&matrix)
}
