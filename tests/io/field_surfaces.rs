//! Surface files as programs write them, in `tests/data/field_files`. Each file has its solid, or an error that names the remedy.

use hydroelastic::io::{FileError, Placement, read_triangle_surface, read_triangles};
use hydroelastic::mesh::{SurfaceError, SurfaceFaults, SurfaceWarning, TriangleSurface};
use nalgebra::{Vector3, vector};
use std::path::{Path, PathBuf};

const ROUND_OFF: f64 = 1e-14;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/field_files")
        .join(name)
}

fn read(name: &str) -> Result<TriangleSurface, FileError> {
    read_triangle_surface(file(name), &Placement::default())
}

fn refusal(name: &str) -> SurfaceError {
    match read(name) {
        Err(FileError::Surface { source, .. }) => source,
        other => panic!("{name}: {other:?}"),
    }
}

#[test]
fn files_of_closed_solids_have_their_volumes() {
    for (name, volume) in [
        ("continued.obj", 1.0 / 6.0),
        ("two_corners.obj", 1.0 / 6.0),
        ("end_solid.stl", 1.0 / 6.0),
        ("tetrahedron.ply", 1.0 / 6.0),
        ("tetrahedron.off", 1.0 / 6.0),
        ("no_area.obj", 1.0),
        ("touch_in_an_edge.stl", 2.0),
        ("u_prism.obj", 7.0),
        ("l_prism.obj", 2.75),
    ] {
        let surface = read(name).unwrap_or_else(|error| panic!("{error}"));
        assert!(
            (surface.volume() - volume).abs() < ROUND_OFF,
            "{name}: {}",
            surface.volume()
        );
        assert_eq!(surface.warnings(), [], "{name}");
    }
    assert_eq!(read("touch_in_an_edge.stl").unwrap().component_count(), 2);
}

#[test]
fn caps_of_a_concave_prism_are_filled_once() {
    let prism = read("u_prism.obj").unwrap();
    let corners = (0..prism.triangles().len()).map(|triangle| prism.corners(triangle));
    let caps = corners.filter(|corners| corners.iter().all(|corner| corner.z > 0.5));
    let area: f64 = caps
        .map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 2.0)
        .sum();
    assert!((area - 7.0).abs() < ROUND_OFF, "{area}");
}

#[test]
fn vertices_one_rounding_error_apart_are_merged_with_a_warning() {
    let cube = read("ulp_apart.stl").unwrap();
    assert_eq!(cube.vertices().len(), 8);
    assert!((cube.volume() - 1e-3).abs() < 1e-9);
    let warnings = cube.warnings();
    let [SurfaceWarning::Welded { distance, .. }] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!(distance > 0.0 && distance < 1e-7, "{distance:e}");
}

#[test]
fn overlapping_parts_are_reported_with_the_volume_that_counts_twice() {
    let parts = read("overlap.stl").unwrap();
    assert!((parts.volume() - 2.0).abs() < ROUND_OFF);
    let warnings = parts.warnings();
    let [
        SurfaceWarning::Overlap {
            pair_count: 1,
            volume,
            ..
        },
    ] = warnings[..]
    else {
        panic!("{warnings:?}");
    };
    assert!((volume - 0.5).abs() < 0.01, "{volume}");
}

#[test]
fn a_file_turned_inwards_is_flipped_on_request() {
    let refused = refusal("inwards.obj");
    assert!(refused.to_string().contains("flipped"), "{refused}");
    let soup = read_triangles(file("inwards.obj"), &Placement::default()).unwrap();
    assert!((soup.flipped().closed().unwrap().volume() - 1.0).abs() < ROUND_OFF);
}

fn faults(name: &str) -> SurfaceFaults {
    match refusal(name) {
        SurfaceError::NotClosed(faults) => *faults,
        refused => panic!("{refused}"),
    }
}

#[test]
fn open_files_report_all_faults_and_have_a_hull() {
    let open = faults("open_box.obj");
    assert_eq!(open.open.map(|fault| fault.count), Some(4));
    assert_eq!(
        (open.inconsistent, open.unbalanced, open.thin),
        (None, None, None)
    );
    let reversed = faults("open_and_reversed.obj");
    assert!(reversed.open.is_some() && reversed.inconsistent.is_some());
    for name in ["open_box.obj", "open_and_reversed.obj", "points.obj"] {
        let refused = refusal(name).to_string();
        assert!(refused.contains("hull=True"), "{refused}");
        let soup = read_triangles(file(name), &Placement::default()).unwrap();
        let hull = soup.convex_hull().unwrap().closed().unwrap();
        assert!((hull.volume() - 1.0).abs() < ROUND_OFF, "{name}");
    }
}

#[test]
fn a_placement_moves_mirrors_and_scales() {
    let placement = Placement {
        unit: 0.01,
        scale: vector![-1.0, 2.0, 1.0],
        pose: hydroelastic::spatial::Pose::from_translation(vector![1.0, 0.0, 0.0]),
    };
    let surface = read_triangle_surface(file("tetrahedron.off"), &placement).unwrap();
    assert!((surface.volume() * 1e6 - 1.0 / 3.0).abs() < 1e-13);
    let bounds = surface.aabb();
    assert!((bounds.lower - vector![0.99, 0.0, 0.0]).amax() < ROUND_OFF);
    assert!((bounds.upper - vector![1.0, 0.02, 0.01]).amax() < ROUND_OFF);
    for scale in [vector![0.0, 1.0, 1.0], vector![1.0, f64::NAN, 1.0]] {
        let placement = Placement {
            scale,
            ..Placement::default()
        };
        let refused = read_triangles(file("tetrahedron.off"), &placement).unwrap_err();
        assert!(
            matches!(&refused, FileError::Option { name, .. } if name == "scale"),
            "{refused}"
        );
    }
    let small =
        read_triangle_surface(file("tetrahedron.off"), &Placement::from_unit(1e-5)).unwrap();
    assert!(matches!(
        small.warnings()[..],
        [SurfaceWarning::Size { .. }]
    ));
}

#[test]
fn an_empty_scene_is_an_error_of_the_surface() {
    assert_eq!(
        refusal("empty.dae"),
        SurfaceError::TooFewTriangles { count: 0 }
    );
    let none: Vec<Vector3<f64>> = Vec::new();
    let soup = read_triangles(file("empty.dae"), &Placement::default()).unwrap();
    assert_eq!(soup.vertices, none);
}
