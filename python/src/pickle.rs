//! Pickling of values as MessagePack. The format preserves every bit of a number, also of infinities and NaN.

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
    Ok((function, (to_bytes(py, value)?,)))
}

/// Serializes a value to bytes.
pub fn to_bytes<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyBytes>> {
    let bytes = rmp_serde::to_vec_named(value).map_err(value_error)?;
    Ok(PyBytes::new(py, &bytes))
}

/// Restores a value from bytes.
pub fn loaded<V: DeserializeOwned>(bytes: &[u8]) -> PyResult<V> {
    rmp_serde::from_slice(bytes).map_err(value_error)
}
