//! Files that take the place of older ones all at once.

use super::FileError;
use std::fs::{self, File, OpenOptions, Permissions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{io, process};

/// How many drafts this process has begun: no two have the same name.
static BEGUN: AtomicUsize = AtomicUsize::new(0);

/// Writes a file that is whole or not there: a draft beside its place, moved there when all of it is on
/// the disk. Where that fails, an older file stays as it was.
///
/// Links are followed. What is no ordinary file (a device, a pipe) cannot be replaced, and is written to.
pub(super) fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), FileError> {
    let place = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let written = Older::at(&place).and_then(|older| match older {
        Older::Special(mut file) => write(&mut file),
        Older::Ordinary(permissions) => replace(&place, Some(permissions), write),
        Older::Nothing => replace(&place, None, write),
    });
    written.map_err(|source| FileError::Write {
        path: path.into(),
        source,
    })
}

/// What is there before.
enum Older {
    Nothing,
    Ordinary(Permissions),
    Special(File),
}

impl Older {
    /// An error where there is something that must not be written.
    fn at(place: &Path) -> io::Result<Self> {
        let file = match OpenOptions::new().write(true).open(place) {
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
    place: &Path,
    permissions: Option<Permissions>,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let (mut file, draft) = Draft::beside(place)?;
    write(&mut file)?;
    if let Some(permissions) = permissions {
        file.set_permissions(permissions)?;
    }
    file.sync_all()?;
    drop(file);
    fs::rename(&draft.path, place)
}

/// A file that is removed when this is dropped, unless it was moved.
struct Draft {
    path: PathBuf,
}

impl Draft {
    /// An empty file of a name of its own in the folder of a place.
    fn beside(place: &Path) -> io::Result<(File, Self)> {
        loop {
            let number = BEGUN.fetch_add(1, Ordering::Relaxed);
            let name = format!("hydroelastic-{}-{number}.part", process::id());
            let path = place.with_file_name(name);
            match File::create_new(&path) {
                Ok(file) => return Ok((file, Self { path })),
                // Left by a process of the same number that was killed.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // Moved or not: there is nobody to tell if it stays.
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
        let name = format!("hydroelastic_replacement_{name}_{}", process::id());
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

    fn half(file: &mut File) -> io::Result<()> {
        file.write_all(b"half")?;
        Err(io::ErrorKind::StorageFull.into())
    }

    #[test]
    fn what_fails_half_way_leaves_the_older_file_and_no_other() {
        let folder = folder("fails");
        let path = folder.join("table.csv");
        write_whole(&path, |file| file.write_all(b"good")).unwrap();
        let FileError::Write { path: named, .. } = write_whole(&path, half).unwrap_err() else {
            panic!()
        };
        assert_eq!(named, path);
        let panics = || write_whole(&path, |_| panic!("half way"));
        assert!(catch_unwind(AssertUnwindSafe(panics)).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"good");
        assert!(write_whole(&folder.join("new.csv"), half).is_err());
        assert_eq!(names(&folder), ["table.csv"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_draft_that_a_killed_process_left_is_not_touched() {
        let folder = folder("killed");
        let number = BEGUN.load(Ordering::Relaxed);
        // Of the next numbers, as other tests take some meanwhile.
        for number in number..number + 100 {
            let name = format!("hydroelastic-{}-{number}.part", process::id());
            fs::write(folder.join(name), b"left").unwrap();
        }
        write_whole(&folder.join("table.csv"), |file| file.write_all(b"good")).unwrap();
        let left = |name: &String| fs::read(folder.join(name)).unwrap() == b"left";
        assert_eq!(names(&folder).iter().filter(|name| left(name)).count(), 100);
        assert_eq!(fs::read(folder.join("table.csv")).unwrap(), b"good");
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = folder("links");
        let (path, link) = (folder.join("table.csv"), folder.join("link.csv"));
        fs::write(&path, b"older").unwrap();
        fs::set_permissions(&path, Permissions::from_mode(0o640)).unwrap();
        symlink(&path, &link).unwrap();
        write_whole(&link, |file| file.write_all(b"newer")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"newer");
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o640);
        fs::remove_dir_all(folder).unwrap();
    }
}
