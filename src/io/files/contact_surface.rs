use super::{FileError, atomic_write::atomic_write, extension::known_extension};
use crate::contact::ContactSurface;
use base64::{Engine, prelude::BASE64_STANDARD};
use nalgebra::Vector3;
use std::io::Write;
use std::path::Path;

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
    let arrays = Arrays::of(surface);
    let bytes = match known_extension(path, EXTENSIONS)? {
        "vtk" => arrays.legacy(),
        _ => arrays.xml().into_bytes(),
    };
    atomic_write(path, |file| file.write_all(&bytes))
}

/// Arrays of the file of a contact surface.
struct Arrays {
    points: Vec<f64>,
    corner_pressures: Vec<f64>,
    pressures: Vec<f64>,
    areas: Vec<f64>,
    normals: Vec<f64>,
    corner_counts: Vec<u32>,
}

impl Arrays {
    fn of(surface: &ContactSurface) -> Self {
        let polygons = &surface.polygons;
        let corners = || polygons.iter().flat_map(|p| p.outline.corners());
        let corner_pressures = polygons.iter().flat_map(|polygon| {
            let corners = polygon.outline.corners().iter();
            corners.map(|corner| polygon.pressure_at(corner))
        });
        let counts = polygons
            .iter()
            .map(|p| u32::try_from(p.outline.corners().len()));
        Self {
            points: components(corners()),
            corner_pressures: corner_pressures.collect(),
            pressures: polygons.iter().map(|p| p.pressure).collect(),
            areas: polygons.iter().map(|p| p.area).collect(),
            normals: components(polygons.iter().map(|p| &p.normal)),
            corner_counts: counts.map(Result::unwrap_or_default).collect(),
        }
    }

    fn legacy(&self) -> Vec<u8> {
        let (point_count, count) = (self.corner_pressures.len(), self.corner_counts.len());
        let mut bytes = Vec::new();
        let mut add = |head: &str, body: Vec<u8>| {
            bytes.extend(head.as_bytes());
            bytes.extend(body);
            bytes.extend(b"\n");
        };
        let reals = |values: &[f64]| {
            values
                .iter()
                .flat_map(|value| value.to_be_bytes())
                .collect()
        };
        let title = "# vtk DataFile Version 3.0\ncontact surface\nBINARY\nDATASET POLYDATA";
        add(
            &format!("{title}\nPOINTS {point_count} double\n"),
            reals(&self.points),
        );
        // VTK rejects an empty list of polygons.
        if count > 0 {
            let mut corners = 0..;
            let lists = self.corner_counts.iter().flat_map(|&count| {
                let corners = corners.by_ref().take(count as usize);
                [count].into_iter().chain(corners).collect::<Vec<u32>>()
            });
            let lists = lists.flat_map(u32::to_be_bytes).collect();
            add(
                &format!("POLYGONS {count} {}\n", count + point_count),
                lists,
            );
        }
        let scalars = |name: &str| format!("SCALARS {name} double 1\nLOOKUP_TABLE default\n");
        let head = format!("POINT_DATA {point_count}\n{}", scalars("pressure"));
        add(&head, reals(&self.corner_pressures));
        let head = format!("CELL_DATA {count}\n{}", scalars("pressure"));
        add(&head, reals(&self.pressures));
        add(&scalars("area"), reals(&self.areas));
        add("VECTORS normal double\n", reals(&self.normals));
        bytes
    }

    fn xml(&self) -> String {
        let (point_count, count) = (self.corner_pressures.len(), self.corner_counts.len());
        let ends = self.corner_counts.iter().scan(0, |end, &count| {
            *end += u64::from(count);
            Some(*end)
        });
        let head = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\"";
        let rest = "NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\"";
        let reals = |name, components, values: &[f64]| {
            let words = values.iter().map(|value| value.to_le_bytes());
            array("Float64", name, components, words)
        };
        [
            &*format!("{head} header_type=\"UInt64\"><PolyData>\n"),
            &format!("<Piece NumberOfPoints=\"{point_count}\" {rest} NumberOfPolys=\"{count}\">\n"),
            "<PointData Scalars=\"pressure\">",
            &reals("pressure", 1, &self.corner_pressures),
            "</PointData>\n<CellData Scalars=\"pressure\" Normals=\"normal\">",
            &reals("pressure", 1, &self.pressures),
            &reals("area", 1, &self.areas),
            &reals("normal", 3, &self.normals),
            "</CellData>\n<Points>",
            &reals("Points", 3, &self.points),
            "</Points>\n<Polys>",
            &array(
                "Int64",
                "connectivity",
                1,
                (0..point_count as u64).map(u64::to_le_bytes),
            ),
            &array("Int64", "offsets", 1, ends.map(u64::to_le_bytes)),
            "</Polys>\n</Piece></PolyData></VTKFile>\n",
        ]
        .concat()
    }
}

/// Data array of little-endian numbers, which follow their length.
fn array(
    kind: &str,
    name: &str,
    components: usize,
    words: impl Iterator<Item = [u8; 8]>,
) -> String {
    let bytes: Vec<u8> = words.flatten().collect();
    let length = (bytes.len() as u64).to_le_bytes();
    let code = BASE64_STANDARD.encode([&length[..], &bytes].concat());
    format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">{code}</DataArray>"
    )
}

fn components<'a>(vectors: impl Iterator<Item = &'a Vector3<f64>>) -> Vec<f64> {
    vectors.flat_map(|v| v.iter().copied()).collect()
}
