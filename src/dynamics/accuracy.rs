use super::WorldError;
use super::validate::check_positive;

/// Upper bounds of the tight tolerances of values and of slopes.
const TIGHT: [f64; 2] = [1e-6, 3e-5];

/// Error tolerances of [`Integrator::Sdirk3`](super::Integrator::Sdirk3).
///
/// Each time step is divided until two errors are below their tolerances for every body. The first
/// is the local error of its velocity, or of its displacement over the duration if that is larger.
/// The second is the error of the derivatives of its motion. Let v be the speed of a body relative
/// to the bodies that it touches, with its spin multiplied by the radius of gyration. The speed v
/// is at least the speed of the spin, and is equal to it if the body touches nothing. Let f be the
/// *resting speed*. A tolerance t then allows
///
/// t·v + min(t·f⁴/v³, f·t^¼).
///
/// If a body is faster than f, the tolerance is relative. Below f the tolerance grows. Below f·t^¼,
/// which is 0.13 f for values and 0.21 f for slopes by default, impacts are not resolved, and
/// bodies come to rest. The error of the derivatives is a sum of two terms: the error of the rate
/// of displacement (m/s), and the error of the acceleration (m/s²) times a duration. The duration
/// is v/g, in which gravity changes the velocity by v, or 1 s if v/g is longer.
///
/// Each step has a budget of trials. For a group of n bodies that move together it is 2500/n² · (3e-4/t)^⅓ with the tolerance t of
/// values, and at least 4. Rejected substeps count, except those that are not solved or in which bodies might pass through each other.
/// Near the end of the budget, each substep may be five times as long as the one before, and is accepted whatever its error.
/// [`Work::missed`](super::Work::missed) counts the substeps that exceed the tolerances.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(
        try_from = "super::serial::AccuracyLayout",
        into = "super::serial::AccuracyLayout"
    )
)]
pub struct Accuracy {
    values: f64,
    slopes: f64,
    resting_speed: Option<f64>,
    /// Factor of every resting speed, whether set or default.
    resting_speed_factor: f64,
}

impl Default for Accuracy {
    fn default() -> Self {
        Self {
            values: 3e-4,
            slopes: 2e-3,
            resting_speed: None,
            resting_speed_factor: 1.0,
        }
    }
}

impl Accuracy {
    /// Tolerances of values and of slopes (derivatives), both relative. The defaults are 3e-4 and 2e-3.
    ///
    /// # Errors
    /// If a tolerance is not positive and finite.
    pub fn new(values: f64, slopes: f64) -> Result<Self, WorldError> {
        check_positive("tolerance of values", values)?;
        check_positive("tolerance of slopes", slopes)?;
        Ok(Self {
            values,
            slopes,
            ..Self::default()
        })
    }

    /// Sets the resting speed (m/s) of all bodies. The default for each body is the speed after a fall by a hundredth of its smallest
    /// extent under standard gravity. It is 0.14 m/s for a cube of 0.1 m.
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

    /// Returns tight tolerances for converged outcomes and derivatives, with a tenth of the resting speeds.
    pub(super) fn tight(self) -> Self {
        let [values, slopes] = TIGHT;
        let tenth = self.tenth();
        Self {
            values: values.min(tenth.values),
            slopes: slopes.min(tenth.slopes),
            resting_speed_factor: 0.1 * self.resting_speed_factor,
            ..self
        }
    }

    /// Returns a tenth of these tolerances, with the same resting speeds.
    pub(super) fn tenth(self) -> Self {
        Self {
            values: 0.1 * self.values,
            slopes: 0.1 * self.slopes,
            ..self
        }
    }

    /// Resting speed (m/s) of a body with the default resting speed `default` (m/s).
    pub(super) fn resting_speed_or(&self, default: f64) -> f64 {
        self.resting_speed_factor * self.resting_speed.unwrap_or(default)
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
