//! Validation of meshes: corrected input, and rejected input with an error that names it.

use super::sample_meshes::{ROUND_OFF, assert_relative, unit_corners};
use hydroelastic::mesh::{MeshError, TetMesh};
use nalgebra::{Vector3, vector};

#[test]
fn negative_tetrahedra_are_turned_round() {
    for swap in [[0, 1], [1, 3], [2, 0]] {
        let mut tet = [0, 1, 2, 3];
        tet.swap(swap[0], swap[1]);
        let mesh = TetMesh::new(unit_corners(), vec![tet]).unwrap();
        assert_relative(mesh.tetrahedron(0).signed_volume(), 1.0 / 6.0, ROUND_OFF);
        let mut corners = mesh.tets()[0];
        corners.sort_unstable();
        assert_eq!(corners, [0, 1, 2, 3]);
    }
}

#[test]
fn positive_tetrahedra_are_left_as_they_are() {
    let mesh = TetMesh::new(unit_corners(), vec![[1, 2, 0, 3]]).unwrap();
    assert_eq!(mesh.tets(), [[1, 2, 0, 3]]);
    assert_eq!((mesh.tet_count(), mesh.vertex_count()), (1, 4));
    assert_eq!(mesh.vertices(), unit_corners());
}

fn mesh_error(vertices: Vec<Vector3<f64>>, tets: &[[usize; 4]]) -> MeshError {
    TetMesh::new(vertices, tets.to_vec()).unwrap_err()
}

#[test]
fn a_mesh_without_tetrahedra_is_empty() {
    assert_eq!(mesh_error(unit_corners(), &[]), MeshError::Empty);
    assert_eq!(mesh_error(Vec::new(), &[]), MeshError::Empty);
    assert_eq!(
        MeshError::Empty.to_string(),
        "a mesh needs at least one tetrahedron"
    );
}

/// The test creates only the message, because a mesh of this size would take 100 GB.
#[test]
fn the_message_of_too_large_a_mesh_names_count_and_limit() {
    let (count, limit) = (5_000_000_000, 4_294_967_295);
    assert_eq!(
        MeshError::TooLarge { count, limit }.to_string(),
        "a mesh holds at most 4294967295 vertices and tetrahedra, but 5000000000 were given"
    );
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut vertices = unit_corners();
        vertices[2].y = bad;
        let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
        assert!(
            matches!(error, MeshError::NonFiniteCoordinate { vertex: 2, value }
                if value.to_bits() == bad.to_bits()),
            "{error}"
        );
    }
    let (vertex, value) = (2, f64::NAN);
    assert_eq!(
        MeshError::NonFiniteCoordinate { vertex, value }.to_string(),
        "vertex 2 has the coordinate NaN, but coordinates must be finite"
    );
}

#[test]
fn a_vertex_that_does_not_exist_is_named() {
    let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], [0, 1, 12, 2]]);
    let expected = MeshError::VertexOutOfRange {
        tet: 1,
        vertex: 12,
        vertex_count: 4,
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "tetrahedron 1 refers to vertex 12, but the mesh has 4 vertices"
    );
    let error = mesh_error(unit_corners(), &[[0, 1, 2, usize::MAX]]);
    assert!(matches!(error, MeshError::VertexOutOfRange { tet: 0, .. }));
}

#[test]
fn a_vertex_used_twice_by_a_tetrahedron_is_named() {
    for (tet, vertex) in [([0, 1, 2, 1], 1), ([3, 3, 0, 2], 3), ([0, 1, 2, 0], 0)] {
        let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], tet]);
        assert_eq!(error, MeshError::RepeatedVertex { tet: 1, vertex });
    }
}

#[test]
fn flat_tetrahedra_are_named() {
    let mut vertices = unit_corners();
    vertices.push(vector![1.0, 1.0, 0.0]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [0, 1, 2, 4]]);
    let expected = MeshError::ZeroVolume {
        tet: 1,
        volume: 0.0,
        longest_edge: 2.0_f64.sqrt(),
    };
    assert_eq!(error, expected);
    let message = error.to_string();
    assert!(
        message.starts_with("tetrahedron 1 has the volume 0e0 m³ over a longest edge of 1.414")
    );
    // Two different vertices have the same position.
    let mut vertices = unit_corners();
    vertices[3] = vertices[0];
    let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
    assert!(matches!(error, MeshError::ZeroVolume { tet: 0, .. }));
}

/// Returns the unit tetrahedron with its top lowered to `height`.
fn flattened(height: f64) -> Vec<Vector3<f64>> {
    let mut vertices = unit_corners();
    vertices[3].z = height;
    vertices
}

#[test]
fn flatness_is_judged_at_every_scale_alike() {
    // Powers of two scale exactly; other factors scale to round-off.
    let scales = [
        1.0,
        1e-6,
        1e6,
        1e-100,
        1e100,
        2.0_f64.powi(-300),
        2.0_f64.powi(300),
    ];
    for scale in scales {
        let is_solid = |height| {
            let vertices = flattened(height).iter().map(|v| v * scale).collect();
            match TetMesh::new(vertices, vec![[0, 1, 2, 3]]) {
                Ok(_) => true,
                Err(MeshError::ZeroVolume { tet: 0, .. }) => false,
                Err(unexpected) => panic!("{unexpected}"),
            }
        };
        // The longest edge is √2, so the limit is 2.8e-12.
        assert!(
            is_solid(1.0) && is_solid(3e-12) && is_solid(-3e-12),
            "{scale:e}"
        );
        assert!(
            !is_solid(2.7e-12) && !is_solid(-2.7e-12) && !is_solid(0.0),
            "{scale:e}"
        );
    }
}

#[test]
fn sizes_beyond_the_range_of_numbers_are_flat_and_no_panic() {
    for scale in [f64::MIN_POSITIVE, 1e-300, 1e-150, 1e150, 1e300, f64::MAX] {
        let vertices = unit_corners().iter().map(|v| v * scale).collect();
        let error = mesh_error(vertices, &[[0, 1, 2, 3]]);
        assert!(
            matches!(error, MeshError::ZeroVolume { tet: 0, .. }),
            "{scale:e}"
        );
    }
}

#[test]
fn an_unused_vertex_is_named() {
    let mut vertices = unit_corners();
    vertices.insert(1, vector![5.0, 5.0, 5.0]);
    let error = mesh_error(vertices, &[[0, 2, 3, 4]]);
    assert_eq!(error, MeshError::UnusedVertex { vertex: 1 });
    assert_eq!(error.to_string(), "vertex 1 belongs to no tetrahedron");
}

#[test]
fn tetrahedra_on_one_side_of_a_face_overlap() {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, 0.5]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [2, 1, 0, 4]]);
    let expected = MeshError::OverlappingTets {
        first: 0,
        second: 1,
        face: [0, 1, 2],
    };
    assert_eq!(error, expected);
    assert_eq!(
        error.to_string(),
        "tetrahedra 0 and 1 overlap: they share the face of vertices [0, 1, 2], but lie on the same side of it or share it with a third"
    );
}

#[test]
fn a_tetrahedron_given_twice_overlaps_itself() {
    let error = mesh_error(unit_corners(), &[[0, 1, 2, 3], [1, 0, 2, 3]]);
    assert!(matches!(
        error,
        MeshError::OverlappingTets {
            first: 0,
            second: 1,
            ..
        }
    ));
}

#[test]
fn three_tetrahedra_at_one_face_overlap() {
    let mut vertices = unit_corners();
    vertices.push(vector![0.2, 0.2, -0.5]);
    vertices.push(vector![0.3, 0.3, -1.0]);
    let error = mesh_error(vertices, &[[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]);
    assert!(
        matches!(
            error,
            MeshError::OverlappingTets {
                face: [0, 1, 2],
                ..
            }
        ),
        "{error}"
    );
}
