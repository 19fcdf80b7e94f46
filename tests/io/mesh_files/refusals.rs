//! Mesh files that are rejected, each with an error that names the invalid or unsupported part.

use super::sample_files::{ONE_TET, ONE_TET_VTK, read_bytes, replaced};
use hydroelastic::io::{FileError, read_mesh};
use hydroelastic::mesh::MeshError;

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

#[test]
fn extensions_count_in_upper_case_too_and_others_are_refused() {
    assert!(read_bytes("UPPER.MSH", ONE_TET.as_bytes()).is_ok());
    for name in ["mesh.stl", "mesh", "msh"] {
        let error = read_mesh(name).unwrap_err();
        assert!(
            matches!(error, FileError::UnknownExtension { .. }),
            "{error:?}"
        );
    }
    let error = read_mesh("there_is_no_such_file.msh").unwrap_err();
    assert!(matches!(error, FileError::Read { .. }));
}

#[test]
fn gmsh_files_of_other_versions_are_refused() {
    let old = replaced(ONE_TET, "4.1 0 8", "2.2 0 8");
    let error = error_of("version.msh", &old);
    assert!(matches!(&error, FileError::Unsupported { found, .. } if found.contains("2.2 0 8")));
    // mshio would panic.
    for header in ["4.1 0 99999999999999", "4.1 1 5", "4.1 0"] {
        let error = error_of("version.msh", &replaced(ONE_TET, "4.1 0 8", header));
        assert!(matches!(error, FileError::Unsupported { .. }), "{error:?}");
    }
}

#[test]
fn empty_sections_are_too_short() {
    // mshio would panic.
    for (from, to) in [("2 5 1 5", "0 0 1 1"), ("2 2 1 2", "0 00 1 1")] {
        let error = error_of("empty.msh", &replaced(ONE_TET, from, to));
        assert!(
            matches!(error, FileError::TooShort { found: 0, .. }),
            "{error:?}"
        );
    }
    let error = error_of("empty.msh", &ONE_TET[..ONE_TET.find("5 1 5").unwrap()]);
    assert!(matches!(error, FileError::TooShort { .. }), "{error:?}");
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
    assert!(matches!(error, FileError::OtherSolid { found, .. } if found == "Pyr5"));
    let error = error_of("solid.vtk", &replaced(ONE_TET_VTK, "5\n10\n", "5\n14\n"));
    assert!(matches!(error, FileError::OtherSolid { found, .. } if found == "Pyramid"));
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
        matches!(error, FileError::TooShort { found: 2, .. }),
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
    let error = error_of("rest.vtk", &format!("{ONE_TET_VTK}GLOBAL_IDS ids long\n"));
    assert!(matches!(error, FileError::Unread { found, .. } if found == "GLOBAL_IDS ids long"));
}

#[test]
fn cells_that_do_not_have_their_corners_are_too_short() {
    let three = replaced(
        ONE_TET_VTK,
        "CELLS 2 9\n3 0 2 3\n4 0 2 3 4",
        "CELLS 2 8\n3 0 2 3\n3 0 2 3",
    );
    let missing = replaced(ONE_TET_VTK, "4 0 2 3 4", "9 0 2 3 4");
    for text in [three, missing] {
        let error = error_of("corners.vtk", &text);
        assert!(matches!(error, FileError::TooShort { .. }), "{error:?}");
    }
    let backwards = replaced(ONE_TET_VTU, ">10<", ">10 10<");
    let backwards = replaced(&backwards, ">4<", ">9 4<");
    let backwards = replaced(&backwards, "NumberOfCells=\"1\"", "NumberOfCells=\"2\"");
    let error = error_of("corners.vtu", &backwards);
    assert!(matches!(error, FileError::TooShort { .. }), "{error:?}");
}

#[test]
fn variants_of_vtk_that_are_not_supported_are_refused() {
    let poly_data = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 double\n";
    let piece = &ONE_TET_VTU[ONE_TET_VTU.find("<Piece").unwrap()..];
    let piece = &piece[..piece.find("</UnstructuredGrid>").unwrap()];
    let raw = "</UnstructuredGrid><AppendedData encoding=\"raw\">_\0<&</AppendedData>";
    let appended = "</UnstructuredGrid><AppendedData encoding=\"base64\">_AAAA</AppendedData>";
    let with_attribute = |attribute: &str| {
        replaced(
            ONE_TET_VTU,
            "version=\"0.1\"",
            &format!("version=\"0.1\" {attribute}"),
        )
    };
    for (name, text) in [
        ("variant.vtk", poly_data.to_string()),
        (
            "variant.vtu",
            replaced(ONE_TET_VTU, piece, &format!("{piece}{piece}")),
        ),
        (
            "variant.vtu",
            replaced(ONE_TET_VTU, "</UnstructuredGrid>", appended),
        ),
        (
            "variant.vtu",
            replaced(ONE_TET_VTU, "</UnstructuredGrid>", raw),
        ),
        (
            "variant.vtu",
            with_attribute("compressor=\"vtkLZ4DataCompressor\""),
        ),
        ("variant.vtu", with_attribute("header_type=\"Float64\"")),
        (
            "variant.vtu",
            ONE_TET_VTU.replace("UnstructuredGrid", "PolyData"),
        ),
    ] {
        let error = error_of(name, &text);
        assert!(matches!(error, FileError::Unsupported { .. }), "{error:?}");
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
    assert!(matches!(
        error_of("lengths.vtu", &huge),
        FileError::TooShort { .. }
    ));
    // The header claims a million bytes from one existing byte.
    let bomb = with_points("AQAAAEBCDwBAQg8AAQAAAA==AA==");
    let error = error_of("lengths.vtu", &bomb);
    assert!(
        matches!(
            error,
            FileError::TooLong {
                found: 1_000_000,
                limit: 1032,
                ..
            }
        ),
        "{error:?}"
    );
    for content in ["", "AAAA", "AAAAAAAAAAAAAAAA", "AQAAAAAAAAAAAAAAAAAAAA=="] {
        let error = error_of("lengths.vtu", &with_points(content));
        assert!(matches!(error, FileError::TooShort { .. }), "{error:?}");
    }
    let uncompressed = replaced(ONE_TET_VTU, points, "format=\"binary\">AAA=<");
    assert!(matches!(
        error_of("lengths.vtu", &uncompressed),
        FileError::TooShort { .. }
    ));
    let connectivity = "Name=\"connectivity\" NumberOfComponents=\"2\"";
    let two = replaced(ONE_TET_VTU, "Name=\"connectivity\"", connectivity);
    assert!(matches!(
        error_of("lengths.vtu", &two),
        FileError::TooLong { .. }
    ));
    let start = ONE_TET_VTU.find("<Points>").unwrap();
    let end = ONE_TET_VTU.find("<Cells>").unwrap();
    let without_points = [&ONE_TET_VTU[..start], &ONE_TET_VTU[end..]].concat();
    assert!(matches!(
        error_of("lengths.vtu", &without_points),
        FileError::TooShort { .. }
    ));
}
