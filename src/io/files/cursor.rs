use super::FileError;
use super::scalar::{ByteOrder, Scalar};
use super::text_lines::{TextFile, excerpt};
use nalgebra::Vector3;
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// Position in a file, from which words, lines and binary numbers are read.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    file: TextFile<'a>,
    rest: &'a [u8],
    /// Order of the bytes of binary numbers, or `None` if numbers are text.
    pub binary: Option<ByteOrder>,
}

impl<'a> Cursor<'a> {
    pub fn new(path: &'a Path, format: &'static str, bytes: &'a [u8]) -> Self {
        Self {
            file: TextFile {
                path,
                format,
                bytes,
            },
            rest: bytes,
            binary: None,
        }
    }

    pub fn path(&self) -> &'a Path {
        self.file.path
    }

    /// Bytes from the position on.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Error at the position.
    pub fn error(&self, cause: impl Display) -> FileError {
        self.file.syntax_error(self.rest, cause)
    }

    /// Skips whitespace, and comments from `#` to the end of the line. Returns true at the end of the file.
    pub fn is_at_end(&mut self) -> bool {
        loop {
            self.rest = self.rest.trim_ascii_start();
            if !self.rest.starts_with(b"#") {
                return self.rest.is_empty();
            }
            self.line();
        }
    }

    /// Next line without its line feed. It is empty at the end of the file.
    pub fn line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        line
    }

    /// Words of the next line that is not blank. There are none at the end of the file, or if the line is not text.
    pub fn line_words(&mut self) -> Vec<&'a str> {
        self.is_at_end();
        let line = std::str::from_utf8(self.line()).unwrap_or_default();
        line.split_ascii_whitespace().collect()
    }

    /// Next word.
    pub fn word(&mut self) -> Result<&'a str, FileError> {
        if self.is_at_end() {
            return Err(self.error("unexpected end of the file"));
        }
        let end = self.rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        let word = std::str::from_utf8(word).map_err(|_| self.error("expected text"))?;
        self.rest = rest;
        Ok(word)
    }

    /// Next word, as a number.
    pub fn parsed<T: FromStr>(&mut self) -> Result<T, FileError> {
        let start = *self;
        let word = self.word()?;
        let cause = || format!("{:?} is not a valid number", excerpt(word.as_bytes()));
        word.parse().map_err(|_| start.error(cause()))
    }

    /// Skips a number of bytes and returns them.
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], FileError> {
        let (bytes, rest) = self.rest.split_at_checked(count).ok_or_else(|| {
            let left = self.rest.len();
            self.error(format!("{count} bytes were expected, but {left} are left"))
        })?;
        self.rest = rest;
        Ok(bytes)
    }

    /// Next real number.
    pub fn real(&mut self, scalar: Scalar) -> Result<f64, FileError> {
        match self.binary {
            None => self.parsed(),
            Some(order) => Ok(scalar.real(self.take(scalar.size)?, order)),
        }
    }

    /// Next three real numbers, which are the coordinates of a vertex.
    pub fn position(&mut self) -> Result<Vector3<f64>, FileError> {
        let mut position = Vector3::zeros();
        for coordinate in &mut position {
            *coordinate = self.real(Scalar::F64)?;
        }
        Ok(position)
    }

    /// Next integer.
    pub fn integer(&mut self, scalar: Scalar) -> Result<i64, FileError> {
        let start = *self;
        match self.binary {
            None => self.parsed(),
            Some(order) => scalar
                .integer(self.take(scalar.size)?, order)
                .ok_or_else(|| start.error("expected an integer below 2⁶³")),
        }
    }

    /// Next integer, which must not be negative.
    pub fn count(&mut self, scalar: Scalar) -> Result<usize, FileError> {
        let start = *self;
        let count = self.integer(scalar)?;
        let cause = || format!("expected a number of entries, not {count}");
        usize::try_from(count).map_err(|_| start.error(cause()))
    }

    /// Next real numbers.
    pub fn reals(&mut self, scalar: Scalar, count: usize) -> Result<Vec<f64>, FileError> {
        self.check_count(scalar, count)?;
        (0..count).map(|_| self.real(scalar)).collect()
    }

    /// Next integers.
    pub fn integers(&mut self, scalar: Scalar, count: usize) -> Result<Vec<i64>, FileError> {
        self.check_count(scalar, count)?;
        (0..count).map(|_| self.integer(scalar)).collect()
    }

    /// Checks that the rest of the file can hold these numbers, before memory is allocated for them.
    pub fn check_count(&self, scalar: Scalar, count: usize) -> Result<(), FileError> {
        let size = if self.binary.is_some() {
            scalar.size
        } else {
            2
        };
        // A word takes a byte and a separator, except the last word.
        if count.saturating_mul(size) > self.rest.len() + 1 {
            let left = self.rest.len();
            let cause = format!("{count} numbers cannot be in the last {left} bytes of the file");
            return Err(self.error(cause));
        }
        Ok(())
    }
}
