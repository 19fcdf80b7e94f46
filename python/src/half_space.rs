//! Half-spaces: grounds and walls without an end.

use crate::arrays::optional_real;
use crate::errors::value_error;
use hydroelastic::contact;
use pyo3::prelude::*;
use std::sync::Arc;

/// All that lies below a plane: in its own frame the points with z ≤ 0, the outward normal along z. It has no mesh and no end,
/// and forces do not move it.
///
/// Parameters
/// ----------
/// thickness : None for one that does not give way, whose Material.rigid has no modulus; or the thickness (m) of a soft layer on
///     something rigid. The pressure is then the hydroelastic modulus (Pa) times depth over thickness, however deep.
///
/// Raises
/// ------
/// HydroelasticError if the thickness is not positive and finite.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct HalfSpace(pub Arc<contact::HalfSpace>);

#[pymethods]
impl HalfSpace {
    #[new]
    #[pyo3(signature = (thickness=None))]
    fn new(#[pyo3(from_py_with = optional_real)] thickness: Option<f64>) -> PyResult<Self> {
        let inner = match thickness {
            None => contact::HalfSpace::rigid(),
            Some(thickness) => contact::HalfSpace::layer(thickness).map_err(value_error)?,
        };
        Ok(Self(Arc::new(inner)))
    }

    /// Thickness (m) of its soft layer; None if it is rigid.
    #[getter]
    fn thickness(&self) -> Option<f64> {
        self.0.thickness()
    }

    pub fn __repr__(&self) -> String {
        match self.thickness() {
            None => "HalfSpace()".to_owned(),
            Some(thickness) => format!("HalfSpace(thickness={thickness:?})"),
        }
    }

    fn __getnewargs__(&self) -> (Option<f64>,) {
        (self.thickness(),)
    }
}
