use super::{MeshError, TetMesh};
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;

/// A new vertex inside an edge, a face or a tetrahedron: a weighted mean of its corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Center {
    corners: [usize; 4],
    shares: [f64; 4],
    count: usize,
}

impl Center {
    /// The centroid of a simplex.
    fn of<const SIZE: usize>(simplex: [usize; SIZE]) -> Self {
        Self {
            corners: std::array::from_fn(|corner| *simplex.get(corner).unwrap_or(&0)),
            shares: [1.0 / SIZE as f64; 4],
            count: SIZE,
        }
    }

    /// The point of an edge at this position, from 0 to 1.
    pub fn on_edge([a, b]: [usize; 2], position: f64) -> Self {
        Self {
            corners: [a, b, 0, 0],
            shares: [1.0 - position, position, 0.0, 0.0],
            count: 2,
        }
    }

    /// Creates a center at the point of a tetrahedron with these barycentric coordinates.
    pub fn in_tet(corners: [usize; 4], shares: [f64; 4]) -> Self {
        Self {
            corners,
            shares,
            count: 4,
        }
    }

    /// Returns the corners with their shares of the new vertex.
    pub fn corners(&self) -> impl Iterator<Item = (usize, f64)> {
        std::iter::zip(self.corners, self.shares).take(self.count)
    }
}

impl TetMesh {
    /// Splits inner simplices whose corners all lie on the surface, by a new vertex at their center.
    ///
    /// Edges are split first, then faces, then tetrahedra. A pressure field is 0 on the surface, so it would be 0 all
    /// over an unsplit simplex. With the new vertices it can be positive everywhere inside. The shape is unchanged.
    ///
    /// # Errors
    /// Returns an error if a part of a split tetrahedron is flat to within rounding error.
    pub fn with_inner_vertices(&self) -> Result<Self, MeshError> {
        Ok(with_inner_vertices(self)?.0.into_owned())
    }
}

/// Splits the mesh as [`TetMesh::with_inner_vertices`] does, and returns the new vertices in order. They follow the
/// original vertices. Borrows the mesh if nothing is split.
pub(super) fn with_inner_vertices(
    mesh: &TetMesh,
) -> Result<(Cow<'_, TetMesh>, Vec<Center>), MeshError> {
    // Edges precede faces and faces precede tetrahedra: a new vertex inside an edge also splits the adjacent faces and
    // tetrahedra.
    let mut centers = Vec::new();
    let mesh = without_flat::<2>(Cow::Borrowed(mesh), &mut centers)?;
    let mesh = without_flat::<3>(mesh, &mut centers)?;
    let mesh = without_flat::<4>(mesh, &mut centers)?;
    Ok((mesh, centers))
}

/// A new vertex inside a simplex of `SIZE` corners: 2 for an edge, 3 for a face, 4 for a tetrahedron.
pub(super) struct Division<const SIZE: usize> {
    /// Vertices of the simplex, sorted.
    pub simplex: [usize; SIZE],
    /// Position of the new vertex (m).
    pub at: Vector3<f64>,
}

/// Adds a vertex at the center of every flat simplex of `SIZE` corners, and appends the centers to `centers`.
fn without_flat<'m, const SIZE: usize>(
    mesh: Cow<'m, TetMesh>,
    centers: &mut Vec<Center>,
) -> Result<Cow<'m, TetMesh>, MeshError> {
    let center = |simplex: [usize; SIZE]| {
        let sum: Vector3<f64> = simplex.iter().map(|&vertex| mesh.vertices()[vertex]).sum();
        Division {
            simplex,
            at: sum / SIZE as f64,
        }
    };
    let divisions: Vec<_> = flat_simplices(&mesh).into_iter().map(center).collect();
    if divisions.is_empty() {
        return Ok(mesh);
    }
    centers.extend(
        divisions
            .iter()
            .map(|division| Center::of(division.simplex)),
    );
    divided(&mesh, &divisions).map(Cow::Owned)
}

/// Returns the simplices that have all corners on the surface but are not part of it, in order. Their vertices are
/// sorted.
fn flat_simplices<const SIZE: usize>(mesh: &TetMesh) -> Vec<[usize; SIZE]> {
    let triangles = mesh.surface_triangles().iter();
    let on_surface: FxHashSet<[usize; SIZE]> = triangles.flat_map(|t| subsets(t)).collect();
    let mut flat = Vec::new();
    for tet in mesh.tets() {
        let corners = tet.iter().filter(|&&vertex| mesh.is_on_surface(vertex));
        if corners.count() >= SIZE {
            flat.extend(subsets::<SIZE>(tet).filter(|simplex| {
                simplex.iter().all(|&vertex| mesh.is_on_surface(vertex))
                    && !on_surface.contains(simplex)
            }));
        }
    }
    flat.sort_unstable();
    flat.dedup();
    flat
}

/// Returns all subsets of `SIZE` vertices, each sorted.
fn subsets<const SIZE: usize>(vertices: &[usize]) -> impl Iterator<Item = [usize; SIZE]> {
    let choices = (0_u32..1 << vertices.len()).filter(|bits| bits.count_ones() as usize == SIZE);
    choices.map(|bits| {
        let mut indices = (0..vertices.len()).filter(|index| bits >> index & 1 == 1);
        let mut subset =
            [0; SIZE].map(|_: usize| indices.next().map_or(0, |index| vertices[index]));
        subset.sort_unstable();
        subset
    })
}

/// Splits every tetrahedron at the new vertices, in their order. The new vertices are appended to the vertices of the mesh.
pub(super) fn divided<const SIZE: usize>(
    mesh: &TetMesh,
    divisions: &[Division<SIZE>],
) -> Result<TetMesh, MeshError> {
    let new = divisions.iter().map(|division| division.at);
    let vertices: Vec<Vector3<f64>> = mesh.vertices().iter().copied().chain(new).collect();
    let simplices = divisions.iter().map(|division| division.simplex);
    let new_vertices: FxHashMap<_, _> = simplices.zip(mesh.vertex_count()..).collect();
    let mut is_touched = vec![false; mesh.vertex_count()];
    for &vertex in divisions.iter().flat_map(|division| &division.simplex) {
        is_touched[vertex] = true;
    }
    let mut tets = Vec::with_capacity(mesh.tet_count());
    for &tet in mesh.tets() {
        if tet.iter().filter(|&&vertex| is_touched[vertex]).count() >= SIZE {
            split(tet, &new_vertices, &mut tets);
        } else {
            tets.push(tet);
        }
    }
    TetMesh::new(vertices, tets)
}

/// Splits the tetrahedron at its simplex with the first of the new vertices, and its parts recursively at the next one. The two tetrahedra
/// at a face split its simplices in the same order, so the parts still match across the face.
fn split<const SIZE: usize>(
    tet: [usize; 4],
    new_vertices: &FxHashMap<[usize; SIZE], usize>,
    parts: &mut Vec<[usize; 4]>,
) {
    let divided_simplices =
        subsets::<SIZE>(&tet).filter_map(|simplex| Some((*new_vertices.get(&simplex)?, simplex)));
    let Some((new, simplex)) = divided_simplices.min() else {
        parts.push(tet);
        return;
    };
    for replaced in simplex {
        let part = tet.map(|vertex| if vertex == replaced { new } else { vertex });
        split(part, new_vertices, parts);
    }
}
