use crate::scalar::{Scalar, lift};
use crate::spatial::{MassProperties, times_constant};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Moments that differ by less than this fraction of the largest are the same: a body of such
/// moments turns like a sphere, to round-off.
const ISOTROPY: f64 = 1e-12;

/// Mass and rotational inertia of a body whose mass may carry derivatives.
///
/// The shape of the inertia is constant; the mass scales it.
#[derive(Debug, Clone, Copy)]
pub struct Inertia<T = f64> {
    /// Mass (kg).
    pub mass: T,
    /// Centre of mass (m), in the body frame.
    pub center_of_mass: Vector3<f64>,
    /// Principal moments over the mass (m²), about the centre of mass.
    pub(super) unit_moments: Vector3<f64>,
    /// The principal axes, as columns in the body frame.
    pub(super) principal_axes: Matrix3<f64>,
}

impl Inertia<f64> {
    /// From mass properties with positive mass and principal moments.
    pub(super) fn new(properties: &MassProperties) -> Self {
        let unit_inertia = properties.inertia / properties.mass;
        let SymmetricEigen {
            mut eigenvectors,
            eigenvalues,
        } = SymmetricEigen::new(unit_inertia);
        if eigenvectors.determinant() < 0.0 {
            eigenvectors.column_mut(0).neg_mut();
        }
        let isotropic = eigenvalues.max() - eigenvalues.min() <= ISOTROPY * eigenvalues.max();
        let (unit_moments, principal_axes) = if isotropic {
            (Vector3::repeat(eigenvalues.mean()), Matrix3::identity())
        } else {
            (eigenvalues, eigenvectors)
        };
        Self {
            mass: properties.mass,
            center_of_mass: properties.center_of_mass,
            unit_moments,
            principal_axes,
        }
    }

    /// The constant inertia.
    pub(super) fn lifted<T: Scalar>(&self) -> Inertia<T> {
        Inertia {
            mass: lift(self.mass),
            center_of_mass: self.center_of_mass,
            unit_moments: self.unit_moments,
            principal_axes: self.principal_axes,
        }
    }
}

impl<T: Scalar> Inertia<T> {
    /// Whether all principal moments are the same (the paper's scalar inertia).
    #[must_use]
    pub fn is_isotropic(&self) -> bool {
        self.unit_moments.max() - self.unit_moments.min() <= ISOTROPY * self.unit_moments.max()
    }

    /// I·ω for a body of the given orientation, both in world axes.
    #[must_use]
    pub fn angular_momentum(&self, rotation: &Matrix3<T>, angular: &Vector3<T>) -> Vector3<T> {
        self.scaled_by_moments(rotation, angular, |moment| moment) * self.mass
    }

    /// I⁻¹·L for a body of the given orientation, both in world axes.
    #[must_use]
    pub fn angular_velocity(&self, rotation: &Matrix3<T>, momentum: &Vector3<T>) -> Vector3<T> {
        self.scaled_by_moments(rotation, momentum, f64::recip) / self.mass
    }

    /// The principal axes in the world, as columns.
    pub(super) fn principal_frame(&self, rotation: &Matrix3<T>) -> Matrix3<T> {
        times_constant(rotation, &self.principal_axes)
    }

    /// The orientation of a body whose principal axes in the world are the columns.
    pub(super) fn rotation_of(&self, principal_frame: &Matrix3<T>) -> Matrix3<T> {
        times_constant(principal_frame, &self.principal_axes.transpose())
    }

    /// I·ω/m (m²/s), given the principal axes in the world as columns.
    pub(super) fn unit_momentum(
        &self,
        principal_frame: &Matrix3<T>,
        angular: &Vector3<T>,
    ) -> Vector3<T> {
        self.scaled_in_frame(principal_frame, angular, |moment| moment)
    }

    /// The inverse of [`Self::unit_momentum`].
    pub(super) fn velocity_of_unit(
        &self,
        principal_frame: &Matrix3<T>,
        unit_momentum: &Vector3<T>,
    ) -> Vector3<T> {
        self.scaled_in_frame(principal_frame, unit_momentum, f64::recip)
    }

    fn scaled_by_moments(
        &self,
        rotation: &Matrix3<T>,
        vector: &Vector3<T>,
        factor: impl Fn(f64) -> f64,
    ) -> Vector3<T> {
        if self.is_isotropic() {
            let factor = factor(self.unit_moments.x);
            return vector.map(|component| component * factor);
        }
        self.scaled_in_frame(&self.principal_frame(rotation), vector, factor)
    }

    fn scaled_in_frame(
        &self,
        principal_frame: &Matrix3<T>,
        vector: &Vector3<T>,
        factor: impl Fn(f64) -> f64,
    ) -> Vector3<T> {
        let along_axes = principal_frame.transpose() * vector;
        principal_frame * along_axes.zip_map(&self.unit_moments, |along, m| along * factor(m))
    }
}
