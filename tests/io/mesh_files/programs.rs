//! Mesh files as programs write them: versions, encodings, seams, second order. The exact volume or force of each is known.

use super::sample_files::{ONE_TET, bracket, read_bytes, replaced};
use hydroelastic::contact::{ContactBody, ContactPair, Partner, Shape};
use hydroelastic::io::{
    FileError, FileWarning, MeshFile, MeshOptions, Placement, read_mesh, read_triangle_surface,
};
use hydroelastic::mesh::PressureField;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::path::{Path, PathBuf};

/// Rounding error of a few sums.
const ROUND_OFF: f64 = 1e-14;

/// Rounding error of positions in single precision with 6 digits of text.
const SINGLE: f64 = 1e-5;

/// Volume (m³) of the tetrahedron of the origin and the unit vectors.
const CORNER: f64 = 1.0 / 6.0;

fn path_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/field_files")
        .join(name)
}

fn read(name: &str) -> MeshFile {
    let file = read_mesh(path_of(name), &MeshOptions::default());
    file.unwrap_or_else(|error| panic!("{error}: {error:?}"))
}

fn assert_volume(file: &MeshFile, expected: f64) {
    assert!(
        (file.mesh.volume() - expected).abs() < ROUND_OFF,
        "{}",
        file.mesh.volume()
    );
    assert_eq!(file.warnings, []);
}

/// Returns the names of the files in a folder with an extension.
fn names(folder: &str, extension: &str) -> Vec<String> {
    let entries = std::fs::read_dir(path_of(folder)).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names
        .filter(|name| name.ends_with(extension))
        .map(|name| format!("{folder}/{name}"))
        .collect()
}

#[test]
fn one_tetrahedron_has_its_volume_in_every_format() {
    for name in [
        "gmsh_1.msh",
        "gmsh_2_2.msh",
        "gmsh_2_2_binary.msh",
        "gmsh_4_0.msh",
        "gmsh_4_0_binary.msh",
        "appended_base64.vtu",
        "appended_raw.vtu",
        "appended_raw_zlib.vtu",
        "xml_in_legacy_name.vtk",
        "medit.mesh",
        "tetgen.node",
        "tetgen.ele",
    ] {
        assert_volume(&read(name), CORNER);
    }
}

#[test]
fn all_files_of_a_box_hold_the_same_mesh() {
    let expected = read("box_4_1_ascii.msh").mesh;
    let mut names = names(".", ".msh");
    names.retain(|name| name.contains("box"));
    assert_eq!(names.len(), 10);
    names.extend(["box.mesh".into(), "box.inp".into()]);
    for name in names {
        let file = read(&name);
        assert_volume(&file, 1.0);
        assert_eq!(file.mesh.vertices(), expected.vertices(), "{name}");
        assert_eq!(file.mesh.tets(), expected.tets(), "{name}");
    }
}

#[test]
fn all_encodings_of_vtk_hold_the_same_mesh_and_data() {
    let mut names = [names("vtk", ".vtu"), names("vtk", ".vtk")].concat();
    names.retain(|name| !name.contains("polygons") && !name.contains("strips"));
    assert_eq!(names.len(), 36);
    for name in names {
        let file = read(&name);
        assert_volume(&file, CORNER);
        // The first point belongs to no tetrahedron.
        assert_eq!(
            file.point_data["some depth"],
            [1.0, 2.0, 3.0, 4.0],
            "{name}"
        );
    }
}

#[test]
fn pieces_are_joined() {
    let text = std::fs::read_to_string(path_of("xml_in_legacy_name.vtk")).unwrap();
    let (start, end) = (
        text.find("<Piece").unwrap(),
        text.find("</UnstructuredGrid>").unwrap(),
    );
    let second = text[start..end].replace("1 0 0 0 1 0 0 0 1<", "-1 0 0 0 -1 0 0 0 1<");
    let both = format!("{}{second}{}", &text[..end], &text[end..]);
    let file = read_bytes("pieces.vtu", both.as_bytes()).unwrap();
    assert_eq!((file.mesh.tet_count(), file.mesh.vertex_count()), (2, 8));
    assert_volume(&file, 2.0 * CORNER);
}

#[test]
fn the_corners_of_tetrahedra_of_second_order_are_read_on_request() {
    let path = path_of("second_order.msh");
    let error = read_mesh(&path, &MeshOptions::default()).unwrap_err();
    assert!(
        matches!(
            error,
            FileError::HigherOrder {
                found: 1,
                vertex_count: 10,
                ..
            }
        ),
        "{error:?}"
    );
    assert!(
        error.to_string().contains("the option corners_only"),
        "{error}"
    );
    let corners_only = MeshOptions {
        corners_only: true,
        ..MeshOptions::default()
    };
    let file = read_mesh(path, &corners_only).unwrap();
    assert_eq!(file.mesh.vertex_count(), 4);
    assert_volume(&file, CORNER);
}

/// Returns the force (N) on the two tetrahedra of the files with and without a seam, a third of a meter deep in a rigid half-space.
fn force(file: &MeshFile) -> f64 {
    let shape = Shape::new(PressureField::from_distance(&file.mesh).unwrap());
    let pose = Pose::from_translation(Vector3::repeat(-1.0 / 3.0));
    let body = ContactBody::new(&shape, pose, 1.0).unwrap();
    let ground = Partner::rigid_half_space(Pose::identity()).unwrap();
    ContactPair::new(body, ground).wrench().on_a.force.z
}

#[test]
fn duplicated_inner_vertices_are_merged_and_reported() {
    let (seam, whole) = (read("seam.vtk"), read("no_seam.vtk"));
    assert_eq!(
        seam.warnings,
        [FileWarning::WeldedVertices {
            vertex_count: 3,
            pair_count: 1
        }]
    );
    assert_eq!(
        (
            seam.mesh.vertex_count(),
            seam.mesh.surface_triangles().len()
        ),
        (5, 6)
    );
    assert_volume(&whole, 0.5);
    assert!((force(&whole) - 0.222).abs() < 5e-4, "{}", force(&whole));
    assert_eq!(force(&seam).to_bits(), force(&whole).to_bits());
}

#[test]
fn nearly_equal_vertices_are_reported_and_merged_on_request() {
    let text = std::fs::read_to_string(path_of("seam.vtk")).unwrap();
    // The second copy of the vertex (1, 0, 0).
    let apart = replaced(&text, "0 0 1\n1 0 0\n", "0 0 1\n1.0000001 0 0\n");
    let file = read_bytes("nearly.vtk", apart.as_bytes()).unwrap();
    let [
        FileWarning::Seam {
            pair_count: 1,
            distance,
            at,
        },
    ] = file.warnings[..]
    else {
        panic!("{:?}", file.warnings);
    };
    assert!(
        (distance - 1e-7).abs() < 1e-9 && (at.sum() - 1.0).abs() < 1e-6,
        "{distance} {at}"
    );
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("nearly.vtk");
    let weld = |weld_tolerance| {
        let options = MeshOptions {
            weld_tolerance,
            ..MeshOptions::default()
        };
        read_mesh(&path, &options).unwrap()
    };
    let welded = weld(2e-7);
    assert_eq!(
        welded.warnings,
        [FileWarning::WeldedVertices {
            vertex_count: 3,
            pair_count: 1
        }]
    );
    assert!((force(&welded) - 0.222).abs() < 5e-4);
    // A tolerance that collapses the tetrahedra joins nothing.
    assert_eq!(weld(2.0).mesh.vertex_count(), 8);
}

#[test]
fn placements_scale_mirror_and_move_tetrahedra() {
    let placement = Placement {
        unit: 0.5,
        scale: vector![-1.0, 2.0, 1.0],
        pose: Pose::from_translation(vector![0.0, 0.0, 3.0]),
    };
    let options = MeshOptions {
        placement,
        ..MeshOptions::default()
    };
    let file = read_mesh(path_of("gmsh_1.msh"), &options).unwrap();
    assert_volume(&file, 0.25 * CORNER);
    let expected = [
        [0.0, 0.0, 3.0],
        [-0.5, 0.0, 3.0],
        [0.0, 1.0, 3.0],
        [0.0, 0.0, 3.5],
    ];
    assert_eq!(file.mesh.vertices(), expected.map(Vector3::from));
}

#[test]
fn options_out_of_range_are_refused_by_name() {
    let with_placement = |unit, scale| {
        let placement = Placement {
            unit,
            scale,
            pose: Pose::identity(),
        };
        MeshOptions {
            placement,
            ..MeshOptions::default()
        }
    };
    let (one, zero) = (Vector3::repeat(1.0), vector![1.0, 0.0, 1.0]);
    let weld = |weld_tolerance| MeshOptions {
        weld_tolerance,
        ..MeshOptions::default()
    };
    for (options, expected) in [
        (with_placement(0.0, one), "unit"),
        (with_placement(f64::NAN, one), "unit"),
        (with_placement(1.0, zero), "scale"),
        (weld(-1.0), "weld_tolerance"),
        (weld(f64::INFINITY), "weld_tolerance"),
    ] {
        let error = read_mesh(path_of("gmsh_1.msh"), &options).unwrap_err();
        assert!(
            matches!(&error, FileError::Option { name, .. } if name == expected),
            "{error:?}"
        );
    }
}

#[test]
fn suspicious_meshes_are_reported() {
    let large = MeshOptions {
        placement: Placement {
            unit: 1e3,
            ..Placement::default()
        },
        ..MeshOptions::default()
    };
    let file = read_mesh(path_of("gmsh_1.msh"), &large).unwrap();
    assert_eq!(
        file.warnings,
        [FileWarning::Size {
            size: 1e3,
            unit: 1e3
        }]
    );
    let thin = replaced(ONE_TET, "0 0 1\n$EndNodes", "0 0 1e-4\n$EndNodes");
    let file = read_bytes("thin.msh", thin.as_bytes()).unwrap();
    let [
        FileWarning::ThinTetrahedra {
            count: 1, ratio, ..
        },
    ] = file.warnings[..]
    else {
        panic!("{:?}", file.warnings);
    };
    // The smallest height ends at the plane x + y + 10⁴ z = 1. The longest edge is √2.
    let expected = 1.0 / (2.0_f64 * (2.0 + 1e8)).sqrt();
    assert!((ratio - expected).abs() < ROUND_OFF, "{ratio}");
    let outside = replaced(ONE_TET, "1 5 1 4\n", "1 5 3 4\n");
    let file = read_bytes("outside.msh", outside.as_bytes()).unwrap();
    assert_eq!(file.warnings, [FileWarning::IgnoredCells { count: 1 }]);
    // Faces of the tetrahedra are not reported.
    assert_eq!(bracket("bracket.msh").warnings, []);
}

#[test]
fn polygons_and_strips_of_vtk_are_surfaces() {
    let tetrahedron =
        read_triangle_surface(path_of("polygons.vtk"), &Placement::default()).unwrap();
    assert!((tetrahedron.volume() - CORNER).abs() < ROUND_OFF);
    let sphere = read_triangle_surface(path_of("vtk/polygons.vtp"), &Placement::default()).unwrap();
    assert_eq!(sphere.triangles().len(), 96);
    for name in ["vtk/polygons.vtk", "vtk/strips.vtp", "vtk/strips.vtk"] {
        let other = read_triangle_surface(path_of(name), &Placement::default()).unwrap();
        assert_eq!(other.triangles().len(), 96, "{name}");
        assert!(
            (other.volume() / sphere.volume() - 1.0).abs() < SINGLE,
            "{name}"
        );
    }
    // The error of each reader names the other one.
    let error = read_mesh(path_of("polygons.vtk"), &MeshOptions::default()).unwrap_err();
    assert!(error.to_string().contains("read_triangles"), "{error}");
    let error = read_triangle_surface(path_of("no_seam.vtk"), &Placement::default()).unwrap_err();
    assert!(error.to_string().contains("read_mesh"), "{error}");
}

#[test]
fn chains_of_duplicated_vertices_are_merged_in_any_order() {
    // Three wedges around a common edge. The copies of its ends are 0.8 tolerances apart.
    let tolerance = 1e-4;
    let spoke = |k: u32| {
        let angle = f64::from(k) * std::f64::consts::FRAC_PI_3;
        [angle.cos(), angle.sin(), 0.5]
    };
    let wedge = |k: u32| {
        let corners = [[0.0; 3], [0.0, 0.0, 1.0], spoke(k), spoke(k + 1)];
        corners.map(|[x, y, z]| [x + 0.8 * tolerance * f64::from(k), y, z])
    };
    let options = MeshOptions {
        weld_tolerance: tolerance,
        ..MeshOptions::default()
    };
    for order in [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ] {
        let vertices = order.map(wedge);
        let vertices = vertices.as_flattened().iter();
        let lines = vertices.map(|[x, y, z]| format!("{x} {y} {z} 0\n"));
        let vertices = lines.collect::<Vec<String>>().concat();
        let text = format!(
            "MeshVersionFormatted 2\nDimension 3\nVertices\n12\n{vertices}Tetrahedra\n3\n1 2 3 4 0\n5 6 7 8 0\n9 10 11 12 0\nEnd\n"
        );
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("chain.mesh");
        std::fs::write(&path, text).unwrap();
        let file = read_mesh(&path, &options).unwrap();
        assert_eq!(file.mesh.vertex_count(), 6, "{order:?}");
        assert_eq!(
            file.warnings,
            [FileWarning::WeldedVertices {
                vertex_count: 6,
                pair_count: 2
            }]
        );
    }
}

#[test]
fn lines_of_second_order_are_not_faces() {
    let line = replaced(
        ONE_TET,
        "2 2 1 2\n2 1 2 1\n1 5 1 4\n",
        "2 2 1 2\n1 1 8 1\n1 5 1 3\n",
    );
    let file = read_bytes("line.msh", line.as_bytes()).unwrap();
    assert_eq!(file.warnings, []);
}
