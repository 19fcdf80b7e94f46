use super::IdentificationError;
use super::error::check_positive;

/// Standard deviations of a measured pose, independent in each component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    pub(super) position: f64,
    pub(super) rotation: f64,
}

impl Noise {
    /// Standard deviations of each component of positions (m) and of rotation vectors (rad). If the model is only approximate, use
    /// the deviations that are expected of the model.
    ///
    /// # Errors
    /// If a deviation or its square is not positive and finite.
    pub fn new(position: f64, rotation: f64) -> Result<Self, IdentificationError> {
        check_positive("the variance of positions (m²)", position * position)?;
        check_positive("the variance of rotations (rad²)", rotation * rotation)?;
        check_positive("the deviation of positions (m)", position)?;
        check_positive("the deviation of rotations (rad)", rotation)?;
        Ok(Self { position, rotation })
    }
}

/// 1 mm and 0.01 rad.
impl Default for Noise {
    fn default() -> Self {
        Self {
            position: 1e-3,
            rotation: 1e-2,
        }
    }
}
