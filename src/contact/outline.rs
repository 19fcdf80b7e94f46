use crate::friction::{Affine, Quadratic, ends};
use crate::geometry::{PER_TRIANGLE, POLYGON_CAPACITY, add_triangle, snapped};
use crate::scalar::{Scalar, lift, real_part};

/// Capacity for the corners of a contact polygon after one more cut.
pub(super) const PLANE_CAPACITY: usize = POLYGON_CAPACITY + 1;

/// The corners of a polygon in a plane, counter-clockwise.
#[derive(Clone, Copy)]
pub(super) struct Outline<T> {
    corners: [[T; 2]; PLANE_CAPACITY],
    /// For the edge from each corner to the next, the edge of the contact polygon that contains it, or [`NO_EDGE`] for a cut.
    edges: [u8; PLANE_CAPACITY],
    len: usize,
}

/// Marks an edge that is not a part of an edge of the contact polygon.
pub(super) const NO_EDGE: u8 = u8::MAX;

impl<T: Scalar> Outline<T> {
    pub fn empty() -> Self {
        Self {
            corners: [[lift(0.0); 2]; PLANE_CAPACITY],
            edges: [NO_EDGE; PLANE_CAPACITY],
            len: 0,
        }
    }

    /// Adds a corner. If the outline is full, the corner is dropped, because it is a copy of another corner up to round-off (see
    /// [`ConvexPolygon`](crate::geometry::ConvexPolygon)).
    pub fn push(&mut self, corner: [T; 2], edge: u8) {
        if self.len < PLANE_CAPACITY {
            self.corners[self.len] = corner;
            self.edges[self.len] = edge;
            self.len += 1;
        }
    }

    pub fn corners(&self) -> &[[T; 2]] {
        &self.corners[..self.len]
    }

    /// Returns, for the edge from each corner to the next, the edge of the contact polygon that contains it, or [`NO_EDGE`].
    pub fn edges(&self) -> &[u8] {
        &self.edges[..self.len]
    }

    /// Returns the outline with each edge numbered by its index. Parts that are cut from the result refer to these edges.
    pub fn renumbered(&self) -> Self {
        let mut outline = *self;
        for (number, edge) in (0..).zip(&mut outline.edges) {
            *edge = number;
        }
        outline
    }

    /// Returns the part where an affine function is not negative, or `None` if this is the whole outline.
    pub fn cut(&self, function: &Affine<T>) -> Option<Self> {
        let is_in = |y: &[T; 2]| real_part(at(function, y)) >= 0.0;
        if self.corners().iter().all(is_in) {
            return None;
        }
        let values = self.corners.map(|y| at(function, &y));
        let is_inside = |corner: usize| real_part(values[corner]) >= 0.0;
        let mut part = Self::empty();
        let mut before = self.len - 1;
        for now in 0..self.len {
            if is_inside(before) != is_inside(now) {
                let crossing = self.crossing([before, now], &values);
                let enters = is_inside(now);
                part.push(crossing, if enters { self.edges[before] } else { NO_EDGE });
            }
            if is_inside(now) {
                part.push(self.corners[now], self.edges[now]);
            }
            before = now;
        }
        Some(part)
    }

    /// Returns the parts where an affine function is not positive, and where it is not negative. Values of magnitude `zero` or less count
    /// as zero. Both parts have the same crossings.
    pub fn split(&self, function: &Affine<T>, zero: f64) -> [Self; 2] {
        let mut parts = [Self::empty(); 2];
        let values = self.corners.map(|y| snapped(at(function, &y), zero));
        let mut before = self.len.saturating_sub(1);
        for now in 0..self.len {
            let [was, is] = [before, now].map(|corner| real_part(values[corner]));
            if was * is < 0.0 {
                let crossing = self.crossing([before, now], &values);
                let edges = if is > 0.0 {
                    [NO_EDGE, self.edges[before]]
                } else {
                    [self.edges[before], NO_EDGE]
                };
                parts
                    .iter_mut()
                    .zip(edges)
                    .for_each(|(part, edge)| part.push(crossing, edge));
            }
            let next = real_part(values[if now + 1 < self.len { now + 1 } else { 0 }]);
            for (part, sign) in parts.iter_mut().zip([-1.0, 1.0]) {
                if sign * is >= 0.0 {
                    // The edge after a corner on the line may be in the other part.
                    let is_in_part = sign * next >= 0.0 || is * sign > 0.0;
                    let edge = if is_in_part { self.edges[now] } else { NO_EDGE };
                    part.push(self.corners[now], edge);
                }
            }
            before = now;
        }
        parts
    }

    /// Returns the zero of an affine function between two corners, from its values at all corners.
    fn crossing(&self, [before, now]: [usize; 2], values: &[T; PLANE_CAPACITY]) -> [T; 2] {
        let share = values[before] / (values[before] - values[now]);
        let [from, to] = [self.corners[before], self.corners[now]];
        [0, 1].map(|i| from[i] + (to[i] - from[i]) * share)
    }

    /// Returns ∫ m dA for the first K of the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂², y₁³, y₁²y₂, y₁y₂², y₂³. K is 6 or 10. The area is
    /// positive if the outline turns counter-clockwise.
    pub fn moments<const K: usize>(&self) -> [T; K] {
        let mut moments = [lift::<T>(0.0); K];
        let corners = self.corners();
        for edge in 0..corners.len() {
            let [a, b] = ends(corners, edge);
            add_triangle(&mut moments, a, b, [lift(0.5), lift(1.0 / 3.0)]);
        }
        for (moment, factor) in moments.iter_mut().zip(PER_TRIANGLE) {
            *moment *= factor;
        }
        moments
    }
}

#[cfg(test)]
impl Outline<f64> {
    /// Returns the outline as a constant: all derivatives are zero.
    pub fn lifted<T: Scalar>(&self) -> Outline<T> {
        Outline {
            corners: self.corners.map(|corner| corner.map(lift)),
            edges: self.edges,
            len: self.len,
        }
    }
}

/// Indices of m times the first six monomials, for m = 1, y₁ and y₂.
const BY_QUADRATIC: [[usize; 6]; 3] = [[0, 1, 2, 3, 4, 5], [1, 3, 4, 6, 7, 8], [2, 4, 5, 7, 8, 9]];

/// Returns ∫ f m for a quadratic f and m = 1, y₁ and y₂.
#[inline]
pub(super) fn quadratic_moments<T: Scalar>(f: &Quadratic<T>, moments: &[T; 10]) -> [T; 3] {
    BY_QUADRATIC.map(|indices| {
        let term = |k: usize| f[k] * moments[indices[k]];
        (term(0) + term(1)) + (term(2) + term(3)) + (term(4) + term(5))
    })
}

/// Returns the value of an affine function at a point.
pub(super) fn at<T: Scalar>(function: &Affine<T>, y: &[T; 2]) -> T {
    function[0] + function[1] * y[0] + function[2] * y[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round-off may bend an outline so that a line cuts it many times.
    #[test]
    fn an_outline_that_is_cut_into_more_corners_than_it_has_room_for_drops_some() {
        let mut zigzag = Outline::<f64>::empty();
        for edge in 0..12 {
            let aside = if edge % 2 == 0 { 1.0 } else { -1.0 };
            zigzag.push([f64::from(edge), aside], edge);
        }
        let part = zigzag.cut(&[0.0, 0.0, 1.0]).unwrap();
        // Each of 12 edges is cut, and 6 corners are inside.
        assert_eq!(part.corners().len(), PLANE_CAPACITY);
        assert_eq!(part.edges().len(), PLANE_CAPACITY);
        assert!(part.corners().iter().all(|[_, y2]| *y2 >= 0.0));
    }
}
