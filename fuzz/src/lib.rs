//! Functions shared by the fuzz targets: bytes read as a mesh file, as a surface file or as a robot.

use hydroelastic::io::urdf::Robot;
use hydroelastic::io::{MeshFile, MeshOptions, Placement, read_mesh, read_triangle_surface};
use hydroelastic::mesh::{PressureField, TriangleSurface};
use std::path::PathBuf;

/// Reads the bytes as a mesh file with that extension. A mesh that is accepted must be one: with a volume,
/// and extents by distance that make a field or are refused.
///
/// # Panics
/// If the file of the bytes cannot be written, or an accepted mesh is none.
pub fn read(extension: &str, bytes: &[u8]) {
    let path = file_of(extension);
    std::fs::write(&path, bytes).expect("the file for the bytes can be written");
    match read_mesh(&path, &MeshOptions::default()) {
        Ok(file) => check(&file),
        Err(error) => check_error(&path, &error.to_string()),
    }
}

/// Reads the bytes as a surface file with that extension. A surface that is accepted must be closed and have a volume.
///
/// # Panics
/// If the file of the bytes cannot be written, or an accepted surface is none.
pub fn read_surface(extension: &str, bytes: &[u8]) {
    let path = file_of(extension);
    std::fs::write(&path, bytes).expect("the file for the bytes can be written");
    match read_triangle_surface(&path, &Placement::default()) {
        Ok(surface) => {
            check_surface(&surface);
            let _ = surface.warnings();
        }
        Err(error) => check_error(&path, &error.to_string()),
    }
}

/// Reads the bytes as a URDF file. A robot that is accepted must be a tree, with parents before children.
///
/// # Panics
/// If the file of the bytes cannot be written, or an accepted robot is not a tree.
pub fn read_robot(bytes: &[u8]) {
    let path = file_of("urdf");
    std::fs::write(&path, bytes).expect("the file for the bytes can be written");
    match Robot::read(&path) {
        Ok(robot) => {
            assert_eq!(robot.links().len(), robot.joints().len() + 1);
            for (joint, child) in robot.joints().iter().zip(&robot.links()[1..]) {
                assert_eq!(joint.child, child.name);
            }
        }
        Err(error) => check_error(&path, &error.to_string()),
    }
}

/// One file for each process: targets run side by side.
fn file_of(extension: &str) -> PathBuf {
    let name = format!("hydroelastic_fuzz_{}.{extension}", std::process::id());
    std::env::temp_dir().join(name)
}

fn check(file: &MeshFile) {
    assert!(file.mesh.tet_count() > 0);
    assert!(file.mesh.volume() > 0.0);
    for values in file.point_data.values() {
        assert_eq!(values.len(), file.mesh.vertex_count());
    }
    if let Ok(field) = PressureField::from_distance(&file.mesh) {
        assert!(field.extents().iter().all(|extent| extent.is_finite()));
    }
}

fn check_surface(surface: &TriangleSurface) {
    assert!(surface.volume() > 0.0);
    assert!(surface.mass_properties(1.0).unwrap().mass.is_finite());
    for triangle in 0..surface.triangles().len() {
        for edge in 0..3 {
            let neighbor = surface.neighbor(triangle, edge);
            let is_back = |back: usize| surface.neighbor(neighbor, back) == triangle;
            assert!((0..3).any(is_back));
        }
    }
}

fn check_error(path: &std::path::Path, message: &str) {
    let name = path.display().to_string();
    assert!(message.contains(&name), "no file is named by: {message}");
}
