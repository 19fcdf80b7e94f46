use super::SurfaceError;

/// A half-edge: an edge as part of one triangle.
struct HalfEdge {
    /// The vertices of the edge, the lower one first.
    edge: [u32; 2],
    triangle: u32,
    /// The corner of the triangle opposite to the edge.
    corner: u8,
    /// Flag that is set if the triangle runs from the lower vertex to the higher one.
    forwards: bool,
}

/// Returns the neighbors of each triangle. Entry k is the triangle across the edge opposite to corner k.
///
/// Fails unless every edge has two half-edges of opposite directions. Sorting takes O(n log n) time. A `u32` must be
/// able to count the triangles and vertices.
pub(super) fn neighbors(triangles: &[[usize; 3]]) -> Result<Vec<[u32; 3]>, SurfaceError> {
    let half_edges = sorted_half_edges(triangles);
    let mut neighbors = vec![[0; 3]; triangles.len()];
    let (mut open, mut open_count) = (None, 0);
    for group in half_edges.chunk_by(|a, b| a.edge == b.edge) {
        match group {
            [alone] => {
                open.get_or_insert(alone);
                open_count += 1;
            }
            [a, b] if a.forwards != b.forwards => {
                neighbors[a.triangle as usize][usize::from(a.corner)] = b.triangle;
                neighbors[b.triangle as usize][usize::from(b.corner)] = a.triangle;
            }
            [a, b] => return Err(a.inconsistent_with(b)),
            [a, b, ..] => return Err(a.crowded_with(b, group.len())),
            [] => {}
        }
    }
    match open {
        Some(alone) => Err(alone.open_among(open_count)),
        None => Ok(neighbors),
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

    fn inconsistent_with(&self, other: &Self) -> SurfaceError {
        SurfaceError::InconsistentOrientation {
            first: self.triangle as usize,
            second: other.triangle as usize,
            edge: self.vertices(),
        }
    }

    fn crowded_with(&self, other: &Self, triangle_count: usize) -> SurfaceError {
        SurfaceError::CrowdedEdge {
            triangle_count,
            first: self.triangle as usize,
            second: other.triangle as usize,
            edge: self.edge.map(|vertex| vertex as usize),
        }
    }

    fn open_among(&self, edge_count: usize) -> SurfaceError {
        SurfaceError::Open {
            edge_count,
            triangle: self.triangle as usize,
            edge: self.vertices(),
        }
    }
}
