//! The traction of the surface law on a contact polygon.

use super::area::{AreaMoments, LawOnPlane};
use crate::contact::SurfaceLaw;
use crate::contact::friction::LoadedSlip;
use crate::contact::plane::{Outline, PlanePolygon};

/// What the surface law adds to the pressure on a polygon.
pub(super) struct Traction<'p> {
    pub plane: &'p PlanePolygon<f64>,
    pub law: LawOnPlane<f64>,
    /// The part of the polygon where ψ is positive, and whether that is not all of it.
    pub pressed: &'p Outline<f64>,
    pub is_clamped: bool,
    pub slip: LoadedSlip<'p>,
}

impl Traction<'_> {
    /// Hands on that of a law on a polygon.
    pub fn on<O>(
        plane: &PlanePolygon<f64>,
        law: &SurfaceLaw,
        value: impl FnOnce(&Traction<'_>) -> O,
    ) -> O {
        let numbers = [law.friction, law.dissipation];
        let on_plane = LawOnPlane::of(numbers, plane.pressure, plane.motion, [0.0, 1.0]);
        let damping = on_plane.damping;
        let part = plane.outline.cut(&damping);
        let pressed = part.as_ref().unwrap_or(&plane.outline);
        let slip = LoadedSlip::on(
            pressed.corners(),
            plane.motion.slip_by(law),
            &plane.pressure,
            &damping,
        );
        value(&Traction {
            plane,
            law: on_plane,
            pressed,
            is_clamped: part.is_some(),
            slip,
        })
    }
}

impl AreaMoments<f64> {
    pub fn on(traction: &Traction) -> Self {
        let whole = traction
            .is_clamped
            .then(|| traction.plane.outline.moments());
        let (slip, pressed) = (traction.slip.moments(), traction.pressed.moments());
        Self::of(&traction.law, &slip, &pressed, whole.as_ref())
    }
}
