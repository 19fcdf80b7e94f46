use super::WorldError;
use super::settings::check_positive;

/// How closely implicit steps with error control follow the motion ([`Plan::with_accuracy`](super::Plan::with_accuracy)).
///
/// A step of a plan is divided until both tolerances hold for every body. With v the speed of a body relative to the bodies
/// that it touches or approaches (including its spin, by the radius of gyration) and f the resting speed:
/// - an error of its velocity may change its kinetic energy by `values`·m·(v² + f²);
/// - an error of the derivative of its velocity may reach `slopes`·(v² + f²)/v over the flight that v can cause, v/g and at
///   most 1 s.
///
/// So a fast body has the relative tolerance `values`, and a body at rest the absolute one f·√(2·`values`).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Accuracy {
    values: f64,
    slopes: f64,
    resting_speed: Option<f64>,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self {
            values: 1e-3,
            slopes: 3e-3,
            resting_speed: None,
        }
    }
}

impl Accuracy {
    /// Tolerances of values and of slopes, both relative.
    ///
    /// # Errors
    /// If a tolerance is not positive and finite.
    pub fn new(values: f64, slopes: f64) -> Result<Self, WorldError> {
        check_positive("tolerance of values", values)?;
        check_positive("tolerance of slopes", slopes)?;
        Ok(Self {
            values,
            slopes,
            resting_speed: None,
        })
    }

    /// The same tolerances with a resting speed (m/s) for all bodies. By default the resting speed of a body is that of a fall by
    /// a hundredth of its smallest extent.
    ///
    /// # Errors
    /// If the speed is not positive and finite.
    pub fn with_resting_speed(self, speed: f64) -> Result<Self, WorldError> {
        check_positive("resting speed", speed)?;
        Ok(Self {
            resting_speed: Some(speed),
            ..self
        })
    }

    /// Tolerance of values.
    #[must_use]
    pub fn values(&self) -> f64 {
        self.values
    }

    /// Tolerance of slopes.
    #[must_use]
    pub fn slopes(&self) -> f64 {
        self.slopes
    }

    /// Resting speed (m/s) of all bodies, if it was set.
    #[must_use]
    pub fn resting_speed(&self) -> Option<f64> {
        self.resting_speed
    }
}
