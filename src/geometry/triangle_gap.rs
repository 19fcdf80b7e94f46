use super::Triangle;
use nalgebra::Vector3;

/// Part of a triangle: a corner, the edge from a corner to the next corner, or the interior.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TrianglePart {
    Corner(usize),
    Edge(usize),
    Interior,
}

/// The smallest distance between two triangles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TriangleGap {
    /// The squared distance (m²). It is 0 if the triangles cross.
    pub squared_distance: f64,
    /// Vector (m) between the closest points of the parts, from the first triangle to the second.
    pub between: Vector3<f64>,
    /// The parts that contain the closest points: a corner and any part, or two edges. If the triangles cross, these are the parts of the
    /// closest such pair.
    pub parts: [TrianglePart; 2],
    /// Whether an edge of one triangle passes through the other triangle.
    pub are_crossing: bool,
}

impl Triangle {
    /// Returns the smallest distance to another triangle.
    ///
    /// If the triangles do not cross, one of the closest points is a corner, or both are inside edges. Parallel edges need no special case,
    /// because an end of one edge is also a closest point.
    pub fn gap_to(&self, other: &Self) -> TriangleGap {
        let first = (
            f64::INFINITY,
            Vector3::zeros(),
            [TrianglePart::Corner(0); 2],
        );
        let (squared_distance, between, parts) =
            self.gaps_to(other).fold(first, |best, (between, parts)| {
                let squared_distance = between.norm_squared();
                if squared_distance < best.0 {
                    (squared_distance, between, parts)
                } else {
                    best
                }
            });
        let are_crossing = self.is_crossed_by(other) || other.is_crossed_by(self);
        TriangleGap {
            squared_distance: if are_crossing { 0.0 } else { squared_distance },
            between,
            parts,
            are_crossing,
        }
    }

    /// Returns vectors (m) from this triangle to the other: from the corners of each triangle to the closest points of the other triangle, and
    /// between pairs of edges. Each has the parts that contain its ends. The shortest vector connects the closest points of triangles that
    /// do not cross.
    pub fn gaps_to(&self, other: &Self) -> impl Iterator<Item = (Vector3<f64>, [TrianglePart; 2])> {
        let corners = (0..3).map(|corner| self.gap_at_corner(corner, other));
        let corners_of_other = (0..3).map(|corner| {
            let (between, [part_of_other, part]) = other.gap_at_corner(corner, self);
            (-between, [part, part_of_other])
        });
        let edges = (0..9).filter_map(|pair| self.gap_of_edges([pair / 3, pair % 3], other));
        corners.chain(corners_of_other).chain(edges)
    }

    /// Returns the vector (m) from a corner to the closest point of the other triangle, and the closest parts.
    fn gap_at_corner(&self, corner: usize, other: &Self) -> (Vector3<f64>, [TrianglePart; 2]) {
        let (to_foot, part) = other.gap_to_point(&self.corners()[corner]);
        (to_foot, [TrianglePart::Corner(corner), part])
    }

    /// Returns the vector (m) from a point to the closest point of the triangle, and the part that contains the closest point.
    pub fn gap_to_point(&self, point: &Vector3<f64>) -> (Vector3<f64>, TrianglePart) {
        let shares = self.foot_of(point).shares;
        let to_foot = |k: usize| (self.corners()[k] - point) * shares[k];
        (to_foot(0) + to_foot(1) + to_foot(2), part_of_shares(shares))
    }

    /// Returns the vector (m) between the closest points of two edges, if both points are between the ends.
    fn gap_of_edges(
        &self,
        edges: [usize; 2],
        other: &Self,
    ) -> Option<(Vector3<f64>, [TrianglePart; 2])> {
        let [[start_a, along_a], [start_b, along_b]] = [self.edge(edges[0]), other.edge(edges[1])];
        let (across, between) = (along_a.cross(&along_b), start_b - start_a);
        let share =
            |along: &Vector3<f64>| between.cross(along).dot(&across) / across.norm_squared();
        let (share_a, share_b) = (share(&along_b), share(&along_a));
        // The shares of parallel edges are not finite.
        let is_inside = |share: f64| share > 0.0 && share < 1.0;
        let gap = between + along_b * share_b - along_a * share_a;
        let parts = edges.map(TrianglePart::Edge);
        (is_inside(share_a) && is_inside(share_b)).then_some((gap, parts))
    }

    /// Returns whether an edge of the other triangle passes through this triangle. An edge that misses the
    /// triangle by less than the tolerance of [`Self::hit_by`] does not count, because its distance to the triangle is positive.
    fn is_crossed_by(&self, other: &Self) -> bool {
        let ends = |edge: usize| [other.corners()[edge], other.corners()[(edge + 1) % 3]];
        let hits = (0..3).filter_map(|edge| self.hit_by(&ends(edge)));
        let mut shares = hits.map(|(_, shares)| shares);
        shares.any(|shares| shares.iter().all(|&share| share >= 0.0))
    }

    /// Returns the start of an edge and the vector to its end (m).
    fn edge(&self, edge: usize) -> [Vector3<f64>; 2] {
        let start = self.corners()[edge];
        [start, self.corners()[(edge + 1) % 3] - start]
    }
}

/// Returns the smallest part of a triangle that contains the point with these barycentric coordinates.
fn part_of_shares(shares: [f64; 3]) -> TrianglePart {
    match shares.map(|share| share > 0.0) {
        [true, true, true] => TrianglePart::Interior,
        [true, true, false] => TrianglePart::Edge(0),
        [false, true, true] => TrianglePart::Edge(1),
        [true, false, true] => TrianglePart::Edge(2),
        [_, false, false] => TrianglePart::Corner(0),
        [false, true, false] => TrianglePart::Corner(1),
        [false, false, true] => TrianglePart::Corner(2),
    }
}
