//! Valid mesh files in all formats: their meshes and point data.

use super::sample_files::{
    ONE_TET, ONE_TET_VTK, PLAIN, WITH_EXTENTS, bracket, read_bytes, replaced,
};
use hydroelastic::io::{FileError, MeshFile};
use hydroelastic::mesh::{MeshError, PressureField};
use nalgebra::Vector3;

/// Rounding error of numbers in ASCII files, which have 12 digits (meshio's .vtu) to 17 digits.
const ASCII_DIGITS: f64 = 1e-11;

fn assert_same_mesh(a: &MeshFile, b: &MeshFile) {
    assert_eq!(a.mesh.tets(), b.mesh.tets());
    assert_eq!(a.mesh.vertex_count(), b.mesh.vertex_count());
    for (a, b) in a.mesh.vertices().iter().zip(b.mesh.vertices()) {
        assert!((a - b).amax() < ASCII_DIGITS);
    }
    assert!((a.mesh.volume() / b.mesh.volume() - 1.0).abs() < 100.0 * ASCII_DIGITS);
}

#[test]
fn all_files_of_gmsh_hold_the_same_mesh() {
    let first = bracket(PLAIN[0]);
    assert_eq!(
        (first.mesh.vertex_count(), first.mesh.tet_count()),
        (294, 836)
    );
    assert!(first.point_data.is_empty());
    for name in PLAIN {
        assert_same_mesh(&bracket(name), &first);
    }
}

#[test]
fn the_volume_is_that_of_the_bracket() {
    // Foot and arm. The hole is a polygon inscribed in its circle.
    let solid = 0.2 * 0.1 * 0.07 + 0.07 * 0.1 * 0.13;
    let hole = std::f64::consts::PI * 0.02_f64.powi(2) * 0.07;
    let volume = bracket("bracket.msh").mesh.volume();
    assert!(
        volume > solid - hole && volume < solid - 0.8 * hole,
        "{volume}"
    );
    // Splitting tetrahedra for the extents has not changed the shape.
    let split = bracket(WITH_EXTENTS[0]).mesh.volume();
    assert!((split / volume - 1.0).abs() < 1e-13);
}

#[test]
fn all_files_with_extents_hold_the_same_mesh_and_field() {
    let first = bracket(WITH_EXTENTS[0]);
    assert_eq!(
        (first.mesh.vertex_count(), first.mesh.tet_count()),
        (609, 1781)
    );
    for name in WITH_EXTENTS {
        let file = bracket(name);
        assert_same_mesh(&file, &first);
        // The vectors in the file are not extents.
        assert_eq!(file.point_data.keys().collect::<Vec<_>>(), ["extent"]);
        for (a, b) in file.point_data["extent"]
            .iter()
            .zip(&first.point_data["extent"])
        {
            assert!((a - b).abs() < ASCII_DIGITS);
        }
        assert_eq!(file.point_data["extent"].len(), 609);
    }
}

#[test]
fn distances_to_the_surface_agree_with_those_of_another_program() {
    let file = bracket(WITH_EXTENTS[0]);
    let by_distance = PressureField::from_distance(&file.mesh).unwrap();
    let field = file.pressure_field("extent").unwrap();
    // make_meshes.py computes the same distances in numpy, with other formulas.
    for (a, b) in field.extents().iter().zip(by_distance.extents()) {
        assert!((a - b).abs() < 1e-13, "{a} {b}");
    }
}

#[test]
fn an_array_that_is_not_there_is_refused_with_the_names_of_those_that_are() {
    let error = bracket(WITH_EXTENTS[0])
        .pressure_field("depth")
        .unwrap_err();
    assert!(error.to_string().contains(r#"only ["extent"]"#), "{error}");
    assert!(matches!(error, FileError::NoSuchArray { name, .. } if name == "depth"));
}

#[test]
fn an_array_that_is_no_field_is_refused() {
    let file = read_bytes("no_field.vtk", ONE_TET_VTK.as_bytes()).unwrap();
    let error = file.pressure_field("depth").unwrap_err();
    let refused = MeshError::SurfaceExtent {
        vertex: 1,
        value: 2.0,
    };
    assert!(matches!(error, FileError::Mesh { source, .. } if source == refused));
}

#[test]
fn node_tags_count_whatever_their_order_and_gaps() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let with_gaps = replaced(ONE_TET, "5\n3\n0 0 0", "700\n3\n0 0 0");
    let with_gaps = replaced(&with_gaps, "2 5 1 5", "2 5 1 700");
    let with_gaps = replaced(&with_gaps, "1 5 1 4", "1 700 1 4");
    let with_gaps = replaced(&with_gaps, "2 5 1 4 2", "2 700 1 4 2");
    for text in [
        ONE_TET.to_string(),
        with_gaps,
        ONE_TET.replace('\n', "\r\n"),
    ] {
        let mesh = read_bytes("tags.msh", text.as_bytes()).unwrap().mesh;
        // The node with tag 3 belongs to no tetrahedron.
        assert_eq!(mesh.vertices(), corners.map(Vector3::from));
        assert_eq!(mesh.tetrahedron(0).corners, corners.map(Vector3::from));
    }
}

#[test]
fn vertices_without_tetrahedra_are_left_out_together_with_their_data() {
    let file = read_bytes("unused.vtk", ONE_TET_VTK.as_bytes()).unwrap();
    assert_eq!(file.mesh.vertex_count(), 4);
    assert_eq!(file.point_data["depth"], [0.0, 2.0, 3.0, 4.0]);
}
