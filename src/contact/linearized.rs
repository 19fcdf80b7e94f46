use super::elastic::{ElasticJacobian, ElasticWrench};
use super::motion::{Motion, RelativeMotion};
use super::reaction::Reaction;
use super::relative_linearization::RelativeLinearization;
use super::response::Responses;
use super::{ContactPair, ContactWrench, Kinks};
use crate::narrow_phase::ELASTIC_COINCIDENCE;
use crate::scalar::{Order, Scalar};
use crate::spatial::{Wrench, add_block, skew};
use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3};

/// The wrenches of a contact and all their first derivatives, in the world frame.
///
/// Wrenches are about the origins of the bodies' frames, which move with the bodies. Twists are in world axes; their linear part is the
/// velocity of the body's origin. A pose moves by a twist: the body turns by `angular` (rad) about its own origin, and the origin moves by
/// `linear` (m); see [`Pose::moved_by`](crate::spatial::Pose::moved_by). Rows are the wrench on A (torque, force), then the wrench on B.
/// Units are N m and N, divided by the units of the columns.
///
/// The derivatives are in closed form: nothing is differentiated through a clip. The elastic part needs only areas and moments of the
/// contact polygons. The part of dissipation and friction also needs the motion of the polygons' edges, which follows from the motion of
/// the faces that contain them.
///
/// If the wrench has a kink, as friction has at flush sides, the derivatives with respect to poses and moduli are the mean of the
/// derivatives on both sides. A pose counts as at the kink if its distance from the kink is at most 2.5e-10 of the bodies' size. The limit
/// is smaller if the bodies overlap by less. If several kinks meet, no linear function is the mean in all directions. The mean is then
/// taken about one generic direction. Derivatives with respect to velocities and the law are evaluated at the pose itself. Surfaces that
/// face each other and only touch have no contact and zero derivatives. The slip tolerance is a constant.
///
/// ```
/// use hydroelastic::contact::{ContactBody, ContactPair, Shape, SurfaceLaw};
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::{Pose, Twist};
/// use nalgebra::vector;
///
/// let block = Shape::new(shapes::cuboid([0.2, 0.2, 0.1])?);
/// let above = Pose::from_translation(vector![0.0, 0.0, 0.0995]);
/// let pair = ContactPair::new(
///     ContactBody::new(&block, above, 1e5)?,
///     ContactBody::new(&block, Pose::identity(), 1e5)?,
/// );
/// let law = SurfaceLaw::new(0.3, 0.4, 1e-2)?; // dissipation (s/m), friction, slip tolerance (m/s)
/// let sliding = Twist { linear: vector![0.5, 0.0, 0.0], ..Twist::zero() };
/// let contact = pair.moving(law, [sliding, Twist::zero()]).linearized();
/// // Derivative of the friction force on A (row 3) with respect to the speed of A along y (column 4), which turns the friction.
/// assert!((contact.by_twists[(4, 4)] - contact.wrench.on_a.force.x / 0.5).abs() < 1e-2);
/// // A change of all inputs, and the change of the wrenches to first order.
/// let change = contact.pushforward(&nalgebra::SVector::repeat(1e-6));
/// assert!(change.norm() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct LinearizedContact {
    /// The wrenches.
    pub wrench: ContactWrench,
    /// Derivatives with respect to motions of A and of B (angular and linear each; rad and m), at constant twists in the world.
    pub by_poses: SMatrix<f64, 12, 12>,
    /// Derivatives with respect to the twists of A and B (rad/s and m/s, in world axes).
    pub by_twists: SMatrix<f64, 12, 12>,
    /// Derivatives with respect to the hydroelastic moduli of A and B (Pa).
    pub by_moduli: SMatrix<f64, 12, 2>,
    /// Derivatives with respect to the dissipation (s/m) and the coefficient of friction of the surface law.
    pub by_law: SMatrix<f64, 12, 2>,
    /// Reasons why the derivatives may not be unique.
    pub kinks: Kinks,
}

impl LinearizedContact {
    /// Returns the 12×28 Jacobian. Its columns are the poses of A and B, the twists of A and B, the moduli of A and B, dissipation and
    /// friction.
    #[must_use]
    pub fn jacobian(&self) -> SMatrix<f64, 12, 28> {
        SMatrix::from_fn(|row, column| match column {
            0..12 => self.by_poses[(row, column)],
            12..24 => self.by_twists[(row, column - 12)],
            24..26 => self.by_moduli[(row, column - 24)],
            _ => self.by_law[(row, column - 26)],
        })
    }

    /// Returns the change of the wrenches for a change of the inputs, the columns of [`Self::jacobian`]: the Jacobian times a vector.
    #[must_use]
    pub fn pushforward(&self, change: &SVector<f64, 28>) -> SVector<f64, 12> {
        self.by_poses * change.fixed_rows::<12>(0)
            + self.by_twists * change.fixed_rows::<12>(12)
            + self.by_moduli * change.fixed_rows::<2>(24)
            + self.by_law * change.fixed_rows::<2>(26)
    }

    /// Returns the derivatives of a number with respect to the columns of [`Self::jacobian`], from its derivatives with respect to the
    /// wrenches: the transposed Jacobian times a vector.
    #[must_use]
    pub fn pullback(&self, by_wrenches: &SVector<f64, 12>) -> SVector<f64, 28> {
        let [poses, twists] = [self.by_poses, self.by_twists].map(|by| by.tr_mul(by_wrenches));
        let [moduli, law] = [self.by_moduli, self.by_law].map(|by| by.tr_mul(by_wrenches));
        SVector::from_fn(|row, _| match row {
            0..12 => poses[row],
            12..24 => twists[row - 12],
            24..26 => moduli[row - 24],
            _ => law[row - 26],
        })
    }
}

impl ContactPair<'_> {
    /// Returns the wrenches and all their first derivatives, in closed form. For a pair at rest, derivatives with respect to twists and the
    /// law are zero, and faces count as coincident within 2e-12 of the size of the bodies.
    #[must_use]
    pub fn linearized(&self) -> LinearizedContact {
        let (relative, ()) = self.relative_linearization();
        relative.in_world(self)
    }

    /// Linearizes the elastic contact of a pair in A's frame. Returns the responses of its polygons, too, if `R` keeps them.
    fn elastic_linearization<R: Responses>(&self) -> (RelativeLinearization, R) {
        let integrand = ElasticJacobian::<R>::new();
        let ((sum, responses), (surface, finer)) =
            self.source()
                .integral_for_derivatives(ELASTIC_COINCIDENCE, self.search(), &integrand);
        let mut linearization = sum.linearization(self.moduli());
        linearization.kinks.are_equal = surface.has_equal_fields();
        linearization.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            linearization.wrench = finer.integral(&ElasticWrench).to_vector();
            linearization.kinks.are_flush = true;
        }
        (linearization, responses)
    }
}

impl<T: Scalar> ContactPair<'_, T> {
    /// Returns the wrenches in the scalar, and the linearization of the real parts. For scalars of first order, both come from one search.
    pub(crate) fn wrench_and_linearized(&self) -> (ContactWrench<T>, LinearizedContact) {
        let (relative, ()) = self.relative_linearization();
        let wrench = if Order::<T>::IS_FIRST {
            self.wrench_from_a(&relative.pushforward(&self.tangent()))
        } else {
            self.wrench()
        };
        (wrench, relative.in_world(&self.real_in_world()))
    }

    /// Linearizes the real parts in A's axes. Returns the responses of the polygons, too, if `R` keeps them.
    pub(super) fn relative_linearization<R: Responses>(&self) -> (RelativeLinearization, R) {
        let real = self.real();
        match self.relative_motion() {
            Some((law, motion)) => real.linearization_in_motion(&law.real(), &motion.real()),
            None => real.elastic_linearization(),
        }
    }
}

impl RelativeLinearization {
    /// Transforms the linearization to world axes. `pair` has the poses and the motion in the world.
    pub fn in_world(&self, pair: &ContactPair) -> LinearizedContact {
        let rotation = pair.a().pose().rotation();
        let from_a_to_b = pair.b().pose().translation() - pair.a().pose().translation();
        let wrench = pair.wrench_from_a(&Wrench::from_vector(&self.wrench));
        let turned = block_diagonal(rotation);
        let in_world = |by: &Matrix6<f64>| turned * by * turned.transpose();
        let by_motion = in_world(&self.by_motion);
        let one = Matrix6::identity();
        // Turning B about its own origin moves the point of B at A's origin by r × ω.
        let mut lever = one;
        add_block(&mut lever, [3, 0], skew(&from_a_to_b));
        // Moving A is equivalent to moving B back and turning the wrench with A.
        let mut by_pose_a = -by_motion;
        add_block(&mut by_pose_a, [0, 0], -skew(&wrench.on_a.torque));
        add_block(&mut by_pose_a, [3, 0], -skew(&wrench.on_a.force));
        let mut by_pose_b = by_motion * lever;
        let mut by_twists = [Matrix6::zeros(); 2];
        if let Some(Motion { twists, .. }) = pair.motion() {
            let motion = RelativeMotion::of([pair.a().pose(), pair.b().pose()], twists);
            let by_twist = in_world(&self.by_twist);
            let [turn, shift] = motion.by_pose_a(rotation, &twists[1].angular);
            by_pose_a += by_twist * (turn - shift);
            by_pose_b += by_twist * shift;
            // The relative velocity is the velocity of A minus the velocity of B, at A's origin.
            by_twists = [by_twist, -(by_twist * lever)];
        }
        let reaction = Reaction {
            from_a_to_b,
            force: wrench.on_a.force,
        };
        LinearizedContact {
            wrench,
            by_poses: reaction.of_poses(&[by_pose_a, by_pose_b]),
            by_twists: reaction.of_blocks(&by_twists),
            by_moduli: reaction.of_columns(&(turned * self.by_moduli)),
            by_law: reaction.of_columns(&(turned * self.by_law)),
            kinks: self.kinks,
        }
    }
}

impl RelativeMotion<f64> {
    /// Returns the derivatives of the velocity of A relative to B with respect to the turn of A's axes with A, and with respect to the
    /// motion of A's origin relative to B. The velocity is in A's axes, and the derivatives are in world axes.
    fn by_pose_a(&self, rotation: &Matrix3<f64>, spin_b: &Vector3<f64>) -> [Matrix6<f64>; 2] {
        let mut turn = Matrix6::zeros();
        add_block(&mut turn, [0, 0], skew(&(rotation * self.angular)));
        add_block(&mut turn, [3, 0], skew(&(rotation * self.at_origin)));
        let mut shift = Matrix6::zeros();
        add_block(&mut shift, [3, 3], skew(spin_b));
        [turn, shift]
    }
}

pub(super) fn block_diagonal(rotation: &Matrix3<f64>) -> Matrix6<f64> {
    let mut matrix = Matrix6::zeros();
    add_block(&mut matrix, [0, 0], *rotation);
    add_block(&mut matrix, [3, 3], *rotation);
    matrix
}
