use super::SurfaceError;

/// One triangle's side of an edge, which is named by its lower and its higher vertex.
struct Side {
    edge: [u32; 2],
    triangle: u32,
    /// The corner opposite to the edge.
    corner: u8,
    /// Whether the triangle runs from the lower vertex to the higher.
    forwards: bool,
}

/// For each triangle those beyond its edges, if every edge has two that run along it in opposite directions.
///
/// Sorting takes n log n; there are no more triangles and vertices than a `u32` counts.
pub(super) fn neighbors(triangles: &[[usize; 3]]) -> Result<Vec<[u32; 3]>, SurfaceError> {
    let sides = sorted_sides(triangles);
    let mut neighbors = vec![[0; 3]; triangles.len()];
    let (mut open, mut open_count) = (None, 0);
    for group in sides.chunk_by(|a, b| a.edge == b.edge) {
        match group {
            [side] => {
                open.get_or_insert(side);
                open_count += 1;
            }
            [a, b] if a.forwards != b.forwards => {
                neighbors[a.triangle as usize][usize::from(a.corner)] = b.triangle;
                neighbors[b.triangle as usize][usize::from(b.corner)] = a.triangle;
            }
            [a, b] => return Err(a.turned_as(b)),
            [a, b, ..] => return Err(a.crowded(b, group.len())),
            [] => {}
        }
    }
    match open {
        Some(side) => Err(side.open(open_count)),
        None => Ok(neighbors),
    }
}

/// The sides of all edges, those of an edge one after the other, in the order of their triangles.
#[expect(
    clippy::cast_possible_truncation,
    reason = "a surface has no more triangles and vertices than a u32 counts"
)]
fn sorted_sides(triangles: &[[usize; 3]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate() {
        for corner in 0..3_u8 {
            let place = usize::from(corner);
            let [from, to] = [corners[(place + 1) % 3], corners[(place + 2) % 3]];
            sides.push(Side {
                edge: [from.min(to) as u32, from.max(to) as u32],
                triangle: triangle as u32,
                corner,
                forwards: from < to,
            });
        }
    }
    sides.sort_unstable_by_key(|side| (side.edge, side.triangle));
    sides
}

impl Side {
    /// The vertices of the edge, in the direction in which the triangle runs.
    fn vertices(&self) -> [usize; 2] {
        let [lower, higher] = self.edge.map(|vertex| vertex as usize);
        if self.forwards {
            [lower, higher]
        } else {
            [higher, lower]
        }
    }

    fn turned_as(&self, other: &Self) -> SurfaceError {
        SurfaceError::InconsistentOrientation {
            first: self.triangle as usize,
            second: other.triangle as usize,
            edge: self.vertices(),
        }
    }

    fn crowded(&self, other: &Self, triangle_count: usize) -> SurfaceError {
        SurfaceError::CrowdedEdge {
            triangle_count,
            first: self.triangle as usize,
            second: other.triangle as usize,
            edge: self.edge.map(|vertex| vertex as usize),
        }
    }

    fn open(&self, edge_count: usize) -> SurfaceError {
        SurfaceError::Open {
            edge_count,
            triangle: self.triangle as usize,
            edge: self.vertices(),
        }
    }
}
