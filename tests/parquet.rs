//! Trajectories in Parquet files, read by the `parquet` crate.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Joint, Mass, Material, Plan, Trajectory, World};
use hydroelastic::io::{FileError, write_trajectory};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Isometry3, Vector3, vector};
use parquet::basic::{LogicalType, Repetition, Type};
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const BALL: &str = "ball, the \"first\" für uns";

/// Number of rows that the writer buffers in memory.
const ROWS_PER_GROUP: i64 = 1 << 17;

/// Returns a rotating ball that falls on a floor. Its velocity has a negative zero, and the floor's velocity a positive zero.
fn world() -> World {
    let skin = Material::elastic(1e5);
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let slab = Arc::new(Shape::new(shapes::cuboid([1.0, 1.0, 0.2]).unwrap()));
    let start = Pose::from_rotation_vector(&vector![0.3, 2.0, 0.1], vector![0.1, 0.0, 0.22]);
    let ball = Body::dynamic(BALL, ball, skin, Mass::Total(1.0)).unwrap();
    let ball = ball
        .with_pose(start)
        .with_velocity(vector![-0.0, 1e-300, -0.1])
        .with_angular_velocity(vector![1.0, 20.0, -3.0]);
    let floor = Body::fixed("floor", slab, skin).unwrap();
    let world = World::new(vec![ball, floor]).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

fn trajectory(world: &World, steps: usize) -> Trajectory {
    let rollout = world.rollout(&Plan::new(1e-3, steps).unwrap());
    rollout.run().unwrap()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

fn reader(path: &Path) -> SerializedFileReader<File> {
    SerializedFileReader::new(File::open(path).unwrap()).unwrap()
}

/// Returns the name, and the bits of time and numbers, of each row.
fn rows(path: &Path) -> Vec<(String, Vec<u64>)> {
    let reader = reader(path);
    let rows = reader.get_row_iter(None).unwrap().map(|row| {
        let row = row.unwrap();
        let numbers = (0..15).filter(|&column| column != 1);
        let bits = numbers.map(|column| row.get_double(column).unwrap().to_bits());
        (row.get_string(1).unwrap().clone(), bits.collect())
    });
    rows.collect()
}

/// Returns the expected rows of a trajectory.
fn expected(trajectory: &Trajectory) -> Vec<(String, Vec<u64>)> {
    let of_state = |state: &hydroelastic::dynamics::State| {
        let time = state.time;
        let bodies = [BALL, "floor"].into_iter().zip(&state.bodies);
        let rows = bodies.map(|(name, body)| {
            let [i, j, k, w] = Isometry3::from(body.pose).rotation.coords.into();
            let mut numbers = vec![time];
            numbers.extend(body.position());
            numbers.extend([w, i, j, k]);
            numbers.extend(body.velocity());
            numbers.extend(&body.twist.angular);
            (
                name.to_owned(),
                numbers.into_iter().map(f64::to_bits).collect(),
            )
        });
        rows.collect::<Vec<_>>()
    };
    trajectory.states().iter().flat_map(of_state).collect()
}

#[test]
fn a_parquet_file_reads_back_to_the_same_bits() {
    let world = world();
    let trajectory = trajectory(&world, 300);
    let path = file("same_bits.parquet");
    write_trajectory(&path, &world, &trajectory).unwrap();
    let rows = rows(&path);
    assert_eq!(rows.len(), 2 * 301);
    assert_eq!(rows, expected(&trajectory));
    let velocity_x = rows.iter().map(|(_, bits)| bits[8]);
    let zeros: Vec<u64> = velocity_x.take(2).collect();
    assert_eq!(zeros, [(-0.0_f64).to_bits(), 0.0_f64.to_bits()]);
}

#[test]
fn the_columns_are_those_of_the_csv_file() {
    let world = world();
    let trajectory = trajectory(&world, 2);
    let (table, text) = (file("columns.parquet"), file("columns_beside.csv"));
    write_trajectory(&table, &world, &trajectory).unwrap();
    write_trajectory(&text, &world, &trajectory).unwrap();
    let text = fs::read_to_string(text).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let reader = reader(&table);
    let columns = reader.metadata().file_metadata().schema_descr().columns();
    assert_eq!(columns.len(), names.len());
    for (column, name) in columns.iter().zip(names) {
        assert_eq!(column.name(), name);
        let info = column.self_type().get_basic_info();
        assert_eq!(info.repetition(), Repetition::REQUIRED);
        let expected = if name == "body" {
            (Type::BYTE_ARRAY, Some(LogicalType::String))
        } else {
            (Type::DOUBLE, None)
        };
        let logical = info.logical_type_ref().cloned();
        assert_eq!((column.physical_type(), logical), expected);
    }
}

#[test]
fn joints_are_in_optional_columns() {
    let hinge = Joint::revolute("hinge", Vector3::z_axis())
        .with_position(20.0)
        .with_velocity(0.3);
    let [free, fixed] = [world().bodies()[0].clone(), world().bodies()[1].clone()];
    let arm = free.with_joint(hinge).unwrap();
    let world = World::new(vec![fixed, arm]).unwrap();
    let start = vec![world.initial_state(); 2];
    let path = file("joints.parquet");
    write_trajectory(&path, &world, &Trajectory::new(start).unwrap()).unwrap();
    let reader = reader(&path);
    let columns = reader.metadata().file_metadata().schema_descr().columns();
    let names: Vec<&str> = columns[15..].iter().map(|column| column.name()).collect();
    assert_eq!(names, ["joint", "joint_position", "joint_velocity"]);
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().collect();
    assert_eq!(rows.len(), 4);
    for (index, row) in rows.into_iter().enumerate() {
        let row = row.unwrap();
        if index % 2 == 0 {
            assert!(row.get_string(15).is_err() && row.get_double(16).is_err());
        } else {
            assert_eq!(row.get_string(15).unwrap(), "hinge");
            let numbers = [16, 17].map(|column| row.get_double(column).unwrap().to_bits());
            assert_eq!(numbers, [20.0_f64, 0.3].map(f64::to_bits));
        }
    }
}

#[test]
fn the_numbers_are_those_of_the_csv_file() {
    let world = world();
    let trajectory = trajectory(&world, 100);
    let (table, text) = (file("numbers.parquet"), file("numbers_beside.csv"));
    write_trajectory(&table, &world, &trajectory).unwrap();
    write_trajectory(&text, &world, &trajectory).unwrap();
    let mut records = csv::Reader::from_path(text).unwrap();
    let from_text = records.records().map(|record| {
        let record = record.unwrap();
        let numbers = (0..15).filter(|&column| column != 1);
        let bits = numbers.map(|column| record[column].parse::<f64>().unwrap().to_bits());
        (record[1].to_owned(), bits.collect::<Vec<_>>())
    });
    assert_eq!(rows(&table), from_text.collect::<Vec<_>>());
}

#[test]
fn a_long_trajectory_is_written_group_by_group() {
    let world = world();
    let short = trajectory(&world, 5);
    // The ball without the floor has no contact to compute.
    let ball = World::new(world.bodies()[..1].to_vec()).unwrap();
    let long = trajectory(&ball, 140_000);
    let path = file("long.parquet");
    write_trajectory(&path, &ball, &long).unwrap();
    let groups = |path: &Path| {
        let reader = reader(path);
        let groups = reader.metadata().row_groups().iter();
        groups.map(RowGroupMetaData::num_rows).collect::<Vec<_>>()
    };
    assert_eq!(groups(&path), [ROWS_PER_GROUP, 140_001 - ROWS_PER_GROUP]);
    let rows = rows(&path);
    for (row, state) in rows.iter().zip(long.states()) {
        assert_eq!(row.1[0], state.time.to_bits());
        assert_eq!(row.1[3], state.bodies[0].position().z.to_bits());
    }
    // A shorter file replaces the file.
    write_trajectory(&path, &world, &short).unwrap();
    assert_eq!(groups(&path), [2 * 6]);
}

#[test]
fn a_file_that_cannot_be_made_is_named() {
    let world = world();
    let path = file("no_such_folder/motion.parquet");
    let error = write_trajectory(&path, &world, &trajectory(&world, 1)).unwrap_err();
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

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_to_be_full() {
    let world = world();
    let path = file("full.parquet");
    let _ = fs::remove_file(&path);
    std::os::unix::fs::symlink("/dev/full", &path).unwrap();
    let error = write_trajectory(&path, &world, &trajectory(&world, 1)).unwrap_err();
    fs::remove_file(&path).unwrap();
    let FileError::Write { source, .. } = error else {
        panic!("{error}")
    };
    assert_eq!(source.kind(), std::io::ErrorKind::StorageFull);
}
