//! Solids: tetrahedra that fill surfaces, triangles with holes, and regions of distance functions.

use crate::arrays::{
    Floats, array, check_finite, finite_row, list, named_error, optional_real, signed, whole_array,
};
use crate::errors::value_error;
use crate::mesh_arrays::{Indices, finite_vectors, index_array, triangle_soup, vector_array};
use crate::rigid_shape::RigidShape;
use crate::shape::Shape;
use crate::shape_files::{placement, surface_error, warn};
use crate::shape_rates::ShapeRates;
use hydroelastic::geometry::Aabb;
use hydroelastic::io::read_triangles;
use hydroelastic::mesh::{
    self, LinearizedDistances, MeshError, Resolution, SolidError, SurfaceWarning, TriangleSoup,
};
use hydroelastic::nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Mutex;

/// Tetrahedra that fill a region, with the derivatives of their vertices.
///
/// The tetrahedra are made by isosurface stuffing: a lattice whose nodes near the boundary move onto it. Each vertex is either a node of
/// the lattice, which is fixed, or at the boundary, on an edge of the lattice that crosses it. Vertices at smooth, curved triangles move
/// along their edges, so that the triangles pass through the surface of the tetrahedra in the mean. Edges and corners of the region are cut
/// off by less than a spacing, and walls must be thicker than a spacing.
///
/// The static methods take the spacing of the lattice (m), or the largest error of the volume or of the distance to the surface. For an
/// error, the spacing is refined until the error is reached. The refinement stops with a warning (UserWarning) if the next mesh is
/// expected to have more than 500,000 tetrahedra or needs more than 1e8 cells. The default is a distance error of 0.02.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Solid {
    region: Region,
    resolution: ResolutionArguments,
    inner: mesh::Solid,
    shape: Shape,
    distances: LinearizedDistances,
}

/// The region that a solid fills, for pickles.
enum Region {
    Surface(RigidShape),
    Triangles(TriangleSoup),
    Distance {
        distances: Py<PyAny>,
        lower: [f64; 3],
        upper: [f64; 3],
    },
}

/// The arguments `spacing`, `volume_error` and `distance_error`. At most one of them is given.
#[derive(Clone, Copy)]
struct ResolutionArguments([Option<f64>; 3]);

impl ResolutionArguments {
    const NAMES: [&str; 3] = ["spacing", "volume_error", "distance_error"];

    fn resolution(self) -> PyResult<Resolution> {
        match self.0 {
            [None, None, None] => Ok(Resolution::default()),
            [Some(spacing), None, None] => Ok(Resolution::Spacing(spacing)),
            [None, Some(error), None] => Ok(Resolution::VolumeWithin(error)),
            [None, None, Some(error)] => Ok(Resolution::DistanceWithin(error)),
            several => {
                let given = Self::NAMES.iter().zip(several);
                let given = given.filter_map(|(name, value)| Some(format!("{name}={:?}", value?)));
                let given = given.collect::<Vec<_>>().join(", ");
                Err(value_error(format!(
                    "a solid has a spacing, a volume error or a distance error, but several were given: {given}"
                )))
            }
        }
    }
}

impl Solid {
    fn new(
        region: Region,
        resolution: ResolutionArguments,
        solid: Result<mesh::Solid, SolidError>,
    ) -> PyResult<Self> {
        let inner = solid.map_err(value_error)?;
        let (field, distances) = inner.linearized_field().map_err(value_error)?;
        Ok(Self {
            region,
            resolution,
            inner,
            shape: Shape::of(Ok(field))?,
            distances,
        })
    }

    fn of_closed(surface: RigidShape, resolution: ResolutionArguments) -> PyResult<Self> {
        let solid = mesh::Solid::of_surface(surface.surface(), resolution.resolution()?);
        Self::new(Region::Surface(surface), resolution, solid)
    }

    fn of_soup(soup: TriangleSoup, resolution: ResolutionArguments) -> PyResult<Self> {
        let solid = soup.solid(resolution.resolution()?);
        Self::new(Region::Triangles(soup), resolution, solid)
    }

    /// Emits the warnings of the solid.
    fn warned(self, py: Python<'_>, name: impl Display) -> PyResult<Self> {
        warn(py, name, self.inner.warnings().iter().copied(), true)?;
        Ok(self)
    }

    /// Converts velocities of the vertices of the solid to rates of the shape.
    fn shape_rates(
        &self,
        py: Python<'_>,
        velocities: Result<Vec<Vector3<f64>>, MeshError>,
    ) -> PyResult<ShapeRates> {
        let rates = velocities.and_then(|velocities| self.distances.rates(&velocities));
        let mut rates = rates.map_err(value_error)?;
        rates.ambiguous = self.ambiguous();
        ShapeRates::of_one(py, &rates)
    }
}

/// Calls a Python function that returns the distances of points.
fn called(distances: &Py<PyAny>, points: &[Vector3<f64>]) -> PyResult<Vec<f64>> {
    Python::attach(|py| {
        let values = distances.bind(py).call1((vector_array(py, points)?,))?;
        list(&values, "the result of the distance function")
    })
}

#[pymethods]
impl Solid {
    /// Fills a closed surface. Components that overlap are united.
    ///
    /// Parameters
    /// ----------
    /// surface : RigidShape
    ///     Surface.
    /// spacing : float, optional
    ///     Spacing of the lattice (m), positive.
    /// volume_error : float, optional
    ///     Largest error of the volume over the volume, positive.
    /// distance_error : float, optional
    ///     Largest mean error of the interpolated distance over the mean distance, positive.
    ///
    /// Returns
    /// -------
    /// Solid
    ///     Tetrahedra inside the surface.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the resolution is out of range or too fine, or several are given.
    #[staticmethod]
    #[pyo3(signature = (surface, *, spacing=None, volume_error=None, distance_error=None))]
    fn of_surface(
        py: Python<'_>,
        surface: &RigidShape,
        #[pyo3(from_py_with = optional_real)] spacing: Option<f64>,
        #[pyo3(from_py_with = optional_real)] volume_error: Option<f64>,
        #[pyo3(from_py_with = optional_real)] distance_error: Option<f64>,
    ) -> PyResult<Self> {
        let resolution = ResolutionArguments([spacing, volume_error, distance_error]);
        let solid = py.detach(|| Self::of_closed(surface.clone(), resolution))?;
        solid.warned(py, "the surface")
    }

    /// Fills the inside of triangles, also with small holes. The triangles may be turned inwards as a whole, and may overlap.
    ///
    /// A point is inside if its generalized winding number is above one half in absolute value.
    ///
    /// Parameters
    /// ----------
    /// vertices : (n, 3) array_like
    ///     Positions (m) in the body frame.
    /// triangles : (m, 3) array_like of int
    ///     Vertex indices of each triangle.
    /// spacing : float, optional
    ///     Spacing of the lattice (m), positive.
    /// volume_error : float, optional
    ///     Largest error of the volume over the volume, positive.
    /// distance_error : float, optional
    ///     Largest mean error of the interpolated distance over the mean distance, positive.
    ///
    /// Returns
    /// -------
    /// Solid
    ///     Tetrahedra inside the triangles.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the triangles do not enclose a solid, or a number is not valid. If the resolution is out of range or too fine, or
    ///     several are given.
    #[staticmethod]
    #[pyo3(signature = (vertices, triangles, *, spacing=None, volume_error=None, distance_error=None))]
    fn of_triangles(
        py: Python<'_>,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = optional_real)] spacing: Option<f64>,
        #[pyo3(from_py_with = optional_real)] volume_error: Option<f64>,
        #[pyo3(from_py_with = optional_real)] distance_error: Option<f64>,
    ) -> PyResult<Self> {
        let resolution = ResolutionArguments([spacing, volume_error, distance_error]);
        let soup = triangle_soup(vertices, triangles)?;
        let solid = py.detach(|| Self::of_soup(soup, resolution))?;
        solid.warned(py, "the triangles")
    }

    /// Fills the region in which a signed distance is negative.
    ///
    /// Exceptions of the function are raised unchanged. A solid can be pickled if its function can.
    ///
    /// Parameters
    /// ----------
    /// distances : function of points
    ///     Function that takes points (m), (n, 3), and returns their distances (m), (n,). They are negative inside. They may be smaller than
    ///     the distance in absolute value, but not larger.
    /// lower : (3,) array_like
    ///     Lower corner (m) of a box that contains the region.
    /// upper : (3,) array_like
    ///     Upper corner (m) of the box.
    /// spacing : float, optional
    ///     Spacing of the lattice (m), positive.
    /// volume_error : float, optional
    ///     Largest error of the volume over the volume, positive. The error is estimated from the last refinement.
    /// distance_error : float, optional
    ///     Largest mean error of the interpolated distance over the mean distance, positive.
    ///
    /// Returns
    /// -------
    /// Solid
    ///     Tetrahedra inside the region.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a distance is not finite, the function returns the wrong number of distances, or the region is empty or reaches beyond the box.
    ///     If the resolution is out of range or too fine, or several are given.
    #[staticmethod]
    #[pyo3(signature = (distances, lower, upper, *, spacing=None, volume_error=None, distance_error=None))]
    fn of_distance(
        py: Python<'_>,
        distances: Py<PyAny>,
        lower: &Bound<'_, PyAny>,
        upper: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = optional_real)] spacing: Option<f64>,
        #[pyo3(from_py_with = optional_real)] volume_error: Option<f64>,
        #[pyo3(from_py_with = optional_real)] distance_error: Option<f64>,
    ) -> PyResult<Self> {
        let arguments = ResolutionArguments([spacing, volume_error, distance_error]);
        let resolution = arguments.resolution()?;
        let [lower, upper] = [finite_row(lower, "lower")?, finite_row(upper, "upper")?];
        let bounds = Aabb {
            lower: lower.into(),
            upper: upper.into(),
        };
        let solid = py.detach(|| {
            let raised = Mutex::new(None);
            let checked = |points: &[Vector3<f64>]| {
                // NaN ends the search. The library discards it.
                let no_distances = vec![f64::NAN; points.len()];
                match raised.lock() {
                    Ok(mut raised) if raised.is_none() => called(&distances, points)
                        .unwrap_or_else(|error| {
                            *raised = Some(error);
                            no_distances
                        }),
                    _ => no_distances,
                }
            };
            let solid = mesh::Solid::of_distance(checked, bounds, resolution);
            if let Some(error) = raised.into_inner().unwrap_or_default() {
                return Err(error);
            }
            let region = Region::Distance {
                distances,
                lower,
                upper,
            };
            Self::new(region, arguments, solid)
        })?;
        solid.warned(py, "the region")
    }

    /// Fills the triangles of a file that RigidShape.read reads: a closed surface as by of_surface, and other triangles as by
    /// of_triangles.
    ///
    /// Parameters
    /// ----------
    /// path : path-like
    ///     File.
    /// unit : float, optional
    ///     Unit of the file in meters, such as 0.001 for the millimeters of most CAD programs. None, the default, means 1, with a
    ///     warning if the triangles are larger than 10 m or smaller than 0.1 mm. glTF and COLLADA files are in meters already.
    /// scale : (3,) array_like, optional
    ///     Factor for each axis of the file. A negative factor mirrors the body. Default: 1.
    /// pose : (4, 4) array_like, optional
    ///     Pose of the axes of the file in the body frame. Default: the identity.
    /// spacing : float, optional
    ///     Spacing of the lattice (m), positive.
    /// volume_error : float, optional
    ///     Largest error of the volume over the volume, positive. The error is estimated from the last refinement.
    /// distance_error : float, optional
    ///     Largest mean error of the interpolated distance over the mean distance, positive.
    ///
    /// Returns
    /// -------
    /// Solid
    ///     Tetrahedra inside the triangles.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an option is out of range, the file is damaged, or its triangles do not enclose a solid. If the resolution is too
    ///     fine, or several are given.
    /// OSError
    ///     If the file cannot be read from the disk.
    #[staticmethod]
    #[pyo3(signature = (path, unit=None, *, scale=None, pose=None, spacing=None, volume_error=None, distance_error=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        #[pyo3(from_py_with = optional_real)] unit: Option<f64>,
        scale: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = optional_real)] spacing: Option<f64>,
        #[pyo3(from_py_with = optional_real)] volume_error: Option<f64>,
        #[pyo3(from_py_with = optional_real)] distance_error: Option<f64>,
    ) -> PyResult<Self> {
        let resolution = ResolutionArguments([spacing, volume_error, distance_error]);
        let placement = placement(unit, scale, pose)?;
        let soup = py.detach(|| read_triangles(&path, &placement).map_err(surface_error))?;
        let warning = SurfaceWarning::of_size(&Aabb::around(&soup.vertices));
        warn(py, path.display(), warning, unit.is_some())?;
        let solid = py.detach(|| match soup.clone().closed() {
            Ok(surface) => Self::of_closed(RigidShape::of(Ok(surface))?, resolution),
            Err(_) => Self::of_soup(soup, resolution),
        });
        let solid = solid.map_err(|error| named_error(&path.display().to_string(), &error))?;
        solid.warned(py, path.display())
    }

    /// Compliant shape whose extents are the distances to the surface of the tetrahedra over the largest distance. The extents are fitted, so
    /// that the mean error of the interpolation around each vertex is about zero. The largest extent exceeds 1 by a few percent.
    #[getter]
    fn shape(&self) -> Shape {
        self.shape.clone()
    }

    /// Positions (m) of the vertices in the body frame, (v, 3) float64.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, self.inner.mesh().vertices())
    }

    /// Vertex indices of each tetrahedron, positively oriented, (m, 4) int64.
    #[getter]
    fn tets<'py>(&self, py: Python<'py>) -> PyResult<Indices<'py>> {
        index_array(py, self.inner.mesh().tets())
    }

    /// Spacing of the lattice (m).
    #[getter]
    fn spacing(&self) -> f64 {
        self.inner.spacing()
    }

    /// Error of the volume over the volume, or None if it is not known. It is exact for a surface of one component. For other regions it is
    /// the change in the last refinement, and known if a volume error was asked for.
    #[getter]
    fn volume_error(&self) -> Option<f64> {
        self.inner.volume_error()
    }

    /// Mean error of the interpolated distance to the surface over the mean distance, at points up to two fifths of the largest distance, or
    /// None if a spacing or a volume error was asked for.
    #[getter]
    fn distance_error(&self) -> Option<f64> {
        self.inner.distance_error()
    }

    /// Positions (m) of the vertices of the triangles that were filled, (n, 3) float64. The array is empty for a distance function.
    #[getter]
    fn surface_vertices<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(
            py,
            match &self.region {
                Region::Surface(surface) => surface.surface().vertices(),
                Region::Triangles(soup) => &soup.vertices,
                Region::Distance { .. } => &[],
            },
        )
    }

    /// Indices of the vertices on the boundary, (b,) int64, in the order of the arguments of rates_of_distance.
    #[getter]
    fn boundary_vertices<'py>(&self, py: Python<'py>) -> PyResult<Indices<'py>> {
        let vertices = signed(self.inner.boundary_vertices());
        let count = vertices.len();
        whole_array(py, vertices, &[count])
    }

    /// Indices of the vertices of the shape without a unique derivative, ascending: vertices at which a small change of the boundary
    /// changes the tetrahedra or the edge of the lattice, vertices on edges between triangles that are not in one plane, vertices that
    /// have no triangle to follow, the neighbors of these vertices on the boundary, and the vertices of LinearizedShape.ambiguous.
    #[getter]
    fn ambiguous(&self) -> Vec<usize> {
        let mut ambiguous = [self.inner.ambiguous(), self.distances.ambiguous()].concat();
        ambiguous.sort_unstable();
        ambiguous.dedup();
        ambiguous
    }

    /// Computes the gradient of a loss with respect to the vertices of the triangles from its gradient with respect to the shape.
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
    /// (n, 3) ndarray of float64
    ///     Derivatives with respect to the surface_vertices.
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
    ) -> PyResult<Floats<'py>> {
        let by_vertices = finite_vectors(by_vertices, "by_vertices")?;
        let by_extents = list(by_extents, "by_extents")?;
        check_finite(&by_extents, "by_extents")?;
        let gradient = self.distances.pullback(&by_vertices, &by_extents);
        let gradient = gradient.and_then(|gradient| self.inner.pullback(&gradient.by_vertices));
        vector_array(py, &gradient.map_err(value_error)?)
    }

    /// Computes the rates of the shape if the vertices of the triangles move.
    ///
    /// Parameters
    /// ----------
    /// velocities : (n, 3) array_like
    ///     Velocity of each of the surface_vertices, in the body frame.
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
        self.shape_rates(py, self.inner.rates(&velocities))
    }

    /// Computes the rates of the shape with respect to a parameter of the distance function.
    ///
    /// The arguments are derivatives of the distance at vertices[boundary_vertices].
    ///
    /// Parameters
    /// ----------
    /// gradients : (b, 3) array_like
    ///     Gradient of the distance with respect to the point.
    /// by_parameter : (b,) array_like
    ///     Derivative of the distance with respect to the parameter.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with one number: vertices (v, 3) and extents (v,).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an array has an unexpected shape, a number is not finite, or a gradient is orthogonal to the edge of the lattice.
    fn rates_of_distance(
        &self,
        py: Python<'_>,
        gradients: &Bound<'_, PyAny>,
        by_parameter: &Bound<'_, PyAny>,
    ) -> PyResult<ShapeRates> {
        let gradients = finite_vectors(gradients, "gradients")?;
        let by_parameter = list(by_parameter, "by_parameter")?;
        check_finite(&by_parameter, "by_parameter")?;
        let velocities = self.inner.rates_of_distance(&gradients, &by_parameter);
        self.shape_rates(py, velocities)
    }

    fn __repr__(&self) -> String {
        let spacing = self.inner.spacing();
        format!("Solid({}, spacing {spacing:.3e} m)", self.shape.__repr__())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Made<'py>> {
        let (method, arguments) = match &self.region {
            Region::Surface(surface) => ("of_surface", (surface.clone(),).into_pyobject(py)?),
            Region::Triangles(soup) => (
                "of_triangles",
                (
                    vector_array(py, &soup.vertices)?,
                    index_array(py, &soup.triangles)?,
                )
                    .into_pyobject(py)?,
            ),
            Region::Distance {
                distances,
                lower,
                upper,
            } => (
                "of_distance",
                (
                    distances,
                    array(py, lower.to_vec(), &[3])?,
                    array(py, upper.to_vec(), &[3])?,
                )
                    .into_pyobject(py)?,
            ),
        };
        let load = py.import("hydroelastic._core")?.getattr("_load_solid")?;
        let keywords = PyDict::new(py);
        for (name, value) in ResolutionArguments::NAMES.iter().zip(self.resolution.0) {
            keywords.set_item(name, value)?;
        }
        Ok((load, (method, arguments, keywords)))
    }
}

/// Function that restores a solid, and its arguments.
type Made<'py> = (
    Bound<'py, PyAny>,
    (&'static str, Bound<'py, PyTuple>, Bound<'py, PyDict>),
);

/// Calls a static method of Solid, to restore a pickle.
///
/// Parameters
/// ----------
/// method : str
///     Name of the method.
/// arguments : sequence of object
///     Positional arguments.
/// keywords : dict of str to object
///     Other arguments.
#[pyfunction]
pub fn _load_solid<'py>(
    py: Python<'py>,
    method: &str,
    arguments: Bound<'py, PyTuple>,
    keywords: Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    py.get_type::<Solid>()
        .call_method(method, arguments, Some(&keywords))
}
