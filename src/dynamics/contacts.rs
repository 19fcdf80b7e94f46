use super::model::Model;
use super::sweep::Sweep;
use super::{Force, State, World, WorldError};
use crate::contact::{ContactSurface, ContactWrench};
use crate::parallel::mapped_into;
use crate::scalar::Scalar;

/// Contact of two bodies of a world.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Contact<T = f64> {
    /// Indices of the bodies in the world, A first. Body A is compliant and has a mesh. If both bodies have a mesh, A is the one with the
    /// smaller index.
    pub bodies: [usize; 2],
    /// Contact surface, in the world frame.
    pub surface: ContactSurface<T>,
    /// Wrench on each body about the origin of its frame, in world axes. It includes friction and dissipation.
    pub wrench: ContactWrench<T>,
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Contacts of a state, sorted by the indices of their bodies. Ignored pairs and pairs without a dynamic body are omitted.
    ///
    /// # Errors
    /// If the state has another number of bodies than the world, a pose that is not rigid, or a
    /// number that is not finite.
    pub fn contacts(&self, state: &State<T>) -> Result<Vec<Contact<T>>, WorldError> {
        state.check_fits(self.bodies())?;
        Ok(self.model.contacts(state))
    }
}

impl<T: Scalar> Model<T> {
    /// Contacts of a state that fits the bodies.
    pub(crate) fn contacts(&self, state: &State<T>) -> Vec<Contact<T>> {
        let (mut sweep, mut contacts) = (Sweep::default(), Vec::new());
        let pairs = self.close_pairs(&state.bodies, &mut sweep);
        mapped_into(&mut contacts, pairs, |&(i, j)| {
            let (bodies, states) = ([i, j], [&state.bodies[i], &state.bodies[j]]);
            let (surface, wrench) = self.pair_of(bodies, states)?.surface_and_wrench()?;
            Some(Contact {
                bodies,
                surface,
                wrench,
            })
        });
        let mut contacts: Vec<_> = contacts.into_iter().flatten().collect();
        contacts.sort_by_key(|contact| contact.bodies);
        contacts
    }
}
