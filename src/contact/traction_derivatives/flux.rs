//! The flux of a traction through an edge.

use super::traction::Traction;
use super::wrenches::wrenches;
use crate::contact::outline::{at, up_to_quadratic};
use crate::contact::polygon_fields::Six;

/// Gauss' points and weights for the mean over an edge, from its start: exact to degree five.
pub(in crate::contact::traction_derivatives) const THREE_POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// ψ − 1 where ψ = 0.
const MINUS_ONE: [f64; 3] = [-1.0, 0.0, 0.0];

impl Traction<'_> {
    /// The wrenches of t, y₁t and y₂t, integrated along an edge of the contact polygon.
    pub fn along_edge(&self, edge: usize) -> [Six<f64>; 3] {
        let mut parts = self.pressed.edges().iter();
        let [first, second] = match parts.position(|&of| usize::from(of) == edge) {
            Some(part) => self.slip.flux(part, -self.law.friction),
            None => [[0.0; 6]; 2],
        };
        let normal = if self.law.excess.iter().any(|&c| c != 0.0) {
            self.normal_along_edge(edge)
        } else {
            [0.0; 6]
        };
        wrenches(&[first, second, normal])
    }

    /// ∫ p (ψ − 1) m dl, with ψ = 0 where it would be negative.
    fn normal_along_edge(&self, edge: usize) -> [f64; 6] {
        let [from, to] = self.polygon.ends(edge);
        let [start, end] = [from, to].map(|y| at(&self.law.damping, &y));
        if start >= 0.0 && end >= 0.0 {
            return self.edge_moments([from, to], &self.law.excess);
        }
        if start < 0.0 && end < 0.0 {
            return self.edge_moments([from, to], &MINUS_ONE);
        }
        let share = start / (start - end);
        let middle = [0, 1].map(|i| from[i] + share * (to[i] - from[i]));
        let (inside, outside) = if start >= 0.0 {
            ([from, middle], [middle, to])
        } else {
            ([middle, to], [from, middle])
        };
        let inside = self.edge_moments(inside, &self.law.excess);
        let outside = self.edge_moments(outside, &MINUS_ONE);
        std::array::from_fn(|m| inside[m] + outside[m])
    }

    /// ∫ p f m dl for an affine f.
    #[inline]
    fn edge_moments(&self, [from, to]: [[f64; 2]; 2], f: &[f64; 3]) -> [f64; 6] {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        let mut moments = [0.0; 6];
        for (share, weight) in THREE_POINTS {
            let y = [0, 1].map(|i| from[i] + share * along[i]);
            let value = at(&self.polygon.plane.pressure, &y) * at(f, &y) * (weight * length);
            for (moment, value) in moments.iter_mut().zip(&up_to_quadratic(value, &y)) {
                *moment += value;
            }
        }
        moments
    }
}
