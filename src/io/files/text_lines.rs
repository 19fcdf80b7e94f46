use super::FileError;
use nalgebra::Vector3;
use roxmltree::Node;
use std::fmt::Display;
use std::path::Path;

/// Length of an excerpt in a message, in characters.
const EXCERPT_LENGTH: usize = 40;

/// A text file in a line-based format.
#[derive(Clone, Copy)]
pub(super) struct TextFile<'a> {
    pub path: &'a Path,
    pub format: &'static str,
    pub bytes: &'a [u8],
}

impl<'a> TextFile<'a> {
    /// Lines, including their line feeds.
    pub fn lines(self) -> impl Iterator<Item = &'a [u8]> {
        self.bytes.split_inclusive(|&byte| byte == b'\n')
    }

    /// Returns the error of a parser that failed at a part of the bytes of this file. The error names the line, counted from 1, and quotes
    /// the start of the part. In a binary file, the line is the number of preceding line feeds plus 1.
    pub fn syntax_error(self, part: &[u8], cause: impl Display) -> FileError {
        let part = part.trim_ascii_start();
        let start = part
            .as_ptr()
            .addr()
            .saturating_sub(self.bytes.as_ptr().addr());
        let before = self.bytes.get(..start).unwrap_or(self.bytes);
        let line = before.split(|&byte| byte == b'\n').count();
        let source = format!("line {line}, {:?}: {cause}", excerpt(part));
        FileError::syntax(self.path, self.format, source)
    }

    /// Parses the first three words of a line as coordinates.
    ///
    /// # Errors
    /// If a coordinate is missing, is not a number, or is not finite.
    pub fn coordinates<'w>(
        self,
        line: &[u8],
        mut words: impl Iterator<Item = &'w [u8]>,
    ) -> Result<Vector3<f64>, FileError> {
        let mut position = Vector3::zeros();
        for coordinate in &mut position {
            let number = words.next().and_then(number::<f64>);
            *coordinate = number
                .filter(|number| number.is_finite())
                .ok_or_else(|| self.syntax_error(line, "expected three finite coordinates"))?;
        }
        Ok(position)
    }
}

/// First characters of the first line of a text.
pub(super) fn excerpt(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(&text[..text.len().min(4 * EXCERPT_LENGTH)]);
    let line = text.split('\n').next().unwrap_or_default();
    line.chars().take(EXCERPT_LENGTH).collect()
}

/// Whitespace-separated words of a line. Invalid UTF-8 is tolerated until a word is parsed.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Whitespace-separated words of an XML element. Comments may divide its text.
pub(super) fn xml_words<'a>(element: Node<'a, '_>) -> impl Iterator<Item = &'a str> {
    let texts = element.children().filter(Node::is_text);
    let texts = texts.filter_map(|node| node.text());
    texts.flat_map(str::split_ascii_whitespace)
}

/// Parses a word as a number. Returns `None` if the word is not a number.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
