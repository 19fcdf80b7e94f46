use super::{MeshError, TetMesh};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// See [`TetMesh::with_inner_vertices`].
pub(super) fn with_inner_vertices(mesh: &TetMesh) -> Result<TetMesh, MeshError> {
    // Edges before faces before tetrahedra: a new vertex inside an edge also serves the faces and
    // tetrahedra around it.
    (2..=4).try_fold(mesh.clone(), |mesh, size| {
        split(&mesh, &flat_simplices(&mesh, size))
    })
}

/// The simplices of `size` corners (2 edges, 3 faces, 4 tetrahedra) that have all corners on the
/// surface but are not part of it, by their sorted vertices.
fn flat_simplices(mesh: &TetMesh, size: usize) -> BTreeSet<Vec<usize>> {
    let on_surface: BTreeSet<Vec<usize>> = mesh
        .surface_triangles()
        .iter()
        .flat_map(|triangle| subsets(triangle, size))
        .collect();
    mesh.tets()
        .iter()
        .flat_map(|tet| subsets(tet, size))
        .filter(|simplex| simplex.iter().all(|&vertex| mesh.is_on_surface(vertex)))
        .filter(|simplex| !on_surface.contains(simplex))
        .collect()
}

/// All subsets of `size` of the vertices, each sorted.
fn subsets(vertices: &[usize], size: usize) -> Vec<Vec<usize>> {
    (0_u32..1 << vertices.len())
        .filter(|bits| bits.count_ones() as usize == size)
        .map(|bits| {
            let chosen = (0..vertices.len()).filter(|place| bits >> place & 1 == 1);
            let mut subset: Vec<usize> = chosen.map(|place| vertices[place]).collect();
            subset.sort_unstable();
            subset
        })
        .collect()
}

/// The mesh with every tetrahedron split at the centres of the simplices.
fn split(mesh: &TetMesh, simplices: &BTreeSet<Vec<usize>>) -> Result<TetMesh, MeshError> {
    let mut vertices = mesh.vertices().to_vec();
    let mut centers = BTreeMap::new();
    for simplex in simplices {
        let sum: Vector3<f64> = simplex.iter().map(|&vertex| mesh.vertices()[vertex]).sum();
        centers.insert(simplex.clone(), vertices.len());
        vertices.push(sum / simplex.len() as f64);
    }
    let size = simplices.first().map_or(0, Vec::len);
    let mut tets = Vec::new();
    for &tet in mesh.tets() {
        split_tet(tet, size, &centers, &mut tets);
    }
    TetMesh::new(vertices, tets)
}

/// Splits at the lowest of the simplices the tetrahedron has, then its parts at the next. Both
/// tetrahedra at a face take the simplices of that face in the same order, so they still meet.
fn split_tet(
    tet: [usize; 4],
    size: usize,
    centers: &BTreeMap<Vec<usize>, usize>,
    parts: &mut Vec<[usize; 4]>,
) {
    let mut own = subsets(&tet, size);
    own.sort();
    let Some((simplex, &center)) = own.iter().find_map(|s| centers.get_key_value(s)) else {
        parts.push(tet);
        return;
    };
    for replaced in simplex {
        let part = tet.map(|vertex| if vertex == *replaced { center } else { vertex });
        split_tet(part, size, centers, parts);
    }
}
