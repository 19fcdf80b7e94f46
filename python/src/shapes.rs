//! Ready-made shapes.

use crate::arrays::{Whole, count, real, row, table, whole};
use crate::errors::value_error;
use crate::mesh_arrays::{triangle_soup, vectors};
use crate::poses::single_pose;
use crate::shape::Shape;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use pyo3::prelude::*;

#[pymethods]
impl Shape {
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

    /// Creates a capsule about the z axis: a cylinder with half balls at its ends.
    ///
    /// Parameters
    /// ----------
    /// radius : float
    ///     Radius (m).
    /// length : float
    ///     Length (m) of the cylinder alone.
    /// segments : int
    ///     Number of sides, from 3 to 1,000.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Capsule about the origin of the body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn capsule(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<Self> {
        Self::of(shapes::capsule(
            radius,
            length,
            count(segments, "segments")?,
        ))
    }

    /// Creates a torus about the z axis. The extent is 1 on the center of the tube.
    ///
    /// Parameters
    /// ----------
    /// radius : float
    ///     Radius (m) of the circle at the center of the tube.
    /// tube_radius : float
    ///     Radius (m) of the tube, less than radius.
    /// segments : int
    ///     Number of steps around the axis, from 3 to 10,000.
    /// sides : int
    ///     Number of sides of the tube, from 3 to 10,000.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Torus about the origin of the body frame.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn torus(
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] tube_radius: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
        #[pyo3(from_py_with = whole)] sides: Whole,
    ) -> PyResult<Self> {
        let [segments, sides] = [count(segments, "segments")?, count(sides, "sides")?];
        Self::of(shapes::torus(radius, tube_radius, segments, sides))
    }

    /// Creates a solid of revolution, such as a cup, a bottle or a ring: a profile that is turned about the z axis.
    ///
    /// If the first and last points have the radius 0, the solid meets the axis. If all radii are positive, the profile is closed, and the
    /// solid is a ring. The extent is the distance to the surface over the largest distance. The mesh is refined until the interpolated
    /// distance has a mean error of at most 0.5 %.
    ///
    /// Parameters
    /// ----------
    /// profile : (n, 2) array_like
    ///     Radius and height (m) of each point.
    /// segments : int
    ///     Number of steps around the axis, from 3 to 10,000.
    /// resolution : float
    ///     Largest edge (m) in the cross-section, about the thickness of the wall.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Solid of revolution.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the profile is not a simple polygon, or an argument is out of range.
    #[staticmethod]
    fn lathe(
        profile: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] segments: Whole,
        #[pyo3(from_py_with = real)] resolution: f64,
    ) -> PyResult<Self> {
        let profile = table::<2>(profile, "profile")?;
        let segments = count(segments, "segments")?;
        Self::of(shapes::lathe(&profile, segments, resolution))
    }

    /// Creates a prism along z with a simple polygon as its base. The polygon may be concave.
    ///
    /// The extent is the distance to the surface over the largest distance. The mesh is refined until the interpolated distance has a
    /// mean error of at most 0.5 %.
    ///
    /// Parameters
    /// ----------
    /// polygon : (n, 2) array_like
    ///     Points (m) of the base.
    /// length : float
    ///     Length (m) along z, half of it on each side of the origin.
    /// resolution : float
    ///     Largest edge (m) of the mesh in the base and along z.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Prism.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the polygon is not simple, or an argument is out of range.
    #[staticmethod]
    fn extrusion(
        polygon: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = real)] resolution: f64,
    ) -> PyResult<Self> {
        let polygon = table::<2>(polygon, "polygon")?;
        Self::of(shapes::extrusion(&polygon, length, resolution))
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
        let soup = triangle_soup(vertices, triangles)?;
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
        Self::of(shapes::convex_hull(&vectors(points, "points")?))
    }

    /// Creates one shape of several parts, which may touch but must not overlap. Each part keeps its extents.
    ///
    /// Parameters
    /// ----------
    /// parts : list of (Shape, (4, 4) array_like)
    ///     Shapes with the poses of their frames in the body frame.
    ///
    /// Returns
    /// -------
    /// Shape
    ///     Compound of the parts.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If there are no parts, or if two parts overlap. The message names the parts.
    #[staticmethod]
    fn compound(parts: Vec<(Py<Shape>, Bound<'_, PyAny>)>) -> PyResult<Self> {
        let poses = parts.iter().map(|(_, pose)| single_pose(pose, "pose"));
        let poses: Vec<Pose> = poses.collect::<PyResult<_>>()?;
        let fields = parts.iter().map(|(shape, _)| shape.get().field());
        let parts: Vec<_> = fields.zip(poses).collect();
        Self::of(shapes::compound(&parts))
    }
}
