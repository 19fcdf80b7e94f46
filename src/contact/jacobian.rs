use super::linearised::{RelativeLinearisation, add_block};
use super::polygon::{CutPolygon, PartialSum};
use super::{Kinks, LinearisedContact};
use crate::scalar::{Scalar, lift};
use crate::spatial::{Wrench, skew};
use nalgebra::{Matrix6, Matrix6x2, SMatrix, Vector3, Vector6};

/// The derivatives of one body's wrench (rows: torque, force) by both poses and both moduli.
///
/// A pose moves by a twist (columns: angular, linear) in world axes: the body turns by `angular`
/// (rad) about its own origin, which moves by `linear` (m); see [`Pose::moved_by`](crate::spatial::Pose::moved_by). The torque is
/// about the body's own origin wherever that moves.
#[derive(Debug, Clone, Copy)]
pub struct WrenchJacobian<T = f64> {
    /// By the pose of A: torques (N m/rad, N m/m), forces (N/rad, N/m).
    pub by_pose_a: Matrix6<T>,
    /// By the pose of B: the same units.
    pub by_pose_b: Matrix6<T>,
    /// By the modulus of A (N m/Pa, N/Pa).
    pub by_modulus_a: Vector6<T>,
    /// By the modulus of B.
    pub by_modulus_b: Vector6<T>,
}

/// The derivatives of both wrenches of a pair.
#[derive(Debug, Clone, Copy)]
pub struct ContactJacobian<T = f64> {
    /// Of the wrench on A, about A's origin.
    pub on_a: WrenchJacobian<T>,
    /// Of the wrench on B, about B's origin.
    pub on_b: WrenchJacobian<T>,
}

impl<T: Scalar> WrenchJacobian<T> {
    /// The 6×14 matrix: rows torque, force; columns pose A, pose B (angular, linear each),
    /// modulus A, modulus B.
    #[must_use]
    pub fn matrix(&self) -> SMatrix<T, 6, 14> {
        SMatrix::from_fn(|row, column| match column {
            0..6 => self.by_pose_a[(row, column)],
            6..12 => self.by_pose_b[(row, column - 6)],
            12 => self.by_modulus_a[row],
            _ => self.by_modulus_b[row],
        })
    }

    /// From the 6×14 matrix of [`Self::matrix`].
    #[must_use]
    pub fn from_matrix(matrix: &SMatrix<T, 6, 14>) -> Self {
        Self {
            by_pose_a: matrix.fixed_view::<6, 6>(0, 0).into_owned(),
            by_pose_b: matrix.fixed_view::<6, 6>(0, 6).into_owned(),
            by_modulus_a: matrix.column(12).into_owned(),
            by_modulus_b: matrix.column(13).into_owned(),
        }
    }
}

impl<T: Scalar> ContactJacobian<T> {
    /// The derivatives by poses and moduli.
    pub(super) fn of(contact: &LinearisedContact<T>) -> Self {
        let of_rows = |row: usize| {
            let block = |column| {
                contact
                    .by_poses
                    .fixed_view::<6, 6>(row, column)
                    .into_owned()
            };
            let column = |of: usize| contact.by_moduli.fixed_view::<6, 1>(row, of).into_owned();
            WrenchJacobian {
                by_pose_a: block(0),
                by_pose_b: block(6),
                by_modulus_a: column(0),
                by_modulus_b: column(1),
            }
        };
        Self {
            on_a: of_rows(0),
            on_b: of_rows(6),
        }
    }
}

/// Wrench on A and its derivatives as B moves relative to A, all in A's axes about A's origin.
///
/// For a pressure field p(x) = ∇p·x + c write s(x) = (x × ∇p, ∇p). A is pushed where its pressure
/// is the lower one: by the divergence theorem, with p = 0 at A's rim,
///
/// W = ∫ over {p_A < p_B} of s_A dV.
///
/// The integrand does not move with B, the region does. Moving B by the twist ξ takes s_B·ξ from p_B
/// at a fixed point, so the surface p_A = p_B moves by h = −s_B·ξ/|g| along its normal, and
/// dW = ∫ s_A h dA over it. Where p_B grows by p·δE_B/E_B instead, h = p/|g|·δE_B/E_B. With A and B
/// exchanged, and W_B = −W_A:
///
/// ∂W/∂ξ = −Σ 1/|g| ∫ s_A s_Bᵀ dA,  E_B ∂W/∂E_B = Σ 1/|g| ∫ p s_A dA,
/// E_A ∂W/∂E_A = −Σ 1/|g| ∫ p s_B dA.
///
/// Where B is rigid, ∇p_B/|g| is −n, and 1/|g| and ∇p_A/|g| are 0: with t = (x × n, n), W = ∫ p t dA and
/// ∂W/∂ξ = ∫ s_A tᵀ dA.
///
/// All integrands are quadratic, so areas and moments give the exact values; nothing is
/// differentiated through a clip.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeJacobian<T> {
    /// The elastic wrench W on A. (`pressed_a` − `pressed_b` is equal to it, but cancels where the fields are nearly equal.)
    pub wrench: Vector6<T>,
    /// ∂W/∂ξ.
    pub by_motion_of_b: Matrix6<T>,
    /// Σ 1/|g| ∫ p s_A dA.
    pub pressed_a: Vector6<T>,
    /// Σ 1/|g| ∫ p s_B dA.
    pub pressed_b: Vector6<T>,
    pub kinks: Kinks,
}

impl<T: Scalar> PartialSum for RelativeJacobian<T> {
    fn empty() -> Self {
        Self {
            wrench: Vector6::from_element(lift(0.0)),
            by_motion_of_b: Matrix6::from_element(lift(0.0)),
            pressed_a: Vector6::from_element(lift(0.0)),
            pressed_b: Vector6::from_element(lift(0.0)),
            kinks: Kinks::default(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.wrench += next.wrench;
        self.by_motion_of_b += next.by_motion_of_b;
        self.pressed_a += next.pressed_a;
        self.pressed_b += next.pressed_b;
        self.kinks.merge(next.kinks);
    }
}

impl<T: Scalar> RelativeJacobian<T> {
    /// The same as a linearisation that knows of no velocity, at the given moduli.
    pub fn linearisation(&self, [modulus_a, modulus_b]: [T; 2]) -> RelativeLinearisation<T> {
        let by_modulus_a = self.pressed_b * (-modulus_a.recip());
        let by_modulus_b = self.pressed_a * modulus_b.recip();
        RelativeLinearisation {
            wrench: self.wrench,
            by_motion: self.by_motion_of_b,
            by_moduli: Matrix6x2::from_columns(&[by_modulus_a, by_modulus_b]),
            kinks: self.kinks,
            ..RelativeLinearisation::empty()
        }
    }
}

impl<T: Scalar> CutPolygon<T> {
    /// The polygon's share of the wrench on A and of its derivatives.
    pub fn add_to(&self, sum: &mut RelativeJacobian<T>) {
        let (gradient_a, [slope_a, slope_b]) = (&self.pressure_a.gradient, &self.plane.slopes);
        sum.kinks.are_flush |= !self.weights.are_whole() || self.polygon.shares_edges();
        let weight = lift::<T>(self.weights.moving.area());
        let area = self.moments.area * weight;
        let first = self.moments.first_about_origin() * weight;
        let second = self.moments.second_about_origin() * weight;
        // ∫ (x × a)(x × b)ᵀ = [a]ₓ (∫ x xᵀ) [b]ₓᵀ, since x × a = −[a]ₓ x.
        let torque_torque = skew(gradient_a) * second * skew(slope_b).transpose();
        let arm_a = first.cross(gradient_a);
        let arm_b = first.cross(slope_b);
        let blocks = [
            ([0, 0], torque_torque),
            ([0, 3], arm_a * slope_b.transpose()),
            ([3, 0], gradient_a * arm_b.transpose()),
            ([3, 3], gradient_a * slope_b.transpose() * area),
        ];
        for (place, block) in blocks {
            add_block(&mut sum.by_motion_of_b, place, -block);
        }
        let (total, weighted) = self.pressure_integrals();
        let pressed = |way: &Vector3<T>| Wrench {
            torque: weighted.cross(way),
            force: way * total,
        };
        sum.wrench += pressed(&self.plane.normal).to_vector();
        sum.pressed_a += pressed(slope_a).to_vector();
        sum.pressed_b += pressed(slope_b).to_vector();
    }
}
