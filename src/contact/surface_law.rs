use super::BodyError;
use crate::scalar::{Scalar, real_part};
use std::ops::RangeInclusive;

/// Slip tolerances (m/s) whose squares, cubes and their inverses can be represented in double precision.
pub(crate) const SLIP_TOLERANCES: RangeInclusive<f64> = 1e-100..=1e100;

/// Law for the dissipation and friction that the relative motion of two surfaces adds to the elastic pressure.
///
/// Let v be the velocity of A relative to B at a point of the contact surface, v_n its part along the normal (positive if the surfaces
/// separate), and v_t the rest. The pressure becomes p' = p·max(0, 1 − d·v_n) with the dissipation d \[Hunt 1975\], and friction pulls A
/// with the traction −μ·p'·v_t/√(|v_t|² + v_s²). This is Coulomb's law, made smooth at rest by the slip tolerance v_s.
///
/// Dissipation also resists rolling, because the pressure is larger where the surfaces approach than where they separate.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceLaw<T = f64> {
    pub(crate) dissipation: T,
    pub(crate) friction: T,
    pub(crate) slip_tolerance: f64,
}

impl<T: Scalar> SurfaceLaw<T> {
    /// Creates a law from the Hunt–Crossley dissipation d (s/m), the coefficient of friction μ, and the slip tolerance v_s (m/s): the speed
    /// at which friction has 71 % of its full value.
    ///
    /// # Errors
    /// Returns an error if dissipation or friction is negative or not finite, or if the slip tolerance is not from 1e-100 to 1e100 m/s.
    pub fn new(dissipation: T, friction: T, slip_tolerance: f64) -> Result<Self, BodyError> {
        let not_negative = 0.0..=f64::MAX;
        let numbers = [
            ("dissipation", real_part(dissipation), &not_negative),
            ("friction", real_part(friction), &not_negative),
            ("slip tolerance", slip_tolerance, &SLIP_TOLERANCES),
        ];
        for (quantity, value, range) in numbers {
            if !range.contains(&value) {
                return Err(BodyError::SurfaceLaw { quantity, value });
            }
        }
        Ok(Self {
            dissipation,
            friction,
            slip_tolerance,
        })
    }
}

impl<T: Copy> SurfaceLaw<T> {
    /// Returns the Hunt–Crossley dissipation (s/m).
    #[must_use]
    pub fn dissipation(&self) -> T {
        self.dissipation
    }

    /// Returns the coefficient of friction.
    #[must_use]
    pub fn friction(&self) -> T {
        self.friction
    }

    /// Returns the slip tolerance (m/s).
    #[must_use]
    pub fn slip_tolerance(&self) -> f64 {
        self.slip_tolerance
    }
}

impl<T: Scalar> SurfaceLaw<T> {
    pub(super) fn real(&self) -> SurfaceLaw<f64> {
        SurfaceLaw {
            dissipation: real_part(self.dissipation),
            friction: real_part(self.friction),
            slip_tolerance: self.slip_tolerance,
        }
    }

    /// Returns whether the law adds nothing to the elastic pressure and its derivatives.
    pub(super) fn is_elastic(&self) -> bool {
        real_part(self.dissipation) == 0.0 && real_part(self.friction) == 0.0
    }
}
