//! Values that travel: as JSON that keeps every bit.

use crate::errors::value_error;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// What `__reduce__` returns: a function of this module, and the bytes that it takes.
pub type Reduced<'py> = (Bound<'py, PyAny>, (Bound<'py, PyBytes>,));

/// A value as pickle keeps it.
pub fn reduced<'py>(py: Python<'py>, load: &str, value: &impl Serialize) -> PyResult<Reduced<'py>> {
    let function = py.import("hydroelastic._core")?.getattr(load)?;
    let saved = serde_json::to_vec(value).map_err(value_error)?;
    Ok((function, (PyBytes::new(py, &saved),)))
}

/// A value from what pickle has kept.
pub fn loaded<V: DeserializeOwned>(saved: &[u8]) -> PyResult<V> {
    serde_json::from_slice(saved).map_err(value_error)
}
