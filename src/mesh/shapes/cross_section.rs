use super::outline::triangulated;
use super::staircase::prism;
use crate::mesh::MeshError;
use nalgebra::Vector2;
use rustc_hash::{FxHashMap, FxHashSet};

/// Largest number of points of a cross-section.
const MOST_POINTS: usize = 100_000;
/// Largest number of tetrahedra of a swept cross-section.
const MOST_TETS: usize = 2_000_000;
/// An edge is divided if it is longer than the resolution by this factor, so that rounding error does not decide.
const LONGER: f64 = 1.001;
/// Ratio of successive limits of the lengths of edges.
const RATIO: f64 = 0.75;
/// An edge is flipped if the sum of the opposite angles exceeds π by about this (rad), so that rounding error does not decide.
const OBTUSE: f64 = 1e-6;

/// Triangles inside an outline, with inner points. No inner edge joins two points of the boundary, so that a field that is 0 on the
/// boundary is positive inside.
///
/// The triangulation is constrained Delaunay, refined at the midpoints of long edges. Finally the inner edges between
/// two boundary points are divided. In a wall thinner than the resolution, their midpoints lie halfway between both sides, where the
/// distance is largest.
pub(super) struct CrossSection {
    /// All points (m), the points of the outline first.
    pub points: Vec<Vector2<f64>>,
    /// Triangles, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    is_boundary: Vec<bool>,
    /// The two points whose midpoint is each further point, in order.
    parents: Vec<[usize; 2]>,
    resolution: f64,
}

impl CrossSection {
    /// Triangulates a simple polygon with edges of about the resolution (m) at most. `is_open` removes the edge from the last point to the
    /// first from the boundary.
    ///
    /// # Errors
    /// Returns an error if the outline is not a simple polygon, or if the resolution is not positive or takes too many points.
    pub fn new(outline: &[[f64; 2]], is_open: bool, resolution: f64) -> Result<Self, MeshError> {
        super::checked_lengths([("resolution", resolution)])?;
        let points: Vec<Vector2<f64>> = outline.iter().map(|&point| point.into()).collect();
        let triangles = triangulated(&points)?;
        let count = points.len();
        let boundary_count = if is_open { count - 1 } else { count };
        let boundary = (0..boundary_count).map(|first| sorted([first, (first + 1) % count]));
        let mut refinement = Refinement {
            boundary: boundary.collect(),
            is_boundary: vec![true; count],
            parents: Vec::new(),
            triangles: FxHashMap::default(),
            points,
        };
        for triangle in triangles {
            refinement.add(triangle);
        }
        refinement.legalize_all();
        refinement.refine(resolution)?;
        refinement.divide_chords();
        Ok(refinement.done(resolution))
    }

    /// Extends positions or velocities of the outline to all points.
    pub fn extended(&self, outline: &[Vector2<f64>]) -> Vec<Vector2<f64>> {
        let mut all = outline.to_vec();
        for &[a, b] in &self.parents {
            all.push((all[a] + all[b]) / 2.0);
        }
        all
    }

    /// Returns the tetrahedra of `count` layers between `count` + 1 images of the cross-section in planes. `vertex(point, plane)` is the
    /// index of a vertex. Every tetrahedron of a layer has an inner point in the plane `layer + inner_side(layer)`, where `inner_side`
    /// returns 0 or 1.
    ///
    /// # Errors
    /// Returns an error if there are too many tetrahedra.
    pub fn swept(
        &self,
        count: usize,
        vertex: impl Fn(usize, usize) -> usize,
        inner_side: impl Fn(usize) -> usize,
    ) -> Result<Vec<[usize; 4]>, MeshError> {
        let tet_count = self.triangles.len().saturating_mul(3 * count);
        if tet_count > MOST_TETS {
            // The number of triangles grows with the inverse square of the resolution.
            let excess = (tet_count as f64 / MOST_TETS as f64).sqrt();
            return Err(MeshError::FineResolution {
                value: self.resolution,
                suggested: self.resolution * excess / RATIO,
            });
        }
        let mut tets = Vec::with_capacity(tet_count);
        for triangle in &self.triangles {
            // Inner points are last, so that all tetrahedra of a prism contain the last point of the upper side.
            let mut corners = *triangle;
            corners.sort_unstable_by_key(|&point| (!self.is_boundary[point], point));
            for layer in 0..count {
                let upper = inner_side(layer);
                let [low, high] =
                    [1 - upper, upper].map(|side| corners.map(|point| vertex(point, layer + side)));
                tets.extend(prism(low, high));
            }
        }
        Ok(tets)
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// A triangulation that is being refined.
struct Refinement {
    points: Vec<Vector2<f64>>,
    is_boundary: Vec<bool>,
    parents: Vec<[usize; 2]>,
    /// Edges of the boundary, sorted.
    boundary: FxHashSet<[usize; 2]>,
    /// The third corner of the triangle to the left of each directed edge.
    triangles: FxHashMap<[usize; 2], usize>,
}

impl Refinement {
    fn add(&mut self, [a, b, c]: [usize; 3]) {
        for (edge, opposite) in [([a, b], c), ([b, c], a), ([c, a], b)] {
            self.triangles.insert(edge, opposite);
        }
    }

    fn remove(&mut self, [a, b, c]: [usize; 3]) {
        for edge in [[a, b], [b, c], [c, a]] {
            self.triangles.remove(&edge);
        }
    }

    /// All edges, each once and sorted, in ascending order.
    fn edges(&self) -> Vec<[usize; 2]> {
        let mut edges: Vec<_> = self.triangles.keys().map(|&edge| sorted(edge)).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    fn length(&self, [a, b]: [usize; 2]) -> f64 {
        (self.points[b] - self.points[a]).norm()
    }

    /// The third corners of the triangles on both sides of an edge.
    fn opposite(&self, [a, b]: [usize; 2]) -> [Option<usize>; 2] {
        [[a, b], [b, a]].map(|edge| self.triangles.get(&edge).copied())
    }

    fn legalize_all(&mut self) {
        let edges = self.edges();
        self.legalize(edges);
    }

    /// Flips the given edges, and edges beside flipped ones, until all are locally Delaunay (Lawson's algorithm).
    fn legalize(&mut self, mut stack: Vec<[usize; 2]>) {
        while let Some(edge @ [a, b]) = stack.pop() {
            let [Some(c), Some(d)] = self.opposite(edge) else {
                continue;
            };
            if !self.is_obtuse(edge, [c, d]) {
                continue;
            }
            self.remove([a, b, c]);
            self.remove([b, a, d]);
            self.add([a, d, c]);
            self.add([d, b, c]);
            stack.extend([[a, d], [d, b], [b, c], [c, a]]);
        }
    }

    /// Returns true if the sum of the angles opposite to an edge exceeds π: its sine is negative.
    fn is_obtuse(&self, edge: [usize; 2], opposite: [usize; 2]) -> bool {
        let [[sine_c, cosine_c], [sine_d, cosine_d]] = opposite.map(|at| {
            let [to_a, to_b] = edge.map(|end| (self.points[end] - self.points[at]).normalize());
            [to_a.perp(&to_b).abs(), to_a.dot(&to_b)]
        });
        sine_c * cosine_d + cosine_c * sine_d < -OBTUSE
    }

    /// Divides edges longer than the resolution (m), the longest ones first. If the ratio of two resolutions is a power of [`RATIO`], the
    /// sequence of limits for the larger resolution is the start of the sequence for the smaller resolution.
    fn refine(&mut self, resolution: f64) -> Result<(), MeshError> {
        let lengths = self.edges().into_iter().map(|edge| self.length(edge));
        let longest = lengths.fold(0.0, f64::max);
        // Below this length, the divided longest edge alone would have too many points.
        let finest = resolution.max(longest / MOST_POINTS as f64);
        let limits = std::iter::successors(Some(finest), |limit| Some(limit / RATIO));
        let limits: Vec<_> = limits.take_while(|&limit| limit < longest).collect();
        for limit in limits.into_iter().rev() {
            if !self.divide_longer_than(LONGER * limit) {
                return Err(MeshError::FineResolution {
                    value: resolution,
                    suggested: limit / RATIO,
                });
            }
        }
        // A single triangle has no inner edge.
        while self.triangles.len() <= 3 {
            let edge = self.edges()[0];
            self.divide(edge);
        }
        Ok(())
    }

    /// Divides edges longer than a limit (m). Returns false if there are more than [`MOST_POINTS`] points.
    fn divide_longer_than(&mut self, limit: f64) -> bool {
        loop {
            let mut long = self.edges();
            long.retain(|&edge| self.length(edge) > limit);
            if long.is_empty() {
                return true;
            }
            for edge in long {
                if self.opposite(edge) == [None, None] {
                    continue;
                }
                let around = self.divide(edge);
                self.legalize(around);
                if self.points.len() > MOST_POINTS {
                    return false;
                }
            }
        }
    }

    /// Divides inner edges between boundary points.
    fn divide_chords(&mut self) {
        let mut chords = self.edges();
        chords.retain(|edge| {
            edge.iter().all(|&point| self.is_boundary[point]) && !self.boundary.contains(edge)
        });
        for chord in chords {
            self.divide(chord);
        }
    }

    /// Divides an edge at its midpoint, and returns the edges opposite to the midpoint.
    fn divide(&mut self, edge @ [a, b]: [usize; 2]) -> Vec<[usize; 2]> {
        let middle = self.points.len();
        self.points.push((self.points[a] + self.points[b]) / 2.0);
        self.parents.push(edge);
        let is_boundary = self.boundary.remove(&sorted(edge));
        self.is_boundary.push(is_boundary);
        if is_boundary {
            self.boundary
                .extend([sorted([a, middle]), sorted([middle, b])]);
        }
        let mut around = Vec::new();
        for [from, to] in [[a, b], [b, a]] {
            if let Some(apex) = self.triangles.get(&[from, to]).copied() {
                self.remove([from, to, apex]);
                self.add([from, middle, apex]);
                self.add([middle, to, apex]);
                around.extend([[to, apex], [apex, from]]);
            }
        }
        around
    }

    fn done(self, resolution: f64) -> CrossSection {
        let triangles = self.triangles.iter().map(|(&[a, b], &c)| [a, b, c]);
        let mut triangles: Vec<_> = triangles.filter(|[a, b, c]| a < b && a < c).collect();
        triangles.sort_unstable();
        CrossSection {
            points: self.points,
            triangles,
            is_boundary: self.is_boundary,
            parents: self.parents,
            resolution,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::CrossSection;
    use crate::mesh::MeshError;

    #[test]
    fn the_suggested_resolution_works() {
        let outline = [[0.0, 0.0], [1.0, 0.0], [0.9, 1.1], [0.3, 0.7]];
        for resolution in [5e-324, 1e-7, 0.0015] {
            let section = CrossSection::new(&outline, false, resolution);
            let Err(MeshError::FineResolution { value, suggested }) = section.map(|_| ()) else {
                panic!("{resolution} is not too fine");
            };
            assert!(value < suggested && suggested < 0.01, "{suggested}");
            assert!(CrossSection::new(&outline, false, suggested).is_ok());
        }
        let swept = |resolution: f64, count: usize| {
            let section = CrossSection::new(&outline, false, resolution).unwrap();
            section.swept(count, |_, _| 0, |_| 0).map(|_| ())
        };
        for count in [600, 4000] {
            let Err(MeshError::FineResolution { suggested, .. }) = swept(0.02, count) else {
                panic!("{count} layers are not too many");
            };
            assert!(suggested < 0.2, "{suggested}");
            assert_eq!(swept(suggested, count), Ok(()));
        }
    }
}
