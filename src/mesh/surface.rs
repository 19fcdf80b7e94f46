use super::MeshError;
use crate::geometry::FACES;

/// The neighbor across a face of the surface.
pub(crate) const OUTSIDE: u32 = u32::MAX;

/// The adjacency of tetrahedra, and the faces that belong to one tetrahedron only.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// The neighbor of each tetrahedron across the face opposite to each corner, or [`OUTSIDE`].
    pub neighbors: Vec<[u32; 4]>,
    /// Vertex indices of the surface triangles, counter-clockwise when seen from outside, in the order of the
    /// tetrahedra.
    pub triangles: Vec<[usize; 3]>,
    /// Flag of each vertex that lies on the surface.
    pub has_vertex: Vec<bool>,
}

/// A face of a tetrahedron. `sorted` identifies the face, and `even` the side on which the tetrahedron lies. `corner`
/// is the opposite corner of the tetrahedron.
#[derive(Clone, Copy)]
struct Face {
    sorted: [u32; 3],
    tet: u32,
    corner: u8,
    even: bool,
}

impl Surface {
    /// Finds the surface of positively oriented tetrahedra.
    pub fn of(tets: &[[usize; 4]], vertex_count: usize) -> Result<Self, MeshError> {
        let faces = sorted_faces(tets, vertex_count);
        let mut neighbors = vec![[OUTSIDE; 4]; tets.len()];
        let mut outer: Vec<&Face> = Vec::new();
        for group in faces.chunk_by(|a, b| a.sorted == b.sorted) {
            match group {
                [face] => outer.push(face),
                [a, b] if a.even != b.even => {
                    neighbors[a.tet as usize][usize::from(a.corner)] = b.tet;
                    neighbors[b.tet as usize][usize::from(b.corner)] = a.tet;
                }
                [.., a, b] => return Err(a.overlap_with(b)),
                [] => {}
            }
        }
        let in_order = |face: &&Face| (face.tet, face.outward(tets));
        outer.sort_unstable_by_key(in_order);
        let triangles: Vec<[usize; 3]> = outer.iter().map(|face| face.outward(tets)).collect();
        let mut has_vertex = vec![false; vertex_count];
        for &vertex in triangles.iter().flatten() {
            has_vertex[vertex] = true;
        }
        Ok(Self {
            neighbors,
            triangles,
            has_vertex,
        })
    }
}

/// Returns the faces of all tetrahedra, sorted by vertices and then by tetrahedron. A counting sort groups them by
/// their first vertex, and each short group is then sorted.
fn sorted_faces(tets: &[[usize; 4]], vertex_count: usize) -> Vec<Face> {
    let faces = || {
        (0_u32..)
            .zip(tets)
            .flat_map(|(index, tet)| Face::all_of(index, tet))
    };
    let mut starts = vec![0_usize; vertex_count];
    for face in faces() {
        starts[face.sorted[0] as usize] += 1;
    }
    let mut end = 0;
    for count in &mut starts {
        end += std::mem::replace(count, end);
    }
    let blank = Face::all_of(0, &[0; 4])[0];
    let mut sorted = vec![blank; end];
    for face in faces() {
        let next = &mut starts[face.sorted[0] as usize];
        sorted[*next] = face;
        *next += 1;
    }
    let together = sorted.chunk_by_mut(|a, b| a.sorted[0] == b.sorted[0]);
    together.for_each(|list| list.sort_unstable_by_key(|face| (face.sorted, face.tet)));
    sorted
}

impl Face {
    /// Returns the four faces of a tetrahedron.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "a mesh has no more vertices than a u32 counts"
    )]
    fn all_of(tet: u32, vertices: &[usize; 4]) -> [Self; 4] {
        [0_u8, 1, 2, 3].map(|corner| {
            let outward = FACES[usize::from(corner)].map(|c| vertices[c] as u32);
            let mut sorted = outward;
            sorted.sort_unstable();
            let [a, b, c] = outward;
            Self {
                sorted,
                tet,
                corner,
                even: [[a, b, c], [b, c, a], [c, a, b]].contains(&sorted),
            }
        })
    }

    /// Returns the vertices of the face, counter-clockwise when seen from outside its tetrahedron.
    fn outward(&self, tets: &[[usize; 4]]) -> [usize; 3] {
        FACES[usize::from(self.corner)].map(|c| tets[self.tet as usize][c])
    }

    fn overlap_with(&self, other: &Self) -> MeshError {
        MeshError::OverlappingTets {
            first: self.tet as usize,
            second: other.tet as usize,
            face: self.sorted.map(|vertex| vertex as usize),
        }
    }
}
