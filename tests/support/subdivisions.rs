//! Other meshes of the same body with the same field: divided, or in another order.

use super::scenes::Random;
use hydroelastic::mesh::{PressureField, TetMesh};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Division of a mesh. New vertices have the extent of the field at their position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Division {
    /// No division.
    Whole,
    /// Every second tetrahedron is divided into four at its centroid.
    Centroids,
    /// Every edge is halved, so each tetrahedron is divided into eight.
    Halves,
    /// Three edges are halved one after the other, which halves all tetrahedra around each edge.
    Edges,
}

impl Division {
    pub const ALL: [Self; 4] = [Self::Whole, Self::Centroids, Self::Halves, Self::Edges];
}

/// Returns the field on the divided mesh.
pub fn divided(field: &PressureField, division: Division, random: &mut Random) -> PressureField {
    let mut parts = Parts::of(field);
    match division {
        Division::Whole => {}
        Division::Centroids => parts.divide_at_centroids(),
        Division::Halves => parts.halve_all_edges(),
        Division::Edges => (0..3).for_each(|_| parts.halve_an_edge(random)),
    }
    parts.into_field()
}

/// Returns the field on the mesh with its vertices, its tetrahedra and their corners in another order.
pub fn shuffled(field: &PressureField, random: &mut Random) -> PressureField {
    let parts = Parts::of(field);
    let order = permutation(parts.vertices.len(), random);
    let mut new_index = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        new_index[old] = new;
    }
    let tets = permutation(parts.tets.len(), random)
        .into_iter()
        .map(|tet| {
            let corners = permutation(4, random);
            [0, 1, 2, 3].map(|k| new_index[parts.tets[tet][corners[k]]])
        });
    Parts {
        tets: tets.collect(),
        vertices: order.iter().map(|&old| parts.vertices[old]).collect(),
        extents: order.iter().map(|&old| parts.extents[old]).collect(),
        middles: BTreeMap::new(),
    }
    .into_field()
}

fn permutation(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for k in (1..count).rev() {
        order.swap(k, random.below(k + 1));
    }
    order
}

/// A mesh with extents during its division.
struct Parts {
    vertices: Vec<Vector3<f64>>,
    extents: Vec<f64>,
    tets: Vec<[usize; 4]>,
    /// Vertices in the middle of edges, by the ends of the edge.
    middles: BTreeMap<[usize; 2], usize>,
}

impl Parts {
    fn of(field: &PressureField) -> Self {
        Self {
            vertices: field.mesh().vertices().to_vec(),
            extents: field.extents().to_vec(),
            tets: field.mesh().tets().to_vec(),
            middles: BTreeMap::new(),
        }
    }

    fn into_field(self) -> PressureField {
        let mesh = TetMesh::new(self.vertices, self.tets).unwrap();
        PressureField::new(mesh, self.extents).unwrap()
    }

    fn divide_at_centroids(&mut self) {
        for (number, tet) in std::mem::take(&mut self.tets).into_iter().enumerate() {
            if number % 2 == 1 {
                self.tets.push(tet);
                continue;
            }
            let centroid = self.mean_of(&tet);
            self.tets
                .extend((0..4).map(|corner| with(tet, corner, centroid)));
        }
    }

    fn halve_all_edges(&mut self) {
        for tet in std::mem::take(&mut self.tets) {
            let mut middle = |i: usize, j: usize| self.middle_of(tet[i], tet[j]);
            let ends = [
                [tet[0], middle(0, 1), middle(0, 2), middle(0, 3)],
                [middle(0, 1), tet[1], middle(1, 2), middle(1, 3)],
                [middle(0, 2), middle(1, 2), tet[2], middle(2, 3)],
                [middle(0, 3), middle(1, 3), middle(2, 3), tet[3]],
            ];
            // The octahedron between the corner tetrahedra is divided around one of its diagonals.
            let diagonal = [middle(0, 1), middle(2, 3)];
            let around = [middle(0, 2), middle(0, 3), middle(1, 3), middle(1, 2)];
            let inner = (0..4).map(|k| [diagonal[0], diagonal[1], around[k], around[(k + 1) % 4]]);
            self.tets.extend(ends.into_iter().chain(inner));
        }
    }

    fn halve_an_edge(&mut self, random: &mut Random) {
        let tet = self.tets[random.below(self.tets.len())];
        let corners = permutation(4, random);
        let edge = [tet[corners[0]], tet[corners[1]]];
        let middle = self.middle_of(edge[0], edge[1]);
        for tet in std::mem::take(&mut self.tets) {
            match edge.map(|end| tet.iter().position(|&vertex| vertex == end)) {
                [Some(first), Some(second)] => self
                    .tets
                    .extend([with(tet, first, middle), with(tet, second, middle)]),
                _ => self.tets.push(tet),
            }
        }
    }

    fn middle_of(&mut self, from: usize, to: usize) -> usize {
        let edge = [from.min(to), from.max(to)];
        if let Some(&middle) = self.middles.get(&edge) {
            return middle;
        }
        let middle = self.mean_of(&edge);
        self.middles.insert(edge, middle);
        middle
    }

    /// Adds a vertex at the mean of these vertices.
    fn mean_of(&mut self, vertices: &[usize]) -> usize {
        let count = vertices.len() as f64;
        let position: Vector3<f64> = vertices.iter().map(|&v| self.vertices[v]).sum();
        let extent: f64 = vertices.iter().map(|&v| self.extents[v]).sum();
        self.vertices.push(position / count);
        self.extents.push(extent / count);
        self.vertices.len() - 1
    }
}

/// Returns the tetrahedron with another vertex at a corner.
fn with(mut tet: [usize; 4], corner: usize, vertex: usize) -> [usize; 4] {
    tet[corner] = vertex;
    tet
}
