//! Reader of PLY files (Stanford), in text and in binary of either byte order: vertices and faces. Other elements and properties are
//! skipped.

use super::FileError;
use super::polygons::add_polygon;
use super::scalar::{ByteOrder, Scalar};
use super::scene::strip;
use super::text_lines::{TextFile, number, words};
use crate::mesh::TriangleSoup;
use nalgebra::Vector3;
use std::path::Path;

struct Property {
    name: Vec<u8>,
    /// Type of the length of a list, or `None` for a single number.
    length: Option<Scalar>,
    number: Scalar,
}

struct Element {
    name: Vec<u8>,
    count: usize,
    properties: Vec<Property>,
}

pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, FileError> {
    let file = TextFile {
        path,
        format: "PLY",
        bytes,
    };
    let (binary, elements, rest) = header(file)?;
    let mut body = Body { file, binary, rest };
    let mut soup = TriangleSoup::default();
    for element in elements
        .iter()
        .filter(|element| !element.properties.is_empty())
    {
        for _ in 0..element.count {
            match &element.name[..] {
                b"vertex" => soup.vertices.push(body.vertex(element)?),
                _ => body.face(element, &mut soup)?,
            }
        }
    }
    Ok(soup)
}

/// Order of the bytes of binary numbers, or `None` if numbers are text.
type Binary = Option<ByteOrder>;

/// Encoding, elements and bytes after the header.
fn header(file: TextFile<'_>) -> Result<(Binary, Vec<Element>, &[u8]), FileError> {
    let (mut encoding, mut elements, mut offset) = (None, Vec::<Element>::new(), 0);
    for (index, line) in file.lines().enumerate() {
        offset += line.len();
        let mut all = words(line);
        let first = all.next().unwrap_or_default();
        let rest: Vec<&[u8]> = all.collect();
        let is_known = match (first, &rest[..]) {
            (b"ply", []) => index == 0,
            _ if index == 0 => false,
            (b"format", [name, ..]) => {
                encoding = encoding_of(name);
                encoding.is_some()
            }
            (b"element", &[name, count]) => number(count).is_some_and(|count| {
                let (name, properties) = (name.to_vec(), Vec::new());
                elements.push(Element {
                    name,
                    count,
                    properties,
                });
                true
            }),
            (b"property", words) => property(words).is_some_and(|property| {
                let element = elements.last_mut();
                element
                    .map(|element| element.properties.push(property))
                    .is_some()
            }),
            (b"end_header", []) => {
                let encoding =
                    encoding.ok_or_else(|| file.syntax_error(line, "the format is missing"))?;
                return Ok((encoding, elements, &file.bytes[offset..]));
            }
            (b"comment" | b"obj_info" | b"", _) => true,
            _ => false,
        };
        if !is_known {
            return Err(file.syntax_error(line, "this is not a line of a PLY header"));
        }
    }
    Err(file.syntax_error(
        &file.bytes[file.bytes.len()..],
        "expected the word end_header",
    ))
}

fn encoding_of(name: &[u8]) -> Option<Binary> {
    match name {
        b"ascii" => Some(None),
        b"binary_little_endian" => Some(Some(ByteOrder::Little)),
        b"binary_big_endian" => Some(Some(ByteOrder::Big)),
        _ => None,
    }
}

fn property(words: &[&[u8]]) -> Option<Property> {
    let (length, word, name) = match *words {
        [b"list", length, word, name] => (Some(number_type(length)?), word, name),
        [word, name] => (None, word, name),
        _ => return None,
    };
    Some(Property {
        name: name.to_vec(),
        length,
        number: number_type(word)?,
    })
}

fn number_type(word: &[u8]) -> Option<Scalar> {
    Some(match word {
        b"char" | b"int8" => Scalar::I8,
        b"short" | b"int16" => Scalar::I16,
        b"int" | b"int32" => Scalar::I32,
        b"uchar" | b"uint8" => Scalar::U8,
        b"ushort" | b"uint16" => Scalar::U16,
        b"uint" | b"uint32" => Scalar::U32,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return None,
    })
}

/// The data after the header.
struct Body<'a> {
    file: TextFile<'a>,
    binary: Binary,
    rest: &'a [u8],
}

impl<'a> Body<'a> {
    fn vertex(&mut self, element: &Element) -> Result<Vector3<f64>, FileError> {
        let mut position = Vector3::repeat(f64::NAN);
        let start = self.rest;
        for property in &element.properties {
            let values = self.values(property)?;
            let axis = [b"x", b"y", b"z"]
                .iter()
                .position(|name| property.name == *name);
            if let (Some(axis), &[value]) = (axis, &values[..]) {
                position[axis] = value;
            }
        }
        if position.iter().all(|x| x.is_finite()) {
            return Ok(position);
        }
        Err(self
            .file
            .syntax_error(start, "expected three finite coordinates x, y and z"))
    }

    /// Reads the properties of an element, and adds its faces if it has any.
    fn face(&mut self, element: &Element, soup: &mut TriangleSoup) -> Result<(), FileError> {
        for property in &element.properties {
            let start = self.rest;
            let values = self.values(property)?;
            let is_list = matches!(&property.name[..], b"vertex_indices" | b"vertex_index");
            let added = match &element.name[..] {
                b"face" if is_list => {
                    let corners = corners(&values, soup.vertices.len());
                    corners.and_then(|corners| add_polygon(soup, &corners))
                }
                b"tristrips" if is_list => {
                    values.split(|&value| value < 0.0).try_for_each(|values| {
                        let corners = corners(values, soup.vertices.len())?;
                        soup.triangles.extend(strip(&corners));
                        Ok(())
                    })
                }
                _ => Ok(()),
            };
            added.map_err(|cause| self.file.syntax_error(start, cause))?;
        }
        Ok(())
    }

    /// Reads the number or the list of a property.
    fn values(&mut self, property: &Property) -> Result<Vec<f64>, FileError> {
        let Some(length) = property.length else {
            return Ok(vec![self.number(property.number)?]);
        };
        let start = self.rest;
        let count = self.number(length)?;
        if count < 0.0 || count > self.rest.len() as f64 {
            let cause = format!("a list cannot have {count} entries here");
            return Err(self.file.syntax_error(start, cause));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the number is between zero and the size of the file"
        )]
        let entries = 0..count as usize;
        { entries }.map(|_| self.number(property.number)).collect()
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64, FileError> {
        let value = match self.binary {
            None => self.word().and_then(number),
            Some(order) => self
                .rest
                .split_at_checked(scalar.size)
                .map(|(bytes, rest)| {
                    self.rest = rest;
                    scalar.real(bytes, order)
                }),
        };
        value.ok_or_else(|| self.file.syntax_error(self.rest, "expected a number"))
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let word = words(self.rest).next()?;
        let end = word.as_ptr().addr() - self.rest.as_ptr().addr() + word.len();
        self.rest = &self.rest[end..];
        Some(word)
    }
}

/// Vertex indices of a face.
///
/// # Errors
/// Returns the cause if an index is out of range. The vertices must precede the faces.
fn corners(values: &[f64], vertex_count: usize) -> Result<Vec<usize>, &'static str> {
    let in_range =
        |&value: &f64| value >= 0.0 && value < vertex_count as f64 && value.fract() == 0.0;
    if !values.iter().all(in_range) {
        return Err("the face refers to a vertex that does not precede it");
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the numbers are whole and in range"
    )]
    Ok(values.iter().map(|&value| value as usize).collect())
}
