//! Convex hulls of points.

use hydroelastic::mesh::{MeshError, SurfaceError, TriangleSoup, TriangleSurface, shapes};
use nalgebra::{Rotation3, Vector3, vector};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::time::{Duration, Instant};

#[path = "../support/hulls.rs"]
mod brute_force;

/// Relative rounding error of sums over some thousand tetrahedra.
const SUM_ROUND_OFF: f64 = 1e-12;

/// Distance of a point outside its hull, relative to the largest distance of a vertex of the hull from the origin.
const TOLERANCE: f64 = 2e-10;

/// Time limit for 20,000 points on a sphere, which took 0.05 s in the last measurement.
const TIME: Duration = Duration::from_secs(5);

fn hull(points: &[Vector3<f64>]) -> Result<TriangleSurface, SurfaceError> {
    let soup = TriangleSoup {
        vertices: points.to_vec(),
        triangles: Vec::new(),
    };
    soup.convex_hull()?.closed()
}

/// Asserts that the hull contains the points, and returns it.
fn containing(points: &[Vector3<f64>]) -> TriangleSurface {
    let hull = hull(points).unwrap();
    assert_eq!(hull.component_count(), 1);
    assert!(hull.vertices().iter().all(|vertex| points.contains(vertex)));
    let allowed = TOLERANCE * hull.reach();
    for triangle in 0..hull.triangles().len() {
        let [a, b, c] = hull.corners(triangle);
        let normal = (b - a).cross(&(c - a)).normalize();
        let highest = points.iter().map(|point| (point - a).dot(&normal));
        let highest = highest.fold(f64::NEG_INFINITY, f64::max);
        // The normal of a thin triangle is inexact.
        let height = (b - a).cross(&(c - a)).norm() / (b - a).norm().max((c - a).norm());
        assert!(
            highest <= allowed * (1.0 + hull.reach() / height * 1e-6),
            "{highest:e}"
        );
    }
    hull
}

/// Returns points spread over a sphere by the golden angle.
fn points_on_sphere(radius: f64, count: usize) -> Vec<Vector3<f64>> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let point = |k: usize| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / count as f64;
        let (sine, cosine) = (golden_angle * k as f64).sin_cos();
        let across = (1.0 - z * z).sqrt();
        vector![across * cosine, across * sine, z] * radius
    };
    (0..count).map(point).collect()
}

/// Returns the points of a grid in a box.
fn grid(counts: [usize; 3], lengths: [f64; 3]) -> Vec<Vector3<f64>> {
    let [nx, ny, nz] = counts;
    let point = |k: usize| {
        let steps = [k % nx, k / nx % ny, k / nx / ny];
        Vector3::from_fn(|axis, _| steps[axis] as f64 / (counts[axis] - 1) as f64 * lengths[axis])
    };
    (0..nx * ny * nz).map(point).collect()
}

#[test]
fn the_hull_of_the_vertices_of_an_icosphere_is_the_icosphere() {
    let ball = shapes::icosphere(0.3, 3).unwrap();
    // The center is one of the points.
    let hull = shapes::convex_hull(ball.mesh().vertices()).unwrap();
    assert_eq!(hull.mesh().tet_count(), ball.mesh().tet_count());
    assert_eq!(hull.mesh().vertex_count(), ball.mesh().vertex_count());
    assert!((hull.mesh().volume() / ball.mesh().volume() - 1.0).abs() < SUM_ROUND_OFF);
}

#[test]
fn hulls_of_points_on_a_sphere_approach_the_ball() {
    let ball = 4.0 / 3.0 * PI * 0.5_f64.powi(3);
    let missing = |count: usize| {
        let hull = containing(&points_on_sphere(0.5, count));
        // Euler's formula: V − E + F = 2.
        assert_eq!(hull.triangles().len(), 2 * count - 4);
        1.0 - hull.volume() / ball
    };
    let [few, many] = [250, 1000].map(missing);
    assert!(many > 0.0 && many < 0.01, "{many}");
    // With a quarter of the area per point, the height below the sphere is a quarter too.
    assert!((3.5..4.5).contains(&(few / many)), "{}", few / many);
}

#[test]
fn points_on_common_planes_and_lines_have_a_hull() {
    for counts in [[2, 2, 2], [3, 3, 3], [9, 5, 2], [7, 7, 7]] {
        let lengths = [1.0, 0.7, 0.3];
        let points = grid(counts, lengths);
        let flat = containing(&points);
        assert!((flat.volume() / 0.21 - 1.0).abs() < SUM_ROUND_OFF);
        // A rotation makes the faces flat to round-off only, and single precision makes them bumpy.
        let turn = Rotation3::new(vector![0.3, -1.2, 0.7]);
        let turned: Vec<_> = points
            .iter()
            .map(|p| turn * p + vector![5.0, 0.0, -3.0])
            .collect();
        assert!((containing(&turned).volume() / 0.21 - 1.0).abs() < SUM_ROUND_OFF);
        let single: Vec<_> = turned
            .iter()
            .map(|p| p.cast::<f32>().cast::<f64>())
            .collect();
        assert!((containing(&single).volume() / 0.21 - 1.0).abs() < 1e-5);
        // Sizes near the limits of double precision of volumes.
        for scale in [1e-60, 1e50] {
            let scaled: Vec<_> = points.iter().map(|p| p * scale).collect();
            let volume = hull(&scaled).unwrap().volume() / scale.powi(3);
            assert!((volume / 0.21 - 1.0).abs() < SUM_ROUND_OFF);
        }
    }
    let mut prism = points_on_sphere(1.0, 40);
    for point in &mut prism {
        point.z = point.z.signum();
    }
    containing(&prism);
}

proptest! {
    #[test]
    fn hulls_match_brute_force(
        points in prop::collection::vec(prop::array::uniform3(-1.0..1.0), 4..20),
    ) {
        let points: Vec<Vector3<f64>> = points.into_iter().map(Vector3::from).collect();
        let hull = containing(&points);
        let expected = brute_force::hull(points);
        prop_assert_eq!(hull.triangles().len(), expected.mesh().tet_count());
        let relative = hull.volume() / expected.mesh().volume() - 1.0;
        prop_assert!(relative.abs() < 1e-9, "{relative:e}");
    }

    #[test]
    fn points_of_few_coordinates_have_a_hull(
        points in prop::collection::vec(prop::array::uniform3(0..4_i32), 12..60),
    ) {
        let points: Vec<Vector3<f64>> =
            points.into_iter().map(|point| Vector3::from(point.map(f64::from))).collect();
        if hull(&points).is_ok() {
            containing(&points);
        }
    }
}

#[test]
fn points_without_a_hull_are_refused() {
    let corner = vector![1.0, 2.0, 3.0];
    let bad = [corner, vector![0.0, f64::INFINITY, 0.0]];
    assert_eq!(
        hull(&bad).unwrap_err().to_string(),
        "vertex 1 has the coordinate inf, but coordinates must be finite"
    );
    let mut in_a_plane = points_on_sphere(1.0, 50);
    for point in &mut in_a_plane {
        point.z = 0.25;
    }
    for points in [
        vec![],
        vec![corner],
        vec![corner; 2],
        vec![corner; 50],
        in_a_plane,
    ] {
        let refused = hull(&points).unwrap_err();
        let point_count = points.len();
        assert_eq!(refused, SurfaceError::FlatHull { point_count });
        let refused = shapes::convex_hull(&points).unwrap_err();
        assert!(matches!(refused, MeshError::Surface(_)), "{refused}");
    }
}

#[test]
fn many_points_have_a_hull_quickly() {
    let start = Instant::now();
    let hull = hull(&points_on_sphere(1.0, 20_000)).unwrap();
    let elapsed = start.elapsed();
    println!("{} triangles: {elapsed:.2?}", hull.triangles().len());
    assert!(elapsed < TIME, "{elapsed:?}");
}

#[test]
fn hulls_far_from_the_origin_keep_their_vertices() {
    let far = Vector3::repeat(1e6);
    let points: Vec<_> = points_on_sphere(0.01, 200)
        .iter()
        .map(|p| p + far)
        .collect();
    let near: Vec<_> = points.iter().map(|point| point - far).collect();
    let [far, near] = [points, near].map(|points| hull(&points).unwrap());
    assert_eq!(far.vertices().len(), 200);
    assert_eq!(far.triangles().len(), near.triangles().len());
    assert!((far.volume() / near.volume() - 1.0).abs() < 1e-10);
}
