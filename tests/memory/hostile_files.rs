//! Mesh and surface files that are wrong on purpose. Each is rejected quickly with a message that names the error. Reading needs little
//! more memory than the file, even if its headers claim huge counts.

use hydroelastic::io::{FileError, MeshOptions, Placement, read_mesh, read_triangle_surface};
use std::collections::BTreeSet;
use std::error::Error;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Largest number of simultaneously allocated bytes per byte of the file, and for the smallest file. The tree of an XML file of tags alone
/// (`deep.vtu`) takes 19 bytes per byte. zlib has a window of 32 KiB.
const BYTES_PER_BYTE: usize = 20;
const BYTES: usize = 1 << 18;

/// Time limit for all files together. They took 0.04 s in the last measurement; a loop over 10¹² entries would take hours.
const TIME: Duration = Duration::from_secs(10);

const MESHES: [&str; 6] = ["msh", "vtk", "vtu", "mesh", "inp", "node"];
const SURFACES: [&str; 6] = ["dae", "glb", "obj", "off", "ply", "stl"];

/// Files, and the text in the message or one of its causes besides the name of the file.
const REFUSED: &[(&str, &str)] = &[
    ("cut_in_element.inp", "the last element is incomplete"),
    (
        "cut_in_tets.mesh",
        "4 numbers cannot be in the last 6 bytes",
    ),
    ("empty.mesh", "has no tetrahedra"),
    (
        "most_attributes.node",
        "18446744073709551615 numbers cannot be in the last 25 bytes",
    ),
    ("trillion_nodes.node", "unexpected end of the file"),
    (
        "trillion_vertices.mesh",
        r#""Tetrahedra" is not a valid number"#,
    ),
    ("vertex_zero.mesh", "refers to vertex 0"),
    ("word_for_a_number.inp", r#"line 6, "3, 0, one, 0""#),
    ("appended_offset_beyond_all.vtu", "appended data"),
    (
        "appended_to_nothing.vtu",
        "the offset is beyond the appended data",
    ),
    (
        "billions_of_cell_types.vtk",
        r#"line 13, "10": 4000000000 numbers cannot be in the last 3 bytes"#,
    ),
    (
        "billions_of_cells.vtk",
        "4000000000 numbers cannot be in the last 26 bytes",
    ),
    (
        "billions_of_cells.vtu",
        "there are 1 offsets, but 4000000000 are needed",
    ),
    ("billions_of_field_arrays.vtk", "line 18"),
    ("billions_of_field_numbers.vtk", "line 1"),
    ("billions_of_lookup_entries.vtk", "line 1"),
    (
        "billions_of_points.vtk",
        r#"line 6, "0 0 0": 12000000000 numbers cannot be"#,
    ),
    (
        "billions_of_points.vtu",
        "there are 12 coordinates of points, but 12000000000 are needed",
    ),
    ("billions_of_points_binary.vtk", "line 6"),
    ("billions_of_tensors.vtk", "line 1"),
    (
        "cell_type_beyond_all.vtu",
        "cell 0 has the unknown type 4000",
    ),
    ("corner_twice.msh", "tetrahedron 0 refers"),
    ("cut_in_cells.vtu", "unexpected end of stream"),
    (
        "cut_in_elements.msh",
        "4 numbers cannot be in the last 5 bytes",
    ),
    ("cut_in_points_binary.vtk", "line 6"),
    ("element_for_attribute.vtu", "invalid name token"),
    ("empty.msh", r#"the header """#),
    ("empty.vtk", "line 1"),
    ("empty.vtu", "vtk DataFile Version"),
    (
        "end_beyond_all.vtk",
        "cell 0 cannot end at 9223372036854775807 in a list of 4 vertices",
    ),
    (
        "end_beyond_all.vtu",
        "cell 0 cannot end at 9223372036854775807 in a list of 4 vertices",
    ),
    ("entities.vtu", "XML with DTD detected"),
    ("huge_coordinates.vtk", "tetrahedron 0 has"),
    ("infinite_vertex.vtu", "vertex 3 has the coordinate inf"),
    (
        "infinite_vertex_binary.msh",
        "vertex 0 has the coordinate inf",
    ),
    ("missing_node.msh", "tetrahedron 0 of"),
    ("missing_point.vtk", "tetrahedron 0 of"),
    (
        "most_blocks.msh",
        r#""18446744073709551615" is not a valid number"#,
    ),
    ("most_blocks_zlib.vtu", "a length is not below 2⁶³"),
    ("most_color_numbers.vtk", r#"line 15, "COLOR_SCALARS"#),
    ("most_corners.vtk", "cell 0 cannot have 4294967295 vertices"),
    ("most_field_numbers.vtk", r#"line 16, "a 461168601"#),
    (
        "most_grid_points.vtk",
        "a data set of the kind STRUCTURED_POINTS",
    ),
    ("most_lookup_entries.vtk", r#"line 15, "LOOKUP_TABLE"#),
    ("most_nodes_binary.msh", "line 6"),
    ("most_points.vtk", r#"line 5, "POINTS 1844674407"#),
    ("most_points_binary.vtk", "line 6"),
    ("most_tensor_numbers.vtk", r#"line 15, "TENSORS"#),
    ("most_tets_binary.msh", "line 9"),
    ("nan_vertex.vtk", "vertex 2 has the coordinate NaN"),
    ("nan_vertex_binary.msh", "vertex 0 has the coordinate NaN"),
    ("negative_corner.vtu", "refers to vertex -1"),
    ("negative_count.msh", r#"line 18, "-1"#),
    ("negative_end.vtu", "cell 0 cannot end at -4"),
    ("no_base64.vtu", r#"array "": Invalid symbol"#),
    ("no_cell_types.vtu", r#"<Cells> has no array "types""#),
    ("no_ends.vtk", "there are 0 cells, but 1 types of cells"),
    ("no_zlib_stream.vtu", "Invalid input data"),
    ("not_closed.vtu", "opened but never closed"),
    ("number_beyond_all.msh", r#"line 19, "9999999"#),
    ("tet_twice.msh", "tetrahedra 0 and 1"),
    (
        "too_few_bytes.vtu",
        "104 bytes were expected, but the data are shorter",
    ),
    (
        "trillion_cell_types.vtk",
        r#"line 13, "10": 1000000000000 numbers cannot be"#,
    ),
    (
        "trillion_cells.vtk",
        "5000000000000 numbers cannot be in the last 26 bytes",
    ),
    (
        "trillion_cells.vtu",
        "there are 1 offsets, but 1000000000000 are needed",
    ),
    (
        "trillion_ends.vtk",
        r#"line 12, "0 4": 1000000000000 numbers"#,
    ),
    (
        "trillion_data_set_fields.vtk",
        r#"line 8, "POINTS 4 double": expected an array"#,
    ),
    (
        "trillion_data_set_times.vtk",
        r#"line 7, "0.5": 1000000000000 numbers"#,
    ),
    (
        "trillion_field_arrays.vtk",
        r#"line 18, "": expected an array"#,
    ),
    (
        "trillion_nodes.msh",
        r#"line 7, "1": 1000000000000 numbers"#,
    ),
    (
        "trillion_points.vtk",
        r#"line 6, "0 0 0": 3000000000000 numbers"#,
    ),
    (
        "trillion_points.vtu",
        "there are 12 coordinates of points, but 3000000000000 are needed",
    ),
    ("trillion_tets.msh", r#"line 20, "$EndElemen"#),
    ("unknown_cell_type.vtk", "cell 0 has the unknown type 250"),
    ("unknown_cell_type.vtu", "cell 0 has the unknown type 250"),
    (
        "unknown_element_type.msh",
        "elements of the unknown type 9999",
    ),
    ("word_for_a_number.msh", r#"line 13, "one 0"#),
    ("mujoco_cut.msh", "in 112 bytes, but the file has 111 bytes"),
    (
        "mujoco_infinite_vertex.msh",
        "vertex 3 has the coordinate inf",
    ),
    (
        "mujoco_missing_vertex.msh",
        "triangle 3 refers to vertex 2147483647",
    ),
    ("mujoco_most_triangles.msh", "2147483647 triangles in"),
    ("mujoco_negative_count.msh", "4294967295 triangles in"),
    ("word_for_a_number.vtk", r#"line 11, "two 3"#),
    ("cut_in_facet_ascii.stl", r#"one of ["endloop"]"#),
    (
        "cut_in_triangles.stl",
        "states 4 triangles, but 3 triangles and 30 bytes follow",
    ),
    ("empty.obj", "at least 4 triangles, but 0"),
    ("empty.stl", "needs 84 bytes, but the file has 0"),
    ("fewer_triangles.stl", "states 3 triangles, but 4 triangles"),
    (
        "four_corners_ascii.stl",
        r#"line 7, "vertex 1 1 1": expected one of"#,
    ),
    ("infinite_vertex_ascii.stl", r#"line 5, "vertex 0 1e999 0""#),
    (
        "most_triangles.stl",
        "states 4294967295 triangles, but 4 triangles",
    ),
    ("nan_vertex.obj", r#"line 3, "v 0 nan 0""#),
    ("nan_vertex.stl", "vertex 11 has the coordinate NaN"),
    (
        "zlib_bomb.vtu",
        "there are 1048576 numbers, but 12 are needed",
    ),
    ("three_faces.obj", "at least 4 triangles, but 3"),
    (
        "cut_in_data.glb",
        r#"the chunk "BIN\0" is missing or truncated"#,
    ),
    (
        "cut_in_faces_binary.ply",
        "4 bytes were expected, but 3 are left",
    ),
    ("deep.glb", "recursion limit exceeded"),
    ("empty.dae", "the document does not have a root node"),
    ("empty.glb", "EOF while parsing"),
    ("empty.off", "expected the word OFF"),
    ("empty.ply", "expected the word ply"),
    ("endless_header.ply", "expected a line of a PLY header"),
    ("missing_point.dae", "refers to vertex 9"),
    ("missing_point.off", "their indices below 4"),
    (
        "missing_point.ply",
        "vertex -4 is not one of the 4 vertices",
    ),
    ("missing_view.glb", "a view of a buffer does not exist"),
    (
        "most_corners_binary.ply",
        "vertex 512 is not one of the 4 vertices",
    ),
    ("most_points.glb", "longer than its buffer"),
    ("nan_vertex.off", r#"line 5, "0 nan 0""#),
    ("no_format.ply", "the header has no line"),
    ("node_in_itself.dae", "contains itself"),
    ("node_in_itself.glb", "contains itself"),
    ("not_closed.dae", "root node was opened but never closed"),
    ("offset_beyond_all.dae", "at least 4 triangles, but 0"),
    ("trillion_corners.off", "their indices below 4"),
    (
        "trillion_corners.ply",
        "1000000000000 numbers cannot be in the last 31 bytes",
    ),
    ("trillion_points.glb", "longer than its buffer"),
    ("trillion_points.off", "expected a vertex"),
    ("trillion_points.ply", "unexpected end of the file"),
    ("view_beyond_all.glb", "longer than its buffer"),
    (
        "vertex_before_all.obj",
        "is not the index of one of the 4 vertices",
    ),
    (
        "vertex_beyond_all.obj",
        "is not the index of one of the 4 vertices",
    ),
];

/// Files that contain a tetrahedron or its surface: the valid originals of the other files, and files whose oddities do not concern the mesh.
const ACCEPTED: &[&str] = &[
    "deep.vtu",
    "sound.inp",
    "sound.mesh",
    "sound.node",
    "most_components.vtu",
    "trillion_points.msh",
    "sound.msh",
    "sound_binary.msh",
    "mujoco.msh",
    "sound.vtk",
    "sound_5_1.vtk",
    "sound_binary.vtk",
    "sound.vtu",
    "sound_binary.vtu",
    "sound.stl",
    "sound_ascii.stl",
    "sound.obj",
    "sound.dae",
    "sound.glb",
    "sound.off",
    "sound.ply",
    "sound_binary.ply",
    "endless_face.obj",
    "trillion_empty_elements.ply",
    "texture_before_all.obj",
];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile_files")
}

/// Returns the message of an error and of all its causes.
fn messages(error: &dyn Error) -> String {
    let (mut text, mut next) = (error.to_string(), error.source());
    while let Some(cause) = next {
        text = format!("{text}: {cause}");
        next = cause.source();
    }
    text
}

/// Returns the number of tetrahedra in a mesh file, or of components in a surface file.
fn counted(path: &Path) -> Result<usize, FileError> {
    let is_mujoco = path
        .file_stem()
        .unwrap()
        .to_str()
        .unwrap()
        .starts_with("mujoco");
    if is_mujoco
        || SURFACES
            .map(OsStr::new)
            .contains(&path.extension().unwrap())
    {
        return Ok(read_triangle_surface(path, &Placement::default())?.component_count());
    }
    Ok(read_mesh(path, &MeshOptions::default())?.mesh.tet_count())
}

/// Reads a file and returns its count, or messages without the folder's name. Asserts that reading used no more memory than allowed.
fn read(name: &str) -> Result<usize, String> {
    let path = folder().join(name);
    let length = usize::try_from(fs::metadata(&path).unwrap().len()).unwrap();
    let profiler = dhat::Profiler::builder().testing().build();
    let outcome = counted(&path);
    let most = dhat::HeapStats::get().max_bytes;
    drop(profiler);
    let due = BYTES + BYTES_PER_BYTE * length;
    assert!(most <= due, "{name} of {length} bytes took {most}");
    let folder = format!("{}/", folder().display());
    outcome.map_err(|error| messages(&error).replace(&folder, ""))
}

/// Returns the names of the mesh and surface files in the folder.
fn files() -> BTreeSet<String> {
    let entries = fs::read_dir(folder()).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let meshes = paths.filter(|path| {
        let extension = path.extension().unwrap();
        let mut known = MESHES.iter().chain(&SURFACES);
        known.any(|known| OsStr::new(known) == extension)
    });
    meshes
        .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned())
        .collect()
}

#[test]
fn hostile_files_are_refused_by_name_at_once_and_without_the_memory_they_claim() {
    let _alone = crate::alone();
    let start = Instant::now();
    let mut wrong = Vec::new();
    for (name, culprit) in REFUSED {
        let outcome = read(name);
        let named = |message: &String| message.contains(name) && message.contains(culprit);
        if !outcome.as_ref().is_err_and(named) {
            wrong.push(format!("{name}: {outcome:?}, but {culprit:?} was expected"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    for name in ACCEPTED {
        assert_eq!(read(name), Ok(1), "{name}");
    }
    assert!(start.elapsed() < TIME, "{:?}", start.elapsed());
    let listed = REFUSED
        .iter()
        .map(|(name, _)| *name)
        .chain(ACCEPTED.iter().copied());
    assert_eq!(files(), listed.map(ToOwned::to_owned).collect());
}
