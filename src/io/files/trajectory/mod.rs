//! Writers of trajectories as tables.

mod csv_appender;
mod csv_file;
#[cfg(feature = "parquet")]
mod parquet_file;

use super::FileError;
use super::atomic_write::atomic_write;
use super::extension::known_extension;
use crate::dynamics::{Body, BodyState, Force, Joint, JointKind, State, Trajectory, World};
pub use csv_appender::TrajectoryFile;
use nalgebra::Isometry3;
use std::path::Path;

/// Extensions of trajectory files.
const EXTENSIONS: &[&str] = if cfg!(feature = "parquet") {
    &["csv", "parquet"]
} else {
    &["csv"]
};

/// Names of the columns of every table: time, body, and the numbers of a row.
const COLUMNS: [&str; 15] = [
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

/// Names of the further columns of a table with joints.
const JOINT_COLUMNS: [&str; 3] = ["joint", "joint_position", "joint_velocity"];

/// State of a body at one time.
struct Row<'a> {
    /// Time (s).
    time: f64,
    /// Name of the body.
    body: &'a str,
    /// Position (m), orientation (quaternion w x y z), velocity (m/s), angular velocity (rad/s).
    numbers: [f64; 13],
    joint: Option<JointCells<'a>>,
}

/// State of a revolute or prismatic joint at one time.
struct JointCells<'a> {
    name: &'a str,
    /// Position (rad or m).
    position: f64,
    /// Velocity (rad/s or m/s).
    velocity: f64,
}

/// Writes a trajectory of a world as a table, with a row for each state and body, in the order of the states. The extension of the
/// file name selects the format:
///
/// - `.csv`: CSV, with enough digits to read back the same `f64`.
/// - `.parquet` (feature `parquet`): Apache Parquet, with doubles and UTF-8 strings, uncompressed.
///
/// The columns, in the world frame:
///
/// - time (s),
/// - name of the body,
/// - position of the origin of the body (m),
/// - orientation as a unit quaternion (w x y z, arbitrary sign),
/// - velocity of the center of mass (m/s), or of the origin for a kinematic body,
/// - angular velocity (rad/s).
///
/// If the world has revolute or prismatic joints, there are three further columns with the joint of the body. They are empty (null in
/// Parquet) for other bodies and for mimicking joints:
///
/// - name of the joint,
/// - position (rad, including full turns, or m),
/// - velocity (rad/s or m/s).
///
/// An existing file is replaced atomically after the new file has reached the disk. After a failure (a full disk, a killed process),
/// the existing file is unchanged. To write states to the disk during a rollout, use a [`TrajectoryFile`].
///
/// ```
/// use hydroelastic::contact::Shape;
/// use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
/// use hydroelastic::io::write_trajectory;
/// use hydroelastic::mesh::shapes;
/// use nalgebra::Vector3;
/// use std::sync::Arc;
///
/// let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1)?));
/// let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// let world = World::new(vec![ball])?.with_gravity(Vector3::new(0.0, 0.0, -9.81))?;
/// let trajectory = world.rollout(&Plan::new(1e-3, 400)?.recording_every(100)).run()?;
/// let path = std::env::temp_dir().join("falling_ball.csv");
/// write_trajectory(&path, &world, &trajectory)?;
/// assert_eq!(std::fs::read_to_string(&path)?.lines().count(), 1 + 5);
/// # std::fs::remove_file(path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// - If the extension is unknown.
/// - If the number of bodies or joints differs between a state and the world.
/// - If the file cannot be written.
pub fn write_trajectory<F: Force>(
    path: impl AsRef<Path>,
    world: &World<f64, F>,
    trajectory: &Trajectory,
) -> Result<(), FileError> {
    let path = path.as_ref();
    let write = match known_extension(path, EXTENSIONS)? {
        #[cfg(feature = "parquet")]
        "parquet" => parquet_file::write,
        _ => csv_file::write,
    };
    let bodies = world.bodies();
    check_fits(path, bodies, trajectory)?;
    let columns = columns(bodies);
    atomic_write(path, |file| {
        write(file, &columns, &mut rows(bodies, trajectory))
    })
}

/// Names of the columns.
fn columns(bodies: &[Body]) -> Vec<&'static str> {
    let mut columns = COLUMNS.to_vec();
    let mut joints = bodies.iter().filter_map(joint_with_state);
    if joints.any(|joint| *joint.kind() != JointKind::Ball) {
        columns.extend(JOINT_COLUMNS);
    }
    columns
}

/// The joint of a body, if a [`JointState`](crate::dynamics::JointState) belongs to it.
fn joint_with_state(body: &Body) -> Option<&Joint> {
    body.joint().filter(|joint| joint.initial_state().is_some())
}

/// Checks that all states have as many bodies and joints as the world.
pub(super) fn check_fits(
    path: &Path,
    bodies: &[Body],
    trajectory: &Trajectory,
) -> Result<(), FileError> {
    let mut states = trajectory.states().iter();
    states.try_for_each(|state| check_count(path, bodies, state))
}

/// Checks that a state has as many bodies and joints as the world.
fn check_count(path: &Path, bodies: &[Body], state: &State) -> Result<(), FileError> {
    let joints = bodies.iter().filter_map(joint_with_state).count();
    for (quantity, found, expected) in [
        ("bodies", state.bodies.len(), bodies.len()),
        ("joints with a state", state.joints.len(), joints),
    ] {
        if found != expected {
            return Err(FileError::OtherWorld {
                path: path.into(),
                quantity,
                found,
                expected,
            });
        }
    }
    Ok(())
}

/// Rows of the table: all bodies of the first state, then all bodies of the second state, and so on.
fn rows<'a>(bodies: &'a [Body], trajectory: &'a Trajectory) -> impl Iterator<Item = Row<'a>> {
    let states = trajectory.states().iter();
    states.flat_map(|state| rows_of(bodies, state))
}

/// Rows of a state.
fn rows_of<'a>(bodies: &'a [Body], state: &'a State) -> impl Iterator<Item = Row<'a>> {
    let mut joints = state.joints.iter();
    let bodies = bodies.iter().zip(&state.bodies);
    bodies.map(move |(body, body_state)| {
        let joint = joint_with_state(body).and_then(|joint| {
            let state = joints.next()?;
            Some(JointCells {
                name: joint.name(),
                position: state.position()?,
                velocity: state.velocity()?,
            })
        });
        Row {
            time: state.time,
            body: body.name(),
            numbers: numbers(body_state),
            joint,
        }
    })
}

fn numbers(state: &BodyState) -> [f64; 13] {
    let orientation = Isometry3::from(state.pose).rotation;
    let mut numbers = [0.0; 13];
    numbers[..3].copy_from_slice(state.position().as_slice());
    numbers[3] = orientation.w;
    numbers[4..7].copy_from_slice(orientation.imag().as_slice());
    numbers[7..10].copy_from_slice(state.velocity().as_slice());
    numbers[10..].copy_from_slice(state.twist.angular.as_slice());
    numbers
}
