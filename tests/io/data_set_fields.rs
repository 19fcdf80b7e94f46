//! Fields of the whole data set before the points of a legacy VTK file, as written by VTK and ParaView, do not affect the mesh.

use hydroelastic::io::{FileError, MeshOptions, read_mesh};
use std::error::Error;
use std::fs;
use std::path::Path;

/// Fields before the points.
const ASCII: &[u8] = b"FIELD FieldData 2\nTimeValue 1 1 double\n0.25\nis%20old 1 3 bit\n0 1 1\n\n";

/// The fields in binary. The bytes of the number contain a line ending.
const BINARY: &[u8] =
    b"FIELD FieldData 2\nTimeValue 1 1 double\n\n\n\n\n\n\n\n\n\nis%20old 1 3 bit\n`\n\n";

/// Returns a file of the mesher with these bytes before the points.
fn with_fields(name: &str, fields: &[u8]) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes_from_mesher");
    let bytes = fs::read(folder.join(name)).unwrap();
    let is_points = |window: &[u8]| window == b"POINTS";
    let points = bytes.windows(6).position(is_points).unwrap();
    [&bytes[..points], fields, &bytes[points..]].concat()
}

fn vertices(name: &str, bytes: &[u8]) -> Result<Vec<[f64; 3]>, FileError> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).unwrap();
    let file = read_mesh(&path, &MeshOptions::default())?;
    Ok(file.mesh.vertices().iter().map(|&v| v.into()).collect())
}

#[test]
fn fields_of_the_data_set_are_passed_over() {
    for (name, fields) in [("bracket.vtk", ASCII), ("bracket_binary.vtk", BINARY)] {
        let plain = vertices(&format!("plain_{name}"), &with_fields(name, b"")).unwrap();
        let read = vertices(&format!("fields_{name}"), &with_fields(name, fields)).unwrap();
        assert_eq!(read, plain);
    }
}

#[test]
fn errors_behind_them_name_their_line() {
    let text = String::from_utf8(with_fields("bracket.vtk", ASCII)).unwrap();
    let damaged = text.replace("CELLS", "SMELLS");
    let line = 1 + damaged
        .lines()
        .position(|line| line.starts_with("SMELLS"))
        .unwrap();
    let error = vertices("damaged_behind_fields.vtk", damaged.as_bytes()).unwrap_err();
    let told = error.source().unwrap().to_string();
    assert!(told.starts_with(&format!("line {line},")), "{told}");
}
