use super::linearised::RelativeLinearisation;
use super::polygon::CutPolygon;
use super::response::{PolygonResponse, Responses};
use super::sums::OverOctets;
use super::sums::PartialSum;
use super::{ContactPair, Kinks};
use crate::narrow_phase::{Cut, ELASTIC_COINCIDENCE, Weights};
use crate::spatial::{Wrench, add_block, skew};
use nalgebra::{Matrix6, Matrix6x2, Vector3, Vector6};

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
pub(super) struct RelativeJacobian {
    /// The elastic wrench W on A. (`pressed_a` − `pressed_b` is equal to it, but cancels where the fields are nearly equal.)
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
    /// The same as a linearisation that knows of no velocity, at the given moduli.
    pub fn linearisation(&self, [modulus_a, modulus_b]: [f64; 2]) -> RelativeLinearisation {
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

/// Sums over an elastic contact, with the responses of its polygons.
struct Elastic<R> {
    sums: RelativeJacobian,
    responses: R,
}

impl<R: Responses> PartialSum for Elastic<R> {
    fn empty() -> Self {
        Self {
            sums: RelativeJacobian::empty(),
            responses: R::empty(),
        }
    }

    fn merge(&mut self, next: Self) {
        self.sums.merge(next.sums);
        self.responses.merge(next.responses);
    }
}

impl ContactPair<'_> {
    /// Linearizes the elastic contact of a pair in A's frame. Returns the responses of its polygons, too, if `R` keeps them.
    pub(super) fn elastic_linearisation<R: Responses>(&self) -> (RelativeLinearisation, R) {
        let source = self.source();
        let (octaves, search) = (ELASTIC_COINCIDENCE, self.search());
        let ((surface, finer), spilled) = if R::ARE_KEPT {
            let surfaces = source.for_derivatives(octaves, search);
            (surfaces, RelativeJacobian::empty())
        } else {
            source.for_sum_of_derivatives(octaves, search)
        };
        let add = |sum: &mut Elastic<R>, cut: &Cut| {
            let add_polygon = |sum: &mut Elastic<R>, polygon: &CutPolygon<f64>| {
                polygon.add_to(&mut sum.sums);
                sum.responses
                    .keep(|| PolygonResponse::of(cut, polygon, None));
            };
            surface.add_where(Weights::have_area, add_polygon, sum, cut);
        };
        let mut elastic = surface.sum_of_special_cuts(&add);
        elastic
            .sums
            .merge(RelativeJacobian::over(surface.found.octets()));
        elastic.sums.merge(spilled);
        if R::ARE_KEPT {
            for octet in surface.found.octets() {
                let places = (0..octet.tets().len()).filter(|&place| octet.has_polygon(place));
                for place in places {
                    let response = || PolygonResponse::at(octet, place, None);
                    elastic.responses.keep(response);
                }
            }
        }
        let mut linearisation = elastic.sums.linearisation(self.moduli());
        linearisation.kinks.are_equal = surface.has_equal_fields();
        linearisation.kinks.are_flush |= surface.touches();
        if let Some(finer) = finer {
            linearisation.wrench = finer.wrench().to_vector();
            linearisation.kinks.are_flush = true;
        }
        (linearisation, elastic.responses)
    }
}

impl CutPolygon<f64> {
    /// The polygon's share of the wrench on A and of its derivatives.
    pub fn add_to(&self, sum: &mut RelativeJacobian) {
        let (gradient_a, [slope_a, slope_b]) = (&self.pressure_a.gradient, &self.plane.slopes);
        sum.kinks.are_flush |= !self.weights.are_whole() || self.polygon.shares_edges();
        let weight = self.weights.moving.area();
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
        let pressed = |way: &Vector3<f64>| Wrench {
            torque: weighted.cross(way),
            force: way * total,
        };
        sum.wrench += pressed(&self.plane.normal).to_vector();
        sum.pressed_a += pressed(slope_a).to_vector();
        sum.pressed_b += pressed(slope_b).to_vector();
    }
}
