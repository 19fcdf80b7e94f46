//! Repairs of triangles that are almost a closed surface.

use super::sample_surfaces::{Triangulation, block, reversed, soup, together, torus, unit_block};
use hydroelastic::mesh::{SurfaceError, SurfaceWarning, TriangleSoup, TriangleSurface};
use nalgebra::{Vector3, vector};
use std::time::{Duration, Instant};

const ROUND_OFF: f64 = 1e-14;

/// Time limit for 24,000 vertices in one cell, which took 0.01 s in the last measurement. A search of all pairs takes half a minute.
const TIME: Duration = Duration::from_secs(5);

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
    let [a, b, _] = triangles[30];
    triangles.push([a, b, 27]);
    triangles.remove(4);
    let row = [9.0, 10.0, 11.0, 12.0].map(|x| vector![x, 0.0, 0.0]);
    vertices.extend(row);
    triangles.push([24, 25, 26]);
    let refused = of((vertices, triangles)).closed().unwrap_err();
    let text = refused.to_string();
    let SurfaceError::NotClosed(faults) = refused else {
        panic!("{text}");
    };
    let edges = [faults.open, faults.inconsistent, faults.unbalanced];
    assert_eq!(edges.map(|fault| fault.unwrap().count), [8, 3, 1]);
    let thin = faults.thin.unwrap();
    assert_eq!((thin.count, thin.first[1]), (1, vector![10.0, 0.0, 0.0]));
    assert_eq!(faults.repeated.unwrap().count, 1);
    for part in [
        "8 edges",
        "3 edges",
        "1 triangles repeat",
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
    for (size, is_unusual) in [(1e-5, true), (1e-3, false), (9.9, false), (10.1, true)] {
        let cube = of(block(Vector3::zeros(), Vector3::repeat(size)));
        let warnings = cube.closed().unwrap().warnings();
        let has_warning = matches!(warnings[..], [SurfaceWarning::Size { .. }]);
        assert_eq!(has_warning, is_unusual, "{warnings:?}");
    }
}

#[test]
fn repeated_triangles_are_dropped_and_reported() {
    for (vertices, triangles) in [
        unit_block(Vector3::zeros()),
        torus(1.0, 0.3, [11, 7]),
        torus(1.0, 0.3, [8, 8]),
    ] {
        let count = triangles.len();
        let once = of((vertices.clone(), triangles.clone())).closed().unwrap();
        let mut thrice = [&triangles[..], &triangles, &triangles].concat();
        for (index, triangle) in thrice.iter_mut().enumerate() {
            triangle.rotate_left(index % 3);
        }
        let kept = of((vertices, thrice)).closed().unwrap();
        assert_eq!(kept.triangles().len(), count);
        assert!((kept.volume() - once.volume()).abs() < ROUND_OFF);
        let triangle_count = 2 * count;
        assert_eq!(
            kept.warnings(),
            [SurfaceWarning::Repeated { triangle_count }]
        );
    }
}

#[test]
fn one_repeated_triangle_is_dropped() {
    let (vertices, mut triangles) = unit_block(Vector3::zeros());
    triangles.push(triangles[5]);
    let cube = of((vertices, triangles)).closed().unwrap();
    assert_eq!(cube.triangles().len(), 12);
    assert!((cube.volume() - 1.0).abs() < ROUND_OFF);
    assert_eq!(
        cube.warnings(),
        [SurfaceWarning::Repeated { triangle_count: 1 }]
    );
}

#[test]
fn a_common_face_of_overlapping_parts_stays_twice() {
    // Two tetrahedra on the same side of a triangle. One apex is above the other.
    let mut vertices = vec![
        vector![0.0, 0.0, 0.0],
        vector![1.0, 0.0, 0.0],
        vector![0.0, 1.0, 0.0],
    ];
    vertices.extend([vector![0.2, 0.3, 1.0], vector![0.2, 0.3, 0.5]]);
    let tetrahedron = |d| [[0, 2, 1], [0, 1, d], [0, d, 2], [1, 2, d]];
    let both = [tetrahedron(3), tetrahedron(4)].concat();
    let both = of((vertices, both)).closed().unwrap();
    assert_eq!((both.triangles().len(), both.component_count()), (8, 2));
    assert!((both.volume() - 0.25).abs() < ROUND_OFF);
    let [SurfaceWarning::Overlap { volume, .. }] = both.warnings()[..] else {
        panic!("{:?}", both.warnings());
    };
    assert!((volume * 12.0 - 1.0).abs() < 0.1, "{volume}");
}

#[test]
fn copies_of_a_part_are_components_of_their_own() {
    for (vertices, triangles) in [unit_block(Vector3::zeros()), torus(1.0, 0.3, [8, 8])] {
        let count = triangles.len();
        // Five is coprime to the count of all triangles.
        let twice = (0..2 * count).map(|k| triangles[(5 * k + 2) % (2 * count) % count]);
        let twice = TriangleSurface::new(vertices, twice.collect()).unwrap();
        assert_eq!(twice.component_count(), 2);
        let warnings = twice.warnings();
        let [SurfaceWarning::Overlap { volume, .. }] = warnings[..] else {
            panic!("{warnings:?}");
        };
        let expected = twice.volume() / 2.0;
        assert!((volume / expected - 1.0).abs() < 0.05, "{volume}");
    }
}

#[test]
fn spikes_without_width_leave_no_vertices() {
    let (mut vertices, mut triangles) = unit_block(Vector3::zeros());
    vertices.extend([vector![0.0, 0.0, 3.0], vector![0.0, 0.0, 5.0]]);
    triangles.extend([[1, 0, 8], [0, 1, 9], [0, 9, 8], [1, 8, 9]]);
    let cube = of((vertices, triangles)).closed().unwrap();
    assert_eq!(cube.vertices().len(), 8);
    assert_eq!(cube.aabb().upper, vector![1.0, 1.0, 1.0]);
    assert!((cube.volume() - 1.0).abs() < ROUND_OFF);
}

#[test]
fn spikes_of_finite_width_are_not_removed() {
    for length in [1e11, 1e13] {
        let (mut vertices, triangles) = unit_block(Vector3::zeros());
        vertices[2].y = length;
        match of((vertices, triangles)).closed() {
            Ok(spike) => assert!((spike.volume() / length - 1.0 / 3.0).abs() < 1e-6),
            Err(SurfaceError::NotClosed(faults)) => assert!(faults.thin.is_some()),
            Err(error) => assert!(matches!(error, SurfaceError::Flat { .. }), "{error}"),
        }
    }
    for length in [1e110, 1e200] {
        let (mut vertices, triangles) = unit_block(Vector3::zeros());
        vertices[2].y = length;
        let error = of((vertices, triangles)).closed().unwrap_err();
        let is_beyond_precision = matches!(error, SurfaceError::BeyondPrecision { .. });
        assert!(is_beyond_precision, "{error}");
    }
}

#[test]
fn sheets_are_refused_with_the_numbers_before_and_after_the_repairs() {
    let (vertices, triangles) = unit_block(Vector3::zeros());
    let (_, back) = reversed((Vec::new(), triangles.clone()));
    let both = [triangles, back].concat();
    let refused = of((vertices, both)).closed().unwrap_err();
    let expected = SurfaceError::Cancelled {
        given: 24,
        count: 0,
    };
    assert_eq!(refused, expected);
    // Merging within a tolerance makes a foil of these triangles, but the fault is the hole.
    let (vertices, mut triangles) = block(Vector3::zeros(), vector![1.0, 1.0, 5e-8]);
    triangles.pop();
    let refused = of((vertices, triangles)).closed().unwrap_err();
    let SurfaceError::NotClosed(faults) = refused else {
        panic!("{refused}");
    };
    assert_eq!(faults.open.unwrap().count, 3);
}

#[test]
fn many_vertices_in_one_cell_are_merged_in_near_linear_time() {
    let mut corners = soup(&unit_block(Vector3::zeros()));
    corners.pop();
    let speck = |k: usize, axis: usize| ((k * (axis + 7) * 7919) % 10_007) as f64 * 1e-11;
    let vertex = |k: usize| Vector3::from_fn(|axis, _| 0.3 + speck(k, axis));
    corners.extend((0..8000).map(|k| [vertex(3 * k), vertex(3 * k + 1), vertex(3 * k + 2)]));
    let start = Instant::now();
    let refused = TriangleSoup::from_corners(&corners).closed().unwrap_err();
    let welded = TriangleSoup::from_corners(&corners).welded(2e-7).unwrap();
    assert!(start.elapsed() < TIME, "{:?}", start.elapsed());
    assert!(matches!(refused, SurfaceError::NotClosed(_)), "{refused}");
    assert_eq!(welded.triangles.len(), 11);
}

#[test]
fn components_are_turned_outwards_one_by_one() {
    let cavity = || reversed(block(Vector3::repeat(0.25), Vector3::repeat(0.5)));
    let both = together([
        unit_block(Vector3::zeros()),
        cavity(),
        reversed(unit_block(vector![3.0, 0.0, 0.0])),
    ]);
    let both = of(both);
    let refused = both.clone().closed().unwrap_err();
    assert!(matches!(refused, SurfaceError::Inward { .. }), "{refused}");
    let (outward, count) = both.with_outward_components().unwrap();
    assert_eq!(count, 1);
    assert!((outward.closed().unwrap().volume() - 1.875).abs() < ROUND_OFF);
}
