use super::checked_lengths;
use super::cored::{CoredSurface, core_size};
use crate::mesh::{MeshError, PressureField};
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
    filled(lengths, Vector3::zeros())
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
    let half = Vector3::from(lengths) * 0.5;
    filled(lengths, half.add_scalar(-half.min()))
}

/// The box around a core with the given half edges (m).
fn filled(lengths: [f64; 3], core_half: Vector3<f64>) -> Result<PressureField, MeshError> {
    let lengths = checked_lengths(lengths.map(|length| ("edge length", length)))?;
    let half = Vector3::from(lengths) * 0.5;
    let corners = |half: Vector3<f64>| (0..8).map(move |c| signs(c).component_mul(&half)).collect();
    CoredSurface {
        vertices: corners(half),
        triangles: TRIANGLES.to_vec(),
        core_points: corners(solid_core(core_half, half)),
    }
    .field()
}

/// The half edges of the core without those along which tetrahedra would be flat.
///
/// The slimmest tetrahedra along the longest core edge 2c₁ have an edge of the surface, at least
/// twice the depth d, at the distance d across it: six times their volume is 2c₁·2d·d. Along the
/// next one, 2c₂, there are some with both core edges: 2c₂·2c₁·d.
fn solid_core(core_half: Vector3<f64>, half: Vector3<f64>) -> Vector3<f64> {
    let (depth, longest) = (half.min(), 2.0 * half.max());
    let (first, last) = (core_half.imax(), core_half.imin());
    let mut solid = Vector3::zeros();
    solid[first] = core_size(core_half[first], 4.0 * depth * depth, longest);
    if first != last {
        let second = 3 - first - last;
        solid[second] = core_size(core_half[second], 4.0 * solid[first] * depth, longest);
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
