//! Coincident vertices are merged, and unused vertices are removed.

use super::sample_surfaces::{Triangulation, soup, unit_block};
use hydroelastic::mesh::{SurfaceError, TriangleSoup, TriangleSurface, shapes};
use nalgebra::{Vector3, vector};

fn cube() -> Triangulation {
    unit_block(Vector3::zeros())
}

/// Returns an unused vertex, then a cube with three separate vertices per triangle.
fn separate_cube() -> Triangulation {
    let corners = soup(&cube());
    let stray = Vector3::repeat(f64::NAN);
    let vertices = [&[stray], corners.as_flattened()].concat();
    let triangles = (0..corners.len()).map(|t| [1, 2, 3].map(|corner| 3 * t + corner));
    (vertices, triangles.collect())
}

fn closed(
    vertices: Vec<Vector3<f64>>,
    triangles: Vec<[usize; 3]>,
) -> Result<TriangleSurface, SurfaceError> {
    let soup = TriangleSoup {
        vertices,
        triangles,
    };
    soup.closed()
}

fn refusal((vertices, triangles): Triangulation) -> SurfaceError {
    closed(vertices, triangles).unwrap_err()
}

#[test]
fn vertices_at_the_same_place_become_one() {
    let (mut vertices, triangles) = separate_cube();
    // Zeros of either sign are the same position.
    for vertex in vertices.iter_mut().step_by(2) {
        *vertex = vertex.map(|x| if x == 0.0 { -0.0 } else { x });
    }
    let welded = closed(vertices.clone(), triangles.clone()).unwrap();
    assert_eq!((welded.vertices().len(), welded.component_count()), (8, 1));
    for (index, triangle) in triangles.iter().enumerate() {
        assert_eq!(welded.corners(index), triangle.map(|v| vertices[v]));
    }
    let field = shapes::star_shaped(&welded).unwrap();
    assert_eq!(
        (field.mesh().vertex_count(), field.mesh().tet_count()),
        (9, 12)
    );
}

#[test]
fn unused_vertices_are_dropped_even_if_they_are_not_finite() {
    let (vertices, triangles) = cube();
    let shifted: Vec<_> = triangles.iter().map(|t| t.map(|v| v + 1)).collect();
    for stray in [vector![1e4, 0.0, 0.0], Vector3::repeat(f64::NAN)] {
        let with_strays = [&[stray], vertices.as_slice(), &[stray]].concat();
        let welded = closed(with_strays, shifted.clone()).unwrap();
        assert_eq!(welded.vertices(), vertices);
        assert_eq!(welded.triangles(), triangles);
    }
}

#[test]
fn errors_name_vertices_by_their_given_indices() {
    let (mut vertices, triangles) = separate_cube();
    vertices[16].y = f64::NAN;
    let refused = refusal((vertices, triangles));
    assert!(
        matches!(
            refused,
            SurfaceError::NonFiniteCoordinate { vertex: 16, .. }
        ),
        "{refused}"
    );

    let (vertices, mut triangles) = separate_cube();
    triangles[5][1] = 37;
    let expected = SurfaceError::VertexOutOfRange {
        triangle: 5,
        vertex: 37,
        vertex_count: 37,
    };
    assert_eq!(refusal((vertices, triangles)), expected);
}

#[test]
fn errors_give_the_coordinates_of_the_first_fault() {
    let (vertices, mut triangles) = separate_cube();
    let removed = triangles.remove(7).map(|v| vertices[v]);
    let SurfaceError::NotClosed(faults) = refusal((vertices, triangles)) else {
        panic!("a cube without a triangle is open");
    };
    let open = faults.open.unwrap();
    assert_eq!(open.count, 3);
    assert!(open.first.iter().all(|end| removed.contains(end)));

    let (vertices, mut triangles) = separate_cube();
    triangles[7].swap(0, 1);
    let turned = triangles[7].map(|v| vertices[v]);
    let SurfaceError::NotClosed(faults) = refusal((vertices, triangles)) else {
        panic!("a turned triangle has inconsistent edges");
    };
    let inconsistent = faults.inconsistent.unwrap();
    assert_eq!((inconsistent.count, faults.open), (3, None));
    assert!(inconsistent.first.iter().all(|end| turned.contains(end)));
}
