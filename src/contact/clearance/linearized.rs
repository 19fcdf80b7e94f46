use super::Clearance;
use crate::contact::ContactPair;
use crate::scalar::{DenseDual, real_part, real_vector};
use crate::spatial::Twist;
use nalgebra::{SVector, Vector2};

type Dual = DenseDual<14>;

/// A clearance with its first derivatives.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct LinearizedClearance {
    /// The clearance.
    pub clearance: Clearance,
    /// Derivatives of the distance with respect to motions of A and of B (angular and linear each; m/rad and m/m), as in
    /// [`LinearizedContact::by_poses`](crate::contact::LinearizedContact::by_poses).
    pub by_poses: SVector<f64, 12>,
    /// Derivatives of the distance with respect to the moduli of A and B (m/Pa). They are zero if the bodies are apart.
    pub by_moduli: Vector2<f64>,
}

impl ContactPair<'_> {
    /// Returns the clearance with its derivatives with respect to poses and moduli.
    #[must_use]
    pub fn linearized_clearance(&self) -> LinearizedClearance {
        let changes = SVector::<Dual, 14>::from_fn(|index, _| Dual::variable(0.0, index));
        let twist = |row| Twist::from_vector(&changes.fixed_rows::<6>(row).into_owned());
        let a = self.a().perturbed(&twist(0), changes[12]);
        let b = self.b().perturbed(&twist(6), changes[13]);
        let pair = ContactPair::new(a, b).with_search(self.search());
        let Clearance {
            distance,
            points,
            features,
        } = pair.clearance();
        LinearizedClearance {
            clearance: Clearance {
                distance: real_part(distance),
                points: points.each_ref().map(real_vector),
                features,
            },
            by_poses: SVector::from_fn(|row, _| distance.eps[row]),
            by_moduli: Vector2::new(distance.eps[12], distance.eps[13]),
        }
    }
}
