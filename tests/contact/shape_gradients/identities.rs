//! Identities without differences: rigid motions, scaling and pressure changes are also changes of shape.

use super::{for_pairs, motion, row, vertices};
use crate::support::octahedra::octahedron;
use crate::support::scenes::{Random, grid, pair};
use hydroelastic::contact::{
    BodyError, ContactBody, ContactPair, LinearizedContact, Partner, RigidShape, Shape,
    ShapeGradient, SurfaceLaw,
};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

/// Rounding error of sums over polygons and vertices, relative to the largest entry.
const SAME: f64 = 1e-12;

/// Visits the pairs of [`for_pairs`] and pairs with coincident faces: boxes with flush sides, layered grids with inner faces or edges of
/// both in the contact surface, and an octahedron with inner faces there. Of polygons on either side of these faces, one half counts.
fn for_pairs_and_flush_ones(
    count: usize,
    seed: u8,
    mut check: impl FnMut(&ContactPair, &mut Random),
) {
    for_pairs(count, seed, &mut check);
    let cuboid = |edges| Shape::new(shapes::cuboid(edges).unwrap());
    let (a, b) = (cuboid([1.0; 3]), cuboid([1.0, 1.2, 0.8]));
    let mut random = Random::new(seed);
    for shift in [[0.0, 0.03, 0.85], [0.07, 0.1, 0.85], [0.04, 0.03, 0.85]] {
        let (a, b) = (
            (&a, Pose::from_translation(shift.into()), 2e4),
            (&b, Pose::identity(), 1e4),
        );
        check(&pair(a, b), &mut random);
    }
    let layers = Shape::new(grid(&[4, 4, 4], 0.25, |_| true).unwrap());
    for shift in [[0.03, 0.02, 0.5], [0.03, 0.02, 0.25], [0.125, 0.0, 0.5]] {
        let (a, b) = (
            (&layers, Pose::from_translation(shift.into()), 2e4),
            (&layers, Pose::identity(), 2e4),
        );
        check(&pair(a, b), &mut random);
    }
    let octahedron = octahedron(0);
    let turned = Pose::from_rotation_vector(&Vector3::new(0.0, 0.0, 0.3), Vector3::zeros());
    let halfway = ContactBody::new(&octahedron, turned, 2e4).unwrap();
    let plane = Partner::rigid_half_space(Pose::identity()).unwrap();
    check(&ContactPair::new(halfway, plane), &mut random);
    let block = TriangleSurface::around(shapes::cuboid([3.0, 3.2, 2.0]).unwrap().mesh());
    let block = RigidShape::new(block.unwrap());
    let below = Pose::from_translation(Vector3::new(0.07, 0.03, -1.0));
    let block = Partner::rigid(&block, below).unwrap();
    check(&ContactPair::new(halfway, block), &mut random);
}

/// Asserts that an error is at most round-off and not NaN, and keeps the largest error.
fn note(worst: &mut f64, error: f64) {
    assert!(error <= SAME, "{error:e}");
    *worst = worst.max(error);
}

/// Returns derivatives with respect to the shapes, of contact with a law or, without a law, at rest.
fn gradients(
    pair: &ContactPair,
    law: Option<&SurfaceLaw>,
    twists: [Twist; 2],
    rows: &SVector<f64, 12>,
) -> [ShapeGradient; 2] {
    match law {
        Some(law) => pair.moving(*law, twists).shape_gradients(rows),
        None => pair.shape_gradients(rows),
    }
}

/// Returns the law of elastic contact.
fn elastic() -> SurfaceLaw {
    SurfaceLaw::new(0.0, 0.0, 1.0).unwrap()
}

/// Returns the velocities of points of a body, in the body's frame, under a rotation about or a translation along an axis of the world.
fn rigid_motion(pose: &Pose, points: &[Vector3<f64>], column: usize) -> Vec<Vector3<f64>> {
    let unit = Vector6::from_fn(|i, _| if i == column { 1.0 } else { 0.0 });
    let twist = Twist::from_vector(&unit);
    let in_body = pose.rotation().transpose();
    let velocity = |point: &Vector3<f64>| {
        let arm = pose.rotation() * point;
        in_body * (twist.linear + twist.angular.cross(&arm))
    };
    points.iter().map(velocity).collect()
}

/// Returns the derivative of the wrench on one body with respect to a rigid motion of the vertices of the other.
fn by_motion_of_vertices(
    pair: &ContactPair,
    (law, twists): (Option<&SurfaceLaw>, [Twist; 2]),
    moved: usize,
) -> SMatrix<f64, 6, 6> {
    let pose = [*pair.a().pose(), *pair.b().pose()][moved];
    let points = vertices(pair)[moved];
    SMatrix::from_fn(|on_other, column| {
        let rows = row(6 * (1 - moved) + on_other);
        let gradients = gradients(pair, law, twists, &rows);
        let velocities = rigid_motion(&pose, points, column);
        gradients[moved].along(&velocities.into()).unwrap()
    })
}

#[test]
fn moving_all_vertices_moves_the_body() {
    let mut worst = 0.0_f64;
    for_pairs_and_flush_ones(60, 71, |pair, random| {
        let (law, mut twists) = motion(random);
        for law in [Some(law), Some(elastic()), None] {
            for moved in 0..2 {
                if vertices(pair)[moved].is_empty() {
                    continue;
                }
                // Otherwise the velocity of a point would change as the body's origin moves away from the point.
                twists[moved] = Twist::zero();
                let actual = by_motion_of_vertices(pair, (law.as_ref(), twists), moved);
                let LinearizedContact { by_poses, .. } = pair
                    .moving(law.unwrap_or_else(elastic), twists)
                    .linearized();
                let expected = by_poses.fixed_view::<6, 6>(6 * (1 - moved), 6 * moved);
                note(&mut worst, (actual - expected).amax() / expected.amax());
            }
        }
    });
    println!("worst: {worst:.1e}");
}

/// If the size doubles at the same pressures and velocities, forces grow by a factor of four, and torques by a factor of eight.
#[test]
fn forces_grow_with_the_square_of_the_size() {
    let mut worst = 0.0_f64;
    for_pairs(60, 72, |pair, random| {
        if vertices(pair)[1].is_empty() {
            return;
        }
        let (law, [mut twist_a, _]) = motion(random);
        twist_a.angular = Vector3::zeros();
        let twists = [twist_a, Twist::zero()];
        for law in [law, elastic()] {
            let wrench = pair.moving(law, twists).wrench().on_a;
            let shift = pair.b().pose().translation() - pair.a().pose().translation();
            let from_b = pair.b().pose().rotation().transpose() * shift;
            let scaled_b: Vec<_> = vertices(pair)[1].iter().map(|x| x + from_b).collect();
            let grown = |of: usize| {
                let [by_a, by_b] = pair.moving(law, twists).shape_gradients(&row(of));
                let along_a = by_a.along(&vertices(pair)[0].to_vec().into()).unwrap();
                along_a + by_b.along(&scaled_b.clone().into()).unwrap()
            };
            let torque = Vector3::from_fn(|i, _| grown(i)) - wrench.torque * 3.0;
            let force = Vector3::from_fn(|i, _| grown(3 + i)) - wrench.force * 2.0;
            note(
                &mut worst,
                torque.amax() / wrench.torque.amax().max(wrench.force.amax()),
            );
            note(&mut worst, force.amax() / wrench.force.amax());
        }
    });
    println!("worst: {worst:.1e}");
}

#[test]
fn growing_all_extents_grows_the_modulus() {
    let mut worst = 0.0_f64;
    for_pairs_and_flush_ones(60, 73, |pair, random| {
        let (law, twists) = motion(random);
        for law in [Some(law), Some(elastic()), None] {
            let LinearizedContact { by_moduli, .. } = pair
                .moving(law.unwrap_or_else(elastic), twists)
                .linearized();
            let moduli = [Some(pair.a().modulus()), pair.b().modulus()];
            let shapes = [Some(pair.a().shape()), pair.b().shape()];
            for body in 0..2 {
                let (Some(modulus), Some(shape)) = (moduli[body], shapes[body]) else {
                    continue;
                };
                let expected = by_moduli.column(body) * modulus;
                let actual = SVector::<f64, 12>::from_fn(|of, _| {
                    let gradients = gradients(pair, law.as_ref(), twists, &row(of));
                    let pairs = gradients[body]
                        .by_extents
                        .iter()
                        .zip(shape.field().extents());
                    pairs.map(|(by_extent, extent)| by_extent * extent).sum()
                });
                note(&mut worst, (actual - expected).amax() / expected.amax());
            }
        }
    });
    println!("worst: {worst:.1e}");
}

#[test]
fn columns_are_those_of_the_products() {
    let mut worst = 0.0_f64;
    for_pairs(40, 74, |pair, random| {
        let (law, twists) = motion(random);
        let all = vertices(pair).map(|vertices| (0..vertices.len()).collect::<Vec<_>>());
        let chosen = [&all[0][..], &all[1][..]];
        let covector = SVector::<f64, 12>::from_fn(|_, _| random.between(-1.0, 1.0));
        let jacobians = pair.moving(law, twists).vertex_jacobians(chosen).unwrap();
        let gradients = pair.moving(law, twists).shape_gradients(&covector);
        for (jacobians, gradient) in jacobians.iter().zip(&gradients) {
            let largest = gradient
                .by_vertices
                .iter()
                .map(Vector3::amax)
                .fold(0.0, f64::max);
            for (jacobian, expected) in jacobians.iter().zip(&gradient.by_vertices) {
                let actual = jacobian.tr_mul(&covector);
                note(&mut worst, (actual - expected).amax() / largest);
            }
        }
        let elastic = pair.vertex_jacobians([&[0], &[]]).unwrap();
        let expected = pair.shape_gradients(&covector)[0].by_vertices[0];
        let error = (elastic[0][0].tr_mul(&covector) - expected).amax();
        assert!(error <= SAME * expected.amax(), "{error:e}");
    });
    println!("worst: {worst:.1e}");
}

#[test]
fn a_vertex_that_is_not_there_is_refused() {
    for_pairs(6, 75, |pair, _| {
        let count = vertices(pair)[1].len();
        let refused = pair.vertex_jacobians([&[0], &[count]]);
        assert_eq!(
            refused.unwrap_err(),
            BodyError::Vertex {
                vertex: count,
                count
            }
        );
    });
}
