//! The paper's Figure 4: half-planes without a common point, two of which have nearly the same border. The paper's algorithm returns a
//! triangle, and clipping returns an empty polygon.

use super::Answer;
use super::clipping::clipped;
use super::half_planes::{HalfPlane, TOLERANCE, intersection};
use super::half_planes_picture::{Panel, draw_gap, draw_panel};
use super::style::ground;
use nalgebra::Vector2;
use std::path::Path;

const SIZE: (u32, u32) = (1600, 1080);

/// Two triangles (m), counter-clockwise. The second is 1.5 nm above the upper edge of the first, and not quite parallel to it, like two
/// stacked bodies that almost touch.
pub const LOWER: [[f64; 2]; 3] = [[-0.1, -0.42], [0.8, 0.16], [-0.9, -0.18]];
pub const UPPER: [[f64; 2]; 3] = [[-0.9, -0.18 + 1.5e-9], [0.8, 0.16 + 1.33e-9], [0.0, 0.9]];

/// Least area (m²) of the spurious triangle.
const LARGE: f64 = 0.05;

/// Overlap of the triangles (m) in a check, and the rounding error of an area (m²).
const OVERLAP: f64 = 0.2;
const SAME: f64 = 1e-14;

pub fn draw(path: &Path) -> Answer<String> {
    check_overlapping();
    let upper = half_planes(UPPER);
    check_apart(&upper);
    let theirs = intersection([half_planes(LOWER), upper].concat());
    let spurious = shoelace(&theirs);
    assert!(spurious > LARGE, "{theirs:?}");
    let ours = clipped(LOWER, &upper);
    assert!(ours.corners().is_empty(), "{:?}", ours.corners());

    let area = ground(path, SIZE)?;
    let (panels, gap) = area.split_vertically(660);
    let panels = panels.split_evenly((1, 2));
    let theirs = Panel {
        title: "The paper’s half-plane intersection",
        outcome: format!("{} corners, area {spurious:.3} m²", theirs.len()),
        found: &theirs,
    };
    let ours = Panel {
        title: "This library’s clipping",
        outcome: "no corner, area 0".to_owned(),
        found: &[],
    };
    draw_panel(&panels[0], &theirs)?;
    draw_panel(&panels[1], &ours)?;
    draw_gap(&gap, TOLERANCE)?;
    area.present()?;
    Ok(format!("area found by theirs {spurious:.3} m², by ours 0"))
}

/// Checks that both algorithms return the same area if the triangles overlap.
fn check_overlapping() {
    let upper = half_planes(UPPER.map(|[x, y]| [x, y - OVERLAP]));
    let theirs = shoelace(&intersection([half_planes(LOWER), upper].concat()));
    let ours = clipped(LOWER, &upper).area_vector().z;
    assert!(
        ours > LARGE && (theirs - ours).abs() < SAME,
        "{theirs} {ours}"
    );
}

/// Returns the half-planes whose intersection is a triangle.
fn half_planes(triangle: [[f64; 2]; 3]) -> [HalfPlane; 3] {
    let corners = triangle.map(Vector2::from);
    [0, 1, 2].map(|side| HalfPlane::left_of(corners[side], corners[(side + 1) % 3]))
}

/// Checks that the first side of the upper triangle separates the triangles.
fn check_apart([border, ..]: &[HalfPlane; 3]) {
    let depths = LOWER.map(|corner| border.depth(&Vector2::from(corner)));
    assert!(depths.iter().all(|depth| *depth < -TOLERANCE), "{depths:?}");
}

fn shoelace(corners: &[Vector2<f64>]) -> f64 {
    let following = corners.iter().cycle().skip(1);
    let doubled: f64 = corners.iter().zip(following).map(|(p, q)| p.perp(q)).sum();
    doubled / 2.0
}
