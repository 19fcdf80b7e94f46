//! Shapes made from distances, with derivatives with respect to the mesh.

use crate::arrays::{Floats, check_finite, list, optional_real};
use crate::errors::value_error;
use crate::mesh_arrays::{Indices, finite_vectors, index_array, tet_mesh, vector_array};
use crate::shape::Shape;
use crate::shape_rates::ShapeRates;
use hydroelastic::mesh::{LinearizedDistances, PressureField, TetMesh};
use pyo3::prelude::*;

/// Shape whose extents are distances to the surface of a mesh, with its derivatives with respect to the vertices of the mesh.
///
/// The shape is that of Shape(vertices, tets), with the same tolerance. It has more vertices than the mesh if tetrahedra are divided, and all its extents depend
/// on the surface.
///
/// Parameters
/// ----------
/// vertices : (n, 3) array_like
///     Positions (m) in the body frame.
/// tets : (m, 4) array_like of int
///     Vertex indices of each tetrahedron, in either orientation.
/// depth : float, optional
///     Depth (m) of a skin. The extent is 1 below the skin. Default: the extent is the distance over the largest distance.
/// tolerance : float, optional
///     Largest mean error of the interpolated distance over the mean distance, positive, without a skin. Tetrahedra are split until the
///     error of shallow points is as small. The places of the new vertices on their edges count as fixed. Default: no tolerance.
///
/// Raises
/// ------
/// HydroelasticError
///     If the mesh or the field is not valid. The message names the vertex or tetrahedron.
#[pyclass(frozen, module = "hydroelastic")]
pub struct LinearizedShape {
    mesh: TetMesh,
    depth: Option<f64>,
    tolerance: Option<f64>,
    shape: Shape,
    distances: LinearizedDistances,
}

#[pymethods]
impl LinearizedShape {
    #[new]
    #[pyo3(signature = (vertices, tets, depth=None, tolerance=None))]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        tets: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = optional_real)] depth: Option<f64>,
        #[pyo3(from_py_with = optional_real)] tolerance: Option<f64>,
    ) -> PyResult<Self> {
        let mesh = tet_mesh(vertices, tets)?;
        let made = py.detach(|| match (depth, tolerance) {
            (None, None) => Ok(PressureField::linearized_from_distance(&mesh)),
            (None, Some(tolerance)) => Ok(PressureField::linearized_from_distance_within(
                &mesh, tolerance, None,
            )),
            (Some(depth), None) => Ok(PressureField::linearized_from_distance_up_to(&mesh, depth)),
            (Some(_), Some(_)) => Err(value_error(
                "a shape with a skin has no tolerance: give the depth or the tolerance",
            )),
        })?;
        let (field, distances) = made.map_err(value_error)?;
        let shape = Shape::of(Ok(field))?;
        Ok(Self {
            mesh,
            depth,
            tolerance,
            shape,
            distances,
        })
    }

    /// Shape with the distances as extents.
    #[getter]
    fn shape(&self) -> Shape {
        self.shape.clone()
    }

    /// Indices of the vertices of the shape without a unique derivative, ascending. A vertex is ambiguous if it has several closest points
    /// of the surface (the mean derivative is used), if several vertices are farthest from the surface, or if it lies where a skin ends.
    #[getter]
    fn ambiguous(&self) -> Vec<usize> {
        self.distances.ambiguous().to_vec()
    }

    /// Computes the gradient of a loss with respect to the mesh from its gradient with respect to the shape.
    ///
    /// Parameters
    /// ----------
    /// by_vertices : (v, 3) array_like
    ///     Derivatives with respect to the vertices of the shape.
    /// by_extents : (v,) array_like
    ///     Derivatives with respect to the extents of the shape.
    ///
    /// Returns
    /// -------
    /// by_mesh : (n, 3) ndarray of float64
    ///     Derivatives with respect to the vertices of the mesh.
    /// by_depth : float
    ///     Derivative with respect to the depth of the skin.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an array has an unexpected shape, or a number is not finite.
    fn pullback<'py>(
        &self,
        py: Python<'py>,
        by_vertices: &Bound<'py, PyAny>,
        by_extents: &Bound<'py, PyAny>,
    ) -> PyResult<(Floats<'py>, f64)> {
        let by_vertices = finite_vectors(by_vertices, "by_vertices")?;
        let by_extents = list(by_extents, "by_extents")?;
        check_finite(&by_extents, "by_extents")?;
        let gradient = self.distances.pullback(&by_vertices, &by_extents);
        let gradient = gradient.map_err(value_error)?;
        Ok((vector_array(py, &gradient.by_vertices)?, gradient.by_depth))
    }

    /// Computes the rates of the shape if the vertices of the mesh move.
    ///
    /// Parameters
    /// ----------
    /// velocities : (n, 3) array_like
    ///     Velocity of each vertex of the mesh, in the body frame.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with one number: vertices (v, 3) and extents (v,).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the array has an unexpected shape, or a number is not finite.
    fn rates(&self, py: Python<'_>, velocities: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        let velocities = finite_vectors(velocities, "velocities")?;
        let rates = self.distances.rates(&velocities).map_err(value_error)?;
        ShapeRates::of_one(py, &rates)
    }

    /// Computes the derivatives of the shape with respect to the depth (m) of its skin.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with one number: vertices (v, 3) and extents (v,).
    fn rates_by_depth(&self, py: Python<'_>) -> PyResult<ShapeRates> {
        ShapeRates::of_one(py, &self.distances.rates_by_depth())
    }

    fn __repr__(&self) -> String {
        let (shape, ambiguous) = (self.shape.__repr__(), self.distances.ambiguous().len());
        let count = self.mesh.vertex_count();
        format!("LinearizedShape({shape} of {count} vertices, {ambiguous} ambiguous)")
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Floats<'py>, Indices<'py>, Option<f64>, Option<f64>)> {
        Ok((
            vector_array(py, self.mesh.vertices())?,
            index_array(py, self.mesh.tets())?,
            self.depth,
            self.tolerance,
        ))
    }
}
