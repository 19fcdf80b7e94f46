use super::body::check_modulus;
use super::{BodyError, ContactBody, HalfSpace, RigidShape, Shape};
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, Twist};
use std::sync::LazyLock;

static RIGID_HALF_SPACE: LazyLock<HalfSpace> = LazyLock::new(HalfSpace::rigid);

/// What a compliant body may touch: another one, a rigid body, or a half-space, rigid or compliant.
#[derive(Debug, Clone, Copy)]
pub struct Partner<'a, T = f64> {
    shape: PartnerShape<'a>,
    pose: Pose<T>,
    /// What the extents of its cells are multiplied by: the modulus (Pa), or 1 if it is rigid.
    modulus: T,
}

/// The shape of a partner, by its kind.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PartnerShape<'a> {
    Compliant(&'a Shape),
    Rigid(&'a RigidShape),
    HalfSpace(&'a HalfSpace),
}

impl<'a, T: Scalar> From<ContactBody<'a, T>> for Partner<'a, T> {
    fn from(body: ContactBody<'a, T>) -> Self {
        let shape = PartnerShape::Compliant(body.shape());
        Self::from_valid(shape, *body.pose(), body.modulus())
    }
}

impl<'a, T: Scalar> Partner<'a, T> {
    /// A body that does not give way, from the pose of its frame in the world.
    ///
    /// # Errors
    /// If the pose is not finite or its rotation not orthonormal.
    pub fn rigid(shape: &'a RigidShape, pose: Pose<T>) -> Result<Self, BodyError> {
        Self::new(PartnerShape::Rigid(shape), pose, lift(1.0))
    }

    /// A half-space that does not give way: everything below the plane z = 0 of a frame, from the pose of this in the world.
    ///
    /// # Errors
    /// As [`Self::rigid`].
    pub fn rigid_half_space(pose: Pose<T>) -> Result<Self, BodyError> {
        Self::new(PartnerShape::HalfSpace(&RIGID_HALF_SPACE), pose, lift(1.0))
    }

    /// A half-space with a soft layer: its pressure is the hydroelastic modulus (Pa) times depth over thickness. One without a
    /// layer is rigid, whatever the modulus.
    ///
    /// # Errors
    /// If the pose is not finite, its rotation not orthonormal, or the modulus of a soft layer not positive, or so large that
    /// the pressure rises by more than 1e153 Pa/m.
    pub fn half_space(shape: &'a HalfSpace, pose: Pose<T>, modulus: T) -> Result<Self, BodyError> {
        Self::new(PartnerShape::HalfSpace(shape), pose, modulus)
    }

    fn new(shape: PartnerShape<'a>, pose: Pose<T>, modulus: T) -> Result<Self, BodyError> {
        let pose = pose.checked()?;
        if !shape.is_rigid() {
            check_modulus(real_part(modulus), shape.steepest())?;
        }
        Ok(Self::from_valid(shape, pose, modulus))
    }

    /// From a pose and a modulus that were checked where they came in.
    #[inline]
    pub(crate) fn from_valid(shape: PartnerShape<'a>, pose: Pose<T>, modulus: T) -> Self {
        let modulus = if shape.is_rigid() { lift(1.0) } else { modulus };
        Self {
            shape,
            pose,
            modulus,
        }
    }

    /// Pose of its frame in the world.
    #[must_use]
    pub fn pose(&self) -> &Pose<T> {
        &self.pose
    }

    /// Hydroelastic modulus (Pa); none if it is rigid.
    #[must_use]
    pub fn modulus(&self) -> Option<T> {
        (!self.shape.is_rigid()).then_some(self.modulus)
    }

    /// Its shape, if it is a compliant body with a mesh.
    #[must_use]
    pub fn shape(&self) -> Option<&'a Shape> {
        match self.shape {
            PartnerShape::Compliant(shape) => Some(shape),
            PartnerShape::Rigid(_) | PartnerShape::HalfSpace(_) => None,
        }
    }

    /// Its shape, if it is a rigid body with a surface.
    #[must_use]
    pub fn rigid_shape(&self) -> Option<&'a RigidShape> {
        match self.shape {
            PartnerShape::Rigid(shape) => Some(shape),
            PartnerShape::Compliant(_) | PartnerShape::HalfSpace(_) => None,
        }
    }

    /// The half-space, if it is one.
    #[must_use]
    pub fn half_space_shape(&self) -> Option<&'a HalfSpace> {
        match self.shape {
            PartnerShape::HalfSpace(half_space) => Some(half_space),
            PartnerShape::Compliant(_) | PartnerShape::Rigid(_) => None,
        }
    }

    /// The partner as a compliant body with a mesh, if it is one.
    #[must_use]
    pub fn body(&self) -> Option<ContactBody<'a, T>> {
        let shape = self.shape()?;
        Some(ContactBody::from_valid(shape, self.pose, self.modulus))
    }

    /// Its shape, whatever its kind.
    pub(crate) fn partner_shape(&self) -> PartnerShape<'a> {
        self.shape
    }

    /// What the extents of its cells are multiplied by in the field that meets A's: the modulus (Pa), or 1 if it is rigid.
    pub(crate) fn scale(&self) -> T {
        self.modulus
    }

    /// The same shape elsewhere, in a scalar of its own, with another modulus (Pa), which a rigid one ignores.
    ///
    /// # Errors
    /// If the pose is not finite, its rotation not orthonormal, or the modulus of a compliant one not positive, or so large
    /// that the pressure rises by more than 1e153 Pa/m.
    pub fn at<U: Scalar>(&self, pose: Pose<U>, modulus: U) -> Result<Partner<'a, U>, BodyError> {
        Partner::new(self.shape, pose, modulus)
    }

    /// The partner with another valid pose, and another modulus if it has one.
    pub(crate) fn with<U: Scalar>(
        &self,
        pose: Pose<U>,
        modulus: impl FnOnce(T) -> U,
    ) -> Partner<'a, U> {
        Partner::from_valid(self.shape, pose, modulus(self.modulus))
    }
}

impl<'a> Partner<'a> {
    /// The partner after a motion by a twist (see [`Pose::moved_by`]) and a change of its modulus (Pa), both with real part
    /// zero: a seed for derivatives, which leaves the values as they are.
    pub(crate) fn perturbed<T: Scalar>(&self, twist: &Twist<T>, change: T) -> Partner<'a, T> {
        self.with(Pose::lifted(&self.pose).moved_by(twist), |modulus| {
            lift::<T>(modulus) + change
        })
    }
}

impl<'a> PartnerShape<'a> {
    /// Whether it does not give way: a rigid body, or a half-space without a layer.
    pub fn is_rigid(self) -> bool {
        match self {
            Self::Compliant(_) => false,
            Self::Rigid(_) => true,
            Self::HalfSpace(half_space) => half_space.thickness().is_none(),
        }
    }

    /// The tetrahedra of a mesh, the cells behind the triangles of a rigid body, or the one cell of a half-space. The field of
    /// a cell makes the plane; its faces bound the polygon, except its zero faces.
    pub fn cells(self) -> &'a [FieldTet] {
        match self {
            Self::Compliant(shape) => shape.field().tets(),
            Self::Rigid(shape) => shape.cells(),
            Self::HalfSpace(half_space) => half_space.cell(),
        }
    }

    /// How many vertices its mesh or surface has, and how many extents.
    pub fn number_counts(self) -> (usize, usize) {
        match self {
            Self::Compliant(shape) => {
                let count = shape.field().mesh().vertex_count();
                (count, count)
            }
            Self::Rigid(shape) => (shape.surface().vertices().len(), 0),
            Self::HalfSpace(_) => (0, 0),
        }
    }

    /// The vertices at the corners of a cell; none at an apex behind a triangle.
    pub fn corner_vertices(self, cell: usize) -> [Option<usize>; 4] {
        match self {
            Self::Compliant(shape) => shape.field().mesh().tets()[cell].map(Some),
            Self::Rigid(shape) => {
                let [a, b, c] = shape.vertices_of(cell);
                [Some(a), Some(b), Some(c), None]
            }
            Self::HalfSpace(_) => [None; 4],
        }
    }

    /// For each cell those beyond its faces, by the opposite corner, or [`OUTSIDE`](crate::mesh::OUTSIDE); empty for a half-space.
    pub fn neighbors(self) -> &'a [[u32; 4]] {
        match self {
            Self::Compliant(shape) => shape.field().mesh().neighbors(),
            Self::Rigid(shape) => shape.neighbors(),
            Self::HalfSpace(_) => &[],
        }
    }

    /// Largest norm of the gradient of the extent in its cells (1/m); 1 if it is rigid, whose extent is the depth.
    pub fn steepest(self) -> f64 {
        match self {
            Self::Compliant(shape) => shape.field().steepest(),
            Self::Rigid(_) => 1.0,
            Self::HalfSpace(half_space) => half_space.cell()[0].steepness,
        }
    }

    /// How far (m) it reaches from the origin of its frame, as far as the contact with A is concerned.
    pub fn reach(self, pose_ab: &Pose<f64>) -> f64 {
        match self {
            Self::Compliant(shape) => shape.field().reach(),
            Self::Rigid(shape) => shape.surface().reach(),
            // As far as A is from that origin; at any distance, squares of which may be none.
            Self::HalfSpace(_) => {
                let (way, largest) = (pose_ab.translation(), pose_ab.translation().amax());
                if largest == 0.0 {
                    0.0
                } else {
                    (way / largest).norm() * largest
                }
            }
        }
    }
}
