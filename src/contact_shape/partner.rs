use super::body::check_modulus;
use super::{BodyError, ContactBody, HalfSpace, RigidShape, Shape};
use crate::mesh::FieldTet;
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, Twist};
use std::sync::LazyLock;

static RIGID_HALF_SPACE: LazyLock<HalfSpace> = LazyLock::new(HalfSpace::rigid);

/// A body that a compliant body may touch: another compliant body, a rigid body, or a rigid or compliant half-space.
#[derive(Debug, Clone, Copy)]
pub struct Partner<'a, T = f64> {
    shape: PartnerShape<'a>,
    pose: Pose<T>,
    /// Factor from the extents of its cells to its field: the modulus (Pa), or 1 if the partner is rigid.
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
    /// Creates a rigid body from the pose of its frame in the world.
    ///
    /// # Errors
    /// Returns an error if the pose is not finite or its rotation is not orthonormal.
    pub fn rigid(shape: &'a RigidShape, pose: Pose<T>) -> Result<Self, BodyError> {
        Self::new(PartnerShape::Rigid(shape), pose, lift(1.0))
    }

    /// Creates a rigid half-space from the pose of its frame in the world. The half-space is z ≤ 0 of that frame.
    ///
    /// # Errors
    /// Returns the errors of [`Self::rigid`].
    pub fn rigid_half_space(pose: Pose<T>) -> Result<Self, BodyError> {
        Self::new(PartnerShape::HalfSpace(&RIGID_HALF_SPACE), pose, lift(1.0))
    }

    /// Creates a half-space with a soft layer. Its pressure is the hydroelastic modulus (Pa) times depth over
    /// thickness. A half-space without a layer is rigid and ignores the modulus.
    ///
    /// # Errors
    /// Returns an error if the pose is not finite or its rotation is not orthonormal. For a soft layer, also returns an
    /// error if the modulus is not positive and finite, or if the gradient of the pressure exceeds 1e153 Pa/m.
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

    /// Creates a partner from a pose and a modulus that have already been checked.
    #[inline]
    pub(crate) fn from_valid(shape: PartnerShape<'a>, pose: Pose<T>, modulus: T) -> Self {
        let modulus = if shape.is_rigid() { lift(1.0) } else { modulus };
        Self {
            shape,
            pose,
            modulus,
        }
    }

    /// Returns the pose of the partner's frame in the world.
    #[must_use]
    pub fn pose(&self) -> &Pose<T> {
        &self.pose
    }

    /// Returns the hydroelastic modulus (Pa), or `None` if the partner is rigid.
    #[must_use]
    pub fn modulus(&self) -> Option<T> {
        (!self.shape.is_rigid()).then_some(self.modulus)
    }

    /// Returns the shape if the partner is a compliant body with a mesh.
    #[must_use]
    pub fn shape(&self) -> Option<&'a Shape> {
        match self.shape {
            PartnerShape::Compliant(shape) => Some(shape),
            PartnerShape::Rigid(_) | PartnerShape::HalfSpace(_) => None,
        }
    }

    /// Returns the shape if the partner is a rigid body with a surface.
    #[must_use]
    pub fn rigid_shape(&self) -> Option<&'a RigidShape> {
        match self.shape {
            PartnerShape::Rigid(shape) => Some(shape),
            PartnerShape::Compliant(_) | PartnerShape::HalfSpace(_) => None,
        }
    }

    /// Returns the shape if the partner is a half-space.
    #[must_use]
    pub fn half_space_shape(&self) -> Option<&'a HalfSpace> {
        match self.shape {
            PartnerShape::HalfSpace(half_space) => Some(half_space),
            PartnerShape::Compliant(_) | PartnerShape::Rigid(_) => None,
        }
    }

    /// Returns the partner as a [`ContactBody`] if it is a compliant body with a mesh.
    #[must_use]
    pub fn body(&self) -> Option<ContactBody<'a, T>> {
        let shape = self.shape()?;
        Some(ContactBody::from_valid(shape, self.pose, self.modulus))
    }

    /// Returns the shape, of any kind.
    pub(crate) fn partner_shape(&self) -> PartnerShape<'a> {
        self.shape
    }

    /// Returns the factor from the extents of its cells to its field: the modulus (Pa), or 1 if the partner is rigid.
    pub(crate) fn scale(&self) -> T {
        self.modulus
    }

    /// Returns a partner of the same shape with another pose, scalar type and modulus (Pa). A rigid partner ignores the
    /// modulus.
    ///
    /// # Errors
    /// Returns an error if the pose is not finite or its rotation is not orthonormal. For a compliant partner, also
    /// returns an error if the modulus is not positive and finite, or if the gradient of the pressure exceeds 1e153
    /// Pa/m.
    pub fn at<U: Scalar>(&self, pose: Pose<U>, modulus: U) -> Result<Partner<'a, U>, BodyError> {
        Partner::new(self.shape, pose, modulus)
    }

    /// Returns the partner with another valid pose. `modulus` maps the modulus unless the partner is rigid.
    pub(crate) fn with<U: Scalar>(
        &self,
        pose: Pose<U>,
        modulus: impl FnOnce(T) -> U,
    ) -> Partner<'a, U> {
        Partner::from_valid(self.shape, pose, modulus(self.modulus))
    }
}

impl<'a> Partner<'a> {
    /// Moves the partner by a twist (see [`Pose::moved_by`]) and changes its modulus (Pa). Both changes must have real
    /// part zero: they seed derivatives and leave values unchanged.
    pub(crate) fn perturbed<T: Scalar>(&self, twist: &Twist<T>, change: T) -> Partner<'a, T> {
        self.with(Pose::lifted(&self.pose).moved_by(twist), |modulus| {
            lift::<T>(modulus) + change
        })
    }
}

impl<'a> PartnerShape<'a> {
    /// Returns true for a rigid body and for a half-space without a layer.
    pub fn is_rigid(self) -> bool {
        match self {
            Self::Compliant(_) => false,
            Self::Rigid(_) => true,
            Self::HalfSpace(half_space) => half_space.thickness().is_none(),
        }
    }

    /// Returns the tetrahedra of a mesh, the cells behind the triangles of a rigid body, or the one cell of a
    /// half-space.
    ///
    /// The field of a cell determines the equilibrium plane. The faces of the cell clip the contact polygon, except its
    /// zero faces.
    pub fn cells(self) -> &'a [FieldTet] {
        match self {
            Self::Compliant(shape) => shape.field().tets(),
            Self::Rigid(shape) => shape.cells(),
            Self::HalfSpace(half_space) => half_space.cell(),
        }
    }

    /// Returns the number of vertices of its mesh or surface, and the number of its extents.
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

    /// Returns the vertices at the corners of a cell. The entry of an apex behind a triangle is `None`.
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

    /// Returns the neighbors of each cell across its faces, by the opposite corner, or
    /// [`OUTSIDE`](crate::mesh::OUTSIDE). The slice is empty for a half-space.
    pub fn neighbors(self) -> &'a [[u32; 4]] {
        match self {
            Self::Compliant(shape) => shape.field().mesh().neighbors(),
            Self::Rigid(shape) => shape.neighbors(),
            Self::HalfSpace(_) => &[],
        }
    }

    /// Returns the largest gradient of the extent in its cells (1/m). It is 1 for a rigid body, whose extent is the
    /// depth (m).
    pub fn steepest(self) -> f64 {
        match self {
            Self::Compliant(shape) => shape.field().steepest(),
            Self::Rigid(_) => 1.0,
            Self::HalfSpace(half_space) => half_space.cell()[0].steepness,
        }
    }

    /// Returns a bound (m) on the distance from the origin of the partner's frame to the part that matters for contact
    /// with A.
    pub fn reach(self, pose_ab: &Pose<f64>) -> f64 {
        match self {
            Self::Compliant(shape) => shape.field().reach(),
            Self::Rigid(shape) => shape.surface().reach(),
            // The distance from A to that origin. Scaling first prevents overflow and underflow of the squares.
            Self::HalfSpace(_) => {
                let (offset, largest) = (pose_ab.translation(), pose_ab.translation().amax());
                if largest == 0.0 {
                    0.0
                } else {
                    (offset / largest).norm() * largest
                }
            }
        }
    }
}
