use super::pair_classes::PairClasses;
use super::{PosedTet, SLOTS};
use crate::geometry::{EDGES, FACES, PER_TRIANGLE, add_triangle};
use crate::lanes::space::{difference, dot, gathered, scaled, sum};
use crate::lanes::{Lanes, Mask, Numbers};

/// The planes of equal pressure, with coordinates y along e₁ and e₂ from an origin. The third axis is the normal n.
pub(super) struct Planes<N> {
    pub origin: [N; 3],
    /// e₁, e₂ and n.
    pub axes: [[N; 3]; 3],
    /// 1/|g|.
    pub inverse_gradient_norm: N,
}

impl<N: Numbers> Planes<N> {
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(lanes: L, met: &PairClasses<N>) -> Self {
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let inverse_gradient_norm = one / dot(met.gradient, met.gradient).sqrt();
        let normal = scaled(met.gradient, inverse_gradient_norm);
        let [e1, e2] = axes_beside(normal, [zero, one]);
        // If there is no generic polygon, the quotient is not a height, and pressures at this distance could overflow.
        let height = met
            .is_generic
            .select(met.at_a[0] * inverse_gradient_norm, zero);
        Self {
            origin: difference(met.corners_a[0], scaled(normal, height)),
            axes: [e1, e2, normal],
            inverse_gradient_norm,
        }
    }
}

/// Computes two unit vectors that are orthogonal to a third and to each other, without a square root \[Duff 2017\]. `axes_beside` in
/// `contact/plane_polygon.rs` does the same for any scalar.
#[inline(always)]
fn axes_beside<N: Numbers>([x, y, z]: [N; 3], [zero, one]: [N; 2]) -> [[N; 3]; 2] {
    let sign = zero.is_at_most(z).select(one, -one);
    let factor = -(one / (z + sign));
    let product = x * y * factor;
    let e1 = [x * x * factor * sign + one, product * sign, -(x * sign)];
    [e1, [product, y * y * factor + sign, -y]]
}

/// Convex polygons as sets of edges, counter-clockwise: one slot for each face that may have an edge.
///
/// A clip moves the ends of edges, removes edges, and adds the edge between the two points where it cuts the outline. No edge changes its
/// slot, so all lanes execute the same instructions.
pub(super) struct Outlines<N: Numbers> {
    pub from: [[N; 2]; SLOTS],
    pub to: [[N; 2]; SLOTS],
    pub is_there: [N::Mask; SLOTS],
    /// For each bound of B, the slot of the edge that the bound cut on the way out; −1 if it cut none.
    pub after: [N; 4],
    /// Lanes in which a corner was near a bound.
    pub is_near: N::Mask,
}

/// Index in [`EDGES`] of the edge between two corners of a tetrahedron, or 6 if the corners are the same.
const EDGE_BETWEEN: [[usize; 4]; 4] = [[6, 0, 1, 2], [0, 6, 3, 4], [1, 3, 6, 5], [2, 4, 5, 6]];

impl<N: Numbers> Outlines<N> {
    /// Slices tetrahedra of A by the planes. Each face that a plane crosses has an edge. Around the face, the edge begins where p_A − p_B
    /// falls below zero, and ends where it rises above zero.
    #[inline(always)]
    pub fn of_slices<L: Lanes<Numbers = N>>(
        lanes: L,
        met: &PairClasses<N>,
        planes: &Planes<N>,
    ) -> Self {
        let zero = lanes.splat(0.0);
        let mut corners = [[zero; 2]; 4];
        for corner in 0..4 {
            let offset = difference(met.corners_a[corner], planes.origin);
            corners[corner] = [dot(planes.axes[0], offset), dot(planes.axes[1], offset)];
        }
        let mut crossings = [[zero; 2]; 6];
        for edge in 0..6 {
            let [i, j] = EDGES[edge];
            let share = met.at_a[i] / (met.at_a[i] - met.at_a[j]);
            for axis in 0..2 {
                let [start, end] = [corners[i][axis], corners[j][axis]];
                crossings[edge][axis] = start + (end - start) * share;
            }
        }
        let nowhere = zero.is_less(zero);
        let mut outlines = Self {
            from: [[zero; 2]; SLOTS],
            to: [[zero; 2]; SLOTS],
            is_there: [nowhere; SLOTS],
            after: [lanes.splat(-1.0); 4],
            is_near: nowhere,
        };
        for face in 0..4 {
            let [p, q, r] = FACES[face];
            let [pq, qr, rp] = [EDGE_BETWEEN[p][q], EDGE_BETWEEN[q][r], EDGE_BETWEEN[r][p]];
            let [below_p, below_q, below_r] = [met.below[p], met.below[q], met.below[r]];
            let is_passed = (below_p | below_q | below_r) & !(below_p & below_q & below_r);
            let is_there = met.is_generic & is_passed;
            for axis in 0..2 {
                let [on_pq, on_qr, on_rp] = [
                    crossings[pq][axis],
                    crossings[qr][axis],
                    crossings[rp][axis],
                ];
                let from = (below_r & !below_q).select(on_qr, on_rp);
                let from = (below_q & !below_p).select(on_pq, from);
                let to = (below_q & !below_r).select(on_qr, on_rp);
                let to = (below_p & !below_q).select(on_pq, to);
                outlines.from[face][axis] = is_there.select(from, zero);
                outlines.to[face][axis] = is_there.select(to, zero);
            }
            outlines.is_there[face] = is_there;
        }
        outlines
    }

    /// Clips the polygons by the faces of B that may bound them: at most `most` in each lane.
    #[inline(always)]
    pub fn clip_by_bounds<L: Lanes<Numbers = N>>(
        &mut self,
        lanes: L,
        planes: &Planes<N>,
        near: N,
        (b, most): (&[&PosedTet], usize),
    ) {
        if most > 0 {
            self.clip::<L, 0>(lanes, planes, near, b);
        }
        if most > 1 {
            self.clip::<L, 1>(lanes, planes, near, b);
        }
        if most > 2 {
            self.clip::<L, 2>(lanes, planes, near, b);
        }
        if most > 3 {
            self.clip::<L, 3>(lanes, planes, near, b);
        }
    }

    /// Clips the polygons by one bound of B. Its number is a constant, so that the loop over the slots that may have an edge is unrolled.
    #[inline(always)]
    fn clip<L: Lanes<Numbers = N>, const BOUND: usize>(
        &mut self,
        lanes: L,
        planes: &Planes<N>,
        near: N,
        b: &[&PosedTet],
    ) {
        let (zero, nowhere) = (lanes.splat(0.0), lanes.splat(0.0).is_less(lanes.splat(0.0)));
        let face = |lane: usize| usize::from(b[lane].bounds[BOUND]);
        let gradient = gathered(lanes, |lane| &b[lane].faces[face(lane)].gradient);
        let offset = lanes.gathered(|lane| b[lane].faces[face(lane)].offset);
        let near = near * lanes.gathered(|lane| b[lane].face_steepness[face(lane)]);
        let at_origin = dot(gradient, planes.origin) + offset;
        let slope = [dot(gradient, planes.axes[0]), dot(gradient, planes.axes[1])];
        let (mut exit, mut entry, mut after) = ([zero; 2], [zero; 2], lanes.splat(-1.0));
        let mut is_cut = nowhere;
        for slot in 0..4 + BOUND {
            let (from, to, is_there) = (self.from[slot], self.to[slot], self.is_there[slot]);
            let value_from = at_origin + (slope[0] * from[0] + slope[1] * from[1]);
            let value_to = at_origin + (slope[0] * to[0] + slope[1] * to[1]);
            // The end of each edge is the start of another.
            self.is_near = self.is_near | (is_there & value_from.abs().is_at_most(near));
            let [starts_in, ends_in] = [zero.is_at_most(value_from), zero.is_at_most(value_to)];
            let leaves = is_there & starts_in & !ends_in;
            let enters = is_there & ends_in & !starts_in;
            let stays = is_there & (starts_in | ends_in);
            let share = value_from / (value_from - value_to);
            for axis in 0..2 {
                let crossing = from[axis] + (to[axis] - from[axis]) * share;
                exit[axis] = leaves.select(crossing, exit[axis]);
                entry[axis] = enters.select(crossing, entry[axis]);
                let start = starts_in.select(from[axis], crossing);
                let end = ends_in.select(to[axis], crossing);
                self.from[slot][axis] = stays.select(start, zero);
                self.to[slot][axis] = stays.select(end, zero);
            }
            after = leaves.select(lanes.splat(slot as f64), after);
            self.is_there[slot] = stays;
            is_cut = is_cut | leaves;
        }
        self.from[4 + BOUND] = exit;
        self.to[4 + BOUND] = entry;
        self.is_there[4 + BOUND] = is_cut;
        self.after[BOUND] = after;
    }

    /// Moves the origin to a corner of each polygon, because areas about a distant origin would be differences of large numbers. Slots
    /// without an edge begin and end at the origin.
    #[inline(always)]
    pub fn recenter<L: Lanes<Numbers = N>>(&mut self, lanes: L, planes: &mut Planes<N>) {
        let zero = lanes.splat(0.0);
        let mut corner = self.from[0];
        for slot in 1..SLOTS {
            for axis in 0..2 {
                corner[axis] = self.is_there[slot].select(self.from[slot][axis], corner[axis]);
            }
        }
        for slot in 0..SLOTS {
            let (from, to, is_there) = (self.from[slot], self.to[slot], self.is_there[slot]);
            for axis in 0..2 {
                self.from[slot][axis] = is_there.select(from[axis] - corner[axis], zero);
                self.to[slot][axis] = is_there.select(to[axis] - corner[axis], zero);
            }
        }
        let [e1, e2, _] = planes.axes;
        let in_plane = sum(scaled(e1, corner[0]), scaled(e2, corner[1]));
        planes.origin = sum(planes.origin, in_plane);
    }

    /// Computes ∫ m dA for the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂². Sums over signed triangles of the origin and each edge. A slot
    /// without an edge adds exactly zero, because both ends are the same point.
    #[inline(always)]
    pub fn moments<L: Lanes<Numbers = N>>(&self, lanes: L) -> [N; 6] {
        let mut sums = [lanes.splat(0.0); 6];
        let constants = [lanes.splat(0.5), lanes.splat(1.0 / 3.0)];
        for slot in 0..SLOTS {
            add_triangle(&mut sums, self.from[slot], self.to[slot], constants);
        }
        for (sum, factor) in sums.iter_mut().zip(PER_TRIANGLE) {
            *sum = *sum * lanes.splat(factor);
        }
        sums
    }
}
