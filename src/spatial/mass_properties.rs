use nalgebra::{Matrix3, Vector3};

/// The derivatives of a number by the mass properties of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassGradient {
    /// By the mass (the number's unit over kg).
    pub by_mass: f64,
    /// By the centre of mass, in the axes of the body frame (over m).
    pub by_center_of_mass: Vector3<f64>,
    /// By the entries of the inertia tensor about the centre of mass, in the axes of the body frame (over kg m²). The tensor is
    /// symmetric: the mean of two opposite entries counts.
    pub by_inertia: Matrix3<f64>,
}

/// Mass, centre of mass and inertia of a rigid body.
#[derive(Debug, Clone, Copy)]
pub struct MassProperties {
    /// Mass (kg).
    pub mass: f64,
    /// Centre of mass (m), in the body frame.
    pub center_of_mass: Vector3<f64>,
    /// Inertia tensor (kg m²) about the centre of mass, in the axes of the body frame.
    pub inertia: Matrix3<f64>,
}

impl MassProperties {
    /// Those of a solid ball around the origin: mass (kg), radius (m).
    #[must_use]
    pub fn solid_ball(mass: f64, radius: f64) -> Self {
        Self {
            mass,
            center_of_mass: Vector3::zeros(),
            inertia: Matrix3::identity() * (0.4 * mass * radius * radius),
        }
    }
}
