use super::{FileError, atomic_write::atomic_write, extension::known_extension};
use crate::contact::{ContactPolygon, ContactSurface};
use nalgebra::Vector3;
use std::io::Write;
use std::path::Path;
use vtkio::Vtk;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, DataArray, DataSet, PolyDataPiece, Version, VertexNumbers,
};

/// Extensions of contact-surface files.
const EXTENSIONS: &[&str] = &["vtk", "vtp"];

/// Writes a contact surface (m, world frame) as VTK PolyData. The extension of the file name selects the format: `.vtk` (legacy,
/// binary) or `.vtp` (XML).
///
/// Each contact polygon is a cell. Cells share no points. The point data is `pressure` (Pa). The cell data are `pressure` (mean,
/// Pa), `area` (m²) and `normal` (out of B into A).
///
/// An existing file is replaced atomically.
///
/// # Errors
/// - If the extension is not `.vtk` or `.vtp`.
/// - If the file cannot be written.
pub fn write_surface(path: impl AsRef<Path>, surface: &ContactSurface) -> Result<(), FileError> {
    let path = path.as_ref();
    let mut bytes = Vec::new();
    let written = match known_extension(path, EXTENSIONS)? {
        "vtk" => vtk(surface).write_legacy(&mut bytes),
        _ => vtk(surface)
            .write_xml(&mut bytes)
            .inspect(|()| add_zero_counts(&mut bytes)),
    };
    atomic_write(path, |file| {
        written?;
        file.write_all(&bytes)
    })
}

/// Adds the counts of an empty surface, which vtkio omits, but which VTK requires.
fn add_zero_counts(xml: &mut Vec<u8>) {
    let text = String::from_utf8_lossy(xml);
    let with_counts = "<Piece NumberOfPoints=\"0\" NumberOfPolys=\"0\">";
    *xml = text.replacen("<Piece>", with_counts, 1).into_bytes();
}

fn vtk(surface: &ContactSurface) -> Vtk {
    let polygons = &surface.polygons;
    let corners = || polygons.iter().flat_map(|p| p.outline.corners());
    let corner_pressures = polygons.iter().flat_map(|polygon| {
        let corners = polygon.outline.corners().iter();
        corners.map(|corner| polygon.pressure_at(corner))
    });
    Vtk {
        version: Version::new_legacy(3, 0),
        title: "contact surface".into(),
        byte_order: ByteOrder::BigEndian,
        file_path: None,
        data: DataSet::inline(PolyDataPiece {
            points: components(corners()).into(),
            // VTK rejects a legacy file with an empty list of polygons.
            polys: (!surface.is_empty()).then(|| cells(polygons)),
            data: Attributes {
                point: vec![scalars("pressure", corner_pressures)],
                cell: vec![
                    scalars("pressure", polygons.iter().map(|p| p.pressure)),
                    scalars("area", polygons.iter().map(|p| p.area)),
                    vectors("normal", polygons.iter().map(|p| &p.normal)),
                ],
            },
            ..PolyDataPiece::default()
        }),
    }
}

/// Cells of the polygons, whose points are consecutive.
fn cells(polygons: &[ContactPolygon]) -> VertexNumbers {
    let counts = polygons.iter().map(|p| p.outline.corners().len() as u64);
    let offsets: Vec<u64> = counts
        .scan(0, |end, count| {
            *end += count;
            Some(*end)
        })
        .collect();
    VertexNumbers::XML {
        connectivity: (0..offsets.last().copied().unwrap_or(0)).collect(),
        offsets,
    }
}

fn scalars(name: &str, values: impl Iterator<Item = f64>) -> Attribute {
    let values: Vec<f64> = values.collect();
    Attribute::DataArray(DataArray::scalars(name, 1).with_vec(values))
}

fn vectors<'a>(name: &str, values: impl Iterator<Item = &'a Vector3<f64>>) -> Attribute {
    Attribute::DataArray(DataArray::vectors(name).with_vec(components(values)))
}

fn components<'a>(vectors: impl Iterator<Item = &'a Vector3<f64>>) -> Vec<f64> {
    vectors.flat_map(|v| v.iter().copied()).collect()
}
