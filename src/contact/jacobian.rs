use super::Kinks;
use super::relative_linearization::RelativeLinearization;
use super::sums::PartialSum;
use nalgebra::{Matrix6, Matrix6x2, Vector6};

/// Wrench on A and its derivatives as B moves relative to A, all in A's axes about A's origin.
///
/// For a pressure field p(x) = ∇p·x + c let s(x) = (x × ∇p, ∇p). A is pushed where its pressure is the lower one. By the divergence
/// theorem, with p = 0 at A's boundary,
///
/// W = ∫ over {p_A < p_B} of s_A dV.
///
/// As B moves, the integrand is constant and the region changes. Moving B by the twist ξ takes s_B·ξ from p_B at a fixed point, so the
/// surface p_A = p_B moves by h = −s_B·ξ/|g| along its normal, and dW = ∫ s_A h dA over the surface. If p_B grows by p·δE_B/E_B instead, h
/// = p/|g|·δE_B/E_B. The derivative with respect to E_A follows by exchanging A and B, with W_B = −W_A:
///
/// ∂W/∂ξ = −Σ 1/|g| ∫ s_A s_Bᵀ dA,  E_B ∂W/∂E_B = Σ 1/|g| ∫ p s_A dA,
/// E_A ∂W/∂E_A = −Σ 1/|g| ∫ p s_B dA.
///
/// If B is rigid, ∇p_B/|g| is −n, and 1/|g| and ∇p_A/|g| are 0. With t = (x × n, n), W = ∫ p t dA and ∂W/∂ξ = ∫ s_A tᵀ dA.
///
/// All integrands are quadratic, so areas and moments give the exact values. Nothing is differentiated through a clip.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativeJacobian {
    /// The elastic wrench W on A. (`pressed_a` − `pressed_b` is equal to it, but cancels if the fields are nearly equal.)
    pub wrench: Vector6<f64>,
    /// ∂W/∂ξ.
    pub by_motion_of_b: Matrix6<f64>,
    /// Σ 1/|g| ∫ p s_A dA.
    pub pressed_a: Vector6<f64>,
    /// Σ 1/|g| ∫ p s_B dA.
    pub pressed_b: Vector6<f64>,
    pub kinks: Kinks,
}

impl PartialSum for RelativeJacobian {
    fn empty() -> Self {
        Self {
            wrench: Vector6::zeros(),
            by_motion_of_b: Matrix6::zeros(),
            pressed_a: Vector6::zeros(),
            pressed_b: Vector6::zeros(),
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

impl RelativeJacobian {
    /// Returns the linearization at the given moduli. Derivatives with respect to velocity are zero.
    pub fn linearization(&self, [modulus_a, modulus_b]: [f64; 2]) -> RelativeLinearization {
        let by_modulus_a = self.pressed_b * (-modulus_a.recip());
        let by_modulus_b = self.pressed_a * modulus_b.recip();
        RelativeLinearization {
            wrench: self.wrench,
            by_motion: self.by_motion_of_b,
            by_moduli: Matrix6x2::from_columns(&[by_modulus_a, by_modulus_b]),
            kinks: self.kinks,
            ..RelativeLinearization::empty()
        }
    }
}
