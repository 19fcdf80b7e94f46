use super::IdentificationError;
use super::error::check_scale;

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
    /// If a deviation is not between 1e-150 and 1e150.
    pub fn new(position: f64, rotation: f64) -> Result<Self, IdentificationError> {
        check_scale("the deviation of positions (m)", position)?;
        check_scale("the deviation of rotations (rad)", rotation)?;
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
