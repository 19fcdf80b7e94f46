use crate::dynamics::dyn_world::{BodyDual, DynWorld};
use crate::dynamics::model::Model;

/// Model in which forces are differentiated. Its numbers are constants unless they are seeded.
pub(super) struct SeededForces {
    pub model: Model<BodyDual>,
    /// Indices of the bodies on whose states forces depend, sorted.
    pub coupled: Vec<usize>,
}

impl SeededForces {
    /// The model, or `None` if the world has no forces.
    pub fn of(world: &dyn DynWorld<f64>) -> Option<Self> {
        let (forces, model) = (world.real_forces(), world.model());
        if forces.is_empty() {
            return None;
        }
        let mut coupled = forces.coupling_groups(&model.bodies).concat();
        coupled.sort_unstable();
        coupled.dedup();
        Some(Self {
            model: model.lifted(),
            coupled,
        })
    }
}
