//! Shapes: pressure fields with their search trees.

use crate::arrays::{
    Floats, Whole, array, check_finite, count, indices, list, optional_real, real, row, signed,
    table, whole, whole_array,
};
use crate::errors::value_error;
use crate::shape_gradient::mass_gradient;
use hydroelastic::contact::{self, BodyError, ContactBody};
use hydroelastic::io::read_mesh;
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, TriangleSurface, shapes};
use hydroelastic::spatial::{MassProperties, Pose};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a compliant body is made of for contact: a tetrahedral mesh with an extent on every vertex, 0 on the surface and positive
/// inside.
/// The pressure is the hydroelastic modulus (Pa) times the extent. Any number of bodies may share a shape.
///
/// Parameters
/// ----------
/// vertices : (n, 3) float64, positions (m) in the body frame.
/// tets : (m, 4) integers, the vertices of each tetrahedron; either orientation.
/// extents : (n,) float64, or None for the distance to the surface over the largest one; tetrahedra whose corners all lie on the
///     surface are then divided, so that there are more vertices.
/// inert_tets : whether tetrahedra with the extent 0 at all corners are allowed. They have mass, but push nothing.
///
/// Raises
/// ------
/// HydroelasticError if the mesh or the field is not valid; the message names the culprit.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Shape(pub Arc<contact::Shape>);

impl Shape {
    /// From its field, if there is one.
    pub fn of(field: Result<PressureField, MeshError>) -> PyResult<Self> {
        let field = field.map_err(value_error)?;
        Ok(Self(Arc::new(contact::Shape::new(field))))
    }

    fn field(&self) -> &PressureField {
        self.0.field()
    }

    /// Reads the mesh in a file, with the numbers of the file in meters.
    fn in_file(py: Python<'_>, path: PathBuf, extents: Option<&str>) -> PyResult<Self> {
        if is_of(&path, &["vtk", "vtu"]) {
            let found = py.import("hydroelastic._vtk")?;
            let found = found.call_method1("read_mesh", (&path, extents))?;
            let (vertices, tets, extents): (Bound<'_, PyAny>, Bound<'_, PyAny>, Option<_>) =
                found.extract()?;
            let shape = Self::new(&vertices, &tets, extents.as_ref(), false);
            return shape.map_err(|error| {
                let (path, why) = (path.display(), error.value(py));
                value_error(format!("{path} does not hold a usable mesh: {why}"))
            });
        }
        py.detach(|| {
            let file = read_mesh(path).map_err(value_error)?;
            match extents {
                Some(name) => Self::of(Ok(file.pressure_field(name).map_err(value_error)?)),
                None => Self::of(PressureField::from_distance(&file.mesh)),
            }
        })
    }

    /// The body of a contact, at a pose, with a modulus (Pa).
    pub fn at(&self, pose: Pose, modulus: f64) -> Result<ContactBody<'_>, BodyError> {
        ContactBody::new(&self.0, pose, modulus)
    }
}

/// Mass, center of mass and inertia.
pub fn mass_arrays<'py>(
    py: Python<'py>,
    found: &MassProperties,
) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
    let center = found.center_of_mass.as_slice().to_vec();
    let inertia = found.inertia.transpose().as_slice().to_vec();
    Ok((
        found.mass,
        array(py, center, &[3])?,
        array(py, inertia, &[3, 3])?,
    ))
}

/// Above this size (m), the numbers of a file without a unit are probably in millimeters.
const LARGE: f64 = 100.0;

/// Whether the name of a file has one of these extensions.
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

/// Warns if the shape in a file has an unlikely size (m).
pub fn warn_of_size(py: Python<'_>, path: &Path, size: f64) -> PyResult<()> {
    if size <= LARGE {
        return Ok(());
    }
    let message = format!(
        "{} is {size:.4} m large if its numbers are meters: unit=1e-3 reads millimeters, and unit=1.0 meters without this warning",
        path.display()
    );
    let warnings = py.import("warnings")?;
    warnings.call_method1("warn", (message,)).map(|_| ())
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

    /// A mesh from a file: Gmsh 4.1 (.msh), VTK legacy (.vtk) or VTK XML (.vtu). Files of VTK are read by meshio, which
    /// the extra hydroelastic[files] installs. Vertices that no tetrahedron uses are left out.
    ///
    /// extents : the name of a point-data array of a VTK file, or None for the distance to the surface.
    /// unit : the unit of the file in meters, 0.001 for millimeters. None means 1, with a warning if the mesh is larger than 100 m.
    ///
    /// Raises
    /// ------
    /// ImportError for a file of VTK without meshio; HydroelasticError if the file is damaged or has no tetrahedra of first
    /// order, or solids of another kind.
    #[staticmethod]
    #[pyo3(signature = (path, extents=None, unit=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        extents: Option<&str>,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
    ) -> PyResult<Self> {
        check_extension(&path, &["stl", "obj"], |path| {
            format!(
                "{path} holds a surface, not a mesh of tetrahedra: RigidShape.read reads it as a rigid body, Shape.star_shaped makes \
                 a compliant one of vertices and triangles, and a mesher makes tetrahedra"
            )
        })?;
        let shape = Self::in_file(py, path.clone(), extents)?;
        let Some(unit) = unit else {
            let bounds = shape.field().mesh().aabb();
            warn_of_size(py, &path, 2.0 * bounds.half_extents().amax())?;
            return Ok(shape);
        };
        if !(unit > 0.0 && unit.is_finite()) {
            return Err(value_error(format!(
                "the unit of {} is {unit} m, but must be positive and finite",
                path.display()
            )));
        }
        let (mesh, extents) = (shape.field().mesh(), shape.field().extents().to_vec());
        let vertices = mesh.vertices().iter().map(|vertex| vertex * unit).collect();
        let mesh = TetMesh::new(vertices, mesh.tets().to_vec()).map_err(value_error)?;
        Self::of(PressureField::with_inert_tets(mesh, extents))
    }

    /// A ball about the origin of the body frame: radius (m), and how often the 20 faces of an icosahedron are divided by four
    /// (0 to 8).
    #[staticmethod]
    fn icosphere(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<Self> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        Self::of(shapes::icosphere(radius, subdivisions))
    }

    /// An ellipsoid with three semi-axes (m): an icosphere, stretched.
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

    /// A box with edges of three lengths (m); the extent rises from each face to 1 at the center.
    #[staticmethod]
    fn cuboid(lengths: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of(shapes::cuboid(row(lengths, "lengths")?))
    }

    /// A box with edges of three lengths (m); the extent is the distance to the surface, over half the shortest edge.
    #[staticmethod]
    fn distance_cuboid(lengths: &Bound<'_, PyAny>) -> PyResult<Self> {
        Self::of(shapes::distance_cuboid(row(lengths, "lengths")?))
    }

    /// A prism with a regular polygon of some segments as its base, for a cylinder along z: radius (m), length (m).
    #[staticmethod]
    fn cylinder(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<Self> {
        let segments = count(segments, "segments")?;
        Self::of(shapes::cylinder(radius, length, segments))
    }

    /// The solid inside a closed surface of triangles that can all be seen from one point inside, as those of convex solids.
    /// Vertices at exactly the same place are merged, and vertices that no triangle uses are dropped.
    ///
    /// vertices : (n, 3) float64 (m); triangles : (m, 3) integers; inner_point : (3,) (m), or None for the center of volume.
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
        let surface = TriangleSurface::welded(vertices, triangles).map_err(value_error)?;
        Self::of(match inner_point {
            None => shapes::star_shaped(&surface),
            Some(point) => {
                let point = row::<3>(point, "inner_point")?;
                shapes::star_shaped_about(point.into(), &surface)
            }
        })
    }

    /// (n, 3) float64: positions of the vertices (m), in the body frame.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let vertices = self.field().mesh().vertices();
        let values = vertices.iter().flat_map(|v| v.iter().copied()).collect();
        array(py, values, &[vertices.len(), 3])
    }

    /// (m, 4) int64: the vertices of each tetrahedron, positively oriented.
    #[getter]
    fn tets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<i64>>> {
        let tets = self.field().mesh().tets();
        whole_array(
            py,
            signed(tets.as_flattened().iter().copied()),
            &[tets.len(), 4],
        )
    }

    /// (n,) float64: the extent of each vertex.
    #[getter]
    fn extents<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let extents = self.field().extents();
        array(py, extents.to_vec(), &[extents.len()])
    }

    /// (k, 3) int64: the triangles of the surface, counter-clockwise seen from outside.
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

    /// Mass (kg), center of mass (3,) (m) and inertia (3, 3) (kg m²) about it, in the body frame, at a uniform density (kg/m³).
    fn mass_properties<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] density: f64,
    ) -> PyResult<(f64, Floats<'py>, Floats<'py>)> {
        let found = self.field().mesh().mass_properties(density);
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
        let found = self.field().mesh().mass_gradient(density, &gradient);
        let found = found.map_err(value_error)?;
        let values: Vec<f64> = found.iter().flatten().copied().collect();
        check_finite(&values, "the gradient")?;
        array(py, values, &[found.len(), 3])
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
