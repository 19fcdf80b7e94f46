use super::FileError;
use std::path::Path;

/// Length of an excerpt in a message, in characters.
const EXCERPT_LENGTH: usize = 40;

/// Position, context and cause of a syntax error.
#[derive(Debug, thiserror::Error)]
#[error("line {line}, {excerpt:?}: {cause}")]
struct SyntaxError {
    /// Line number, counted from 1. In a binary file, the number of preceding line feeds plus 1.
    line: usize,
    cause: String,
    /// Excerpt of the rest of the line.
    excerpt: String,
}

/// Returns the error of a parser that failed at `rest`, a subslice of the bytes of the file.
pub(super) fn syntax_error_at(
    rest: &[u8],
    cause: String,
    (path, format, bytes): (&Path, &'static str, &[u8]),
) -> FileError {
    let rest = rest.trim_ascii_start();
    let start = rest.as_ptr().addr().saturating_sub(bytes.as_ptr().addr());
    let before = bytes.get(..start).unwrap_or(bytes);
    let source = SyntaxError {
        line: before.split(|&byte| byte == b'\n').count(),
        cause,
        excerpt: excerpt(rest.split(|&byte| byte == b'\n').next().unwrap_or(rest)),
    };
    FileError::Syntax {
        path: path.into(),
        format,
        source: source.into(),
    }
}

/// First characters of a text.
pub(super) fn excerpt(text: &[u8]) -> String {
    let text = &text[..text.len().min(4 * EXCERPT_LENGTH)];
    String::from_utf8_lossy(text)
        .chars()
        .take(EXCERPT_LENGTH)
        .collect()
}
