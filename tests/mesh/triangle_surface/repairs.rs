//! Repairs of triangles that are almost a closed surface.

use super::sample_surfaces::{Triangulation, block, reversed, soup, together, torus, unit_block};
use hydroelastic::mesh::{SurfaceError, SurfaceWarning, TriangleSoup};
use nalgebra::{Vector3, vector};

const ROUND_OFF: f64 = 1e-14;

fn of((vertices, triangles): Triangulation) -> TriangleSoup {
    TriangleSoup {
        vertices,
        triangles,
    }
}

/// Returns triangles without shared vertices. Each corner is moved by up to `distance` (m) along each axis.
fn scattered(parts: &Triangulation, distance: f64) -> TriangleSoup {
    let mut scattered = TriangleSoup::from_corners(&soup(parts));
    for (vertex, position) in scattered.vertices.iter_mut().enumerate() {
        let step = |axis: usize| ((vertex * 7 + axis * 3) % 5) as f64 / 4.0 - 0.5;
        *position += Vector3::from_fn(|axis, _| step(axis)) * 2.0 * distance;
    }
    scattered
}

#[test]
fn vertices_a_rounding_error_apart_are_merged_at_any_position() {
    // The offsets place the vertices on both sides of the borders of any grid.
    for offset in [0.0, 1e-7, 0.3, 1.0 / 3.0, -7.0] {
        let cube = block(Vector3::repeat(offset), Vector3::repeat(1.0));
        for (distance, limit) in [(4e-8, 1e-7), (4e-7, 1e-6)] {
            let surface = scattered(&cube, distance).closed().unwrap();
            assert_eq!(surface.vertices().len(), 8);
            assert!((surface.volume() - 1.0).abs() < 10.0 * distance);
            let warnings = surface.warnings();
            let [
                SurfaceWarning::Welded {
                    vertex_count,
                    distance: moved,
                },
            ] = warnings[..]
            else {
                panic!("{warnings:?}");
            };
            assert!(vertex_count > 8 && vertex_count <= 28, "{vertex_count}");
            assert!(moved > distance && moved <= 4.0 * limit, "{moved:e}");
        }
        let apart = scattered(&cube, 1e-5).closed().unwrap_err();
        assert!(matches!(apart, SurfaceError::NotClosed(_)), "{apart}");
        let welded = scattered(&cube, 1e-5).welded(3e-5).unwrap();
        assert_eq!(welded.closed().unwrap().vertices().len(), 8);
    }
    let exact = TriangleSoup::from_corners(&soup(&unit_block(Vector3::zeros())));
    assert_eq!(exact.closed().unwrap().warnings(), []);
}

#[test]
fn merging_follows_chains_of_vertices() {
    let along = |x: f64| vector![x, 0.0, 0.0];
    let soup = TriangleSoup {
        vertices: [0.0, 1.0, 0.95, 0.1, 0.2, 5.0].map(along).to_vec(),
        triangles: vec![[0, 1, 5], [4, 2, 5], [3, 0, 5]],
    };
    let welded = soup.welded(0.11).unwrap();
    assert_eq!(welded.vertices, [0.0, 1.0, 5.0].map(along));
    assert_eq!(welded.triangles, [[0, 1, 2], [0, 1, 2]]);
}

#[test]
fn triangles_without_area_are_removed_and_their_neighbors_split() {
    let (mut vertices, mut triangles) = unit_block(Vector3::zeros());
    // Points on the edge of the first triangle are corners of the triangles on one side only, and a fan of triangles without area
    // fills the gap.
    let [a, b, c] = triangles.remove(0);
    let points = [0.25, 0.5, 0.75].map(|t| vertices[a].lerp(&vertices[b], t));
    let first = vertices.len();
    vertices.extend(points);
    let path = [a, first, first + 1, first + 2, b];
    triangles.extend(path.windows(2).map(|ends| [ends[0], ends[1], c]));
    let fan = path.windows(2).skip(1).map(|ends| [a, ends[1], ends[0]]);
    triangles.extend(fan);
    let surface = of((vertices, triangles)).closed().unwrap();
    assert_eq!(
        (surface.vertices().len(), surface.triangles().len()),
        (11, 18)
    );
    assert!((surface.volume() - 1.0).abs() < ROUND_OFF);
    assert_eq!(surface.warnings(), []);
}

#[test]
fn faces_that_cancel_are_dropped() {
    let both = together([
        unit_block(Vector3::zeros()),
        unit_block(vector![1.0, 0.0, 0.0]),
    ]);
    let mut corners = soup(&both);
    // The diagonals of the common face must agree for its triangles to cancel.
    let [a, b, c, d] =
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[y, z]| vector![1.0, y, z]);
    corners.retain(|triangle| !triangle.iter().all(|corner| (corner.x - 1.0).abs() < 0.5));
    corners.extend([[a, b, c], [a, c, d], [a, c, b], [a, d, c]]);
    let joined = TriangleSoup::from_corners(&corners).closed().unwrap();
    assert_eq!(
        (joined.triangles().len(), joined.component_count()),
        (20, 1)
    );
    assert!((joined.volume() - 2.0).abs() < ROUND_OFF);
}

#[test]
fn an_inward_surface_is_flipped_on_request() {
    let inwards = of(reversed(torus(1.0, 0.3, [11, 7])));
    let refused = inwards.clone().closed().unwrap_err();
    assert!(refused.to_string().contains("flipped"), "{refused}");
    let outwards = of(torus(1.0, 0.3, [11, 7])).closed().unwrap();
    let flipped = inwards.flipped().closed().unwrap();
    assert!((flipped.volume() - outwards.volume()).abs() < ROUND_OFF);
}

#[test]
fn all_kinds_of_faults_are_counted_and_the_remedies_named() {
    let (mut vertices, mut triangles) = together([
        unit_block(Vector3::zeros()),
        unit_block(vector![3.0, 0.0, 0.0]),
        unit_block(vector![6.0, 0.0, 0.0]),
    ]);
    triangles[20].swap(0, 1);
    triangles.push(triangles[30]);
    triangles.remove(4);
    vertices.extend([[9.0, 0.0, 0.0], [10.0, 0.0, 0.0], [11.0, 0.0, 0.0]].map(Vector3::from));
    triangles.push([24, 25, 26]);
    let refused = of((vertices, triangles)).closed().unwrap_err();
    let text = refused.to_string();
    let SurfaceError::NotClosed(faults) = refused else {
        panic!("{text}");
    };
    let edges = [faults.open, faults.inconsistent, faults.unbalanced];
    assert_eq!(edges.map(|fault| fault.unwrap().count), [6, 3, 3]);
    let thin = faults.thin.unwrap();
    assert_eq!((thin.count, thin.first[1]), (1, vector![10.0, 0.0, 0.0]));
    for part in [
        "6 edges",
        "3 edges",
        "1 triangles have no area",
        "(9, 0, 0)",
        "convex_hull",
        "tetrahedra",
    ] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn unusual_sizes_are_reported() {
    for (size, is_unusual) in [(1e-5, true), (1e-3, false), (99.0, false), (101.0, true)] {
        let cube = of(block(Vector3::zeros(), Vector3::repeat(size)));
        let warnings = cube.closed().unwrap().warnings();
        let has_warning = matches!(warnings[..], [SurfaceWarning::Size { .. }]);
        assert_eq!(has_warning, is_unusual, "{warnings:?}");
    }
}
