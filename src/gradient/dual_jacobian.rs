use crate::contact::{ContactPair, ContactWrench, SurfaceLaw};
use crate::scalar::DenseDual;
use crate::spatial::Twist;
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
    let wrench = perturbed_wrench(pair, &changes);
    let on_both = [wrench.on_a, wrench.on_b].map(|wrench| wrench.to_vector());
    let jacobian = SMatrix::from_fn(|row, column| on_both[row / 6][row % 6].eps[column]);
    let values = ContactWrench {
        on_a: wrench.on_a.real(),
        on_b: wrench.on_b.real(),
    };
    (values, jacobian)
}

/// Wrenches after changes of poses, twists, moduli, dissipation and friction.
fn perturbed_wrench(pair: &ContactPair, changes: &SVector<Dual, 28>) -> ContactWrench<Dual> {
    let twist = |row| Twist::from_vector(&changes.fixed_rows::<6>(row).into_owned());
    let perturbed = ContactPair::new(
        pair.a().perturbed(&twist(0), changes[24]),
        pair.b().perturbed(&twist(6), changes[25]),
    );
    let perturbed = perturbed.with_search(pair.search());
    let Some(motion) = pair.motion() else {
        return perturbed.pipeline().wrench();
    };
    let law = SurfaceLaw {
        dissipation: changes[26] + motion.law.dissipation,
        friction: changes[27] + motion.law.friction,
        slip_tolerance: motion.law.slip_tolerance,
    };
    let [mut twist_a, mut twist_b] = [twist(12), twist(18)];
    for (change, twist) in [&mut twist_a, &mut twist_b].into_iter().zip(&motion.twists) {
        change.angular += twist.angular.map(Dual::from);
        change.linear += twist.linear.map(Dual::from);
    }
    perturbed
        .moving(law, [twist_a, twist_b])
        .pipeline()
        .wrench()
}
