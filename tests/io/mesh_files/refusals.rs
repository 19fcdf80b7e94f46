//! Mesh files that are rejected, each with an error that names the invalid or unsupported part.

use super::sample_files::{ONE_TET, ONE_TET_VTK, read_bytes, replaced};
use hydroelastic::io::{FileError, MeshOptions, read_mesh};
use hydroelastic::mesh::MeshError;
use std::error::Error;

const ONE_TET_VTU: &str = "<?xml version=\"1.0\"?>\
    <VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\
    <UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\
    <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\
    0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\
    <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
    <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>\
    <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>\
    </Piece></UnstructuredGrid></VTKFile>";

fn error_of(name: &str, text: &str) -> FileError {
    read_bytes(name, text.as_bytes()).unwrap_err()
}

/// Asserts that the text is refused as damaged, and that the cause has these words.
fn assert_damaged(name: &str, text: &str, words: &str) {
    let error = error_of(name, text);
    assert!(matches!(error, FileError::Syntax { .. }), "{error:?}");
    let cause = error.source().unwrap().to_string();
    assert!(cause.contains(words), "{cause}");
}

#[test]
fn extensions_count_in_upper_case_too_and_others_are_refused() {
    assert!(read_bytes("UPPER.MSH", ONE_TET.as_bytes()).is_ok());
    for name in ["mesh.stl", "mesh", "msh"] {
        let error = read_mesh(name, &MeshOptions::default()).unwrap_err();
        assert!(
            matches!(error, FileError::UnknownExtension { .. }),
            "{error:?}"
        );
    }
    let error = read_mesh("there_is_no_such_file.msh", &MeshOptions::default()).unwrap_err();
    assert!(matches!(error, FileError::Read { .. }));
}

#[test]
fn gmsh_files_of_other_versions_are_refused() {
    for header in ["3.0 0 8", "4.1 0 99999999999999", "4.1 1 5", "4.1 0"] {
        let error = error_of("version.msh", &replaced(ONE_TET, "4.1 0 8", header));
        assert!(
            matches!(&error, FileError::Unsupported { found, .. } if found.contains(header)),
            "{error:?}"
        );
    }
}

#[test]
fn sections_that_are_longer_or_shorter_than_stated_are_refused() {
    let empty = |from, to| replaced(ONE_TET, from, to);
    assert_damaged(
        "empty.msh",
        &empty("2 5 1 5", "0 0 1 1"),
        "expected $EndNodes",
    );
    assert_damaged(
        "empty.msh",
        &empty("2 2 1 2", "0 00 1 1"),
        "expected $EndElements",
    );
    let cut = &ONE_TET[..ONE_TET.find("5 1 5").unwrap()];
    assert_damaged("empty.msh", cut, "3 numbers cannot be in the last 1 bytes");
    // The last number may be incomplete if the end of the section is missing.
    let cut = &ONE_TET[..ONE_TET.find("\n$EndElements").unwrap()];
    assert_damaged("empty.msh", cut, "$EndElements is missing");
}

#[test]
fn files_without_tetrahedra_are_refused() {
    let without_elements = &ONE_TET[..ONE_TET.find("$Elements").unwrap()];
    let error = error_of("surface.msh", without_elements);
    assert!(matches!(error, FileError::NoTetrahedra { .. }));
    let triangle = replaced(ONE_TET, "3 1 4 1\n2 5 1 4 2", "2 1 2 1\n2 5 1 4");
    assert!(matches!(
        error_of("surface.msh", &triangle),
        FileError::NoTetrahedra { .. }
    ));
    let line = replaced(ONE_TET_VTU, ">10<", ">4<");
    assert!(matches!(
        error_of("surface.vtu", &line),
        FileError::NoTetrahedra { .. }
    ));
}

#[test]
fn tetrahedra_of_second_order_are_refused_by_name() {
    let msh = replaced(
        ONE_TET,
        "3 1 4 1\n2 5 1 4 2",
        "3 1 11 1\n2 5 1 4 2 1 1 1 1 1 1",
    );
    let vtk = replaced(ONE_TET_VTK, "5\n10\n", "5\n24\n");
    let vtu = replaced(ONE_TET_VTU, ">10<", ">71<");
    for (name, text) in [
        ("second.msh", msh),
        ("second.vtk", vtk),
        ("second.vtu", vtu),
    ] {
        let error = error_of(name, &text);
        assert!(
            error.to_string().contains("second or higher order"),
            "{error}"
        );
        assert!(matches!(error, FileError::HigherOrder { .. }));
    }
}

#[test]
fn solids_that_are_not_all_tetrahedra_are_refused() {
    let pyramid = replaced(ONE_TET, "3 1 4 1\n2 5 1 4 2", "3 1 7 1\n2 5 1 4 2 3");
    let error = error_of("solid.msh", &pyramid);
    assert!(matches!(error, FileError::OtherSolid { found, .. } if found == "pyramid: 1"));
    let error = error_of("solid.vtk", &replaced(ONE_TET_VTK, "5\n10\n", "5\n14\n"));
    assert!(matches!(error, FileError::OtherSolid { found, .. } if found == "pyramid: 1"));
}

#[test]
fn references_to_vertices_that_are_not_there_are_refused() {
    let msh = replaced(ONE_TET, "2 5 1 4 2", "2 5 1 4 6");
    let vtk = replaced(ONE_TET_VTK, "4 0 2 3 4", "4 0 2 3 6");
    let vtu = replaced(ONE_TET_VTU, "0 1 2 3<", "0 1 2 6<");
    for (name, text) in [
        ("unknown.msh", msh),
        ("unknown.vtk", vtk),
        ("unknown.vtu", vtu),
    ] {
        let error = error_of(name, &text);
        let expected = matches!(
            error,
            FileError::UnknownVertex {
                tet: 0,
                vertex: 6,
                ..
            }
        );
        assert!(expected, "{error:?}");
    }
}

#[test]
fn two_nodes_of_one_tag_are_refused() {
    let error = error_of(
        "twice.msh",
        &replaced(ONE_TET, "1\n4\n2\n1 0 0", "1\n4\n5\n1 0 0"),
    );
    assert!(
        matches!(error, FileError::RepeatedTag { tag: 5, .. }),
        "{error:?}"
    );
    let error = error_of(
        "twice.msh",
        &replaced(ONE_TET, "1\n4\n2\n1 0 0", "1\n4\n4\n1 0 0"),
    );
    assert!(
        matches!(error, FileError::RepeatedTag { tag: 4, .. }),
        "{error:?}"
    );
}

#[test]
fn numbers_that_make_no_mesh_are_refused_with_the_cause() {
    let flat = replaced(ONE_TET, "0 0 1\n$EndNodes", "1 1 0\n$EndNodes");
    let error = error_of("numbers.msh", &flat);
    assert!(matches!(
        error,
        FileError::Mesh {
            source: MeshError::ZeroVolume { .. },
            ..
        }
    ));
    let error = error_of("numbers.vtu", &replaced(ONE_TET_VTU, "0 0 1<", "0 0 nan<"));
    assert!(matches!(
        error,
        FileError::Mesh {
            source: MeshError::NonFiniteCoordinate { .. },
            ..
        }
    ));
}

#[test]
fn legacy_files_that_go_on_where_they_should_end_are_refused() {
    let text = format!("{ONE_TET_VTK}GLOBAL_IDS ids long\n");
    assert_damaged("rest.vtk", &text, "5 numbers cannot be in the last 0 bytes");
    let text = format!("{ONE_TET_VTK}LOCAL_IDS ids long\n1 2 3 4 5");
    assert_damaged("rest.vtk", &text, "expected a keyword");
}

#[test]
fn cells_that_do_not_have_their_corners_are_refused() {
    let three = replaced(
        ONE_TET_VTK,
        "CELLS 2 9\n3 0 2 3\n4 0 2 3 4",
        "CELLS 2 8\n3 0 2 3\n3 0 2 3",
    );
    let missing = replaced(ONE_TET_VTK, "4 0 2 3 4", "9 0 2 3 4");
    assert_damaged(
        "corners.vtk",
        &three,
        "cell 1 of type 10 cannot have 3 vertices",
    );
    assert_damaged("corners.vtk", &missing, "cell 1 cannot have 9 vertices");
    let backwards = replaced(ONE_TET_VTU, ">10<", ">10 10<");
    let backwards = replaced(&backwards, ">4<", ">9 4<");
    let backwards = replaced(&backwards, "NumberOfCells=\"1\"", "NumberOfCells=\"2\"");
    assert_damaged(
        "corners.vtu",
        &backwards,
        "cell 0 cannot end at 9 in a list of 4",
    );
}

#[test]
fn variants_of_vtk_that_are_not_supported_are_refused() {
    let with_attribute = |attribute: &str| {
        replaced(
            ONE_TET_VTU,
            "version=\"0.1\"",
            &format!("version=\"0.1\" {attribute}"),
        )
    };
    for (name, text) in [
        (
            "variant.vtu",
            with_attribute("compressor=\"vtkLZ4DataCompressor\""),
        ),
        ("variant.vtu", with_attribute("header_type=\"Float64\"")),
    ] {
        let error = error_of(name, &text);
        assert!(matches!(error, FileError::Unsupported { .. }), "{error:?}");
    }
    let poly_data = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 double\n";
    for (name, text) in [
        ("surface.vtk", poly_data.to_string()),
        (
            "surface.vtu",
            ONE_TET_VTU.replace("UnstructuredGrid", "PolyData"),
        ),
    ] {
        let error = error_of(name, &text);
        assert!(matches!(error, FileError::HoldsSurface { .. }), "{error:?}");
    }
}

#[test]
fn lengths_that_cannot_be_are_refused_before_anything_is_allocated() {
    let points = "format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1<";
    let with_points = |content: &str| {
        let text = replaced(
            ONE_TET_VTU,
            points,
            &format!("format=\"binary\">{content}<"),
        );
        replaced(
            &text,
            "version=\"0.1\"",
            "version=\"0.1\" compressor=\"vtkZLibDataCompressor\"",
        )
    };
    // The number of blocks, the lengths of a block and of the last block, and the compressed length, without any data.
    let huge = with_points("AgAAAP///////////////w==");
    assert_damaged("lengths.vtu", &huge, "the data are shorter");
    // The header claims a million bytes from one existing byte.
    let bomb = with_points("AQAAAEBCDwBAQg8AAQAAAA==AA==");
    assert_damaged("lengths.vtu", &bomb, "125000 numbers, but 12 are needed");
    for (content, words) in [
        ("", "the data are shorter"),
        ("AAAA", "the data are shorter"),
        (
            "AAAAAAAAAAAAAAAA",
            "there are 0 coordinates of points, but 12 are needed",
        ),
        ("AQAAAAAAAAAAAAAAAAAAAA==", "Truncated input stream"),
    ] {
        assert_damaged("lengths.vtu", &with_points(content), words);
    }
    let uncompressed = replaced(ONE_TET_VTU, points, "format=\"binary\">AAA=<");
    assert_damaged("lengths.vtu", &uncompressed, "the data are shorter");
    let start = ONE_TET_VTU.find("<Points>").unwrap();
    let end = ONE_TET_VTU.find("<Cells>").unwrap();
    let without_points = [&ONE_TET_VTU[..start], &ONE_TET_VTU[end..]].concat();
    assert_damaged("lengths.vtu", &without_points, "<Piece> has no <Points>");
}

#[test]
fn entries_beyond_the_stated_number_are_refused() {
    let medit = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n";
    assert!(read_bytes("exact.mesh", medit.as_bytes()).is_ok());
    let more = [
        replaced(medit, "0 0 1 0\n", "0 0 1 0\n5 5 5 0\n"),
        replaced(medit, "1 2 3 4 0\n", "1 2 3 4 0\n2 1 4 3 0\n"),
    ];
    for text in more {
        assert_damaged("more.mesh", &text, "expected a keyword");
    }
    let (nodes, tets) = (
        "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n",
        "1 4 0\n0 0 1 2 3\n",
    );
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"));
    let of = |nodes: &str, tets: &str| {
        std::fs::write(folder.join("more.ele"), tets).unwrap();
        read_bytes("more.node", nodes.as_bytes())
    };
    assert!(of(nodes, &format!("{tets}# the end\n")).is_ok());
    let more_nodes = of(&format!("{nodes}4 5 5 5\n"), tets).unwrap_err();
    let more_tets = of(nodes, &format!("{tets}1 1 0 3 2\n")).unwrap_err();
    for (error, count) in [(more_nodes, 4), (more_tets, 1)] {
        let cause = error.source().unwrap().to_string();
        let expected = format!("the end of the file after {count} entries");
        assert!(cause.contains(&expected), "{cause}");
    }
}

#[test]
fn errors_name_the_reader_of_binary_meshes_of_mujoco() {
    let counts = [4_u32, 0, 4, 4];
    let mut bytes: Vec<u8> = counts
        .iter()
        .flat_map(|count| count.to_le_bytes())
        .collect();
    bytes.resize(16 + 4 * (12 + 8 + 12), 0);
    let error = read_bytes("mujoco.msh", &bytes).unwrap_err();
    assert!(matches!(error, FileError::HoldsSurface { .. }), "{error:?}");
    assert!(error.to_string().contains("read_triangles"), "{error}");
}

#[test]
fn abaqus_parts_without_displacements_are_read() {
    let part = |name: &str, first: i64| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| first + k);
        format!(
            "*PART, NAME={name}\n*NODE\n{a},{first},0,0\n{b},{b},0,0\n{c},{first},1,0\n{d},{first},0,1\n*ELEMENT, TYPE=C3D4\n{a},{a},{b},{c},{d}\n"
        )
    };
    let instances =
        "*INSTANCE, NAME=A, PART=P\n*END INSTANCE\n*INSTANCE, NAME=B, PART=Q\n*END INSTANCE\n";
    let text = format!("{}{}{instances}", part("P", 1), part("Q", 5));
    let mesh = read_bytes("parts.inp", text.as_bytes()).unwrap().mesh;
    assert_eq!(mesh.tet_count(), 2);
}

#[test]
fn abaqus_nodes_in_the_plane_are_refused() {
    for node in ["1, 0.5, 2", "1, 0.5, 2,"] {
        let text = format!("*NODE\n{node}\n*ELEMENT, TYPE=CPS3\n1,1,1,1\n");
        assert_damaged("plane.inp", &text, "line 2, \"1, 0.5, 2");
        assert_damaged(
            "plane.inp",
            &text,
            "two-dimensional models have no tetrahedra",
        );
    }
}

#[test]
fn abaqus_keywords_that_make_or_move_nodes_are_refused() {
    let nodes = "*NODE\n1, 0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n";
    let model = format!("{nodes}*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n");
    let instance = "*INSTANCE, NAME=A, PART=P\n5., 0., 0.\n*END INSTANCE\n";
    let one = format!("{model}{instance}");
    assert!(read_bytes("one.inp", one.as_bytes()).is_ok());
    for (text, expected) in [
        (format!("{one}{instance}"), "more than one *INSTANCE"),
        (
            format!(
                "{model}*Instance, name=A, part=P\n*End Instance\n*Instance, name=B, Part = p\n"
            ),
            "more than one *INSTANCE of the part P",
        ),
        (
            format!("*SYSTEM\n10,0,0\n{model}"),
            "*SYSTEM cannot be read",
        ),
        (format!("{model}*NGEN\n1,3,1\n"), "*NGEN cannot be read"),
        (format!("{model}*Elgen\n1,3,1,1\n"), "*ELGEN cannot be read"),
        (
            format!("*INCLUDE, INPUT=a.inp\n{model}"),
            "*INCLUDE cannot be read",
        ),
        (
            replaced(&model, "*NODE", "*NODE, INPUT=a.inp"),
            "INPUT=A.INP cannot be read",
        ),
        (
            replaced(&model, "*NODE", "*NODE, SYSTEM=C"),
            "SYSTEM=C cannot be read",
        ),
    ] {
        assert_damaged("moved.inp", &text, expected);
    }
}

#[test]
fn encoded_arrays_longer_than_their_points_are_refused_before_they_are_decoded() {
    let array = "<PointData><DataArray type=\"Float64\" Name=\"a\" format=\"binary\">QAAAAA==</DataArray></PointData>";
    let text = replaced(ONE_TET_VTU, "<Points>", &format!("{array}<Points>"));
    assert_damaged("long.vtu", &text, "there are 8 numbers, but 4 are needed");
    let commented = replaced(ONE_TET_VTU, "1 0 0 0 1 0", "1 0 <!-- a comment --> 0 0 1 0");
    assert!(read_bytes("commented.vtu", commented.as_bytes()).is_ok());
}
