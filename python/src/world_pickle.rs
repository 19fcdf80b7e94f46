//! Worlds that travel.

use crate::errors::refused;
use crate::path::{Kind, Path};
use crate::pickle::{Reduced, loaded, reduced};
use crate::world::{Inner, World};
use pyo3::prelude::*;
use std::sync::Arc;

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
