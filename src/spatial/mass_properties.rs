use nalgebra::{Matrix3, Vector3};

/// Derivatives of a number with respect to the mass properties of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassGradient {
    /// Derivative with respect to the mass (unit of the number per kg).
    pub by_mass: f64,
    /// Derivative with respect to the center of mass, in the axes of the body frame (per m).
    pub by_center_of_mass: Vector3<f64>,
    /// Derivative with respect to the entries of the inertia tensor about the center of mass, in
    /// the axes of the body frame (per kg m²). The tensor is symmetric, so only the mean of two
    /// opposite entries matters.
    pub by_inertia: Matrix3<f64>,
}

/// Mass, center of mass and inertia of a rigid body.
#[derive(Debug, Clone, Copy)]
pub struct MassProperties {
    /// Mass (kg).
    pub mass: f64,
    /// Center of mass (m), in the body frame.
    pub center_of_mass: Vector3<f64>,
    /// Inertia tensor (kg m²) about the center of mass, in the axes of the body frame.
    pub inertia: Matrix3<f64>,
}

impl MassProperties {
    /// Returns the mass properties of a body without mass.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            mass: 0.0,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::zeros(),
        }
    }

    /// Returns the mass properties of a solid ball around the origin, with the given mass (kg) and
    /// radius (m).
    #[must_use]
    pub fn solid_ball(mass: f64, radius: f64) -> Self {
        Self {
            mass,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::identity() * (0.4 * mass * radius * radius),
        }
    }
}
