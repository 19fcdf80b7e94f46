//! Inner vertices: no simplex inside a mesh has all its corners on the surface, and the shape does not change.

use super::sample_meshes::{
    FIVE, KUHN, ROUND_OFF, assert_inertia, assert_relative, cube, enclosed_volume, meshes,
    tet_around_a_vertex, unit_tet,
};
use hydroelastic::mesh::TetMesh;
use std::collections::BTreeSet;

/// Returns the edges, faces and tetrahedra that have all corners on the surface but are not part of the surface.
fn flat_simplices(mesh: &TetMesh) -> Vec<BTreeSet<usize>> {
    let surface: Vec<BTreeSet<usize>> = mesh
        .surface_triangles()
        .iter()
        .map(|triangle| BTreeSet::from(*triangle))
        .collect();
    let choices = [
        &[0, 1][..],
        &[0, 2],
        &[0, 3],
        &[1, 2],
        &[1, 3],
        &[2, 3],
        &[0, 1, 2],
        &[0, 1, 3],
        &[0, 2, 3],
        &[1, 2, 3],
        &[0, 1, 2, 3],
    ];
    let simplices = mesh.tets().iter().flat_map(|tet| {
        choices.map(|choice| {
            choice
                .iter()
                .map(|&corner| tet[corner])
                .collect::<BTreeSet<usize>>()
        })
    });
    simplices
        .filter(|simplex| simplex.iter().all(|&vertex| mesh.is_on_surface(vertex)))
        .filter(|simplex| !surface.iter().any(|triangle| simplex.is_subset(triangle)))
        .collect()
}

fn sorted_surface(mesh: &TetMesh) -> Vec<[usize; 3]> {
    let smallest_first =
        |&[a, b, c]: &[usize; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let mut triangles: Vec<[usize; 3]> = mesh
        .surface_triangles()
        .iter()
        .map(smallest_first)
        .collect();
    triangles.sort_unstable();
    triangles
}

#[test]
fn inner_vertices_leave_nothing_flat_inside() {
    for (name, mesh) in meshes() {
        let split = mesh.with_inner_vertices().unwrap();
        assert!(flat_simplices(&split).is_empty(), "{name}");
        assert!(
            (0..split.vertex_count()).any(|vertex| !split.is_on_surface(vertex)),
            "{name}"
        );
    }
}

#[test]
fn inner_vertices_leave_volume_and_surface_as_they_were() {
    for (name, mesh) in meshes() {
        let split = mesh.with_inner_vertices().unwrap();
        assert_relative(split.volume(), mesh.volume(), ROUND_OFF);
        assert_eq!(sorted_surface(&split), sorted_surface(&mesh), "{name}");
        assert_eq!(
            &split.vertices()[..mesh.vertex_count()],
            mesh.vertices(),
            "{name}"
        );
        let (actual, expected) = (
            split.mass_properties(1.0).unwrap(),
            mesh.mass_properties(1.0).unwrap(),
        );
        assert_inertia(&actual.inertia, &expected.inertia, ROUND_OFF);
    }
}

#[test]
fn meshes_with_inner_vertices_are_conforming_in_any_order_of_vertices() {
    for (name, mesh) in meshes() {
        let count = mesh.vertex_count();
        for shift in 1..count.min(12) {
            let shifted = |vertex: usize| (vertex + shift) % count;
            let mut vertices = mesh.vertices().to_vec();
            vertices.rotate_right(shift);
            let tets = mesh.tets().iter().map(|tet| tet.map(shifted)).collect();
            let turned = TetMesh::new(vertices, tets).unwrap();
            // TetMesh::new inside this call rejects faces that do not meet.
            let split = turned.with_inner_vertices().unwrap();
            assert_relative(split.volume(), mesh.volume(), ROUND_OFF);
            assert_relative(enclosed_volume(&split), mesh.volume(), ROUND_OFF);
            assert!(flat_simplices(&split).is_empty(), "{name}");
        }
    }
}

#[test]
fn a_mesh_that_needs_no_inner_vertices_stays_as_it_is() {
    let mesh = tet_around_a_vertex();
    let split = mesh.with_inner_vertices().unwrap();
    assert_eq!(
        (split.tets(), split.vertices()),
        (mesh.tets(), mesh.vertices())
    );
    let twice = cube(&FIVE).with_inner_vertices().unwrap();
    assert_eq!(twice.with_inner_vertices().unwrap().tets(), twice.tets());
}

#[test]
fn counts_of_inner_vertices_are_known() {
    let counts = |mesh: &TetMesh| {
        let split = mesh.with_inner_vertices().unwrap();
        (split.vertex_count(), split.tet_count())
    };
    // One vertex at the center.
    assert_eq!(counts(&unit_tet()), (5, 4));
    // The diagonal that all six tetrahedra share is halved.
    assert_eq!(counts(&cube(&KUHN)), (9, 12));
    // No inner edge exists, but four inner faces do. Each corner tetrahedron is split into three. The inner tetrahedron is split into three
    // at its first face, and each of these into three at one of the other faces.
    assert_eq!(counts(&cube(&FIVE)), (12, 4 * 3 + 9));
}
