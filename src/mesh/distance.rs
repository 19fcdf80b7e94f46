use super::deepest::deepest_point;
use super::distance_fit::DistanceFit;
use super::splitting::{self, Center};
use super::surface_distance::SurfaceDistance;
use super::{MeshError, TetMesh};
use crate::parallel;
use nalgebra::Vector3;

/// A mesh whose extents are distances to its surface, with the data needed to differentiate them.
pub(super) struct MadeOfDistances {
    pub mesh: TetMesh,
    pub surface: SurfaceDistance,
    pub extents: Vec<f64>,
    /// The vertices that follow the vertices of the input mesh: points of the simplices that were split.
    pub centers: Vec<Center>,
    /// Distances (m) of the vertices of the input mesh from the surface, followed by the distances of `centers`.
    pub distances: Vec<f64>,
    /// The vertices that follow `centers`: intersections of edges with the inner boundary of a skin.
    pub passages: Vec<Passage>,
    /// The fit of the distances, if the extents are fitted.
    pub fit: Option<DistanceFit>,
}

/// A new vertex where an edge crosses the depth of a skin. Its position is from + share·(to − from) with share = (1 −
/// e_from)/(e_to − e_from), where e is the distance to the surface over the depth.
#[derive(Debug, Clone)]
pub(super) struct Passage {
    /// The vertices of the edge, from and to.
    pub ends: [usize; 2],
    /// Position along the edge, from 0 to 1.
    pub share: f64,
    /// Vector (m) from the first end of the edge to the second.
    pub edge: Vector3<f64>,
    /// Derivatives of `share` with respect to the extents at the two ends.
    pub slopes: [f64; 2],
}

/// Returns the distance (m) of each vertex to the surface. It is 0 for vertices of the surface.
pub(super) fn distances(mesh: &TetMesh, surface: &SurfaceDistance) -> Vec<f64> {
    distances_from(0, mesh, surface)
}

/// Returns the distances (m) of the vertices from the first index on.
pub(super) fn distances_from(first: usize, mesh: &TetMesh, surface: &SurfaceDistance) -> Vec<f64> {
    parallel::values_of(mesh.vertex_count() - first, |index| {
        let vertex = first + index;
        if mesh.is_on_surface(vertex) {
            0.0
        } else {
            surface.to(&mesh.vertices()[vertex])
        }
    })
}

/// Builds a mesh whose extents are the distances divided by the largest distance, in [0, 1]. All extents are zero if no
/// vertex lies inside.
pub(super) fn normalized(mesh: &TetMesh) -> Result<MadeOfDistances, MeshError> {
    let (mesh, centers) = splitting::with_inner_vertices(mesh)?;
    let surface = SurfaceDistance::of(&mesh);
    let distances = distances(&mesh, &surface);
    Ok(with_extents(mesh.into_owned(), centers, surface, distances))
}

/// Builds the mesh of [`normalized`] without splitting simplices. If a point inside a tetrahedron is farther from the surface than all
/// vertices, the tetrahedron is split there. `centers` are the last vertices of `mesh`.
pub(super) fn normalized_with_deepest(
    mut mesh: TetMesh,
    mut centers: Vec<Center>,
) -> Result<MadeOfDistances, MeshError> {
    let surface = SurfaceDistance::of(&mesh);
    let mut distances = distances(&mesh, &surface);
    if let Some(deepest) = deepest_point(&mesh, &surface, &distances) {
        mesh = splitting::divided(&mesh, &[deepest.division()])?;
        centers.push(deepest.center());
        distances.push(deepest.distance);
    }
    Ok(with_extents(mesh, centers, surface, distances))
}

/// Builds the mesh of [`normalized_with_deepest`] for a mesh without splits, with extents whose means are correct.
pub(super) fn fitted_with_deepest(mesh: TetMesh) -> Result<MadeOfDistances, MeshError> {
    let mut made = normalized_with_deepest(mesh, Vec::new())?;
    let fit = DistanceFit::of(&made.mesh, &made.surface, &made.distances);
    made.extents = extents(fit.of_distances(&made.distances), &made.distances);
    made.fit = Some(fit);
    Ok(made)
}

/// Divides lengths (m) by the largest distance (m), if it is positive.
fn extents(mut lengths: Vec<f64>, distances: &[f64]) -> Vec<f64> {
    let largest = distances.iter().copied().fold(0.0, f64::max);
    if largest > 0.0 {
        for length in &mut lengths {
            *length /= largest;
        }
    }
    lengths
}

/// Normalizes the distances (m) to extents.
fn with_extents(
    mesh: TetMesh,
    centers: Vec<Center>,
    surface: SurfaceDistance,
    distances: Vec<f64>,
) -> MadeOfDistances {
    MadeOfDistances {
        mesh,
        surface,
        extents: extents(distances.clone(), &distances),
        centers,
        distances,
        passages: Vec::new(),
        fit: None,
    }
}
