use super::distance::MadeOfDistances;
use super::surface_distance::{SurfaceDistance, SurfaceTriangle};
use crate::geometry::Foot;
use crate::parallel;
use nalgebra::Vector3;
use rustc_hash::FxHashSet;

/// Tolerance for equal distances, relative to the size of the surface. Coordinates in files often have ten digits, and
/// derivatives of contact treat faces up to 2.5e-10 apart as coincident.
pub(super) const EQUAL: f64 = 1e-9;

/// The dependence of the distance d of a point on a triangle of the surface: ∂d/∂x = n and ∂d/∂v = −λ n. Here n is the unit
/// vector from the closest point to the point x, and λ are the barycentric coordinates of the closest point. The
/// coordinates λ vary too, but the closest point then moves along the surface, which does not change d to first order.
#[derive(Debug, Clone)]
pub(super) struct Dependence {
    /// Index of the point: a vertex, or the number of vertices plus the index of a tetrahedron for its centroid.
    pub point: usize,
    /// The vertices of the triangle.
    pub corners: [usize; 3],
    /// The barycentric coordinates of the closest point.
    pub shares: [f64; 3],
    /// The vector n divided by the number of closest triangles, so that a sum over them is their mean.
    pub direction: Vector3<f64>,
}

/// Returns the dependences of the distances of all vertices, and of the centroids of a fit, and the points at which a distance is not
/// differentiable. Those points have several closest places on the surface, or lie on the surface without being
/// vertices of it. Vertices of the surface have no dependences, because their distance is always 0.
pub(super) fn dependences(made: &MadeOfDistances) -> (Vec<Dependence>, Vec<usize>) {
    let MadeOfDistances {
        mesh,
        surface,
        distances,
        fit,
        ..
    } = made;
    let centroids = fit.as_ref().map_or(&[][..], |fit| &fit.tets);
    let of_points = parallel::values_of(distances.len() + centroids.len(), |point| {
        match point.checked_sub(distances.len()) {
            Some(tet) => {
                let centroid = mesh.tetrahedron(tet).centroid();
                of_point(surface, point, &centroid, centroids[tet].distance)
            }
            None if mesh.is_on_surface(point) => Vec::new(),
            None => of_point(surface, point, &mesh.vertices()[point], distances[point]),
        }
    });
    let is_ambiguous = |dependences: &Vec<Dependence>| {
        dependences.len() > 1
            || dependences
                .iter()
                .any(|dependence| dependence.direction == Vector3::zeros())
    };
    let ambiguous = (0..of_points.len()).filter(|&point| is_ambiguous(&of_points[point]));
    let ambiguous = ambiguous.collect();
    (of_points.into_iter().flatten().collect(), ambiguous)
}

/// Returns the dependences of a point inside (m) at this distance (m) from the surface, one per closest place.
fn of_point(
    surface: &SurfaceDistance,
    index: usize,
    point: &Vector3<f64>,
    distance: f64,
) -> Vec<Dependence> {
    let mut near = surface.feet(point, distance + EQUAL * surface.size());
    near.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
    // Parts of the triangles seen so far. A closest point in a part of a closer triangle is a duplicate.
    let mut seen = FxHashSet::default();
    near.retain(|(_, facet, foot)| {
        let is_new = !seen.contains(&sorted(part_below(facet, foot)));
        seen.extend(parts(facet));
        is_new
    });
    let count = near.len() as f64;
    let dependence = |(_, facet, foot): (f64, &SurfaceTriangle, Foot)| Dependence {
        point: index,
        corners: facet.vertices,
        shares: foot.shares,
        direction: foot.direction / count,
    };
    near.into_iter().map(dependence).collect()
}

/// A corner, an edge or the whole of a triangle: its vertices, padded with `None`.
type Part = [Option<usize>; 3];

fn sorted(mut part: Part) -> Part {
    part.sort_unstable();
    part
}

/// Returns the lowest-dimensional part of the triangle that contains its closest point.
fn part_below(facet: &SurfaceTriangle, foot: &Foot) -> Part {
    std::array::from_fn(|corner| (foot.shares[corner] > 0.0).then_some(facet.vertices[corner]))
}

/// Returns all corners and edges of the triangle, and the triangle itself.
fn parts(facet: &SurfaceTriangle) -> impl Iterator<Item = Part> {
    let part = |bits: usize| {
        std::array::from_fn(|corner| (bits >> corner & 1 == 1).then_some(facet.vertices[corner]))
    };
    (1..8).map(move |bits| sorted(part(bits)))
}
