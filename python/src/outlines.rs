//! Capsules, tori, solids of revolution, extrusions, compounds and skins.

use crate::arrays::{Whole, count, indices, real, table, whole};
use crate::poses::single_pose;
use crate::shape::Shape;
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use pyo3::prelude::*;

#[pymethods]
impl Shape {
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
    /// solid is a ring. The extent is the distance to the surface over the largest distance, interpolated between vertices.
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
    /// The extent is the distance to the surface over the largest distance, interpolated between vertices.
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
        let fields = parts.iter().map(|(shape, _)| shape.get().0.field());
        let parts: Vec<_> = fields.zip(poses).collect();
        Self::of(shapes::compound(&parts))
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
        let vertices = table::<3>(vertices, "vertices")?;
        let vertices = vertices.into_iter().map(Into::into).collect();
        let tets = indices(tets, "tets")?;
        let field = |mesh: TetMesh| PressureField::from_distance_up_to(&mesh, depth);
        let field: Result<_, MeshError> = TetMesh::new(vertices, tets).and_then(field);
        Self::of(field)
    }
}
