use super::cored::{CoredSurface, core_size, is_about_to_open, least};
use super::{checked_lengths, variables};
use crate::mesh::{MeshError, PressureField, ShapeRates};
use crate::scalar::{Scalar, lift, real_part, real_vector};
use nalgebra::Vector3;

/// The twelve triangles of a box. Corners are numbered 4·x + 2·y + z, and opposite faces are divided alike.
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

/// Creates a box with the given edge lengths (m): eight corners, a center of extent 1, and twelve tetrahedra (the
/// paper, §V).
///
/// In a cube the field is proportional to the distance to the surface. In a longer box it rises more slowly from the
/// far faces than from the near ones. [`distance_cuboid`] has the true distance.
///
/// # Errors
/// Returns an error if a length is not positive and finite, or if the box is so slender (a rod of 1 : 10⁶) that
/// tetrahedra are flat to within rounding error.
pub fn cuboid(lengths: [f64; 3]) -> Result<PressureField, MeshError> {
    let half = half_edges(checked_edges(lengths)?);
    filled(half, Vector3::zeros()).field()
}

/// Computes the rates of change of a [`cuboid`] with respect to each of its three edge lengths (m). The two faces
/// across an edge move outwards by half its change.
///
/// ```
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
///
/// let lengths = [0.3, 0.2, 0.1];
/// let field = shapes::cuboid(lengths)?;
/// let rates = shapes::cuboid_rates(lengths)?;
/// // Vertex coordinates are half the edge lengths.
/// for (vertex, at) in field.mesh().vertices().iter().enumerate() {
///     let by_edges = rates.iter().zip(lengths);
///     let parts = by_edges.map(|(by_edge, length)| by_edge.vertices[vertex] * length);
///     assert_eq!(*at, parts.sum::<Vector3<f64>>());
/// }
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// Returns the errors of [`cuboid`].
pub fn cuboid_rates(lengths: [f64; 3]) -> Result<[ShapeRates; 3], MeshError> {
    let half = half_edges(variables(checked_edges(lengths)?));
    filled(half, Vector3::from_element(lift(0.0))).rates()
}

/// Creates a box with the given edge lengths (m) whose field is the distance to the surface divided by the largest
/// distance. The largest distance is half the shortest edge.
///
/// The points farthest from the surface form a rectangle, a segment (if two edges are shortest) or a point (in a cube).
/// Each face is joined to its part of this core.
///
/// # Errors
/// Returns an error if a length is not positive and finite, or if the box is so slender (a rod of 1 : 10⁶) that
/// tetrahedra are flat to within rounding error.
pub fn distance_cuboid(lengths: [f64; 3]) -> Result<PressureField, MeshError> {
    let half = half_edges(checked_edges(lengths)?);
    distance_filled(half).field()
}

/// Computes the rates of change of a [`distance_cuboid`] with respect to each of its three edge lengths (m).
///
/// If two or three edges are shortest, the core gains a dimension as soon as one of them changes. The vertices of the
/// box cannot represent this change, so [`ShapeRates::ambiguous`] lists the vertices of the core. Their rates keep the
/// core's dimension: a point remains a point. The ends of a segment move by the mean of the rates for the two shortest
/// edges. These rates are exact for changes that keep the shortest edges equal, such as a change of scale. The surface
/// of the box has no ambiguous vertices.
///
/// # Errors
/// Returns the errors of [`distance_cuboid`].
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

/// Fills the box with these half edges (m) around the points farthest from its surface.
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

/// Creates the tetrahedra of a box with the half edges `half` (m), around a core with the half edges `core_half` (m).
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

/// Returns the half edges of the core, with 0 along axes whose tetrahedra would be flat.
///
/// Let d be the depth. The slimmest tetrahedra along the longest core edge 2c₁ have an edge of the surface at the
/// distance d across it. That edge is at least 2d long, so six times their volume is 2c₁·2d·d. Along the next core edge
/// 2c₂, some tetrahedra contain both core edges, and six times their volume is 2c₂·2c₁·d.
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

/// Returns the signs of a corner's coordinates.
fn signs(corner: usize) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| {
        if corner >> (2 - axis) & 1 == 1 {
            1.0
        } else {
            -1.0
        }
    })
}
