//! The point of a mesh that is farthest from its surface.

use super::TetMesh;
use super::splitting::{Center, Division};
use super::surface_distance::SurfaceDistance;
use crate::geometry::EDGES;
use crate::parallel;
use nalgebra::Vector3;

/// Number of steps of a barycentric coordinate from 0 to 1. The search uses whole steps, so that small changes of the mesh do not change
/// the coordinates.
const STEP_COUNT: i32 = 64;

/// Smallest barycentric coordinate, in steps.
const MIN_STEPS: i32 = 4;

/// Smallest relative gain for which a tetrahedron is split.
const GAIN: f64 = 1e-3;

/// Relative difference below which two distances count as equal.
const TIE: f64 = 1e-4;

/// Upper bound of the distance from a point of a tetrahedron to the nearest corner, over the longest edge (Jung's theorem) [Jung 1901].
const JUNG_RATIO: f64 = 0.612_372_5;

/// A point of a tetrahedron and its distance from the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct DeepestPoint {
    tet: [usize; 4],
    /// Barycentric coordinates.
    shares: [f64; 4],
    position: Vector3<f64>,
    /// Distance from the surface (m).
    pub distance: f64,
}

impl DeepestPoint {
    /// Returns the new vertex at this point.
    pub fn center(&self) -> Center {
        Center::in_tet(self.tet, self.shares)
    }

    /// Returns the split of the tetrahedron at this point.
    pub fn division(&self) -> Division<4> {
        let mut simplex = self.tet;
        simplex.sort_unstable();
        Division {
            simplex,
            at: self.position,
        }
    }
}

/// Returns approximately the point of the mesh that is farthest from the surface. `distances` are the distances (m) of the vertices.
/// Returns `None` if no point is more than 0.1 % farther from the surface than all vertices.
pub(super) fn deepest_point(
    mesh: &TetMesh,
    surface: &SurfaceDistance,
    distances: &[f64],
) -> Option<DeepestPoint> {
    let at_vertices = distances.iter().copied().fold(0.0, f64::max);
    let is_near = |&tet: &usize| {
        let of_corners = mesh.tets()[tet].map(|vertex| distances[vertex]);
        let largest_of_corners = of_corners.into_iter().fold(0.0, f64::max);
        let reach = JUNG_RATIO * mesh.tetrahedron(tet).longest_edge();
        largest_of_corners + reach > (1.0 - GAIN) * at_vertices
    };
    let near: Vec<usize> = (0..mesh.tet_count()).filter(is_near).collect();
    let centroid = |tet: usize| mesh.tetrahedron(tet).centroid();
    let at_centroids = parallel::map(&near, |&tet| surface.to(&centroid(tet)));
    let largest = at_centroids.iter().copied().fold(at_vertices, f64::max);
    // Distances of two points differ by at most the distance between the points.
    let can_be_deepest = |&(tet, at_centroid): &(usize, f64)| {
        let centroid = centroid(tet);
        let corners = mesh.tetrahedron(tet).corners;
        let radius = corners.map(|corner| (corner - centroid).norm());
        at_centroid + radius.into_iter().fold(0.0, f64::max) > (1.0 - GAIN) * largest
    };
    let near: Vec<_> = near
        .into_iter()
        .zip(at_centroids)
        .filter(can_be_deepest)
        .collect();
    let deepest = parallel::map(&near, |&(tet, _)| deepest_in(mesh, surface, tet));
    let deeper = |a: DeepestPoint, b| if is_deeper(&b, &a) { b } else { a };
    let deepest = deepest.into_iter().reduce(deeper)?;
    (deepest.distance > (1.0 + GAIN) * at_vertices).then_some(deepest)
}

/// Returns the deepest point of a tetrahedron. The pattern search starts at the centroid and moves parallel to the edges.
fn deepest_in(mesh: &TetMesh, surface: &SurfaceDistance, tet: usize) -> DeepestPoint {
    let corners = mesh.tetrahedron(tet).corners;
    let point = |steps: [i32; 4]| {
        let shares = steps.map(|count| f64::from(count) / f64::from(STEP_COUNT));
        let weighted = corners.iter().zip(shares);
        let position = weighted.map(|(corner, share)| corner * share).sum();
        DeepestPoint {
            tet: mesh.tets()[tet],
            shares,
            position,
            distance: surface.to(&position),
        }
    };
    let mut steps = [STEP_COUNT / 4; 4];
    let mut deepest = point(steps);
    let mut step = STEP_COUNT / 8;
    while step > 0 {
        let moved = EDGES.iter().flat_map(|&[a, b]| [[a, b], [b, a]]);
        let moved = moved.filter_map(|[from, to]| {
            let mut moved = steps;
            moved[from] -= step;
            moved[to] += step;
            (moved[from] >= MIN_STEPS).then(|| (moved, point(moved)))
        });
        match moved.reduce(|a, b| if is_deeper(&b.1, &a.1) { b } else { a }) {
            Some((moved, next)) if is_deeper(&next, &deepest) => (steps, deepest) = (moved, next),
            _ => step /= 2,
        }
    }
    deepest
}

/// Returns true if `a` is farther from the surface than `b` by more than the tolerance [`TIE`]. Callers keep the first of two points at a
/// tie, so that rounding error does not select the point.
fn is_deeper(a: &DeepestPoint, b: &DeepestPoint) -> bool {
    a.distance > (1.0 + TIE) * b.distance
}
