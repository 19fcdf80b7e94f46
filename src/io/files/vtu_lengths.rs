use super::FileError;
use std::fmt::Write;
use std::path::Path;
use vtkio::model::ByteOrder;
use vtkio::xml::{Compressor, DataSet, ScalarType, VTKFile};

/// Largest compression ratio of zlib.
const ZLIB_RATIO: usize = 1032;

/// Actual and supported variant, for a file with appended data.
const APPENDED: (&str, &str) = (
    "appended data",
    "inline data (VTK's data modes ascii and binary)",
);

/// Checks the array lengths that an XML file states. vtkio slices and allocates with these lengths unchecked, so a wrong length
/// would make it panic or run out of memory.
///
/// The arrays of vtkio are private, but vtkio can write them. The written text has no comments, has attributes in double quotes, and
/// has all `<`, `>` and `"` within texts escaped.
pub(super) fn check(path: &Path, file: &VTKFile) -> Result<(), FileError> {
    check_variant(file).map_err(|variant| unsupported(path, variant))?;
    let mut text = String::new();
    write!(text, "{file}").map_err(|source| FileError::Syntax {
        path: path.into(),
        format: "VTK XML",
        source: source.into(),
    })?;
    let mut pieces = text.split("<Piece").skip(1);
    if pieces.any(|piece| !piece.contains("<Points>")) {
        return Err(FileError::TooShort {
            path: path.into(),
            part: "list of points".into(),
            found: 0,
            expected: 1,
        });
    }
    let mut arrays = text.split("<DataArray").skip(1).map(Array::of);
    arrays.try_for_each(|array| {
        let name = array.name;
        check_array(file, &array).map_err(|length| length.into_error(path, name))
    })
}

/// Checks that the file has no appended data.
pub(super) fn check_inline(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let tag = b"<AppendedData";
    if bytes.windows(tag.len()).any(|window| window == tag) {
        return Err(unsupported(path, APPENDED));
    }
    Ok(())
}

fn unsupported(path: &Path, (found, expected): (&str, &'static str)) -> FileError {
    FileError::Unsupported {
        path: path.into(),
        found: found.into(),
        expected,
    }
}

/// Checks that vtkio can read the variant of the file, and that the checks of this module cover it.
///
/// # Errors
/// The actual variant and the supported variant.
fn check_variant(file: &VTKFile) -> Result<(), (&'static str, &'static str)> {
    if !matches!(file.data_set, DataSet::UnstructuredGrid(_)) {
        return Err(("another kind of data set", "an unstructured grid"));
    }
    if file.appended_data.is_some() {
        return Err(APPENDED);
    }
    if !matches!(
        file.header_type,
        None | Some(ScalarType::UInt32 | ScalarType::UInt64)
    ) {
        return Err(("another type of header", "UInt32 and UInt64"));
    }
    if matches!(file.compressor, Compressor::LZ4 | Compressor::LZMA) {
        return Err(("an LZ4 or LZMA compressor", "data compressed with zlib"));
    }
    Ok(())
}

/// Relevant attributes and content of a data array in an XML file.
struct Array<'a> {
    name: &'a str,
    component_count: &'a str,
    is_ascii: bool,
    content: &'a str,
}

impl<'a> Array<'a> {
    /// Parses the text that begins with the attributes of the array.
    fn of(text: &'a str) -> Self {
        let (attributes, rest) = text.split_once('>').unwrap_or((text, ""));
        let attribute = |start| {
            let (_, rest) = attributes.split_once(start)?;
            rest.split('"').next()
        };
        Self {
            name: attribute(" Name=\"").unwrap_or_default(),
            component_count: attribute(" NumberOfComponents=\"").unwrap_or("1"),
            is_ascii: attribute(" format=\"") == Some("ascii"),
            content: rest.split('<').next().unwrap_or_default(),
        }
    }
}

fn check_array(file: &VTKFile, array: &Array) -> Result<(), WrongLength> {
    // vtkio multiplies the last offset by the number of components.
    if array.name == "connectivity" {
        let count = array.component_count.parse().unwrap_or(usize::MAX);
        check_limit(count, 1)?;
    }
    if array.is_ascii {
        Ok(())
    } else if file.compressor.is_none() {
        let bytes = decoded(array.content.as_bytes());
        check_length(bytes.len(), integer_size(file))
    } else {
        check_blocks(file, array.content.as_bytes())
    }
}

/// An invalid length.
enum WrongLength {
    TooShort { length: usize, expected: usize },
    TooLong { length: usize, limit: usize },
}

impl WrongLength {
    fn into_error(self, path: &Path, array: &str) -> FileError {
        let (path, part) = (path.into(), format!("data array {array:?}"));
        match self {
            Self::TooShort { length, expected } => FileError::TooShort {
                path,
                part,
                found: length,
                expected,
            },
            Self::TooLong { length, limit } => FileError::TooLong {
                path,
                part,
                found: length,
                limit,
            },
        }
    }
}

/// Checks a compressed array. It consists of a header of integers in base64, and of the blocks in base64.
///
/// The header contains the number of blocks, the uncompressed length of a block, the uncompressed length of the last block, and the
/// compressed length of each block.
fn check_blocks(file: &VTKFile, content: &[u8]) -> Result<(), WrongLength> {
    let header = header(file, content, 3)?;
    let (block_count, block, last_block) = (header[0], header[1], header[2]);
    check_length(block_count, 1)?;
    check_length(block, 1)?;
    // The number of blocks cannot exceed the number of characters. This bound prevents overflow of the products below.
    check_limit(block_count, content.len())?;
    let header = self::header(file, content, 3 + block_count)?;
    let compressed = header[3..].iter().fold(0, |sum, &n| n.saturating_add(sum));
    let data_start = encoded_length(integer_size(file) * header.len());
    let data = &content[data_start..];
    check_length(decoded(data).len(), compressed)?;
    check_length(data.len(), encoded_length(compressed))?;
    let uncompressed = (block_count - 1).saturating_mul(block);
    check_limit(
        uncompressed.saturating_add(last_block),
        compressed.saturating_mul(ZLIB_RATIO),
    )
}

/// First `count` integers of an array.
fn header(file: &VTKFile, content: &[u8], count: usize) -> Result<Vec<usize>, WrongLength> {
    let length = integer_size(file) * count;
    let encoded = content.get(..encoded_length(length)).unwrap_or_default();
    let bytes = decoded(encoded);
    check_length(bytes.len(), length)?;
    let integers = bytes[..length].chunks_exact(integer_size(file));
    Ok(integers.map(|i| integer(i, file.byte_order)).collect())
}

/// Size of the integers in array headers (bytes).
fn integer_size(file: &VTKFile) -> usize {
    match file.header_type {
        Some(ScalarType::UInt64) => 8,
        _ => 4,
    }
}

fn check_length(length: usize, expected: usize) -> Result<(), WrongLength> {
    if length < expected {
        return Err(WrongLength::TooShort { length, expected });
    }
    Ok(())
}

fn check_limit(length: usize, limit: usize) -> Result<(), WrongLength> {
    if length > limit {
        return Err(WrongLength::TooLong { length, limit });
    }
    Ok(())
}

/// Decodes an integer of 4 or 8 bytes.
fn integer(bytes: &[u8], order: ByteOrder) -> usize {
    let append = |value: usize, byte: &u8| value << 8 | usize::from(*byte);
    match order {
        ByteOrder::BigEndian => bytes.iter().fold(0, append),
        ByteOrder::LittleEndian => bytes.iter().rev().fold(0, append),
    }
}

/// Base64 length of `length` bytes.
fn encoded_length(length: usize) -> usize {
    4 * length.div_ceil(3)
}

/// Decodes base64 up to the first invalid character.
fn decoded(text: &[u8]) -> Vec<u8> {
    let digits: Vec<u8> = text.iter().map_while(|&c| digit(c)).collect();
    let decode = |group: &[u8]| {
        let bits = (0..4).fold(0, |bits, i| {
            bits << 6 | u32::from(group.get(i).copied().unwrap_or(0))
        });
        let [_, bytes @ ..] = bits.to_be_bytes();
        bytes.into_iter().take(group.len() * 6 / 8)
    };
    digits.chunks(4).flat_map(decode).collect()
}

fn digit(character: u8) -> Option<u8> {
    match character {
        b'A'..=b'Z' => Some(character - b'A'),
        b'a'..=b'z' => Some(character - b'a' + 26),
        b'0'..=b'9' => Some(character - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    }
}
