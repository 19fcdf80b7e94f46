//! Bodies on a grid, and poses that keep them on the grid. The contact surface often lies in shared faces of tetrahedra.

use super::scenes::{Random, grid};
use hydroelastic::contact::{ContactPair, ContactPolygon};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3, vector};

/// Barycentric coordinates below this value count as zero.
const IN_FACE: f64 = 1e-12;

/// Returns bodies on a grid of eighths, and some other bodies.
pub fn bodies() -> Vec<PressureField> {
    let fields = [
        shapes::cuboid([1.0; 3]),
        shapes::cuboid([1.0, 0.5, 1.5]),
        shapes::distance_cuboid([1.0; 3]),
        shapes::distance_cuboid([1.0, 0.5, 1.5]),
        shapes::icosphere(0.5, 0),
        shapes::icosphere(0.5, 1),
        shapes::cylinder(0.5, 1.0, 4),
        shapes::cylinder(0.5, 1.0, 7),
        grid(&[2, 2, 1], 0.5, |[i, j, _]| i == 0 || j == 0),
        grid(&[2, 2, 2], 0.5, |_| true),
    ];
    fields.map(Result::unwrap).into()
}

/// Returns a pose that maps axes to axes, and the origin to a grid of eighths or along one axis.
pub fn aligned_pose(random: &mut Random) -> Pose {
    let position = Vector3::from_fn(|_, _| (random.below(13) as f64 - 6.0) / 8.0);
    match random.below(3) {
        0 => Pose::from_translation(vector![position.x, 0.0, 0.0]),
        1 => Pose::from_translation(position),
        _ => {
            let first = random.below(3);
            let signs = [0, 1].map(|_| [1.0, -1.0][random.below(2)]);
            let signs = [signs[0], signs[1], signs[0] * signs[1]];
            let axes = [0, 1, 2].map(|k| Vector3::ith((first + k) % 3, signs[k]));
            let rotation = Matrix3::from_columns(&axes);
            Pose::new(rotation, position).unwrap()
        }
    }
}

/// Returns the contact polygons that lie in a face of one of their tetrahedra.
pub fn polygons_in_faces(pair: &ContactPair) -> Vec<ContactPolygon> {
    let mut polygons = pair.surface().polygons;
    polygons.retain(|polygon| is_in_face(pair, polygon));
    polygons
}

fn is_in_face(pair: &ContactPair, polygon: &ContactPolygon) -> bool {
    let bodies = [pair.a(), &pair.b().body().unwrap()];
    bodies.iter().zip(polygon.tets).any(|(body, tet)| {
        let inverse = body.pose().inverse();
        let faces = &body.shape().field().tets()[tet].barycentric;
        let corners = polygon.outline.corners().iter();
        let corners: Vec<_> = corners.map(|c| inverse.transformed_point(c)).collect();
        let holds = |corner: &Vector3<f64>, face: usize| faces[face].at(corner).abs() <= IN_FACE;
        (0..4).any(|face| corners.iter().all(|corner| holds(corner, face)))
    })
}
