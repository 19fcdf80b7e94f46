//! Format of a file, from the extension of its name.

use super::FileError;
use std::path::Path;

/// Returns the extension of the name of a file, in lower case.
///
/// # Errors
/// [`FileError::UnknownExtension`] if the extension is not in the list.
pub(super) fn known_extension(
    path: &Path,
    known: &'static [&'static str],
) -> Result<&'static str, FileError> {
    let extension = path.extension().unwrap_or_default();
    let lowercase = extension.to_string_lossy().to_lowercase();
    let unknown = || FileError::UnknownExtension {
        path: path.into(),
        found: lowercase.clone(),
        expected: known,
    };
    let matches = |extension: &&&str| **extension == lowercase;
    known.iter().find(matches).copied().ok_or_else(unknown)
}
