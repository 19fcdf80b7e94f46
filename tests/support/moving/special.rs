//! Positions and motions at which a one-sided derivative is intended.

use super::Scene;
use crate::support::hostile::measures::Measures;
use hydroelastic::contact::{ContactPair, HalfSpace};
use hydroelastic::geometry::Aabb;
use hydroelastic::mesh::TetMesh;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;

/// Value of 1 − d·v_n at or below which there is no pressure.
const PARTED: f64 = 1e-9;

/// Largest angle and distance, relative to the size, at which faces count as coplanar. Positions have offsets of up to 1e-6.
const IN_PLANE: f64 = 3e-6;

/// Returns the largest depth of the contact surface below the plane of a compliant layer, relative to the size. In a stiff layer the depth
/// is tiny, and positions that are special for the plane have an offset of this depth. Returns 0 for other partners.
pub fn depth_in_layer(pair: &ContactPair) -> f64 {
    let layer = pair.b().half_space_shape().and_then(HalfSpace::thickness);
    let depth = |thickness: f64| {
        let measures = Measures::of(pair);
        let slope = pair.b().modulus().unwrap() / thickness;
        measures.pressure / slope / measures.size
    };
    layer.map_or(0.0, depth)
}

/// Returns whether a polygon has just zero pressure everywhere.
pub fn is_parted(scene: &Scene) -> bool {
    let poses = [scene.pair.a().pose(), scene.pair.b().pose()];
    let velocity = |of: usize, at: &Vector3<f64>| {
        let twist = &scene.twists[of];
        let lever = at - poses[of].translation();
        twist.linear + twist.angular.cross(&lever)
    };
    scene.pair.surface().polygons.iter().any(|polygon| {
        polygon.outline.corners().iter().all(|corner| {
            let parting = (velocity(0, corner) - velocity(1, corner)).dot(&polygon.normal);
            (1.0 - scene.dissipation * parting).abs() <= PARTED
        })
    })
}

/// Returns whether surface triangles of both bodies, or one of A and the plane of a half-space, are coplanar with the bodies on opposite
/// sides.
pub fn are_faces_touching(pair: &ContactPair) -> bool {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let triangles_a = triangles(pair.a().shape().field().mesh(), &Pose::identity());
    let size = Measures::of(pair).size;
    let is_in_plane = |a: &[Vector3<f64>; 3], outward: &Vector3<f64>, point: &Vector3<f64>| {
        let normal = normal_of(a);
        let apart = normal.dot(&(a[0] - point)).abs();
        (outward + normal).norm() <= IN_PLANE && apart <= IN_PLANE * size
    };
    let triangles_b = match (pair.b().shape(), pair.b().rigid_shape()) {
        (Some(shape), _) => triangles(shape.field().mesh(), &pose_ab),
        (_, Some(rigid)) => (0..rigid.surface().triangles().len())
            .map(|triangle| rigid.surface().corners(triangle))
            .map(|corners| corners.map(|corner| pose_ab.transformed_point(&corner)))
            .collect(),
        _ => {
            let outward = pose_ab.rotation().column(2).into_owned();
            let on_plane = pose_ab.translation();
            return triangles_a
                .iter()
                .any(|a| is_in_plane(a, &outward, on_plane));
        }
    };
    triangles_a.iter().any(|a| {
        let around = Aabb::around(a).inflated(IN_PLANE * size);
        triangles_b
            .iter()
            .any(|b| is_in_plane(a, &normal_of(b), &b[0]) && Aabb::around(b).overlaps(&around))
    })
}

fn triangles(mesh: &TetMesh, pose: &Pose) -> Vec<[Vector3<f64>; 3]> {
    let posed_vertex = |vertex: usize| pose.transformed_point(&mesh.vertices()[vertex]);
    mesh.surface_triangles()
        .iter()
        .map(|triangle| triangle.map(posed_vertex))
        .collect()
}

fn normal_of([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)).normalize()
}
