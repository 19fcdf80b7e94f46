//! A surface that is not closed is rejected, and the error names the fault.

use super::sample_surfaces::{Triangulation, block, reversed, soup, together, unit_block};
use crate::tet_mesh::sample_meshes::grid;
use hydroelastic::mesh::{SurfaceError, SurfaceFaults, TriangleSoup, TriangleSurface};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

fn cube() -> Triangulation {
    unit_block(Vector3::zeros())
}

fn refusal((vertices, triangles): Triangulation) -> SurfaceError {
    TriangleSurface::new(vertices, triangles).unwrap_err()
}

#[test]
fn numbers_that_are_no_triangles_are_refused() {
    let (vertices, triangles) = cube();
    let few = (vertices.clone(), triangles[..3].to_vec());
    assert_eq!(refusal(few), SurfaceError::TooFewTriangles { count: 3 });

    let (mut infinite, triangles) = cube();
    infinite[5].y = f64::INFINITY;
    let value = f64::INFINITY;
    let expected = SurfaceError::NonFiniteCoordinate { vertex: 5, value };
    assert_eq!(refusal((infinite, triangles)), expected);

    let (vertices, mut triangles) = cube();
    triangles[7][2] = 8;
    let expected = SurfaceError::VertexOutOfRange {
        triangle: 7,
        vertex: 8,
        vertex_count: 8,
    };
    assert_eq!(refusal((vertices, triangles)), expected);

    let (vertices, mut triangles) = cube();
    triangles[7][2] = triangles[7][0];
    let vertex = triangles[7][0];
    let expected = SurfaceError::RepeatedVertex {
        triangle: 7,
        vertex,
    };
    assert_eq!(refusal((vertices, triangles)), expected);

    let (mut vertices, triangles) = cube();
    vertices.push(Vector3::zeros());
    assert_eq!(
        refusal((vertices, triangles)),
        SurfaceError::UnusedVertex { vertex: 8 }
    );
}

#[test]
fn a_soup_that_is_not_finite_is_refused_by_its_corner() {
    let mut corners = soup(&cube());
    corners[4][1].z = f64::NAN;
    let refused = TriangleSoup::from_corners(&corners).closed().unwrap_err();
    assert!(
        matches!(
            refused,
            SurfaceError::NonFiniteCoordinate { vertex: 13, .. }
        ),
        "{refused}"
    );
    let refused = TriangleSoup::default().closed().unwrap_err();
    assert_eq!(refused, SurfaceError::TooFewTriangles { count: 0 });
}

/// Returns the faults of a surface that is not closed.
fn faults(refused: SurfaceError) -> SurfaceFaults {
    let SurfaceError::NotClosed(faults) = refused else {
        panic!("{refused}");
    };
    *faults
}

#[test]
fn holes_are_counted_and_one_is_shown() {
    let (vertices, mut triangles) = cube();
    let removed = triangles.remove(6).map(|vertex| vertices[vertex]);
    let open = faults(refusal((vertices, triangles))).open.unwrap();
    assert_eq!(open.count, 3);
    // The hole's edge, in the direction of the triangle beside it.
    assert!((0..3).any(|k| [removed[(k + 1) % 3], removed[k]] == open.first));
}

#[test]
fn a_triangle_turned_the_wrong_way_round_is_found() {
    let (vertices, mut triangles) = cube();
    triangles[8].swap(0, 1);
    let turned = triangles[8].map(|vertex| vertices[vertex]);
    let inconsistent = faults(refusal((vertices, triangles))).inconsistent.unwrap();
    assert_eq!(inconsistent.count, 3);
    assert!(inconsistent.first.iter().all(|end| turned.contains(end)));
}

#[test]
fn blocks_that_touch_in_an_edge_are_two_components() {
    let beside = unit_block(vector![1.0, 1.0, 0.0]);
    let both = soup(&together([cube(), beside]));
    let welded = TriangleSoup::from_corners(&both).closed().unwrap();
    assert_eq!((welded.vertices().len(), welded.component_count()), (14, 2));
    assert_eq!(welded.component_starts(), [0, 12]);
    assert!((welded.volume() - 2.0).abs() < 1e-14);
    // Two cells of a mesh share an edge.
    let mesh = grid([2, 2, 1], 1.0, |[x, y, _]| x == y);
    let around = TriangleSurface::around(&mesh).unwrap();
    assert_eq!(around.component_count(), 2);
    // Four cells, two of which share each of six edges, leave four others out around a point.
    let mesh = grid([2, 2, 2], 1.0, |[x, y, z]| (x + y + z) % 2 == 0);
    let around = TriangleSurface::around(&mesh).unwrap();
    assert_eq!(around.component_count(), 4);
    assert!((around.volume() - 4.0).abs() < 1e-14);
}

#[test]
fn an_edge_of_three_triangles_is_refused() {
    let (vertices, mut triangles) = cube();
    triangles.push(triangles[4]);
    let unbalanced = faults(refusal((vertices, triangles))).unbalanced.unwrap();
    assert_eq!(unbalanced.count, 3);
}

#[test]
fn triangles_are_thin_below_a_trillionth_and_no_sooner() {
    // A tetrahedron over a triangle whose height is this fraction of its longest edge.
    let over = |height: f64| {
        let base = [
            vector![0.0, 0.0, 0.0],
            vector![1.0, 0.0, 0.0],
            vector![0.5, height, 0.0],
        ];
        let vertices = base.into_iter().chain([vector![0.5, 0.3, 1.0]]).collect();
        (vertices, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    };
    let refused = refusal(over(0.9e-12));
    assert!(
        matches!(refused, SurfaceError::ThinTriangle { triangle: 0, .. }),
        "{refused}"
    );
    // A solid over so thin a triangle is so flat that 1e-12 of the cubed diagonal exceeds its volume.
    let refused = refusal(over(1.1e-12));
    assert!(
        matches!(refused, SurfaceError::Flat { triangle: 0, .. }),
        "{refused}"
    );
    let (vertices, triangles) = over(1e-11);
    assert!(TriangleSurface::new(vertices, triangles).is_ok());
}

/// Returns a pyramid over a triangle in a plane z = const, counter-clockwise seen from above, with its apex below.
fn pyramid(base: [Vector3<f64>; 3], apex: Vector3<f64>) -> Triangulation {
    let vertices = base.into_iter().chain([apex]).collect();
    (vertices, vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
}

#[test]
fn flat_solids_are_refused() {
    let base = [
        vector![0.0, 0.0, 0.0],
        vector![1.0, 0.0, 0.0],
        vector![0.0, 1.0, 0.0],
    ];
    let sheet = pyramid(base, vector![0.3, 0.3, -1e-14]);
    let refused = refusal(together([cube(), sheet]));
    assert!(
        matches!(refused, SurfaceError::Flat { triangle: 12, .. }),
        "{refused}"
    );
}

#[test]
fn a_surface_turned_inwards_is_refused_unless_it_is_a_cavity() {
    let refused = refusal(reversed(cube()));
    assert!(
        matches!(refused, SurfaceError::Inward { triangle: 0, volume, .. } if (volume + 1.0).abs() < 1e-14)
    );

    // The inner surface is beside the solid, in the bounding box around the concave part of an L, or in a cavity, and never inside the
    // solid.
    let beside = unit_block(vector![3.0, 0.0, 0.0]);
    let refused = refusal(together([beside, reversed(cube())]));
    assert!(
        matches!(refused, SurfaceError::Inward { triangle: 12, .. }),
        "{refused}"
    );

    let angle = TriangleSurface::around(&grid([2, 2, 1], 4.0, |[x, y, _]| x < 1 || y < 1)).unwrap();
    let angle = (angle.vertices().to_vec(), angle.triangles().to_vec());
    let in_the_hollow = reversed(unit_block(vector![6.0, 6.0, 1.0]));
    let refused = refusal(together([angle.clone(), in_the_hollow]));
    assert!(matches!(refused, SurfaceError::Inward { .. }), "{refused}");
    let (vertices, triangles) = together([angle, reversed(unit_block(vector![1.0, 6.0, 1.0]))]);
    assert!(TriangleSurface::new(vertices, triangles).is_ok());

    let outer = block(Vector3::repeat(-2.0), Vector3::repeat(5.0));
    let cavity = reversed(block(Vector3::repeat(-1.0), Vector3::repeat(3.0)));
    let refused = refusal(together([outer, cavity, reversed(cube())]));
    assert!(
        matches!(refused, SurfaceError::Inward { triangle: 24, .. }),
        "{refused}"
    );
}

/// Returns a cube with a cavity, turned and moved, with the triangles of the cavity in another order.
fn cube_with_cavity(cavity: Triangulation, k: usize) -> Triangulation {
    let (vertices, triangles) = reversed(cavity);
    let first = 5 * k % triangles.len();
    let triangles = [&triangles[first..], &triangles[..first]].concat();
    let (mut vertices, triangles) = together([cube(), (vertices, triangles)]);
    let angle = k as f64;
    let pose = Pose::from_rotation_vector(
        &vector![angle, 0.3 * angle, -0.7 * angle],
        vector![angle, 0.1, -3.0],
    );
    for vertex in &mut vertices {
        *vertex = pose.transformed_point(vertex);
    }
    (vertices, triangles)
}

#[test]
fn a_cavity_that_sticks_out_is_refused_in_any_order_and_pose() {
    for k in 0..24 {
        for low in [[0.6, 0.6, 0.6], [0.25, 0.25, 0.75]] {
            let cavity = block(low.into(), Vector3::repeat(0.5));
            let refused = refusal(cube_with_cavity(cavity, k));
            assert!(
                matches!(refused, SurfaceError::SticksOut { triangle: 12, .. }),
                "{refused}"
            );
        }
        // A cavity may share a part of the surface.
        for low in [[0.0, 0.25, 0.25], [0.25, 0.25, 0.5], [0.5, 0.0, 0.5]] {
            let cavity = block(low.into(), Vector3::repeat(0.5));
            let (vertices, triangles) = cube_with_cavity(cavity, k);
            let solid = TriangleSurface::new(vertices, triangles).unwrap();
            assert!((solid.volume() - 0.875).abs() < 1e-13);
        }
    }
}

#[test]
fn cavities_larger_than_the_solid_are_refused() {
    // The validation does not search for cavities that overlap.
    let cavity = || reversed(block(Vector3::repeat(0.05), Vector3::repeat(0.9)));
    let refused = refusal(together([cube(), cavity(), cavity()]));
    let volume = 1.0 - 2.0 * 0.729;
    assert!(
        matches!(refused, SurfaceError::NoVolume { volume: stated } if (stated - volume).abs() < 1e-14),
        "{refused}"
    );
}

#[test]
fn sizes_beyond_double_precision_are_refused() {
    for (size, is_large) in [(1e70, true), (1e-170, false)] {
        let refused = refusal(block(Vector3::zeros(), Vector3::repeat(size)));
        let is_beyond_precision = matches!(refused, SurfaceError::BeyondPrecision { .. });
        assert_eq!(is_beyond_precision, is_large, "{refused}");
    }
    for size in [1e50, 1e-70] {
        let (vertices, triangles) = block(Vector3::zeros(), Vector3::repeat(size));
        let solid = TriangleSurface::new(vertices, triangles).unwrap();
        assert!((solid.volume() / size.powi(3) - 1.0).abs() < 1e-14);
    }
}
