//! Derivatives of ready-made shapes with respect to their dimensions.

use crate::arrays::{Whole, count, real, row, table, whole};
use crate::shape::Shape;
use crate::shape_rates::ShapeRates;
use hydroelastic::mesh::shapes;
use pyo3::prelude::*;

#[pymethods]
impl Shape {
    /// Computes the derivative of Shape.icosphere with respect to its radius (m).
    ///
    /// Parameters
    /// ----------
    /// radius, subdivisions
    ///     Arguments of Shape.icosphere.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 1.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn icosphere_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<ShapeRates> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        let rates = shapes::icosphere_rates(radius, subdivisions);
        ShapeRates::of(py, rates.map(|rates| [rates]))
    }

    /// Computes the derivatives of Shape.ellipsoid with respect to its semi-axes (m).
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
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn ellipsoid_rates(
        py: Python<'_>,
        semi_axes: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] subdivisions: Whole,
    ) -> PyResult<ShapeRates> {
        let subdivisions = count(subdivisions, "subdivisions")?;
        let semi_axes = row(semi_axes, "semi_axes")?;
        ShapeRates::of(py, shapes::ellipsoid_rates(semi_axes, subdivisions))
    }

    /// Computes the derivatives of Shape.cuboid with respect to its edge lengths (m).
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m).
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::cuboid_rates(row(lengths, "lengths")?))
    }

    /// Computes the derivatives of Shape.distance_cuboid with respect to its edge lengths (m).
    ///
    /// If two or three edges are the shortest, the inner vertices are ambiguous. Their rates are then exact for changes that keep these
    /// edges equal.
    ///
    /// Parameters
    /// ----------
    /// lengths : (3,) array_like
    ///     Edge lengths (m).
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 3.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a length is not positive and finite.
    #[staticmethod]
    fn distance_cuboid_rates(py: Python<'_>, lengths: &Bound<'_, PyAny>) -> PyResult<ShapeRates> {
        ShapeRates::of(py, shapes::distance_cuboid_rates(row(lengths, "lengths")?))
    }

    /// Computes the derivatives of Shape.cylinder with respect to its radius and its length (m).
    ///
    /// If the length is twice the radius of the circle inscribed in the base, the inner vertex is ambiguous. Its rates are then exact for
    /// a change of scale only.
    ///
    /// Parameters
    /// ----------
    /// radius, length, segments
    ///     Arguments of Shape.cylinder.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 2.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn cylinder_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<ShapeRates> {
        let segments = count(segments, "segments")?;
        ShapeRates::of(py, shapes::cylinder_rates(radius, length, segments))
    }

    /// Computes the derivatives of Shape.capsule with respect to its radius and its length (m).
    ///
    /// Parameters
    /// ----------
    /// radius, length, segments
    ///     Arguments of Shape.capsule.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 2.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn capsule_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
    ) -> PyResult<ShapeRates> {
        let segments = count(segments, "segments")?;
        ShapeRates::of(py, shapes::capsule_rates(radius, length, segments))
    }

    /// Computes the derivatives of Shape.torus with respect to its radius and the radius of its tube (m).
    ///
    /// Parameters
    /// ----------
    /// radius, tube_radius, segments, sides
    ///     Arguments of Shape.torus.
    ///
    /// Returns
    /// -------
    /// ShapeRates
    ///     Rates with k = 2.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an argument is out of range.
    #[staticmethod]
    fn torus_rates(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] radius: f64,
        #[pyo3(from_py_with = real)] tube_radius: f64,
        #[pyo3(from_py_with = whole)] segments: Whole,
        #[pyo3(from_py_with = whole)] sides: Whole,
    ) -> PyResult<ShapeRates> {
        let [segments, sides] = [count(segments, "segments")?, count(sides, "sides")?];
        ShapeRates::of(
            py,
            shapes::torus_rates(radius, tube_radius, segments, sides),
        )
    }

    /// Computes the derivatives of Shape.lathe with respect to its profile: the radius and the height (m) of the first point, of the
    /// second point and so on.
    ///
    /// The tetrahedra stay the same. Points on the axis stay there, so the rates with respect to their radii are zero.
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
    /// ShapeRates
    ///     Rates with k = 2n.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the profile is not a simple polygon, or an argument is out of range.
    #[staticmethod]
    fn lathe_rates(
        py: Python<'_>,
        profile: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = whole)] segments: Whole,
        #[pyo3(from_py_with = real)] resolution: f64,
    ) -> PyResult<ShapeRates> {
        let profile = table::<2>(profile, "profile")?;
        let segments = count(segments, "segments")?;
        ShapeRates::of(py, shapes::lathe_rates(&profile, segments, resolution))
    }

    /// Computes the derivatives of Shape.extrusion with respect to its polygon, and finally its length (m): x and y of the first point, of
    /// the second point and so on.
    ///
    /// The tetrahedra stay the same.
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
    /// ShapeRates
    ///     Rates with k = 2n + 1.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the polygon is not simple, or an argument is out of range.
    #[staticmethod]
    fn extrusion_rates(
        py: Python<'_>,
        polygon: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = real)] length: f64,
        #[pyo3(from_py_with = real)] resolution: f64,
    ) -> PyResult<ShapeRates> {
        let polygon = table::<2>(polygon, "polygon")?;
        ShapeRates::of(py, shapes::extrusion_rates(&polygon, length, resolution))
    }
}
