use super::element::Element;
use super::origin::origin_of;
use super::{UrdfError, UrdfWarning};
use crate::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3};

/// Tolerance of the triangle inequality of principal moments, relative to the largest moment. Numbers with five significant digits have
/// errors of this size.
const FIVE_DIGITS: f64 = 1e-4;

/// Radius of gyration (m) below which moments count as zero. Files with rounded numbers have moments of 1e-18 kg m² instead of zero.
const POINT_RADIUS: f64 = 1e-8;

/// Mass properties of an `<inertial>` element, in the link frame, and the warning about them.
pub(super) fn inertial_of(
    element: Element,
) -> Result<(MassProperties, Option<UrdfWarning>), UrdfError> {
    let pose = origin_of(element)?;
    let mass = element.required_child("mass", "<mass>")?;
    let mass = mass.at_least_zero("value", mass.required_number("value")?)?;
    let inertia = element.required_child("inertia", "<inertia>")?;
    let tensor = tensor_of(inertia)?;
    let moments = principal_moments(&tensor);
    let warning = (!is_possible(moments, mass)).then(|| UrdfWarning::ImpossibleInertia {
        at: inertia.location(),
        moments,
    });
    let properties = MassProperties {
        mass,
        center_of_mass: *pose.translation(),
        inertia: pose.rotation() * tensor * pose.rotation().transpose(),
    };
    Ok((properties, warning))
}

/// Tensor in the axes of the inertial frame.
fn tensor_of(inertia: Element) -> Result<Matrix3<f64>, UrdfError> {
    let entry = |name| inertia.required_number(name);
    let [xx, yy, zz] = [entry("ixx")?, entry("iyy")?, entry("izz")?];
    let [xy, xz, yz] = [entry("ixy")?, entry("ixz")?, entry("iyz")?];
    Ok(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// Eigenvalues in increasing order. The tensor is divided by its largest entry first, so that no product overflows.
fn principal_moments(tensor: &Matrix3<f64>) -> [f64; 3] {
    let largest = tensor.amax();
    if largest <= 0.0 {
        return [0.0; 3];
    }
    let eigenvalues: Vector3<f64> = (tensor / largest).symmetric_eigenvalues();
    let mut moments: [f64; 3] = (eigenvalues * largest).into();
    moments.sort_by(f64::total_cmp);
    moments
}

/// Whether a solid, a plate, a rod or a point can have these moments (kg m²), in increasing order.
fn is_possible([smallest, middle, largest]: [f64; 3], mass: f64) -> bool {
    let excess = largest - (smallest + middle);
    let tolerance = FIVE_DIGITS * largest.max(0.0) + POINT_RADIUS * POINT_RADIUS * mass;
    smallest >= -tolerance && excess <= tolerance
}
