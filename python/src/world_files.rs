//! Files of trajectories.

use crate::arrays::{real, row, table};
use crate::errors::file_error;
use crate::trajectory::Trajectory;
use crate::world::World;
use hydroelastic::io::{Recording, write_trajectory};
use hydroelastic::nalgebra::Vector3;
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;

#[pymethods]
impl World {
    /// Writes a trajectory of this world as a table.
    ///
    /// The table has a row for each state and body: the position (m), the orientation (unit quaternion, w first), the velocity of the
    /// center of mass (m/s) and the angular velocity (rad/s). If the world has revolute or prismatic joints, the columns ``joint``,
    /// ``joint_position`` (rad or m) and ``joint_velocity`` have the joint of the body. They are empty for other bodies and for mimicking joints.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File with the extension .csv.
    /// trajectory : Trajectory
    ///     Trajectory of this world.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the trajectory does not fit the world, or the extension is wrong.
    /// OSError
    ///     If the file cannot be written to the disk.
    fn write_trajectory(
        &self,
        py: Python<'_>,
        path: PathBuf,
        trajectory: &Trajectory,
    ) -> PyResult<()> {
        py.detach(|| write_trajectory(path, &self.inner, &trajectory.inner))
            .map_err(file_error)
    }

    /// Writes a trajectory of this world as an animated glTF file, for Blender and other viewers.
    ///
    /// Contact surfaces are colored by pressure. Arrows show forces.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File with the extension .glb.
    /// trajectory : Trajectory
    ///     Trajectory of this world.
    /// slowdown : float
    ///     Playback time over simulated time.
    /// targets : dict of str to ((3,) array_like, float), optional
    ///     Balls that mark points, by name: center (m) and radius (m).
    /// paths : dict of str to (k, 3) array_like, optional
    ///     Lines, by name: points (m).
    /// camera : ((3,) array_like, (3,) array_like), optional
    ///     Position of the camera, and the point that the camera looks at (m).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the trajectory does not fit the world, the extension is wrong, or a number is out of range.
    /// OSError
    ///     If the file cannot be written to the disk.
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
        py.detach(|| recording.write(path)).map_err(file_error)
    }
}
