//! Rates of shapes: derivatives of vertices and extents with respect to the numbers that define a shape.

use crate::arrays::{
    Floats, Whole, array, check_finite, check_kept, count, indices, list, optional_real, real, row,
    signed, table, whole, whole_array, wholes,
};
use crate::errors::value_error;
use crate::shape::Shape;
use hydroelastic::mesh::{self, LinearizedDistances, PressureField, TetMesh, shapes};
use hydroelastic::nalgebra::Vector3;
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
    fn of_one(py: Python<'_>, rates: &mesh::ShapeRates) -> PyResult<Self> {
        let vertices: Vec<f64> = rates.vertices.iter().flatten().copied().collect();
        let count = rates.vertices.len();
        Ok(Self {
            vertices: array(py, vertices, &[count, 3])?.unbind(),
            extents: array(py, rates.extents.clone(), &[count])?.unbind(),
            ambiguous: rates.ambiguous.clone(),
        })
    }

    fn of<const N: usize>(
        py: Python<'_>,
        rates: Result<[mesh::ShapeRates; N], mesh::MeshError>,
    ) -> PyResult<Self> {
        let rates = rates.map_err(value_error)?;
        let count = rates[0].vertices.len();
        let vertices = rates
            .iter()
            .flat_map(|rates| rates.vertices.iter().flatten());
        let extents = rates.iter().flat_map(|rates| &rates.extents);
        Ok(Self {
            vertices: array(py, vertices.copied().collect(), &[N, count, 3])?.unbind(),
            extents: array(py, extents.copied().collect(), &[N, count])?.unbind(),
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

#[pymethods]
impl Shape {
    /// Computes the derivative of Shape.icosphere with respect to its radius (m).
    ///
    /// Parameters
    /// ----------
    /// radius, subdivisions
    ///     Arguments of Shape.icosphere.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 1.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn icosphere_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<ShapeRates> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        let rates = shapes::icosphere_rates(radius, subdivisions);
        ShapeRates::of(py, rates.map(|rates| [rates]))
    }

    /// Computes the derivatives of Shape.ellipsoid with respect to its semi-axes (m).
    ///
    /// Parameters
    /// ----------
    /// semi_axes : (3,) array_like
    ///     Semi-axes (m) along x, y and z.
    /// subdivisions : int
    ///     Number of times that each face of an icosahedron is divided into four, from 0 to 8.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn ellipsoid_rates(
        py: Python<'_>,
        semi_axes: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<ShapeRates> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        let semi_axes = row(semi_axes, "semi_axes")?;
        ShapeRates::of(py, shapes::ellipsoid_rates(semi_axes, subdivisions))
    }

    /// Computes the derivatives of Shape.cuboid with respect to its edge lengths (m).
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m).
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::cuboid_rates(row(lengths, "lengths")?))
    }

    /// Computes the derivatives of Shape.distance_cuboid with respect to its edge lengths (m).
    ///
    /// If two or three edges are the shortest, the inner vertices are ambiguous. Their rates are then exact for changes that keep these
    /// edges equal.
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m).
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn distance_cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::distance_cuboid_rates(row(lengths, "lengths")?))
    }

    /// Computes the derivatives of Shape.cylinder with respect to its radius and its length (m).
    ///
    /// If the length is twice the radius of the circle inscribed in the base, the inner vertex is ambiguous. Its rates are then exact for
    /// a change of scale only.
    ///
    /// Parameters
    /// ----------
    /// radius, length, segments
    ///     Arguments of Shape.cylinder.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 2.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn cylinder_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<ShapeRates> {
        let segments = count(segments, "segments")?;
        ShapeRates::of(py, shapes::cylinder_rates(radius, length, segments))
    }
}

/// Shape whose extents are distances to the surface of a mesh, with its derivatives with respect to the vertices of the mesh.
///
/// The shape is that of Shape(vertices, tets). It has more vertices than the mesh if tetrahedra are divided, and all its extents depend
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
///
/// Raises
/// ------
/// HydroelasticError
///     If the mesh or the field is not valid. The message names the vertex or tetrahedron.
#[pyclass(frozen, module = "hydroelastic")]
pub struct LinearizedShape {
    mesh: TetMesh,
    depth: Option<f64>,
    shape: Shape,
    distances: LinearizedDistances,
}

#[pymethods]
impl LinearizedShape {
    #[new]
    #[pyo3(signature = (vertices, tets, depth=None))]
    fn new(
        vertices: &Bound<'_, PyAny>,
        tets: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = optional_real)] depth: Option<f64>,
    ) -> PyResult<Self> {
        let vertices = table::<3>(vertices, "vertices")?;
        let vertices = vertices.into_iter().map(Into::into).collect();
        let tets = indices(tets, "tets")?;
        let mesh = TetMesh::new(vertices, tets).map_err(value_error)?;
        let made = match depth {
            None => PressureField::linearized_from_distance(&mesh),
            Some(depth) => PressureField::linearized_from_distance_up_to(&mesh, depth),
        };
        let (field, distances) = made.map_err(value_error)?;
        let shape = Shape::of(Ok(field))?;
        Ok(Self {
            mesh,
            depth,
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
        let by_vertices = vectors(by_vertices, "by_vertices")?;
        let by_extents = list(by_extents, "by_extents")?;
        check_finite(&by_extents, "by_extents")?;
        let gradient = self.distances.pullback(&by_vertices, &by_extents);
        let gradient = gradient.map_err(value_error)?;
        let values = gradient.by_vertices.iter().flatten().copied().collect();
        let by_vertices = array(py, values, &[gradient.by_vertices.len(), 3])?;
        Ok((by_vertices, gradient.by_depth))
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
        let velocities = vectors(velocities, "velocities")?;
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
    ) -> PyResult<(Floats<'py>, Bound<'py, PyArrayDyn<i64>>, Option<f64>)> {
        let (vertices, tets) = (self.mesh.vertices(), self.mesh.tets());
        let coordinates = vertices.iter().flatten().copied().collect();
        let corners = signed(tets.as_flattened().iter().copied());
        Ok((
            array(py, coordinates, &[vertices.len(), 3])?,
            whole_array(py, corners, &[tets.len(), 4])?,
            self.depth,
        ))
    }
}

fn vectors(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vector3<f64>>> {
    let rows = table::<3>(argument, name)?;
    check_finite(rows.as_flattened(), name)?;
    Ok(rows.into_iter().map(Into::into).collect())
}
