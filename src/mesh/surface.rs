use super::MeshError;
use crate::geometry::FACES;

/// A tetrahedron's neighbour across a face that belongs to no other.
pub(super) const OUTSIDE: u32 = u32::MAX;

/// Which tetrahedra meet in a face; the faces that belong to one only, and the vertices on them.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// For each tetrahedron the one across the face opposite to each corner, or [`OUTSIDE`].
    pub neighbours: Vec<[u32; 4]>,
    /// Vertex indices, counter-clockwise seen from outside, in the order of the tetrahedra.
    pub triangles: Vec<[usize; 3]>,
    /// For each vertex whether it lies on the surface.
    pub has_vertex: Vec<bool>,
}

/// A face of a tetrahedron: `sorted` tells which it is, `even` on which side the tetrahedron lies,
/// `corner` which corner of the tetrahedron is opposite.
struct Face {
    sorted: [usize; 3],
    even: bool,
    tet: usize,
    corner: usize,
    outward: [usize; 3],
}

impl Surface {
    /// The surface of positively oriented tetrahedra.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a mesh has no more tetrahedra than a u32 counts"
    )]
    pub fn of(tets: &[[usize; 4]], vertex_count: usize) -> Result<Self, MeshError> {
        let mut faces: Vec<Face> = (0..tets.len())
            .flat_map(|tet| (0..4).map(move |corner| Face::new(tets, tet, corner)))
            .collect();
        faces.sort_by_key(|face| (face.sorted, face.tet));
        let mut neighbours = vec![[OUTSIDE; 4]; tets.len()];
        let mut outer: Vec<&Face> = Vec::new();
        for group in faces.chunk_by(|a, b| a.sorted == b.sorted) {
            match group {
                [face] => outer.push(face),
                [a, b] if a.even != b.even => {
                    neighbours[a.tet][a.corner] = b.tet as u32;
                    neighbours[b.tet][b.corner] = a.tet as u32;
                }
                [.., a, b] => return Err(a.overlap_with(b)),
                [] => {}
            }
        }
        outer.sort_by_key(|face| (face.tet, face.outward));
        let triangles: Vec<[usize; 3]> = outer.iter().map(|face| face.outward).collect();
        let mut has_vertex = vec![false; vertex_count];
        for &vertex in triangles.iter().flatten() {
            has_vertex[vertex] = true;
        }
        Ok(Self {
            neighbours,
            triangles,
            has_vertex,
        })
    }
}

impl Face {
    fn new(tets: &[[usize; 4]], tet: usize, corner: usize) -> Self {
        let outward = FACES[corner].map(|c| tets[tet][c]);
        let mut sorted = outward;
        sorted.sort_unstable();
        let [a, b, c] = outward;
        let even = [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted);
        Self {
            sorted,
            even,
            tet,
            corner,
            outward,
        }
    }

    fn overlap_with(&self, other: &Self) -> MeshError {
        MeshError::OverlappingTets {
            first: self.tet,
            second: other.tet,
            face: self.sorted,
        }
    }
}
