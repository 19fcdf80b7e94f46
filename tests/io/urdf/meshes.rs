//! Files of meshes.

use super::robot;
use hydroelastic::io::urdf::{Collision, Robot, UrdfError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn mesh(file: &str) -> String {
    format!(
        "<link name=\"hand\"><collision><geometry><mesh filename=\"{file}\"/></geometry></collision></link>"
    )
}

fn collision(file: &str) -> Collision {
    robot(&mesh(file)).unwrap().links()[0].collisions[0].clone()
}

fn packages() -> BTreeMap<String, PathBuf> {
    BTreeMap::from([("arm".to_owned(), "/opt/arm".into())])
}

#[test]
fn paths_of_meshes_are_resolved() {
    for (file, expected) in [
        ("package://arm/meshes/hand.stl", "/opt/arm/meshes/hand.stl"),
        ("package:///arm/meshes/hand.stl", "/opt/arm/meshes/hand.stl"),
        ("file:///opt/hand.stl", "/opt/hand.stl"),
        ("/opt/hand.stl", "/opt/hand.stl"),
        ("meshes/hand.stl", "meshes/hand.stl"),
    ] {
        let path = collision(file).mesh_path(&packages()).unwrap();
        assert_eq!(path.as_deref(), Some(Path::new(expected)), "{file}");
    }
}

#[test]
fn a_relative_path_begins_at_the_folder_of_the_urdf_file() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let file = folder.join("relative.urdf");
    let text = format!("<robot name='arm'>{}</robot>", mesh("../hand.stl"));
    std::fs::write(&file, text).unwrap();
    let robot = Robot::read(&file).unwrap();
    assert_eq!(robot.path(), Some(file.as_path()));
    let path = robot.links()[0].collisions[0]
        .mesh_path(&packages())
        .unwrap();
    assert_eq!(path, Some(folder.join("../hand.stl")));
}

#[test]
fn an_unknown_package_is_an_error_when_the_path_is_needed() {
    let error = collision("package://leg/hand.stl")
        .mesh_path(&packages())
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "line 2: <mesh> of link \"hand\" refers to the package \"leg\", but only the folders of [\"arm\"] were given"
    );
}

#[test]
fn other_schemes_are_errors() {
    let error = collision("https://arm.org/hand.stl")
        .mesh_path(&packages())
        .unwrap_err();
    assert!(matches!(error, UrdfError::UnknownScheme { .. }), "{error}");
}

#[test]
fn a_geometry_that_is_no_mesh_has_no_path() {
    let ball = mesh("").replace("mesh filename=\"\"", "sphere radius=\"1\"");
    let robot = robot(&ball).unwrap();
    assert_eq!(
        robot.links()[0].collisions[0]
            .mesh_path(&packages())
            .unwrap(),
        None
    );
}
