//! Trajectory files, written and read back.

use crate::support::worlds::{cuboid, dynamic, falling, fixed, icosphere, turned};
use hydroelastic::dynamics::{
    BodyState, Integrator, Joint, Material, Plan, State, Trajectory, World,
};
use hydroelastic::io::{FileError, TrajectoryFile, write_trajectory};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, vector};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rounding error of converting a rotation matrix to a quaternion and back.
const ROTATION: f64 = 1e-14;

/// A name that requires quotes in CSV.
const BALL: &str = "ball, the \"first\"";

const COLUMNS: &str = "time,body,position_x,position_y,position_z,orientation_w,orientation_x,\
    orientation_y,orientation_z,velocity_x,velocity_y,velocity_z,spin_x,spin_y,spin_z";

/// A row of a file, as numbers without the body's name.
struct Row {
    body: String,
    numbers: Vec<f64>,
}

impl Row {
    fn vector(&self, first: usize) -> Vector3<f64> {
        Vector3::from_column_slice(&self.numbers[first..first + 3])
    }

    fn rotation(&self) -> Matrix3<f64> {
        let [w, x, y, z] = [4, 5, 6, 7].map(|column| self.numbers[column]);
        let quaternion = Quaternion::new(w, x, y, z);
        assert!((quaternion.norm() - 1.0).abs() < ROTATION);
        let rotation = UnitQuaternion::new_unchecked(quaternion).to_rotation_matrix();
        rotation.into_inner()
    }
}

/// Returns a rotating ball that falls on a floor.
fn world() -> World {
    let skin = Material::elastic(1e5);
    let ball = Arc::new(icosphere(0.1, 1));
    let slab = Arc::new(cuboid([1.0, 1.0, 0.2]));
    let start = turned([0.3, 2.0, 0.1], [0.1, 0.0, 0.22]);
    let ball = dynamic(BALL, ball, skin, 1.0);
    let ball = ball
        .with_pose(start)
        .with_velocity(vector![1e-9, -0.1, 0.0])
        .with_angular_velocity(vector![1.0, 20.0, -3.0]);
    let floor = fixed("floor", slab, skin);
    falling(vec![ball, floor])
}

fn trajectory(world: &World) -> Trajectory {
    let plan = Plan::new(1e-3, 300).unwrap().recording_every(3);
    world.rollout(&plan).run().unwrap()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

/// Returns the rows of a trajectory's file.
fn written(name: &str, trajectory: &Trajectory) -> Vec<Row> {
    let path = file(name);
    write_trajectory(&path, &world(), trajectory).unwrap();
    let mut reader = csv::Reader::from_path(&path).unwrap();
    let rows = reader.records().map(|record| {
        let record = record.unwrap();
        let number = |(_, field): (usize, &str)| field.parse::<f64>().unwrap();
        let is_number = |(column, _): &(usize, &str)| *column != 1;
        Row {
            body: record[1].to_owned(),
            numbers: record
                .iter()
                .enumerate()
                .filter(is_number)
                .map(number)
                .collect(),
        }
    });
    rows.collect()
}

fn bits(vector: &Vector3<f64>) -> [u64; 3] {
    [0, 1, 2].map(|axis| vector[axis].to_bits())
}

fn assert_is(row: &Row, state: &State, body: &BodyState) {
    assert_eq!(row.numbers[0].to_bits(), state.time.to_bits());
    assert_eq!(bits(&row.vector(1)), bits(body.pose.translation()));
    assert_eq!(bits(&row.vector(8)), bits(&body.twist.linear));
    assert_eq!(bits(&row.vector(11)), bits(&body.twist.angular));
    let turned_away = (row.rotation() - body.pose.rotation()).amax();
    assert!(turned_away <= ROTATION, "{turned_away:e}");
}

#[test]
fn a_file_reads_back_to_the_same_bits() {
    let trajectory = trajectory(&world());
    let rows = written("same_bits.csv", &trajectory);
    let expected = trajectory.states().iter().flat_map(|state| {
        let bodies = [BALL, "floor"].into_iter().zip(&state.bodies);
        bodies.map(move |(name, body)| (name, state, body))
    });
    assert_eq!(rows.len(), 2 * 101);
    for (row, (name, state, body)) in rows.iter().zip(expected) {
        assert_eq!(row.body, name);
        assert_is(row, state, body);
    }
}

#[test]
fn the_first_line_names_the_columns() {
    let path = file("columns.csv");
    let world = world();
    write_trajectory(&path, &world, &trajectory(&world)).unwrap();
    let text = fs::read_to_string(path).unwrap();
    assert_eq!(text.lines().next().unwrap(), COLUMNS);
}

/// An arm with a revolute, a ball, a mimicking and a prismatic joint, beside a free ball.
fn arm() -> World {
    let skin = Material::elastic(1e5);
    let part = |name: &str| dynamic(name, Arc::new(icosphere(0.02, 0)), skin, 1.0);
    let on = |body: &str, joint: Joint| part(body).with_joint(joint).unwrap();
    let hinge = Joint::revolute("hinge", Vector3::z_axis())
        .with_position(20.0)
        .with_velocity(0.3);
    let gear = Joint::revolute("gear", Vector3::x_axis()).with_mimic("hinge", 2.0, 0.0);
    let slide = Joint::prismatic("slide", Vector3::x_axis())
        .with_parent("upper")
        .with_velocity(-0.1);
    falling(vec![
        part("free"),
        on("upper", hinge),
        on("head", Joint::ball("neck").with_parent("upper")),
        on("wheel", gear),
        on("hand", slide),
    ])
}

#[test]
fn a_table_has_the_positions_and_velocities_of_joints() {
    let world = arm();
    let plan = Plan::new(1e-3, 2).unwrap();
    let plan = plan.with_integrator(Integrator::ImplicitEuler);
    let trajectory = world.rollout(&plan).run().unwrap();
    let whole = file("joints.csv");
    write_trajectory(&whole, &world, &trajectory).unwrap();
    let text = fs::read_to_string(&whole).unwrap();
    let columns = format!("{COLUMNS},joint,joint_position,joint_velocity");
    assert_eq!(text.lines().next().unwrap(), columns);
    let mut reader = csv::Reader::from_path(&whole).unwrap();
    let mut found = reader.records().map(|record| {
        let record = record.unwrap();
        let numbers = [16, 17].map(|column| record[column].parse::<f64>().ok());
        (record[15].to_owned(), numbers.map(|x| x.map(f64::to_bits)))
    });
    for state in trajectory.states() {
        let of = |name: &str, index: usize| {
            let joint = &state.joints[index];
            let numbers = [joint.position(), joint.velocity()];
            (name.to_owned(), numbers.map(|x| x.map(f64::to_bits)))
        };
        let none = || (String::new(), [None; 2]);
        let expected = [none(), of("hinge", 0), none(), none(), of("slide", 2)];
        assert!(found.by_ref().take(5).eq(expected));
    }
    let growing = file("growing_joints.csv");
    let _ = fs::remove_file(&growing);
    let mut rows = TrajectoryFile::create_new(&growing, &world).unwrap();
    for state in trajectory.states() {
        rows.push(state).unwrap();
    }
    assert_eq!(fs::read_to_string(growing).unwrap(), text);
    let mut jointless = trajectory.last().clone();
    jointless.joints.pop();
    assert!(matches!(
        rows.push(&jointless).unwrap_err(),
        FileError::OtherWorld {
            quantity: "joints with a state",
            found: 2,
            expected: 3,
            ..
        }
    ));
}

#[test]
fn a_thinned_trajectory_makes_every_so_manyth_row() {
    let trajectory = trajectory(&world());
    let all = written("all.csv", &trajectory);
    let thinned = written("thinned.csv", &trajectory.thinned(7));
    // States 0, 7, …, 98 of 101, with two bodies each.
    assert_eq!(thinned.len(), 2 * 15);
    let kept = all.chunks(2).step_by(7).flatten();
    for (row, from_all) in thinned.iter().zip(kept) {
        assert_eq!(row.numbers, from_all.numbers);
    }
}

#[test]
fn a_shorter_file_replaces_a_longer_one() {
    let trajectory = trajectory(&world());
    let first = written("replaced.csv", &trajectory).len();
    let second = written("replaced.csv", &trajectory.thinned(50)).len();
    assert_eq!([first, second], [2 * 101, 2 * 3]);
}

/// The available formats.
const FORMATS: &[&str] = if cfg!(feature = "parquet") {
    &["csv", "parquet"]
} else {
    &["csv"]
};

#[test]
fn a_trajectory_goes_to_no_other_format() {
    let world = world();
    let trajectory = trajectory(&world);
    for (name, extension) in [("motion.txt", "txt"), ("motion", ""), ("csv", "")] {
        let path = file(name);
        let error = write_trajectory(&path, &world, &trajectory).unwrap_err();
        let FileError::UnknownExtension {
            found, expected, ..
        } = error
        else {
            panic!("{error}")
        };
        assert_eq!((found.as_str(), expected), (extension, FORMATS));
        assert!(!path.exists());
    }
    write_trajectory(file("upper_case.CSV"), &world, &trajectory).unwrap();
}

#[cfg(not(feature = "parquet"))]
#[test]
fn without_the_feature_parquet_is_no_format() {
    let world = world();
    let path = file("motion.parquet");
    let error = write_trajectory(&path, &world, &trajectory(&world)).unwrap_err();
    let message = error.to_string();
    let expected = r#"ends in "parquet", but has to end in one of ["csv"]"#;
    assert!(message.ends_with(expected), "{message}");
    assert!(!path.exists());
}

#[test]
fn a_file_that_cannot_be_written_is_named() {
    let world = world();
    let path = file("no_such_folder/motion.csv");
    let error = write_trajectory(&path, &world, &trajectory(&world)).unwrap_err();
    let FileError::Write {
        path: named,
        source,
    } = error
    else {
        panic!("{error}")
    };
    assert_eq!(named, path);
    assert_eq!(source.kind(), std::io::ErrorKind::NotFound);
}

#[test]
fn a_trajectory_of_another_world_is_refused() {
    let whole = world();
    let ball_alone = World::new(whole.bodies()[..1].to_vec()).unwrap();
    let path = file("other_world.csv");
    let error = write_trajectory(&path, &ball_alone, &trajectory(&whole)).unwrap_err();
    assert!(matches!(
        error,
        FileError::OtherWorld {
            found: 2,
            expected: 1,
            ..
        }
    ));
    assert!(!path.exists());
}
