use crate::geometry::{EDGES, FACES};
use crate::mesh::PressureField;
use rustc_hash::FxHashSet;

/// Reason why contact surfaces with a shape cannot be followed from polygon to polygon. They are
/// found by culling instead, which takes longer. The extent is 0 somewhere inside, so a contact
/// surface may end without crossing the body's surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotFollowed {
    /// All corners of a tetrahedron have extent 0.
    #[error("tetrahedron {tet} has extent 0 at all corners")]
    ZeroTetrahedron {
        /// Index of the tetrahedron.
        tet: usize,
    },
    /// A vertex inside the body has extent 0.
    #[error("vertex {vertex} has extent 0, but is not on the surface")]
    ZeroVertex {
        /// Index of the vertex in the mesh.
        vertex: usize,
    },
    /// An edge through the body joins two vertices of its surface.
    #[error(
        "the edge from vertex {} to {} joins two vertices of the surface through the inside, and the extent is 0 along it",
        vertices[0], vertices[1]
    )]
    ZeroEdge {
        /// Indices of the ends of the edge.
        vertices: [usize; 2],
    },
    /// A face inside the body has all its corners on the surface.
    #[error("face {face} of tetrahedron {tet} is inside, but the extent is 0 at all its corners")]
    ZeroFace {
        /// Index of a tetrahedron that has the face.
        tet: usize,
        /// Corner of the tetrahedron opposite to the face.
        face: usize,
    },
}

/// Checks that the extent is 0 only on the surface, and not at a vertex, edge or face inside.
pub(super) fn check_positive_inside(field: &PressureField) -> Result<(), NotFollowed> {
    let mut surface_edges = FxHashSet::default();
    for &[a, b, c] in field.mesh().surface_triangles() {
        surface_edges.extend([[a, b], [b, c], [c, a]].map(sorted));
    }
    let error = (0..field.tets().len()).find_map(|tet| zero_inside(field, &surface_edges, tet));
    error.map_or(Ok(()), Err)
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Returns a part of a tetrahedron that is not on the surface, and where the extent is 0.
fn zero_inside(
    field: &PressureField,
    surface_edges: &FxHashSet<[usize; 2]>,
    tet: usize,
) -> Option<NotFollowed> {
    let (mesh, extents) = (field.mesh(), &field.tets()[tet].extents);
    let vertices = mesh.tets()[tet];
    let is_zero = |corner: usize| extents[corner] == 0.0;
    if field.tets()[tet].is_inert() {
        return Some(NotFollowed::ZeroTetrahedron { tet });
    }
    let vertex = (0..4).find(|&corner| is_zero(corner) && !mesh.is_on_surface(vertices[corner]));
    if let Some(corner) = vertex {
        let vertex = vertices[corner];
        return Some(NotFollowed::ZeroVertex { vertex });
    }
    let zero_edges = EDGES.iter().filter(|[i, j]| is_zero(*i) && is_zero(*j));
    let mut zero_edges = zero_edges.map(|edge| sorted(edge.map(|corner| vertices[corner])));
    if let Some(vertices) = zero_edges.find(|edge| !surface_edges.contains(edge)) {
        return Some(NotFollowed::ZeroEdge { vertices });
    }
    let is_zero_face = |face: &usize| FACES[*face].iter().all(|&corner| is_zero(corner));
    let face = (0..4).find(|face| is_zero_face(face) && mesh.neighbor(tet, *face).is_some())?;
    Some(NotFollowed::ZeroFace { tet, face })
}
