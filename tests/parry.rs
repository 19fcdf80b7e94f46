//! Shapes and poses of parry.

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::io::{ShapeError, field_from_polyhedron, field_from_trimesh, surface_from_shape};
use hydroelastic::mesh::{MeshError, PressureField, SurfaceError, shapes};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Vector3, vector};
use parry3d_f64::math::{Pose3, Vec3};
use parry3d_f64::shape::{
    Ball, Capsule, Cone, ConvexPolyhedron, Cuboid, Cylinder, Segment, Shape as ParryShape, TriMesh,
};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

/// Relative rounding error of sums over some thousand tetrahedra.
const SUM_ROUND_OFF: f64 = 1e-12;

/// Difference, relative to the largest component, of wrenches of equal fields whose centers differ by rounding.
const SAME_WRENCH: f64 = 1e-12;

/// Rounding error of converting a rotation matrix to a quaternion and back.
const ROTATION: f64 = 2e-15;

fn assert_relative(actual: f64, expected: f64, tolerance: f64) {
    let error = (actual - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{actual:e} is not {expected:e}"
    );
}

fn to_parry(point: &Vector3<f64>) -> Vec3 {
    Vec3::new(point.x, point.y, point.z)
}

fn from_parry(point: Vec3) -> Vector3<f64> {
    vector![point.x, point.y, point.z]
}

fn trimesh((vertices, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> TriMesh {
    TriMesh::new(vertices, triangles).unwrap()
}

const EDGES: [f64; 3] = [0.3, 0.2, 0.1];

/// Returns parry's triangulation of a box with these edges.
fn parry_box() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let [x, y, z] = EDGES;
    Cuboid::new(Vec3::new(x, y, z) / 2.0).to_trimesh()
}

/// Returns force and torque on the block when a ball is pressed into it from above.
fn wrench_on(block: &PressureField, turn: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let ball = Shape::new(shapes::icosphere(0.1, 2).unwrap());
    let above = Pose::from_translation(vector![0.02, 0.01, 0.13]);
    let ball = ContactBody::new(&ball, above, 1e5).unwrap();
    let block = Shape::new(block.clone());
    let turned = Pose::from_rotation_vector(turn, Vector3::zeros());
    let block = ContactBody::new(&block, turned, 1e6).unwrap();
    let wrench = ContactPair::new(ball, block).wrench().on_a;
    [wrench.force, wrench.torque]
}

#[test]
fn a_box_of_parry_is_pressed_as_our_box() {
    let (vertices, triangles) = parry_box();
    let points: Vec<_> = vertices.iter().copied().map(from_parry).collect();
    let polyhedron = ConvexPolyhedron::from_convex_mesh(vertices.clone(), &triangles).unwrap();
    let of_hull = ConvexPolyhedron::from_convex_hull(&vertices).unwrap();
    let expected = shapes::cuboid(EDGES).unwrap();
    for field in [
        field_from_trimesh(&trimesh((vertices, triangles))).unwrap(),
        field_from_polyhedron(&polyhedron).unwrap(),
        field_from_polyhedron(&of_hull).unwrap(),
        shapes::convex_hull(&points).unwrap(),
    ] {
        assert_eq!(field.mesh().tet_count(), 12);
        for turn in [
            vector![0.0, 0.0, 0.0],
            vector![0.3, -0.2, 0.5],
            vector![1.0, 1.0, -2.0],
        ] {
            let [actual, expected] = [&field, &expected].map(|block| wrench_on(block, &turn));
            let largest = expected[0].amax();
            assert!(largest > 1.0, "no contact at {turn}");
            for (actual, expected) in actual.iter().zip(&expected) {
                assert!((actual - expected).amax() <= SAME_WRENCH * largest);
            }
        }
    }
}

fn assert_same_mass(actual: &MassProperties, expected: &MassProperties) {
    assert_relative(actual.mass, expected.mass, SUM_ROUND_OFF);
    let size = expected.inertia.amax() / expected.mass;
    let apart = (actual.center_of_mass - expected.center_of_mass).amax();
    assert!(apart <= SUM_ROUND_OFF * size.sqrt(), "{apart:e}");
    let inertia = (actual.inertia - expected.inertia).amax();
    assert!(inertia <= SUM_ROUND_OFF * expected.inertia.amax());
}

proptest! {
    #[test]
    fn hulls_have_the_mass_that_parry_gives_them(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0), 8..60),
    ) {
        let points: Vec<Vector3<f64>> = points.into_iter().map(Vector3::from).collect();
        let field = shapes::convex_hull(&points).unwrap();
        let mass = field.mesh().mass_properties(1000.0).unwrap();
        let parry_points: Vec<Vec3> = points.iter().map(to_parry).collect();
        let (vertices, triangles) = parry3d_f64::transformation::convex_hull(&parry_points);
        let properties = parry3d_f64::mass_properties::MassProperties::from_convex_polyhedron(
            1000.0, &vertices, &triangles,
        );
        let columns = properties.reconstruct_inertia_matrix().to_cols_array();
        let expected = MassProperties {
            mass: properties.mass(),
            center_of_mass: from_parry(properties.local_com),
            inertia: Matrix3::from_column_slice(&columns),
        };
        assert_same_mass(&mass, &expected);
    }
}

#[test]
fn cylinders_and_cones_of_parry_have_their_prisms_and_pyramids_volumes() {
    let segments = 24;
    let base = 0.5 * f64::from(segments) * 0.1_f64.powi(2) * (TAU / f64::from(segments)).sin();
    let cylinder = trimesh(Cylinder::new(0.2, 0.1).to_trimesh(segments));
    let field = field_from_trimesh(&cylinder).unwrap();
    assert_relative(field.mesh().volume(), base * 0.4, SUM_ROUND_OFF);
    let cone = trimesh(Cone::new(0.2, 0.1).to_trimesh(segments));
    let field = field_from_trimesh(&cone).unwrap();
    assert_relative(field.mesh().volume(), base * 0.4 / 3.0, SUM_ROUND_OFF);
    // The center of mass is at a quarter of the height above the base, which parry places at y = −0.2.
    let center = field.mesh().mass_properties(1.0).unwrap().center_of_mass;
    assert!((center - vector![0.0, -0.1, 0.0]).amax() <= SUM_ROUND_OFF);
}

#[test]
fn a_soup_of_triangles_is_welded() {
    let (vertices, triangles) = parry_box();
    let soup = triangles.iter().flatten().map(|&v| vertices[v as usize]);
    let separate = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let field = field_from_trimesh(&trimesh((soup.collect(), separate.collect()))).unwrap();
    assert_eq!(field.mesh().vertex_count(), 9);
    assert_relative(field.mesh().volume(), EDGES.iter().product(), SUM_ROUND_OFF);
}

/// Returns the number of open edges.
fn open_edges(error: &ShapeError) -> Option<usize> {
    match error {
        ShapeError::Surface(SurfaceError::NotClosed(faults)) => Some(faults.open?.count),
        _ => None,
    }
}

#[test]
fn an_open_mesh_is_refused() {
    let (vertices, mut triangles) = parry_box();
    triangles.pop();
    let error = field_from_trimesh(&trimesh((vertices, triangles))).unwrap_err();
    assert_eq!(open_edges(&error), Some(3));
}

#[test]
fn a_mesh_that_is_not_star_shaped_is_refused() {
    // The letter U, 3 by 3 and 1 deep. Its center of volume lies between the arms.
    let outline = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 3.0],
        [2.0, 3.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    let front = [
        [0, 1, 4],
        [0, 4, 5],
        [1, 2, 4],
        [2, 3, 4],
        [0, 5, 7],
        [5, 6, 7],
    ];
    let level = |z: f64| outline.map(|[x, y]| Vec3::new(x, y, z));
    let sides = (0..8).flat_map(|k| {
        let next = (k + 1) % 8;
        [[k, next, 8 + next], [k, 8 + next, 8 + k]]
    });
    let back = front.map(|[a, b, c]| [a, c, b]);
    let triangles = back.into_iter().chain(front.map(|t| t.map(|v| 8 + v)));
    let mesh = trimesh((
        [level(0.0), level(1.0)].concat(),
        triangles.chain(sides).collect(),
    ));
    let error = field_from_trimesh(&mesh).unwrap_err();
    let ShapeError::Field(MeshError::HiddenTriangle { triangle, distance }) = error else {
        panic!("{error}")
    };
    // The inner sides of the arms are 0.5 m from the center, which is on their outer side. The floor between the arms is 0.357… m below the
    // center: 9.5/7 − 1.
    let normal = mesh.triangle(u32::try_from(triangle).unwrap()).normal();
    let expected = if normal.unwrap().y > 0.5 {
        9.5 / 7.0 - 1.0
    } else {
        0.5
    };
    assert_relative(distance, expected, SUM_ROUND_OFF);
}

// Poses.

fn poses() -> impl Strategy<Value = Pose> {
    let vectors = || prop::array::uniform3(-3.0..3.0).prop_map(Vector3::from);
    (vectors(), vectors()).prop_map(|(turn, origin)| Pose::from_rotation_vector(&turn, origin))
}

proptest! {
    #[test]
    fn poses_of_both_libraries_map_points_alike(
        pose_ab in poses(),
        p_bq in prop::array::uniform3(-1.0..1.0),
    ) {
        let p_bq = Vector3::from(p_bq);
        let p_aq = Pose3::from(pose_ab).transform_point(to_parry(&p_bq));
        let expected = pose_ab.transformed_point(&p_bq);
        prop_assert!((from_parry(p_aq) - expected).amax() <= 4.0 * ROTATION);
        let back = Pose::from(Pose3::from(pose_ab));
        prop_assert!((back.rotation() - pose_ab.rotation()).amax() <= ROTATION);
        prop_assert_eq!(back.translation(), pose_ab.translation());
    }
}

/// Returns the volume (m³) of a parry shape as a polyhedron with `segments` segments per circle.
fn volume_of(shape: &dyn ParryShape, segments: u32) -> f64 {
    let surface = surface_from_shape(shape, segments);
    surface.unwrap_or_else(|error| panic!("{error}")).volume()
}

#[test]
fn shapes_become_surfaces_that_tend_to_their_volumes() {
    let (radius, half) = (0.3_f64, 0.5);
    let ball = 4.0 / 3.0 * PI * radius.powi(3);
    let cylinder = PI * radius.powi(2) * 2.0 * half;
    let shapes: [(&dyn ParryShape, f64); 4] = [
        (&Ball::new(radius), ball),
        (&Capsule::new_y(half, radius), ball + cylinder),
        (&Cylinder::new(half, radius), cylinder),
        (&Cone::new(half, radius), cylinder / 3.0),
    ];
    for (shape, expected) in shapes {
        let [coarse, fine] = [32, 64].map(|segments| 1.0 - volume_of(shape, segments) / expected);
        // The polyhedron is inscribed, and its error is of second order.
        assert!(0.0 < fine && fine < 0.01, "{fine}");
        assert!((fine / coarse - 0.25).abs() < 0.01, "{fine} {coarse}");
        assert!(volume_of(shape, 4) > 0.0);
        assert!(volume_of(shape, 5) > 0.0);
    }
}

#[test]
fn polyhedra_become_surfaces_of_the_same_volume() {
    let [x, y, z] = EDGES;
    let cuboid = Cuboid::new(Vec3::new(x, y, z) / 2.0);
    let mesh = trimesh(parry_box());
    let (points, _) = parry_box();
    let hull = ConvexPolyhedron::from_convex_hull(&points).unwrap();
    for shape in [&cuboid as &dyn ParryShape, &mesh, &hull] {
        assert_relative(volume_of(shape, 4), x * y * z, SUM_ROUND_OFF);
    }
}

#[test]
fn shapes_without_a_surface_are_refused() {
    let segment = Segment::new(Vec3::ZERO, Vec3::X);
    let refused = surface_from_shape(&segment, 8).unwrap_err();
    assert!(
        matches!(refused, ShapeError::Unsupported { .. }),
        "{refused}"
    );
    for segments in [3, 4097] {
        let refused = surface_from_shape(&Ball::new(1.0), segments).unwrap_err();
        assert!(matches!(refused, ShapeError::Segments { .. }), "{refused}");
    }
    let refused = surface_from_shape(&Ball::new(f64::NAN), 8).unwrap_err();
    let ShapeError::Surface(SurfaceError::NonFiniteCoordinate { .. }) = refused else {
        panic!("{refused}");
    };
    let (vertices, mut triangles) = parry_box();
    triangles.pop();
    let refused = surface_from_shape(&trimesh((vertices, triangles)), 8).unwrap_err();
    assert_eq!(open_edges(&refused), Some(3));
}
