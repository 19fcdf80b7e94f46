//! Pressure and slip on generic contact polygons, and the levels of the quadrature rules that integrate them.

use super::SurfaceLaw;
use super::motion::RelativeMotion;
use super::plane_motion::PlaneMotion;
use crate::friction::{LEVELS, level_bounds, theta_squared};
use crate::lanes::space::{loaded, store};
use crate::lanes::{Lanes, Mask, Numbers, ROW, Row};
use crate::narrow_phase::{Octet, SLOTS};

/// Pressure and slip on the polygons of an octet, as affine functions c₀ + c₁y₁ + c₂y₂ on their planes.
pub(super) struct SlipFields<'o> {
    pub pressure: &'o [Row; 3],
    pub damping: [Row; 3],
    /// The slip at the origin, and the spin.
    pub slip: [Row; 3],
    /// The lowest level of quadrature rules that is accurate enough for each polygon, as a whole number. If the slip direction varies too
    /// rapidly, or the pressure is clamped at a corner, no rule is used and the level is [`LEVELS`].
    levels: Row,
}

impl<'o> SlipFields<'o> {
    #[inline(always)]
    pub fn of<L: Lanes>(
        lanes: L,
        octet: &'o Octet,
        law: &SurfaceLaw,
        motion: &RelativeMotion<f64>,
    ) -> Self {
        let mut loads = Self {
            pressure: &octet.pressure,
            damping: [[0.0; ROW]; 3],
            slip: [[0.0; ROW]; 3],
            levels: [0.0; ROW],
        };
        let (dissipation, one) = (lanes.splat(law.dissipation), lanes.splat(1.0));
        let tolerance = lanes.splat(law.slip_tolerance);
        for first in (0..octet.tets().len()).step_by(L::COUNT) {
            let [e1, e2, n] = &octet.axes;
            let axes = [
                loaded(lanes, e1, first),
                loaded(lanes, e2, first),
                loaded(lanes, n, first),
            ];
            let origin = loaded(lanes, &octet.origin, first);
            let motion = PlaneMotion::in_lanes(lanes, motion, &axes, origin);
            let ([v1, v2], spin) = motion.slip();
            let (damping, slip) = (motion.damping(dissipation, one), [v1, v2, spin]);
            store(&mut loads.damping, first, damping);
            store(&mut loads.slip, first, slip);
            levels(lanes, (octet, first), damping, (slip, tolerance))
                .store(&mut loads.levels, first);
        }
        loads
    }

    /// Returns the indices of polygons that are integrated by rules, as bits. The bits of indices without a polygon are arbitrary.
    #[inline]
    pub fn by_rules(&self) -> u8 {
        let mut by_rules = 0;
        for index in 0..ROW {
            by_rules |= u8::from(self.level(index) < LEVELS) << index;
        }
        by_rules
    }

    /// Returns the level of the polygon at an index.
    #[inline]
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small whole number"
    )]
    pub fn level(&self, index: usize) -> usize {
        self.levels[index] as usize
    }
}

/// Computes the [`SlipFields::levels`] of polygons, one in each lane, like [`Slip::level`](crate::friction::Slip::level) for one polygon.
#[inline(always)]
fn levels<L: Lanes>(
    lanes: L,
    (octet, first): (&Octet, usize),
    damping: [L::Numbers; 3],
    ([v1, v2, spin], tolerance): ([L::Numbers; 3], L::Numbers),
) -> L::Numbers {
    let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
    let corner = |slot: usize| {
        let [y1, y2] = &octet.corners[slot];
        [lanes.load(y1, first), lanes.load(y2, first)]
    };
    let mut total = [zero; 2];
    let mut is_clamped = zero.is_less(zero);
    for slot in 0..SLOTS {
        let [y1, y2] = corner(slot);
        total = [total[0] + y1, total[1] + y2];
        let at_corner = damping[0] + damping[1] * y1 + damping[2] * y2;
        is_clamped = is_clamped | at_corner.is_less(zero);
    }
    let count = lanes.gathered(|lane| f64::from(octet.edge_count(first + lane).max(1)));
    let mean = [total[0] / count, total[1] / count];
    let mut size_squared = zero;
    for slot in 0..SLOTS {
        let [y1, y2] = corner(slot);
        let [d1, d2] = [y1 - mean[0], y2 - mean[1]];
        size_squared = size_squared.max(d1 * d1 + d2 * d2);
    }
    let theta_squared = theta_squared(([v1, v2], spin, tolerance), mean, size_squared);
    let mut level = zero;
    for bound in level_bounds() {
        // NaN fails every comparison, so it selects the closed form.
        let is_within = theta_squared.is_less(lanes.splat(bound * bound));
        level = level + is_within.select(zero, one);
    }
    is_clamped.select(lanes.splat(LEVELS as f64), level)
}
