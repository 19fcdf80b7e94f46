use super::{Rates, Traction, VectorMoments, along_normal_of, wrenches};
use crate::contact::plane::{PlanePolygon, at, up_to_quadratic};
use crate::contact::polygon::{CutPolygon, PolygonSource};
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

/// A motion of B and a growth of its modulus, by this part of itself, in which faces that share a line leave it one after
/// the other: any that are not special. Layers of equal pressure share their lines whatever the motion.
const NUDGE: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);
const GROWTH: f64 = 0.381;

/// The line in which the plane meets a face that owns an edge.
#[derive(Clone, Copy)]
struct Line {
    /// The face's outward normal, along the axes of the plane.
    normal: Vector3<f64>,
    /// 1/|m − (m·n)n| for this normal m, negative if it points into the polygon.
    outwardness: f64,
    moves_with_b: bool,
    /// How fast the line leaves the middle of the edge outwards, by [`NUDGE`] and [`GROWTH`].
    speed: f64,
}

/// The edges of a contact polygon that is moved.
struct Edges<'e> {
    source: &'e PolygonSource<'e, f64>,
    cut: &'e Cut,
    traction: &'e Traction<'e>,
    /// The speed of the plane along its normal as B is moved by [`NUDGE`], and by its pressure (m/(s Pa)).
    plane_speed: f64,
    by_pressure: f64,
}

impl PolygonSource<'_, f64> {
    /// Adds what the motion of the edges contributes.
    pub(super) fn add_edges(
        &self,
        (cut, polygon): (&Cut, &CutPolygon<f64>),
        traction: &Traction,
        rates: &mut Rates,
    ) {
        let per_gradient = polygon.plane.steepness.recip();
        let edges = Edges {
            source: self,
            cut,
            traction,
            plane_speed: -polygon.pressure_b.gradient.dot(&NUDGE) * per_gradient,
            by_pressure: GROWTH * per_gradient,
        };
        edges.add_to(rates);
    }
}

/// An edge of a line is one of its two ways, and not what trims its ends, if it is longer than this part of the longest.
const WAY: f64 = 1e-6;

impl Edges<'_> {
    fn add_to(&self, rates: &mut Rates) {
        let zero_faces = self.source.pair.tet_a(self.cut.tets[0]).zero_faces;
        // At the rim there is no pressure.
        let is_moved = |owners: u8| owners != 0 && owners & zero_faces == 0;
        if let Some((edge, owners)) = self.line_way() {
            if is_moved(owners) {
                self.add_edge(edge, owners, rates);
            }
            return;
        }
        for (edge, &owners) in self.owners().iter().enumerate() {
            if is_moved(owners) && self.length_squared(edge) > 0.0 {
                self.add_edge(edge, owners, rates);
            }
        }
    }

    fn owners(&self) -> &[u8] {
        &self.cut.polygon.owners()[..self.traction.plane.outline.corners().len()]
    }

    fn length_squared(&self, edge: usize) -> f64 {
        let [y1, y2] = self.traction.plane.edge(edge);
        y1 * y1 + y2 * y2
    }

    /// Of a polygon that is but a line, forth and back, one of its two ways and the owners of both. An owner of one of the
    /// ways has the polygon on its outer side.
    fn line_way(&self) -> Option<(usize, u8)> {
        let owners = self.owners();
        if owners.iter().all(|own| own.count_ones() < 2) {
            return None;
        }
        let length = |edge: &usize| self.length_squared(*edge);
        let by_length = |one: &usize, other: &usize| length(one).total_cmp(&length(other));
        let longest = (0..owners.len()).max_by(by_length)?;
        let least = WAY * WAY * length(&longest);
        let ways = || (0..owners.len()).filter(|edge| length(edge) > least);
        let has_owner_inside = |edge: usize| {
            let owners = owners[edge];
            owners.count_ones() > 1
                && faces_of(owners).any(|face| self.line(face, edge).outwardness < 0.0)
        };
        ways().find(|&edge| has_owner_inside(edge))?;
        Some((longest, ways().fold(0, |all, edge| all | owners[edge])))
    }

    fn add_edge(&self, edge: usize, owners: u8, rates: &mut Rates) {
        let flux = wrenches(&self.traction.along_edge(edge));
        let weight = self.cut.weight().edges;
        if owners.is_power_of_two() {
            let line = self.line(owners.trailing_zeros() as usize, edge);
            return rates.add_flux(&flux, &line, weight);
        }
        let mut lines = [None; 8];
        for (line, face) in lines.iter_mut().zip(faces_of(owners)) {
            *line = Some(self.line(face, edge));
        }
        for line in owning(&lines) {
            rates.add_flux(&flux, line, weight * share_of(line, &lines));
        }
    }

    fn line(&self, face: usize, edge: usize) -> Line {
        let plane = self.traction.plane;
        let [from, to] = plane.ends(edge);
        let middle = [0, 1].map(|i| 0.5 * (from[i] + to[i]));
        let plane_speed = self.plane_speed + self.by_pressure * at(&plane.pressure, &middle);
        let pair = &self.source.pair;
        let outward = if face < 4 {
            let a = pair.tet_a(self.cut.tets[0]);
            a.barycentric[face].gradient * -a.barycentric_steepness[face].recip()
        } else {
            let (b, face) = (pair.tet_b(self.cut.tets[1]), face - 4);
            let in_b = b.barycentric[face].gradient * -b.barycentric_steepness[face].recip();
            self.source.pose_ab.rotation() * in_b
        };
        let normal = plane.axes.tr_mul(&outward);
        let outwardness = outwardness(&plane.edge(edge), &normal);
        let own_speed = if face < 4 { 0.0 } else { outward.dot(&NUDGE) };
        Line {
            normal,
            outwardness,
            moves_with_b: face >= 4,
            speed: outwardness * (own_speed - plane_speed * normal.z),
        }
    }
}

/// The places of the bits that are set.
fn faces_of(owners: u8) -> impl Iterator<Item = usize> {
    (0..8).filter(move |face| owners & 1 << face != 0)
}

fn owning(lines: &[Option<Line>; 8]) -> impl Iterator<Item = &Line> {
    lines.iter().flatten()
}

/// How much of an edge's flux is that of a line's motion: the mean of both sides of the coincidence.
///
/// Moved a little by [`NUDGE`], ahead or behind, the polygon ends at the innermost of the lines that bound it from
/// outside, and begins at the outermost of those that bound it from inside, if that lies further in. So of any number of
/// lines that bound it from outside alone, the slowest and the fastest share the edge.
fn share_of(line: &Line, lines: &[Option<Line>; 8]) -> f64 {
    let is_outer = |line: &&Line| line.outwardness > 0.0;
    [1.0, -1.0]
        .into_iter()
        .map(|way| {
            let speed = |line: &&Line| way * line.speed;
            let by_speed = |one: &&Line, other: &&Line| speed(one).total_cmp(&speed(other));
            let end = owning(lines).filter(is_outer).min_by(by_speed);
            let start = owning(lines)
                .filter(|line| !is_outer(line))
                .max_by(by_speed);
            let is_empty = end
                .zip(start)
                .is_some_and(|(end, start)| speed(&end) <= speed(&start));
            match (end, start) {
                _ if is_empty => 0.0,
                (Some(end), _) if std::ptr::eq(end, line) => 0.5,
                (_, Some(start)) if std::ptr::eq(start, line) => -0.5,
                _ => 0.0,
            }
        })
        .sum()
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
    /// Adds a share of the flux through an edge that moves with a line.
    fn add_flux(&mut self, flux: &[Vector6<f64>; 3], line: &Line, share: f64) {
        let m = line.normal * (share * line.outwardness);
        for (k, f) in self.by_speed.iter_mut().zip(flux) {
            *k -= f * m.z;
        }
        if line.moves_with_b {
            self.by_motion += along_normal_of(&m, flux);
        }
    }
}
