//! Surfaces in VTK unstructured grids.

use hydroelastic::io::{
    FileError, MeshOptions, Placement, read_mesh, read_triangle_surface, read_triangles,
};
use std::error::Error;
use std::path::{Path, PathBuf};

/// A type of cells of VTK, and vertices.
type Cell<'a> = (u8, &'a [usize]);

const POINTS: &str = "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1";

/// A cube of quadrilaterals, a pixel, triangles, a polygon and a strip, with a point and a line.
const CUBE: [Cell; 9] = [
    (1, &[0]),
    (9, &[3, 2, 1, 0]),
    (8, &[4, 5, 7, 6]),
    (3, &[0, 6]),
    (5, &[0, 1, 5]),
    (5, &[0, 5, 4]),
    (7, &[1, 2, 6, 5]),
    (6, &[2, 3, 6, 7]),
    (9, &[3, 0, 4, 7]),
];

fn words(numbers: impl IntoIterator<Item = usize>) -> String {
    let words = numbers.into_iter().map(|number| format!("{number} "));
    words.collect()
}

/// Writes cells as a legacy file and as an XML file.
fn written(name: &str, cells: &[Cell]) -> [PathBuf; 2] {
    let (count, lists) = (cells.len(), || cells.iter().map(|cell| cell.1));
    let counted = lists().flat_map(|list| [&[list.len()], list].concat());
    let counted: Vec<usize> = counted.collect();
    let types = words(cells.iter().map(|cell| cell.0.into()));
    let legacy = format!(
        "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n{POINTS}\nCELLS {count} {}\n{}\nCELL_TYPES {count}\n{types}\n",
        counted.len(),
        words(counted.iter().copied())
    );
    let ends = lists().scan(0, |end, list| {
        *end += list.len();
        Some(*end)
    });
    let array = |name: &str, text: &str| {
        format!("<DataArray type=\"Float64\" Name=\"{name}\" format=\"ascii\">{text}</DataArray>")
    };
    let xml = format!(
        "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"8\" NumberOfCells=\"{count}\"><Points>{}</Points>\
         <Cells>{}{}{}</Cells></Piece></UnstructuredGrid></VTKFile>",
        array("points", POINTS),
        array("connectivity", &words(lists().flatten().copied())),
        array("offsets", &words(ends)),
        array("types", &types),
    );
    [("vtk", legacy), ("vtu", xml)].map(|(extension, text)| {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.{extension}"));
        std::fs::write(&path, text).unwrap();
        path
    })
}

#[test]
fn faces_of_unstructured_grids_are_surfaces() {
    for path in written("faces", &CUBE) {
        let cube = read_triangle_surface(&path, &Placement::default()).unwrap();
        assert_eq!((cube.vertices().len(), cube.triangles().len()), (8, 12));
        assert!((cube.volume() - 1.0).abs() < 1e-15);
        let error = read_mesh(&path, &MeshOptions::default()).unwrap_err();
        assert!(matches!(error, FileError::HoldsSurface { .. }), "{error:?}");
    }
}

#[test]
fn grids_of_faces_and_solids_are_not_read_as_surfaces() {
    let with_tet = [&CUBE[..], &[(10, &[0, 1, 3, 4])]].concat();
    for path in written("faces_and_solid", &with_tet) {
        let error = read_triangles(&path, &Placement::default()).unwrap_err();
        assert!(matches!(error, FileError::HoldsGrid { .. }), "{error:?}");
        let mesh = read_mesh(&path, &MeshOptions::default()).unwrap().mesh;
        assert_eq!(mesh.tet_count(), 1);
    }
}

#[test]
fn wrong_faces_of_grids_are_located_errors() {
    let cases: [(Cell, &str); 4] = [
        (
            (22, &[0, 1, 2, 3, 4, 5]),
            "cell 9: type 22 with 6 vertices is not a triangle",
        ),
        ((200, &[0]), "cell 9: type 200 with 1 vertices"),
        ((8, &[0, 1, 2]), "cell 9: type 8 with 3 vertices"),
        (
            (5, &[0, 1, 8]),
            "cell 9: vertex 8 is not one of the 8 vertices",
        ),
    ];
    for (cell, expected) in cases {
        for path in written("wrong_faces", &[&CUBE[..], &[cell]].concat()) {
            let error = read_triangles(&path, &Placement::default()).unwrap_err();
            let cause = error.source().unwrap().to_string();
            assert!(cause.contains(expected), "{cause}");
        }
    }
}
