use super::FileError;
use std::ops::Range;
use std::path::Path;

const NODES: &str = "$Nodes";
const ELEMENTS: &str = "$Elements";

/// Size of an integer in the section headers of a binary file (bytes).
const INTEGER_SIZE: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Ascii,
    Binary,
}

impl Encoding {
    fn zero_digit(self) -> u8 {
        match self {
            Self::Ascii => b'0',
            Self::Binary => 0,
        }
    }

    fn largest_integer(self) -> Vec<u8> {
        match self {
            Self::Ascii => u64::MAX.to_string().into(),
            Self::Binary => u64::MAX.to_ne_bytes().into(),
        }
    }
}

/// Validates a file and modifies it for mshio.
///
/// - mshio subtracts 1 from the number of nodes and elements, so both numbers must be positive.
/// - mshio discards the tags of the nodes if the header states that they fill their range, but it does not check that they are
///   in order. Replacing the largest tag with the largest integer makes mshio keep the tags.
pub(super) fn prepare(path: &Path, bytes: &mut Vec<u8>) -> Result<(), FileError> {
    let encoding = checked_encoding(path, bytes)?;
    for section in [NODES, ELEMENTS] {
        // The order is reversed, because a replacement can change the length of the text and move
        // later sections.
        for start in starts(bytes, section).into_iter().rev() {
            let largest_tag =
                largest_tag(bytes, start, encoding).map_err(|(found, expected)| {
                    let (path, part) = (path.into(), format!("section {section}"));
                    FileError::TooShort {
                        path,
                        part,
                        found,
                        expected,
                    }
                })?;
            if section == NODES {
                bytes.splice(largest_tag, encoding.largest_integer());
            }
        }
    }
    Ok(())
}

/// Byte range of the largest tag in the header of a section.
///
/// # Errors
/// The actual length and the required length, if the header is incomplete or the section has no entries.
fn largest_tag(
    bytes: &[u8],
    start: usize,
    encoding: Encoding,
) -> Result<Range<usize>, (usize, usize)> {
    let numbers = numbers(bytes, start, encoding);
    let [_, count, _, largest_tag] = numbers.ok_or((bytes.len() - start, 4 * INTEGER_SIZE))?;
    let zero = encoding.zero_digit();
    if bytes[count].iter().all(|&digit| digit == zero) {
        return Err((0, 1));
    }
    Ok(largest_tag)
}

/// Encoding of a file.
///
/// # Errors
/// If mshio does not support the header. mshio may panic for other headers.
fn checked_encoding(path: &Path, bytes: &[u8]) -> Result<Encoding, FileError> {
    let mut lines = bytes.splitn(3, |&byte| byte == b'\n');
    let mut next_line = || String::from_utf8_lossy(lines.next().unwrap_or_default());
    let (first, second) = (next_line(), next_line());
    let numbers: Vec<&str> = second.split_whitespace().collect();
    match (first.trim_end(), numbers.as_slice()) {
        ("$MeshFormat", ["4.1", "0", "8"]) => Ok(Encoding::Ascii),
        ("$MeshFormat", ["4.1", "1", "8"]) => Ok(Encoding::Binary),
        (first, _) => Err(FileError::Unsupported {
            path: path.into(),
            found: format!("the header {:?}", shortened(&format!("{first} {second}"))),
            expected: "\"$MeshFormat 4.1 0 8\" (ASCII) and \"$MeshFormat 4.1 1 8\" (binary)",
        }),
    }
}

fn shortened(text: &str) -> String {
    text.trim_end().chars().take(40).collect()
}

/// Start of the contents of each section of a name: the byte after the line with the name.
fn starts(bytes: &[u8], section: &str) -> Vec<usize> {
    let name = section.as_bytes();
    let names = bytes.windows(name.len()).enumerate();
    names
        .filter(|(_, window)| *window == name)
        .filter_map(|(start, _)| {
            let end = start + name.len();
            let rest = &bytes[end..];
            let line_end = [&b"\n"[..], b"\r\n"];
            let line_end = line_end.iter().find(|text| rest.starts_with(text))?;
            Some(end + line_end.len())
        })
        .collect()
}

/// Byte ranges of the four numbers in the header of a section: block count, entry count, smallest tag, largest tag.
fn numbers(bytes: &[u8], start: usize, encoding: Encoding) -> Option<[Range<usize>; 4]> {
    let mut end = start;
    let mut next = || {
        let length = if encoding == Encoding::Binary {
            INTEGER_SIZE
        } else {
            end += bytes
                .get(end..)?
                .iter()
                .position(|b| !b.is_ascii_whitespace())?;
            bytes[end..].iter().position(u8::is_ascii_whitespace)?
        };
        let number = end..end + length;
        end = number.end;
        (end <= bytes.len()).then_some(number)
    };
    Some([next()?, next()?, next()?, next()?])
}
