use super::cored::{CoredSurface, core_size, is_about_to_open, least};
use super::{checked_lengths, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::{Scalar, lift, real_part, real_vector};
use nalgebra::Vector3;

/// The twelve triangles of a box over corners numbered 4·x + 2·y + z, opposite faces split alike.
const TRIANGLES: [[usize; 3]; 12] = [
    [0, 1, 3],
    [0, 3, 2],
    [4, 7, 5],
    [4, 6, 7],
    [0, 4, 5],
    [0, 5, 1],
    [2, 7, 6],
    [2, 3, 7],
    [0, 2, 6],
    [0, 6, 4],
    [1, 7, 3],
    [1, 5, 7],
];

/// A box with edges of the given lengths (m): eight corners, a center of extent 1, and twelve
/// tetrahedra (the paper, §V).
///
/// In a cube the field is the distance to the surface; in a longer box it rises more slowly from
/// the far faces than from the near ones, and [`distance_cuboid`] has the true distance.
///
/// # Errors
/// If a length is not positive and finite, or the box so slender (a rod of 1 : 10⁶) that
/// tetrahedra are flat to round-off.
pub fn cuboid(lengths: [f64; 3]) -> Result<PressureField, MeshError> {
    let half = half_edges(checked_edges(lengths)?);
    filled(half, Vector3::zeros()).field()
}

/// How the vertices and extents of a [`cuboid`] change with each of its three edges (m): the faces across it move outwards by
/// half as much.
///
/// ```
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
///
/// let lengths = [0.3, 0.2, 0.1];
/// let field = shapes::cuboid(lengths)?;
/// let rates = shapes::cuboid_rates(lengths)?;
/// // A vertex is as far from the middle as half the edges are long.
/// for (vertex, at) in field.mesh().vertices().iter().enumerate() {
///     let by_edges = rates.iter().zip(lengths);
///     let parts = by_edges.map(|(by_edge, length)| by_edge.vertices[vertex] * length);
///     assert_eq!(*at, parts.sum::<Vector3<f64>>());
/// }
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// As [`cuboid`].
pub fn cuboid_rates(lengths: [f64; 3]) -> Result<[ShapeRates; 3], MeshError> {
    let half = half_edges(variables(checked_edges(lengths)?));
    filled(half, Vector3::from_element(lift(0.0))).rates()
}

/// A box with edges of the given lengths (m) whose field is the true distance to the surface,
/// over the largest distance: half the shortest edge.
///
/// The points farthest from the surface form a rectangle, a segment (two edges shortest) or a
/// point (a cube); each face is joined to its part of it.
///
/// # Errors
/// If a length is not positive and finite, or the box so slender (a rod of 1 : 10⁶) that
/// tetrahedra are flat to round-off.
pub fn distance_cuboid(lengths: [f64; 3]) -> Result<PressureField, MeshError> {
    let half = half_edges(checked_edges(lengths)?);
    distance_filled(half).field()
}

/// How the vertices and extents of a [`distance_cuboid`] change with each of its three edges (m).
///
/// Where two edges are shortest, or all, the core opens in a new direction as one of them changes, and the vertices of the box
/// cannot tell how. [`ShapeRates::ambiguous`] then lists those of the core, and the rates are those of the core as it is: a
/// point stays one, and the ends of a segment move by half of what each of the two edges would have them do. They are exact for
/// changes that keep the shortest edges equal, as a change of size. The faces of the box have no such places.
///
/// # Errors
/// As [`distance_cuboid`].
pub fn distance_cuboid_rates(lengths: [f64; 3]) -> Result<[ShapeRates; 3], MeshError> {
    let half = half_edges(variables(checked_edges(lengths)?));
    distance_filled(half).rates()
}

fn checked_edges(lengths: [f64; 3]) -> Result<[f64; 3], MeshError> {
    checked_lengths(lengths.map(|length| ("edge length", length)))
}

fn half_edges<T: Scalar>(lengths: [T; 3]) -> Vector3<T> {
    lengths.map(|length| length * 0.5).into()
}

/// The box with these half edges around the points farthest from its surface.
fn distance_filled<T: Scalar>(half: Vector3<T>) -> CoredSurface<T> {
    let depth = least(half.as_slice());
    let core = half.map(|half| half - depth);
    let solid = solid_core(core, &real_vector(&half));
    let depth = real_part(depth);
    let (core, shortest) = (real_vector(&core), real_vector(&core).imin());
    let opens = |axis| axis != shortest && is_about_to_open(core[axis], solid[axis], depth);
    CoredSurface {
        is_about_to_open: (0..3).any(opens),
        ..filled(half, solid)
    }
}

/// The box with the half edges `half`, around a core with the half edges `core_half`.
fn filled<T: Scalar>(half: Vector3<T>, core_half: Vector3<T>) -> CoredSurface<T> {
    let corners = |half: Vector3<T>| {
        let corner = |c| signs(c).zip_map(&half, |sign, half| half * sign);
        (0..8).map(corner).collect()
    };
    CoredSurface {
        vertices: corners(half),
        triangles: TRIANGLES.to_vec(),
        core_points: corners(core_half),
        is_about_to_open: false,
    }
}

/// The half edges of the core without those along which tetrahedra would be flat.
///
/// The slimmest tetrahedra along the longest core edge 2c₁ have an edge of the surface, at least
/// twice the depth d, at the distance d across it: six times their volume is 2c₁·2d·d. Along the
/// next one, 2c₂, there are some with both core edges: 2c₂·2c₁·d.
fn solid_core<T: Scalar>(core_half: Vector3<T>, half: &Vector3<f64>) -> Vector3<T> {
    let (depth, longest) = (half.min(), 2.0 * half.max());
    let core = real_vector(&core_half);
    let (first, last) = (core.imax(), core.imin());
    let mut solid = Vector3::from_element(lift(0.0));
    solid[first] = core_size(core_half[first], 4.0 * depth * depth, longest);
    if first != last {
        let second = 3 - first - last;
        solid[second] = core_size(
            core_half[second],
            4.0 * real_part(solid[first]) * depth,
            longest,
        );
    }
    solid
}

/// The octant of a corner.
fn signs(corner: usize) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        if corner >> (2 - axis) & 1 == 1 {
            1.0
        } else {
            -1.0
        }
    })
}
