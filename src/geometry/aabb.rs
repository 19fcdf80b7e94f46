use crate::spatial::Pose;
use nalgebra::Vector3;

/// Bound on the rounding error of a transformed coordinate, relative to its size, with a safety
/// factor.
const ROUNDING: f64 = 1e-14;

/// Axis-aligned box. Its boundary belongs to the box.
#[derive(Debug, Clone, Copy)]
pub struct Aabb {
    /// Smallest coordinates (m).
    pub lower: Vector3<f64>,
    /// Largest coordinates (m).
    pub upper: Vector3<f64>,
}

impl Aabb {
    /// A box that overlaps every other box. Do not transform it.
    pub(crate) const EVERYWHERE: Self = Self {
        lower: Vector3::new(f64::MIN, f64::MIN, f64::MIN),
        upper: Vector3::new(f64::MAX, f64::MAX, f64::MAX),
    };

    /// Returns the smallest box around the points. Without points, the box is inverted: `lower` is
    /// +∞ and `upper` is −∞.
    #[must_use]
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> Self {
        let empty = Self {
            lower: Vector3::repeat(f64::INFINITY),
            upper: Vector3::repeat(f64::NEG_INFINITY),
        };
        points.into_iter().fold(empty, |aabb, point| Self {
            lower: aabb.lower.inf(point),
            upper: aabb.upper.sup(point),
        })
    }

    /// Returns the box grown by `margin` (m) on every side.
    #[must_use]
    pub fn inflated(&self, margin: f64) -> Self {
        Self {
            lower: self.lower.add_scalar(-margin),
            upper: self.upper.add_scalar(margin),
        }
    }

    /// Returns whether the boxes share a point.
    #[inline]
    #[must_use]
    #[expect(
        clippy::needless_bitwise_bool,
        reason = "one branch for all six comparisons: where boxes are near, each is a coin toss"
    )]
    pub fn overlaps(&self, other: &Self) -> bool {
        let (bounds, other_bounds) = ((&self.lower, &self.upper), (&other.lower, &other.upper));
        let x = (bounds.0.x <= other_bounds.1.x) & (other_bounds.0.x <= bounds.1.x);
        let y = (bounds.0.y <= other_bounds.1.y) & (other_bounds.0.y <= bounds.1.y);
        let z = (bounds.0.z <= other_bounds.1.z) & (other_bounds.0.z <= bounds.1.z);
        x & y & z
    }

    /// Returns a box in the outer frame that contains this box.
    #[must_use]
    pub fn posed(&self, pose: &Pose<f64>) -> Self {
        let center = pose.transformed_point(&self.center());
        let reach = pose.rotation().abs() * self.half_extents();
        // Add the rounding error of both, so that boxes that touch still overlap.
        let margin = Vector3::repeat(ROUNDING * (center.amax() + reach.amax()));
        Self {
            lower: center - reach - margin,
            upper: center + reach + margin,
        }
    }

    /// Returns the smallest box that contains this box and another box.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            lower: self.lower.inf(&other.lower),
            upper: self.upper.sup(&other.upper),
        }
    }

    /// Returns the squared distance (m²) to a point. It is 0 inside the box.
    #[inline]
    #[must_use]
    pub fn squared_distance_to(&self, point: &Vector3<f64>) -> f64 {
        let outside = (self.lower - point).sup(&(point - self.upper));
        outside.sup(&Vector3::zeros()).norm_squared()
    }

    /// Returns the squared distance (m²) to another box. It is 0 if the boxes overlap.
    #[inline]
    #[must_use]
    pub fn squared_distance_to_box(&self, other: &Self) -> f64 {
        let outside = (self.lower - other.upper).sup(&(other.lower - self.upper));
        outside.sup(&Vector3::zeros()).norm_squared()
    }

    /// Returns the intersection of the boxes, or `None` if they do not overlap.
    #[must_use]
    pub fn common(&self, other: &Self) -> Option<Self> {
        self.overlaps(other).then(|| Self {
            lower: self.lower.sup(&other.lower),
            upper: self.upper.inf(&other.upper),
        })
    }

    /// Returns the center of the box (m).
    #[must_use]
    pub fn center(&self) -> Vector3<f64> {
        (self.lower + self.upper) * 0.5
    }

    /// Returns half the edge lengths (m).
    #[must_use]
    pub fn half_extents(&self) -> Vector3<f64> {
        (self.upper - self.lower) * 0.5
    }

    /// Returns whether no face of either box separates the boxes by more than `margin` (m). `self`
    /// is in A and `other` is in B. The nine edge-edge directions are not tested, so some pairs
    /// that do not overlap pass.
    #[must_use]
    pub fn may_overlap_posed(&self, other: &Self, pose_ab: &Pose<f64>, margin: f64) -> bool {
        let rotation = pose_ab.rotation();
        let reach = rotation.abs();
        let (half_a, half_b) = (self.half_extents(), other.half_extents());
        let between_a = pose_ab.transformed_point(&other.center()) - self.center();
        let between_b = rotation.tr_mul(&between_a);
        let (reach_a, reach_b) = (half_a + reach * half_b, half_b + reach.tr_mul(&half_a));
        (0..3).all(|i| {
            between_a[i].abs() <= reach_a[i] + margin && between_b[i].abs() <= reach_b[i] + margin
        })
    }
}
