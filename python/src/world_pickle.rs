//! Pickling of worlds and bodies.

use crate::body::Body;
use crate::errors::value_error;
use crate::path::{Kind, Path};
use crate::pickle::{Reduced, loaded, reduced};
use crate::world::{Inner, World};
use crate::world_joints::connecting_joint;
use hydroelastic::dynamics::{self, BodyState, State};
use pyo3::prelude::*;
use std::sync::Arc;

#[pymethods]
impl World {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_world", &self.saved()?)
    }
}

impl World {
    /// The world without paths, and the paths by name.
    fn saved(&self) -> PyResult<(Inner, Vec<(&str, &Kind)>)> {
        let mut still = self.inner.clone();
        for (name, _) in &self.paths {
            still = still.with_path(name, None).map_err(value_error)?;
        }
        let paths = self.paths.iter();
        let paths = paths.map(|(name, path)| (name.as_str(), &*path.0));
        Ok((still, paths.collect()))
    }
}

#[pymethods]
impl Body {
    /// Pickles a world that has only this body, at the time of its initial state, and the joint. The parent of the joint is not in the
    /// world.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        // A free body without inertia is not a valid world, so such a body is welded to the world, and its motion is saved apart.
        let free = self.inner.clone().without_joint();
        let pose = self.inner.initial_state().pose;
        let alone = dynamics::World::new(vec![free]).or_else(|_| {
            let weld = dynamics::Joint::fixed(self.inner.name()).with_origin(pose);
            dynamics::World::new(vec![self.inner.clone().with_joint(weld)?])
        });
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
        let joint = connecting_joint(&self.inner);
        let start = self.inner.initial_state();
        reduced(py, "_load_body", &(world.saved()?, joint, start))
    }
}

/// Restores a body from a pickle.
#[pyfunction]
pub fn _load_body(saved: &[u8]) -> PyResult<Body> {
    let (world, joint, start): (Saved, Option<dynamics::Joint>, BodyState) = loaded(saved)?;
    let body = world_of(world)?.bodies().into_iter().next();
    let body = body.ok_or_else(|| value_error("there is no body in what was saved"))?;
    let inner = match joint {
        Some(joint) => body.inner.with_joint(joint).map_err(value_error)?,
        None if connecting_joint(&body.inner).is_some() => {
            let free = body.inner.without_joint().with_pose(start.pose);
            free.with_velocity(start.twist.linear)
                .with_angular_velocity(start.twist.angular)
        }
        None => return Ok(body),
    };
    Ok(Body { inner, ..body })
}

/// Restores a world from a pickle.
#[pyfunction]
pub fn _load_world(saved: &[u8]) -> PyResult<World> {
    world_of(loaded(saved)?)
}

/// World without paths, and the paths by name.
type Saved = (Inner, Vec<(String, Kind)>);

fn world_of((mut inner, kinds): Saved) -> PyResult<World> {
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
