//! Detection of bodies that have passed so far into each other that contact no longer keeps them apart.

use super::ContactPair;
use super::polygon::PolygonSource;
use crate::broad_phase::Shape;
use crate::narrow_phase::PartnerShape;
use crate::scalar::Scalar;
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Extents within this fraction of the largest are peaks of the field.
const PEAK: f64 = 1e-9;

impl<T: Scalar> ContactPair<'_, T> {
    /// Whether the bodies have passed so far into each other that contact may no longer push them apart. There are three cases:
    ///
    /// - The bodies overlap without a contact surface, so there is no force. The work done on the contact has exceeded the energy
    ///   that the pressure field of one body can store: the integral of its pressure over its volume.
    /// - One of the bodies, with a mesh or a surface, is wholly inside the other.
    /// - Each of two compliant bodies contains a point of the other's highest pressure. The force will soon push the bodies further
    ///   in instead of apart.
    ///
    /// Takes as long as [`Self::potential_energy`] if there is no contact surface.
    #[must_use]
    pub fn has_sunk_through(&self) -> bool {
        let real = self.real();
        let source = PolygonSource::of(&real);
        if real.cut_surface().is_empty() {
            return source.has_energy();
        }
        let (a, pose_ab) = (source.pair.shape_a, &source.pair.pose_ab);
        let in_a = |vertex: &Vector3<f64>| contains(a, &pose_ab.transformed_point(vertex));
        match source.pair.shape_b {
            PartnerShape::HalfSpace(_) => false,
            PartnerShape::Rigid(b) => b.surface().vertices().iter().all(in_a),
            PartnerShape::Compliant(b) => {
                let pose_ba = pose_ab.inverse();
                let in_b = |v: &Vector3<f64>| contains(b, &pose_ba.transformed_point(v));
                b.field().mesh().vertices().iter().all(in_a)
                    || a.field().mesh().vertices().iter().all(in_b)
                    || has_peak_in(a, b, &pose_ba) && has_peak_in(b, a, pose_ab)
            }
        }
    }
}

/// Whether a shape contains a point, given in the body frame.
fn contains(shape: &Shape, point: &Vector3<f64>) -> bool {
    let (tets, mut is_inside) = (shape.field().tets(), false);
    shape.tree().visit_at(point, 0.0, |tet| {
        let mut coordinates = tets[tet].barycentric.iter();
        is_inside |= coordinates.all(|coordinate| coordinate.at(point) >= 0.0);
    });
    is_inside
}

/// Whether a point of a shape's highest pressure is in another shape. `pose` maps the frame of the shape to the frame of the other.
fn has_peak_in(shape: &Shape, other: &Shape, pose: &Pose) -> bool {
    let field = shape.field();
    let highest = field.extents().iter().copied().fold(0.0, f64::max);
    let mut vertices = field.mesh().vertices().iter().zip(field.extents());
    vertices.any(|(vertex, &extent)| {
        extent >= highest * (1.0 - PEAK) && contains(other, &pose.transformed_point(vertex))
    })
}
