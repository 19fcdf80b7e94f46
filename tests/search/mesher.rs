//! Meshes of a mesher, whose fields have many peaks and creases, are traced too. A shape that cannot be traced reports the reason.

use super::following::{Tally, is_all_inside};
use crate::support::scenes::{Random, grid, pair};
use hydroelastic::contact::{ContactPair, NotFollowed, Shape};
use hydroelastic::io::{MeshOptions, read_mesh};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::path::{Path, PathBuf};

const ROUND: [&str; 3] = ["sphere", "cylinder", "torus"];

/// Size (m) of the bodies.
const SIZE: f64 = 0.1;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes_from_mesher")
}

fn mesh(folder: &Path, name: &str) -> TetMesh {
    read_mesh(
        folder.join(name).with_extension("msh"),
        &MeshOptions::default(),
    )
    .unwrap()
    .mesh
}

fn round_shapes(folder: &Path) -> Vec<Shape> {
    let field = |name| PressureField::from_distance(&mesh(folder, name)).unwrap();
    ROUND.map(|name| Shape::new(field(name))).into()
}

/// Returns a shape with random extents inside, so its field rises and falls from vertex to vertex.
fn rough(name: &str, lowest: f64, random: &mut Random) -> Shape {
    let mesh = mesh(&folder(), name).with_inner_vertices().unwrap();
    let extents = (0..mesh.vertex_count()).map(|vertex| {
        let inside = random.between(lowest, 1.0);
        if mesh.is_on_surface(vertex) {
            0.0
        } else {
            inside
        }
    });
    let extents = extents.collect();
    Shape::new(PressureField::new(mesh, extents).unwrap())
}

fn random_pose(apart: f64, random: &mut Random) -> Pose {
    let turn = random.rotation_vector();
    Pose::from_rotation_vector(&turn, random.vector() * apart)
}

/// Returns two bodies at most `apart` apart along each axis, with moduli within a factor of a hundred.
fn pair_within<'a>([a, b]: [&'a Shape; 2], apart: f64, random: &mut Random) -> ContactPair<'a> {
    let modulus = 10_f64.powf(random.between(-1.0, 1.0));
    let at = random_pose(apart, random);
    pair((a, at, modulus), (b, Pose::identity(), 1.0))
}

/// Compares every pair of the round bodies at `poses` poses.
fn round_bodies(shapes: &[Shape], poses: usize) {
    for (first, a) in shapes.iter().enumerate() {
        for (second, b) in shapes.iter().enumerate() {
            let (mut tally, mut random) = (Tally::default(), Random::new(71));
            for _ in 0..poses {
                tally.compare(&pair_within([a, b], 1.3 * SIZE, &mut random));
            }
            tally.assert_told_something(&format!("{} on {}", ROUND[first], ROUND[second]), 80);
        }
    }
}

#[test]
fn round_bodies_at_generic_poses() {
    let shapes = round_shapes(&folder());
    assert!(shapes.iter().all(|shape| shape.followed().is_ok()));
    round_bodies(&shapes, 60);
}

/// Maximum number of pairs examined for each contact polygon of two balls. The number is 1.11 with directions from the known normals,
/// and 1.33 with directions that do not depend on the contact.
const EXAMINED: f64 = 1.2;

#[test]
fn known_normals_prune_the_search_for_components_without_a_rim() {
    let ball = Shape::new(PressureField::from_distance(&mesh(&folder(), "sphere")).unwrap());
    let (mut random, mut examined, mut polygons) = (Random::new(76), 0, 0);
    for _ in 0..60 {
        let work = pair_within([&ball; 2], SIZE, &mut random).work_count();
        examined += work.candidate_pairs;
        polygons += work.polygons;
    }
    let ratio = examined as f64 / polygons as f64;
    println!("{examined} pairs examined for {polygons} polygons: {ratio}");
    assert!(polygons > 10_000 && ratio < EXAMINED, "{ratio}");
}

#[test]
#[ignore = "minutes: 10,000 poses of each two"]
fn round_bodies_at_many_poses() {
    round_bodies(&round_shapes(&folder()), 10_000);
}

/// The meshes have 20,000 tetrahedra and more. `make_round.py` beside the small meshes makes them.
#[test]
#[ignore = "hours; the folder with sphere.msh, cylinder.msh and torus.msh is in HYDROELASTIC_MESHES"]
fn large_round_bodies_at_many_poses() {
    let folder = std::env::var_os("HYDROELASTIC_MESHES").expect("a folder of meshes");
    let poses = std::env::var("HYDROELASTIC_POSES").map_or(10_000, |poses| poses.parse().unwrap());
    let shapes = round_shapes(Path::new(&folder));
    assert!(shapes.iter().all(|shape| shape.followed().is_ok()));
    let (mut random, mut tally) = (Random::new(72), Tally::default());
    for (name, shape) in ROUND.iter().zip(&shapes) {
        for _ in 0..poses {
            tally.compare(&pair_within([shape, shape], 1.3 * SIZE, &mut random));
        }
        tally.assert_told_something(name, 80);
    }
}

#[test]
fn round_bodies_centered_on_one_another() {
    let shapes = round_shapes(&folder());
    let (mut random, mut tally) = (Random::new(73), Tally::default());
    for case in 0..200 {
        let two = [0, 1].map(|_| &shapes[random.below(3)]);
        let apart = [0.0, 1e-6, 1e-3, 0.02][case % 4];
        tally.compare(&pair_within(two, apart, &mut random));
    }
    tally.assert_told_something("centered", 90);
}

#[test]
fn components_without_a_rim_between_rough_fields() {
    rough_fields(120);
}

#[test]
#[ignore = "minutes: fifty times as many poses"]
fn components_without_a_rim_between_rough_fields_at_many_poses() {
    rough_fields(6_000);
}

fn rough_fields(poses: usize) {
    let mut random = Random::new(74);
    let mut shapes: Vec<Shape> = Vec::new();
    for lowest in [0.9, 0.5, 0.05] {
        shapes.extend(ROUND.map(|name| rough(name, lowest, &mut random)));
    }
    shapes.extend(round_shapes(&folder()));
    for small in [
        shapes::icosphere(0.3 * SIZE, 1),
        shapes::cuboid([0.4 * SIZE; 3]),
    ] {
        shapes.push(Shape::new(small.unwrap()));
    }
    let (mut tally, mut without_rim) = (Tally::default(), 0);
    for case in 0..poses {
        let two = [0, 1].map(|_| &shapes[random.below(shapes.len())]);
        let apart = [0.2, 0.7, 1.3][case % 3] * SIZE;
        let pair = pair_within(two, apart, &mut random);
        without_rim += usize::from(is_all_inside(&pair));
        tally.compare(&pair);
    }
    tally.assert_told_something("rough", 80);
    assert!(without_rim > poses / 60, "{without_rim}");
}

#[test]
fn a_body_with_a_cavity() {
    let shell = Shape::new(grid(&[3, 3, 3], 0.5, |cell| cell != [1, 1, 1]).unwrap());
    assert_eq!(shell.followed(), Ok(()));
    let others = [shapes::icosphere(0.45, 1), shapes::cuboid([0.8, 0.5, 0.3])];
    let others = others.map(|field| Shape::new(field.unwrap()));
    let (mut random, mut tally) = (Random::new(75), Tally::default());
    for case in 0..400 {
        let partner = [&others[0], &others[1], &shell][case % 3];
        let at = random_pose(0.5, &mut random);
        let center = Pose::from_translation(vector![0.75, 0.75, 0.75]);
        tally.compare(&pair(
            (&shell, Pose::identity(), 1.0),
            (partner, center * at, 2.0),
        ));
    }
    tally.assert_told_something("cavity", 70);
}

fn vertices(coordinates: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    coordinates.iter().copied().map(Vector3::from).collect()
}

const APEXES: [[f64; 3]; 2] = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];

#[test]
fn a_shape_says_where_its_extent_is_zero_inside() {
    let ring = [[1.0, 0.0, 0.0], [-0.5, 0.8, 0.0], [-0.5, -0.8, 0.0]];
    let reason = |mesh, extents| {
        let field = PressureField::with_inert_tets(mesh, extents).unwrap();
        Shape::new(field).followed().unwrap_err()
    };
    // Three tetrahedra share the edge between both apexes.
    let around_edge = [ring.as_slice(), &APEXES].concat();
    let tets = vec![[0, 1, 3, 4], [1, 2, 3, 4], [2, 0, 3, 4]];
    let mesh = TetMesh::new(vertices(&around_edge), tets).unwrap();
    let zero_tet = reason(mesh, vec![0.0; 5]);
    assert_eq!(zero_tet, NotFollowed::ZeroTetrahedron { tet: 0 });
    assert_eq!(
        zero_tet.to_string(),
        "tetrahedron 0 has extent 0 at all corners"
    );
    // A ball with its center at 0, then a ball with a tetrahedron at 0.
    let ball = shapes::icosphere(1.0, 0).unwrap();
    let inner = (0..ball.extents().len())
        .find(|&v| ball.extents()[v] > 0.0)
        .unwrap();
    let divided = split_at_centroids(ball.mesh());
    let mut extents = vec![0.0; ball.extents().len()];
    extents.resize(divided.vertex_count(), 0.5);
    assert_eq!(
        reason(divided, extents),
        NotFollowed::ZeroVertex { vertex: inner }
    );
    // The edge and the face between tetrahedra that have their own inner vertices.
    let edge = split_at_centroids(
        &TetMesh::new(
            vertices(&around_edge),
            vec![[0, 1, 3, 4], [1, 2, 3, 4], [2, 0, 3, 4]],
        )
        .unwrap(),
    );
    let extents = [[0.0; 5].as_slice(), &[1.0; 3]].concat();
    assert_eq!(
        reason(edge, extents),
        NotFollowed::ZeroEdge { vertices: [3, 4] }
    );
    let two = TetMesh::new(vertices(&around_edge), vec![[0, 1, 2, 3], [0, 1, 2, 4]]).unwrap();
    let extents = [[0.0; 5].as_slice(), &[1.0; 2]].concat();
    let zero_face = reason(split_at_centroids(&two), extents);
    assert!(
        matches!(zero_face, NotFollowed::ZeroFace { .. }),
        "{zero_face}"
    );
}

/// Returns the mesh with each tetrahedron divided into four.
fn split_at_centroids(mesh: &TetMesh) -> TetMesh {
    let mut vertices = mesh.vertices().to_vec();
    let mut tets = Vec::new();
    for corners in mesh.tets() {
        let sum: Vector3<f64> = corners.iter().map(|&corner| mesh.vertices()[corner]).sum();
        for corner in 0..4 {
            let mut part = *corners;
            part[corner] = vertices.len();
            tets.push(part);
        }
        vertices.push(sum / 4.0);
    }
    TetMesh::new(vertices, tets).unwrap()
}
