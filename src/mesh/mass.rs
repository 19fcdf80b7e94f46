use crate::geometry::{FACES, Tetrahedron};
use crate::spatial::{MassGradient, MassProperties};
use nalgebra::{Matrix3, Vector3};

/// An invalid density: not positive and finite, or with a mass or inertia that is not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the density is {0} kg/m³, but must be positive, with a finite mass and inertia")]
pub struct DensityError(pub f64);

/// Returns the volume (m³), first moment (m⁴) and second moment (m⁵) of a sum of signed tetrahedra about an origin.
///
/// Over a tetrahedron with corners at `c` from the origin, ∫ x xᵀ dV = V/20·(Σ c cᵀ + s sᵀ) with s = Σ c.
fn moments(
    origin: &Vector3<f64>,
    tetrahedra: impl Iterator<Item = Tetrahedron>,
) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for tetrahedron in tetrahedra {
        let tet_volume = tetrahedron.signed_volume();
        let corners = tetrahedron.corners.map(|corner| corner - origin);
        let sum: Vector3<f64> = corners.iter().sum();
        let squares: Matrix3<f64> = corners.iter().map(|c| c * c.transpose()).sum();
        volume += tet_volume;
        first += sum * (tet_volume / 4.0);
        second += (squares + sum * sum.transpose()) * (tet_volume / 20.0);
    }
    (volume, first, second)
}

/// Returns the centroid (m) of a sum of signed tetrahedra. See [`mass_properties`] for the arguments.
pub(super) fn center(
    origin: Vector3<f64>,
    tetrahedra: impl Iterator<Item = Tetrahedron>,
) -> Vector3<f64> {
    let (volume, first, _) = moments(&origin, tetrahedra);
    origin + first / volume
}

/// Computes the exact mass properties of a sum of signed tetrahedra of uniform density (kg/m³).
///
/// An origin near the center of the solid keeps cancellation small.
pub(super) fn mass_properties(
    origin: Vector3<f64>,
    tetrahedra: impl Iterator<Item = Tetrahedron>,
    density: f64,
) -> Result<MassProperties, DensityError> {
    let (volume, first, second) = moments(&origin, tetrahedra);
    let offset = first / volume;
    let central = second - offset * offset.transpose() * volume;
    let properties = MassProperties {
        mass: density * volume,
        center_of_mass: origin + offset,
        inertia: (Matrix3::identity() * central.trace() - central) * density,
    };
    let inertia = properties.inertia.sum();
    if density > 0.0 && properties.mass.is_finite() && inertia.is_finite() {
        Ok(properties)
    } else {
        Err(DensityError(density))
    }
}

/// Computes the derivatives of a scalar with respect to the corners of each tetrahedron, at uniform density (kg/m³).
/// `gradient` holds its derivatives with respect to the mass properties of the sum. See [`mass_properties`] for the
/// other arguments.
///
/// An integral over a tetrahedron of volume V depends on corner i in two ways. The volume contributes V∇λᵢ times the
/// mean of the integrand. The moments of the corners contribute the rest.
pub(super) fn mass_gradients(
    origin: Vector3<f64>,
    tetrahedra: impl Iterator<Item = Tetrahedron> + Clone,
    density: f64,
    gradient: &MassGradient,
) -> Result<impl Iterator<Item = [Vector3<f64>; 4]>, DensityError> {
    let MassProperties {
        mass,
        center_of_mass,
        ..
    } = mass_properties(origin, tetrahedra.clone(), density)?;
    let (volume, center) = (mass / density, center_of_mass - origin);
    let by_inertia = (gradient.by_inertia + gradient.by_inertia.transpose()) * 0.5;
    let by_second = (Matrix3::identity() * by_inertia.trace() - by_inertia) * density;
    let by_center = gradient.by_center_of_mass / volume;
    let by_first = by_center - by_second * center * 2.0;
    let by_volume =
        density * gradient.by_mass - by_center.dot(&center) + center.dot(&(by_second * center));
    Ok(tetrahedra.map(move |tetrahedron| {
        let corners = tetrahedron.corners.map(|corner| corner - origin);
        let sum: Vector3<f64> = corners.iter().sum();
        let squares = corners
            .iter()
            .chain([&sum])
            .map(|c| c.dot(&(by_second * c)));
        let mean = by_volume + by_first.dot(&sum) / 4.0 + squares.sum::<f64>() / 20.0;
        let tet_volume = tetrahedron.signed_volume();
        std::array::from_fn(|corner| {
            let [a, b, c] = FACES[corner].map(|of_face| corners[of_face]);
            let by_corner = (b - a).cross(&(c - a)) / -6.0;
            let moved = by_first / 4.0 + by_second * (corners[corner] + sum) / 10.0;
            by_corner * mean + moved * tet_volume
        })
    }))
}
