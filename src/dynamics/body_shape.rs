use super::{Mass, WorldError};
use crate::contact::{HalfSpace, PartnerShape, RigidShape, Shape};
use crate::geometry::Aabb;
use crate::mesh::DensityError;
use crate::spatial::{MassGradient, MassProperties, Pose};
use nalgebra::Vector3;
use std::sync::Arc;

/// Shape of a body for contact. Each of the shapes, and an `Arc` of it, converts into this type with `into()`. Bodies can share an `Arc`.
///
/// Two bodies can be in contact if at least one of them is compliant and has a mesh. Rigid bodies and half-spaces have no contact with each
/// other. A body without a shape has no contact.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum BodyShape {
    /// Compliant body: a tetrahedral mesh with a pressure field.
    Compliant(Arc<Shape>),
    /// Rigid body: a closed surface.
    Rigid(Arc<RigidShape>),
    /// Half-space below a plane, rigid or with a soft layer.
    HalfSpace(Arc<HalfSpace>),
    /// No shape. The material of the body has no effect.
    None,
}

impl BodyShape {
    /// Whether the shape is a rigid body, or a half-space without a soft layer. The material of a
    /// rigid body or rigid half-space has no modulus.
    #[must_use]
    pub fn is_rigid(&self) -> bool {
        self.partner().is_some_and(PartnerShape::is_rigid)
    }

    /// The shape of a compliant body with a mesh.
    #[must_use]
    pub fn compliant(&self) -> Option<&Arc<Shape>> {
        match self {
            Self::Compliant(shape) => Some(shape),
            Self::Rigid(_) | Self::HalfSpace(_) | Self::None => None,
        }
    }

    /// Bounding box in the body frame, or `None` for a half-space, which is unbounded, and for a body without a shape.
    #[must_use]
    pub fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Compliant(shape) => Some(shape.bounds()),
            Self::Rigid(shape) => Some(shape.bounds()),
            Self::HalfSpace(_) | Self::None => None,
        }
    }

    /// Bounding box in the world frame, at a pose. The box of a body without a shape is the origin of the body frame.
    pub(super) fn bounds_at(&self, pose: &Pose) -> Aabb {
        if let Self::None = self {
            return Aabb::around([pose.translation()]);
        }
        let bounds = self.bounds();
        bounds.map_or(Aabb::EVERYWHERE, |bounds| bounds.posed(pose))
    }

    /// Shape as body B of a contact, or `None` for a body without a shape.
    pub(super) fn partner(&self) -> Option<PartnerShape<'_>> {
        match self {
            Self::Compliant(shape) => Some(PartnerShape::Compliant(shape)),
            Self::Rigid(shape) => Some(PartnerShape::Rigid(shape)),
            Self::HalfSpace(half_space) => Some(PartnerShape::HalfSpace(half_space)),
            Self::None => None,
        }
    }

    /// Mass properties of a dynamic body with this shape.
    ///
    /// # Errors
    /// - If no solid has the mass properties.
    /// - If the shape is a half-space, which has no mass.
    /// - If the mass is distributed over the volume, but the body has no shape.
    pub(super) fn mass_properties(
        &self,
        body: &str,
        mass: &Mass,
    ) -> Result<MassProperties, WorldError> {
        match self {
            Self::Compliant(shape) => {
                let mesh = shape.field().mesh();
                mass.properties(body, mesh.volume(), |density| mesh.mass_properties(density))
            }
            Self::Rigid(shape) => {
                let surface = shape.surface();
                mass.properties(body, surface.volume(), |density| {
                    surface.mass_properties(density)
                })
            }
            Self::HalfSpace(_) => Err(WorldError::Unbounded(body.to_owned())),
            Self::None => mass.without_volume(body),
        }
    }

    /// Volume (m³): infinity for a half-space, and zero for a body without a shape.
    pub(crate) fn volume(&self) -> f64 {
        match self {
            Self::Compliant(shape) => shape.field().mesh().volume(),
            Self::Rigid(shape) => shape.surface().volume(),
            Self::HalfSpace(_) => f64::INFINITY,
            Self::None => 0.0,
        }
    }

    /// Gradient with respect to the vertices, from the gradient with respect to the mass properties at a density (kg/m³).
    pub(crate) fn mass_gradient(
        &self,
        density: f64,
        gradient: &MassGradient,
    ) -> Result<Vec<Vector3<f64>>, DensityError> {
        match self {
            Self::Compliant(shape) => shape.field().mesh().mass_gradient(density, gradient),
            Self::Rigid(shape) => shape.surface().mass_gradient(density, gradient),
            Self::HalfSpace(_) | Self::None => Ok(Vec::new()),
        }
    }

    /// Whether both values share one allocation of a shape, or both have no shape.
    #[must_use]
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Compliant(a), Self::Compliant(b)) => Arc::ptr_eq(a, b),
            (Self::Rigid(a), Self::Rigid(b)) => Arc::ptr_eq(a, b),
            (Self::HalfSpace(a), Self::HalfSpace(b)) => Arc::ptr_eq(a, b),
            (Self::None, Self::None) => true,
            (Self::Compliant(_) | Self::Rigid(_) | Self::HalfSpace(_) | Self::None, _) => false,
        }
    }
}

impl From<Shape> for BodyShape {
    fn from(shape: Shape) -> Self {
        Self::Compliant(Arc::new(shape))
    }
}

impl From<Arc<Shape>> for BodyShape {
    fn from(shape: Arc<Shape>) -> Self {
        Self::Compliant(shape)
    }
}

impl From<RigidShape> for BodyShape {
    fn from(shape: RigidShape) -> Self {
        Self::Rigid(Arc::new(shape))
    }
}

impl From<Arc<RigidShape>> for BodyShape {
    fn from(shape: Arc<RigidShape>) -> Self {
        Self::Rigid(shape)
    }
}

impl From<HalfSpace> for BodyShape {
    fn from(shape: HalfSpace) -> Self {
        Self::HalfSpace(Arc::new(shape))
    }
}

impl From<Arc<HalfSpace>> for BodyShape {
    fn from(shape: Arc<HalfSpace>) -> Self {
        Self::HalfSpace(shape)
    }
}
