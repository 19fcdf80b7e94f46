//! The neighbors of triangles across their edges.
//!
//! Usually two triangles meet in an edge and run along it in opposite directions. If parts of a solid touch in an edge, four or more
//! triangles meet, equally many in each direction. Around the edge, parts of the solid alternate with gaps. The two triangles at the
//! sides of one part become neighbors, so that the parts are not connected.

use super::surface_faults::{Fault, SurfaceFaults};
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// A half-edge: an edge as part of one triangle.
#[derive(Clone, Copy)]
struct HalfEdge {
    /// The vertices of the edge, the lower index first.
    edge: [u32; 2],
    triangle: u32,
    /// The corner of the triangle opposite to the edge.
    corner: u8,
    /// Flag that is set if the triangle runs from the lower vertex to the higher one.
    forwards: bool,
}

/// Returns the neighbors of each triangle. Entry k is the triangle across the edge opposite to corner k.
///
/// Returns the faults unless every edge has equally many half-edges in both directions. Sorting takes O(n log n) time. A `u32` must be
/// able to count the triangles and vertices.
pub(super) fn neighbors(
    vertices: &[Vector3<f64>],
    triangles: &[[usize; 3]],
) -> Result<Vec<[u32; 3]>, Box<SurfaceFaults>> {
    let mut half_edges = sorted_half_edges(triangles);
    let mut neighbors = vec![[0; 3]; triangles.len()];
    let mut connect = |[a, b]: [&HalfEdge; 2]| {
        neighbors[a.triangle as usize][usize::from(a.corner)] = b.triangle;
        neighbors[b.triangle as usize][usize::from(b.corner)] = a.triangle;
    };
    let (mut open, mut inconsistent, mut unbalanced) = (Vec::new(), Vec::new(), Vec::new());
    for group in half_edges.chunk_by_mut(|a, b| a.edge == b.edge) {
        let forwards = group.iter().filter(|half_edge| half_edge.forwards).count();
        let count = group.len();
        match group {
            [a, b] if forwards == 1 => connect([a, b]),
            [alone] => open.push(*alone),
            [first, _] => inconsistent.push(*first),
            [first, ..] if 2 * forwards != count => unbalanced.push(*first),
            _ => {
                sort_around_edge(group, vertices, triangles);
                connect_wedges(group, &mut connect);
            }
        }
    }
    let fault = |half_edges: &[HalfEdge]| {
        let ends = |half_edge: &HalfEdge| half_edge.vertices().map(|vertex| vertices[vertex]);
        Fault::of(half_edges.iter().map(ends))
    };
    let faults = SurfaceFaults {
        open: fault(&open),
        inconsistent: fault(&inconsistent),
        unbalanced: fault(&unbalanced),
        ..SurfaceFaults::default()
    };
    if faults == SurfaceFaults::default() {
        Ok(neighbors)
    } else {
        Err(Box::new(faults))
    }
}

/// Returns the half-edges, sorted by edge and then by triangle.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a surface has no more triangles and vertices than a u32 counts"
)]
fn sorted_half_edges(triangles: &[[usize; 3]]) -> Vec<HalfEdge> {
    let mut half_edges = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate() {
        for corner in 0..3_u8 {
            let index = usize::from(corner);
            let [from, to] = [corners[(index + 1) % 3], corners[(index + 2) % 3]];
            half_edges.push(HalfEdge {
                edge: [from.min(to) as u32, from.max(to) as u32],
                triangle: triangle as u32,
                corner,
                forwards: from < to,
            });
        }
    }
    half_edges.sort_unstable_by_key(|half_edge| (half_edge.edge, half_edge.triangle));
    half_edges
}

/// Sorts the half-edges of one edge by the angles of their triangles around the edge.
///
/// At equal angles, a triangle that ends a part of the solid precedes a triangle that begins a part. Copies of the triangles that begin a
/// part are in the order of their indices, and copies of the triangles that end it are in the reverse order. Each copy of a part then
/// becomes a component.
fn sort_around_edge(group: &mut [HalfEdge], vertices: &[Vector3<f64>], triangles: &[[usize; 3]]) {
    let [lower, higher] = group[0].edge.map(|vertex| vertices[vertex as usize]);
    let axis = (higher - lower).normalize();
    let apex = |half_edge: &HalfEdge| {
        let corners = triangles[half_edge.triangle as usize];
        vertices[corners[usize::from(half_edge.corner)]] - lower
    };
    let across = axis.cross(&apex(&group[0]));
    let angle = |half_edge: &HalfEdge| {
        let apex = apex(half_edge);
        let angle = atan2(across.dot(&apex), across.dot(&axis.cross(&apex)));
        if angle < 0.0 { angle + TAU } else { angle }
    };
    group.sort_by(|a, b| {
        let by_angle = angle(a).total_cmp(&angle(b));
        let by_triangle = || {
            let order = a.triangle.cmp(&b.triangle);
            if a.forwards { order.reverse() } else { order }
        };
        by_angle
            .then(b.forwards.cmp(&a.forwards))
            .then_with(by_triangle)
    });
}

/// Connects the two half-edges at the sides of each part of the solid around an edge.
///
/// The outer side of a forward triangle is at increasing angles. So a backward triangle begins a part of the solid, and the matching
/// forward triangle ends it, like parentheses on a circle.
fn connect_wedges<'e>(group: &'e [HalfEdge], mut connect: impl FnMut([&'e HalfEdge; 2])) {
    let mut begun = Vec::new();
    // The second round ends the parts that contain angle 0.
    for half_edge in group.iter().chain(group) {
        if !half_edge.forwards {
            begun.push(half_edge);
        } else if let Some(begin) = begun.pop() {
            connect([begin, half_edge]);
        }
    }
}

impl HalfEdge {
    /// Returns the vertices of the edge in the direction of the triangle.
    fn vertices(&self) -> [usize; 2] {
        let [lower, higher] = self.edge.map(|vertex| vertex as usize);
        if self.forwards {
            [lower, higher]
        } else {
            [higher, lower]
        }
    }
}
