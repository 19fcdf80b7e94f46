use crate::geometry::Tetrahedron;
use crate::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3};

/// Exact mass properties of the sum of signed tetrahedra at a uniform density (kg/m³).
///
/// Over a tetrahedron with corners at `c` from any origin, ∫ x xᵀ dV = V/20·(Σ c cᵀ + s sᵀ) with
/// s = Σ c. The origin should be in the middle of them, so that little cancels.
pub(super) fn mass_properties(
    origin: Vector3<f64>,
    tetrahedra: impl Iterator<Item = Tetrahedron>,
    density: f64,
) -> MassProperties {
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
    let offset = first / volume;
    let central = second - offset * offset.transpose() * volume;
    MassProperties {
        mass: density * volume,
        center_of_mass: origin + offset,
        inertia: (Matrix3::identity() * central.trace() - central) * density,
    }
}
