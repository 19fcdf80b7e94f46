//! Mesh files in all formats, sound and damaged, and the files of contact surfaces.

use hydroelastic::contact::{ContactBody, ContactPair, ContactSurface, Shape};
use hydroelastic::io::{FileError, MeshFile, read_mesh, write_surface};
use hydroelastic::mesh::{MeshError, PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use vtkio::model::{Attribute, DataSet, Piece, PolyDataPiece, VertexNumbers};

/// Meshes of the bracket as Gmsh wrote them.
const PLAIN: [&str; 4] = [
    "bracket.msh",
    "bracket_binary.msh",
    "bracket.vtk",
    "bracket_binary.vtk",
];

/// Meshes of the bracket with extents, as meshio wrote them; the first one has all digits.
const WITH_EXTENTS: [&str; 5] = [
    "bracket_extents_binary.vtk",
    "bracket_extents.vtk",
    "bracket_extents_zlib.vtu",
    "bracket_extents_binary.vtu",
    "bracket_extents.vtu",
];

/// Numbers in the ASCII files have 12 (meshio's .vtu) to 17 digits.
const ASCII_DIGITS: f64 = 1e-11;

/// One tetrahedron and a node that it does not use, in tags that are dense but out of order.
const ONE_TET: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
    $Nodes\n2 5 1 5\n2 1 0 2\n5\n3\n0 0 0\n9 9 9\n3 1 0 3\n1\n4\n2\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n\
    $Elements\n2 2 1 2\n2 1 2 1\n1 5 1 4\n3 1 4 1\n2 5 1 4 2\n$EndElements\n";

const ONE_TET_VTK: &str = "# vtk DataFile Version 3.0\none\nASCII\nDATASET UNSTRUCTURED_GRID\n\
    POINTS 5 double\n0 0 0\n9 9 9\n1 0 0\n0 1 0\n0 0 1\nCELLS 2 9\n3 0 2 3\n4 0 2 3 4\nCELL_TYPES 2\n5\n10\n\
    POINT_DATA 5\nSCALARS depth double 1\nLOOKUP_TABLE default\n0 1 2 3 4\nVECTORS at double\n\
    0 0 0 9 9 9 1 0 0 0 1 0 0 0 1\n";

const ONE_TET_VTU: &str = "<?xml version=\"1.0\"?>\
    <VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\
    <UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\
    <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\
    0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>\
    <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray>\
    <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4</DataArray>\
    <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells>\
    </Piece></UnstructuredGrid></VTKFile>";

fn path_of(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes_from_mesher");
    folder.join(name)
}

fn bracket(name: &str) -> MeshFile {
    read_mesh(path_of(name)).unwrap_or_else(|error| panic!("{error}: {error:?}"))
}

/// Reads the bytes as a file of that name; each test uses names of its own.
fn read_bytes(name: &str, bytes: &[u8]) -> Result<MeshFile, FileError> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, bytes).unwrap();
    read_mesh(path)
}

fn error_of(name: &str, text: &str) -> FileError {
    read_bytes(name, text.as_bytes()).unwrap_err()
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from} is not in the text");
    text.replacen(from, to, 1)
}

fn assert_same_mesh(one: &MeshFile, other: &MeshFile) {
    assert_eq!(one.mesh.tets(), other.mesh.tets());
    assert_eq!(one.mesh.vertex_count(), other.mesh.vertex_count());
    for (a, b) in one.mesh.vertices().iter().zip(other.mesh.vertices()) {
        assert!((a - b).amax() < ASCII_DIGITS);
    }
    assert!((one.mesh.volume() / other.mesh.volume() - 1.0).abs() < 100.0 * ASCII_DIGITS);
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
    // Foot and arm; the hole is a polygon inside its circle.
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
        // The vectors that are also in the file are no extents.
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
        // The node with the tag 3 belongs to no tetrahedron.
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
    // Blocks, length of a block and of the last one, compressed length; then no data.
    let huge = with_points("AgAAAP///////////////w==");
    assert!(matches!(
        error_of("lengths.vtu", &huge),
        FileError::TooShort { .. }
    ));
    // A million bytes from the one that is there.
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

/// The first bytes, those from the end, and some between.
fn places(count: usize, at_ends: usize) -> impl Iterator<Item = usize> {
    let inner = (at_ends..count - at_ends).step_by(count / 97);
    (0..at_ends).chain(inner).chain(count - at_ends..count)
}

#[test]
fn truncated_files_are_refused_or_lack_only_what_is_not_the_mesh() {
    for name in PLAIN.iter().chain(&WITH_EXTENTS) {
        let whole = bracket(name).mesh;
        let bytes = std::fs::read(path_of(name)).unwrap();
        // Not the last two bytes: the last 10 of an ASCII file would become a 1.
        for length in places(bytes.len() - 2, 100) {
            if let Ok(file) = read_bytes(&format!("truncated_{name}"), &bytes[..length]) {
                let same = file.mesh.tets() == whole.tets();
                assert!(
                    same && file.mesh.vertices() == whole.vertices(),
                    "{name}: {length} bytes"
                );
            }
        }
    }
}

#[test]
fn files_with_wrong_bytes_never_panic() {
    for name in PLAIN.iter().chain(&WITH_EXTENTS) {
        let bytes = std::fs::read(path_of(name)).unwrap();
        for place in places(bytes.len(), 100) {
            for wrong in [b'0', b'<', 0xff, bytes[place] ^ 1] {
                let mut damaged = bytes.clone();
                damaged[place] = wrong;
                // Some still hold a mesh, if another one; none is empty.
                let file = read_bytes(&format!("damaged_{name}"), &damaged);
                assert!(file.is_err() || file.unwrap().mesh.tet_count() > 0);
            }
        }
    }
}

fn touching() -> ContactSurface {
    let ball = Shape::new(shapes::icosphere(0.1, 2).unwrap());
    let block = Shape::new(shapes::cuboid([0.4, 0.4, 0.2]).unwrap());
    let tilt = Vector3::new(0.1, 0.2, 0.3);
    let on_top = Pose::from_rotation_vector(&tilt, Vector3::new(0.01, 0.02, 0.19));
    let a = ContactBody::new(&ball, on_top, 1e5).unwrap();
    let b = ContactBody::new(&block, Pose::identity(), 1e6).unwrap();
    ContactPair::new(a, b).surface()
}

/// Writes the surface, and reads it again with vtkio.
fn written(name: &str, surface: &ContactSurface) -> PolyDataPiece {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    write_surface(&path, surface).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let vtk = match path.extension().unwrap().to_ascii_lowercase().to_str() {
        Some("vtp") => vtkio::Vtk::parse_xml(bytes.as_slice()).unwrap(),
        _ => vtkio::Vtk::parse_legacy_be(bytes.as_slice()).unwrap(),
    };
    let DataSet::PolyData { mut pieces, .. } = vtk.data else {
        panic!("{name} is no PolyData");
    };
    let Some(Piece::Inline(piece)) = pieces.pop() else {
        panic!("{name} has no data");
    };
    *piece
}

/// The numbers of the array of that name.
fn values(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let named = attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.cast_into(),
        _ => None,
    });
    named.unwrap_or_else(|| panic!("there is no {name}"))
}

/// The indices of the corners of each polygon.
fn polygons(piece: &PolyDataPiece) -> Vec<Vec<usize>> {
    let (connectivity, ends) = match piece.polys.clone().unwrap_or_default() {
        numbers @ VertexNumbers::Legacy { .. } => numbers.into_xml(),
        VertexNumbers::XML {
            connectivity,
            offsets,
        } => (connectivity, offsets),
    };
    let starts = [0].into_iter().chain(ends.iter().copied());
    let index = |number: &u64| usize::try_from(*number).unwrap();
    let ranges = starts
        .zip(&ends)
        .map(|(start, end)| index(&start)..index(end));
    ranges
        .map(|range| connectivity[range].iter().map(index).collect())
        .collect()
}

#[test]
fn a_written_surface_reads_back_with_its_polygons_and_pressures() {
    let surface = touching();
    assert!(surface.polygons.len() > 20, "{}", surface.polygons.len());
    for name in ["surface.vtk", "surface.vtp", "SURFACE.VTP"] {
        let piece = written(name, &surface);
        let points: Vec<f64> = piece.points.cast_into().unwrap();
        let corner_pressures = values(&piece.data.point, "pressure");
        let read = polygons(&piece);
        assert_eq!(read.len(), surface.polygons.len());
        assert_eq!(points.len(), 3 * corner_pressures.len());
        for (polygon, corners) in surface.polygons.iter().zip(&read) {
            assert_eq!(corners.len(), polygon.outline.corners().len());
            for (&point, corner) in corners.iter().zip(polygon.outline.corners()) {
                assert_eq!(points[3 * point..3 * point + 3], *corner.as_slice());
                let pressure = polygon.pressure_at(corner);
                assert_eq!(corner_pressures[point].to_bits(), pressure.to_bits());
            }
        }
        let cell = |name| values(&piece.data.cell, name);
        let of_each = |f: fn(&hydroelastic::contact::ContactPolygon) -> f64| {
            surface.polygons.iter().map(f).collect::<Vec<f64>>()
        };
        assert_eq!(cell("pressure"), of_each(|polygon| polygon.pressure));
        assert_eq!(cell("area"), of_each(|polygon| polygon.area));
        let normals = surface
            .polygons
            .iter()
            .flat_map(|p| p.normal.iter().copied());
        assert_eq!(cell("normal"), normals.collect::<Vec<f64>>());
    }
}

#[test]
fn an_empty_surface_makes_a_file_without_polygons() {
    let surface = ContactSurface {
        polygons: Vec::new(),
    };
    for name in ["empty.vtk", "empty.vtp"] {
        let piece = written(name, &surface);
        assert!(polygons(&piece).is_empty());
        assert!(piece.points.is_empty());
    }
}

#[test]
fn a_surface_goes_to_no_other_format_and_to_no_missing_folder() {
    let surface = touching();
    let error = write_surface("surface.vtu", &surface).unwrap_err();
    assert!(matches!(error, FileError::UnknownExtension { found, .. } if found == "vtu"));
    let missing = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_folder/surface.vtk");
    let error = write_surface(missing, &surface).unwrap_err();
    assert!(matches!(error, FileError::Write { .. }));
}
