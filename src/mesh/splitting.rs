use super::{MeshError, TetMesh};
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;

/// A new vertex in the middle of an edge, a face or a tetrahedron.
#[derive(Debug, Clone, Copy)]
pub(super) struct Center {
    corners: [usize; 4],
    count: usize,
}

impl Center {
    fn of<const SIZE: usize>(simplex: [usize; SIZE]) -> Self {
        let corners = std::array::from_fn(|place| *simplex.get(place).unwrap_or(&0));
        let count = SIZE;
        Self { corners, count }
    }

    /// The vertices whose mean it is.
    pub fn corners(&self) -> &[usize] {
        &self.corners[..self.count]
    }
}

impl TetMesh {
    /// The mesh with a new vertex at the center of every edge, then every face, then every
    /// tetrahedron that runs through the inside although all its corners lie on the surface.
    ///
    /// A pressure field is 0 on the surface, so over such an edge, face or tetrahedron it would
    /// be 0 too; with the new vertices it can rise everywhere inside. The shape stays the same.
    ///
    /// # Errors
    /// If a part of a split tetrahedron is flat to round-off.
    pub fn with_inner_vertices(&self) -> Result<Self, MeshError> {
        Ok(with_inner_vertices(self)?.0.into_owned())
    }
}

/// The mesh as [`TetMesh::with_inner_vertices`] splits it, itself where nothing is to be split; and the new vertices, in their
/// order, which follow its own.
pub(super) fn with_inner_vertices(
    mesh: &TetMesh,
) -> Result<(Cow<'_, TetMesh>, Vec<Center>), MeshError> {
    // Edges before faces before tetrahedra: a new vertex inside an edge also serves the faces and
    // tetrahedra around it.
    let mut centers = Vec::new();
    let mesh = without_flat::<2>(Cow::Borrowed(mesh), &mut centers)?;
    let mesh = without_flat::<3>(mesh, &mut centers)?;
    let mesh = without_flat::<4>(mesh, &mut centers)?;
    Ok((mesh, centers))
}

/// A new vertex of a mesh, inside a simplex of `SIZE` corners (2 an edge, 3 a face, 4 a tetrahedron).
pub(super) struct Division<const SIZE: usize> {
    /// Vertices of the simplex, sorted.
    pub simplex: [usize; SIZE],
    /// Where the new vertex lies (m).
    pub at: Vector3<f64>,
}

/// The mesh with a vertex at the center of every flat simplex of `SIZE` corners; adds these centers to the list.
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
    centers.extend(divisions.iter().map(|it| Center::of(it.simplex)));
    divided(&mesh, &divisions).map(Cow::Owned)
}

/// The simplices that have all corners on the surface but are not part of it, by their sorted
/// vertices, in order.
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

/// All subsets of `SIZE` of the vertices, each sorted.
fn subsets<const SIZE: usize>(vertices: &[usize]) -> impl Iterator<Item = [usize; SIZE]> {
    let choices = (0_u32..1 << vertices.len()).filter(|bits| bits.count_ones() as usize == SIZE);
    choices.map(|bits| {
        let mut places = (0..vertices.len()).filter(|place| bits >> place & 1 == 1);
        let mut subset = [0; SIZE].map(|_: usize| places.next().map_or(0, |place| vertices[place]));
        subset.sort_unstable();
        subset
    })
}

/// The mesh with every tetrahedron split at the new vertices, which are appended to its own.
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

/// Splits at the lowest of the simplices the tetrahedron has, then its parts at the next. Both
/// tetrahedra at a face take the simplices of that face in the same order, so they still meet.
fn split<const SIZE: usize>(
    tet: [usize; 4],
    new_vertices: &FxHashMap<[usize; SIZE], usize>,
    parts: &mut Vec<[usize; 4]>,
) {
    let own = subsets::<SIZE>(&tet).filter(|simplex| new_vertices.contains_key(simplex));
    let Some(simplex) = own.min() else {
        parts.push(tet);
        return;
    };
    let new = new_vertices[&simplex];
    for replaced in simplex {
        let part = tet.map(|vertex| if vertex == replaced { new } else { vertex });
        split(part, new_vertices, parts);
    }
}
