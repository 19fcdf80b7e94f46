//! Triangles that share an edge.

use super::sample_surfaces::{soup, surface, together, torus, unit_block};
use crate::tet_mesh::sample_meshes::meshes;
use hydroelastic::mesh::{TriangleSoup, TriangleSurface};
use nalgebra::vector;
use std::time::{Duration, Instant};

/// Time limit for a million triangles, which took 0.93 s in the last measurement.
const TIME: Duration = Duration::from_secs(20);

/// Returns the ends of the edge opposite to a corner, in the direction of the triangle.
fn edge(surface: &TriangleSurface, triangle: usize, corner: usize) -> [usize; 2] {
    let corners = surface.triangles()[triangle];
    [corners[(corner + 1) % 3], corners[(corner + 2) % 3]]
}

#[test]
fn a_neighbor_has_the_same_edge_the_other_way_round() {
    for (name, mesh) in meshes() {
        let surface = TriangleSurface::around(&mesh).unwrap();
        for triangle in 0..surface.triangles().len() {
            for corner in 0..3 {
                let [from, to] = edge(&surface, triangle, corner);
                let neighbor = surface.neighbor(triangle, corner);
                let back = (0..3).find(|&k| edge(&surface, neighbor, k) == [to, from]);
                let back = back.unwrap_or_else(|| panic!("{name}: {triangle} {corner}"));
                assert_eq!(surface.neighbor(neighbor, back), triangle, "{name}");
            }
        }
    }
}

#[test]
fn a_soup_in_any_order_becomes_the_surface_it_was_made_of() {
    let ring = torus(1.0, 0.3, [11, 7]);
    let whole = surface(ring.clone());
    let corners = soup(&ring);
    // Five is coprime to the count.
    let order: Vec<usize> = (0..corners.len())
        .map(|k| (5 * k + 2) % corners.len())
        .collect();
    let shuffled: Vec<_> = order.iter().map(|&k| corners[k]).collect();
    let welded = TriangleSoup::from_corners(&shuffled).closed().unwrap();
    assert_eq!(welded.vertices().len(), whole.vertices().len());
    for (triangle, &before) in order.iter().enumerate() {
        assert_eq!(welded.corners(triangle), whole.corners(before));
        for edge in 0..3 {
            let neighbor = order[welded.neighbor(triangle, edge)];
            assert_eq!(neighbor, whole.neighbor(before, edge));
        }
    }
}

#[test]
fn triangles_without_three_corners_are_left_out_of_a_soup() {
    let mut corners = soup(&unit_block(vector![0.0, 0.0, 0.0]));
    let [a, b, _] = corners[3];
    corners.insert(2, [a, a, b]);
    corners.push([b, b, b]);
    // Zeros of either sign are the same position.
    let zero = corners[0]
        .iter()
        .position(|corner| corner.x == 0.0)
        .unwrap();
    corners[0][zero].x = -0.0;
    let welded = TriangleSoup::from_corners(&corners).closed().unwrap();
    assert_eq!((welded.vertices().len(), welded.triangles().len()), (8, 12));
}

#[test]
fn blocks_that_touch_at_a_corner_are_two_components() {
    let both = together([
        unit_block(vector![0.0, 0.0, 0.0]),
        unit_block(vector![1.0, 1.0, 1.0]),
    ]);
    let welded = TriangleSoup::from_corners(&soup(&both)).closed().unwrap();
    assert_eq!(welded.vertices().len(), 15);
    assert_eq!(welded.component_starts(), [0, 12]);
}

#[test]
#[ignore = "half a gigabyte"]
fn a_million_triangles_become_a_surface_in_about_a_second() {
    let corners = soup(&torus(1.0, 0.3, [1000, 500]));
    let start = Instant::now();
    let scan = TriangleSoup::from_corners(&corners).closed().unwrap();
    let elapsed = start.elapsed();
    println!("{} triangles: {elapsed:.2?}", scan.triangles().len());
    assert!(elapsed < TIME, "{elapsed:?}");
}
