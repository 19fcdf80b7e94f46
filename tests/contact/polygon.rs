//! Slicing and clipping of inputs for which the paper's half-plane intersection fails.

use hydroelastic::geometry::{AffineField, ConvexPolygon, Tetrahedron};
use nalgebra::{Vector3, vector};

/// Rounding error of areas of order one.
const EXACT: f64 = 1e-14;

/// Tolerance of a clip in these tests.
const TOLERANCE: f64 = 1e-14;

/// Bit of the clipping half-plane, besides the four bits of the sliced tetrahedron.
const SIDE: u8 = 0b1_0000;

/// Returns the triangle (0,0), (1,0), (0,1) at z = ½, counter-clockwise about z.
fn triangle() -> ConvexPolygon {
    let corners = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 2.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let tetrahedron = Tetrahedron {
        corners: corners.map(Vector3::from),
    };
    tetrahedron.sliced(&[-0.5, -0.5, -0.5, 0.5])
}

/// Returns the half-plane a·x + b·y + c ≥ 0.
fn half_plane(a: f64, b: f64, c: f64) -> AffineField {
    AffineField {
        gradient: vector![a, b, 0.0],
        offset: c,
    }
}

fn area(polygon: &ConvexPolygon) -> f64 {
    polygon.area_vector().z
}

#[test]
fn every_slice_of_a_tetrahedron_turns_about_the_gradient_of_its_values() {
    let corners = [
        [0.1, 0.0, 0.2],
        [1.3, 0.1, 0.0],
        [0.0, 1.1, 0.3],
        [0.2, 0.3, 0.9],
    ];
    let tetrahedron = Tetrahedron {
        corners: corners.map(Vector3::from),
    };
    assert!(tetrahedron.signed_volume() > 0.0);
    for mask in 1..15_u32 {
        let values: [f64; 4] =
            std::array::from_fn(|i| (if mask >> i & 1 == 1 { -1.0 } else { 1.0 }) + 0.1 * i as f64);
        let gradient: Vector3<f64> = tetrahedron
            .barycentric_fields()
            .iter()
            .zip(values)
            .map(|(field, value)| field.gradient * value)
            .sum();
        let slice = tetrahedron.sliced(&values);
        let fan = slice.corners().windows(2).skip(1);
        let turns = fan.map(|pair| {
            let [a, b] = [pair[0] - slice.corners()[0], pair[1] - slice.corners()[0]];
            a.cross(&b).dot(&gradient)
        });
        assert!(
            turns.into_iter().all(|turn| turn > 0.0),
            "corners below: {mask:04b}"
        );
    }
}

#[test]
fn nearly_parallel_half_planes_that_meet_nowhere_leave_nothing() {
    // The paper's Figure 4: two borders that face away from each other with a tiny gap, and a third border.
    for gap in [1e-3, 1e-9, 1e-13] {
        for tilt in [0.0, 1e-12, 1e-16] {
            let above = half_plane(tilt, 1.0, -0.25 - gap);
            let below = half_plane(tilt, -1.0, 0.25);
            let clipped = triangle()
                .clipped(&above, TOLERANCE, SIDE)
                .clipped(&below, TOLERANCE, SIDE);
            // If the tilt exceeds the gap, a sliver of that height exists.
            assert!(area(&clipped).abs() <= tilt + EXACT, "{gap:e} {tilt:e}");
        }
    }
}

#[test]
fn clipping_twice_by_the_same_or_nearly_the_same_border_changes_nothing() {
    let once = triangle().clipped(&half_plane(0.3, -1.0, 0.2), TOLERANCE, SIDE);
    for nudge in [0.0, 1e-16, 1e-15, -1e-15] {
        let twice = once.clipped(&half_plane(0.3 + nudge, -1.0, 0.2 + nudge), TOLERANCE, SIDE);
        assert!((area(&twice) - area(&once)).abs() <= EXACT);
    }
}

#[test]
fn a_border_through_corners_and_along_edges_keeps_what_is_inside() {
    let whole = area(&triangle());
    assert!((whole - 0.5).abs() <= EXACT);
    // Clips along an edge from either side, through one corner, and through a corner and the middle of an edge.
    let cases = [
        (half_plane(0.0, 1.0, 0.0), 0.5),
        (half_plane(0.0, -1.0, 0.0), 0.0),
        (half_plane(1.0, 1.0, -1.0), 0.0),
        (half_plane(-1.0, -1.0, 1.0), 0.5),
        (half_plane(1.0, 0.0, -1.0), 0.0),
        (half_plane(1.0, -1.0, 0.0), 0.25),
    ];
    for (border, expected) in cases {
        let clipped = triangle().clipped(&border, TOLERANCE, SIDE);
        assert!((area(&clipped) - expected).abs() <= EXACT, "{border:?}");
    }
}
