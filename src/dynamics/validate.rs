//! Checks of numbers that callers set.

use super::WorldError;
use crate::contact::SLIP_TOLERANCES;

/// Checks that numbers are finite.
pub(super) fn check_finite(quantity: &'static str, numbers: &[f64]) -> Result<(), WorldError> {
    let mut numbers = numbers.iter();
    numbers.try_for_each(|&value| check(quantity, value, true, "finite"))
}

/// Checks that a number is positive and finite.
pub(crate) fn check_positive(quantity: &'static str, value: f64) -> Result<(), WorldError> {
    check(quantity, value, value > 0.0, "positive and finite")
}

/// Checks that a slip tolerance (m/s) is in the range of the contact computation.
pub(super) fn check_slip_tolerance(value: f64) -> Result<(), WorldError> {
    let is_in_range = SLIP_TOLERANCES.contains(&value);
    check(
        "slip tolerance",
        value,
        is_in_range,
        "from 1e-100 to 1e100 m/s",
    )
}

/// Checks that a number is finite and not negative.
pub(super) fn check_not_negative(quantity: &'static str, value: f64) -> Result<(), WorldError> {
    check(quantity, value, value >= 0.0, "not negative and finite")
}

fn check(
    quantity: &'static str,
    value: f64,
    is_in_range: bool,
    expected: &'static str,
) -> Result<(), WorldError> {
    if is_in_range && value.is_finite() {
        return Ok(());
    }
    Err(WorldError::Setting {
        quantity,
        value,
        expected,
    })
}
