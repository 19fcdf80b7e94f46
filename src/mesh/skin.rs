use super::distance::{MadeOfDistances, Passage, distances};
use super::splitting::{self, Division};
use super::surface_distance::SurfaceDistance;
use super::{MeshError, TetMesh};

/// Largest difference from 1 of an extent that counts as the end of the skin.
const NEARNESS: f64 = 1e-3;

/// Returns true if a vertex of this extent counts as the end of the skin.
pub(super) fn is_at_end(extent: f64) -> bool {
    (extent - 1.0).abs() <= NEARNESS
}

/// Splits the mesh so that no edge crosses the depth (m), and computes its extents. The extent is the distance to the
/// surface over the depth, clamped to 1.
pub(super) fn layered(mesh: &TetMesh, depth: f64) -> Result<MadeOfDistances, MeshError> {
    if !(depth > 0.0 && depth.is_finite()) {
        let (name, value) = ("skin depth", depth);
        return Err(MeshError::InvalidDimension { name, value });
    }
    let (mesh, centers) = splitting::with_inner_vertices(mesh)?;
    let surface = SurfaceDistance::of(&mesh);
    let distances = distances(&mesh, &surface);
    let mut extents = distances.clone();
    for extent in &mut extents {
        *extent /= depth;
        if is_at_end(*extent) {
            *extent = 1.0;
        }
    }
    let passages = passages(&mesh, &extents);
    extents.resize(extents.len() + passages.len(), 1.0);
    for extent in &mut extents {
        *extent = extent.min(1.0);
    }
    let mesh = if passages.is_empty() {
        mesh.into_owned()
    } else {
        let divisions: Vec<_> = passages
            .iter()
            .map(|passage| passage.division(&mesh))
            .collect();
        splitting::divided(&mesh, &divisions)?
    };
    Ok(MadeOfDistances {
        mesh,
        // New vertices are inside the body, so the surface is unchanged.
        surface,
        extents,
        centers,
        distances,
        passages,
        fit: None,
    })
}

/// Returns the points where edges cross the extent 1, in the order of their vertices.
fn passages(mesh: &TetMesh, extents: &[f64]) -> Vec<Passage> {
    let mut passing = Vec::new();
    for tet in mesh.tets() {
        let low = tet.iter().filter(|&&vertex| extents[vertex] < 1.0);
        for &a in low {
            let high = tet.iter().filter(|&&vertex| extents[vertex] > 1.0);
            passing.extend(high.map(|&b| [a.min(b), a.max(b)]));
        }
    }
    passing.sort_unstable();
    passing.dedup();
    let passage = |ends: [usize; 2]| {
        let [from, to] = ends.map(|vertex| mesh.vertices()[vertex]);
        let [low, high] = ends.map(|vertex| extents[vertex] - 1.0);
        let share = low / (low - high);
        Passage {
            ends,
            share,
            edge: to - from,
            slopes: [share - 1.0, -share].map(|slope| slope / (high - low)),
        }
    };
    passing.into_iter().map(passage).collect()
}

impl Passage {
    fn division(&self, mesh: &TetMesh) -> Division<2> {
        Division {
            simplex: self.ends,
            at: mesh.vertices()[self.ends[0]] + self.edge * self.share,
        }
    }
}
