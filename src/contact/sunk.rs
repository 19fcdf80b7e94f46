//! Detection of bodies that have passed so far into each other that contact no longer keeps them apart.

use super::ContactPair;
use crate::contact_shape::{PartnerShape, Shape};
use crate::mesh::TriangleSurface;
use crate::scalar::Scalar;
use nalgebra::Vector3;

/// Extents within this fraction of the largest are peaks of the field.
const PEAK: f64 = 1e-9;

/// A line crosses a triangle if it misses the triangle by less than this fraction of its area. Rounding then leaves no gap between
/// neighboring triangles.
const GAP: f64 = 1e-9;

impl<T: Scalar> ContactPair<'_, T> {
    /// Returns whether the bodies have passed so far into each other that contact may no longer push them apart. There are four cases:
    ///
    /// - The bodies overlap without a contact surface, so there is no force. The work done on the contact has exceeded the energy
    ///   that the pressure field of one body can store: the integral of its pressure over its volume.
    /// - One of the bodies, with a mesh or a surface, is wholly inside the other.
    /// - Each of two compliant bodies contains a point of the other's highest pressure. The force will soon push the bodies further
    ///   in instead of apart.
    /// - A rigid body contains a point P of the compliant body's highest pressure. The compliant
    ///   body contains the middle of the chord of the rigid body through P along the contact force.
    ///
    /// A rod or a plate that pierces a body away from the points of highest pressure is not reported.
    ///
    /// Takes as long as [`Self::potential_energy`] if there is no contact surface.
    #[must_use]
    pub fn has_sunk_through(&self) -> bool {
        let real = self.real();
        let source = real.source();
        if real.cut_surface().is_empty() {
            return source.has_energy();
        }
        let (a, pose_ab) = (source.pair.shape_a, &source.pair.pose_ab);
        let in_a = |v: &Vector3<f64>| a.tet_at(&pose_ab.transformed_point(v)).is_some();
        match source.pair.shape_b {
            PartnerShape::HalfSpace(_) => false,
            PartnerShape::Rigid(b) => {
                let (surface, pose_ba) = (b.surface(), pose_ab.inverse());
                let force = pose_ba.rotation() * real.wrench().on_a.force;
                let direction = force.try_normalize(0.0).unwrap_or_else(Vector3::z);
                let has_middle_in_a = |peak: &Vector3<f64>| {
                    let peak = pose_ba.transformed_point(peak);
                    middle_of_chord(surface, &peak, &direction).is_some_and(|middle| in_a(&middle))
                };
                surface.vertices().iter().all(in_a) || peaks(a).any(has_middle_in_a)
            }
            PartnerShape::Compliant(b) => {
                let pose_ba = pose_ab.inverse();
                let in_b = |v: &Vector3<f64>| b.tet_at(&pose_ba.transformed_point(v)).is_some();
                b.field().mesh().vertices().iter().all(in_a)
                    || a.field().mesh().vertices().iter().all(in_b)
                    || peaks(a).any(in_b) && peaks(b).any(in_a)
            }
        }
    }
}

/// Returns the points of a shape's highest pressure, in the body frame.
fn peaks(shape: &Shape) -> impl Iterator<Item = &Vector3<f64>> {
    let field = shape.field();
    let highest = field.extents().iter().copied().fold(0.0, f64::max);
    let vertices = field.mesh().vertices().iter().zip(field.extents());
    let peaks = vertices.filter(move |(_, extent)| **extent >= highest * (1.0 - PEAK));
    peaks.map(|(vertex, _)| vertex)
}

/// Returns the middle of the chord through a point: the part of a line around the point that is inside a surface. Returns `None` if the
/// point is outside.
fn middle_of_chord(
    surface: &TriangleSurface,
    point: &Vector3<f64>,
    direction: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    // The distance to the nearest triangle ahead and behind, and whether the point is on its inner side.
    let mut ends = [(f64::INFINITY, false); 2];
    for triangle in 0..surface.triangles().len() {
        let [a, b, c] = surface.corners(triangle).map(|corner| corner - point);
        let areas = [b.cross(&c), c.cross(&a), a.cross(&b)].map(|area| area.dot(direction));
        let area: f64 = areas.iter().sum();
        let distance = a.dot(&b.cross(&c)) / area;
        let end = &mut ends[usize::from(distance < 0.0)];
        if areas.iter().all(|part| part / area >= -GAP) && distance.abs() < end.0 {
            *end = (distance.abs(), (area > 0.0) == (distance >= 0.0));
        }
    }
    let [(ahead, is_inside_ahead), (behind, is_inside_behind)] = ends;
    let middle = point + direction * ((ahead - behind) / 2.0);
    (is_inside_ahead && is_inside_behind).then_some(middle)
}
