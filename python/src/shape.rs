//! Compliant shapes: pressure fields with their search trees.

use crate::arrays::{Floats, array, list, optional_real, real};
use crate::errors::{file_error, value_error};
use crate::mesh_arrays::{Indices, gradient_array, index_array, tet_mesh, vector_array};
use crate::shape_files::{mesh_error, placement, warn};
use crate::shape_gradient::mass_gradient;
use hydroelastic::contact::{self, BodyError, ContactBody};
use hydroelastic::io::{MeshOptions, read_mesh};
use hydroelastic::mesh::{MeshError, PressureField, TetMesh};
use hydroelastic::spatial::{MassProperties, Pose};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// Shape of a compliant body: a tetrahedral mesh with an extent at every vertex.
///
/// The extent is 0 on the surface and positive inside. The pressure is the hydroelastic modulus (Pa) times the extent. Any number of
/// bodies may share a shape.
///
/// Parameters
/// ----------
/// vertices : (n, 3) array_like
///     Positions (m) in the body frame.
/// tets : (m, 4) array_like of int
///     Vertex indices of each tetrahedron, in either orientation.
/// extents : (n,) array_like, optional
///     Extent of each vertex. Default: the distance to the surface over the largest distance. Tetrahedra whose corners all lie on the
///     surface are then divided, which adds vertices.
/// inert_tets : bool
///     True to allow tetrahedra with the extent 0 at all corners. They have mass, but exert no force.
/// tolerance : float, optional
///     Largest mean error of the interpolated distance over the mean distance, positive, without extents. Tetrahedra are split until the
///     error of shallow points is as small. Coarse meshes without a tolerance are too soft at their edges. Default: no tolerance.
///
/// Raises
/// ------
/// HydroelasticError
///     If the mesh or the field is not valid. The message names the vertex or tetrahedron.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Shape(pub Arc<contact::Shape>);

impl Shape {
    /// Creates a shape from a pressure field, or converts the error.
    pub fn of(field: Result<PressureField, MeshError>) -> PyResult<Self> {
        let field = field.map_err(value_error)?;
        Ok(Self(Arc::new(contact::Shape::new(field))))
    }

    /// Creates a shape whose extents are distances to the surface, interpolated within a tolerance if there is one.
    fn of_distances(mesh: &TetMesh, tolerance: Option<f64>) -> PyResult<Self> {
        Self::of(match tolerance {
            None => PressureField::from_distance(mesh),
            Some(tolerance) => PressureField::from_distance_within(mesh, tolerance, None),
        })
    }

    /// Pressure field of the shape.
    pub fn field(&self) -> &PressureField {
        self.0.field()
    }

    /// Creates the body of a contact, at a pose and with a modulus (Pa).
    pub fn at(&self, pose: Pose, modulus: f64) -> Result<ContactBody<'_>, BodyError> {
        ContactBody::new(&self.0, pose, modulus)
    }
}

/// Converts mass properties to the mass, the center of mass and the inertia.
pub fn mass_arrays<'py>(
    py: Python<'py>,
    properties: &MassProperties,
) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
    let center = properties.center_of_mass.as_slice().to_vec();
    let inertia = properties.inertia.transpose().as_slice().to_vec();
    Ok((
        properties.mass,
        array(py, center, &[3])?,
        array(py, inertia, &[3, 3])?,
    ))
}

#[pymethods]
impl Shape {
    #[new]
    #[pyo3(signature = (vertices, tets, extents=None, *, inert_tets=false, tolerance=None))]
    fn new(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        tets: &Bound<'_, PyAny>,
        extents: Option<&Bound<'_, PyAny>>,
        inert_tets: bool,
        #[pyo3(from_py_with = optional_real)] tolerance: Option<f64>,
    ) -> PyResult<Self> {
        let mesh = tet_mesh(vertices, tets)?;
        let Some(extents) = extents else {
            return py.detach(|| Self::of_distances(&mesh, tolerance));
        };
        let extents = list(extents, "extents")?;
        if tolerance.is_some() {
            return Err(value_error(
                "a tolerance is that of distances, but extents were given: give one of them",
            ));
        }
        Self::of(if inert_tets {
            PressureField::with_inert_tets(mesh, extents)
        } else {
            PressureField::new(mesh, extents)
        })
    }

    /// Reads a tetrahedral mesh from a file: Gmsh (.msh), VTK (.vtk, .vtu), Medit (.mesh), TetGen (.node, .ele) or Abaqus (.inp).
    ///
    /// Vertices that no tetrahedron uses are dropped. Properties of the file that may be mistakes are warnings (UserWarning): seams,
    /// thin tetrahedra, surfaces that are not part of the mesh, and an unlikely size.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    /// extents : str, optional
    ///     Name of a point-data array of a VTK file with the extents. Default: the extents are distances to the surface.
    /// unit : float, optional
    ///     Unit of the file in meters, such as 0.001 for millimeters. None, the default, means 1, with a warning if the mesh is larger
    ///     than 10 m or smaller than 0.1 mm.
    /// scale : (3,) array_like, optional
    ///     Factor for each axis of the file. A negative factor mirrors the body. Default: 1.
    /// pose : (4, 4) array_like, optional
    ///     Pose of the axes of the file in the body frame. Default: the identity.
    /// corners_only : bool
    ///     True to read tetrahedra of second or higher order as tetrahedra of first order with the same corners.
    /// weld_tolerance : float
    ///     Distance (m) up to which duplicated vertices on coincident faces are merged. Vertices at equal positions are always merged.
    /// tolerance : float or None
    ///     Largest mean error of the interpolated distance over the mean distance, positive, if the extents are distances. Tetrahedra
    ///     are split until the error of shallow points is as small. None keeps the tetrahedra of the file, which may be too soft at their
    ///     edges.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Shape with this mesh.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an option is out of range, or if the file is damaged, has no tetrahedra, has tetrahedra of higher order without
    ///     corners_only, or has other solid elements.
    /// OSError
    ///     If the file cannot be read from the disk.
    #[staticmethod]
    #[pyo3(signature = (path, extents=None, unit=None, *, scale=None, pose=None, corners_only=false, weld_tolerance=0.0, tolerance=Some(0.005)),
           text_signature = "(path, extents=None, unit=None, *, scale=None, pose=None, corners_only=False, weld_tolerance=0.0, \
                             tolerance=0.005)")]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        extents: Option<&str>,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
        scale: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        corners_only: bool,
        #[pyo3(from_py_with = real)] weld_tolerance: f64,
        #[pyo3(from_py_with = optional_real)] tolerance: Option<f64>,
    ) -> PyResult<Self> {
        let options = MeshOptions {
            placement: placement(unit, scale, pose)?,
            corners_only,
            weld_tolerance,
        };
        let (shape, warnings) = py.detach(|| {
            let mut file = read_mesh(&path, &options).map_err(mesh_error)?;
            let warnings = std::mem::take(&mut file.warnings);
            let shape = match extents {
                Some(name) => Self::of(Ok(file.pressure_field(name).map_err(file_error)?)),
                None => Self::of_distances(&file.mesh, tolerance),
            };
            Ok::<_, PyErr>((shape?, warnings))
        })?;
        warn(py, path.display(), warnings, unit.is_some())?;
        Ok(shape)
    }

    /// Creates a shape with a skin: the extent is the distance to the surface over the depth of the skin, at most 1.
    ///
    /// Parameters
    /// ----------
    /// vertices : (n, 3) array_like
    ///     Positions (m) in the body frame.
    /// tets : (m, 4) array_like of int
    ///     Vertex indices of each tetrahedron, in either orientation.
    /// depth : float
    ///     Depth (m) of the skin.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Shape with more vertices than the mesh, because tetrahedra are divided at the end of the skin.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the mesh is not valid, or the depth is not positive and finite.
    #[staticmethod]
    fn from_distance_up_to(
        vertices: &Bound<'_, PyAny>,
        tets: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = real)] depth: f64,
    ) -> PyResult<Self> {
        Self::of(PressureField::from_distance_up_to(
            &tet_mesh(vertices, tets)?,
            depth,
        ))
    }

    /// Positions (m) of the vertices in the body frame, (n, 3) float64.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, self.field().mesh().vertices())
    }

    /// Vertex indices of each tetrahedron, positively oriented, (m, 4) int64.
    #[getter]
    fn tets<'py>(&self, py: Python<'py>) -> PyResult<Indices<'py>> {
        index_array(py, self.field().mesh().tets())
    }

    /// Extent of each vertex, (n,) float64.
    #[getter]
    fn extents<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let extents = self.field().extents();
        array(py, extents.to_vec(), &[extents.len()])
    }

    /// Vertex indices of each triangle of the surface, counter-clockwise seen from outside, (k, 3) int64.
    #[getter]
    fn surface_triangles<'py>(&self, py: Python<'py>) -> PyResult<Indices<'py>> {
        index_array(py, self.field().mesh().surface_triangles())
    }

    /// Volume (m³).
    #[getter]
    fn volume(&self) -> f64 {
        self.field().mesh().volume()
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
        let properties = self.field().mesh().mass_properties(density);
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
        let result_gradient = self.field().mesh().mass_gradient(density, &gradient);
        gradient_array(py, &result_gradient.map_err(value_error)?)
    }

    pub fn __repr__(&self) -> String {
        let mesh = self.field().mesh();
        format!(
            "Shape({} vertices, {} tetrahedra, {:.4e} m³)",
            mesh.vertex_count(),
            mesh.tet_count(),
            mesh.volume()
        )
    }
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((Floats<'py>, Indices<'py>, Floats<'py>), Bound<'py, PyDict>)> {
        let keywords = PyDict::new(py);
        keywords.set_item("inert_tets", true)?;
        Ok((
            (self.vertices(py)?, self.tets(py)?, self.extents(py)?),
            keywords,
        ))
    }
}
