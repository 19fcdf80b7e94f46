//! Reader of VTK XML files. The data of an array is text, inline base64, or appended to the document as base64 or raw bytes. It may be
//! compressed with zlib.

use super::FileError;
use super::scalar::{ByteOrder, Scalar};
use super::text_lines::xml_words;
use super::vtk_data_set::{DataSet, Lists, POLYGON, STRIP};
use super::vtk_encoding::{Encoding, Stream};
use roxmltree::{Document, Node};
use std::borrow::Cow;
use std::cell::Cell;
use std::path::Path;
use std::str::FromStr;

/// Number of numbers that the arrays of a file may have for each byte of the file, and for the smallest file. Arrays can share data, and
/// data can be compressed, so that a small file can have many numbers.
const NUMBERS_PER_BYTE: usize = 16;
const EXTRA_COUNT: usize = 1 << 22;

/// Reads an XML file.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<DataSet, FileError> {
    type Cause = Box<dyn std::error::Error + Send + Sync>;
    let syntax_error = |source: Cause| FileError::syntax(path, "VTK XML", source);
    let (text, appended) = split_appended(bytes);
    let text = std::str::from_utf8(&text).map_err(|error| syntax_error(error.into()))?;
    let document = Document::parse(text).map_err(|error| syntax_error(error.into()))?;
    let root = document.root_element();
    let reader = Reader::new(root, appended, bytes.len()).map_err(|(found, expected)| {
        FileError::Unsupported {
            path: path.into(),
            found,
            expected,
        }
    })?;
    reader
        .data_set(root)
        .map_err(|cause| syntax_error(cause.into()))
}

/// Splits a file into the document, without the appended data, and the appended data after their first character `_`. Raw data
/// are not XML.
fn split_appended(bytes: &[u8]) -> (Cow<'_, [u8]>, &[u8]) {
    const TAG: &[u8] = b"<AppendedData";
    let position = |bytes: &[u8], byte: u8| bytes.iter().position(|&other| other == byte);
    let start = bytes.windows(TAG.len()).position(|window| window == TAG);
    let end = start.and_then(|start| Some(start + position(&bytes[start..], b'>')? + 1));
    let Some(end) = end else {
        return (bytes.into(), &[]);
    };
    let data = position(&bytes[end..], b'_').map_or(&[][..], |first| &bytes[end + first + 1..]);
    let closed = [&bytes[..end], b"</AppendedData></VTKFile>"].concat();
    (closed.into(), data)
}

/// Reader of the arrays of a document.
struct Reader<'a> {
    encoding: Encoding,
    appended: Stream<'a>,
    /// Number of numbers that may still be decoded.
    remaining: Cell<usize>,
}

impl<'a> Reader<'a> {
    /// Reads the attributes of a file of this size (bytes).
    ///
    /// # Errors
    /// Returns the unsupported variant and the supported ones.
    fn new(root: Node, appended: &'a [u8], size: usize) -> Result<Self, (String, &'static str)> {
        let is_second = |name, [first, second]: [&str; 2], expected| match root.attribute(name) {
            None => Ok(false),
            Some(found) if found == first => Ok(false),
            Some(found) if found == second => Ok(true),
            Some(found) => Err((format!("{name}={found:?}"), expected)),
        };
        let orders = ["LittleEndian", "BigEndian"];
        let is_big = is_second("byte_order", orders, "LittleEndian and BigEndian")?;
        let is_wide = is_second("header_type", ["UInt32", "UInt64"], "UInt32 and UInt64")?;
        let compressors = ["", "vtkZLibDataCompressor"];
        let is_compressed = is_second("compressor", compressors, "vtkZLibDataCompressor")?;
        let kinds = ["UnstructuredGrid", "PolyData"];
        is_second("type", kinds, "the data sets UnstructuredGrid and PolyData")?;
        let data = root
            .children()
            .find(|node| node.has_tag_name("AppendedData"));
        Ok(Self {
            encoding: Encoding {
                order: if is_big {
                    ByteOrder::Big
                } else {
                    ByteOrder::Little
                },
                header: if is_wide { Scalar::U64 } else { Scalar::U32 },
                is_compressed,
            },
            appended: Stream {
                bytes: appended,
                is_base64: data.and_then(|node| node.attribute("encoding")) != Some("raw"),
            },
            remaining: Cell::new(
                size.saturating_mul(NUMBERS_PER_BYTE)
                    .saturating_add(EXTRA_COUNT),
            ),
        })
    }

    /// Reads the pieces of a data set.
    fn data_set(&self, root: Node) -> Result<DataSet, String> {
        let kind = root.attribute("type").unwrap_or_default();
        let set = child(root, kind)?;
        let mut data = DataSet {
            is_poly_data: kind == "PolyData",
            ..DataSet::default()
        };
        for piece in set.children().filter(|node| node.has_tag_name("Piece")) {
            let first_vertex = i64::try_from(data.points.len() / 3).unwrap_or(i64::MAX);
            let points = child(child(piece, "Points")?, "DataArray")?;
            let point_count = count(piece, "NumberOfPoints")?;
            let expected = point_count.saturating_mul(3);
            let points = self.reals(points, expected)?;
            check_count("coordinates of points", points.len(), expected)?;
            data.points.extend(points);
            if data.is_poly_data {
                let polygons = self.lists(piece, "Polys", "NumberOfPolys")?;
                data.add_cells(&polygons, first_vertex, POLYGON);
                let strips = self.lists(piece, "Strips", "NumberOfStrips")?;
                data.add_cells(&strips, first_vertex, STRIP);
            } else {
                let cells = self.lists(piece, "Cells", "NumberOfCells")?;
                let types = self.integers(named(child(piece, "Cells")?, "types")?, cells.len())?;
                check_count("types of cells", types.len(), cells.len())?;
                data.cells.append(&cells, first_vertex);
                data.types.extend(types);
            }
            let arrays = piece
                .children()
                .filter(|node| node.has_tag_name("PointData"));
            for array in arrays.flat_map(|node| node.children()) {
                let is_scalar = matches!(array.attribute("NumberOfComponents"), None | Some("1"));
                if let Some(name) = array.attribute("Name")
                    && is_scalar
                    && array.attribute("type") != Some("String")
                {
                    let values = data.point_data.entry(name.into()).or_default();
                    values.extend(self.reals(array, point_count)?);
                }
            }
        }
        Ok(data)
    }

    /// Reads lists of vertices. They may be missing if their number is zero.
    fn lists(&self, piece: Node, tag: &str, counted: &str) -> Result<Lists, String> {
        let expected = match piece.attribute(counted) {
            None if tag != "Cells" => 0,
            _ => count(piece, counted)?,
        };
        if expected == 0 {
            return Ok(Lists::default());
        }
        let lists = child(piece, tag)?;
        let ends = self.integers(named(lists, "offsets")?, expected)?;
        check_count("offsets", ends.len(), expected)?;
        let count = ends
            .last()
            .map_or(0, |&end| usize::try_from(end).unwrap_or(0));
        Lists::from_ends(self.integers(named(lists, "connectivity")?, count)?, &ends)
    }

    fn reals(&self, array: Node, limit: usize) -> Result<Vec<f64>, String> {
        let order = self.encoding.order;
        let number = |scalar: Scalar, bytes: &[u8]| Some(scalar.real(bytes, order));
        let numbers = self.numbers(array, limit, number);
        numbers.map_err(|cause| in_array(array, &cause))
    }

    fn integers(&self, array: Node, limit: usize) -> Result<Vec<i64>, String> {
        let order = self.encoding.order;
        let number = |scalar: Scalar, bytes: &[u8]| scalar.integer(bytes, order);
        let numbers = self.numbers(array, limit, number);
        numbers.map_err(|cause| in_array(array, &cause))
    }

    /// Checks the number of numbers of an encoded array, before memory is allocated for them.
    fn check_encoded(&self, count: usize, limit: usize) -> Result<(), String> {
        if count > limit {
            return Err(format!("there are {count} numbers, but {limit} are needed"));
        }
        let remaining = self.remaining.get().checked_sub(count);
        let cause = "the arrays of the file share or compress more numbers than can be read";
        self.remaining.set(remaining.ok_or(cause)?);
        Ok(())
    }

    /// Reads the numbers of an array. An encoded array may have up to `limit` numbers.
    fn numbers<T: FromStr>(
        &self,
        array: Node,
        limit: usize,
        number: impl Fn(Scalar, &[u8]) -> Option<T>,
    ) -> Result<Vec<T>, String> {
        let words = xml_words(array);
        let inline: String;
        let stream = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => {
                let invalid = |word| format!("{word:?} is not a valid number");
                return words
                    .map(|word| word.parse().map_err(|_| invalid(word)))
                    .collect();
            }
            "binary" => {
                inline = words.collect();
                let (bytes, is_base64) = (inline.as_bytes(), true);
                Stream { bytes, is_base64 }
            }
            "appended" => {
                let bytes = self.appended.bytes.get(count(array, "offset")?..);
                let bytes = bytes.ok_or("the offset is beyond the appended data")?;
                Stream {
                    bytes,
                    ..self.appended
                }
            }
            found => return Err(format!("the format {found:?} is unknown")),
        };
        let kind = array.attribute("type").unwrap_or_default();
        let scalar = Scalar::named(kind).ok_or_else(|| format!("the type {kind:?} is unknown"))?;
        let check = |length: usize| self.check_encoded(length / scalar.size, limit);
        let bytes = self.encoding.decoded(stream, check)?;
        check_count("bytes after the last number", bytes.len() % scalar.size, 0)?;
        let numbers = bytes
            .chunks_exact(scalar.size)
            .map(|bytes| number(scalar, bytes));
        let numbers: Option<_> = numbers.collect();
        numbers.ok_or_else(|| "expected integers below 2⁶³".into())
    }
}

fn in_array(array: Node, cause: &str) -> String {
    let name = array.attribute("Name").unwrap_or_default();
    format!("array {name:?}: {cause}")
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Result<Node<'a, 'i>, String> {
    let child = node.children().find(|child| child.has_tag_name(tag));
    child.ok_or_else(|| format!("<{}> has no <{tag}>", node.tag_name().name()))
}

fn named<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Result<Node<'a, 'i>, String> {
    let array = node
        .children()
        .find(|child| child.attribute("Name") == Some(name));
    array.ok_or_else(|| format!("<{}> has no array {name:?}", node.tag_name().name()))
}

/// Attribute that is a number of entries or bytes.
fn count(node: Node, name: &str) -> Result<usize, String> {
    let text = node.attribute(name).unwrap_or_default();
    let tag = node.tag_name().name();
    let number = text.parse();
    number.map_err(|_| format!("<{tag}> has {name}={text:?}, but needs a number"))
}

fn check_count(name: &str, found: usize, expected: usize) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!(
        "there are {found} {name}, but {expected} are needed"
    ))
}
