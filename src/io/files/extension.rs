//! The format of a file, by the extension of its name.

use super::FileError;
use std::path::Path;

/// The extension of a file's name, in lower case, if it is one of those known.
pub(super) fn known_extension(
    path: &Path,
    known: &'static [&'static str],
) -> Result<&'static str, FileError> {
    let extension = path.extension().unwrap_or_default();
    let found = extension.to_string_lossy().to_lowercase();
    let unknown = || FileError::UnknownExtension {
        path: path.into(),
        found: found.clone(),
        expected: known,
    };
    let is_found = |extension: &&&str| **extension == found;
    known.iter().find(is_found).copied().ok_or_else(unknown)
}
