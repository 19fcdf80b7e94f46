use super::{Aabb, AffineField, ConvexPolygon};
use crate::scalar::{Scalar, lift, real_part, real_vector};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// The corners of the face opposite to each corner, counter-clockwise seen from outside.
pub(crate) const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// The set of all four faces, one bit each.
pub(crate) const ALL_FACES: u8 = 0b1111;

/// The edges of a tetrahedron, by its corners.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The edges in which a plane cuts a tetrahedron, by the set of its corners below the plane (bit i
/// for corner i), in an order that turns counter-clockwise about the direction "above".
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

/// A tetrahedron by its corners (m). Positively oriented where corner 3 sees corners 0, 1, 2
/// clockwise: det(v₁−v₀, v₂−v₀, v₃−v₀) > 0.
#[derive(Debug, Clone, Copy)]
pub struct Tetrahedron<T = f64> {
    /// The corners (m).
    pub corners: [Vector3<T>; 4],
}

impl<T: Scalar> Tetrahedron<T> {
    /// Volume (m³), negative for a negatively oriented tetrahedron.
    #[must_use]
    pub fn signed_volume(&self) -> T {
        let [o, a, b, c] = &self.corners;
        (a - o).dot(&(b - o).cross(&(c - o))) / 6.0
    }

    /// The tetrahedron without its derivatives.
    #[must_use]
    pub fn real(&self) -> Tetrahedron<f64> {
        Tetrahedron {
            corners: self.corners.each_ref().map(real_vector),
        }
    }

    /// Tetrahedra, oriented alike, that make up the part of this one where the field with the
    /// given corner values is ≥ 0: none, one or three. Corners at zero count as inside.
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
            // One corner inside, or three: told apart by which ends the edges share.
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
    /// The smallest box around the tetrahedron.
    #[must_use]
    pub fn aabb(&self) -> Aabb {
        Aabb::around(&self.corners)
    }

    /// The tetrahedron in the outer frame.
    #[must_use]
    pub fn posed(&self, pose: &Pose<f64>) -> Self {
        let corners = self.corners.each_ref();
        Self {
            corners: corners.map(|corner| pose.transformed_point(corner)),
        }
    }

    /// The barycentric coordinates λᵢ(q) = gᵢ·q + cᵢ: 1 at corner i, 0 on the face opposite.
    /// Not finite where the volume is zero.
    #[must_use]
    pub fn barycentric_fields(&self) -> [AffineField; 4] {
        let six_volumes = 6.0 * self.signed_volume();
        FACES.map(|[a, b, c]| {
            let [a, b, c] = [self.corners[a], self.corners[b], self.corners[c]];
            // FACES turn outwards, so the inward gradient is minus the face's cross product.
            let gradient = -(b - a).cross(&(c - a)) / six_volumes;
            let offset = -gradient.dot(&a);
            AffineField { gradient, offset }
        })
    }

    /// The polygon in which the zero plane of a field with the given corner values cuts the
    /// tetrahedron, counter-clockwise about the field's gradient. Corners at zero count as above,
    /// so corners may come out doubled, and a tetrahedron that only touches the plane from above
    /// gives nothing. Bit i of an edge's owners stands for the face opposite to corner i.
    #[must_use]
    pub fn sliced<T: Scalar>(&self, values: &[T; 4]) -> ConvexPolygon<T> {
        self.sliced_below(below_mask(&values.map(real_part)), values)
    }

    /// [`Self::sliced`] with these corners (bit i for corner i) below, which must not be above, and the others above.
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
        // An edge of the tetrahedron in the plane belongs to both its faces.
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

/// By the set of corners below, as in [`CUT_EDGES`]: for each face that a slice's outline passes, the face in which it goes on,
/// counter-clockwise about the direction "above". Of other faces 0.
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

/// One of the faces that the outline passes of a slice with these corners below; 0 if there is no slice.
pub(crate) fn face_of_slice(below: usize) -> usize {
    // Where no face owns an edge, there are as many trailing zeros as bits.
    SLICE_OWNERS[below][0].trailing_zeros() as usize % 4
}

/// The first edge of a slice that is the edge between these two corners of the tetrahedron.
#[cold]
fn edge_of_slice(cuts: &[(usize, usize)], corners: u8) -> usize {
    let end = |cut: usize| {
        let (i, j) = cuts[cut % cuts.len()];
        corners & (1 << i | 1 << j)
    };
    let joins = |cut: &usize| end(*cut) != 0 && end(*cut) ^ end(cut + 1) == corners;
    (0..cuts.len()).find(joins).unwrap_or(0)
}

/// For each slice the face (its bit) in which it goes on from each cut edge to the next: the one opposite to the
/// corner that neither joins.
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

/// Bit i is set where value i is below zero.
fn below_mask(values: &[f64; 4]) -> usize {
    (0..4).map(|i| usize::from(values[i] < 0.0) << i).sum()
}

/// Up to three tetrahedra on the stack.
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

    /// The tetrahedra.
    #[must_use]
    pub fn as_slice(&self) -> &[Tetrahedron<T>] {
        &self.parts[..self.len]
    }

    fn push(&mut self, corners: [Vector3<T>; 4]) {
        self.parts[self.len] = Tetrahedron { corners };
        self.len += 1;
    }

    /// The prism between two triangles, its edges joining equal places, where `p` turns
    /// counter-clockwise seen from `q`: three positively oriented tetrahedra.
    fn push_prism(&mut self, [p0, p1, p2]: [Vector3<T>; 3], [q0, q1, q2]: [Vector3<T>; 3]) {
        self.push([p0, p1, p2, q2]);
        self.push([p0, p1, q2, q1]);
        self.push([p0, q1, q2, q0]);
    }
}
