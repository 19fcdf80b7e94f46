use super::splitting::{self, Center};
use super::surface_distance::SurfaceDistance;
use super::{MeshError, TetMesh};
use crate::threads;
use nalgebra::Vector3;

/// A mesh with extents from the distance to its surface, and how both came about.
pub(super) struct MadeOfDistances {
    pub mesh: TetMesh,
    pub surface: SurfaceDistance,
    pub extents: Vec<f64>,
    /// The vertices that follow those of the given mesh: in the middle of edges, faces and tetrahedra that were split.
    pub centers: Vec<Center>,
    /// Distances (m) of these vertices and of those of the given mesh to the surface.
    pub distances: Vec<f64>,
    /// The vertices that follow the centers: where edges pass the depth of a skin.
    pub passages: Vec<Passage>,
}

/// A new vertex where an edge passes the depth of a skin: at from + share·(to − from) with
/// share = (1 − e_from)/(e_to − e_from), e the distance over the depth.
#[derive(Debug, Clone)]
pub(super) struct Passage {
    /// The vertices of the edge.
    pub ends: [usize; 2],
    /// How far along the edge, from 0 to 1.
    pub share: f64,
    /// From one end to the other (m).
    pub edge: Vector3<f64>,
    /// The derivatives of the share by the extents at the ends.
    pub slopes: [f64; 2],
}

/// For each vertex its distance (m) to the surface: 0 on it.
pub(super) fn distances(mesh: &TetMesh, surface: &SurfaceDistance) -> Vec<f64> {
    threads::values_of(mesh.vertex_count(), |vertex| {
        if mesh.is_on_surface(vertex) {
            0.0
        } else {
            surface.to(&mesh.vertices()[vertex])
        }
    })
}

/// Distances over the largest of them: in [0, 1]. All zero where no vertex lies inside.
pub(super) fn normalized(mesh: &TetMesh) -> Result<MadeOfDistances, MeshError> {
    let (mesh, centers) = splitting::with_inner_vertices(mesh)?;
    let surface = SurfaceDistance::of(&mesh);
    let distances = distances(&mesh, &surface);
    let mut extents = distances.clone();
    let largest = distances.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        for extent in &mut extents {
            *extent /= largest;
        }
    }
    Ok(MadeOfDistances {
        mesh: mesh.into_owned(),
        surface,
        extents,
        centers,
        distances,
        passages: Vec::new(),
    })
}
