//! Rigid shapes: closed triangle surfaces with their search trees.

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

/// Shape of a rigid body: the closed triangle surface of a solid.
///
/// Rigid shapes have contact with compliant shapes only. The surface may have several components and cavities. It must not intersect
/// itself, which is not checked.
///
/// Parameters
/// ----------
/// vertices : (n, 3) array_like
///     Positions (m) in the body frame. Each vertex must belong to a triangle: RigidShape.around makes the surface of a Shape.
/// triangles : (m, 3) array_like of int
///     Vertex indices of each triangle, counter-clockwise seen from outside.
///
/// Raises
/// ------
/// HydroelasticError
///     If the surface is not closed, oriented inwards or flat, or a number is not valid. The message names the vertex, edge or triangle.
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

    /// Reads a surface from an STL file (.stl, binary or ASCII) or a Wavefront file (.obj).
    ///
    /// Vertices at exactly the same position are merged.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    /// unit : float, optional
    ///     Unit of the file in meters, such as 0.001 for the millimeters of most CAD programs. None, the default, means 1, with a
    ///     warning if the surface is larger than 100 m.
    ///
    /// Returns
    /// -------
    /// RigidShape
    ///     Shape with this surface.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the file cannot be read or is damaged, or its surface is not closed.
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

    /// Creates a rigid shape from the surface of a compliant shape.
    ///
    /// Parameters
    /// ----------
    /// shape : Shape
    ///     Compliant shape.
    ///
    /// Returns
    /// -------
    /// RigidShape
    ///     Rigid shape with the same surface.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the surface is not valid.
    #[staticmethod]
    fn around(py: Python<'_>, shape: &Shape) -> PyResult<Self> {
        py.detach(|| Self::of(TriangleSurface::around(shape.0.field().mesh())))
    }

    /// Positions (m) of the vertices in the body frame, (n, 3) float64.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let vertices = self.surface().vertices();
        let values = vertices.iter().flat_map(|v| v.iter().copied()).collect();
        array(py, values, &[vertices.len(), 3])
    }

    /// Vertex indices of each triangle, counter-clockwise seen from outside, (m, 3) int64.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let triangles = self.surface().triangles();
        let values = signed(triangles.as_flattened().iter().copied());
        whole_array(py, values, &[triangles.len(), 3])
    }

    /// Enclosed volume (m³), without cavities.
    #[getter]
    fn volume(&self) -> f64 {
        self.surface().volume()
    }

    /// Computes the mass properties at a uniform density.
    ///
    /// Parameters
    /// ----------
    /// density : float
    ///     Density (kg/m³), positive.
    ///
    /// Returns
    /// -------
    /// mass : float
    ///     Mass (kg).
    /// center_of_mass : (3,) ndarray of float64
    ///     Center of mass (m) in the body frame.
    /// inertia : (3, 3) ndarray of float64
    ///     Inertia (kg m²) about the center of mass, in the axes of the body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the density is not positive and finite.
    fn mass_properties<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] density: f64,
    ) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
        let properties = self.surface().mass_properties(density);
        mass_arrays(py, &properties.map_err(value_error)?)
    }

    /// Computes the gradient of a loss with respect to the vertices from its gradient with respect to the mass properties.
    ///
    /// The mass properties are those at a uniform density. The result is exact up to round-off.
    ///
    /// Parameters
    /// ----------
    /// density : float
    ///     Density (kg/m³), positive.
    /// by_mass : float
    ///     Derivative of the loss with respect to the mass.
    /// by_center : (3,) array_like
    ///     Derivatives with respect to the center of mass.
    /// by_inertia : (3, 3) array_like
    ///     Derivatives with respect to the entries of the inertia. Only the mean of two opposite entries has an effect.
    ///
    /// Returns
    /// -------
    /// (n, 3) ndarray of float64
    ///     Derivatives with respect to the vertices, in the body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the density is not positive and finite, a number is not finite, or an array has an unexpected shape.
    fn mass_gradient<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] density: f64,
        #[pyo3(from_py_with = real)] by_mass: f64,
        by_center: &Bound<'py, PyAny>,
        by_inertia: &Bound<'py, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let gradient = mass_gradient(by_mass, by_center, by_inertia)?;
        let result_gradient = self.surface().mass_gradient(density, &gradient);
        let result_gradient = result_gradient.map_err(value_error)?;
        let values: Vec<f64> = result_gradient.iter().flatten().copied().collect();
        check_finite(&values, "the gradient")?;
        array(py, values, &[result_gradient.len(), 3])
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
