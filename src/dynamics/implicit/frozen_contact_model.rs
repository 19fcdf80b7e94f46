//! Local model of the contact of two bodies near a state.

use super::about_centers::{PairGeometry, PairMatrix, PairVector, joined};
use super::step_context::Pair;
use crate::contact::{AddedByLaw, ContactWrench, FrozenContact, LinearizedContact};
use nalgebra::{SMatrix, Vector6};

/// Local model of a contact about the centers of mass: frozen polygons with an exact contact law, plus a linear part.
pub(super) struct FrozenContactModel {
    /// Indices of the bodies among the participants of the island.
    pub bodies: [usize; 2],
    contact: FrozenContact,
    pub wrenches: PairVector,
    /// Derivatives of the elastic contact with respect to displacements. If the derivatives that
    /// frozen polygons omit were computed, these are added.
    by_displacements: PairMatrix,
    /// Derivatives with respect to velocities that frozen polygons omit, or zero if they were not
    /// computed.
    by_velocities: PairMatrix,
    velocity_maps: [SMatrix<f64, 6, 12>; 2],
    velocity: Vector6<f64>,
}

/// Wrenches of a contact, with their derivatives.
pub(super) struct PairWrenches {
    /// Indices of the bodies among the participants of the island.
    pub bodies: [usize; 2],
    pub wrenches: PairVector,
    pub by_displacements: PairMatrix,
    pub by_velocities: PairMatrix,
}

/// Wrenches of a contact near the evaluated state.
pub(super) struct NearbyWrenches {
    pub wrenches: PairVector,
    added: AddedByLaw,
}

impl PairWrenches {
    /// Wrenches with all exact first derivatives.
    pub fn of(geometry: &PairGeometry, bodies: [usize; 2], contact: &LinearizedContact) -> Self {
        let [by_displacements, by_velocities] = geometry.linearized(contact);
        Self {
            bodies,
            wrenches: geometry.wrenches([&contact.wrench.on_a, &contact.wrench.on_b]),
            by_displacements,
            by_velocities,
        }
    }
}

impl FrozenContactModel {
    /// Model with the exact derivatives of the contact law, or with the derivatives on frozen
    /// polygons. `None` if the bodies do not touch.
    pub fn of(pair: &Pair, bodies: [usize; 2], is_exact: bool) -> Option<Self> {
        let contact = pair.frozen()?;
        let geometry = pair.geometry();
        let ContactWrench { on_a, on_b } = &contact.wrench;
        let maps = geometry.relative_velocity();
        let twists = pair.states().map(|state| Some(state.twist.to_vector()));
        let velocity = maps.by_velocities * joined(twists);
        let mut contact_model = FrozenContactModel {
            bodies,
            wrenches: geometry.wrenches([on_a, on_b]),
            by_displacements: geometry.by_displacements(&contact.by_poses, [on_a, on_b]),
            velocity_maps: [maps.by_velocities, maps.by_displacements],
            by_velocities: PairMatrix::zeros(),
            velocity,
            contact,
        };
        if is_exact && contact_model.contact.is_dissipative() {
            let [by_displacements, by_velocities] = geometry.linearized(&pair.linearized());
            let frozen = contact_model.evaluated();
            contact_model.by_displacements += by_displacements - frozen.by_displacements;
            contact_model.by_velocities = by_velocities - frozen.by_velocities;
        }
        Some(contact_model)
    }

    /// Returns whether dissipation or friction adds to the wrenches.
    pub fn is_dissipative(&self) -> bool {
        self.contact.is_dissipative()
    }

    /// Wrenches at the evaluated state, with their derivatives.
    pub fn evaluated(&self) -> PairWrenches {
        self.linearized(&NearbyWrenches {
            wrenches: self.wrenches,
            added: self.contact.added,
        })
    }

    /// Wrenches after displacements of the bodies and changes of their velocities.
    pub fn near(&self, displacements: &PairVector, velocities: &PairVector) -> NearbyWrenches {
        let mut wrenches =
            self.wrenches + self.by_displacements * displacements + self.by_velocities * velocities;
        let mut added = self.contact.added;
        if self.contact.is_dissipative() {
            let [by_velocities, by_displacements] = &self.velocity_maps;
            let motion = -(by_velocities * displacements);
            let velocity =
                self.velocity + by_velocities * velocities + by_displacements * displacements;
            added = self.contact.added(&motion, &velocity);
            // The transposed map converts the added wrench on A into wrenches on both bodies that do the same work.
            wrenches += by_velocities.tr_mul(&(added.wrench - self.contact.added.wrench));
        }
        NearbyWrenches { wrenches, added }
    }

    /// Wrenches with their derivatives, including the derivatives of the contact law.
    pub fn linearized(&self, near: &NearbyWrenches) -> PairWrenches {
        let NearbyWrenches { wrenches, added } = near;
        let [by_velocities, by_displacements] = &self.velocity_maps;
        let moved = added.by_twist * by_displacements - added.by_motion * by_velocities;
        PairWrenches {
            bodies: self.bodies,
            wrenches: *wrenches,
            by_displacements: self.by_displacements + by_velocities.tr_mul(&moved),
            by_velocities: self.by_velocities
                + by_velocities.tr_mul(&(added.by_twist * by_velocities)),
        }
    }
}
