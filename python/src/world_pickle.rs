//! Pickling of worlds and bodies.

use crate::body::Body;
use crate::errors::value_error;
use crate::path::{Kind, Path};
use crate::pickle::{Reduced, loaded, reduced};
use crate::world::{Inner, World};
use hydroelastic::dynamics::{self, State};
use pyo3::prelude::*;
use std::sync::Arc;

#[pymethods]
impl World {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let mut still = self.inner.clone();
        for (name, _) in &self.paths {
            still = still.with_path(name, None).map_err(value_error)?;
        }
        let paths: Vec<(&str, &Kind)> = self
            .paths
            .iter()
            .map(|(name, path)| (name.as_str(), &*path.0))
            .collect();
        reduced(py, "_load_world", &(&still, paths))
    }
}

#[pymethods]
impl Body {
    /// Pickles a world that has only this body, at the time of its initial state.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let alone = dynamics::World::new(vec![self.inner.clone()]);
        let start = State {
            joints: Vec::new(),
            time: self.inner.initial_time(),
            bodies: vec![*self.inner.initial_state()],
        };
        let inner = alone
            .and_then(|world| world.with_initial_state(&start)?.with_forces(Vec::new()))
            .map_err(value_error)?;
        let name = self.inner.name().to_owned();
        let paths = self.path.iter().map(|path| (name.clone(), path.clone()));
        let world = World {
            inner,
            paths: paths.collect(),
        };
        let (_, saved) = world.__reduce__(py)?;
        let function = py.import("hydroelastic._core")?.getattr("_load_body")?;
        Ok((function, saved))
    }
}

/// Restores a body from a pickle.
#[pyfunction]
pub fn _load_body(saved: &[u8]) -> PyResult<Body> {
    let world = world_of(saved)?;
    let body = world.bodies().into_iter().next();
    body.ok_or_else(|| value_error("there is no body in what was saved"))
}

/// Restores a world from a pickle.
#[pyfunction]
pub fn _load_world(saved: &[u8]) -> PyResult<World> {
    world_of(saved)
}

fn world_of(saved: &[u8]) -> PyResult<World> {
    let (mut inner, kinds): (Inner, Vec<(String, Kind)>) = loaded(saved)?;
    let paths = kinds
        .into_iter()
        .map(|(name, kind)| (name, Path(Arc::new(kind))));
    let paths: Vec<(String, Path)> = paths.collect();
    for (name, path) in &paths {
        inner = inner
            .with_path(name, Some(path.function()))
            .map_err(value_error)?;
    }
    Ok(World { inner, paths })
}
