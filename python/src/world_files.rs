//! Files of what a world did.

use crate::arrays::{real, row, table};
use crate::errors::value_error;
use crate::trajectory::Trajectory;
use crate::world::World;
use hydroelastic::io::{Recording, write_trajectory};
use hydroelastic::nalgebra::Vector3;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[pymethods]
impl World {
    /// Writes a trajectory of this world as a table (.csv): a row for each state and body, with its position (m), orientation
    /// (unit quaternion, w first), velocity of the center of mass (m/s) and spin (rad/s).
    fn write_trajectory(
        &self,
        py: Python<'_>,
        path: PathBuf,
        trajectory: &Trajectory,
    ) -> PyResult<()> {
        py.detach(|| write_trajectory(path, &self.inner, &trajectory.inner))
            .map_err(value_error)
    }

    /// Writes a trajectory of this world as an animated glTF file (.glb), with contact surfaces colored by pressure and arrows
    /// for forces, for Blender and any other viewer.
    ///
    /// Parameters
    /// ----------
    /// slowdown : how many seconds a second lasts.
    /// targets : balls that mark points: {name: ((3,) point (m), radius (m))}.
    /// paths : lines: {name: (k, 3) float64, points (m)}.
    /// camera : where it is and where it looks, two points (m).
    #[pyo3(signature = (path, trajectory, *, slowdown=1.0, targets=None, paths=None, camera=None))]
    fn write_recording<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        trajectory: &Trajectory,
        #[pyo3(from_py_with = real)] slowdown: f64,
        targets: Option<BTreeMap<String, (Bound<'py, PyAny>, Bound<'py, PyAny>)>>,
        paths: Option<BTreeMap<String, Bound<'py, PyAny>>>,
        camera: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    ) -> PyResult<()> {
        let mut recording = Recording::new(&self.inner, &trajectory.inner).slowed(slowdown);
        for (name, (point, radius)) in targets.unwrap_or_default() {
            let (point, radius) = (row::<3>(&point, "point")?, real(&radius)?);
            recording = recording.with_target(&name, point.into(), radius);
        }
        for (name, points) in paths.unwrap_or_default() {
            let points = table::<3>(&points, "points")?;
            recording = recording.with_path(&name, points.into_iter().map(Vector3::from));
        }
        if let Some((eye, point)) = camera {
            let [eye, point] = [row::<3>(&eye, "camera")?, row::<3>(&point, "camera")?];
            recording = recording.seen_from(eye.into(), point.into());
        }
        py.detach(|| recording.write(path)).map_err(value_error)
    }
}
