//! Refinement of a mesh until the interpolated distance to its surface is close to the exact one.

use super::distance::{self, MadeOfDistances};
use super::splitting::{self, Center, Division};
use super::surface_distance::SurfaceDistance;
use super::{MeshError, TetMesh};
use crate::geometry::EDGES;
use crate::parallel;
use nalgebra::Vector3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Largest number of tetrahedra.
const MAX_TETS: usize = 4_000_000;

/// Distance from the middle of an edge of the first places that are compared, and the last one, over its length.
const STEPS: [f64; 2] = [0.15, 0.01];

/// The edges of a tetrahedron with at least this share of its largest error are split.
const PART: f64 = 0.3;

/// Depth that is checked by default, over the largest distance. It is not half, because the midpoints of many edges are that deep.
const DEFAULT_DEPTH: f64 = 0.4;

/// Relative difference below which two errors or lengths count as equal. The first candidate then wins, so that rounding error does not
/// select the split.
const TIE: f64 = 1e-3;

/// Fraction of the total error in the tetrahedra that one pass splits. One half would be ambiguous for symmetric bodies, because their two
/// halves have equal errors.
const SPLIT_SHARE: f64 = 0.499;

/// Error that counts as rounding, over the size of the surface.
const ROUNDING: f64 = 1e-12;

/// The part of a body whose distances are checked, and how exact they must be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Accuracy {
    /// Largest distance from the surface (m), or `None` for two fifths of the largest distance of a vertex.
    pub depth: Option<f64>,
    /// Largest mean error of the interpolated distance, over the mean distance.
    pub tolerance: f64,
}

/// Integrals over a part of a body.
#[derive(Debug, Clone, Copy, Default)]
struct Integrals {
    /// Integral of the error of the interpolated distance in absolute value (m⁴).
    error: f64,
    /// Integral of the distance (m⁴).
    distance: f64,
}

impl Integrals {
    fn sum(parts: impl Iterator<Item = Self>) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            error: sum.error + part.error,
            distance: sum.distance + part.distance,
        })
    }

    /// Returns the mean error over the mean distance, or 0 if there is no distance.
    fn share(&self) -> f64 {
        if self.distance > 0.0 {
            self.error / self.distance
        } else {
            0.0
        }
    }
}

/// Returns the mean difference between the interpolated and the exact distance to the surface over the mean distance. The means are
/// over the points at most `depth` (m) below the surface: the centroids of tetrahedra and the midpoints of their edges, weighted by
/// volume.
pub(super) fn distance_error(mesh: &TetMesh, depth: Option<f64>) -> f64 {
    let surface = SurfaceDistance::of(mesh);
    let distances = distance::distances(mesh, &surface);
    let errors = Errors::new(mesh, &surface, &distances, depth);
    let all: Vec<usize> = (0..mesh.tet_count()).collect();
    Integrals::sum(errors.of(&all).into_iter()).share()
}

/// Splits tetrahedra until the distances are as exact as asked. Returns the mesh and the new vertices, which follow those of the mesh.
///
/// Each pass splits the tetrahedra that have about half of the error, the worst first [Dörfler 1996]. Their edges are split where the error
/// is largest. That is where the distance has a kink, because another triangle becomes the closest one. The distance to flat faces is
/// thereby exact after few passes.
fn refined(
    mut mesh: TetMesh,
    mut centers: Vec<Center>,
    accuracy: Accuracy,
) -> Result<(TetMesh, Vec<Center>), MeshError> {
    let surface = SurfaceDistance::of(&mesh);
    let mut known: FxHashMap<[usize; 4], Integrals> = FxHashMap::default();
    let mut distances = Vec::new();
    loop {
        // Splits leave the other vertices, and the surface, where they are.
        distances.extend(distance::distances_from(distances.len(), &mesh, &surface));
        let errors = Errors::new(&mesh, &surface, &distances, accuracy.depth);
        let tets = mesh.tets();
        let new: Vec<usize> = (0..tets.len())
            .filter(|&tet| !known.contains_key(&tets[tet]))
            .collect();
        let found = errors.of(&new);
        known.extend(new.iter().map(|&tet| tets[tet]).zip(found));
        let of_tets: Vec<Integrals> = tets.iter().map(|tet| known[tet]).collect();
        let all = Integrals::sum(of_tets.iter().copied());
        if all.share() <= accuracy.tolerance {
            return Ok((mesh, centers));
        }
        if tets.len() > MAX_TETS {
            return Err(MeshError::TooLarge {
                count: tets.len(),
                limit: MAX_TETS,
            });
        }
        let mut worst: Vec<usize> = (0..tets.len()).collect();
        worst.sort_by(|&a, &b| of_tets[b].error.total_cmp(&of_tets[a].error));
        let mut left = SPLIT_SHARE * all.error;
        let mut smallest_error = 0.0;
        // Tetrahedra with equal errors are split together.
        let marked = worst.into_iter().take_while(|&tet| {
            let error = of_tets[tet].error;
            if left > 0.0 {
                smallest_error = (1.0 - TIE) * error;
            }
            left -= error;
            error >= smallest_error
        });
        let places = errors.worst_places(marked);
        centers.extend(
            places
                .iter()
                .map(|place| Center::on_edge(place.edge, place.position)),
        );
        let divisions: Vec<_> = places.iter().map(|place| place.division(&mesh)).collect();
        mesh = splitting::divided(&mesh, &divisions)?;
    }
}

/// A place on an edge.
#[derive(Debug, Clone, Copy)]
struct Place {
    edge: [usize; 2],
    /// Position along the edge, from 0 to 1.
    position: f64,
    /// Error of the interpolated distance there (m).
    error: f64,
}

impl Place {
    fn division(&self, mesh: &TetMesh) -> Division<2> {
        let [a, b] = self.edge.map(|vertex| mesh.vertices()[vertex]);
        Division {
            simplex: self.edge,
            at: a.lerp(&b, self.position),
        }
    }
}

/// The errors of the distances that are interpolated in a mesh.
struct Errors<'a> {
    surface: &'a SurfaceDistance,
    mesh: &'a TetMesh,
    /// Distance of each vertex (m).
    distances: &'a [f64],
    /// Largest distance that counts (m).
    depth: f64,
}

impl<'a> Errors<'a> {
    fn new(
        mesh: &'a TetMesh,
        surface: &'a SurfaceDistance,
        distances: &'a [f64],
        depth: Option<f64>,
    ) -> Self {
        let largest = distances.iter().copied().fold(0.0, f64::max);
        Self {
            surface,
            mesh,
            distances,
            depth: depth.unwrap_or(DEFAULT_DEPTH * largest),
        }
    }

    /// Returns the integrals over these tetrahedra.
    fn of(&self, tets: &[usize]) -> Vec<Integrals> {
        let corners = |tet: usize| &self.mesh.tets()[tet];
        let is_shallow = |tet: usize| {
            corners(tet)
                .iter()
                .any(|&vertex| self.distances[vertex] < self.depth)
        };
        let shallow = tets.iter().copied().filter(|&tet| is_shallow(tet));
        let mut edges: Vec<_> = shallow.flat_map(|tet| edges(corners(tet))).collect();
        edges.sort_unstable();
        edges.dedup();
        let at_edges = parallel::map(&edges, |edge| self.at_center(edge));
        let at_edges: FxHashMap<_, _> = edges.into_iter().zip(at_edges).collect();
        parallel::map(tets, |&tet| {
            if !is_shallow(tet) {
                return Integrals::default();
            }
            let places = self::edges(corners(tet))
                .into_iter()
                .map(|edge| at_edges[&edge]);
            let sum = Integrals::sum(places.chain([self.at_center(corners(tet))]));
            let share = self.mesh.tetrahedron(tet).signed_volume() / (EDGES.len() + 1) as f64;
            Integrals {
                error: share * sum.error,
                distance: share * sum.distance,
            }
        })
    }

    /// Returns the worst places of the edges of these tetrahedra that have the largest errors. A tetrahedron whose edges have no
    /// error has its longest edge among them.
    fn worst_places(&self, tets: impl Iterator<Item = usize>) -> Vec<Place> {
        let tets: Vec<_> = tets.map(|tet| edges(&self.mesh.tets()[tet])).collect();
        let mut all = tets.as_flattened().to_vec();
        all.sort_unstable();
        all.dedup();
        let places = parallel::map(&all, |edge| self.worst_place(*edge));
        let places: FxHashMap<_, _> = all.into_iter().zip(places).collect();
        let mut divided = FxHashSet::default();
        for edges in tets {
            let most = edges
                .iter()
                .map(|edge| places[edge].error)
                .fold(0.0, f64::max);
            if most > ROUNDING * self.surface.size() {
                divided.extend(
                    edges
                        .iter()
                        .filter(|edge| places[*edge].error >= PART * most),
                );
            } else {
                divided.insert(self.longest_of(edges));
            }
        }
        let mut worst: Vec<Place> = divided.iter().map(|edge| places[edge]).collect();
        // An order that small changes of the mesh leave as it is.
        worst.sort_unstable_by_key(|place| place.edge);
        worst
    }

    /// Returns the place of an edge at which the interpolated distance is off the most, away from the ends.
    fn worst_place(&self, edge: [usize; 2]) -> Place {
        let [from, to] = edge.map(|vertex| self.mesh.vertices()[vertex]);
        let [at_from, at_to] = edge.map(|vertex| self.distances[vertex]);
        let place = |position: f64| {
            let interpolated = at_from + (at_to - at_from) * position;
            let error = (interpolated - self.surface.to(&from.lerp(&to, position))).abs();
            Place {
                edge,
                position,
                error,
            }
        };
        let (mut worst, [mut step, last]) = (place(0.5), STEPS);
        while step >= last {
            for next in [place(worst.position - step), place(worst.position + step)] {
                // If the distance is exact along the edge, the edge is split in the middle.
                if next.error > (1.0 + TIE) * worst.error + ROUNDING * self.surface.size() {
                    worst = next;
                }
            }
            step /= 2.0;
        }
        worst
    }

    fn longest_of(&self, edges: [[usize; 2]; 6]) -> [usize; 2] {
        let length =
            |[a, b]: [usize; 2]| (self.mesh.vertices()[a] - self.mesh.vertices()[b]).norm();
        let longer = |a: [usize; 2], b: [usize; 2]| {
            if length(b) > (1.0 + TIE) * length(a) {
                b
            } else {
                a
            }
        };
        edges.into_iter().fold(edges[0], longer)
    }

    /// Returns the error and the distance (m) at the center of a simplex, or 0 if the center is too deep.
    fn at_center(&self, simplex: &[usize]) -> Integrals {
        let center: Vector3<f64> = simplex
            .iter()
            .map(|&vertex| self.mesh.vertices()[vertex])
            .sum();
        let interpolated: f64 = simplex.iter().map(|&vertex| self.distances[vertex]).sum();
        let count = simplex.len() as f64;
        let distance = self.surface.to(&(center / count));
        if distance > self.depth {
            return Integrals::default();
        }
        Integrals {
            error: (interpolated / count - distance).abs(),
            distance,
        }
    }
}

fn edges(tet: &[usize; 4]) -> [[usize; 2]; 6] {
    EDGES.map(|[a, b]| [tet[a].min(tet[b]), tet[a].max(tet[b])])
}

/// Returns the data of a field whose distances are as exact as asked.
pub(super) fn normalized_within(
    mesh: &TetMesh,
    accuracy: Accuracy,
) -> Result<MadeOfDistances, MeshError> {
    let tolerance = ("tolerance of the distance", accuracy.tolerance);
    let depth = accuracy.depth.map(|depth| ("depth", depth));
    for (name, value) in std::iter::once(tolerance).chain(depth) {
        if !(value > 0.0 && value.is_finite()) {
            return Err(MeshError::InvalidDimension { name, value });
        }
    }
    let (mesh, centers) = splitting::with_inner_vertices(mesh)?;
    let (mesh, centers) = refined(mesh.into_owned(), centers, accuracy)?;
    distance::normalized_with_deepest(mesh, centers)
}
