use super::FileError;
use super::stopped::stopped_at;
use nalgebra::Vector3;
use std::path::Path;

/// A text file of a format that is read line by line.
#[derive(Clone, Copy)]
pub(super) struct TextFile<'a> {
    pub path: &'a Path,
    pub format: &'static str,
    pub bytes: &'a [u8],
}

impl<'a> TextFile<'a> {
    /// The lines, with what ends them.
    pub fn lines(self) -> impl Iterator<Item = &'a [u8]> {
        self.bytes.split_inclusive(|&byte| byte == b'\n')
    }

    /// The error of a line of this file that is wrong.
    pub fn stopped(self, line: &[u8], cause: impl Into<String>) -> FileError {
        stopped_at(line, cause.into(), (self.path, self.format, self.bytes))
    }

    /// The first three of the words of a line as coordinates.
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
                .ok_or_else(|| self.stopped(line, "three finite coordinates were expected"))?;
        }
        Ok(position)
    }
}

/// The words of a line; what is no text in it does not matter as long as nobody reads it.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// The number that a word stands for.
pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
