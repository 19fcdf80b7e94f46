//! Published robots, against Pinocchio.

use approx::assert_relative_eq;
use hydroelastic::io::FileError;
use hydroelastic::io::urdf::{Collision, Robot, ShapeOptions, UrdfError};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Rounding error of chains of up to 20 poses with translations of about 1 m, and of tensors of about 1 kg m².
const ROUND_OFF: f64 = 1e-13;

/// Pose of a link at position zero of all joints, and its inertia.
#[derive(Deserialize)]
pub struct Reference {
    rotation: Matrix,
    pub translation: [f64; 3],
    mass: f64,
    center_of_mass: [f64; 3],
    inertia: Matrix,
}

type Matrix = [[f64; 3]; 3];

fn matrix(rows: Matrix) -> Matrix3<f64> {
    Matrix3::from(rows).transpose()
}

pub fn references(path: &Path) -> BTreeMap<String, BTreeMap<String, Reference>> {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robots")
}

/// Poses of the links at position zero of all joints, relative to the root.
fn poses(robot: &Robot) -> BTreeMap<&str, Pose> {
    let mut poses = BTreeMap::from([(robot.links()[0].name.as_str(), Pose::identity())]);
    for joint in robot.joints() {
        let pose = poses[joint.parent.as_str()] * joint.origin;
        poses.insert(&joint.child, pose);
    }
    poses
}

fn check(robot: &Robot, expected: &BTreeMap<String, Reference>) {
    assert_eq!(robot.links().len(), expected.len());
    let poses = poses(robot);
    for link in robot.links() {
        let reference = &expected[&link.name];
        let pose = &poses[link.name.as_str()];
        assert_relative_eq!(
            *pose.rotation(),
            matrix(reference.rotation),
            epsilon = ROUND_OFF
        );
        let translation = Vector3::from(reference.translation);
        assert_relative_eq!(*pose.translation(), translation, epsilon = ROUND_OFF);
        let Some(found) = link.inertial else {
            assert!(reference.mass == 0.0, "{}", link.name);
            continue;
        };
        // Pinocchio drops the inertia of a link without mass.
        if found.mass > 0.0 {
            let center = Vector3::from(reference.center_of_mass);
            assert_relative_eq!(found.mass, reference.mass);
            assert_relative_eq!(found.center_of_mass, center, epsilon = ROUND_OFF);
            assert_relative_eq!(
                found.inertia,
                matrix(reference.inertia),
                epsilon = ROUND_OFF
            );
        }
    }
}

#[test]
fn poses_and_inertias_of_published_robots_are_those_of_pinocchio() {
    let robots = references(&folder().join("links.json"));
    assert_eq!(robots.len(), 3);
    for (file, expected) in robots {
        check(&Robot::read(folder().join(file)).unwrap(), &expected);
    }
}

#[test]
fn the_fingers_of_a_gripper_mimic_each_other() {
    let panda = Robot::read(folder().join("panda.urdf")).unwrap();
    let named = |name: &str| {
        panda
            .joints()
            .iter()
            .find(|joint| joint.name == name)
            .unwrap()
    };
    let mimic = named("panda_finger_joint2").mimic.as_ref().unwrap();
    assert_eq!(mimic.joint, "panda_finger_joint1");
    let limit = named("panda_joint1").limit.unwrap();
    assert_eq!(limit.range, Some([-2.8973, 2.8973]));
    assert_eq!((limit.effort, limit.velocity), (Some(87.0), Some(2.175)));
}

/// Name of the package.
pub const PACKAGE: &str = "example-robot-data";

/// File without a name and links.
const EMPTY: &str = "ur3.urdf";

#[test]
#[ignore = "needs a folder of robots: see tests/data/robots/README.md"]
fn all_published_robots_are_read() {
    let Ok(folder) = std::env::var("ROBOTS").map(PathBuf::from) else {
        eprintln!("skipped: the variable ROBOTS is not set");
        return;
    };
    let expected = references(&folder.join("links.json"));
    let mut counts = [0; 4];
    for path in urdf_files(&folder) {
        let robot = match Robot::read(&path) {
            Ok(robot) => robot,
            Err(error) => {
                println!("{error}");
                assert!(path.ends_with(EMPTY), "{error}");
                continue;
            }
        };
        for warning in robot.warnings() {
            println!("{warning}");
        }
        let name = path.strip_prefix(&folder).unwrap().to_str().unwrap();
        check(&robot, &expected[name]);
        counts[0] += 1;
        counts[1] += robot.links().len();
        counts[2] += robot
            .links()
            .iter()
            .map(|link| link.collisions.len())
            .sum::<usize>();
        counts[3] += robot.warnings().len();
    }
    let [robots, links, collisions, warnings] = counts;
    println!("{robots} robots, {links} links, {collisions} geometries, {warnings} warnings");
    assert!(robots > 0);
}

#[test]
#[ignore = "needs a folder of robots: see tests/data/robots/README.md"]
fn geometries_of_all_published_robots_become_shapes_or_named_errors() {
    let Ok(folder) = std::env::var("ROBOTS").map(PathBuf::from) else {
        eprintln!("skipped: the variable ROBOTS is not set");
        return;
    };
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    // Many links share a mesh.
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    for path in urdf_files(&folder) {
        let package = path.ancestors().find(|parent| parent.ends_with(PACKAGE));
        let options = ShapeOptions {
            packages: BTreeMap::from([(PACKAGE.to_owned(), package.unwrap().to_owned())]),
            ..ShapeOptions::default()
        };
        let Ok(robot) = Robot::read(&path) else {
            continue;
        };
        for collision in robot.links().iter().flat_map(|link| &link.collisions) {
            let key = format!("{:?}", collision.geometry);
            let outcome = known
                .entry(key)
                .or_insert_with(|| outcome(collision, &options));
            *counts.entry(outcome.clone()).or_default() += 1;
        }
    }
    for (outcome, count) in &counts {
        println!("{count:5} {outcome}");
    }
    assert!(counts["Compliant"] > 0 && counts["Rigid"] > 0);
}

/// Kind of the shape, or of the error.
fn outcome(collision: &Collision, options: &ShapeOptions) -> String {
    let text = match collision.shape(options) {
        Ok((shape, _)) => format!("{shape:?}"),
        Err(UrdfError::MeshFile { source, .. }) => match *source {
            FileError::Surface { source, .. } => format!("{source:?}"),
            FileError::UnknownExtension { found, .. } => format!("extension {found}"),
            source => format!("{source:?}"),
        },
        Err(error) => format!("{error:?}"),
    };
    text.split(['(', '{'])
        .next()
        .unwrap_or_default()
        .trim()
        .to_owned()
}

pub fn urdf_files(folder: &Path) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(urdf_files(&path));
        } else if path
            .extension()
            .is_some_and(|extension| extension == "urdf")
        {
            files.push(path);
        }
    }
    files.sort();
    files
}
