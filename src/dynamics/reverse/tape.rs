use crate::dynamics::any_world::AnyWorld;
use crate::dynamics::steps::Steps;
use crate::dynamics::{BodyState, Plan, RolloutError, State};

/// States of up to so many bytes are all kept.
const ROOM: usize = 256 << 20;

/// The states of a rollout, to be read from the last to the first: all of them are kept, or one in so many, from which the
/// others are computed again, with the same bits.
pub(crate) struct Tape<'w> {
    world: &'w dyn AnyWorld<f64>,
    plan: &'w Plan,
    /// Steps from one state that is kept to the next.
    stride: usize,
    kept: Vec<State>,
    /// The states that follow one that is kept.
    stretch: Vec<State>,
}

impl<'w> Tape<'w> {
    /// Of no steps yet.
    pub fn new(world: &'w dyn AnyWorld<f64>, plan: &'w Plan) -> Self {
        let steps = plan.steps();
        let bytes = steps.saturating_mul(size_of::<BodyState>() * world.system().bodies.len());
        Self {
            world,
            plan,
            stride: if bytes <= ROOM { 1 } else { steps.isqrt() },
            kept: Vec::new(),
            stretch: Vec::new(),
        }
    }

    /// Takes down the state after so many steps; to be called for each of them.
    pub fn keep(&mut self, taken: usize, state: &State) {
        if taken.is_multiple_of(self.stride) && taken < self.plan.steps() {
            self.kept.push(state.clone());
        }
    }

    /// The state after so many steps, of which those after later ones are not asked for again.
    pub fn back_to(&mut self, taken: usize) -> Result<&State, RolloutError> {
        let (place, further) = (taken / self.stride, taken % self.stride);
        self.kept.truncate(place + 1);
        if further == 0 {
            self.stretch.clear();
        } else if self.stretch.is_empty() {
            let first = self.kept[place].clone();
            let mut steps = Steps::resumed(first, self.world, place * self.stride);
            for _ in 0..further {
                let state = steps.advance(self.world, self.plan)?.clone();
                self.stretch.push(state);
            }
        }
        self.stretch.truncate(further);
        Ok(self.stretch.last().unwrap_or(&self.kept[place]))
    }
}
