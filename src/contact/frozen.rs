use super::jacobian::RelativeJacobian;
use super::polygon::{CutSurface, PartialSum, PolygonSource};
use super::surface_law::RelativeMotion;
use super::traction_rates::{AddedByLaw, FrozenPolygon};
use super::{ContactPair, ContactWrench, LinearisedContact, SurfaceLaw};
use crate::spatial::{Twist, Wrench};
use nalgebra::{SMatrix, Vector6};

/// A contact of moving bodies at one pose, with a model of it nearby: what an implicit time step iterates on between two
/// evaluations of the contact.
///
/// The wrench is exact, and so are the elastic derivatives. What dissipation and friction add is integrated, nearby, over the
/// contact polygons as they are, with the pressure that the fields of the bodies have there: cheap to evaluate anew as
/// velocities change, and exact in what makes friction hard, that its direction turns.
#[derive(Clone)]
pub(crate) struct FrozenContact {
    /// The exact wrenches, in the world, about the origins of the bodies.
    pub wrench: ContactWrench,
    /// The elastic wrenches by the poses of A and B: see [`LinearisedContact::by_poses`].
    pub by_poses: SMatrix<f64, 12, 12>,
    /// What the law adds as it is.
    pub added: AddedByLaw,
    /// None if the bodies are elastic.
    law: Option<SurfaceLaw>,
    polygons: Vec<FrozenPolygon>,
}

struct FrozenSum {
    wrench: Wrench,
    elastic: RelativeJacobian<f64>,
    polygons: Vec<FrozenPolygon>,
}

impl PartialSum for FrozenSum {
    fn empty() -> Self {
        Self {
            wrench: Wrench::zero(),
            elastic: RelativeJacobian::empty(),
            polygons: Vec::new(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.wrench += next.wrench;
        self.elastic.merge(next.elastic);
        self.polygons.extend(next.polygons);
    }
}

impl ContactPair<'_> {
    /// The contact as it is, with a model of it nearby: of moving bodies by a law, with arguments as of
    /// [`Self::wrench_in_motion`], or, without one, of elastic ones. Takes little longer than the wrench. None if the bodies
    /// do not touch.
    pub(crate) fn frozen(
        &self,
        moving: Option<(&SurfaceLaw, [Twist; 2])>,
    ) -> Option<FrozenContact> {
        let moving = moving.filter(|(law, _)| !law.is_elastic());
        let moving = moving.map(|(law, twists)| (law, RelativeMotion::of(self, twists)));
        let surface = PolygonSource::of(self).for_values(self.search());
        if surface.found.is_empty() {
            return None;
        }
        let sum = surface.frozen(moving.as_ref().map(|(_, motion)| motion));
        let mut elastic = sum.elastic.linearisation(self.moduli());
        let mut added = AddedByLaw::nothing();
        if let Some((law, motion)) = &moving {
            for polygon in &sum.polygons {
                polygon.add_to(&mut added, law, (&Vector6::zeros(), motion));
            }
        }
        elastic.wrench = sum.wrench.to_vector() + added.wrench;
        let LinearisedContact {
            wrench, by_poses, ..
        } = elastic.in_world(self, None);
        Some(FrozenContact {
            wrench,
            by_poses,
            added,
            law: moving.map(|(law, _)| *law),
            polygons: sum.polygons,
        })
    }
}

impl CutSurface<'_, f64> {
    fn frozen(&self, motion: Option<&RelativeMotion<f64>>) -> FrozenSum {
        self.sum(|sum: &mut FrozenSum, polygon| {
            polygon.add_to(&mut sum.elastic);
            sum.wrench += polygon.wrench();
            let frozen = motion.and_then(|motion| FrozenPolygon::of(polygon, motion));
            sum.polygons.extend(frozen);
        })
    }
}

impl FrozenContact {
    /// Whether dissipation and friction add anything.
    pub fn rubs(&self) -> bool {
        self.law.is_some()
    }

    /// What dissipation and friction add after a motion of B (angular, linear, of the point at A's origin) with a velocity
    /// of A relative to B (angular, linear at A's origin), all in A's axes.
    pub fn added(&self, motion: &Vector6<f64>, twist: &Vector6<f64>) -> AddedByLaw {
        let mut sum = AddedByLaw::nothing();
        let Twist { angular, linear } = Twist::from_vector(twist);
        let velocity = RelativeMotion {
            angular,
            at_origin: linear,
        };
        if let Some(law) = &self.law {
            for polygon in &self.polygons {
                polygon.add_to(&mut sum, law, (motion, &velocity));
            }
        }
        sum
    }
}
