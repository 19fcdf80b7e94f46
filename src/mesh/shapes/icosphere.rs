use super::cored::CoredSurface;
use super::{check_resolution, checked_lengths, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::{Scalar, lift};
use nalgebra::Vector3;
use std::collections::HashMap;

/// Smallest and largest number of subdivisions: eight give 1.3 million tetrahedra, nearly a gigabyte.
const SUBDIVISIONS: [usize; 2] = [0, 8];

/// The triangles of an icosahedron, with corners numbered as in [`icosahedron`].
const ICOSAHEDRON: [[usize; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// Creates a ball of the given radius (m) with 20·4ᵏ tetrahedra, k = `subdivisions` (the paper, §V).
///
/// Each triangle of an icosahedron is split into four at its edge midpoints, `subdivisions` times. The vertices are
/// then projected to the sphere, and every triangle is joined to a center vertex of extent 1.
///
/// # Errors
/// Returns an error if the radius is not positive and finite, or if there are more than 8 subdivisions.
pub fn icosphere(radius: f64, subdivisions: usize) -> Result<PressureField, MeshError> {
    let [radius] = checked_lengths([("radius", radius)])?;
    ellipsoid([radius; 3], subdivisions)
}

/// Creates an ellipsoid with the given semi-axes (m): an icosphere, stretched, with extent 1 at its center.
///
/// # Errors
/// Returns an error if a semi-axis is not positive and finite, or if there are more than 8 subdivisions. Also returns
/// an error if the shape is so slender that tetrahedra are flat to within rounding error.
pub fn ellipsoid(semi_axes: [f64; 3], subdivisions: usize) -> Result<PressureField, MeshError> {
    filled(checked_semi_axes(semi_axes)?, subdivisions)?.field()
}

/// Computes the rates of change of an [`icosphere`] with respect to its radius (m). Each vertex of the surface moves
/// away from the center at the rate 1.
///
/// # Errors
/// Returns the errors of [`icosphere`].
pub fn icosphere_rates(radius: f64, subdivisions: usize) -> Result<ShapeRates, MeshError> {
    let [radius] = variables(checked_lengths([("radius", radius)])?);
    let [rates] = filled([radius; 3], subdivisions)?.rates()?;
    Ok(rates)
}

/// Computes the rates of change of an [`ellipsoid`] with respect to each of its semi-axes (m).
///
/// # Errors
/// Returns the errors of [`ellipsoid`].
pub fn ellipsoid_rates(
    semi_axes: [f64; 3],
    subdivisions: usize,
) -> Result<[ShapeRates; 3], MeshError> {
    filled(variables(checked_semi_axes(semi_axes)?), subdivisions)?.rates()
}

fn checked_semi_axes(semi_axes: [f64; 3]) -> Result<[f64; 3], MeshError> {
    checked_lengths(semi_axes.map(|length| ("semi-axis", length)))
}

/// Fills the stretched icosphere around its center.
fn filled<T: Scalar>(semi_axes: [T; 3], subdivisions: usize) -> Result<CoredSurface<T>, MeshError> {
    check_resolution("subdivisions", subdivisions, SUBDIVISIONS)?;
    let (corners, triangles) = (0..subdivisions).fold(icosahedron(), subdivided);
    let stretch = Vector3::from(semi_axes);
    let stretched = |corner: &Vector3<f64>| stretch.zip_map(&corner.normalize(), |s, x| s * x);
    let vertices: Vec<_> = corners.iter().map(stretched).collect();
    Ok(CoredSurface {
        core_points: vec![Vector3::from_element(lift(0.0)); vertices.len()],
        vertices,
        triangles,
        is_about_to_open: false,
    })
}

/// Vertices and triangles.
type Triangulation = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// Creates an icosahedron. Its corners are the cyclic permutations of (±1, ±φ, 0), where φ is the golden ratio.
fn icosahedron() -> Triangulation {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let sides = [
        (-1.0, golden),
        (1.0, golden),
        (-1.0, -golden),
        (1.0, -golden),
    ];
    let corners = [[0, 1, 2], [2, 0, 1], [1, 2, 0]]
        .iter()
        .flat_map(|axes| {
            sides.map(|(short, long)| Vector3::from(axes.map(|i| [short, long, 0.0][i])))
        })
        .collect();
    (corners, ICOSAHEDRON.to_vec())
}

/// Splits every triangle into four at the midpoints of its edges.
fn subdivided((mut corners, triangles): Triangulation, _: usize) -> Triangulation {
    let mut midpoints = HashMap::new();
    let mut midpoint = |a: usize, b: usize| {
        *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
            corners.push((corners[a] + corners[b]) * 0.5);
            corners.len() - 1
        })
    };
    let quarters = triangles
        .iter()
        .flat_map(|&[a, b, c]| {
            let (ab, bc, ca) = (midpoint(a, b), midpoint(b, c), midpoint(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    (corners, quarters)
}
