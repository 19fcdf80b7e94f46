use super::surface_law::RelativeMotion;
use super::{ContactBody, ContactPair, ContactWrench, SurfaceLaw};
use crate::scalar::{
    DenseDual, Order, Scalar, change, constant_times, cross_constant, lift, real_part, real_vector,
};
use crate::search::PartialSum;
use crate::spatial::{Pose, Twist, Wrench, turn_from_real};
use nalgebra::{SMatrix, Vector3, Vector6};

/// A number with derivatives by what the polygons of a pair depend on: the motion of B relative to A
/// (angular, linear, in A's axes about A's origin) and the moduli.
type Inner = DenseDual<8>;

impl<T: Scalar> ContactPair<'_, T> {
    /// [`Self::wrench`] with first derivatives from the closed form: the contact is evaluated once in
    /// `f64` with its Jacobian, which the chain rule carries into however many derivatives `T` has.
    ///
    /// Faster than the generic pipeline, and right also where edges of polygons coincide. For a `T`
    /// of second or higher order, and for `f64`, it is [`Self::wrench`].
    #[must_use]
    pub fn wrench_carried(&self) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let slopes = self.real_slopes();
            let wrench_a = slopes.carried(&self.changes());
            return self.wrench_from_a(&wrench_a);
        }
        self.wrench()
    }

    /// [`Self::wrench_in_motion`] with first derivatives by the chain rule: the contact is evaluated
    /// once in dual numbers of fixed width, whose derivatives are carried into however many `T` has.
    ///
    /// For a `T` of second or higher order, and for `f64`, it is [`Self::wrench_in_motion`].
    #[must_use]
    pub fn wrench_in_motion_carried(
        &self,
        law: &SurfaceLaw<T>,
        twists: [Twist<T>; 2],
    ) -> ContactWrench<T> {
        if Order::<T>::IS_FIRST {
            let motion = RelativeMotion::of(self, twists);
            let slopes = self.slopes_in_motion(&law.real(), &motion.real());
            let wrench_a = slopes.carried(&self.changes_in_motion(law, &motion));
            return self.wrench_from_a(&wrench_a);
        }
        self.wrench_in_motion(law, twists)
    }

    /// Wrench on A about A's origin in A's axes, with its slopes in closed form.
    fn real_slopes(&self) -> Slopes<8> {
        let [a, b] = self.real_bodies();
        let relative = ContactPair::new(a, b).relative_jacobian();
        let [by_modulus_a, by_modulus_b] = relative.by_moduli([a.modulus(), b.modulus()]);
        let mut slopes = SMatrix::<f64, 6, 8>::zeros();
        let mut by_motion = slopes.fixed_columns_mut::<6>(0);
        by_motion.copy_from(relative.by_motion_of_b());
        slopes.set_column(6, &by_modulus_a);
        slopes.set_column(7, &by_modulus_b);
        let wrench = relative.wrench().to_vector();
        Slopes { wrench, slopes }
    }

    /// Wrench on A about A's origin in A's axes, with its slopes: by what the polygons depend on in
    /// dual numbers, by velocities and law on the polygons as they are.
    fn slopes_in_motion(&self, law: &SurfaceLaw, motion: &RelativeMotion<f64>) -> Slopes<16> {
        let [a, b] = self.real_bodies();
        let pair = ContactPair::new(
            ContactBody::from_valid(a.shape(), Pose::identity(), Inner::variable(a.modulus(), 6)),
            ContactBody::from_valid(
                b.shape(),
                moved_about_origin(b.pose()),
                Inner::variable(b.modulus(), 7),
            ),
        );
        let (inner_law, inner_motion) = (law.lifted::<Inner>(), motion.lifted::<Inner>());
        let sum: SlopesInMotion = pair.sum_polygons(|sum: &mut SlopesInMotion, polygon| {
            sum.wrench += polygon.wrench_in_motion(&inner_law, &inner_motion);
            polygon.add_slopes(law, motion, &mut sum.by_motion);
        });
        let (wrench_a, by_motion) = (sum.wrench.to_vector(), sum.by_motion);
        let slopes = SMatrix::from_fn(|row, column| match column {
            0..8 => wrench_a[row].eps[column],
            _ => by_motion[(row, column - 8)],
        });
        Slopes {
            wrench: wrench_a.map(real_part),
            slopes,
        }
    }

    /// Both bodies without derivatives, in A's frame.
    fn real_bodies(&self) -> [ContactBody<'_, f64>; 2] {
        let (a, b) = (self.a(), self.b());
        let pose_ab = a.pose().real().inverse() * b.pose().real();
        [
            ContactBody::from_valid(a.shape(), Pose::identity(), real_part(a.modulus())),
            ContactBody::from_valid(b.shape(), pose_ab, real_part(b.modulus())),
        ]
    }

    /// How B has moved relative to A from where the real parts are (angular, linear, in A's axes
    /// about A's origin), and how the moduli have changed.
    fn changes(&self) -> [T; 8] {
        let (pose_wa, pose_wb) = (self.a().pose(), self.b().pose());
        let [turn_a, turn_b] = [pose_wa, pose_wb].map(|pose| turn_from_real(pose.rotation()));
        let from_a_to_b = pose_wb.translation() - pose_wa.translation();
        // Of the points of both bodies at A's origin: a turn about B's origin moves the one of B too.
        let shift = from_a_to_b.map(change) - cross_constant(&turn_b, &real_vector(&from_a_to_b));
        let in_a = pose_wa.real().rotation().transpose();
        let angular = constant_times(&in_a, &(turn_b - turn_a));
        let linear = constant_times(&in_a, &shift);
        let moduli = [self.a().modulus(), self.b().modulus()].map(change);
        [
            angular.x, angular.y, angular.z, linear.x, linear.y, linear.z, moduli[0], moduli[1],
        ]
    }

    /// [`Self::changes`], and those of the relative motion and of the law.
    fn changes_in_motion(&self, law: &SurfaceLaw<T>, motion: &RelativeMotion<T>) -> [T; 16] {
        let of_pair = self.changes();
        let angular = motion.angular.map(change);
        let linear = motion.at_origin.map(change);
        std::array::from_fn(|number| match number {
            0..8 => of_pair[number],
            8..11 => angular[number - 8],
            11..14 => linear[number - 11],
            14 => change(law.dissipation),
            _ => change(law.friction),
        })
    }
}

/// A wrench with its derivatives by what the polygons depend on, and those by velocities and law.
struct SlopesInMotion {
    wrench: Wrench<Inner>,
    by_motion: SMatrix<f64, 6, 8>,
}

impl PartialSum for SlopesInMotion {
    fn empty() -> Self {
        Self {
            wrench: Wrench::zero(),
            by_motion: SMatrix::zeros(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.wrench += next.wrench;
        self.by_motion += next.by_motion;
    }
}

/// A wrench (torque, force) and its derivatives by `K` numbers.
struct Slopes<const K: usize> {
    wrench: Vector6<f64>,
    slopes: SMatrix<f64, 6, K>,
}

impl<const K: usize> Slopes<K> {
    /// The chain rule: the wrench after changes with real parts of zero.
    fn carried<T: Scalar>(&self, changes: &[T; K]) -> Wrench<T> {
        let number = |row: usize| {
            let mut sum = lift::<T>(self.wrench[row]);
            for (column, change) in changes.iter().enumerate() {
                sum += *change * self.slopes[(row, column)];
            }
            sum
        };
        Wrench {
            torque: Vector3::from_fn(|i, _| number(i)),
            force: Vector3::from_fn(|i, _| number(3 + i)),
        }
    }
}

/// A pose with the derivatives by a motion about the outer frame's origin: numbers 0..6.
fn moved_about_origin(pose: &Pose) -> Pose<Inner> {
    let variables = |first: usize| Vector3::from_fn(|i, _| Inner::variable(0.0, first + i));
    let start = Pose::<Inner>::lifted(pose);
    let turned = Pose::from_rotation_vector(&variables(0), variables(3));
    turned * start
}
