use super::{check_count, columns, csv_file, rows_of};
use crate::dynamics::{Body, Force, State, World};
use crate::io::FileError;
use crate::io::files::extension::known_extension;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Extensions of appendable trajectory files.
const EXTENSIONS: &[&str] = &["csv"];

/// A CSV file that states are appended to during a rollout. Use it for rollouts that are too long for the memory or that must not be
/// lost. The table has the columns of [`write_trajectory`](super::write_trajectory).
///
/// - If the process panics or is killed, the file contains all states that were pushed before. The last state may be incomplete, and
///   its last line may be truncated.
/// - If the disk is full, [`Self::push`] returns an error, and the file ends with the last complete state.
/// - If the operating system crashes, states that were pushed after the last call of [`Self::sync`] may be lost.
///
/// Parquet is not supported, because a Parquet file cannot be read without its footer, which is written last.
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
    /// Length of the file up to the end of the last complete state (bytes).
    length: u64,
}

impl TrajectoryFile {
    /// Creates a file without states.
    ///
    /// # Errors
    /// - If the extension is not `.csv`.
    /// - If the file exists. The results of an earlier run are never overwritten.
    /// - If the file cannot be written.
    pub fn create_new<F: Force>(
        path: impl AsRef<Path>,
        world: &World<f64, F>,
    ) -> Result<Self, FileError> {
        let path = path.as_ref();
        known_extension(path, EXTENSIONS)?;
        let file = File::create_new(path).map_err(|source| write_error(path, source))?;
        let mut trajectory_file = Self {
            path: path.into(),
            file,
            bodies: world.bodies().to_vec(),
            length: 0,
        };
        if let Err(source) = csv_file::header(&columns(world.bodies()))
            .and_then(|line| trajectory_file.append(&line))
        {
            // An error is ignored, because a file without its header contains no data.
            let _ = fs::remove_file(path);
            return Err(write_error(path, source));
        }
        Ok(trajectory_file)
    }

    /// Appends the rows of a state, and passes them to the operating system.
    ///
    /// # Errors
    /// - If the number of bodies or joints differs between the state and the world.
    /// - If the file cannot be written. The file then ends with the previous state.
    pub fn push(&mut self, state: &State) -> Result<(), FileError> {
        check_count(&self.path, &self.bodies, state)?;
        let lines = csv_file::lines(&columns(&self.bodies), rows_of(&self.bodies, state));
        let appended = lines.and_then(|lines| self.append(&lines));
        appended.map_err(|source| write_error(&self.path, source))
    }

    /// Waits until all pushed states are on the disk.
    ///
    /// # Errors
    /// If the operating system reports a failure.
    pub fn sync(&self) -> Result<(), FileError> {
        let synced = self.file.sync_all();
        synced.map_err(|source| write_error(&self.path, source))
    }

    /// Appends bytes. On failure, tries to truncate the file to its previous length.
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
