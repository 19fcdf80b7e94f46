//! Serialization of difference checks with serde.

use super::DifferenceCheck;
use nalgebra::DMatrix;

/// Serialized form of a difference check: the errors row by row, with `None` for infinity, which some formats cannot represent.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "DifferenceCheck", deny_unknown_fields)]
pub(super) struct CheckLayout {
    steps: Vec<f64>,
    numbers: Vec<String>,
    errors: Vec<Option<f64>>,
}

impl From<DifferenceCheck> for CheckLayout {
    fn from(check: DifferenceCheck) -> Self {
        let row_major = check.errors.transpose();
        let finite = |error: &f64| Some(*error).filter(|error| error.is_finite());
        Self {
            errors: row_major.iter().map(finite).collect(),
            steps: check.steps,
            numbers: check.numbers,
        }
    }
}

impl TryFrom<CheckLayout> for DifferenceCheck {
    type Error = String;

    fn try_from(layout: CheckLayout) -> Result<Self, String> {
        let CheckLayout {
            steps,
            numbers,
            errors,
        } = layout;
        let (count, rows, columns) = (errors.len(), steps.len(), numbers.len());
        if count != rows * columns {
            return Err(format!(
                "a check of {rows} steps and {columns} numbers must have {} errors, but has {count}",
                rows * columns
            ));
        }
        let errors = errors
            .into_iter()
            .map(|error| error.unwrap_or(f64::INFINITY));
        Ok(Self {
            errors: DMatrix::from_row_iterator(rows, columns, errors),
            steps,
            numbers,
        })
    }
}
