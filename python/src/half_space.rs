//! Half-spaces: unbounded floors and walls.

use crate::arrays::optional_real;
use crate::errors::value_error;
use hydroelastic::contact;
use pyo3::prelude::*;
use std::sync::Arc;

/// Half-space: all points with z ≤ 0 in its frame, with the outward normal along z.
///
/// A half-space is unbounded, has no mesh, and cannot be a dynamic body. It is rigid, or it has a compliant layer on a rigid base. The
/// pressure in a layer is the hydroelastic modulus (Pa) times depth over thickness, at any depth.
///
/// Parameters
/// ----------
/// thickness : float, optional
///     Thickness (m) of the layer. None, the default, is a rigid half-space: its material has no modulus, see Material.rigid.
///
/// Raises
/// ------
/// HydroelasticError
///     If the thickness is not positive and finite.
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

    /// Thickness (m) of the compliant layer; None for a rigid half-space.
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
