use super::{check_count, csv_file, rows_of};
use crate::dynamics::{Body, Force, State, World};
use crate::io::FileError;
use crate::io::files::extension::known_extension;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// What the name of a growing file can end in.
const EXTENSIONS: &[&str] = &["csv"];

/// A trajectory that goes to a CSV file as it comes about, for rollouts too long to be kept in memory or
/// to be lost: the table of [`write_trajectory`](super::write_trajectory), with the rows of each state as
/// soon as it is pushed.
///
/// A process that is killed, or panics, leaves all states that were pushed before; of the one that was
/// being written a part may be there, the last line cut short. On a full disk [`Self::push`] is an error, and
/// the file ends with the last whole state. When the system itself goes down, what was pushed since
/// [`Self::sync`] may be lost.
///
/// There is no such file in Parquet: without its footer, which comes last, it cannot be read.
///
/// ```
/// use hydroelastic::contact::Shape;
/// use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
/// use hydroelastic::io::TrajectoryFile;
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
///
/// let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// let world = World::new(vec![ball])?.with_gravity(Vector3::new(0.0, 0.0, -9.81))?;
/// let path = std::env::temp_dir().join("long_fall.csv");
/// # let _ = std::fs::remove_file(&path);
/// let mut file = TrajectoryFile::create_new(&path, &world)?;
/// file.push(&world.initial_state())?;
/// let mut rollout = world.rollout(&Plan::new(1e-3, 400)?);
/// for step in 1..=400 {
///     let state = rollout.advance()?;
///     if step % 100 == 0 {
///         file.push(state)?;
///     }
/// }
/// file.sync()?;
/// assert_eq!(std::fs::read_to_string(&path)?.lines().count(), 1 + 5);
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TrajectoryFile {
    path: PathBuf,
    file: File,
    bodies: Vec<Body>,
    /// Bytes up to the end of the last whole state.
    length: u64,
}

impl TrajectoryFile {
    /// A new file without states.
    ///
    /// # Errors
    /// If the name of the file does not end in `.csv`, there is a file of that name (an earlier run is
    /// not written over), or it cannot be written.
    pub fn create_new<F: Force>(
        path: impl AsRef<Path>,
        world: &World<f64, F>,
    ) -> Result<Self, FileError> {
        let path = path.as_ref();
        known_extension(path, EXTENSIONS)?;
        let file = File::create_new(path).map_err(|source| write_error(path, source))?;
        let mut growing = Self {
            path: path.into(),
            file,
            bodies: world.bodies().to_vec(),
            length: 0,
        };
        if let Err(source) = csv_file::header().and_then(|line| growing.append(&line)) {
            // As a file without its header is of no use, so nothing is lost if it stays.
            let _ = fs::remove_file(path);
            return Err(write_error(path, source));
        }
        Ok(growing)
    }

    /// Adds the rows of a state and hands them to the system.
    ///
    /// # Errors
    /// If the state has more or fewer bodies than the world, or the file cannot be written; then it ends with
    /// the state before.
    pub fn push(&mut self, state: &State) -> Result<(), FileError> {
        check_count(&self.path, &self.bodies, state)?;
        let lines = csv_file::lines(rows_of(&self.bodies, state));
        let appended = lines.and_then(|lines| self.append(&lines));
        appended.map_err(|source| write_error(&self.path, source))
    }

    /// Waits until all states are on the disk.
    ///
    /// # Errors
    /// If the system says that they are not.
    pub fn sync(&self) -> Result<(), FileError> {
        let synced = self.file.sync_all();
        synced.map_err(|source| write_error(&self.path, source))
    }

    /// Adds all the bytes or, as far as the disk lets it, none.
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let written = self.file.write_all(bytes);
        if written.is_ok() {
            self.length += bytes.len() as u64;
        } else {
            self.file.set_len(self.length)?;
            self.file.seek(SeekFrom::Start(self.length))?;
        }
        written
    }
}

fn write_error(path: &Path, source: io::Error) -> FileError {
    FileError::Write {
        path: path.into(),
        source,
    }
}
