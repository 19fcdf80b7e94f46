//! Files of contact surfaces, written and read back.

use crate::support::worlds::{cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, ContactSurface};
use hydroelastic::io::{FileError, write_surface};
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use std::path::Path;
use vtkio::model::{Attribute, DataSet, Piece, PolyDataPiece, VertexNumbers};

fn touching() -> ContactSurface {
    let ball = icosphere(0.1, 2);
    let block = cuboid([0.4, 0.4, 0.2]);
    let tilt = Vector3::new(0.1, 0.2, 0.3);
    let on_top = Pose::from_rotation_vector(&tilt, Vector3::new(0.01, 0.02, 0.19));
    let a = ContactBody::new(&ball, on_top, 1e5).unwrap();
    let b = ContactBody::new(&block, Pose::identity(), 1e6).unwrap();
    ContactPair::new(a, b).surface()
}

/// Writes the surface and reads it with vtkio.
fn written(name: &str, surface: &ContactSurface) -> PolyDataPiece {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    write_surface(&path, surface).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let vtk = match path.extension().unwrap().to_ascii_lowercase().to_str() {
        Some("vtp") => vtkio::Vtk::parse_xml(bytes.as_slice()).unwrap(),
        _ => vtkio::Vtk::parse_legacy_be(bytes.as_slice()).unwrap(),
    };
    let DataSet::PolyData { mut pieces, .. } = vtk.data else {
        panic!("{name} is not PolyData");
    };
    let Some(Piece::Inline(piece)) = pieces.pop() else {
        panic!("{name} has no data");
    };
    *piece
}

/// Returns the numbers of the array with this name.
fn values(attributes: &[Attribute], name: &str) -> Vec<f64> {
    let named = attributes.iter().find_map(|attribute| match attribute {
        Attribute::DataArray(array) if array.name == name => array.data.cast_into(),
        _ => None,
    });
    named.unwrap_or_else(|| panic!("{name} is missing"))
}

/// Returns the corner indices of each polygon.
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
