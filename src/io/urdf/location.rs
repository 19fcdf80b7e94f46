use std::fmt;
use std::path::PathBuf;

/// Place in a URDF file.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Location {
    /// The file, or `None` for a text that was not read from a file.
    pub path: Option<PathBuf>,
    /// Line number, counted from 1.
    pub line: usize,
    /// Description of the element, such as `<axis> of joint "elbow"`.
    pub element: String,
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            path,
            line,
            element,
        } = self;
        match path {
            Some(path) => write!(formatter, "{}:{line}: {element}", path.display()),
            None => write!(formatter, "line {line}: {element}"),
        }
    }
}
