//! Dynamics of published robots, compared with Pinocchio.

use super::published::folder;
use hydroelastic::dynamics::{Kinetics, Material, World};
use hydroelastic::io::urdf::{MeshShape, Robot, RobotOptions, ShapeOptions};
use nalgebra::{DMatrix, DVector, vector};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Round-off of sums over up to 101 links.
const ROUND_OFF: f64 = 1e-12;

/// Quantities of a robot on a fixed base, in the order of its joints.
#[derive(Deserialize)]
struct Reference {
    /// Position, velocity and acceleration of each joint.
    states: BTreeMap<String, [f64; 3]>,
    joints: Vec<String>,
    mass_matrix: Vec<Vec<f64>>,
    bias: Vec<f64>,
    inverse_dynamics: Vec<f64>,
    by_positions: Vec<Vec<f64>>,
    by_velocities: Vec<Vec<f64>>,
}

fn references(path: &Path) -> BTreeMap<String, Reference> {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// World of the robot at the state of the reference, or the error of the conversion.
fn world(robot: &Robot, reference: &Reference) -> Result<World, String> {
    let options = RobotOptions {
        shapes: ShapeOptions {
            meshes: MeshShape::None,
            ..ShapeOptions::default()
        },
        ..RobotOptions::new(Material::elastic(1e6))
    };
    let mechanism = robot
        .mechanism(&options)
        .map_err(|error| error.to_string())?;
    let mechanism = mechanism.with_joints(|joint| {
        let [position, velocity, _] = reference.states[joint.name()];
        joint.with_position(position).with_velocity(velocity)
    });
    let builder = World::builder().mechanism(mechanism);
    let world = builder.gravity(vector![0.0, 0.0, -9.81]).build();
    world.map_err(|error| error.to_string())
}

/// Column of each joint of the reference.
fn columns(robot: &Robot, world: &World, kinetics: &Kinetics, names: &[String]) -> Vec<usize> {
    let column = |name: &String| {
        let joint = robot.joints().iter().find(|joint| joint.name == *name);
        let body = world.index_of(&joint.unwrap().child).unwrap();
        kinetics.columns(body).unwrap().start
    };
    names.iter().map(column).collect()
}

/// Largest errors of the mass matrix, the bias, the inverse dynamics and its derivatives. Each is relative to the largest entry of the quantity
/// or of the mass matrix, because some quantities are zero.
fn errors(robot: &Robot, reference: &Reference) -> Result<[f64; 5], String> {
    let world = world(robot, reference)?;
    let kinetics = world.kinetics(&world.initial_state()).unwrap();
    let names = &reference.joints;
    let columns = columns(robot, &world, &kinetics, names);
    assert_eq!(columns.len(), kinetics.velocity_count());
    let mut accelerations = DVector::zeros(columns.len());
    for (name, &column) in names.iter().zip(&columns) {
        accelerations[column] = reference.states[name][2];
    }
    let forces = kinetics.inverse_dynamics(&accelerations).unwrap();
    let slopes = kinetics.inverse_dynamics_derivatives(&accelerations);
    let slopes = slopes.unwrap();
    let scale = kinetics.mass_matrix().amax();
    let matrix_error = |found: &DMatrix<f64>, expected: &dyn Fn(usize, usize) -> f64| {
        let size = columns.len();
        let expected = DMatrix::from_fn(size, size, expected);
        let found = DMatrix::from_fn(size, size, |i, j| found[(columns[i], columns[j])]);
        (found - &expected).amax() / expected.amax().max(scale)
    };
    let vector_error = |found: &DVector<f64>, expected: &[f64]| {
        let found = DVector::from_fn(columns.len(), |i, _| found[columns[i]]);
        let expected = DVector::from_column_slice(expected);
        (found - &expected).amax() / expected.amax().max(scale)
    };
    let mass = &reference.mass_matrix;
    Ok([
        matrix_error(&kinetics.mass_matrix(), &|i, j| mass[i.max(j)][i.min(j)]),
        vector_error(&kinetics.bias(), &reference.bias),
        vector_error(&forces, &reference.inverse_dynamics),
        matrix_error(&slopes.by_positions, &|i, j| reference.by_positions[i][j]),
        matrix_error(&slopes.by_velocities, &|i, j| reference.by_velocities[i][j]),
    ])
}

#[test]
fn the_dynamics_of_published_robots_agree_with_pinocchio() {
    let references = references(&folder().join("dynamics.json"));
    assert_eq!(references.len(), 3);
    for (file, reference) in references {
        let robot = Robot::read(folder().join(&file)).unwrap();
        let errors = errors(&robot, &reference).unwrap();
        assert!(
            errors.iter().all(|&error| error < ROUND_OFF),
            "{file}: {errors:?}"
        );
    }
}

#[test]
#[ignore = "needs a folder of robots: see tests/data/robots/README.md"]
fn the_dynamics_of_all_published_robots_agree_with_pinocchio() {
    let Ok(folder) = std::env::var("ROBOTS").map(PathBuf::from) else {
        eprintln!("skipped: the variable ROBOTS is not set");
        return;
    };
    let (mut agreeing, mut largest) = (0, [0.0_f64; 5]);
    let references = references(&folder.join("dynamics.json")).into_iter();
    for (file, reference) in references.filter(|(_, robot)| !robot.joints.is_empty()) {
        let robot = Robot::read(folder.join(&file)).unwrap();
        let errors = match errors(&robot, &reference) {
            Ok(errors) => errors,
            Err(error) => {
                println!("{file}: {error}");
                continue;
            }
        };
        assert!(
            errors.iter().all(|&error| error < ROUND_OFF),
            "{file}: {errors:?}"
        );
        agreeing += 1;
        for (largest, error) in largest.iter_mut().zip(errors) {
            *largest = largest.max(error);
        }
    }
    println!("{agreeing} robots agree, largest errors {largest:?}");
    assert!(agreeing > 0);
}
