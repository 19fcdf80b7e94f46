use super::{
    FileError,
    mesh_file::{extension, unknown_extension},
};
use crate::dynamics::{BodyState, ExternalForces, Trajectory, World};
use nalgebra::Isometry3;
use std::path::Path;

/// What the name of a trajectory file can end in.
const EXTENSIONS: &[&str] = &["csv"];

/// The names of the columns.
const HEADER: [&str; 15] = [
    "time",
    "body",
    "position_x",
    "position_y",
    "position_z",
    "orientation_w",
    "orientation_x",
    "orientation_y",
    "orientation_z",
    "velocity_x",
    "velocity_y",
    "velocity_z",
    "spin_x",
    "spin_y",
    "spin_z",
];

/// Writes a trajectory of a world as CSV, a row for each state and body, in the order of the states.
///
/// The columns, all in the world frame: time (s), name of the body, position of its origin (m),
/// orientation as a unit quaternion (w x y z; its sign has no meaning), velocity of its centre of
/// mass (m/s; for a body on a prescribed path, of its origin), spin (rad/s). Numbers have as many
/// digits as it takes to read back the same `f64`.
///
/// ```
/// use hydroelastic::contact::Shape;
/// use hydroelastic::dynamics::{Body, Integrator, Mass, Material, World};
/// use hydroelastic::io::write_trajectory;
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
/// use std::sync::Arc;
///
/// let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1)?));
/// let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// let world = World::new(vec![ball])?.with_gravity(Vector3::new(0.0, 0.0, -9.81))?;
/// let trajectory = world.rollout(1e-3, Integrator::Leapfrog)?.recorded(400, 100)?;
/// let path = std::env::temp_dir().join("falling_ball.csv");
/// write_trajectory(&path, &world, &trajectory)?;
/// assert_eq!(std::fs::read_to_string(&path)?.lines().count(), 1 + 5);
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the extension is not `.csv`, a state has more or fewer bodies than the world, or the file
/// cannot be written.
pub fn write_trajectory<F: ExternalForces>(
    path: impl AsRef<Path>,
    world: &World<f64, F>,
    trajectory: &Trajectory,
) -> Result<(), FileError> {
    let path = path.as_ref();
    if !EXTENSIONS.contains(&extension(path).as_str()) {
        return Err(unknown_extension(path, EXTENSIONS));
    }
    let expected = world.bodies().len();
    let mut counts = trajectory.states().iter().map(|state| state.bodies.len());
    if let Some(found) = counts.find(|&count| count != expected) {
        return Err(FileError::OtherWorld {
            path: path.into(),
            found,
            expected,
        });
    }
    write_rows(path, world, trajectory).map_err(|error| FileError::Write {
        path: path.into(),
        source: system_error(error),
    })
}

/// What the system says; csv's own conversion would hide it in an error of another kind.
fn system_error(error: csv::Error) -> std::io::Error {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => std::io::Error::other(format!("{other:?}")),
    }
}

fn write_rows<F: ExternalForces>(
    path: &Path,
    world: &World<f64, F>,
    trajectory: &Trajectory,
) -> Result<(), csv::Error> {
    let mut writer = csv::WriterBuilder::new()
        .has_headers(false)
        .from_path(path)?;
    writer.write_record(HEADER)?;
    for state in trajectory.states() {
        for (body, body_state) in world.bodies().iter().zip(&state.bodies) {
            writer.serialize((state.time, body.name(), numbers(body_state)))?;
        }
    }
    Ok(writer.flush()?)
}

/// Position, orientation, velocity, spin.
fn numbers(state: &BodyState) -> Vec<f64> {
    let orientation = Isometry3::from(state.pose).rotation;
    let [position, velocity, spin] = [state.position(), state.velocity(), &state.twist.angular];
    let [i, j, k, w] = orientation.coords.into();
    let parts = [
        position.as_slice(),
        &[w, i, j, k],
        velocity.as_slice(),
        spin.as_slice(),
    ];
    parts.concat()
}
