//! Force of a contact on the first body, at the center of pressure.

use crate::bodies::single;
use crate::palette;
use hydroelastic::contact::ContactPolygon;
use hydroelastic::dynamics::Contact;
use nalgebra::Vector3;
use rerun::Arrows3D;

/// Length (m) of the arrow of a force of 1 N, and radius (m) of all arrows.
const LENGTH: f64 = 3e-3;
const RADIUS: f32 = 6e-3;

/// Returns an arrow, or no arrow without contact.
pub fn arrow(contact: Option<&Contact>) -> Arrows3D {
    let at_center = contact.and_then(|contact| {
        let center = contact.surface.center_of_pressure()?;
        Some((center, contact.wrench.on_a.force * LENGTH))
    });
    let vectors = at_center.iter().map(|(_, vector)| single(vector));
    Arrows3D::from_vectors(vectors)
        .with_origins(at_center.iter().map(|(center, _)| single(center)))
        .with_radii([RADIUS])
        .with_colors([palette::FORCE])
}

/// Returns the components (N) of a force along and across the mean normal: pressure with dissipation, and friction.
pub fn normal_and_friction(contact: Option<&Contact>) -> [f64; 2] {
    let Some(contact) = contact else {
        return [0.0; 2];
    };
    let (force, normal) = (contact.wrench.on_a.force, mean_normal(contact));
    let along = force.dot(&normal);
    [along, (force - normal * along).norm()]
}

/// Returns the direction of ∫ p n dA.
fn mean_normal(contact: &Contact) -> Vector3<f64> {
    let forces = contact.surface.polygons.iter().map(ContactPolygon::force);
    forces
        .sum::<Vector3<f64>>()
        .try_normalize(0.0)
        .unwrap_or_default()
}
