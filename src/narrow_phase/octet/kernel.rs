use super::outlines::{Outlines, Planes};
use super::pair_classes::{Bodies, PairClasses};
use super::{BELOW, OPPOSITE, Octet, Part, PosedTet, SLOTS, SPECIAL};
use crate::lanes::space::{dot, scaled, store};
use crate::lanes::{InLanes, Lanes, Mask, Numbers, ROW};
use crate::narrow_phase::RelativePair;
use std::array;

/// Classifies the pairs of octets and cuts the generic ones. No octet may be empty.
pub(crate) struct CutOctets<'o, 'p, 'a, P> {
    pub pair: &'p RelativePair<'a>,
    /// A tetrahedron of B in A's frame.
    pub posed: P,
    pub octets: &'o mut [Octet],
}

impl<'p, P: Fn(u32) -> &'p PosedTet> InLanes for CutOctets<'_, 'p, '_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let bodies = Bodies::of(lanes, self.pair);
        for octet in self.octets {
            let a: [_; ROW] =
                array::from_fn(|index| self.pair.tet_a(octet.tet_or_first(index, 0) as usize));
            let b: [_; ROW] = array::from_fn(|index| (self.posed)(octet.tet_or_first(index, 1)));
            for first in (0..ROW).step_by(L::COUNT) {
                if first < octet.len {
                    let (a, b) = (&a[first..], &b[first..]);
                    octet.fill(lanes, &bodies, &Part { first, a, b });
                } else {
                    octet.fill_with_nothing(lanes, first);
                }
            }
        }
    }
}

impl Octet {
    /// Returns the index of the tetrahedron of A (0) or B (1) of a pair. For a missing pair, returns the index of the first pair, so that
    /// all lanes have valid input.
    #[inline(always)]
    fn tet_or_first(&self, index: usize, body: usize) -> u32 {
        self.tets[if index < self.len { index } else { 0 }][body]
    }

    /// Processes as many pairs as there are lanes.
    #[inline(always)]
    fn fill<L: Lanes>(&mut self, lanes: L, bodies: &Bodies<L::Numbers>, part: &Part) {
        let (first, b, len) = (part.first, part.b, self.len);
        let zero = lanes.splat(0.0);
        let is_there = zero.is_less(lanes.gathered(|lane| f64::from(u8::from(first + lane < len))));
        let met = PairClasses::of(lanes, bodies, part, is_there);
        if !met.is_any_generic() {
            self.fill_with_nothing(lanes, first);
            let special = lanes.splat(f64::from(SPECIAL));
            met.is_special
                .select(special, zero)
                .store(&mut self.codes, first);
            return;
        }
        let mut planes = Planes::of(lanes, &met);
        let mut outlines = Outlines::of_slices(lanes, &met, &planes);
        let most_bounds = (0..L::COUNT)
            .map(|lane| b[lane].bound_count)
            .fold(0, usize::max);
        outlines.clip_by_bounds(lanes, &planes, bodies.near, (b, most_bounds));
        outlines.recenter(lanes, &mut planes);
        let moments = outlines.moments(lanes);
        let counts = zero.is_less(moments[0]) & !outlines.is_near;
        for (row, moment) in self.moments.iter_mut().zip(moments) {
            counts.select(moment, zero).store(row, first);
        }
        self.store_codes(lanes, first, &met, &outlines);
        self.store_planes(first, &planes);
        self.store_outlines(first, &outlines);
        self.store_pressures(lanes, bodies, part, (&met, &planes));
        self.store_slopes(first, bodies, &met, planes.inverse_gradient_norm);
        let inverse_gradient_norm = if bodies.is_rigid {
            zero
        } else {
            planes.inverse_gradient_norm
        };
        inverse_gradient_norm.store(&mut self.inverse_gradient_norm, first);
    }

    #[inline(always)]
    fn store_codes<L: Lanes>(
        &mut self,
        lanes: L,
        first: usize,
        met: &PairClasses<L::Numbers>,
        outlines: &Outlines<L::Numbers>,
    ) {
        let (zero, special) = (lanes.splat(0.0), lanes.splat(f64::from(SPECIAL)));
        let mut code = zero;
        for (bit, is_set) in outlines.is_there.into_iter().enumerate() {
            code = code + is_set.select(lanes.splat(f64::from(1_u32 << bit)), zero);
        }
        for (corner, is_below) in met.below.into_iter().enumerate() {
            let bit = f64::from(1_u32 << (BELOW + corner));
            code = code + is_below.select(lanes.splat(bit), zero);
        }
        for slot in 0..SLOTS {
            let bit = f64::from(1_u32 << (OPPOSITE + slot));
            let is_beside =
                is_origin(outlines.from[slot], zero) | is_origin(outlines.to[slot], zero);
            code = code + is_beside.select(zero, lanes.splat(bit));
        }
        let is_special = met.is_special | outlines.is_near;
        is_special
            .select(special, code)
            .store(&mut self.codes, first);
    }

    /// Stores that some places have no polygon. Other rows keep values of earlier pairs. These are finite, and their area is zero.
    #[inline(always)]
    fn fill_with_nothing<L: Lanes>(&mut self, lanes: L, first: usize) {
        let zero = lanes.splat(0.0);
        zero.store(&mut self.codes, first);
        for row in &mut self.moments {
            zero.store(row, first);
        }
    }

    #[inline(always)]
    fn store_planes<N: Numbers>(&mut self, first: usize, planes: &Planes<N>) {
        store(&mut self.origin, first, planes.origin);
        for (rows, axis) in self.axes.iter_mut().zip(planes.axes) {
            store(rows, first, axis);
        }
    }

    #[inline(always)]
    fn store_outlines<N: Numbers>(&mut self, first: usize, outlines: &Outlines<N>) {
        for slot in 0..SLOTS {
            for axis in 0..2 {
                outlines.from[slot][axis].store(&mut self.corners[slot][axis], first);
                outlines.to[slot][axis].store(&mut self.ends[slot][axis], first);
            }
        }
        for bound in 0..4 {
            outlines.after[bound].store(&mut self.after[bound], first);
        }
    }

    /// Stores the pressure. Uses the field with the smaller gradient, because its rounding error is smaller. If B is rigid, uses A's field.
    /// (`SpacePolygon::pressure` does the same for one pair.)
    #[inline(always)]
    fn store_pressures<L: Lanes>(
        &mut self,
        lanes: L,
        bodies: &Bodies<L::Numbers>,
        part: &Part,
        (met, planes): (&PairClasses<L::Numbers>, &Planes<L::Numbers>),
    ) {
        let &Part { first, a, b } = part;
        let gradient_a = scaled(met.extent_gradient, bodies.modulus_a);
        let (mut gradient, mut offset) = (
            gradient_a,
            lanes.gathered(|lane| a[lane].extent.offset) * bodies.modulus_a,
        );
        if !bodies.is_rigid {
            let steepness_a = lanes.gathered(|lane| a[lane].steepness) * bodies.scale_a;
            let is_a = steepness_a.is_at_most(lanes.gathered(|lane| b[lane].steepness));
            for axis in 0..3 {
                gradient[axis] = is_a.select(gradient[axis], met.gradient_b[axis]);
            }
            offset = is_a.select(offset, lanes.gathered(|lane| b[lane].field.offset));
        }
        let [e1, e2, _] = planes.axes;
        let at_origin = dot(gradient, planes.origin) + offset;
        store(
            &mut self.pressure,
            first,
            [at_origin, dot(gradient, e1), dot(gradient, e2)],
        );
    }

    /// Stores ∇p_A, ∇p_A/|g| and ∇p_B/|g|.
    #[inline(always)]
    fn store_slopes<N: Numbers>(
        &mut self,
        first: usize,
        bodies: &Bodies<N>,
        met: &PairClasses<N>,
        inverse_gradient_norm: N,
    ) {
        let gradient_a = scaled(met.extent_gradient, bodies.modulus_a);
        store(&mut self.gradient_a, first, gradient_a);
        let slope_a = scaled(met.extent_gradient, bodies.scale_a * inverse_gradient_norm);
        store(&mut self.slopes[0], first, slope_a);
        let slope_b = scaled(met.gradient_b, inverse_gradient_norm);
        store(&mut self.slopes[1], first, slope_b);
    }
}

/// Returns the lanes in which a point is the origin.
#[inline(always)]
fn is_origin<N: Numbers>([y1, y2]: [N; 2], zero: N) -> N::Mask {
    (y1.abs() + y2.abs()).is_at_most(zero)
}
