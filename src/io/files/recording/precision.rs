//! Conversion to the single precision of glTF.

/// Rounds numbers to single precision.
#[expect(clippy::cast_possible_truncation, reason = "glTF has single precision")]
pub(super) fn single<const N: usize>(numbers: [f64; N]) -> [f32; N] {
    numbers.map(|number| number as f32)
}
