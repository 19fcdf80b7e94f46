use super::Feature;
use super::nearest::{Nearest, TOUCHING};
use super::separation::Separation;
use crate::contact::ContactPair;
use crate::contact_shape::PartnerShape;
use crate::scalar::{Scalar, change, lift, lift_vector};
use nalgebra::Vector3;

/// Signed distance between two bodies: the smallest distance between their surfaces, or minus the depth if they overlap.
///
/// The pressure fields select points of the overlap: the corners of the contact polygons, where both pressures are equal, and the vertices
/// inside the other body at which the pressure of their own body is not larger. The depth of a point is its distance to the surface of A plus
/// its distance to the surface of B. The depth of the bodies is the largest depth of these points. For a ball in a half-space, it is the
/// geometric depth. The depth never exceeds the shortest displacement that separates the bodies. Overlaps without contact polygons
/// and without such vertices have the clearance 0.
///
/// The clearance is continuous in the poses. Its derivative changes where the features change: at ties, such as parallel faces, and where
/// the bodies begin to overlap. At a tie, the derivative is the derivative for one pair of closest features.
///
/// If the bodies touch exactly, the derivative is the mean of the derivatives of the distances of all closest features that tie. Overlaps
/// below 1.2e-10 of the size of the bodies are round-off and count as touch. The depth may begin with a smaller slope than the distance. If
/// edges are parallel, the mean may therefore be outside of the interval between the one-sided derivatives.
///
/// ```
/// use hydroelastic::contact::{ContactBody, ContactPair, Feature, Partner, Shape};
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let ball = Shape::new(shapes::icosphere(0.1, 3)?);
/// let floor = Partner::rigid_half_space(Pose::identity())?;
/// let clearance_at = |z: f64| {
///     let ball = ContactBody::new(&ball, Pose::from_translation(vector![0.0, 0.0, z]), 1e5)?;
///     Ok::<_, hydroelastic::contact::BodyError>(ContactPair::new(ball, floor).clearance())
/// };
/// let apart = clearance_at(0.3)?;
/// assert!((apart.distance - 0.2).abs() < 1e-12);
/// assert_eq!(apart.features[1], Feature::Plane);
/// assert!((clearance_at(0.09)?.distance + 0.01).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Clearance<T = f64> {
    /// Distance (m) between the boundary surfaces, or minus the depth (m) if the bodies overlap.
    pub distance: T,
    /// Closest points of A and of B (m) in the world. If the bodies overlap, both are the deepest point.
    pub points: [Vector3<T>; 2],
    /// Features of A and of B that contain these points.
    pub features: [Feature; 2],
}

impl<T: Scalar> ContactPair<'_, T> {
    /// Returns the signed distance between the bodies, with the closest points. Dissipation, friction and twists have no effect.
    ///
    /// The distance has derivatives also if the bodies are apart. The closest features depend only on the real parts of the poses. If a
    /// body has no pressure where the bodies overlap, the clearance is 0.
    #[must_use]
    pub fn clearance(&self) -> Clearance<T> {
        let real = self.real();
        let nearest = || Nearest::of(&real.source().pair);
        let Some((pair, place, depth)) = real.deepest() else {
            return self.mean_separation(&nearest());
        };
        if depth <= TOUCHING * real.source().pair.margin() {
            let nearest = nearest();
            if !nearest.are_crossing {
                return self.mean_separation(&nearest);
            }
        }
        let (depth, point) = self.depth_at(pair, &place);
        self.in_world(-depth, [point; 2], place.features(pair.shape_b))
    }

    /// Returns the clearance of bodies that do not overlap by more than round-off, from their closest features. The distance
    /// and its derivatives are averaged over the features that tie.
    fn mean_separation(&self, nearest: &Nearest) -> Clearance<T> {
        let (mut clearance, mut count) = (self.separation(nearest, nearest.features[0]), 1.0);
        for features in &nearest.features[1..] {
            clearance.distance += self.separation(nearest, *features).distance;
            count += 1.0;
        }
        clearance.distance /= lift::<T>(count);
        clearance
    }

    /// Returns the clearance from one pair of features.
    fn separation(&self, nearest: &Nearest, features: [Feature; 2]) -> Clearance<T> {
        let pose_ab = self.source().pose_ab;
        let [feature_a, feature_b] = features;
        let shape_b = self.b().partner_shape();
        let a = feature_a.points(PartnerShape::Compliant(self.a().shape()));
        let a: Vec<_> = a.iter().map(lift_vector).collect();
        let separation = if feature_b == Feature::Plane {
            let above = Separation::above_plane(pose_ab.inverse().transformed_point(&a[0]));
            Separation {
                points: above.points.map(|point| pose_ab.transformed_point(&point)),
                ..above
            }
        } else {
            let b = feature_b.points(shape_b);
            let b: Vec<_> = b.iter().map(|p| pose_ab.transformed_constant(p)).collect();
            Separation::between(&a, &b, nearest.touching.as_ref())
        };
        let distance = if nearest.are_crossing {
            change(separation.distance)
        } else {
            separation.distance
        };
        self.in_world(distance, separation.points, features)
    }

    /// Creates a clearance from points in A's frame.
    fn in_world(
        &self,
        distance: T,
        points: [Vector3<T>; 2],
        features: [Feature; 2],
    ) -> Clearance<T> {
        Clearance {
            distance,
            points: points.map(|point| self.a().pose().transformed_point(&point)),
            features,
        }
    }
}
