//! Hostile pairs: contact geometry at and near every degenerate position, the same in every run.
//!
//! `shapes` creates the bodies, and this file pairs them. `claims` has the claims for every pair, `measures` the bounds of round-off, and
//! `kinks` the kinks of the model.

pub mod claims;
pub mod kinks;
pub mod measures;
pub mod partners;
pub mod shapes;

use super::scenes::{Random, pair};
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use shapes::Pool;
use std::f64::consts::{PI, TAU};

/// The reason why a pair is hostile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// None: the reference for the other families.
    Generic,
    /// A face of one body lies in the plane of a face of the other.
    Coplanar,
    /// A face of one body nearly lies in the plane of a face of the other, with a tilt and an offset of 1e-16 to 1e-4.
    NearlyCoplanar,
    /// The bodies share a vertex, an edge or a face, exactly or with an offset as small.
    Shared,
    /// Both bodies have the same mesh and pose, exactly or with an offset as small.
    Identical,
    /// Tetrahedra are as flat as a mesh allows.
    Sliver,
    /// One body is inside the other.
    Nested,
    /// Bodies have sizes of 1e-6 to 1e6 m.
    Scaled,
    /// Bodies are up to 1e6 m from the world's origin.
    Offset,
    /// Moduli are 1 to 1e12 Pa, equal or different.
    Moduli,
    /// All of these.
    Combined,
}

impl Family {
    pub const ALL: [Self; 11] = [
        Self::Generic,
        Self::Coplanar,
        Self::NearlyCoplanar,
        Self::Shared,
        Self::Identical,
        Self::Sliver,
        Self::Nested,
        Self::Scaled,
        Self::Offset,
        Self::Moduli,
        Self::Combined,
    ];
}

/// Sizes of the shapes (m).
const SCALES: [f64; 6] = [1e-6, 1e-3, 0.25, 1.0, 1e3, 1e6];

/// Index of one meter in [`SCALES`].
const UNIT: usize = 3;

/// Shapes of all sizes, from which pairs are made.
pub struct Hostile(Vec<Pool>);

impl Hostile {
    /// Creates the shapes with a number.
    pub fn new(number: u64) -> Self {
        let mut random = Random::numbered(number);
        Self(SCALES.map(|size| Pool::of(size, &mut random)).into())
    }

    /// Yields all shapes.
    pub fn shapes(&self) -> impl Iterator<Item = &Shape> {
        self.0.iter().flat_map(Pool::shapes)
    }

    /// Returns the pair with a number.
    pub fn pair(&self, family: Family, number: u64) -> ContactPair<'_> {
        let random = &mut Random::numbered(number);
        let [size_a, size_b] = sizes(family, random);
        let slivers = match family {
            Family::Sliver => [true, random.below(2) == 0],
            Family::Combined => [random.below(4) == 0, random.below(4) == 0],
            _ => [false; 2],
        };
        let a = self.0[size_a].any(slivers[0], random);
        let is_same = family == Family::Identical
            || (family == Family::Combined && size_a == size_b && random.below(4) == 0);
        let b = if is_same {
            a
        } else {
            self.0[size_b].any(slivers[1], random)
        };
        let pose_ab = relative_pose(family, [a, b], is_same, random);
        let pose_wa = pose_of_a(family, SCALES[size_a], random);
        let [modulus_a, modulus_b] = moduli(family, random);
        let (a, b) = ((a, pose_wa, modulus_a), (b, pose_wa * pose_ab, modulus_b));
        match random.below(2) {
            0 => pair(a, b),
            _ => pair(b, a),
        }
    }
}

/// Returns the indices of both bodies' sizes in [`SCALES`].
fn sizes(family: Family, random: &mut Random) -> [usize; 2] {
    let any = random.below(SCALES.len());
    match family {
        Family::Scaled => [any; 2],
        Family::Combined => [any, [any, random.below(SCALES.len())][random.below(2)]],
        Family::Nested => [UNIT, random.below(UNIT)],
        _ => [UNIT; 2],
    }
}

fn moduli(family: Family, random: &mut Random) -> [f64; 2] {
    let wild = match family {
        Family::Moduli => true,
        Family::Combined => random.below(2) == 0,
        _ => false,
    };
    let largest = if wild { 12.0 } else { 1.0 };
    let [a, b] = [0, 1].map(|_| 10_f64.powf(random.between(0.0, largest)));
    [a, [a, b][random.below(2)]]
}

fn pose_of_a(family: Family, size: f64, random: &mut Random) -> Pose {
    let away = match family {
        Family::Offset => 10_f64.powf(random.between(0.0, 6.0)),
        Family::Combined => [0.0, 10_f64.powf(random.between(0.0, 6.0))][random.below(2)],
        _ => size * [0.0, 1.0][random.below(2)],
    };
    let position = random.direction() * away;
    match random.below(2) {
        0 => Pose::from_translation(position),
        _ => Pose::from_rotation_vector(&random.rotation_vector(), position),
    }
}

/// Returns the pose of B in A's frame.
fn relative_pose(family: Family, shapes: [&Shape; 2], same: bool, random: &mut Random) -> Pose {
    let reach = shapes.map(|shape| shape.field().reach());
    let exact = match family {
        Family::Coplanar | Family::NearlyCoplanar => coplanar(shapes, random),
        Family::Shared => shared(shapes, random),
        Family::Identical => Pose::identity(),
        Family::Nested => nested(reach, random),
        Family::Sliver => match random.below(3) {
            0 => coplanar(shapes, random),
            1 => shared(shapes, random),
            _ => overlapping(reach, random),
        },
        Family::Combined => match random.below(5) {
            0 => coplanar(shapes, random),
            1 => shared(shapes, random),
            2 => nested(reach, random),
            3 if same => Pose::identity(),
            _ => overlapping(reach, random),
        },
        _ => overlapping(reach, random),
    };
    let is_exact = family == Family::Coplanar || random.below(2) == 0;
    if is_exact && family != Family::NearlyCoplanar {
        exact
    } else {
        nudged(exact, reach[0].min(reach[1]), random)
    }
}

/// Perturbs a pose by 1e-16 to 1e-4 of a size (m), in angle and position.
fn nudged(pose: Pose, size: f64, random: &mut Random) -> Pose {
    let [tilt, shift] = [0, 1].map(|_| 10_f64.powf(random.between(-16.0, -4.0)));
    let nudge = Pose::from_rotation_vector(&(random.vector() * tilt), Vector3::zeros());
    let moved = pose * nudge;
    moved.with_translation(moved.translation() + random.vector() * (shift * size))
}

/// Returns a generic pose at which the bodies mostly overlap.
fn overlapping(reach: [f64; 2], random: &mut Random) -> Pose {
    let position = random.direction() * (random.between(0.0, 0.8) * (reach[0] + reach[1]));
    Pose::from_rotation_vector(&random.rotation_vector(), position)
}

/// Returns a pose with the origin of the smaller body deep in the larger body.
fn nested(reach: [f64; 2], random: &mut Random) -> Pose {
    let depth = [0.0, random.between(0.0, 0.4)][random.below(2)];
    let position = random.direction() * (depth * reach[0].max(reach[1]));
    match random.below(2) {
        0 => Pose::from_translation(position),
        _ => Pose::from_rotation_vector(&random.rotation_vector(), position),
    }
}

/// Returns a pose with a surface triangle of one body in the plane of a triangle of the other, from outside or inside, rotated and
/// translated in the plane.
pub fn coplanar(shapes: [&Shape; 2], random: &mut Random) -> Pose {
    let [on_a, on_b] = shapes.map(|shape| triangle_frame(shape, random));
    let size = shapes.map(|shape| shape.field().reach()).map(|r| 0.5 * r);
    let shift = Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0);
    let turn = Vector3::z() * [0.0, PI / 2.0, random.between(0.0, TAU)][random.below(3)];
    let in_plane = Pose::from_rotation_vector(&turn, shift * size[0].min(size[1]));
    on_a * in_plane * facing(random) * on_b.inverse()
}

/// Returns a pose with a shared vertex, edge or face.
pub fn shared(shapes: [&Shape; 2], random: &mut Random) -> Pose {
    let [on_a, on_b] = shapes.map(|shape| triangle_frame(shape, random));
    let about = match random.below(3) {
        0 => random.rotation_vector(),
        1 => Vector3::x() * random.between(0.0, TAU),
        _ => Vector3::zeros(),
    };
    let turn = Pose::from_rotation_vector(&about, Vector3::zeros());
    on_a * turn * facing(random) * on_b.inverse()
}

/// Returns a pose with equal or opposite normals. The opposite normal is half a turn about the edge.
fn facing(random: &mut Random) -> Pose {
    let signs = [Vector3::new(1.0, 1.0, 1.0), Vector3::new(1.0, -1.0, -1.0)][random.below(2)];
    Pose::new(Matrix3::from_diagonal(&signs), Vector3::zeros()).unwrap()
}

/// Returns a frame on a surface triangle: at a vertex, with x along an edge and z along the normal.
pub fn triangle_frame(shape: &Shape, random: &mut Random) -> Pose {
    let mesh = shape.field().mesh();
    let triangles = mesh.surface_triangles();
    let triangle = triangles[random.below(triangles.len())];
    let first = random.below(3);
    let [start, end, opposite] = [0, 1, 2].map(|k| mesh.vertices()[triangle[(first + k) % 3]]);
    let along = (end - start).normalize();
    let across = (opposite - start).normalize();
    let normal = along.cross(&across).normalize();
    // The normal is computed twice, because the first normal of a thin triangle is not exactly orthogonal to the edge.
    let across = normal.cross(&along).normalize();
    let normal = along.cross(&across).normalize();
    let rotation = Matrix3::from_columns(&[along, across, normal]);
    Pose::new(rotation, start).unwrap()
}
