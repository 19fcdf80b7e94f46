//! Derivatives of the vertices and extents of a shape with respect to the numbers that define the shape.

use crate::arrays::{Whole, array, check_kept, count, wholes};
use crate::errors::value_error;
use crate::mesh_arrays::vector_array;
use hydroelastic::mesh::{self, MeshError};
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Derivatives of the vertices and extents of a shape with respect to k numbers that define the shape. See ShapeGradient.along.
///
/// Parameters
/// ----------
/// vertices : (k, v, 3) or (v, 3) ndarray of float64
///     Derivatives of the vertices.
/// extents : (k, v) or (v,) ndarray of float64
///     Derivatives of the extents.
/// ambiguous : list of int
///     Vertices without a unique derivative.
///
/// Raises
/// ------
/// HydroelasticError
///     If an array has an unexpected shape, or a number is not finite.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct ShapeRates {
    /// Derivative of each vertex in the axes of the body frame, (k, v, 3) or (v, 3) float64, in m over the unit of the number.
    pub vertices: Py<PyArrayDyn<f64>>,
    /// Derivative of the extent of each vertex, (k, v) or (v,) float64.
    pub extents: Py<PyArrayDyn<f64>>,
    /// Indices of the vertices without a unique derivative, ascending. Their rates are one of several one-sided derivatives, or a mean.
    ambiguous: Vec<usize>,
}

impl ShapeRates {
    /// Converts the rates with respect to one number.
    pub fn of_one(py: Python<'_>, rates: &mesh::ShapeRates) -> PyResult<Self> {
        Ok(Self {
            vertices: vector_array(py, &rates.vertices)?.unbind(),
            extents: array(py, rates.extents.clone(), &[rates.extents.len()])?.unbind(),
            ambiguous: rates.ambiguous.clone(),
        })
    }

    /// Converts the rates with respect to k numbers. There is at least one.
    pub fn of(
        py: Python<'_>,
        rates: Result<impl AsRef<[mesh::ShapeRates]>, MeshError>,
    ) -> PyResult<Self> {
        let rates = rates.map_err(value_error)?;
        let rates = rates.as_ref();
        let (numbers, count) = (rates.len(), rates[0].vertices.len());
        let vertices = rates
            .iter()
            .flat_map(|rates| rates.vertices.iter().flatten());
        let extents = rates.iter().flat_map(|rates| &rates.extents);
        Ok(Self {
            vertices: array(py, vertices.copied().collect(), &[numbers, count, 3])?.unbind(),
            extents: array(py, extents.copied().collect(), &[numbers, count])?.unbind(),
            ambiguous: rates[0].ambiguous.clone(),
        })
    }
}

#[pymethods]
impl ShapeRates {
    #[new]
    #[pyo3(signature = (vertices, extents, ambiguous=vec![]))]
    fn new(
        py: Python<'_>,
        vertices: Py<PyArrayDyn<f64>>,
        extents: Py<PyArrayDyn<f64>>,
        #[pyo3(from_py_with = wholes)] ambiguous: Vec<Whole>,
    ) -> PyResult<Self> {
        check_kept(
            py,
            &[
                (&vertices, "vertices", &["k?", "v", "3"]),
                (&extents, "extents", &["k?", "v"]),
            ],
        )?;
        let ambiguous = ambiguous
            .into_iter()
            .map(|vertex| count(vertex, "ambiguous"));
        Ok(Self {
            vertices,
            extents,
            ambiguous: ambiguous.collect::<PyResult<_>>()?,
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let shape = |array: &Py<PyArrayDyn<f64>>| -> PyResult<String> {
            Ok(array.bind(py).getattr("shape")?.repr()?.to_string())
        };
        Ok(format!(
            "ShapeRates(vertices {}, extents {}, {} ambiguous)",
            shape(&self.vertices)?,
            shape(&self.extents)?,
            self.ambiguous.len()
        ))
    }

    fn __getnewargs__(
        &self,
        py: Python<'_>,
    ) -> (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>, Vec<usize>) {
        (
            self.vertices.clone_ref(py),
            self.extents.clone_ref(py),
            self.ambiguous.clone(),
        )
    }
}
