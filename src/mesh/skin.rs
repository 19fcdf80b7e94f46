use super::distance::distances;
use super::splitting::{self, Division};
use super::{MeshError, TetMesh};

/// A vertex counts as lying where the skin ends if its extent is so near to 1.
const NEARNESS: f64 = 1e-3;

/// A mesh of the same solid in which no edge passes the depth (m), and its extents: the distance to the surface over the
/// depth, 1 at most.
pub(super) fn layered(mesh: &TetMesh, depth: f64) -> Result<(TetMesh, Vec<f64>), MeshError> {
    if !(depth > 0.0 && depth.is_finite()) {
        let (name, value) = ("skin depth", depth);
        return Err(MeshError::InvalidDimension { name, value });
    }
    let mesh = splitting::with_inner_vertices(mesh)?;
    let mut extents = distances(&mesh);
    for extent in &mut extents {
        *extent /= depth;
        if (*extent - 1.0).abs() <= NEARNESS {
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
        splitting::divided(&mesh, &passages)?
    };
    Ok((mesh, extents))
}

/// Where edges pass the extent 1, in the order of their vertices.
fn passages(mesh: &TetMesh, extents: &[f64]) -> Vec<Division<2>> {
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
    let passage = |simplex: [usize; 2]| {
        let [from, to] = simplex.map(|vertex| mesh.vertices()[vertex]);
        let [low, high] = simplex.map(|vertex| extents[vertex] - 1.0);
        Division {
            simplex,
            at: from + (to - from) * (low / (low - high)),
        }
    };
    passing.into_iter().map(passage).collect()
}
