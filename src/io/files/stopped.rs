use super::FileError;
use std::path::Path;

/// Characters of the text that a message quotes.
const QUOTED: usize = 40;

/// Where a parser stopped, and at what.
#[derive(Debug, thiserror::Error)]
#[error("line {line}, {found:?}: {cause}")]
struct Stopped {
    /// From 1; in a binary file, one more than the line feeds before.
    line: usize,
    cause: String,
    /// The rest of the line.
    found: String,
}

/// The error of a parser that stopped at `rest`, a part of the bytes it was given.
pub(super) fn stopped_at(
    rest: &[u8],
    cause: String,
    (path, format, bytes): (&Path, &'static str, &[u8]),
) -> FileError {
    let rest = rest.trim_ascii_start();
    let start = rest.as_ptr().addr().saturating_sub(bytes.as_ptr().addr());
    let before = bytes.get(..start).unwrap_or(bytes);
    let source = Stopped {
        line: before.split(|&byte| byte == b'\n').count(),
        cause,
        found: beginning(rest.split(|&byte| byte == b'\n').next().unwrap_or(rest)),
    };
    FileError::Syntax {
        path: path.into(),
        format,
        source: source.into(),
    }
}

/// The first characters of a text.
pub(super) fn beginning(text: &[u8]) -> String {
    let text = &text[..text.len().min(4 * QUOTED)];
    String::from_utf8_lossy(text).chars().take(QUOTED).collect()
}
