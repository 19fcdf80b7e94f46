//! Atomic replacement of files.

use super::FileError;
use std::fs::{self, File, OpenOptions, Permissions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{io, process};

/// Number of temporary files that this process has created. It makes their names unique.
static TEMP_FILE_COUNT: AtomicUsize = AtomicUsize::new(0);

/// Writes a file atomically. The function writes a temporary file in the same folder, syncs it to the disk, and renames it to the
/// target. On failure, an existing file stays unchanged.
///
/// Symbolic links are followed. Special files (devices, pipes) cannot be replaced, so the function writes to them directly.
pub(super) fn atomic_write(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), FileError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let written = Existing::at(&target).and_then(|existing| match existing {
        Existing::Special(mut file) => write(&mut file),
        Existing::Ordinary(permissions) => replace(&target, Some(permissions), write),
        Existing::Nothing => replace(&target, None, write),
    });
    written.map_err(|source| FileError::Write {
        path: path.into(),
        source,
    })
}

/// File that exists at the target.
enum Existing {
    Nothing,
    Ordinary(Permissions),
    Special(File),
}

impl Existing {
    /// Returns the existing file.
    ///
    /// # Errors
    /// If the existing file is not writable.
    fn at(target: &Path) -> io::Result<Self> {
        let file = match OpenOptions::new().write(true).open(target) {
            Ok(file) => file,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::Nothing),
            Err(error) => return Err(error),
        };
        let metadata = file.metadata()?;
        Ok(if metadata.is_file() {
            Self::Ordinary(metadata.permissions())
        } else {
            Self::Special(file)
        })
    }
}

fn replace(
    target: &Path,
    permissions: Option<Permissions>,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let (mut file, temp_file) = TempFile::beside(target)?;
    write(&mut file)?;
    if let Some(permissions) = permissions {
        file.set_permissions(permissions)?;
    }
    file.sync_all()?;
    drop(file);
    fs::rename(&temp_file.path, target)
}

/// A temporary file, which is removed on drop unless it was renamed.
struct TempFile {
    path: PathBuf,
}

impl TempFile {
    /// Creates an empty file with a unique name in the folder of the target.
    fn beside(target: &Path) -> io::Result<(File, Self)> {
        loop {
            let number = TEMP_FILE_COUNT.fetch_add(1, Ordering::Relaxed);
            let name = format!("hydroelastic-{}-{number}.part", process::id());
            let path = target.with_file_name(name);
            match File::create_new(&path) {
                Ok(file) => return Ok((file, Self { path })),
                // A killed process with the same id has left this file.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Drop for TempFile {
    fn drop(&mut self) {
        // The file is missing if it was renamed. Other errors cannot be reported here.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// An empty folder.
    fn folder(name: &str) -> PathBuf {
        let name = format!("hydroelastic_atomic_write_{name}_{}", process::id());
        let folder = std::env::temp_dir().join(name);
        fs::create_dir(&folder).unwrap();
        folder
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let name = |entry: io::Result<fs::DirEntry>| entry.unwrap().file_name();
        entries
            .map(|entry| name(entry).into_string().unwrap())
            .collect()
    }

    fn write_half(file: &mut File) -> io::Result<()> {
        file.write_all(b"half")?;
        Err(io::ErrorKind::StorageFull.into())
    }

    #[test]
    fn what_fails_half_way_leaves_the_older_file_and_no_other() {
        let folder = folder("fails");
        let path = folder.join("table.csv");
        atomic_write(&path, |file| file.write_all(b"good")).unwrap();
        let FileError::Write { path: named, .. } = atomic_write(&path, write_half).unwrap_err()
        else {
            panic!()
        };
        assert_eq!(named, path);
        let panics = || atomic_write(&path, |_| panic!("half way"));
        assert!(catch_unwind(AssertUnwindSafe(panics)).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"good");
        assert!(atomic_write(&folder.join("new.csv"), write_half).is_err());
        assert_eq!(names(&folder), ["table.csv"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_draft_that_a_killed_process_left_is_not_touched() {
        let folder = folder("killed");
        let number = TEMP_FILE_COUNT.load(Ordering::Relaxed);
        // Reserves 100 numbers, because other tests use some of them meanwhile.
        for number in number..number + 100 {
            let name = format!("hydroelastic-{}-{number}.part", process::id());
            fs::write(folder.join(name), b"left").unwrap();
        }
        atomic_write(&folder.join("table.csv"), |file| file.write_all(b"good")).unwrap();
        let is_left = |name: &String| fs::read(folder.join(name)).unwrap() == b"left";
        let left_count = names(&folder).iter().filter(|name| is_left(name)).count();
        assert_eq!(left_count, 100);
        assert_eq!(fs::read(folder.join("table.csv")).unwrap(), b"good");
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = folder("links");
        let (path, link) = (folder.join("table.csv"), folder.join("link.csv"));
        fs::write(&path, b"existing").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        atomic_write(&link, |file| file.write_all(b"newer")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"newer");
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        fs::remove_dir_all(folder).unwrap();
    }
}
