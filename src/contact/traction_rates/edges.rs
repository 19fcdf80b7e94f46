use super::{Rates, Traction, VectorMoments, along_normal_of, wrenches};
use crate::contact::plane::{PlanePolygon, at, up_to_quadratic};
use crate::contact::polygon::PolygonSource;
use crate::narrow_phase::Cut;
use nalgebra::{Vector3, Vector6};

/// Gauss' points and weights for the mean over an edge, from its start: exact to degree five.
const THREE_POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// ψ − 1 where ψ = 0.
const NONE: [f64; 3] = [-1.0, 0.0, 0.0];

impl PolygonSource<'_, f64> {
    /// Adds what the motion of the edges contributes.
    pub(super) fn add_edges(&self, cut: &Cut, traction: &Traction, rates: &mut Rates) {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let edges = traction.plane.outline.corners().len();
        for (edge, &owners) in cut.polygon.owners().iter().enumerate().take(edges) {
            // At the rim there is no pressure.
            if owners == 0 || owners & a.zero_faces != 0 {
                continue;
            }
            let along = traction.plane.edge(edge);
            if along[0] == 0.0 && along[1] == 0.0 {
                continue;
            }
            let flux = wrenches(&traction.along_edge(edge));
            let share = cut.weight().edges / f64::from(owners.count_ones());
            for face in (0..8).filter(|face| owners & 1 << face != 0) {
                let outward = if face < 4 {
                    a.barycentric[face].gradient * -a.barycentric_steepness[face].recip()
                } else {
                    let face = face - 4;
                    let in_b =
                        b.barycentric[face].gradient * -b.barycentric_steepness[face].recip();
                    self.pose_ab.rotation() * in_b
                };
                let m = traction.plane.axes.tr_mul(&outward);
                rates.add_flux(&flux, &m, share * outwardness(&along, &m), face >= 4);
            }
        }
    }
}

/// 1/|m − (m·n)n|, negative if a face's normal m points into the polygon at this edge, 0 if the face lies in the plane.
fn outwardness(along: &[f64; 2], m: &Vector3<f64>) -> f64 {
    let sine = (m.x * m.x + m.y * m.y).sqrt();
    let turn = m.x * along[1] - m.y * along[0];
    if sine == 0.0 {
        0.0
    } else {
        turn.signum() / sine
    }
}

impl PlanePolygon<f64> {
    /// From the start of an edge of the contact polygon to its end.
    fn edge(&self, edge: usize) -> [f64; 2] {
        let [from, to] = self.ends(edge);
        [to[0] - from[0], to[1] - from[1]]
    }

    fn ends(&self, edge: usize) -> [[f64; 2]; 2] {
        let corners = self.outline.corners();
        [
            corners[edge],
            corners[if edge + 1 == corners.len() {
                0
            } else {
                edge + 1
            }],
        ]
    }
}

impl Traction<'_> {
    /// ∫ t m dl along an edge of the contact polygon.
    fn along_edge(&self, edge: usize) -> VectorMoments {
        let mut moments = [[0.0; 6]; 3];
        let pressed = self.pressed.edges().iter();
        if let Some(part) = pressed.clone().position(|&of| usize::from(of) == edge) {
            let [first, second] = &self.slip.edges[part];
            moments[0] = first.map(|moment| -self.friction * moment);
            moments[1] = second.map(|moment| -self.friction * moment);
        }
        if self.dissipation != 0.0 {
            moments[2] = self.normal_along_edge(edge);
        }
        moments
    }

    /// ∫ p (ψ − 1) m dl, with ψ = 0 where it would be negative.
    fn normal_along_edge(&self, edge: usize) -> [f64; 6] {
        let [from, to] = self.plane.ends(edge);
        let excess = self.excess_damping();
        let [start, end] = [from, to].map(|y| at(&self.damping, &y));
        if start >= 0.0 && end >= 0.0 {
            return self.edge_moments([from, to], &excess);
        }
        if start < 0.0 && end < 0.0 {
            return self.edge_moments([from, to], &NONE);
        }
        let share = start / (start - end);
        let middle = [0, 1].map(|i| from[i] + share * (to[i] - from[i]));
        let (inside, outside) = if start >= 0.0 {
            ([from, middle], [middle, to])
        } else {
            ([middle, to], [from, middle])
        };
        let inside = self.edge_moments(inside, &excess);
        let outside = self.edge_moments(outside, &NONE);
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
            let value = at(&self.plane.pressure, &y) * at(f, &y) * (weight * length);
            for (moment, value) in moments.iter_mut().zip(&up_to_quadratic(value, &y)) {
                *moment += value;
            }
        }
        moments
    }
}

impl Rates {
    /// Adds the flux through an edge of a face with the outward normal m, times `scale`; the face moves with A or with B.
    fn add_flux(
        &mut self,
        flux: &[Vector6<f64>; 3],
        m: &Vector3<f64>,
        scale: f64,
        moves_with_b: bool,
    ) {
        for (k, f) in self.by_speed.iter_mut().zip(flux) {
            *k -= f * (scale * m.z);
        }
        if moves_with_b {
            self.by_motion += along_normal_of(&(m * scale), flux);
        }
    }
}
