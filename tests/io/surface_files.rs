//! Files of contact surfaces, written and read back.

use crate::support::worlds::{cuboid, icosphere};
use base64::{Engine, prelude::BASE64_STANDARD};
use hydroelastic::contact::{ContactBody, ContactPair, ContactSurface};
use hydroelastic::io::{FileError, write_surface};
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use roxmltree::Document;
use std::collections::HashMap;
use std::path::Path;

fn touching() -> ContactSurface {
    let ball = icosphere(0.1, 2);
    let block = cuboid([0.4, 0.4, 0.2]);
    let tilt = Vector3::new(0.1, 0.2, 0.3);
    let on_top = Pose::from_rotation_vector(&tilt, Vector3::new(0.01, 0.02, 0.19));
    let a = ContactBody::new(&ball, on_top, 1e5).unwrap();
    let b = ContactBody::new(&block, Pose::identity(), 1e6).unwrap();
    ContactPair::new(a, b).surface()
}

/// Numbers of a file of polygons.
#[derive(Default)]
struct PolyData {
    points: Vec<f64>,
    polygons: Vec<Vec<usize>>,
    /// Arrays by the name of their group and their own name.
    arrays: HashMap<(String, String), Vec<f64>>,
}

/// Writes the surface and reads it back with readers of this test.
fn written(name: &str, surface: &ContactSurface) -> PolyData {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    write_surface(&path, surface).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    match path.extension().unwrap().to_ascii_lowercase().to_str() {
        Some("vtp") => xml(std::str::from_utf8(&bytes).unwrap()),
        _ => legacy(&bytes),
    }
}

fn xml(text: &str) -> PolyData {
    let document = Document::parse(text).unwrap();
    let mut data = PolyData::default();
    let (mut ends, mut corners) = (Vec::new(), Vec::new());
    for array in document
        .descendants()
        .filter(|node| node.has_tag_name("DataArray"))
    {
        let bytes = BASE64_STANDARD.decode(array.text().unwrap()).unwrap();
        let (length, bytes) = bytes.split_first_chunk().unwrap();
        assert_eq!(u64::from_le_bytes(*length), bytes.len() as u64);
        let group = array.parent().unwrap().tag_name().name();
        let name = array.attribute("Name").unwrap();
        let numbers = bytes.as_chunks().0.iter();
        let wholes = || {
            numbers
                .clone()
                .map(|&bytes| usize::try_from(u64::from_le_bytes(bytes)).unwrap())
        };
        let reals = || {
            numbers
                .clone()
                .map(|&bytes| f64::from_le_bytes(bytes))
                .collect()
        };
        match (group, name) {
            ("Points", _) => data.points = reals(),
            ("Polys", "connectivity") => corners = wholes().collect(),
            ("Polys", _) => ends = wholes().collect(),
            _ => drop(data.arrays.insert((group.into(), name.into()), reals())),
        }
    }
    let starts = [0].into_iter().chain(ends.iter().copied());
    data.polygons = starts
        .zip(&ends)
        .map(|(start, &end)| corners[start..end].to_vec())
        .collect();
    data
}

fn legacy(mut bytes: &[u8]) -> PolyData {
    let mut data = PolyData::default();
    let (mut group, mut count) = (String::new(), 0);
    while let Some(end) = bytes.iter().position(|&byte| byte == b'\n') {
        let line = std::str::from_utf8(&bytes[..end]).unwrap();
        bytes = &bytes[end + 1..];
        let mut reals = |count: usize| -> Vec<f64> {
            let (numbers, rest) = bytes.split_at(8 * count);
            bytes = rest.strip_prefix(b"\n").unwrap();
            numbers
                .as_chunks()
                .0
                .iter()
                .map(|&bytes| f64::from_be_bytes(bytes))
                .collect()
        };
        let number = |word: &str| word.parse::<usize>().unwrap();
        match line.split(' ').collect::<Vec<_>>()[..] {
            ["POINTS", points, "double"] => data.points = reals(3 * number(points)),
            ["POLYGONS", _, length] => {
                let (numbers, rest) = bytes.split_at(4 * number(length));
                bytes = rest.strip_prefix(b"\n").unwrap();
                let numbers = numbers
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&bytes| u32::from_be_bytes(bytes) as usize);
                let numbers: Vec<_> = numbers.collect();
                let mut list = &numbers[..];
                while let Some((&count, rest)) = list.split_first() {
                    data.polygons.push(rest[..count].to_vec());
                    list = &rest[count..];
                }
            }
            ["POINT_DATA", points] => (group, count) = ("PointData".into(), number(points)),
            ["CELL_DATA", cells] => (group, count) = ("CellData".into(), number(cells)),
            ["SCALARS", name, "double", "1"] => {
                bytes = bytes.strip_prefix(b"LOOKUP_TABLE default\n").unwrap();
                let (numbers, rest) = bytes.split_at(8 * count);
                bytes = rest.strip_prefix(b"\n").unwrap();
                let numbers = numbers
                    .as_chunks()
                    .0
                    .iter()
                    .map(|&bytes| f64::from_be_bytes(bytes));
                data.arrays
                    .insert((group.clone(), name.into()), numbers.collect());
            }
            ["VECTORS", name, "double"] => drop(
                data.arrays
                    .insert((group.clone(), name.into()), reals(3 * count)),
            ),
            _ => {}
        }
    }
    data
}

#[test]
fn a_written_surface_reads_back_with_its_polygons_and_pressures() {
    let surface = touching();
    assert!(surface.polygons.len() > 20, "{}", surface.polygons.len());
    for name in ["surface.vtk", "surface.vtp", "SURFACE.VTP"] {
        let PolyData {
            points,
            polygons: read,
            arrays,
        } = written(name, &surface);
        let array = |group: &str, name: &str| arrays[&(group.into(), name.into())].clone();
        let corner_pressures = array("PointData", "pressure");
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
        let cell = |name| array("CellData", name);
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
        let data = written(name, &surface);
        assert!(data.polygons.is_empty() && data.points.is_empty());
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
