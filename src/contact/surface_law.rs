use super::BodyError;
use crate::scalar::{Scalar, real_part};
use std::ops::RangeInclusive;

/// Slip tolerances (m/s) of which squares and cubes, and their inverses, are numbers of double precision.
pub(crate) const SLIP_TOLERANCES: RangeInclusive<f64> = 1e-100..=1e100;

/// What the surfaces of a pair add to the elastic pressure when they move against each other.
///
/// With v the velocity of A relative to B at a point of the contact surface, v_n its part along the
/// normal (positive when separating) and v_t the rest, the pressure becomes
/// p' = p·max(0, 1 − d·v_n) with the dissipation d \[Hunt 1975\], and friction pulls A with the
/// traction −μ·p'·v_t/√(|v_t|² + v_s²): Coulomb's law made smooth at rest by the slip tolerance v_s.
///
/// Dissipation resists rolling too: skin that is pressed in pushes back more than skin that is let go.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceLaw<T = f64> {
    pub(crate) dissipation: T,
    pub(crate) friction: T,
    pub(crate) slip_tolerance: f64,
}

impl<T: Scalar> SurfaceLaw<T> {
    /// From the Hunt–Crossley dissipation d (s/m), the coefficient of friction μ, and the slip
    /// tolerance v_s (m/s): the speed at which friction has 71 % of its full value.
    ///
    /// # Errors
    /// If dissipation or friction is negative or not finite, or the slip tolerance is not from 1e-100 to 1e100 m/s.
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
    /// Hunt–Crossley dissipation (s/m).
    #[must_use]
    pub fn dissipation(&self) -> T {
        self.dissipation
    }

    /// Coefficient of friction.
    #[must_use]
    pub fn friction(&self) -> T {
        self.friction
    }

    /// Slip tolerance (m/s).
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

    /// Whether nothing is added to the elastic pressure, nor to its derivatives.
    pub(super) fn is_elastic(&self) -> bool {
        real_part(self.dissipation) == 0.0 && real_part(self.friction) == 0.0
    }
}
