//! The traction of the surface law on a contact polygon.

use super::area::{AreaMoments, LawOnPlane};
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::Outline;
use crate::contact::plane_motion::PlaneMotion;
use crate::contact::plane_polygon::PlanePolygon;
use crate::friction::FrictionIntegrand;

/// What the surface law adds to the pressure on a polygon.
pub(super) struct Traction<'p> {
    pub polygon: &'p PlanePolygon<f64>,
    pub law: LawOnPlane<f64>,
    /// The part of the polygon where ψ is positive, and whether that is not all of it.
    pub pressed: &'p Outline<f64>,
    pub is_clamped: bool,
    pub slip: FrictionIntegrand<'p>,
}

impl Traction<'_> {
    /// Calls `value` with the traction of a law on a polygon of moving bodies, and returns its result.
    pub fn on<O>(
        polygon: &PlanePolygon<f64>,
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
        value: impl FnOnce(&Traction<'_>) -> O,
    ) -> O {
        let PlanePolygon { plane, outline, .. } = polygon;
        let numbers = [law.friction, law.dissipation];
        let motion = PlaneMotion::of(motion, plane);
        let on_plane = LawOnPlane::of(numbers, plane.pressure, motion, [0.0, 1.0]);
        let damping = on_plane.damping;
        let part = outline.cut(&damping);
        let pressed = part.as_ref().unwrap_or(outline);
        let slip = FrictionIntegrand::on(
            pressed.corners(),
            motion.slip_by(law),
            &plane.pressure,
            &damping,
        );
        value(&Traction {
            polygon,
            law: on_plane,
            pressed,
            is_clamped: part.is_some(),
            slip,
        })
    }
}

impl AreaMoments<f64> {
    pub fn on(traction: &Traction) -> Self {
        let (slip, all) = (traction.slip.moments(), traction.polygon.moments());
        if traction.is_clamped {
            Self::of(
                &traction.law,
                &slip,
                &traction.pressed.moments(),
                Some(&all),
            )
        } else {
            Self::of(&traction.law, &slip, &all, None)
        }
    }
}
