//! Gradient with respect to the centers of mass of the links of a multibody.
//!
//! Let d be the shift of the center of mass in the body, in world axes, and let ω be the spin of the body.
//!
//! - Body on a joint: all poses are constant. The center of mass moves by d, and its velocity changes by ω × d.
//! - Free body: the coordinates are those of the center of mass, and are constant. The origin of the body and its descendants move by −d, and
//!   their velocities change by −ω × d. This is the change of a body on a joint, followed by a displacement of the coordinates by −d.
//!
//! The residual of a stage is (S − τṠ)ᵀH − p̃ − τSᵀF. It is multiplied by generalized velocities λ. For each link, let m be the mass, v the
//! velocity of the center of mass and f the force. (α, a) is the twist about the center of mass along the axes S − τṠ, and σ is the spin along
//! the axes S. For a free body, sums are over the body and its descendants, and P = Σmv. The derivatives with respect to d are:
//!
//! | product | body on a joint | in addition for a free body |
//! |---|---|---|
//! | λᵀ(S − τṠ)ᵀH | m(v × α + a × ω) | −(Y − τP × σ) × ω − P × σ, with Y = Σ(ma + τmv × σᵢ) and the spin σᵢ of each link |
//! | λᵀSᵀF | f × σ | −Σf × σ |
//!
//! Y is the derivative with respect to a common velocity of the links. The terms with P and Σf come from the displacement of λ.

use super::pullback::Pullback;
use crate::dynamics::joint::JointKind;
use crate::dynamics::multibody::{Kinematics, Multibody};
use crate::spatial::Twist;
use nalgebra::{DVector, Vector3, Vector6};

impl Multibody {
    /// Indices of a free link and its descendants.
    fn moved_by(&self, free: usize) -> impl Iterator<Item = usize> {
        let column = self.links[free].columns.start;
        let links = self.links.iter().enumerate();
        links.filter_map(move |(index, link)| {
            let is_moved = link.moving_columns.contains(&column);
            is_moved.then_some(index)
        })
    }
}

impl Pullback<'_> {
    /// Propagates the gradient with respect to projected momenta (S − τṠ)ᵀH, at a duration τ (s), to the centers of mass.
    pub(super) fn add_by_centers_in_momenta(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        (by_momenta, duration): (&DVector<f64>, f64),
    ) {
        let [twists, turns] = [duration, 0.0].map(|duration| {
            let twists = multibody.twists(kinematics, by_momenta, duration);
            let twists = twists.iter().map(Twist::from_vector);
            twists.collect::<Vec<_>>()
        });
        for (index, link) in multibody.links.iter().enumerate() {
            let (state, twist) = (&kinematics.states[index], &twists[index]);
            let Twist { angular, linear } = &state.twist;
            let own = linear.cross(&twist.angular) + twist.linear.cross(angular);
            let mut by_center = own * link.inertia.mass;
            if link.kind == JointKind::Free {
                let turn = &turns[index].angular;
                for moved in multibody.moved_by(index) {
                    let mass = multibody.links[moved].inertia.mass;
                    let momentum = kinematics.states[moved].twist.linear * mass;
                    let relative_turn = turns[moved].angular - turn;
                    let by_velocity =
                        twists[moved].linear * mass + momentum.cross(&relative_turn) * duration;
                    by_center -= by_velocity.cross(angular) + momentum.cross(turn);
                }
            }
            self.add_by_center(link.body, state, &by_center);
        }
    }

    /// Propagates λ to the centers of mass, through the wrenches on the links about their centers of mass in a stage of a duration (s).
    /// `twists` are the twists of the links with the generalized velocities λ.
    pub(super) fn add_by_centers_in_forces(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        [twists, wrenches]: [&[Vector6<f64>]; 2],
        duration: f64,
    ) {
        let force_on = |link: usize| wrenches[link].fixed_rows::<3>(3).into_owned();
        for (index, link) in multibody.links.iter().enumerate() {
            let mut force: Vector3<f64> = force_on(index);
            if link.kind == JointKind::Free {
                force -= multibody
                    .moved_by(index)
                    .map(force_on)
                    .sum::<Vector3<f64>>();
            }
            let turn = Twist::from_vector(&twists[index]).angular;
            let by_center = force.cross(&turn) * duration;
            self.add_by_center(link.body, &kinematics.states[index], &by_center);
        }
    }

    /// Propagates the gradients with respect to the states of the links, taken as [`Self::take_gradient`] does, to the centers of mass.
    /// `by_twists` are the gradients with respect to the twists of the links, and `gradients` the gradients with respect to the coordinates.
    pub(super) fn add_by_centers_in_states(
        &mut self,
        multibody: &Multibody,
        kinematics: &Kinematics,
        by_twists: &[Vector6<f64>],
        [by_position, by_velocity]: &[DVector<f64>; 2],
    ) {
        for (index, link) in multibody.links.iter().enumerate() {
            let state = &kinematics.states[index];
            let mut by_velocity_of_center = Twist::from_vector(&by_twists[index]).linear;
            let mut by_center = Vector3::zeros();
            if link.kind == JointKind::Free {
                let translation = link.columns.start + 3;
                let of =
                    |gradient: &DVector<f64>| gradient.fixed_rows::<3>(translation).into_owned();
                by_velocity_of_center -= of(by_velocity);
                by_center -= of(by_position);
            }
            by_center += by_velocity_of_center.cross(&state.twist.angular);
            self.add_by_center(link.body, state, &by_center);
        }
    }
}
