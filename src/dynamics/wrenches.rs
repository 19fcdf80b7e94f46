use super::dyn_world::DynWorld;
use super::model::Model;
use super::sweep::Sweep;
use super::workspace::Workspace;
use super::{
    Body, BodyState, Force, ForceContext, State, TimeSpan, World, WorldError, WrenchAccumulator,
};
use crate::contact::{ContactBody, ContactPair, ContactWrench, Partner};
use crate::parallel::mapped_into;
use crate::scalar::{Scalar, lift, lift_vector};
use crate::spatial::Wrench;
use nalgebra::{Vector3, Vector6};

/// Wrench of everything but gravity on each body, about its center of mass, in world axes. Controls are averaged over a time step.
pub(super) fn all_wrenches<'s, T: Scalar>(
    world: &dyn DynWorld<T>,
    state: &State<T>,
    span: TimeSpan,
    workspace: &'s mut Workspace<T>,
) -> &'s [Wrench<T>] {
    let model = world.model();
    model.add_contact(&state.bodies, workspace);
    let Workspace { contact, all, .. } = workspace;
    all.clone_from(contact);
    model.with_forces(
        (state.time, &state.bodies, contact),
        all,
        |wrenches, now| {
            model.add_controls(wrenches, now, span);
            world.add_forces(wrenches, now);
        },
    );
    all
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Contact of two bodies in a state, with its surface, its wrench with friction and dissipation, and its derivatives. Body A is
    /// `first`, unless that body is rigid or a half-space.
    ///
    /// # Errors
    /// - If one of the names is unknown, or both are the same.
    /// - If neither body is compliant with a mesh.
    /// - If the state does not fit the world.
    pub fn contact_between(
        &self,
        state: &State<T>,
        first: &str,
        second: &str,
    ) -> Result<ContactPair<'_, T>, WorldError> {
        let (i, j) = (self.index_of(first)?, self.index_of(second)?);
        if i == j {
            return Err(WorldError::SameBody(first.to_owned()));
        }
        state.check_fits(self.bodies())?;
        let states = &state.bodies;
        let pair = self.model.pair_of([i, j], [&states[i], &states[j]]);
        let pair = pair.or_else(|| self.model.pair_of([j, i], [&states[j], &states[i]]));
        pair.ok_or_else(|| WorldError::NoContact([first.to_owned(), second.to_owned()]))
    }
}

impl<T: Scalar> Model<T> {
    /// Calls `add` with an accumulator of wrenches and the context of forces, for states at a time (s) and the contact wrenches on the
    /// bodies.
    pub(super) fn with_forces(
        &self,
        (time, states, contact): (f64, &[BodyState<T>], &[Wrench<T>]),
        sums: &mut [Wrench<T>],
        add: impl FnOnce(&mut WrenchAccumulator<T>, &ForceContext<T>),
    ) {
        let now = ForceContext {
            time,
            bodies: &self.bodies,
            states,
            gravity: &self.gravity,
            contact,
            parameters: &self.force_parameters,
        };
        add(&mut WrenchAccumulator::new(&now, sums), &now);
    }

    /// Adds the mean controls over a time step.
    pub(super) fn add_controls(
        &self,
        wrenches: &mut WrenchAccumulator<T>,
        now: &ForceContext<T>,
        span: TimeSpan,
    ) {
        for control in &self.controls {
            if let Some(body) = now.index_of(control.body()) {
                wrenches.add(body, &control.mean_over(span));
            }
        }
    }

    /// Weight and mean control of each body over a time step: torque and force about the center of mass.
    pub(super) fn applied_wrenches(&self, span: TimeSpan) -> Vec<Vector6<T>> {
        let weight = |body: &Body<T>| {
            let mass = body.inertia().map_or(lift(0.0), |inertia| inertia.mass);
            let force = self.gravity.map(|component| component * mass);
            let torque = lift_vector(&Vector3::zeros());
            Wrench { torque, force }.to_vector()
        };
        let mut applied: Vec<_> = self.bodies.iter().map(weight).collect();
        for control in &self.controls {
            if let Ok(body) = self.index_of(control.body()) {
                applied[body] += control.mean_over(span).to_vector();
            }
        }
        applied
    }

    /// Net contact wrench on each body, about its center of mass, in world axes.
    fn add_contact(&self, states: &[BodyState<T>], workspace: &mut Workspace<T>) {
        let Workspace {
            sweep,
            pair_wrenches,
            contact: wrenches,
            ..
        } = workspace;
        let pairs = self.close_pairs(states, sweep);
        mapped_into(pair_wrenches, pairs, |&(i, j)| {
            self.pair_wrench(states, i, j)
        });
        wrenches.clear();
        wrenches.resize(states.len(), Wrench::zero());
        // Sum in the order of the pairs, not in the order in which threads finish, because another order rounds differently.
        for (&(i, j), contact) in pairs.iter().zip(&*pair_wrenches) {
            wrenches[i] += contact.on_a;
            wrenches[j] += contact.on_b;
        }
        for (index, wrench) in wrenches.iter_mut().enumerate() {
            if let Some(inertia) = self.bodies[index].inertia() {
                let to_center = states[index].pose.rotated_constant(&inertia.center_of_mass);
                *wrench = wrench.about(&to_center);
            }
        }
    }

    /// Pairs that may touch, A first: [valid pairs](Self::ordered_pair) whose bounding boxes overlap in the world.
    pub(super) fn close_pairs<'s>(
        &self,
        states: &[BodyState<T>],
        sweep: &'s mut Sweep,
    ) -> &'s [(usize, usize)] {
        let boxes = self
            .bodies
            .iter()
            .zip(states)
            .map(|(body, state)| body.shape.bounds_at(&state.pose.real()));
        sweep.overlapping(boxes, |i, j| self.ordered_pair(i, j))
    }

    /// Contact of two bodies in these states, if the first is compliant with a mesh. The contact is in motion if either body has
    /// dissipation or friction.
    #[inline]
    pub(super) fn pair_of(
        &self,
        indices: [usize; 2],
        states: [&BodyState<T>; 2],
    ) -> Option<ContactPair<'_, T>> {
        let [a, b] = indices.map(|index| &self.bodies[index]);
        let modulus = |body: &Body<T>| body.material.modulus;
        let shape_a = a.shape.compliant()?;
        let body_a = ContactBody::from_valid(shape_a, states[0].pose, modulus(a)?);
        let modulus_b = modulus(b).unwrap_or(lift(1.0));
        let partner_b = Partner::from_valid(b.shape.partner()?, states[1].pose, modulus_b);
        let pair = ContactPair::new(body_a, partner_b);
        Some(if a.is_dissipative() || b.is_dissipative() {
            let law = a.material.combined_with(&b.material, self.slip_tolerance);
            pair.moving(
                law,
                [a.twist_at_origin(states[0]), b.twist_at_origin(states[1])],
            )
        } else {
            pair
        })
    }

    pub(super) fn pair_wrench(
        &self,
        states: &[BodyState<T>],
        i: usize,
        j: usize,
    ) -> ContactWrench<T> {
        let (indices, states) = ([i, j], [&states[i], &states[j]]);
        let pair = self.pair_of(indices, states);
        pair.map_or_else(ContactWrench::zero, |pair| pair.wrench())
    }
}

#[cfg(test)]
mod tests {
    use crate::contact::Shape;
    use crate::dynamics::sweep::Sweep;
    use crate::dynamics::{Body, Mass, Material, World};
    use crate::mesh::shapes;
    use crate::spatial::Pose;
    use nalgebra::Vector3;
    use std::sync::Arc;

    fn pairs(world: &World) -> Vec<(usize, usize)> {
        let states = world.initial_state().bodies;
        world
            .model
            .close_pairs(&states, &mut Sweep::default())
            .to_vec()
    }

    #[test]
    fn pairs_with_boxes_apart_are_not_evaluated() {
        let cube = Arc::new(Shape::new(shapes::cuboid([0.2; 3]).unwrap()));
        let skin = Material::elastic(1e5);
        // On a line: two fixed cubes and three dynamic cubes. The middle dynamic cube is turned.
        let placed = |body: Body, x: f64, turn: f64| {
            let rotation_vector = Vector3::z() * turn;
            body.with_pose(Pose::from_rotation_vector(
                &rotation_vector,
                Vector3::x() * x,
            ))
        };
        let fixed = |name| Body::fixed(name, Arc::clone(&cube), skin).unwrap();
        let falling = |name| {
            let shape = Arc::clone(&cube);
            Body::dynamic(name, shape, skin, Mass::Total(1.0)).unwrap()
        };
        let world = |turn| {
            World::new(vec![
                placed(fixed("a"), 0.0, 0.0),
                placed(fixed("b"), 0.1, 0.0),
                placed(falling("c"), 0.15, 0.0),
                placed(falling("d"), 0.36, turn),
                placed(falling("e"), 0.5, 0.0),
            ])
            .unwrap()
        };
        assert_eq!(pairs(&world(0.0)), [(0, 2), (1, 2), (3, 4)]);
        // The box of a cube after an eighth of a turn is 0.28 m wide.
        let turned = world(std::f64::consts::FRAC_PI_4);
        assert_eq!(pairs(&turned), [(0, 2), (1, 2), (2, 3), (3, 4)]);
        let ignoring = turned.with_ignored("c", "a").unwrap();
        assert_eq!(pairs(&ignoring), [(1, 2), (2, 3), (3, 4)]);
    }
}
