//! Worlds that travel: as JSON that keeps every bit.

use crate::errors::refused;
use crate::path::{Kind, Path};
use crate::world::{Inner, World};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// What `__reduce__` returns: a function of this module, and the bytes that it takes.
pub type Reduced<'py> = (Bound<'py, PyAny>, (Bound<'py, PyBytes>,));

/// A value as pickle keeps it.
pub fn reduced<'py>(py: Python<'py>, load: &str, value: &impl Serialize) -> PyResult<Reduced<'py>> {
    let function = py.import("hydroelastic._core")?.getattr(load)?;
    let saved = serde_json::to_vec(value).map_err(refused)?;
    Ok((function, (PyBytes::new(py, &saved),)))
}

/// A value from what pickle has kept.
pub fn loaded<V: DeserializeOwned>(saved: &[u8]) -> PyResult<V> {
    serde_json::from_slice(saved).map_err(refused)
}

#[pymethods]
impl World {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let mut still = self.inner.clone();
        for (name, _) in &self.paths {
            still = still.with_path(name, None).map_err(refused)?;
        }
        let paths: Vec<(&str, &Kind)> = self
            .paths
            .iter()
            .map(|(name, path)| (name.as_str(), &*path.0))
            .collect();
        reduced(py, "_load_world", &(&still, paths))
    }
}

/// A world from what pickle has kept.
#[pyfunction]
pub fn _load_world(saved: &[u8]) -> PyResult<World> {
    let (mut inner, kinds): (Inner, Vec<(String, Kind)>) = loaded(saved)?;
    let paths = kinds
        .into_iter()
        .map(|(name, kind)| (name, Path(Arc::new(kind))));
    let paths: Vec<(String, Path)> = paths.collect();
    for (name, path) in &paths {
        inner = inner
            .with_path(name, Some(path.function()))
            .map_err(refused)?;
    }
    Ok(World { inner, paths })
}
