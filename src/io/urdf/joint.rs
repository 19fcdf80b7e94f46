use super::element::{Element, excerpt};
use super::origin::origin_of;
use super::{Location, UrdfError};
use crate::spatial::Pose;
use nalgebra::{UnitVector3, Vector3};

/// Connection of two links. The units are written for a revolute joint. For a prismatic joint, replace rad by m, and N m by N.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Motions that the joint allows.
    pub kind: JointKind,
    /// Name of the parent link.
    pub parent: String,
    /// Name of the child link.
    pub child: String,
    /// Pose of the joint frame in the frame of the parent. At position zero the joint frame is the frame of the child.
    pub origin: Pose,
    /// Limits, or `None` if the file has no `<limit>`.
    pub limit: Option<Limit>,
    /// Viscous damping (N m s/rad). Zero if the file has no damping.
    pub damping: f64,
    /// Coulomb friction (N m). Zero if the file has no friction.
    pub friction: f64,
    /// Dependence on another joint.
    pub mimic: Option<Mimic>,
    /// Place of the joint in the file.
    pub at: Location,
}

/// Motions that a [`Joint`] allows. Axes are in the joint frame. The default is the x axis.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum JointKind {
    /// Rotation about an axis, within limits.
    Revolute(UnitVector3<f64>),
    /// Rotation about an axis, without limits.
    Continuous(UnitVector3<f64>),
    /// Translation along an axis.
    Prismatic(UnitVector3<f64>),
    /// No motion.
    Fixed,
    /// All motions.
    Floating,
    /// Motion in the plane with this normal.
    Planar(UnitVector3<f64>),
}

/// Limits of a [`Joint`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Limit {
    /// Lower and upper position (rad). `None` if the file has neither position. If the file has only one position, the other position is
    /// zero.
    pub range: Option<[f64; 2]>,
    /// Largest torque of the actuator (N m), or `None` if the file has no effort.
    pub effort: Option<f64>,
    /// Largest velocity (rad/s), or `None` if the file has no velocity.
    pub velocity: Option<f64>,
}

/// Dependence of a joint on another joint: position = multiplier · position of the other joint + offset.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Mimic {
    /// Name of the other joint.
    pub joint: String,
    /// Multiplier. 1 if the file has no multiplier.
    pub multiplier: f64,
    /// Offset (rad). Zero if the file has no offset.
    pub offset: f64,
}

impl JointKind {
    /// Axis or normal, or `None` for a fixed or floating joint.
    #[must_use]
    pub fn axis(&self) -> Option<UnitVector3<f64>> {
        match self {
            Self::Revolute(axis)
            | Self::Continuous(axis)
            | Self::Prismatic(axis)
            | Self::Planar(axis) => Some(*axis),
            Self::Fixed | Self::Floating => None,
        }
    }

    /// Whether the joint has one degree of freedom.
    pub(super) fn is_scalar(&self) -> bool {
        matches!(
            self,
            Self::Revolute(_) | Self::Continuous(_) | Self::Prismatic(_)
        )
    }

    /// Name of the type in URDF files.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Revolute(_) => "revolute",
            Self::Continuous(_) => "continuous",
            Self::Prismatic(_) => "prismatic",
            Self::Fixed => "fixed",
            Self::Floating => "floating",
            Self::Planar(_) => "planar",
        }
    }
}

impl Joint {
    pub(super) fn of(element: Element) -> Result<Self, UrdfError> {
        let name = element.name_in("name")?.to_owned();
        let link_in = |tag, expected| -> Result<String, UrdfError> {
            let link = element.required_child(tag, expected)?.name_in("link")?;
            Ok(link.to_owned())
        };
        let (damping, friction) = match element.child("dynamics")? {
            None => (0.0, 0.0),
            Some(dynamics) => (
                coefficient(dynamics, "damping")?,
                coefficient(dynamics, "friction")?,
            ),
        };
        Ok(Self {
            name,
            kind: kind_of(element)?,
            parent: link_in("parent", "<parent>")?,
            child: link_in("child", "<child>")?,
            origin: origin_of(element)?,
            limit: element.child("limit")?.map(limit_of).transpose()?,
            damping,
            friction,
            mimic: element.child("mimic")?.map(mimic_of).transpose()?,
            at: element.location(),
        })
    }
}

fn kind_of(joint: Element) -> Result<JointKind, UrdfError> {
    let axis = || axis_of(joint);
    Ok(match joint.required_attribute("type")? {
        "revolute" => JointKind::Revolute(axis()?),
        "continuous" => JointKind::Continuous(axis()?),
        "prismatic" => JointKind::Prismatic(axis()?),
        "fixed" => JointKind::Fixed,
        "floating" => JointKind::Floating,
        "planar" => JointKind::Planar(axis()?),
        found => {
            return Err(UrdfError::UnknownJointType {
                at: joint.location(),
                found: excerpt(found),
            });
        }
    })
}

fn axis_of(joint: Element) -> Result<UnitVector3<f64>, UrdfError> {
    match joint.child("axis")? {
        None => Ok(Vector3::x_axis()),
        Some(axis) => axis.direction("xyz", axis.required_numbers("xyz")?),
    }
}

fn limit_of(element: Element) -> Result<Limit, UrdfError> {
    let range = match (element.bound("lower")?, element.bound("upper")?) {
        (None, None) => None,
        (lower, upper) => Some([lower.unwrap_or(0.0), upper.unwrap_or(0.0)]),
    };
    if let Some([lower, upper]) = range.filter(|[lower, upper]| lower > upper) {
        let at = element.location();
        return Err(UrdfError::ReversedLimits { at, lower, upper });
    }
    let magnitude = |attribute| -> Result<Option<f64>, UrdfError> {
        let bound = element.bound(attribute)?;
        bound
            .map(|bound| element.at_least_zero(attribute, bound))
            .transpose()
    };
    Ok(Limit {
        range,
        effort: magnitude("effort")?,
        velocity: magnitude("velocity")?,
    })
}

fn coefficient(dynamics: Element, attribute: &'static str) -> Result<f64, UrdfError> {
    let number = dynamics.number(attribute)?.unwrap_or(0.0);
    dynamics.at_least_zero(attribute, number)
}

fn mimic_of(element: Element) -> Result<Mimic, UrdfError> {
    Ok(Mimic {
        joint: element.name_in("joint")?.to_owned(),
        multiplier: element.number("multiplier")?.unwrap_or(1.0),
        offset: element.number("offset")?.unwrap_or(0.0),
    })
}
