//! Compliant shapes: pressure fields with their search trees.

use crate::arrays::{
    Floats, Whole, array, check_finite, count, indices, list, optional_real, real, row, signed,
    table, whole, whole_array,
};
use crate::errors::{file_error, value_error};
use crate::poses::single_pose;
use crate::shape_gradient::mass_gradient;
use hydroelastic::contact::{self, BodyError, ContactBody};
use hydroelastic::io::{FileWarning, MeshOptions, Placement, read_mesh};
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, TriangleSoup, shapes};
use hydroelastic::spatial::{MassProperties, Pose};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::fmt::Display;
use std::path::{Path, PathBuf};
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

    fn field(&self) -> &PressureField {
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

/// Returns whether the name of a file has one of the extensions.
fn is_of(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    extensions
        .iter()
        .any(|known| extension.eq_ignore_ascii_case(known))
}

/// Returns an error if a file has an extension that another class reads.
pub fn check_extension(
    path: &Path,
    extensions: &[&str],
    remedy: impl Fn(std::path::Display<'_>) -> String,
) -> PyResult<()> {
    if is_of(path, extensions) {
        return Err(value_error(remedy(path.display())));
    }
    Ok(())
}

/// Emits a warning about a file or a surface. A warning about the size of a body names the remedy.
pub fn warn(
    py: Python<'_>,
    name: impl Display,
    warning: impl Display,
    is_about_size: bool,
) -> PyResult<()> {
    let remedy = if is_about_size {
        "; unit=1.0 reads meters without this warning"
    } else {
        ""
    };
    let message = format!("{name}: {warning}{remedy}");
    py.import("warnings")?.call_method1("warn", (message,))?;
    Ok(())
}

#[pymethods]
impl Shape {
    #[new]
    #[pyo3(signature = (vertices, tets, extents=None, *, inert_tets=false))]
    fn new(
        vertices: &Bound<'_, PyAny>,
        tets: &Bound<'_, PyAny>,
        extents: Option<&Bound<'_, PyAny>>,
        inert_tets: bool,
    ) -> PyResult<Self> {
        let vertices = table::<3>(vertices, "vertices")?;
        let vertices = vertices.into_iter().map(Into::into).collect();
        let mesh = TetMesh::new(vertices, indices(tets, "tets")?).map_err(value_error)?;
        let extents = extents
            .map(|extents| list(extents, "extents"))
            .transpose()?;
        Self::of(match extents {
            None => PressureField::from_distance(&mesh),
            Some(extents) if inert_tets => PressureField::with_inert_tets(mesh, extents),
            Some(extents) => PressureField::new(mesh, extents),
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
    ///     than 100 m or smaller than 0.1 mm.
    /// scale : (3,) array_like, optional
    ///     Factor for each axis of the file. A negative factor mirrors the body. Default: 1.
    /// pose : (4, 4) array_like, optional
    ///     Pose of the axes of the file in the body frame. Default: the identity.
    /// corners_only : bool
    ///     True to read tetrahedra of second or higher order as tetrahedra of first order with the same corners.
    /// weld_tolerance : float
    ///     Distance (m) up to which duplicated vertices on coincident faces are merged. Vertices at equal positions are always merged.
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
    #[pyo3(signature = (path, extents=None, unit=None, *, scale=None, pose=None, corners_only=false, weld_tolerance=0.0))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        extents: Option<&str>,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
        scale: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        corners_only: bool,
        #[pyo3(from_py_with = real)] weld_tolerance: f64,
    ) -> PyResult<Self> {
        check_extension(
            &path,
            &["stl", "obj", "ply", "off", "glb", "gltf", "dae"],
            |path| {
                format!(
                    "{path} holds a surface, not a mesh of tetrahedra: RigidShape.read reads it as a rigid body, Shape.star_shaped makes \
                 a compliant one of vertices and triangles, and a mesher makes tetrahedra"
                )
            },
        )?;
        let mut placement = Placement::default();
        placement.unit = unit.unwrap_or(placement.unit);
        if let Some(scale) = scale {
            placement.scale = row::<3>(scale, "scale")?.into();
        }
        if let Some(pose) = pose {
            placement.pose = single_pose(pose, "pose")?;
        }
        let options = MeshOptions {
            placement,
            corners_only,
            weld_tolerance,
        };
        let (shape, warnings) = py.detach(|| {
            let mut file = read_mesh(&path, &options).map_err(file_error)?;
            let warnings = std::mem::take(&mut file.warnings);
            let shape = Self::of(match extents {
                Some(name) => Ok(file.pressure_field(name).map_err(file_error)?),
                None => PressureField::from_distance(&file.mesh),
            })?;
            Ok::<_, PyErr>((shape, warnings))
        })?;
        for warning in warnings {
            let is_about_size = matches!(warning, FileWarning::Size { .. });
            // An explicit unit is not a mistake.
            if !(is_about_size && unit.is_some()) {
                warn(py, path.display(), warning, is_about_size)?;
            }
        }
        Ok(shape)
    }

    /// Creates a ball about the origin of the body frame.
    ///
    /// Parameters
    /// ----------
    /// radius : float
    ///     Radius (m).
    /// subdivisions : int
    ///     Number of times that each face of an icosahedron is divided into four, from 0 to 8.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Ball.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn icosphere(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<Self> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        Self::of(shapes::icosphere(radius, subdivisions))
    }

    /// Creates an ellipsoid about the origin of the body frame: a stretched icosphere.
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
    /// Shape
    ///     Ellipsoid.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn ellipsoid(
        semi_axes: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<Self> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        Self::of(shapes::ellipsoid(
            row(semi_axes, "semi_axes")?,
            subdivisions,
        ))
    }

    /// Creates a box about the origin of the body frame. The extent rises linearly from each face to 1 at the center.
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m) along x, y and z.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Box.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn cuboid(lengths: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of(shapes::cuboid(row(lengths, "lengths")?))
    }

    /// Creates a box about the origin of the body frame. The extent is the distance to the surface over half the shortest edge.
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m) along x, y and z.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Box.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn distance_cuboid(lengths: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of(shapes::distance_cuboid(row(lengths, "lengths")?))
    }

    /// Creates an approximate cylinder along z: a prism whose base is a regular polygon.
    ///
    /// Parameters
    /// ----------
    /// radius : float
    ///     Radius (m).
    /// length : float
    ///     Length (m) along z.
    /// segments : int
    ///     Number of sides of the base, from 3 to 100,000.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Prism about the origin of the body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn cylinder(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<Self> {
        let segments = count(segments, "segments")?;
        Self::of(shapes::cylinder(radius, length, segments))
    }

    /// Creates the solid inside a star-shaped surface, whose triangles are all visible from one inner point.
    ///
    /// Convex solids are star-shaped. The triangles are repaired as by RigidShape.
    ///
    /// Parameters
    /// ----------
    /// vertices : (n, 3) array_like
    ///     Positions (m) in the body frame.
    /// triangles : (m, 3) array_like of int
    ///     Vertex indices of each triangle of a closed surface, counter-clockwise seen from outside.
    /// inner_point : (3,) array_like, optional
    ///     Inner point (m) in the body frame. Default: the center of volume.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Solid with the extent 1 at the inner point.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the surface is not closed, or a triangle is not visible from the inner point.
    #[staticmethod]
    #[pyo3(signature = (vertices, triangles, inner_point=None))]
    fn star_shaped(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        inner_point: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let vertices = table::<3>(vertices, "vertices")?;
        let vertices = vertices.into_iter().map(Into::into).collect();
        let triangles = indices(triangles, "triangles")?;
        let soup = TriangleSoup {
            vertices,
            triangles,
        };
        let surface = soup.closed().map_err(value_error)?;
        Self::of(match inner_point {
            None => shapes::star_shaped(&surface),
            Some(point) => {
                let point = row::<3>(point, "inner_point")?;
                shapes::star_shaped_about(point.into(), &surface)
            }
        })
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
    /// Shape
    ///     Solid with the extent 1 at the center of volume.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the points lie in a plane, or a number is not finite.
    #[staticmethod]
    fn convex_hull(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let points = table::<3>(points, "points")?;
        let points: Vec<_> = points.into_iter().map(Into::into).collect();
        Self::of(shapes::convex_hull(&points))
    }

    /// Positions (m) of the vertices in the body frame, (n, 3) float64.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let vertices = self.field().mesh().vertices();
        let values = vertices.iter().flat_map(|v| v.iter().copied()).collect();
        array(py, values, &[vertices.len(), 3])
    }

    /// Vertex indices of each tetrahedron, positively oriented, (m, 4) int64.
    #[getter]
    fn tets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let tets = self.field().mesh().tets();
        whole_array(
            py,
            signed(tets.as_flattened().iter().copied()),
            &[tets.len(), 4],
        )
    }

    /// Extent of each vertex, (n,) float64.
    #[getter]
    fn extents<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let extents = self.field().extents();
        array(py, extents.to_vec(), &[extents.len()])
    }

    /// Vertex indices of each triangle of the surface, counter-clockwise seen from outside, (k, 3) int64.
    #[getter]
    fn surface_triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let triangles = self.field().mesh().surface_triangles();
        whole_array(
            py,
            signed(triangles.as_flattened().iter().copied()),
            &[triangles.len(), 3],
        )
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
        let result_gradient = result_gradient.map_err(value_error)?;
        let values: Vec<f64> = result_gradient.iter().flatten().copied().collect();
        check_finite(&values, "the gradient")?;
        array(py, values, &[result_gradient.len(), 3])
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
    ) -> PyResult<(
        (Floats<'py>, Bound<'py, PyArrayDyn<i64>>, Floats<'py>),
        Bound<'py, PyDict>,
    )> {
        let keywords = PyDict::new(py);
        keywords.set_item("inert_tets", true)?;
        Ok((
            (self.vertices(py)?, self.tets(py)?, self.extents(py)?),
            keywords,
        ))
    }
}
