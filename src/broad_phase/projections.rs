use crate::geometry::Tetrahedron;
use crate::scalar::portable::sin_cos;
use nalgebra::Vector3;
use std::sync::LazyLock;

/// Inverses of the plastic number and of its square. The fractional parts of their multiples spread
/// evenly over a square. So the directions spread over the sphere, and are the same in every run.
const SPREAD: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

static DIRECTIONS: LazyLock<[Vector3<f64>; Projections::COUNT]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let [u, v] = SPREAD.map(|step| ((k + 1) as f64 * step).fract());
        let (z, angle) = (2.0 * u - 1.0, std::f64::consts::TAU * v);
        let (across, (sine, cosine)) = ((1.0 - z * z).sqrt(), sin_cos(angle));
        Vector3::new(across * cosine, across * sine, z)
    })
});

/// Projections of a tetrahedron onto a few fixed directions, for the separating-direction test of
/// the paper, §IV-D. The directions belong to one frame. Projections of that frame's own mesh are
/// computed once. A tetrahedron from another frame is projected once for all its partners.
#[derive(Debug, Clone, Copy)]
pub struct Projections([[f64; 2]; Self::COUNT]);

impl Projections {
    /// Number of directions.
    pub const COUNT: usize = 16;

    /// Projects a tetrahedron.
    #[must_use]
    pub fn of(tetrahedron: &Tetrahedron) -> Self {
        Self(DIRECTIONS.each_ref().map(|direction| {
            let limits = [f64::INFINITY, f64::NEG_INFINITY];
            tetrahedron
                .corners
                .iter()
                .fold(limits, |[low, high], corner| {
                    let x = corner.dot(direction);
                    [low.min(x), high.max(x)]
                })
        }))
    }

    /// Returns whether a gap wider than `margin` (m) separates the two tetrahedra along one of the
    /// first `count` directions.
    #[inline]
    #[must_use]
    pub fn separate(&self, other: &Self, count: usize, margin: f64) -> bool {
        let pairs = self.0.iter().zip(&other.0).take(count);
        pairs.into_iter().any(|([low_a, high_a], [low_b, high_b])| {
            *low_a > high_b + margin || *low_b > high_a + margin
        })
    }
}
