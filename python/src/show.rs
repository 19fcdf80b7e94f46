//! Pictures for notebooks, drawn by `hydroelastic.view`.

use crate::arrays::{Whole, optional_real, whole};
use crate::state::State;
use crate::surface::Surface;
use crate::trajectory::Trajectory;
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Calls `hydroelastic.view.picture` for a value.
fn picture<'py>(
    value: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let view = value.py().import("hydroelastic.view")?;
    view.call_method("picture", (value,), Some(options))
}

/// HTML of a picture for the output of a notebook cell.
fn html<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    picture(value, &PyDict::new(value.py()))?.call_method0("_repr_html_")
}

#[pymethods]
impl Surface {
    /// Draws the polygons, colored by pressure, for a notebook or a file.
    ///
    /// Parameters
    /// ----------
    /// pressure_limit : float, optional
    ///     Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    /// height : int
    ///     Height (pixels) of the picture in a notebook.
    ///
    /// Returns
    /// -------
    /// hydroelastic.view.Picture
    ///     Picture that can be turned.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a number is out of range.
    #[pyo3(signature = (*, pressure_limit=None, height=420))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        #[pyo3(from_py_with = optional_real)] pressure_limit: Option<f64>,
        #[pyo3(from_py_with = whole)] height: Whole,
    ) -> PyResult<Bound<'py, PyAny>> {
        let options = PyDict::new(slf.py());
        options.set_item("pressure_limit", pressure_limit)?;
        options.set_item("height", height)?;
        picture(slf.as_any(), &options)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        html(slf.as_any())
    }
}

#[pymethods]
impl World {
    /// Draws translucent bodies and the contact surfaces between them, for a notebook or a file.
    ///
    /// Parameters
    /// ----------
    /// state : State, optional
    ///     State of this world. Default: the initial state.
    /// pressure_limit : float, optional
    ///     Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    /// height : int
    ///     Height (pixels) of the picture in a notebook.
    ///
    /// Returns
    /// -------
    /// hydroelastic.view.Picture
    ///     Picture that can be turned.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world, or a number is out of range.
    #[pyo3(signature = (state=None, *, pressure_limit=None, height=420))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        state: Option<Bound<'py, State>>,
        #[pyo3(from_py_with = optional_real)] pressure_limit: Option<f64>,
        #[pyo3(from_py_with = whole)] height: Whole,
    ) -> PyResult<Bound<'py, PyAny>> {
        let options = PyDict::new(slf.py());
        options.set_item("state", state)?;
        options.set_item("pressure_limit", pressure_limit)?;
        options.set_item("height", height)?;
        picture(slf.as_any(), &options)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        html(slf.as_any())
    }
}

#[pymethods]
impl Trajectory {
    /// Draws an animation with a slider, for a notebook or a file.
    ///
    /// Parameters
    /// ----------
    /// world : World, optional
    ///     World of the trajectory. The picture then has its bodies and contact surfaces. Without a world, the picture has the frames of
    ///     the bodies and the paths of their origins.
    /// frames : int
    ///     Maximum number of drawn states. They are evenly spaced and include the first and the last state.
    /// pressure_limit : float, optional
    ///     Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    /// height : int
    ///     Height (pixels) of the picture in a notebook.
    ///
    /// Returns
    /// -------
    /// hydroelastic.view.Picture
    ///     Picture that can be played and turned.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the trajectory does not fit the world, or a number is out of range.
    #[pyo3(signature = (world=None, *, frames=100, pressure_limit=None, height=420))]
    fn show<'py>(
        slf: &Bound<'py, Self>,
        world: Option<Bound<'py, World>>,
        #[pyo3(from_py_with = whole)] frames: Whole,
        #[pyo3(from_py_with = optional_real)] pressure_limit: Option<f64>,
        #[pyo3(from_py_with = whole)] height: Whole,
    ) -> PyResult<Bound<'py, PyAny>> {
        let options = PyDict::new(slf.py());
        options.set_item("world", world)?;
        options.set_item("frames", frames)?;
        options.set_item("pressure_limit", pressure_limit)?;
        options.set_item("height", height)?;
        picture(slf.as_any(), &options)
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        html(slf.as_any())
    }
}
