use super::FileError;
use super::syntax_error::syntax_error_at;
use nalgebra::Vector3;
use std::path::Path;

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

    /// Returns the error for an invalid line of this file.
    pub fn syntax_error(self, line: &[u8], cause: impl Into<String>) -> FileError {
        syntax_error_at(line, cause.into(), (self.path, self.format, self.bytes))
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

/// Whitespace-separated words of a line. Invalid UTF-8 is tolerated until a word is parsed.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Parses a word as a number. Returns `None` if the word is not a number.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
