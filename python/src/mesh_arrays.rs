//! Conversion of the arrays of meshes: positions, indices of corners, and derivatives with respect to positions.

use crate::arrays::{Floats, array, check_finite, indices, signed, table, whole_array};
use crate::errors::value_error;
use hydroelastic::mesh::{TetMesh, TriangleSoup};
use hydroelastic::nalgebra::Vector3;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Array of `int64` that is returned to Python.
pub type Indices<'py> = Bound<'py, PyArrayDyn<i64>>;

/// Reads n vectors.
pub fn vectors(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vector3<f64>>> {
    let rows = table::<3>(argument, name)?;
    Ok(rows.into_iter().map(Into::into).collect())
}

/// Reads n vectors, or returns an error if a number is not finite.
pub fn finite_vectors(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Vector3<f64>>> {
    let rows = table::<3>(argument, name)?;
    check_finite(rows.as_flattened(), name)?;
    Ok(rows.into_iter().map(Into::into).collect())
}

/// Reads the arguments `vertices` and `triangles`.
pub fn triangle_soup(
    vertices: &Bound<'_, PyAny>,
    triangles: &Bound<'_, PyAny>,
) -> PyResult<TriangleSoup> {
    Ok(TriangleSoup {
        vertices: vectors(vertices, "vertices")?,
        triangles: indices(triangles, "triangles")?,
    })
}

/// Reads the arguments `vertices` and `tets`.
pub fn tet_mesh(vertices: &Bound<'_, PyAny>, tets: &Bound<'_, PyAny>) -> PyResult<TetMesh> {
    TetMesh::new(vectors(vertices, "vertices")?, indices(tets, "tets")?).map_err(value_error)
}

/// Creates an array of n vectors.
pub fn vector_array<'py>(py: Python<'py>, vectors: &[Vector3<f64>]) -> PyResult<Floats<'py>> {
    let values = vectors.iter().flatten().copied().collect();
    array(py, values, &[vectors.len(), 3])
}

/// Creates an array of n rows of indices.
pub fn index_array<'py, const N: usize>(
    py: Python<'py>,
    rows: &[[usize; N]],
) -> PyResult<Indices<'py>> {
    let values = signed(rows.as_flattened().iter().copied());
    whole_array(py, values, &[rows.len(), N])
}

/// Creates an array of derivatives with respect to n positions, or returns an error if a number is not finite.
pub fn gradient_array<'py>(py: Python<'py>, gradient: &[Vector3<f64>]) -> PyResult<Floats<'py>> {
    let values: Vec<f64> = gradient.iter().flatten().copied().collect();
    check_finite(&values, "the gradient")?;
    array(py, values, &[gradient.len(), 3])
}
