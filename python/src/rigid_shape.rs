//! Rigid shapes: closed triangle surfaces with their search trees.

use crate::arrays::{Floats, optional_real, real};
use crate::errors::value_error;
use crate::mesh_arrays::{
    Indices, gradient_array, index_array, triangle_soup, vector_array, vectors,
};
use crate::shape::{Shape, mass_arrays};
use crate::shape_files::{placement, surface_error, warn};
use crate::shape_gradient::mass_gradient;
use hydroelastic::contact;
use hydroelastic::io::read_triangles;
use hydroelastic::mesh::{SurfaceError, TriangleSoup, TriangleSurface};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Shape of a rigid body: the closed triangle surface of a solid.
///
/// Rigid shapes have contact with compliant shapes only. The surface may have several components and cavities. Components that overlap
/// count twice in volume and force, with a warning. Vertices that are equal or almost equal are merged if the surface is not closed
/// otherwise, triangles without area are removed, and unused vertices are dropped.
///
/// Parameters
/// ----------
/// vertices : (n, 3) array_like
///     Positions (m) in the body frame.
/// triangles : (m, 3) array_like of int
///     Vertex indices of each triangle, counter-clockwise seen from outside.
///
/// Raises
/// ------
/// HydroelasticError
///     If the surface is not closed, is turned inwards or is flat, or if a number is not valid. The message counts the faults and names the first
///     of each kind.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct RigidShape(pub Arc<contact::RigidShape>);

impl RigidShape {
    /// Creates a rigid shape from a surface.
    pub fn of(surface: Result<TriangleSurface, SurfaceError>) -> PyResult<Self> {
        let surface = surface.map_err(value_error)?;
        Ok(Self(Arc::new(contact::RigidShape::new(surface))))
    }

    /// Surface of the shape.
    pub fn surface(&self) -> &TriangleSurface {
        self.0.surface()
    }
}

/// Creates the exception for a file whose triangles are not a surface.
fn unusable(path: &Path, why: &SurfaceError) -> PyErr {
    value_error(format!(
        "{} does not hold a usable surface: {why}",
        path.display()
    ))
}

#[pymethods]
impl RigidShape {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let soup = triangle_soup(vertices, triangles)?;
        let shape = py.detach(|| {
            // A valid surface keeps its vertices.
            let surface = TriangleSurface::new(soup.vertices.clone(), soup.triangles.clone());
            Self::of(surface.or_else(|_| soup.closed()))
        })?;
        warn(py, "the surface", shape.surface().warnings(), true)?;
        Ok(shape)
    }

    /// Creates the convex hull of points.
    ///
    /// Parameters
    /// ----------
    /// points : (n, 3) array_like
    ///     Positions (m) in the body frame.
    ///
    /// Returns
    /// -------
    /// RigidShape
    ///     Surface of the hull.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the points lie in a plane, or a number is not finite.
    #[staticmethod]
    fn convex_hull(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let soup = TriangleSoup {
            vertices: vectors(points, "points")?,
            triangles: Vec::new(),
        };
        py.detach(|| Self::of(soup.convex_hull().and_then(TriangleSoup::closed)))
    }

    /// Reads a surface from a file: STL (.stl), Wavefront (.obj), PLY (.ply), OFF (.off), glTF (.glb, .gltf), COLLADA (.dae), VTK
    /// with faces only (.vtk, .vtp, .vtu) or a binary mesh of MuJoCo (.msh).
    ///
    /// The surface is repaired as by RigidShape(vertices, triangles). Repairs that move vertices, overlapping components and an unlikely
    /// size are warnings (UserWarning).
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    /// unit : float, optional
    ///     Unit of the file in meters, such as 0.001 for the millimeters of most CAD programs. None, the default, means 1, with a
    ///     warning if the surface is larger than 10 m or smaller than 0.1 mm. glTF and COLLADA files are in meters already.
    /// scale : (3,) array_like, optional
    ///     Factor for each axis of the file. A negative factor mirrors the body. Default: 1.
    /// pose : (4, 4) array_like, optional
    ///     Pose of the axes of the file in the body frame. Default: the identity.
    /// hull : bool
    ///     True to read the convex hull of all vertices. The triangles need not be closed, and there may be none.
    /// flip : bool
    ///     True to reverse the orientation of all triangles.
    ///
    /// Returns
    /// -------
    /// RigidShape
    ///     Shape with this surface.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an option is out of range, or if the file is damaged, has no surface, or its surface is not closed.
    /// OSError
    ///     If the file cannot be read from the disk.
    #[staticmethod]
    #[pyo3(signature = (path, unit=None, *, scale=None, pose=None, hull=false, flip=false))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
        scale: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        hull: bool,
        flip: bool,
    ) -> PyResult<Self> {
        let placement = placement(unit, scale, pose)?;
        let shape = py.detach(|| {
            let mut soup = read_triangles(&path, &placement).map_err(surface_error)?;
            if hull {
                soup = soup.convex_hull().map_err(|why| unusable(&path, &why))?;
            }
            let soup = if flip && !hull { soup.flipped() } else { soup };
            let surface = soup.closed().map_err(|why| unusable(&path, &why))?;
            Self::of(Ok(surface))
        })?;
        let warnings = shape.surface().warnings();
        warn(py, path.display(), warnings, unit.is_some())?;
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
        vector_array(py, self.surface().vertices())
    }

    /// Vertex indices of each triangle, counter-clockwise seen from outside, (m, 3) int64.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Indices<'py>> {
        index_array(py, self.surface().triangles())
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
        gradient_array(py, &result_gradient.map_err(value_error)?)
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

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(Floats<'py>, Indices<'py>)> {
        Ok((self.vertices(py)?, self.triangles(py)?))
    }
}
