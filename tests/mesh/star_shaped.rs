//! Solids inside closed surfaces of triangles, filled from a point that sees all of them.

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::{MeshError, PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Sums over some hundred tetrahedra, relative to the result.
const SUM_ROUND_OFF: f64 = 1e-13;

/// Wrenches of the same fields, whose centres differ by a rounding, relative to their largest part.
const SAME_WRENCH: f64 = 1e-12;

type Triangulation = (Vec<Vector3<f64>>, Vec<[usize; 3]>);

/// The surface of a field whose vertices inside come last.
fn surface_of(field: &PressureField) -> Triangulation {
    let mesh = field.mesh();
    let on_surface = (0..mesh.vertex_count()).filter(|&vertex| mesh.is_on_surface(vertex));
    let vertices = on_surface.map(|vertex| mesh.vertices()[vertex]);
    (vertices.collect(), mesh.surface_triangles().to_vec())
}

/// A polygon in the plane z = 0, given with its triangles, extruded to z = 1.
fn prism(polygon: &[[f64; 2]], caps: &[[usize; 3]]) -> Triangulation {
    let count = polygon.len();
    let level = |z: f64| polygon.iter().map(move |&[x, y]| vector![x, y, z]);
    let sides = (0..count).flat_map(|here| {
        let next = (here + 1) % count;
        [
            [here, next, count + next],
            [here, count + next, count + here],
        ]
    });
    let bottom = caps.iter().map(|&[a, b, c]| [a, c, b]);
    let top = caps.iter().map(|cap| cap.map(|vertex| count + vertex));
    let triangles = bottom.chain(top).chain(sides).collect();
    (level(0.0).chain(level(1.0)).collect(), triangles)
}

/// Two arms of length 3 and width 1: star-shaped about any point of the square in which they meet.
fn letter_l() -> Triangulation {
    let polygon = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ];
    prism(&polygon, &[[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]])
}

fn cube() -> Triangulation {
    surface_of(&shapes::cuboid([1.0; 3]).unwrap())
}

fn refusal((vertices, triangles): Triangulation) -> MeshError {
    shapes::star_shaped(vertices, triangles).unwrap_err()
}

fn assert_relative(found: f64, expected: f64, tolerance: f64) {
    let error = (found - expected).abs();
    assert!(
        error <= tolerance * expected.abs(),
        "{found:e} is not {expected:e}"
    );
}

// What it makes.

#[test]
fn a_tetrahedron_has_the_volume_and_centre_of_the_textbook() {
    let vertices = vec![
        vector![1.0, 1.0, 1.0],
        vector![1.5, 1.0, 1.0],
        vector![1.0, 1.25, 1.0],
        vector![1.0, 1.0, 3.0],
    ];
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let field = shapes::star_shaped(vertices, triangles).unwrap();
    let mass = field.mesh().mass_properties(1.0).unwrap();
    assert_relative(mass.mass, 0.5 * 0.25 * 2.0 / 6.0, SUM_ROUND_OFF);
    let center = vector![1.125, 1.0625, 1.5];
    assert!((mass.center_of_mass - center).amax() <= SUM_ROUND_OFF);
    assert!((field.mesh().vertices()[4] - center).amax() <= SUM_ROUND_OFF);
    assert_eq!(field.extents(), [0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn the_surface_of_an_icosphere_gives_the_icosphere() {
    let sphere = shapes::icosphere(0.3, 3).unwrap();
    let (vertices, triangles) = surface_of(&sphere);
    let field = shapes::star_shaped_about(Vector3::zeros(), vertices, triangles).unwrap();
    assert_eq!(field.mesh().vertices(), sphere.mesh().vertices());
    assert_eq!(field.extents(), sphere.extents());
    let corners = |field: &PressureField| {
        let sorted = field.mesh().tets().iter().map(|tet| {
            let mut sorted = *tet;
            sorted.sort_unstable();
            sorted
        });
        sorted.collect::<BTreeSet<_>>()
    };
    assert_eq!(corners(&field), corners(&sphere));
}

#[test]
fn the_surface_of_a_box_is_pressed_as_the_box() {
    let box_itself = shapes::cuboid([0.3, 0.2, 0.1]).unwrap();
    let (vertices, triangles) = surface_of(&box_itself);
    let field = shapes::star_shaped(vertices, triangles).unwrap();
    let [ours, expected] = [field, box_itself].map(Shape::new);
    let ball = Shape::new(shapes::icosphere(0.1, 2).unwrap());
    for turn in [
        vector![0.0, 0.0, 0.0],
        vector![0.3, -0.2, 0.5],
        vector![1.0, 1.0, -2.0],
    ] {
        let ball = ContactBody::new(
            &ball,
            Pose::from_translation(vector![0.02, 0.01, 0.13]),
            1e5,
        );
        let wrench = |shape: &Shape| {
            let pose = Pose::from_rotation_vector(&turn, Vector3::zeros());
            let block = ContactBody::new(shape, pose, 1e6).unwrap();
            ContactPair::new(ball.unwrap(), block).wrench().on_a
        };
        let (found, expected) = (wrench(&ours), wrench(&expected));
        let largest = expected.force.amax();
        assert!(largest > 1.0, "no contact at {turn}");
        assert!((found.force - expected.force).amax() <= SAME_WRENCH * largest);
        assert!((found.torque - expected.torque).amax() <= SAME_WRENCH * largest);
    }
}

proptest! {
    #[test]
    fn bumpy_balls_have_the_volume_under_their_triangles(
        radii in prop::collection::vec(0.2..2.0, 42),
        shift in prop::array::uniform3(-5.0..5.0),
    ) {
        let (directions, triangles) = surface_of(&shapes::icosphere(1.0, 1).unwrap());
        let bumpy = directions.iter().zip(&radii).map(|(direction, radius)| direction * *radius);
        let bumpy: Vec<Vector3<f64>> = bumpy.collect();
        let expected: f64 = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| bumpy[vertex]);
            a.dot(&b.cross(&c)) / 6.0
        }).sum();
        let shift = Vector3::from(shift);
        let shifted: Vec<_> = bumpy.iter().map(|vertex| vertex + shift).collect();
        let field = shapes::star_shaped_about(shift, shifted, triangles.clone()).unwrap();
        prop_assert!((field.mesh().volume() - expected).abs() <= SUM_ROUND_OFF * 100.0 * expected);
        prop_assert_eq!(field.mesh().surface_triangles().len(), triangles.len());
    }
}

#[test]
fn a_solid_can_be_filled_from_a_point_where_its_centre_will_not_do() {
    // The centre of volume is (1.1, 1.1): outside.
    assert!(matches!(
        refusal(letter_l()),
        MeshError::HiddenTriangle { .. }
    ));
    let (vertices, triangles) = letter_l();
    let field = shapes::star_shaped_about(vector![0.5, 0.5, 0.5], vertices, triangles).unwrap();
    assert_relative(field.mesh().volume(), 5.0, SUM_ROUND_OFF);
}

#[test]
fn triangles_may_come_with_corners_of_their_own() {
    let (vertices, triangles) = cube();
    let centered: Vec<_> = vertices
        .iter()
        .map(|v| v + vector![0.5, 0.5, 0.5])
        .collect();
    let corners = triangles.iter().flatten().enumerate();
    // Zeros of either sign are the same place.
    let soup = corners.map(|(place, &vertex)| {
        let sign = if place % 2 == 0 { 1.0 } else { -1.0 };
        centered[vertex].map(|x| if x == 0.0 { 0.0 * sign } else { x })
    });
    let separate = (0..triangles.len()).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    let field = shapes::star_shaped(soup.collect(), separate.collect()).unwrap();
    assert_eq!(field.mesh().vertex_count(), 9);
    assert_relative(field.mesh().volume(), 1.0, SUM_ROUND_OFF);
}

#[test]
fn vertices_of_no_triangle_are_left_out() {
    let (mut vertices, triangles) = cube();
    vertices.insert(0, vector![7.0, 7.0, 7.0]);
    vertices.push(Vector3::zeros());
    let triangles = triangles.iter().map(|t| t.map(|vertex| vertex + 1));
    // Not of the centre either, which has a vertex of its own.
    let field = shapes::star_shaped(vertices, triangles.collect()).unwrap();
    assert_eq!(field.mesh().vertex_count(), 9);
    assert_relative(field.reach(), 0.75_f64.sqrt(), SUM_ROUND_OFF);
}

#[test]
fn vertices_of_no_triangle_decide_nothing() {
    let (vertices, triangles) = cube();
    let plain = shapes::star_shaped(vertices.clone(), triangles.clone()).unwrap();
    for stray in [vector![1e4, 0.0, 0.0], Vector3::repeat(f64::NAN)] {
        let mut vertices = vertices.clone();
        vertices.push(stray);
        let field = shapes::star_shaped(vertices, triangles.clone()).unwrap();
        assert_eq!(field.mesh().vertices(), plain.mesh().vertices());
    }
}

// What it refuses.

#[test]
fn a_surface_beyond_double_precision_is_refused_as_too_large() {
    for size in [1e90, 1e120, 1e200] {
        let (mut vertices, triangles) = cube();
        for vertex in &mut vertices {
            *vertex *= size;
        }
        let error = refusal((vertices, triangles));
        let MeshError::SurfaceTooLarge { diagonal } = error else {
            panic!("{error}")
        };
        assert!(diagonal > size);
    }
}

#[test]
fn numbers_and_indices_that_make_no_triangles_are_named() {
    let (mut vertices, triangles) = cube();
    vertices[3].y = f64::NAN;
    let error = refusal((vertices, triangles));
    assert!(matches!(
        error,
        MeshError::NonFiniteCoordinate { vertex: 3, value } if value.is_nan()
    ));
    let (vertices, mut triangles) = cube();
    triangles[5][1] = 8;
    assert_eq!(
        refusal((vertices, triangles)).to_string(),
        "triangle 5 refers to vertex 8, but there are 8 vertices"
    );
    let (vertices, mut triangles) = cube();
    triangles[4] = [1, 2, 1];
    assert_eq!(
        refusal((vertices, triangles)).to_string(),
        "triangle 4 has vertex 1, or its place, twice, but needs three corners"
    );
    assert_eq!(
        refusal((cube().0, vec![])).to_string(),
        "a surface needs at least one triangle"
    );
}

#[test]
fn an_open_surface_is_named_with_the_edge_of_its_hole() {
    let (vertices, mut triangles) = cube();
    let removed = triangles.remove(7);
    let MeshError::OpenSurface {
        triangle,
        edge: [from, to],
    } = refusal((vertices, triangles.clone()))
    else {
        panic!("expected OpenSurface")
    };
    assert!(removed.contains(&from) && removed.contains(&to));
    assert!(triangles[triangle].contains(&from) && triangles[triangle].contains(&to));
    let error = MeshError::OpenSurface {
        triangle: 2,
        edge: [4, 1],
    };
    assert_eq!(
        error.to_string(),
        "the surface is not closed: the edge from vertex 4 to vertex 1 of triangle 2 belongs to no other triangle"
    );
}

#[test]
fn a_triangle_turned_the_wrong_way_round_is_named() {
    let (vertices, mut triangles) = cube();
    triangles[7].swap(0, 1);
    let error = refusal((vertices, triangles));
    let MeshError::InconsistentTriangles { first, second, .. } = error else {
        panic!("{error}")
    };
    assert!(first == 7 || second == 7);
}

#[test]
fn a_surface_turned_inwards_is_refused() {
    let (vertices, mut triangles) = cube();
    for triangle in &mut triangles {
        triangle.swap(0, 1);
    }
    let MeshError::EnclosedVolume { volume, diagonal } = refusal((vertices, triangles)) else {
        panic!("expected EnclosedVolume")
    };
    assert_relative(volume, -1.0, SUM_ROUND_OFF);
    assert_relative(diagonal, 3.0_f64.sqrt(), SUM_ROUND_OFF);
}

#[test]
fn a_hidden_triangle_is_named_with_its_distance() {
    let (vertices, triangles) = cube();
    let outside = vector![0.0, 0.0, 0.75];
    let error = shapes::star_shaped_about(outside, vertices.clone(), triangles.clone());
    let Err(MeshError::HiddenTriangle { triangle, distance }) = error else {
        panic!("expected HiddenTriangle")
    };
    let top = triangles[triangle].map(|vertex| vertices[vertex].z);
    assert_eq!(top.map(f64::to_bits), [0.5_f64.to_bits(); 3]);
    assert_relative(distance, 0.25, SUM_ROUND_OFF);
    let bad = shapes::star_shaped_about(vector![0.0, f64::NAN, 0.0], vertices, triangles);
    assert!(matches!(bad, Err(MeshError::NonFiniteInnerPoint { .. })));
}

#[test]
fn an_inner_point_in_the_plane_of_a_triangle_is_named_with_it() {
    let (vertices, triangles) = cube();
    let on_top = vector![0.0, 0.0, 0.5];
    let error = shapes::star_shaped_about(on_top, vertices.clone(), triangles.clone());
    let Err(MeshError::TriangleSeenEdgeOn { triangle, volume }) = error else {
        panic!("expected TriangleSeenEdgeOn")
    };
    assert!(volume.abs() <= SUM_ROUND_OFF);
    let top = triangles[triangle].map(|vertex| vertices[vertex].z);
    assert_eq!(top.map(f64::to_bits), [0.5_f64.to_bits(); 3]);
}

#[test]
fn a_surface_within_a_surface_is_refused() {
    let (inner, triangles) = surface_of(&shapes::icosphere(0.5, 1).unwrap());
    let outer = inner.iter().map(|vertex| vertex * 2.0);
    let count = inner.len();
    let vertices = inner.iter().copied().chain(outer).collect();
    let shifted = triangles.iter().map(|t| t.map(|vertex| vertex + count));
    let both = triangles.iter().copied().chain(shifted).collect();
    let error = refusal((vertices, both));
    assert_eq!(
        error.to_string(),
        "the surface surrounds the inner point 2 times, but must do so once"
    );
}

#[test]
fn a_solid_without_thickness_is_refused() {
    let vertices = vec![
        vector![0.1, 0.2, 0.3],
        vector![1.0, 0.3, 0.5],
        vector![0.2, 1.1, 0.7],
    ];
    let both_sides = vec![[0, 1, 2], [0, 2, 1]];
    assert!(matches!(
        refusal((vertices, both_sides)),
        MeshError::EnclosedVolume { .. }
    ));
}
