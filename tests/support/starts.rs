//! Worlds with many initial states.

use hydroelastic::dynamics::{Force, State, World};

/// Returns the world with each state as its initial state.
pub fn starting_from<F: Force>(world: &World<f64, F>, states: &[State]) -> Vec<World<f64, F>> {
    let start = |state: &State| world.clone().with_initial_state(state).unwrap();
    states.iter().map(start).collect()
}
