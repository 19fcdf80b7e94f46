use super::deviations::PER_POSE;
use crate::scalar::portable::ln_1p;

/// Loss ρ(s) of a measured pose, with the squared deviation s in units of the noise. For a correct model, s has the mean 6: three
/// components of the position and three of the rotation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum RobustLoss {
    /// ρ(s) = s: least squares.
    #[default]
    Squared,
    /// ρ(s) = s up to the squared threshold d², and 2d√s − d² above it. The threshold d is in units of the noise. A usual value is 4.
    Huber(f64),
    /// ρ(s) = c² ln(1 + s/c²). The scale c is in units of the noise. The weight of a pose is c²/(c² + s). A usual value is 4.
    Cauchy(f64),
}

impl RobustLoss {
    /// Threshold or scale of the loss, or 1 for least squares.
    pub(super) fn scale(self) -> f64 {
        match self {
            Self::Squared => 1.0,
            Self::Huber(scale) | Self::Cauchy(scale) => scale,
        }
    }

    /// Loss ρ and its derivative for each pose, from the deviations of all poses.
    pub(super) fn of_poses(self, deviations: &[f64]) -> impl Iterator<Item = [f64; 2]> {
        let squared = |pose: &[f64]| pose.iter().map(|deviation| deviation * deviation).sum();
        let poses = deviations.chunks(PER_POSE);
        poses.map(move |pose| self.at(squared(pose)))
    }

    /// Loss ρ and its derivative at a squared deviation.
    pub(super) fn at(self, squared: f64) -> [f64; 2] {
        match self {
            Self::Huber(threshold) if squared > threshold * threshold => {
                let deviation = squared.sqrt();
                let loss = 2.0 * threshold * deviation - threshold * threshold;
                [loss, threshold / deviation]
            }
            Self::Squared | Self::Huber(_) => [squared, 1.0],
            Self::Cauchy(scale) => {
                let scale_squared = scale * scale;
                [
                    scale_squared * ln_1p(squared / scale_squared),
                    scale_squared / (scale_squared + squared),
                ]
            }
        }
    }
}
