//! Pickling of values as JSON that keeps every bit.

use crate::errors::value_error;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Result of `__reduce__`: a function of this module, and the bytes that the function reads.
pub type Reduced<'py> = (Bound<'py, PyAny>, (Bound<'py, PyBytes>,));

/// Serializes a value. `load` is the name of the function that restores it.
pub fn reduced<'py>(py: Python<'py>, load: &str, value: &impl Serialize) -> PyResult<Reduced<'py>> {
    let function = py.import("hydroelastic._core")?.getattr(load)?;
    let saved = serde_json::to_vec(value).map_err(value_error)?;
    Ok((function, (PyBytes::new(py, &saved),)))
}

/// Restores a value from the bytes of a pickle.
pub fn loaded<V: DeserializeOwned>(saved: &[u8]) -> PyResult<V> {
    serde_json::from_slice(saved).map_err(value_error)
}
