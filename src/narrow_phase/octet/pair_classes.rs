use super::Part;
use crate::contact_shape::PartnerShape;
use crate::lanes::space::{difference, dot, gathered, scaled};
use crate::lanes::{Lanes, Mask, Numbers};
use crate::narrow_phase::RelativePair;

/// Pressure gradients count as nearly equal if they differ by less than this fraction of the fields' sensitivity. The error of the plane's
/// position is then at least a thousand times the rounding error of a coordinate.
const NEARLY_EQUAL: f64 = 1e-3;

/// Properties of two bodies that are the same for all their pairs of tetrahedra.
pub(super) struct Bodies<N> {
    pub scale_a: N,
    pub modulus_a: N,
    /// Distances (m) up to which values are near zero.
    pub near: N,
    pub is_rigid: bool,
    /// Whether the plane must pass between the corners of B's tetrahedra. If B is rigid or a half-space, only the clips by B's faces decide
    /// this (see `RelativePair::signs_at_b`).
    has_corners_b: bool,
}

impl<N: Numbers> Bodies<N> {
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(lanes: L, pair: &RelativePair) -> Self {
        Self {
            scale_a: lanes.splat(pair.scales[0]),
            modulus_a: lanes.splat(pair.modulus_a),
            near: lanes.splat(pair.tolerance.noted()),
            is_rigid: pair.shape_b.is_rigid(),
            has_corners_b: matches!(pair.shape_b, PartnerShape::Compliant(_)),
        }
    }
}

/// Position of the plane of equal pressure relative to a tetrahedron of A and one of B, in each lane.
pub(super) struct PairClasses<N: Numbers> {
    pub corners_a: [[N; 3]; 4],
    /// p_A − p_B (Pa) at A's corners.
    pub at_a: [N; 4],
    /// Lanes in which `at_a` is below zero.
    pub below: [N::Mask; 4],
    pub extent_gradient: [N; 3],
    pub gradient_b: [N; 3],
    /// ∇p_A − ∇p_B, or a unit vector if there is no generic polygon.
    pub gradient: [N; 3],
    /// Lanes in which the plane passes through both tetrahedra, no value is near zero, and the fields are not nearly equal.
    pub is_generic: N::Mask,
    /// Lanes in which the plane may pass through both tetrahedra, and a value is near zero or the fields are nearly equal. If a lane is
    /// neither generic nor special, the plane misses one of the tetrahedra, or there is no pair.
    pub is_special: N::Mask,
}

/// Signs of the four values at the corners of a tetrahedron.
struct Signs<M> {
    have_below: M,
    have_above: M,
    are_near: M,
}

#[inline(always)]
fn signs<N: Numbers>(values: &[N; 4], zero: N, near: N) -> Signs<N::Mask> {
    let [v0, v1, v2, v3] = *values;
    Signs {
        have_below: v0.is_less(zero) | v1.is_less(zero) | v2.is_less(zero) | v3.is_less(zero),
        have_above: zero.is_less(v0) | zero.is_less(v1) | zero.is_less(v2) | zero.is_less(v3),
        are_near: v0.abs().is_at_most(near)
            | v1.abs().is_at_most(near)
            | v2.abs().is_at_most(near)
            | v3.abs().is_at_most(near),
    }
}

/// p_A − p_B (Pa) at A's corners.
#[inline(always)]
fn excess_at_corners_of_a<L: Lanes>(
    lanes: L,
    bodies: &Bodies<L::Numbers>,
    part: &Part,
    (corners_a, gradient_b): (&[[L::Numbers; 3]; 4], [L::Numbers; 3]),
) -> [L::Numbers; 4] {
    let offset_b = lanes.gathered(|lane| part.b[lane].field.offset);
    let mut at_a = [offset_b; 4];
    for corner in 0..4 {
        let value_a = lanes.gathered(|lane| part.a[lane].extents[corner]) * bodies.scale_a;
        at_a[corner] = value_a - (dot(gradient_b, corners_a[corner]) + offset_b);
    }
    at_a
}

/// Returns p_A − p_B (Pa) at B's corners. A's field is extended beyond its tetrahedron.
#[inline(always)]
fn excess_at_corners_of_b<L: Lanes>(
    lanes: L,
    bodies: &Bodies<L::Numbers>,
    part: &Part,
    gradient_a: [L::Numbers; 3],
) -> [L::Numbers; 4] {
    let offset_a = lanes.gathered(|lane| part.a[lane].extent.offset) * bodies.scale_a;
    let mut at_b = [offset_a; 4];
    for corner in 0..4 {
        let corner_b = gathered(lanes, |lane| &part.b[lane].tetrahedron.corners[corner]);
        let value_b = lanes.gathered(|lane| part.b[lane].values[corner]);
        at_b[corner] = (dot(gradient_a, corner_b) + offset_a) - value_b;
    }
    at_b
}

impl<N: Numbers> PairClasses<N> {
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(
        lanes: L,
        bodies: &Bodies<N>,
        part: &Part,
        is_there: N::Mask,
    ) -> Self {
        let (a, b) = (part.a, part.b);
        let (zero, one) = (lanes.splat(0.0), lanes.splat(1.0));
        let corners_a = [
            gathered(lanes, |lane| &a[lane].tetrahedron.corners[0]),
            gathered(lanes, |lane| &a[lane].tetrahedron.corners[1]),
            gathered(lanes, |lane| &a[lane].tetrahedron.corners[2]),
            gathered(lanes, |lane| &a[lane].tetrahedron.corners[3]),
        ];
        let gradient_b = gathered(lanes, |lane| &b[lane].field.gradient);
        let sensitivity_b = lanes.gathered(|lane| b[lane].sensitivity);
        let at_a = excess_at_corners_of_a(lanes, bodies, part, (&corners_a, gradient_b));
        let signs_a = signs(&at_a, zero, bodies.near * sensitivity_b);
        let extent_gradient = gathered(lanes, |lane| &a[lane].extent.gradient);
        let gradient_a = scaled(extent_gradient, bodies.scale_a);
        let sensitivity_a = lanes.gathered(|lane| a[lane].sensitivity) * bodies.scale_a;
        let gradient = difference(gradient_a, gradient_b);
        let least = sensitivity_a.max(sensitivity_b) * lanes.splat(NEARLY_EQUAL);
        let are_nearly_equal = dot(gradient, gradient).is_at_most(least * least);
        let mut is_met = signs_a.have_below & signs_a.have_above;
        let mut is_near = signs_a.are_near;
        let mut may_meet = is_met | is_near;
        if bodies.has_corners_b {
            let at_b = excess_at_corners_of_b(lanes, bodies, part, gradient_a);
            let signs_b = signs(&at_b, zero, bodies.near * sensitivity_a);
            let is_met_b = signs_b.have_below & signs_b.have_above;
            is_met = is_met & is_met_b;
            is_near = is_near | signs_b.are_near;
            may_meet = may_meet & (is_met_b | signs_b.are_near);
        }
        let is_doubtful = is_near | are_nearly_equal;
        let is_generic = is_there & is_met & !is_doubtful;
        Self {
            corners_a,
            at_a,
            below: [
                at_a[0].is_less(zero),
                at_a[1].is_less(zero),
                at_a[2].is_less(zero),
                at_a[3].is_less(zero),
            ],
            extent_gradient,
            gradient_b,
            gradient: [
                is_generic.select(gradient[0], zero),
                is_generic.select(gradient[1], zero),
                is_generic.select(gradient[2], one),
            ],
            is_generic,
            is_special: is_there & may_meet & is_doubtful,
        }
    }

    /// Returns whether any lane has a generic pair.
    #[inline(always)]
    pub fn is_any_generic(&self) -> bool {
        self.is_generic.is_any()
    }
}
