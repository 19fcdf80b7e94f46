//! Rigid shapes: closed surfaces of triangles with their search trees.

use crate::arrays::{
    Floats, array, check_finite, indices, optional_real, real, signed, table, whole_array,
};
use crate::errors::value_error;
use crate::shape::{Shape, check_extension, mass_arrays, warn_of_size};
use crate::shape_gradient::mass_gradient;
use hydroelastic::contact;
use hydroelastic::io::read_triangle_surface;
use hydroelastic::mesh::{SurfaceError, TriangleSurface};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A body that does not give way: the closed surface of a solid, which only compliant bodies feel. It may have several components
/// and cavities; that it does not pass through itself is not checked.
///
/// Parameters
/// ----------
/// vertices : (n, 3) float64, positions (m) in the body frame.
/// triangles : (m, 3) integers, the vertices of each triangle, counter-clockwise seen from outside.
///
/// Raises
/// ------
/// HydroelasticError if the surface is not closed, turned inwards or flat, or a number is not valid; the message names the
/// culprit.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct RigidShape(pub Arc<contact::RigidShape>);

impl RigidShape {
    fn of(surface: Result<TriangleSurface, SurfaceError>) -> PyResult<Self> {
        let surface = surface.map_err(value_error)?;
        Ok(Self(Arc::new(contact::RigidShape::new(surface))))
    }

    fn surface(&self) -> &TriangleSurface {
        self.0.surface()
    }
}

#[pymethods]
impl RigidShape {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let vertices = table::<3>(vertices, "vertices")?;
        let vertices = vertices.into_iter().map(Into::into).collect();
        let triangles = indices(triangles, "triangles")?;
        py.detach(|| Self::of(TriangleSurface::new(vertices, triangles)))
    }

    /// The surface in a file: STL (.stl, binary or ASCII) or Wavefront (.obj). Vertices at exactly the same place become one.
    ///
    /// unit : the unit of the file in meters: 0.001 for the millimeters of most CAD programs. None means 1, with a warning if the
    ///     surface is larger than 100 m.
    ///
    /// Raises
    /// ------
    /// HydroelasticError if the file is damaged, or its surface not closed.
    #[staticmethod]
    #[pyo3(signature = (path, unit=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
    ) -> PyResult<Self> {
        check_extension(&path, &["msh", "vtk", "vtu"], |path| {
            format!(
                "{path} holds a mesh of tetrahedra, not a surface: Shape.read reads it, and RigidShape.around(Shape.read(path)) makes a \
                 rigid body of it"
            )
        })?;
        let read = |path: &PathBuf| read_triangle_surface(path, unit.unwrap_or(1.0));
        let shape = py.detach(|| Self::of(Ok(read(&path).map_err(value_error)?)))?;
        if unit.is_none() {
            let bounds = shape.surface().aabb();
            warn_of_size(py, &path, 2.0 * bounds.half_extents().amax())?;
        }
        Ok(shape)
    }

    /// The surface of a compliant shape: a rigid body of the same form.
    #[staticmethod]
    fn around(py: Python<'_>, shape: &Shape) -> PyResult<Self> {
        py.detach(|| Self::of(TriangleSurface::around(shape.0.field().mesh())))
    }

    /// (n, 3) float64: positions of the vertices (m), in the body frame.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let vertices = self.surface().vertices();
        let values = vertices.iter().flat_map(|v| v.iter().copied()).collect();
        array(py, values, &[vertices.len(), 3])
    }

    /// (m, 3) int64: the vertices of each triangle, counter-clockwise seen from outside.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let triangles = self.surface().triangles();
        let values = signed(triangles.as_flattened().iter().copied());
        whole_array(py, values, &[triangles.len(), 3])
    }

    /// Volume (m³) inside, without cavities.
    #[getter]
    fn volume(&self) -> f64 {
        self.surface().volume()
    }

    /// Mass (kg), center of mass (3,) (m) and inertia (3, 3) (kg m²) about it, in the body frame, at a uniform density (kg/m³).
    fn mass_properties<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] density: f64,
    ) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
        let found = self.surface().mass_properties(density);
        mass_arrays(py, &found.map_err(value_error)?)
    }

    /// (n, 3) float64: the derivatives by the vertices of a number that has these by the mass properties at a uniform density
    /// (kg/m³): by the mass, by the center of mass (3,), and by the entries of the inertia (3, 3), of which the mean of two
    /// opposite ones counts. Exact up to round-off.
    fn mass_gradient<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] density: f64,
        #[pyo3(from_py_with = real)] by_mass: f64,
        by_center: &Bound<'py, PyAny>,
        by_inertia: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let gradient = mass_gradient(by_mass, by_center, by_inertia)?;
        let found = self.surface().mass_gradient(density, &gradient);
        let found = found.map_err(value_error)?;
        let values: Vec<f64> = found.iter().flatten().copied().collect();
        check_finite(&values, "the gradient")?;
        array(py, values, &[found.len(), 3])
    }

    pub fn __repr__(&self) -> String {
        let surface = self.surface();
        format!(
            "RigidShape({} vertices, {} triangles, {:.4e} m³)",
            surface.vertices().len(),
            surface.triangles().len(),
            surface.volume()
        )
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Floats<'py>, Bound<'py, PyArrayDyn<i64>>)> {
        Ok((self.vertices(py)?, self.triangles(py)?))
    }
}
