//! Reader of legacy VTK files, up to version 5.1.

use super::FileError;
use super::cursor::Cursor;
use super::scalar::{ByteOrder, Scalar};
use super::vtk_data_set::{DataSet, Lists, POLYGON, STRIP};
use std::path::Path;

/// Reads a legacy file.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<DataSet, FileError> {
    let mut cursor = Cursor::new(path, "legacy VTK", bytes);
    let start = cursor;
    if !cursor.line().starts_with(b"# vtk DataFile Version") {
        return Err(start.error("expected \"# vtk DataFile Version\""));
    }
    // The second line is a title.
    cursor.line();
    let encoding = cursor;
    cursor.binary = match &*cursor.line().trim_ascii().to_ascii_uppercase() {
        b"ASCII" => None,
        b"BINARY" => Some(ByteOrder::Big),
        _ => return Err(encoding.error("expected ASCII or BINARY")),
    };
    let mut reader = Reader {
        cursor,
        data: DataSet::default(),
        tuples: 0,
        has_point_data: false,
    };
    while !reader.cursor.is_at_end() {
        reader.read_section()?;
    }
    Ok(reader.data)
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    data: DataSet,
    /// Number of points or cells that the current arrays belong to.
    tuples: usize,
    has_point_data: bool,
}

impl Reader<'_> {
    fn read_section(&mut self) -> Result<(), FileError> {
        let start = self.cursor;
        let words = self.cursor.line_words();
        let keyword = words.first().unwrap_or(&"").to_ascii_uppercase();
        let cause = || start.error("expected a keyword of legacy VTK with its arguments");
        match (&*keyword, &words[..]) {
            ("DATASET", [_, kind]) => self.check_kind(kind)?,
            ("POINTS", [_, count, kind]) => {
                let points = self.array(kind, product(count, 3).ok_or_else(cause)?)?;
                self.data.points = points.ok_or_else(cause)?;
            }
            ("CELLS", [_, first, second]) => self.data.cells = self.lists(first, second)?,
            ("POLYGONS" | "TRIANGLE_STRIPS", [_, first, second]) => {
                let kind = if keyword == "POLYGONS" {
                    POLYGON
                } else {
                    STRIP
                };
                let cells = self.lists(first, second)?;
                self.data.add_cells(&cells, 0, kind);
            }
            ("VERTICES" | "LINES", [_, first, second]) => drop(self.lists(first, second)?),
            ("CELL_TYPES", [_, count]) => {
                let count = product(count, 1).ok_or_else(cause)?;
                self.data.types = self.cursor.integers(Scalar::I32, count)?;
            }
            ("POINT_DATA" | "CELL_DATA", [_, count]) => {
                self.tuples = product(count, 1).ok_or_else(cause)?;
                self.has_point_data = keyword == "POINT_DATA";
            }
            ("FIELD", [_, _, count]) => self.read_field(product(count, 1).ok_or_else(cause)?)?,
            ("METADATA", _) => self.skip_metadata(),
            ("LOOKUP_TABLE", [_, _, count]) => {
                self.skip_colors(product(count, 4).ok_or_else(cause)?)?;
            }
            ("COLOR_SCALARS", [_, _, components]) => {
                self.skip_colors(product(components, self.tuples).ok_or_else(cause)?)?;
            }
            (_, [_, name, rest @ ..]) => {
                let (kind, components) = attribute(&keyword, rest).ok_or_else(cause)?;
                if keyword == "SCALARS" {
                    self.skip_table_name();
                }
                let count = components.checked_mul(self.tuples).ok_or_else(cause)?;
                let values = self.array(kind, count)?;
                self.keep(name, components, values);
            }
            _ => return Err(cause()),
        }
        Ok(())
    }

    fn check_kind(&mut self, kind: &str) -> Result<(), FileError> {
        match &*kind.to_ascii_uppercase() {
            "UNSTRUCTURED_GRID" => {}
            "POLYDATA" => self.data.is_poly_data = true,
            _ => {
                return Err(FileError::Unsupported {
                    path: self.cursor.path().into(),
                    found: format!("a data set of the kind {kind}"),
                    expected: "UNSTRUCTURED_GRID and POLYDATA",
                });
            }
        }
        Ok(())
    }

    /// Reads lists of vertices. Files before version 5 state the number of cells and the length of the list with counts. Later files
    /// state the number of offsets, which begin at 0, and the number of vertices.
    fn lists(&mut self, first: &str, second: &str) -> Result<Lists, FileError> {
        let start = self.cursor;
        let counts = product(first, 1).zip(product(second, 1));
        let (first, second) =
            counts.ok_or_else(|| start.error("expected two numbers of entries"))?;
        let lists = if self.cursor.rest().starts_with(b"OFFSETS") {
            let offsets = self.named_array("OFFSETS", first)?;
            let vertices = self.named_array("CONNECTIVITY", second)?;
            Lists::from_ends(vertices, offsets.get(1..).unwrap_or_default())
        } else {
            let list = self.cursor.integers(Scalar::I32, second)?;
            Lists::from_counted(&list).and_then(|lists| {
                let found = lists.len();
                let cause = || format!("expected {first} cells, but found {found}");
                (found == first).then_some(lists).ok_or_else(cause)
            })
        };
        lists.map_err(|cause| start.error(cause))
    }

    fn named_array(&mut self, name: &str, count: usize) -> Result<Vec<i64>, FileError> {
        let start = self.cursor;
        let cause = || start.error(format!("expected {name} and its type"));
        match *self.cursor.line_words() {
            [found, kind] if found == name => {
                let scalar = Scalar::named(kind).ok_or_else(cause)?;
                self.cursor.integers(scalar, count)
            }
            _ => Err(cause()),
        }
    }

    /// Reads an array. Returns `None` for the types bit and string, whose values are skipped.
    fn array(&mut self, kind: &str, count: usize) -> Result<Option<Vec<f64>>, FileError> {
        if let Some(scalar) = Scalar::named(kind) {
            return self.cursor.reals(scalar, count).map(Some);
        }
        let is_binary = self.cursor.binary.is_some();
        match kind {
            "bit" if is_binary => self.cursor.take(count.div_ceil(8)).map(|_| ())?,
            "bit" => (0..count).try_for_each(|_| self.cursor.word().map(|_| ()))?,
            "string" if !is_binary => {
                self.cursor.check_count(Scalar::U8, count)?;
                for _ in 0..count {
                    self.cursor.line();
                }
            }
            _ => {
                return Err(self
                    .cursor
                    .error(format!("arrays of the type {kind:?} are not supported")));
            }
        }
        Ok(None)
    }

    /// Reads the arrays of a field.
    fn read_field(&mut self, count: usize) -> Result<(), FileError> {
        for _ in 0..count {
            let start = self.cursor;
            let mut words = self.cursor.line_words();
            while words.first() == Some(&"METADATA") {
                self.skip_metadata();
                words = self.cursor.line_words();
            }
            let cause = || {
                start.error(
                    "expected an array: its name, numbers of components and tuples, and type",
                )
            };
            let [name, components, tuples, kind] = *words else {
                return Err(cause());
            };
            let (components, tuples) = product(components, 1)
                .zip(product(tuples, 1))
                .ok_or_else(cause)?;
            let values = self.array(kind, components.checked_mul(tuples).ok_or_else(cause)?)?;
            self.keep(name, components, values);
        }
        Ok(())
    }

    /// Skips metadata, which end with an empty line.
    fn skip_metadata(&mut self) {
        while !self.cursor.line().trim_ascii().is_empty() {}
    }

    fn keep(&mut self, name: &str, components: usize, values: Option<Vec<f64>>) {
        if let (true, 1, Some(values)) = (self.has_point_data, components, values) {
            self.data.point_data.insert(percent_decoded(name), values);
        }
    }

    /// Skips colors, which are bytes in binary files.
    fn skip_colors(&mut self, count: usize) -> Result<(), FileError> {
        self.cursor.reals(Scalar::U8, count).map(|_| ())
    }

    /// Skips the optional line after the line of scalars.
    fn skip_table_name(&mut self) {
        let mut after = self.cursor;
        if matches!(*after.line_words(), [keyword, _] if keyword.eq_ignore_ascii_case("LOOKUP_TABLE"))
        {
            self.cursor = after;
        }
    }
}

/// Product of a word and a number.
fn product(word: &str, factor: usize) -> Option<usize> {
    word.parse::<usize>().ok()?.checked_mul(factor)
}

/// Type and number of components of an array of attributes.
fn attribute<'w>(keyword: &str, words: &[&'w str]) -> Option<(&'w str, usize)> {
    Some(match (keyword, words) {
        ("SCALARS", &[kind, components]) | ("TEXTURE_COORDINATES", &[components, kind]) => {
            (kind, product(components, 1)?)
        }
        ("SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS", &[kind]) => (kind, 1),
        ("VECTORS" | "NORMALS", &[kind]) => (kind, 3),
        ("TENSORS", &[kind]) => (kind, 9),
        ("TENSORS6", &[kind]) => (kind, 6),
        _ => return None,
    })
}

/// Decodes a percent-encoded name. Returns the name unchanged if the decoded bytes are not UTF-8.
fn percent_decoded(name: &str) -> String {
    let mut bytes = Vec::with_capacity(name.len());
    let mut rest = name.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let hex = after
            .get(..2)
            .filter(|hex| hex.iter().all(u8::is_ascii_hexdigit));
        let code = hex.and_then(|hex| u8::from_str_radix(std::str::from_utf8(hex).ok()?, 16).ok());
        let (byte, after) = match code {
            Some(code) if byte == b'%' => (code, &after[2..]),
            _ => (byte, after),
        };
        bytes.push(byte);
        rest = after;
    }
    String::from_utf8(bytes).unwrap_or_else(|_| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::percent_decoded;

    #[test]
    fn names_are_decoded_if_the_result_is_text() {
        assert_eq!(
            percent_decoded("a%20name%20with%20spaces"),
            "a name with spaces"
        );
        assert_eq!(percent_decoded("plain"), "plain");
        assert_eq!(percent_decoded("100%"), "100%");
        assert_eq!(percent_decoded("50%zz%+f"), "50%zz%+f");
        assert_eq!(percent_decoded("%c3%a9"), "é");
        assert_eq!(percent_decoded("%ff"), "%ff");
    }
}
