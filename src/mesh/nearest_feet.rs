use super::TetMesh;
use super::distance::MadeOfDistances;
use super::surface_distance::{SurfaceDistance, SurfaceTriangle};
use crate::geometry::Foot;
use crate::threads;
use nalgebra::Vector3;
use rustc_hash::FxHashSet;

/// Distances that differ by no more than this, relative to the size of the surface, count as equal: coordinates of files often
/// have ten digits, and contact takes faces for coincident that are 2.5e-10 apart.
pub(super) const EQUAL: f64 = 1e-9;

/// How the distance of a vertex depends on a triangle of the surface: ∂d/∂x = n, ∂d/∂v = −λ n, with n from its nearest point to
/// the vertex, and the barycentric coordinates λ of that point. These change too, but along the surface, which changes nothing.
#[derive(Debug, Clone)]
pub(super) struct Dependence {
    /// The vertex.
    pub vertex: usize,
    /// The vertices of the triangle.
    pub corners: [usize; 3],
    /// The barycentric coordinates of the point.
    pub shares: [f64; 3],
    /// From the point to the vertex, of length one over the number of such triangles that the vertex has: their mean counts.
    pub direction: Vector3<f64>,
}

/// What the distances of all vertices depend on, and the vertices at which they have no derivative: those with several places of
/// the surface equally near, and those that lie on the surface without being vertices of it. Vertices of the surface depend on
/// nothing: their distance is 0.
pub(super) fn dependences(made: &MadeOfDistances) -> (Vec<Dependence>, Vec<usize>) {
    let MadeOfDistances {
        mesh,
        surface,
        distances,
        ..
    } = made;
    let of_vertices = threads::values_of(distances.len(), |vertex| {
        if mesh.is_on_surface(vertex) {
            return Vec::new();
        }
        of_vertex(surface, mesh, vertex, distances[vertex])
    });
    let is_ambiguous = |found: &Vec<Dependence>| {
        found.len() > 1 || found.iter().any(|it| it.direction == Vector3::zeros())
    };
    let ambiguous = (0..of_vertices.len()).filter(|&vertex| is_ambiguous(&of_vertices[vertex]));
    let ambiguous = ambiguous.collect();
    (of_vertices.into_iter().flatten().collect(), ambiguous)
}

/// The dependences of a vertex inside, at this distance (m) from the surface: one for each place of it that is nearest.
fn of_vertex(
    surface: &SurfaceDistance,
    mesh: &TetMesh,
    vertex: usize,
    distance: f64,
) -> Vec<Dependence> {
    let point = &mesh.vertices()[vertex];
    let mut near = surface.feet(point, distance + EQUAL * surface.size());
    near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    // Parts of triangles that were looked at: one that is nearest in a part of a nearer triangle is none of its own.
    let mut seen = FxHashSet::default();
    near.retain(|(_, facet, foot)| {
        let is_new = !seen.contains(&sorted(part_below(facet, foot)));
        seen.extend(parts(facet));
        is_new
    });
    let count = near.len() as f64;
    let dependence = |(_, facet, foot): (f64, &SurfaceTriangle, Foot)| Dependence {
        vertex,
        corners: facet.vertices,
        shares: foot.shares,
        direction: foot.direction / count,
    };
    near.into_iter().map(dependence).collect()
}

/// A corner, an edge or the whole of a triangle: the vertices, and otherwise nothing.
type Part = [Option<usize>; 3];

fn sorted(mut part: Part) -> Part {
    part.sort_unstable();
    part
}

/// The least part of the triangle in which its nearest point lies.
fn part_below(facet: &SurfaceTriangle, foot: &Foot) -> Part {
    std::array::from_fn(|corner| (foot.shares[corner] > 0.0).then_some(facet.vertices[corner]))
}

/// All parts of the triangle.
fn parts(facet: &SurfaceTriangle) -> impl Iterator<Item = Part> {
    let part = |bits: usize| {
        std::array::from_fn(|corner| (bits >> corner & 1 == 1).then_some(facet.vertices[corner]))
    };
    (1..8).map(move |bits| sorted(part(bits)))
}
