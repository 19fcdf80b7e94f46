//! Reader of PLY files (Stanford), in text and in binary of either byte order: vertices and faces, in any order. Other elements and
//! properties are skipped.

use super::FileError;
use super::cursor::Cursor;
use super::polygons::add_polygon;
use super::scalar::{ByteOrder, Scalar};
use super::scene::strip;
use crate::mesh::TriangleSoup;
use nalgebra::Vector3;
use std::path::Path;

/// Error message for a line that is not part of a PLY header.
const HEADER_LINES: &str = "expected a line of a PLY header: \"format\" with ascii, binary_little_endian or binary_big_endian, \
    \"element\" with a name and a count, \"property\" with a known type and a name, \"comment\" or \"end_header\"";

struct Property<'a> {
    name: &'a str,
    /// Type of the length of a list.
    length: Option<Scalar>,
    number: Scalar,
}

struct Element<'a> {
    name: &'a str,
    count: usize,
    properties: Vec<Property<'a>>,
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let mut cursor = Cursor::new(path, "PLY", bytes);
    let mut elements = header(&mut cursor)?;
    elements.retain(|element| !element.properties.is_empty());
    let is_vertex = |element: &Element| element.name == "vertex";
    let vertex_end = elements
        .iter()
        .rposition(is_vertex)
        .map_or(0, |last| last + 1);
    let (mut soup, mut faces) = (TriangleSoup::default(), Vec::new());
    for element in &elements[..vertex_end] {
        if !is_vertex(element) {
            faces.push((cursor, element));
        }
        for _ in 0..element.count {
            if is_vertex(element) {
                soup.vertices.push(vertex(&mut cursor, element)?);
            } else {
                skip(&mut cursor, element)?;
            }
        }
    }
    for (mut cursor, element) in faces {
        read_faces(&mut cursor, element, &mut soup)?;
    }
    for element in &elements[vertex_end..] {
        read_faces(&mut cursor, element, &mut soup)?;
    }
    Ok(soup)
}

fn skip(cursor: &mut Cursor, element: &Element) -> Result<(), FileError> {
    let mut properties = element.properties.iter();
    properties.try_for_each(|property| values(cursor, property).map(drop))
}

/// Reads the encoding and the elements.
fn header<'a>(cursor: &mut Cursor<'a>) -> Result<Vec<Element<'a>>, FileError> {
    let (start, mut has_format, mut elements) = (*cursor, false, Vec::<Element>::new());
    if cursor.line_words() != ["ply"] {
        return Err(start.error("expected the word ply"));
    }
    while !cursor.is_at_end() {
        let start = *cursor;
        let is_known = match *cursor.line_words() {
            ["end_header"] if has_format => return Ok(elements),
            ["end_header"] => {
                let cause = "the header has no line \"format\": expected \"format ascii 1.0\" or a binary format before \"end_header\"";
                return Err(start.error(cause));
            }
            ["format", name, ..] => {
                cursor.binary = byte_order(name);
                has_format = name == "ascii" || cursor.binary.is_some();
                has_format
            }
            ["element", name, count] => count.parse().is_ok_and(|count| {
                let properties = Vec::new();
                elements.push(Element {
                    name,
                    count,
                    properties,
                });
                true
            }),
            ["property", ref words @ ..] => match (elements.last_mut(), property(words)) {
                (Some(element), Some(property)) => {
                    element.properties.push(property);
                    true
                }
                _ => false,
            },
            ["comment" | "obj_info", ..] | [] => true,
            _ => false,
        };
        if !is_known {
            return Err(start.error(HEADER_LINES));
        }
    }
    Err(cursor.error("expected the word end_header"))
}

/// Returns the order of the bytes in a binary format.
fn byte_order(format: &str) -> Option<ByteOrder> {
    match format {
        "binary_little_endian" => Some(ByteOrder::Little),
        "binary_big_endian" => Some(ByteOrder::Big),
        _ => None,
    }
}

fn property<'a>(words: &[&'a str]) -> Option<Property<'a>> {
    let (length, number, name) = match *words {
        ["list", length, number, name] => (Some(Scalar::named(length)?), number, name),
        [number, name] => (None, number, name),
        _ => return None,
    };
    Some(Property {
        name,
        length,
        number: Scalar::named(number)?,
    })
}

fn vertex(cursor: &mut Cursor, element: &Element) -> Result<Vector3<f64>, FileError> {
    let (start, mut position) = (*cursor, Vector3::repeat(f64::NAN));
    for property in &element.properties {
        let values = values(cursor, property)?;
        let axis = ["x", "y", "z"]
            .iter()
            .position(|&axis| axis == property.name);
        if let (Some(axis), &[value]) = (axis, &values[..]) {
            position[axis] = value;
        }
    }
    if position.iter().all(|x| x.is_finite()) {
        return Ok(position);
    }
    Err(start.error("expected three finite coordinates x, y and z"))
}

/// Reads all entries of an element, and adds their faces if they have any.
fn read_faces(
    cursor: &mut Cursor,
    element: &Element,
    soup: &mut TriangleSoup,
) -> Result<(), FileError> {
    let properties = (0..element.count).flat_map(|_| &element.properties);
    for property in properties {
        let start = *cursor;
        let values = values(cursor, property)?;
        let is_list = matches!(property.name, "vertex_indices" | "vertex_index");
        let added = match element.name {
            "face" if is_list => {
                let corners = corners(&values, soup.vertices.len());
                corners.and_then(|corners| Ok(add_polygon(soup, &corners)?))
            }
            "tristrips" if is_list => values.split(|&value| value < 0.0).try_for_each(|values| {
                let corners = corners(values, soup.vertices.len())?;
                soup.triangles.extend(strip(&corners));
                Ok(())
            }),
            _ => Ok(()),
        };
        added.map_err(|cause| start.error(cause))?;
    }
    Ok(())
}

/// Reads the number or the list of a property.
fn values(cursor: &mut Cursor, property: &Property) -> Result<Vec<f64>, FileError> {
    let count = property.length.map(|length| cursor.count(length));
    cursor.reals(property.number, count.transpose()?.unwrap_or(1))
}

/// Vertex indices of a face.
///
/// # Errors
/// Returns the cause if an index is out of range.
fn corners(values: &[f64], vertex_count: usize) -> Result<Vec<usize>, String> {
    let in_range =
        |&value: &f64| value >= 0.0 && value < vertex_count as f64 && value.fract() == 0.0;
    if let Some(vertex) = values.iter().find(|value| !in_range(value)) {
        return Err(format!(
            "vertex {vertex} is not one of the {vertex_count} vertices"
        ));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the numbers are whole and in range"
    )]
    Ok(values.iter().map(|&value| value as usize).collect())
}
