//! Stability limit of explicit time steps.
//!
//! Every close pair is linearized over mass-weighted motions of its two bodies. Power iteration finds the step h at which the largest
//! eigenvalue of h²K + 2hC is 4. At this step, a mode changes sign and begins to grow. The search errs toward a shorter step. Rollouts
//! compare each step with this limit when contact begins or changes fast, and keep a balance of the energy that each contact absorbs and
//! returns (`balance.rs`).

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
    /// Largest time step (s) for which explicit steps of the contacts in a state are stable, or
    /// `None` if no bodies touch or the contacts resist no motion.
    ///
    /// # The formula
    ///
    /// Consider one mode with the stiffness rate k (stiffness divided by mass, 1/s²) and the
    /// damping rate c (damping divided by mass, 1/s). A kick of the step h changes v to (1 − hc)v −
    /// hk·x. A drift changes x to x + hv. In either order, and however the drift is split, kick and
    /// drift together have the determinant 1 − hc and the trace 2 − hc − h²k. Both eigenvalues are
    /// in the unit circle if and only if
    /// |trace| ≤ 1 + determinant and |determinant| ≤ 1, that is
    ///
    /// h²k + 2hc ≤ 4, h ≤ 4/(c + √(c² + 4k)).
    ///
    /// The limit is 2/√k without damping and 2/c without stiffness. It is the same for both
    /// integrators. Many modes have symmetric matrices K and C, divided by the masses. An
    /// eigenvector x obeys the same quadratic equation with k = x·Kx and c = x·Cx. So h is stable
    /// if and only if no eigenvalue of h²K + 2hC exceeds 4. Beyond 4 a mode changes sign and grows
    /// in every step.
    ///
    /// # By hand
    ///
    /// Consider a contact of area A (m²) between fields with the pressure gradients κ_A and κ_B (modulus times gradient of the extent,
    /// Pa/m). Its stiffness is κA with κ = κ_Aκ_B/(κ_A + κ_B). If it is pressed with the force F, dissipation d adds the damping dF.
    /// Friction μ adds the tangential damping μF/v_s, at slip below the slip tolerance v_s. With the effective mass m, 1/m = 1/m_A + 1/m_B,
    /// the rates are k = κA/m and c = dF/m. Friction also turns the bodies. At the distance r from its center, each body adds r²/I to 1/m,
    /// so 1/m is 3.5/m_A for a ball and 2.5/m_A for a cube on a fixed body. Then c = μF/(m v_s).
    ///
    /// # Scope
    ///
    /// - The limit holds for this state only. Later contact may be deeper, and therefore stiffer. Rollouts also check their steps, without
    ///   friction, unless [`Plan::without_stability_check`](super::Plan::without_stability_check) turns the check off.
    /// - Only contacts are included. Drag, springs and other forces are not.
    /// - Only the symmetric parts of stiffness and damping are included. The stiffness of friction
    ///   is omitted. For sliding contacts, this changes the limit by about one per cent
    ///   (`cargo test --test dynamics stability:: -- --nocapture`), and by more if a weak contact
    ///   slides fast.
    /// - Only the growth that a time step causes is included. A system that is unstable by nature, such as a pencil on its tip, is unstable
    ///   with any step.
    /// - Beyond the limit, friction makes bodies at rest chatter, at speeds of about hμF/(2m) (m/s), because the force of friction is
    ///   bounded.
    /// - Derivatives of the state are ignored.
    ///
    /// Each contact without friction is linearized once, and each contact with friction twice.
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
    /// - If the state has another number of bodies than the world, a pose that is not rigid, or a number that is not finite.
    /// - If the world has joints, because explicit steps do not support them.
    pub fn largest_stable_step(&self, state: &State<T>) -> Result<Option<f64>, WorldError> {
        state.check_fits(self.bodies())?;
        self.model.refuse_joints("the stability limit")?;
        let rates = self.model.rates(&state.bodies, true);
        Ok(stability_limit(&rates, state.bodies.len()))
    }
}

impl<T: Scalar> Model<T> {
    /// Stability limit (s) of the contacts of a state, and the contacts, or `None` if the contacts
    /// resist no motion. Friction is omitted, because the chatter of bodies at rest is bounded.
    fn limit_without_friction(&self, states: &[BodyState<T>]) -> Option<(f64, Vec<PairRates>)> {
        let rates = self.rates(states, false);
        stability_limit(&rates, states.len()).map(|limit| (limit, rates))
    }

    /// Potential energy (J) of the contact of two bodies.
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
            let body = |index: usize| RealBody::of(&self.bodies[index], &states[index]);
            let bodies = [body(i)?, body(j)?];
            PairRates::of([i, j], &bodies, self.slip_tolerance, with_friction)
        });
        rates.into_iter().flatten().collect()
    }
}
