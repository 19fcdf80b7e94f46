//! Pictures for notebooks: what `hydroelastic.view` draws.

use crate::arrays::{Whole, optional_real, whole};
use crate::state::State;
use crate::surface::Surface;
use crate::trajectory::Trajectory;
use crate::world::World;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What `hydroelastic.view.picture` makes of a value.
fn picture<'py>(
    value: &Bound<'py, PyAny>,
    options: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let view = value.py().import("hydroelastic.view")?;
    view.call_method("picture", (value,), Some(options))
}

/// The HTML of a picture, as a notebook shows the value of a cell.
fn html<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    picture(value, &PyDict::new(value.py()))?.call_method0("_repr_html_")
}

#[pymethods]
impl Surface {
    /// A picture of the polygons, colored by pressure, for a notebook or a file: see hydroelastic.view.Picture.
    ///
    /// Parameters
    /// ----------
    /// pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    /// height : of the picture in a notebook (pixels).
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
    /// A picture of the bodies, translucent, and of the contact surfaces between them, for a notebook or a file: see
    /// hydroelastic.view.Picture.
    ///
    /// Parameters
    /// ----------
    /// state : a State of this world; None for its initial state.
    /// pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    /// height : of the picture in a notebook (pixels).
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
    /// A picture that plays, with a slider, for a notebook or a file: see hydroelastic.view.Picture.
    ///
    /// Parameters
    /// ----------
    /// world : the World whose trajectory it is, for its bodies and their contact surfaces. Without it, the frames of the bodies
    ///     and the paths of their origins are drawn.
    /// frames : how many of the states are drawn at most, evenly chosen, the first and the last among them.
    /// pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    /// height : of the picture in a notebook (pixels).
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
