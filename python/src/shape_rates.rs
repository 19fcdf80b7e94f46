//! How shapes change with the numbers that they are made of.

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

/// How a shape changes with k numbers that it is made of: velocities of its vertices, and rates of their extents. ShapeGradient.along
/// takes it.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct ShapeRates {
    /// (k, v, 3) float64, or (v, 3): the velocity of each vertex, in the axes of the body's frame (m over the number's unit).
    pub vertices: Py<PyArrayDyn<f64>>,
    /// (k, v) float64, or (v,): the rate of the extent of each vertex.
    pub extents: Py<PyArrayDyn<f64>>,
    /// Vertices whose rates are one of several, or a mean, ascending.
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
        let vertices = rates.iter().flat_map(|it| it.vertices.iter().flatten());
        let extents = rates.iter().flat_map(|it| &it.extents);
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
        let ambiguous = ambiguous.into_iter().map(|it| count(it, "ambiguous"));
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
    /// How Shape.icosphere changes with its radius (m): k is 1.
    #[staticmethod]
    fn icosphere_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<ShapeRates> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        let rates = shapes::icosphere_rates(radius, subdivisions);
        ShapeRates::of(py, rates.map(|it| [it]))
    }

    /// How Shape.ellipsoid changes with its semi-axes (m): k is 3.
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

    /// How Shape.cuboid changes with its edges (m): k is 3.
    #[staticmethod]
    fn cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::cuboid_rates(row(lengths, "lengths")?))
    }

    /// How Shape.distance_cuboid changes with its edges (m): k is 3. Where two edges are shortest, or all, the vertices inside are
    /// ambiguous: exact for changes that keep these edges equal.
    #[staticmethod]
    fn distance_cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::distance_cuboid_rates(row(lengths, "lengths")?))
    }

    /// How Shape.cylinder changes with its radius and its length (m): k is 2. Where the length is twice the radius of the circle
    /// inscribed in the base, the vertex inside is ambiguous: exact for a change of size alone.
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

/// A shape with the distance to the surface of a mesh as field, as Shape(vertices, tets) makes it, and how it changes with the
/// vertices of that mesh. The shape has more vertices, where tetrahedra are divided, and all its extents depend on the surface.
///
/// Parameters
/// ----------
/// vertices : (n, 3) float64, positions (m) in the body frame.
/// tets : (m, 4) integers, the vertices of each tetrahedron; either orientation.
/// depth : None for the distance over the largest one; or the depth (m) of a skin, below which the extent stays 1.
///
/// Raises
/// ------
/// HydroelasticError if the mesh or the field is not valid; the message names the culprit.
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

    /// The shape.
    #[getter]
    fn shape(&self) -> Shape {
        self.shape.clone()
    }

    /// The vertices of the shape, ascending, at which there is no derivative: equally far from several places of the surface, of
    /// which the mean is taken; among several that are farthest from it; or where a skin ends.
    #[getter]
    fn ambiguous(&self) -> Vec<usize> {
        self.distances.ambiguous().to_vec()
    }

    /// The derivatives by the mesh of a number that has these by the shape, by_vertices (v, 3) and by_extents (v,): by its vertices,
    /// (n, 3), and by the depth.
    fn pullback<'py>(
        &self,
        py: Python<'py>,
        by_vertices: &Bound<'py, PyAny>,
        by_extents: &Bound<'py, PyAny>,
    ) -> PyResult<(Floats<'py>, f64)> {
        let by_vertices = vectors(by_vertices, "by_vertices")?;
        let by_extents = list(by_extents, "by_extents")?;
        check_finite(&by_extents, "by_extents")?;
        let found = self.distances.pullback(&by_vertices, &by_extents);
        let found = found.map_err(value_error)?;
        let values = found.by_vertices.iter().flatten().copied().collect();
        let by_vertices = array(py, values, &[found.by_vertices.len(), 3])?;
        Ok((by_vertices, found.by_depth))
    }

    /// How the shape changes as the vertices of the mesh move at these velocities, (n, 3).
    fn rates(&self, py: Python<'_>, velocities: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        let velocities = vectors(velocities, "velocities")?;
        let rates = self.distances.rates(&velocities).map_err(value_error)?;
        ShapeRates::of_one(py, &rates)
    }

    /// How the shape changes with the depth of its skin (m).
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
