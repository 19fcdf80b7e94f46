use super::{BodyShape, WorldError};
use crate::contact::{PartnerShape, STEEPEST, SurfaceLaw};
use crate::scalar::{Scalar, lift, real_part};

/// Contact properties of a body: stiffness, damping and friction.
#[derive(Debug, Clone, Copy)]
pub struct Material<T = f64> {
    /// Hydroelastic modulus (Pa), positive: pressure is modulus × extent. A rigid body has no
    /// modulus.
    pub modulus: Option<T>,
    /// Hunt–Crossley dissipation (s/m), not negative. The dissipation of a rigid body has no effect.
    pub dissipation: T,
    /// Coefficient of friction, not negative. `None` takes the coefficient of the partner in each contact.
    pub friction: Option<T>,
}

impl Material<f64> {
    /// Material of a compliant body with this hydroelastic modulus (Pa), without dissipation and friction.
    #[must_use]
    pub fn elastic(modulus: f64) -> Self {
        Self {
            modulus: Some(modulus),
            ..Self::rigid().with_friction(0.0)
        }
    }

    /// Material of a rigid body, without dissipation. Each contact has the friction of the partner.
    #[must_use]
    pub fn rigid() -> Self {
        Self {
            modulus: None,
            dissipation: 0.0,
            friction: None,
        }
    }

    /// Sets the dissipation (s/m).
    #[must_use]
    pub fn with_dissipation(self, dissipation: f64) -> Self {
        Self {
            dissipation,
            ..self
        }
    }

    /// Sets the coefficient of friction.
    #[must_use]
    pub fn with_friction(self, friction: f64) -> Self {
        let friction = Some(friction);
        Self { friction, ..self }
    }

    /// The material with zero derivatives.
    #[must_use]
    pub fn lifted<T: Scalar>(&self) -> Material<T> {
        Material {
            modulus: self.modulus.map(lift),
            dissipation: lift(self.dissipation),
            friction: self.friction.map(lift),
        }
    }
}

impl<T: Scalar> Material<T> {
    /// The material without derivatives.
    pub(super) fn real(&self) -> Material {
        Material {
            modulus: self.modulus.map(real_part),
            dissipation: real_part(self.dissipation),
            friction: self.friction.map(real_part),
        }
    }

    /// Contact law of two surfaces. The dissipations are weighted with the modulus of the *other* body, because each body dissipates in
    /// proportion to its deformation. A rigid body dissipates nothing. The coefficients of friction combine by their harmonic mean, so a
    /// coefficient of 0 makes the pair frictionless. A material without a coefficient takes the coefficient of the other material. Two
    /// materials without coefficients have no friction. The slip tolerance (m/s) is not checked.
    ///
    /// If both coefficients a and b are 0, the mean 2ab/(a + b) has directional derivatives, but no derivative. Dual numbers get 0, which
    /// is the derivative with respect to one of the coefficients alone.
    #[must_use]
    pub fn combined_with(&self, other: &Self, slip_tolerance: f64) -> SurfaceLaw<T> {
        let dissipation = match (self.modulus, other.modulus) {
            (Some(modulus), Some(other_modulus)) => {
                (self.dissipation * other_modulus + other.dissipation * modulus)
                    / (modulus + other_modulus)
            }
            (Some(_), None) => self.dissipation,
            (None, Some(_)) => other.dissipation,
            (None, None) => lift(0.0),
        };
        let friction = match (self.friction, other.friction) {
            (Some(a), Some(b)) if real_part(a + b) > 0.0 => a * b * 2.0 / (a + b),
            (Some(friction), None) | (None, Some(friction)) => friction,
            (Some(_), Some(_)) | (None, None) => lift(0.0),
        };
        SurfaceLaw {
            dissipation,
            friction,
            slip_tolerance,
        }
    }

    /// Checks that all numbers are in range, and that the material has a modulus unless the shape is rigid. A body without a
    /// shape needs no modulus.
    pub(super) fn check_on(&self, body: &str, shape: &BodyShape) -> Result<(), WorldError> {
        let body = || body.to_owned();
        let partner = shape.partner();
        match (partner.as_ref().map(|shape| shape.is_rigid()), self.modulus) {
            (Some(true), Some(_)) => return Err(WorldError::RigidWithModulus(body())),
            (Some(false), None) => return Err(WorldError::NoModulus(body())),
            (Some(true), None) | (Some(false), Some(_)) | (None, _) => {}
        }
        if let Some((quantity, value)) = self.number_out_of_range() {
            return Err(WorldError::Material {
                body: body(),
                quantity,
                value,
            });
        }
        let steepest = partner.map_or(0.0, PartnerShape::steepest);
        let slope = self.modulus.map_or(0.0, real_part) * steepest;
        if slope > STEEPEST {
            let body = body();
            return Err(WorldError::Steep { body, slope });
        }
        Ok(())
    }

    /// Name and value of the first number that is out of range.
    pub(super) fn number_out_of_range(&self) -> Option<(&'static str, f64)> {
        let modulus = self.modulus.map_or(1.0, real_part);
        if !(modulus > 0.0 && modulus.is_finite()) {
            return Some(("hydroelastic modulus", modulus));
        }
        let friction = self.friction.map_or(0.0, real_part);
        let not_negative = [
            ("dissipation", real_part(self.dissipation)),
            ("friction", friction),
        ];
        let mut values = not_negative.into_iter();
        values.find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
    }
}
