//! How long an explicit time step may be.
//!
//! Every close pair is linearized over mass-weighted motions of its two bodies. Power iteration finds the step h at which the largest
//! eigenvalue of h²K + 2hC is 4, where a mode changes sign and begins to grow. The search errs toward a shorter step. Rollouts compare
//! each step with this limit when contact begins or changes fast, and keep a balance of the energy that each contact absorbs and returns
//! (`balance.rs`).

mod balance;
mod kick;
mod limit;
mod pair;

use super::model::Model;
use super::sweep::Sweep;
use super::{BodyState, Force, State, World, WorldError};
use crate::parallel::mapped_into;
use crate::scalar::{Scalar, real_part};
pub(super) use balance::{ContactBalances, Instability};
pub(super) use kick::Kick;
use limit::stability_limit;
use pair::{PairRates, RealBody};

impl<T: Scalar, F: Force> World<T, F> {
    /// The longest time step (s) with which the contacts of a state are stepped stably; `None` where
    /// nothing touches, or no motion is resisted.
    ///
    /// # The formula
    ///
    /// Take one mode with the stiffness rate k (stiffness over mass, 1/s²) and the damping rate c
    /// (damping over mass, 1/s). A kick of the step h takes v to (1 − hc)v − hk·x, a drift takes x
    /// to x + hv. Kick and drift have, in either order and however the drift is split, the
    /// determinant 1 − hc and the trace 2 − hc − h²k. Both eigenvalues are in the unit circle iff
    /// |trace| ≤ 1 + determinant and |determinant| ≤ 1, that is
    ///
    /// h²k + 2hc ≤ 4, h ≤ 4/(c + √(c² + 4k)):
    ///
    /// 2/√k without damping, 2/c without stiffness, and for both integrators the same. For many modes
    /// with symmetric matrices K and C over the masses, an eigenvector x obeys the same quadratic
    /// equation with k = x·Kx and c = x·Cx, so h is stable iff no eigenvalue of h²K + 2hC
    /// exceeds 4: beyond it a mode changes sign and grows with every step.
    ///
    /// # By hand
    ///
    /// A contact of the area A (m²) between fields with the pressure gradients κ_A and κ_B (modulus
    /// times gradient of the extent, Pa/m) has the stiffness κA with κ = κ_Aκ_B/(κ_A + κ_B). Pressed
    /// with the force F, dissipation d damps it with dF and friction μ with μF/v_s across, at slip
    /// below the slip tolerance v_s. With the effective mass m, 1/m = 1/m_A + 1/m_B, the rates are
    /// k = κA/m and c = dF/m. Friction turns bodies too: at the distance r from their centers, 1/m is
    /// the larger by r²/I of each (3.5/m_A in all for a ball, 2.5/m_A for a cube), and c = μF/(m v_s).
    ///
    /// # What it knows
    ///
    /// - Only this state: later contact may be deeper, and therefore stiffer. Rollouts also check their steps, without friction, unless
    ///   [`Plan::without_stability_check`](super::Plan::without_stability_check) turns the check off.
    /// - Contacts alone: drag, springs and other forces are not included.
    /// - The symmetric parts of stiffness and damping, and no stiffness of friction. Where contacts slide
    ///   this changes the limit by a per cent or so (`cargo test --test dynamics stability:: -- --nocapture`), where a weak contact
    ///   slides fast by more.
    /// - The growth that a time step makes. What is unstable by nature, like a pencil on its tip, stays
    ///   so at any step.
    /// - Friction beyond its limit makes bodies at rest chatter, at speeds of about hμF/(2m) (m/s): its force is bounded.
    /// - Derivatives of the state play no part.
    ///
    /// Linearizes each contact once, one with friction twice.
    ///
    /// ```
    /// use hydroelastic::contact::Shape;
    /// use hydroelastic::dynamics::{Body, Mass, Material, World};
    /// use hydroelastic::mesh::shapes;
    /// use hydroelastic::spatial::Pose;
    /// use nalgebra::vector;
    ///
    /// let skin = Material::elastic(1e6);
    /// let cube = Shape::new(shapes::cuboid([0.2, 0.2, 0.2])?);
    /// let slab = Shape::new(shapes::cuboid([2.0, 2.0, 0.2])?);
    /// let world = World::new(vec![
    ///     Body::dynamic("cube", cube, skin, Mass::Total(1.0))?
    ///         .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.1999])),
    ///     Body::fixed("slab", slab, skin)?,
    /// ])?;
    /// let limit = world.largest_stable_step(&world.initial_state())?;
    /// // Both gradients are 1e6 Pa/0.1 m, the area is (0.2 m)², the mass 1 kg.
    /// let by_hand = 2.0 / (0.5e7_f64 * 0.04).sqrt();
    /// assert!((limit.ok_or("apart")? / by_hand - 1.0).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If the state does not fit the world: another number of bodies, a pose that is not rigid, or a number that is not finite.
    pub fn largest_stable_step(&self, state: &State<T>) -> Result<Option<f64>, WorldError> {
        state.check_fits(self.bodies())?;
        let rates = self.model.rates(&state.bodies, true);
        Ok(stability_limit(&rates, state.bodies.len()))
    }
}

impl<T: Scalar> Model<T> {
    /// The stability limit (s) of the contacts of a state, and the contacts; none if nothing is resisted. Friction is left out,
    /// because the chatter of bodies at rest is bounded.
    fn limit_without_friction(&self, states: &[BodyState<T>]) -> Option<(f64, Vec<PairRates>)> {
        let rates = self.rates(states, false);
        stability_limit(&rates, states.len()).map(|limit| (limit, rates))
    }

    /// The potential energy (J) of the contact of two bodies.
    fn stored_energy(&self, bodies: [usize; 2], states: &[BodyState]) -> f64 {
        let states = bodies.map(|index| states[index].lifted());
        let pair = self.pair_of(bodies, [&states[0], &states[1]]);
        pair.map_or(0.0, |pair| real_part(pair.potential_energy()))
    }

    /// All contacts of a state, linearized with or without the damping of friction.
    fn rates(&self, states: &[BodyState<T>], with_friction: bool) -> Vec<PairRates> {
        let (mut sweep, mut rates) = (Sweep::default(), Vec::new());
        let pairs = self.close_pairs(states, &mut sweep);
        mapped_into(&mut rates, pairs, |&(i, j)| {
            let bodies = [i, j].map(|index| RealBody::of(&self.bodies[index], &states[index]));
            PairRates::of([i, j], &bodies, self.slip_tolerance, with_friction)
        });
        rates.into_iter().flatten().collect()
    }
}
