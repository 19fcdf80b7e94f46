use super::{Aabb, AffineField, ConvexPolygon};
use crate::scalar::{Scalar, lift, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Corners of the face opposite to each corner, counter-clockwise as seen from outside.
pub(crate) const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The set of all four faces, one bit each.
pub(crate) const ALL_FACES: u8 = 0b1111;

/// Edges of a tetrahedron, as pairs of corners.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Edges in which a plane cuts a tetrahedron, indexed by the set of corners below the plane (bit i
/// for corner i). Each edge is (corner below, corner above). The cuts are counter-clockwise about
/// the direction "above".
const CUT_EDGES: [&[(usize, usize)]; 16] = [
    &[],
    &[(0, 1), (0, 2), (0, 3)],
    &[(1, 0), (1, 3), (1, 2)],
    &[(0, 2), (0, 3), (1, 3), (1, 2)],
    &[(2, 0), (2, 1), (2, 3)],
    &[(0, 3), (0, 1), (2, 1), (2, 3)],
    &[(1, 0), (1, 3), (2, 3), (2, 0)],
    &[(0, 3), (1, 3), (2, 3)],
    &[(3, 0), (3, 2), (3, 1)],
    &[(0, 1), (0, 2), (3, 2), (3, 1)],
    &[(1, 2), (1, 0), (3, 0), (3, 2)],
    &[(0, 2), (3, 2), (1, 2)],
    &[(2, 0), (2, 1), (3, 1), (3, 0)],
    &[(0, 1), (2, 1), (3, 1)],
    &[(1, 0), (3, 0), (2, 0)],
    &[],
];

/// A tetrahedron with its corners (m). It is positively oriented if corners 0, 1, 2 are
/// counter-clockwise as seen from corner 3: det(v₁−v₀, v₂−v₀, v₃−v₀) > 0.
#[derive(Debug, Clone, Copy)]
pub struct Tetrahedron<T = f64> {
    /// The corners (m).
    pub corners: [Vector3<T>; 4],
}

impl<T: Scalar> Tetrahedron<T> {
    /// Returns the volume (m³), negative for a negatively oriented tetrahedron.
    #[must_use]
    pub fn signed_volume(&self) -> T {
        let [o, a, b, c] = &self.corners;
        (a - o).dot(&(b - o).cross(&(c - o))) / 6.0
    }

    /// Returns the tetrahedron without its derivatives.
    #[must_use]
    pub fn real(&self) -> Tetrahedron<f64> {
        Tetrahedron {
            corners: self.corners.each_ref().map(real_vector),
        }
    }

    /// Returns the part of the tetrahedron where the field with the given corner values is ≥ 0. The
    /// part consists of zero, one or three tetrahedra with the orientation of this one. Corners at
    /// zero count as inside.
    #[must_use]
    #[expect(
        clippy::many_single_char_names,
        reason = "the corner names of a tetrahedron"
    )]
    pub fn clipped(&self, values: &[T; 4]) -> ClippedTetrahedra<T> {
        let cut = |i: usize, j: usize| {
            let t = values[i] / (values[i] - values[j]);
            self.corners[i] + (self.corners[j] - self.corners[i]) * t
        };
        let corner = |i: usize| self.corners[i];
        let edges = CUT_EDGES[below_mask(&values.map(real_part))];
        let mut parts = ClippedTetrahedra::empty();
        match *edges {
            [] if real_part(values[0]) >= 0.0 => parts.push(self.corners),
            // Three edges are cut. Either the corner below is their common end, or the corner
            // above.
            [(i, a), (_, b), (k, c)] if i == k => {
                let near = [cut(i, a), cut(i, b), cut(i, c)];
                parts.push_prism(near, [corner(a), corner(b), corner(c)]);
            }
            [(a, i), (b, _), (c, _)] => {
                parts.push([cut(a, i), cut(b, i), cut(c, i), corner(i)]);
            }
            [(i, k), (_, l), (j, _), _] => {
                let near = [corner(k), cut(i, k), cut(j, k)];
                parts.push_prism(near, [corner(l), cut(i, l), cut(j, l)]);
            }
            _ => {}
        }
        parts
    }
}

impl Tetrahedron<f64> {
    /// Returns the centroid (m).
    pub(crate) fn centroid(&self) -> Vector3<f64> {
        self.corners.iter().sum::<Vector3<f64>>() / 4.0
    }

    /// Returns the length of the longest edge (m).
    pub(crate) fn longest_edge(&self) -> f64 {
        let length = |[i, j]: [usize; 2]| (self.corners[i] - self.corners[j]).norm();
        EDGES.map(length).into_iter().fold(0.0, f64::max)
    }

    /// Returns the smallest box around the tetrahedron.
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.corners)
    }

    /// Transforms the tetrahedron to the outer frame.
    #[must_use]
    pub fn posed(&self, pose: &Pose<f64>) -> Self {
        let corners = self.corners.each_ref();
        Self {
            corners: corners.map(|corner| pose.transformed_point(corner)),
        }
    }

    /// Returns the barycentric coordinates λᵢ(q) = gᵢ·q + cᵢ. Coordinate i is 1 at corner i and 0
    /// on the opposite face. The coordinates are not finite if the volume is zero.
    #[must_use]
    pub fn barycentric_fields(&self) -> [AffineField; 4] {
        let six_volumes = 6.0 * self.signed_volume();
        FACES.map(|[a, b, c]| {
            let [a, b, c] = [self.corners[a], self.corners[b], self.corners[c]];
            // The cross product of a face points outwards, so the inward gradient is its negative.
            let gradient = -(b - a).cross(&(c - a)) / six_volumes;
            let offset = -gradient.dot(&a);
            AffineField { gradient, offset }
        })
    }

    /// Returns the polygon in which the zero plane of a field cuts the tetrahedron. The field is
    /// given by its corner values. The polygon is counter-clockwise about the gradient of the
    /// field.
    ///
    /// Corners at zero count as above. So corners of the polygon may be duplicated. A tetrahedron
    /// that only touches the plane from above gives an empty polygon. Bit i of the owners of an
    /// edge stands for the face opposite to corner i.
    #[must_use]
    pub fn sliced<T: Scalar>(&self, values: &[T; 4]) -> ConvexPolygon<T> {
        self.sliced_below(below_mask(&values.map(real_part)), values)
    }

    /// Computes [`Self::sliced`] for a given set of corners below (bit i for corner i). The values
    /// of these corners must be ≤ 0. The other corners count as above.
    #[inline]
    pub(crate) fn sliced_below<T: Scalar>(
        &self,
        below: usize,
        values: &[T; 4],
    ) -> ConvexPolygon<T> {
        let mut polygon = ConvexPolygon::empty();
        let zero: u8 = (0..4)
            .map(|i| u8::from(real_part(values[i]) == 0.0) << i)
            .sum();
        // An edge of the tetrahedron that lies in the plane belongs to both of its faces.
        let edge = if zero.count_ones() == 2 { zero } else { 0 };
        for (&(i, j), &face) in CUT_EDGES[below].iter().zip(&SLICE_OWNERS[below]) {
            let t = values[i] / (values[i] - values[j]);
            let (from, along) = (self.corners[i], self.corners[j] - self.corners[i]);
            let corner = Vector3::from_fn(|k, _| t * along[k] + lift::<T>(from[k]));
            polygon.push(corner, face);
        }
        if edge != 0 {
            polygon.add_owners(edge_of_slice(CUT_EDGES[below], edge), ALL_FACES & !edge);
        }
        polygon
    }
}

/// Next face along the outline of a slice, indexed by the set of corners below (see [`CUT_EDGES`])
/// and by a face. The outline is counter-clockwise about the direction "above". Faces that do not
/// contribute an edge have 0.
pub(crate) const NEXT_FACES: [[usize; 4]; 16] = {
    let mut next = [[0; 4]; 16];
    let mut below = 0;
    while below < 16 {
        let len = CUT_EDGES[below].len();
        let mut cut = 0;
        while cut < len {
            let (face, beyond) = (
                SLICE_OWNERS[below][cut],
                SLICE_OWNERS[below][(cut + 1) % len],
            );
            next[below][face.trailing_zeros() as usize] = beyond.trailing_zeros() as usize;
            cut += 1;
        }
        below += 1;
    }
    next
};

/// Returns one face that contributes an edge to the slice by a plane with these corners below it.
/// Returns 0 if there is no slice.
pub(crate) fn face_of_slice(below: usize) -> usize {
    // Without a slice, the owner is 0, which has 8 trailing zeros.
    SLICE_OWNERS[below][0].trailing_zeros() as usize % 4
}

/// Returns the first edge of a slice that coincides with an edge of the tetrahedron. The edge is
/// given by its two corners, one bit each.
#[cold]
fn edge_of_slice(cuts: &[(usize, usize)], corners: u8) -> usize {
    let end = |cut: usize| {
        let (i, j) = cuts[cut % cuts.len()];
        corners & (1 << i | 1 << j)
    };
    let joins = |cut: &usize| end(*cut) != 0 && end(*cut) ^ end(cut + 1) == corners;
    (0..cuts.len()).find(joins).unwrap_or(0)
}

/// Face (one bit) that contains the edge from each cut to the next cut of a slice. It is opposite
/// to the only corner that is not an end of the two cut edges.
const SLICE_OWNERS: [[u8; 4]; 16] = {
    let mut owners = [[0; 4]; 16];
    let mut below = 0;
    while below < 16 {
        let cuts = CUT_EDGES[below];
        let mut cut = 0;
        while cut < cuts.len() {
            let ((i, j), (k, l)) = (cuts[cut], cuts[(cut + 1) % cuts.len()]);
            owners[below][cut] = ALL_FACES & !(1 << i | 1 << j | 1 << k | 1 << l);
            cut += 1;
        }
        below += 1;
    }
    owners
};

/// Returns the set of corners with values below zero: bit i for value i.
fn below_mask(values: &[f64; 4]) -> usize {
    (0..4).map(|i| usize::from(values[i] < 0.0) << i).sum()
}

/// Up to three tetrahedra, stored without heap allocation.
#[derive(Debug, Clone, Copy)]
pub struct ClippedTetrahedra<T> {
    parts: [Tetrahedron<T>; 3],
    len: usize,
}

impl<T: Scalar> ClippedTetrahedra<T> {
    fn empty() -> Self {
        let origin = Vector3::from_element(lift(0.0));
        Self {
            parts: [Tetrahedron {
                corners: [origin; 4],
            }; 3],
            len: 0,
        }
    }

    /// Returns the tetrahedra.
    #[must_use]
    pub fn as_slice(&self) -> &[Tetrahedron<T>] {
        &self.parts[..self.len]
    }

    fn push(&mut self, corners: [Vector3<T>; 4]) {
        self.parts[self.len] = Tetrahedron { corners };
        self.len += 1;
    }

    /// Appends the prism between two triangles as three tetrahedra. The edges of the prism join
    /// corners of the same index. The tetrahedra are positively oriented if `p` is
    /// counter-clockwise as seen from `q`.
    fn push_prism(&mut self, [p0, p1, p2]: [Vector3<T>; 3], [q0, q1, q2]: [Vector3<T>; 3]) {
        self.push([p0, p1, p2, q2]);
        self.push([p0, p1, q2, q1]);
        self.push([p0, q1, q2, q0]);
    }
}
