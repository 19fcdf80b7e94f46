use crate::scalar::{
    Order, Scalar, change, constant_times, cross_constant, lift, real_part, real_vector,
};
use crate::spatial::{MassProperties, Pose, times_constant, turn_from_real};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Relative tolerance below which moments are made equal. Sums over thousands of tetrahedra have rounding errors of this size.
const SPHERE: f64 = 1e-12;

/// Tolerance of the triangle inequality of principal moments. A plate attains equality. Moments with five significant digits have errors of
/// up to 5e-5 each, so the largest may exceed the sum of the others by this fraction.
const FIVE_DIGITS: f64 = 1e-4;

/// Mass and rotational inertia of a body whose mass may carry derivatives.
///
/// The inertia is proportional to the mass. The ratios of the principal moments are constant.
#[derive(Debug, Clone, Copy)]
pub struct Inertia<T = f64> {
    /// Mass (kg).
    pub mass: T,
    /// Center of mass (m), in the body frame.
    pub center_of_mass: Vector3<f64>,
    /// Inertia per mass about the center of mass.
    pub(super) principal: PrincipalInertia,
    /// Factor of the inertia. Its derivatives are the effect of the radius of gyration, and its real part is 1.
    pub(super) factor: T,
}

/// Inertia per mass in principal axes, sorted by their moments.
#[derive(Debug, Clone, Copy)]
pub(super) struct PrincipalInertia {
    /// Principal moments (m²), in increasing order.
    pub moments: Vector3<f64>,
    /// Principal axes as columns, in the body frame, right-handed.
    pub axes: Matrix3<f64>,
}

impl Inertia<f64> {
    /// Inertia from mass properties. The inertia of a massless body is zero.
    pub(super) fn new(properties: &MassProperties) -> Self {
        let MassProperties {
            mass,
            center_of_mass,
            inertia,
        } = *properties;
        let per_mass = if mass > 0.0 { inertia / mass } else { inertia };
        Self::in_principal_axes(mass, center_of_mass, PrincipalInertia::of(per_mass))
    }

    /// Creates an inertia from its parts.
    pub(super) fn in_principal_axes(
        mass: f64,
        center_of_mass: Vector3<f64>,
        principal: PrincipalInertia,
    ) -> Self {
        Self {
            mass,
            center_of_mass,
            principal,
            factor: 1.0,
        }
    }

    /// The inertia with zero derivatives.
    pub(super) fn lifted<T: Scalar>(&self) -> Inertia<T> {
        Inertia {
            mass: lift(self.mass),
            center_of_mass: self.center_of_mass,
            principal: self.principal,
            factor: lift(self.factor),
        }
    }
}

impl<T> Inertia<T> {
    /// Returns the radius of gyration (m) about the center of mass: the square root of the mean principal moment per mass. The radius is
    /// negative if the mean is negative.
    pub(crate) fn radius_of_gyration(&self) -> f64 {
        let mean = self.principal.moments.mean();
        mean.abs().sqrt().copysign(mean)
    }

    /// Inertia tensor divided by the mass (m²), about the center of mass, in the axes of the body frame.
    pub(crate) fn per_mass(&self) -> Matrix3<f64> {
        let PrincipalInertia { moments, axes } = &self.principal;
        axes * Matrix3::from_diagonal(moments) * axes.transpose()
    }
}

impl<T: Scalar> Inertia<T> {
    /// The inertia without derivatives.
    pub(super) fn real(&self) -> Inertia {
        Inertia {
            mass: real_part(self.mass),
            center_of_mass: self.center_of_mass,
            principal: self.principal,
            factor: real_part(self.factor),
        }
    }

    /// Scales all principal moments by the same factor, to a radius of gyration (m) about the center of mass. The moments are negative for
    /// a negative radius.
    pub(crate) fn set_radius_of_gyration(&mut self, radius: T) {
        let before = self.radius_of_gyration();
        let ratio = real_part(radius) / before;
        self.principal.moments *= ratio * ratio.abs();
        let change = radius / real_part(radius);
        self.factor *= change * change;
    }

    /// Pose of a body after its orientation has changed to `rotation` and its center of mass has moved by `shift` (m).
    pub(super) fn turned_and_moved(
        &self,
        pose: &Pose<T>,
        rotation: &Matrix3<T>,
        shift: &Vector3<T>,
    ) -> Pose<T> {
        let before = pose.rotated_constant(&self.center_of_mass);
        let turned = Pose::from_drifted_rotation(rotation);
        let after = turned.rotated_constant(&self.center_of_mass);
        turned.with_translation(pose.translation() + before + shift - after)
    }

    /// Angular momentum I·ω of a body with this orientation, in world axes.
    #[must_use]
    pub fn angular_momentum(&self, rotation: &Matrix3<T>, angular: &Vector3<T>) -> Vector3<T> {
        self.angular_momentum_per_mass(rotation, angular) * self.mass
    }

    /// [`Self::angular_momentum`] divided by the mass.
    pub(super) fn angular_momentum_per_mass(
        &self,
        rotation: &Matrix3<T>,
        angular: &Vector3<T>,
    ) -> Vector3<T> {
        let principal = &self.principal;
        principal.times(rotation, &principal.moments, angular) * self.factor
    }

    /// Angular velocity I⁻¹·L of a body with this orientation, in world axes. It is not finite for a massless body.
    #[must_use]
    pub fn angular_velocity(&self, rotation: &Matrix3<T>, momentum: &Vector3<T>) -> Vector3<T> {
        let per_moments = self.principal.moments.map(f64::recip);
        self.principal.times(rotation, &per_moments, momentum) / (self.mass * self.factor)
    }
}

impl PrincipalInertia {
    /// Principal moments and axes of an inertia tensor divided by the mass. The tensor is symmetric up to rounding.
    pub fn of(inertia: Matrix3<f64>) -> Self {
        let SymmetricEigen {
            eigenvectors,
            eigenvalues,
        } = SymmetricEigen::new((inertia + inertia.transpose()) / 2.0);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigenvalues[i].total_cmp(&eigenvalues[j]));
        let mut axes = Matrix3::from_columns(&order.map(|axis| eigenvectors.column(axis)));
        if axes.determinant() < 0.0 {
            axes.column_mut(0).neg_mut();
        }
        let moments = Vector3::from(order.map(|axis| eigenvalues[axis]));
        let is_sphere = moments[2] - moments[0] <= SPHERE * moments[2];
        Self {
            moments: if is_sphere {
                Vector3::repeat(moments[1])
            } else {
                moments
            },
            axes,
        }
    }

    /// Whether a solid can have these moments, in increasing order. They must be positive and finite, and the largest must be at most the
    /// sum of the others, up to rounding to five digits.
    pub fn is_of_solid(&self) -> bool {
        let [smallest, middle, largest] = self.moments.into();
        let is_ordered = 0.0 < smallest && smallest <= middle && middle <= largest;
        is_ordered && largest.is_finite() && largest <= (smallest + middle) * (1.0 + FIVE_DIGITS)
    }

    /// Whether the moments are finite and in increasing order.
    #[cfg(feature = "serde")]
    pub fn is_sorted(&self) -> bool {
        self.moments.iter().all(|moment| moment.is_finite()) && self.moments.as_slice().is_sorted()
    }

    /// Whether all moments are equal to the last bit. The axes then have no effect.
    pub fn is_sphere(&self) -> bool {
        self.moments[2] - self.moments[0] <= 0.0
    }

    /// Principal axes in the world, as columns, of a body with this orientation.
    pub fn frame<T: Scalar>(&self, rotation: &Matrix3<T>) -> Matrix3<T> {
        times_constant(rotation, &self.axes)
    }

    /// Orientation of a body whose principal axes in the world are the columns of `frame`.
    pub fn rotation_of<T: Scalar>(&self, frame: &Matrix3<T>) -> Matrix3<T> {
        times_constant(frame, &self.axes.transpose())
    }

    /// Product of a vector and the matrix with these principal values, for a body with this orientation.
    fn times<T: Scalar>(
        &self,
        rotation: &Matrix3<T>,
        values: &Vector3<f64>,
        vector: &Vector3<T>,
    ) -> Vector3<T> {
        if self.is_sphere() {
            return vector.map(|component| component * values[1]);
        }
        if Order::<T>::IS_FIRST {
            // If the body turns by θ and the vector changes by dv, the product is J·(v + dv − θ × v) + θ × (J·v).
            let (frame, constant) = (self.frame(&rotation.map(real_part)), real_vector(vector));
            let product = scaled(&frame, values, &constant);
            let matrix = frame * Matrix3::from_diagonal(values) * frame.transpose();
            let turn = turn_from_real(rotation);
            let vector_change = vector.map(change) - cross_constant(&turn, &constant);
            let of_product =
                constant_times(&matrix, &vector_change) + cross_constant(&turn, &product);
            return of_product + product.map(lift::<T>);
        }
        scaled(&self.frame(rotation), values, vector)
    }
}

/// Vector after its components along the axes of a frame are scaled.
pub(super) fn scaled<T: Scalar>(
    frame: &Matrix3<T>,
    factors: &Vector3<f64>,
    vector: &Vector3<T>,
) -> Vector3<T> {
    let middle = factors[1];
    vector.map(|component| component * middle) + scaled_beyond(frame, factors, vector)
}

/// Difference between the result of [`scaled`] and the vector times the middle factor. The
/// difference is close to zero for a sphere, which has no distinct axes.
pub(super) fn scaled_beyond<T: Scalar>(
    frame: &Matrix3<T>,
    factors: &Vector3<f64>,
    vector: &Vector3<T>,
) -> Vector3<T> {
    let along = |axis: usize| {
        let direction = frame.column(axis);
        let along = direction.x * vector.x + direction.y * vector.y + direction.z * vector.z;
        let more = along * (factors[axis] - factors[1]);
        direction.map(|component| component * more)
    };
    along(0) + along(2)
}
