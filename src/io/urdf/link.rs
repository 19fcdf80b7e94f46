use super::collision::Collision;
use super::element::Element;
use super::inertial::inertial_of;
use super::{Location, UrdfError, UrdfWarning};
use crate::spatial::MassProperties;

/// Rigid part of a robot.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Link {
    /// Name.
    pub name: String,
    /// Mass, center of mass and inertia, in the link frame. `None` if the file has no `<inertial>`. The mass may be zero.
    pub inertial: Option<MassProperties>,
    /// Shapes for contact.
    pub collisions: Vec<Collision>,
    /// Location of the link in the file.
    pub at: Location,
}

impl Link {
    pub(super) fn of(element: Element) -> Result<(Self, Option<UrdfWarning>), UrdfError> {
        let name = element.name_in("name")?.to_owned();
        let inertial = element.child("inertial")?.map(inertial_of).transpose()?;
        let (inertial, warning) = inertial.unzip();
        let collisions = element.elements_named("collision").map(Collision::of);
        let link = Self {
            name,
            inertial,
            collisions: collisions.collect::<Result<_, _>>()?,
            at: element.location(),
        };
        Ok((link, warning.flatten()))
    }
}
