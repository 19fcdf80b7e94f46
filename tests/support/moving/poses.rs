//! Pairs that are flush, aligned, nested or coplanar, or share vertices, exactly or nearly.

use super::Scene;
use super::bodies::Bodies;
use super::motions::set_in_motion;
use crate::support::hostile::{coplanar, shared};
use crate::support::scenes::{Random, pair};
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::geometry::Aabb;
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Relative position of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// No special position: the reference for the other families.
    Generic,
    /// One body on the other, with flush sides or aligned centers.
    Stacked,
    /// One body on the other, rotated about the vertical.
    Turned,
    /// Parallel axes, with origins on a grid of eighths.
    Aligned,
    /// One body inside the other, with parallel axes and coplanar centers or sides.
    Nested,
    /// A surface triangle of one body in the plane of a triangle of the other.
    Coplanar,
    /// A shared vertex, edge or face.
    Shared,
}

impl Family {
    pub const ALL: [Self; 7] = [
        Self::Generic,
        Self::Stacked,
        Self::Turned,
        Self::Aligned,
        Self::Nested,
        Self::Coplanar,
        Self::Shared,
    ];
}

/// Returns the scene with a number, made of these bodies.
pub fn scene(bodies: &Bodies, family: Family, number: u64) -> Scene<'_> {
    let random = &mut Random::numbered(number);
    loop {
        let (pair, missed) = posed_pair(bodies, family, random);
        if let Some(scene) = set_in_motion(&pair, bodies.size, random) {
            return Scene { missed, ..scene };
        }
    }
}

/// Returns the pair and its distance from the special position.
fn posed_pair<'a>(
    bodies: &'a Bodies,
    family: Family,
    random: &mut Random,
) -> (ContactPair<'a>, f64) {
    let a = bodies.any(random);
    let b = if random.below(3) == 0 {
        a
    } else {
        bodies.any(random)
    };
    let exact = relative_pose(bodies.size, family, [a, b], random);
    let (pose_ab, missed) = if random.below(3) == 0 || family == Family::Generic {
        (exact, 0.0)
    } else {
        nudged(exact, bodies.size, random)
    };
    let pose_wa = match random.below(3) {
        0 => Pose::identity(),
        1 => Pose::from_translation(random.vector()),
        _ => Pose::from_rotation_vector(&random.rotation_vector(), random.vector()),
    };
    let [modulus_a, modulus_b] = [0, 1].map(|_| 10_f64.powf(random.between(4.0, 7.0)));
    let modulus_b = [modulus_a, modulus_b, 2.0 * modulus_a][random.below(3)];
    let (a, b) = ((a, pose_wa, modulus_a), (b, pose_wa * pose_ab, modulus_b));
    let pair = match random.below(2) {
        0 => pair(a, b),
        _ => pair(b, a),
    };
    (pair, missed)
}

/// Returns the pose of B in A's frame.
fn relative_pose(size: f64, family: Family, shapes: [&Shape; 2], random: &mut Random) -> Pose {
    match family {
        Family::Generic => Pose::from_rotation_vector(
            &random.rotation_vector(),
            random.direction() * (size * random.between(0.1, 0.8)),
        ),
        Family::Stacked | Family::Turned | Family::Nested => {
            let is_inside = family == Family::Nested;
            let turn = match (family, random.below(2)) {
                (Family::Turned, _) => Pose::from_rotation_vector(
                    &(Vector3::z() * random.between(0.0, TAU)),
                    Vector3::zeros(),
                ),
                (_, 0) => Pose::identity(),
                _ => axes_to_axes(random),
            };
            turn.with_translation(flush(size, shapes, &turn, is_inside, random))
        }
        Family::Aligned => {
            let position = Vector3::from_fn(|_, _| (random.below(13) as f64 - 6.0) / 8.0 * size);
            axes_to_axes(random).with_translation(position)
        }
        Family::Coplanar => coplanar(shapes, random),
        Family::Shared => shared(shapes, random),
    }
}

/// Returns one of the 24 rotations of a cube.
fn axes_to_axes(random: &mut Random) -> Pose {
    let first = random.below(3);
    let signs = [0, 1].map(|_| [1.0, -1.0][random.below(2)]);
    let signs = [signs[0], signs[1], signs[0] * signs[1]];
    let mut axes = [0, 1, 2].map(|k| Vector3::ith((first + k) % 3, signs[k]));
    if random.below(2) == 0 {
        axes.swap(0, 1);
        axes[2] = -axes[2];
    }
    Pose::new(Matrix3::from_columns(&axes), Vector3::zeros()).unwrap()
}

/// Returns B's origin such that its box is on one side of A's box, slightly pressed in. Along the other axes, the boxes are centered, flush
/// on a side, or displaced by a few eighths.
fn flush(
    size: f64,
    shapes: [&Shape; 2],
    turn: &Pose,
    is_inside: bool,
    random: &mut Random,
) -> Vector3<f64> {
    let [a, b] = shapes.map(|shape| shape.field().mesh().vertices());
    let turned: Vec<_> = b.iter().map(|v| turn.transformed_point(v)).collect();
    let [a, b] = [Aabb::around(a), Aabb::around(&turned)];
    let upright = if is_inside { 3 } else { random.below(3) };
    let depth = match random.below(3) {
        0 => size * (1 + random.below(3)) as f64 / 8.0,
        _ => size * 10_f64.powf(random.between(-3.0, -0.5)),
    };
    Vector3::from_fn(|axis, _| {
        if axis == upright {
            return [
                a.upper[axis] - b.lower[axis] - depth,
                a.lower[axis] - b.upper[axis] + depth,
            ][random.below(2)];
        }
        match random.below(4) {
            0 => a.upper[axis] - b.upper[axis],
            1 => a.lower[axis] - b.lower[axis],
            2 => 0.5 * (a.lower[axis] + a.upper[axis] - b.lower[axis] - b.upper[axis]),
            _ => (random.below(5) as f64 - 2.0) / 8.0 * size,
        }
    })
}

/// Perturbs a pose by 1e-16 to 1e-6, in angle, in position (relative to the size), or both. Returns the pose and the perturbation.
fn nudged(pose: Pose, size: f64, random: &mut Random) -> (Pose, f64) {
    let [mut tilt, mut shift] = [0, 1].map(|_| 10_f64.powf(random.between(-16.0, -6.0)));
    match random.below(4) {
        0 => tilt = 0.0,
        1 => shift = 0.0,
        _ => {}
    }
    let nudge = Pose::from_rotation_vector(&(random.vector() * tilt), Vector3::zeros());
    let moved = pose * nudge;
    let moved = moved.with_translation(moved.translation() + random.vector() * (shift * size));
    (moved, tilt.max(shift))
}
