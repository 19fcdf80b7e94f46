//! Positions and motions at which a one-sided derivative is meant.

use super::Scene;
use hydroelastic::contact::{ContactBody, ContactPair};
use hydroelastic::geometry::Aabb;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;

/// There is no pressure where 1 − d·v_n is no more than this.
const PARTED: f64 = 1e-9;

/// Faces are in one plane that are tilted and apart by no more, relative to the size: positions are missed by up to 1e-6.
const IN_PLANE: f64 = 3e-6;

/// Whether a polygon has no pressure all over, just so.
pub fn is_parted(scene: &Scene) -> bool {
    let bodies = [scene.pair.a(), &scene.pair.b().body().unwrap()];
    let velocity = |of: usize, at: &Vector3<f64>| {
        let twist = &scene.twists[of];
        let lever = at - bodies[of].pose().translation();
        twist.linear + twist.angular.cross(&lever)
    };
    scene.pair.surface().polygons.iter().any(|polygon| {
        polygon.outline.corners().iter().all(|corner| {
            let parting = (velocity(0, corner) - velocity(1, corner)).dot(&polygon.normal);
            (1.0 - scene.dissipation * parting).abs() <= PARTED
        })
    })
}

/// Whether surface triangles of both bodies lie in one plane, the bodies on either side of it.
pub fn are_faces_touching(pair: &ContactPair) -> bool {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let own = triangles(pair.a(), &Pose::identity());
    let other = triangles(&pair.b().body().unwrap(), &pose_ab);
    let size = pair
        .a()
        .shape()
        .field()
        .reach()
        .min(pair.b().shape().unwrap().field().reach());
    own.iter().any(|a| {
        let normal = normal_of(a);
        let around = Aabb::around(a).inflated(IN_PLANE * size);
        other.iter().any(|b| {
            let tilt = (normal_of(b) + normal).norm();
            let apart = normal.dot(&(b[0] - a[0])).abs();
            tilt <= IN_PLANE && apart <= IN_PLANE * size && Aabb::around(b).overlaps(&around)
        })
    })
}

fn triangles(body: &ContactBody, pose: &Pose) -> Vec<[Vector3<f64>; 3]> {
    let mesh = body.shape().field().mesh();
    let place = |vertex: usize| pose.transformed_point(&mesh.vertices()[vertex]);
    mesh.surface_triangles()
        .iter()
        .map(|triangle| triangle.map(place))
        .collect()
}

fn normal_of([a, b, c]: &[Vector3<f64>; 3]) -> Vector3<f64> {
    (b - a).cross(&(c - a)).normalize()
}
