use super::schedule::next_checkpoint;
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::implicit::IslandRecord;
use crate::dynamics::integrator::Kind;
use crate::dynamics::steps::{Checkpoint, Stepper};
use crate::dynamics::{BodyState, Plan, RolloutError};
use nalgebra::Vector6;
use std::cmp;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// As many steps are kept even where they take more than the memory allowed.
const LEAST: usize = 16;

/// The steps of a rollout, to be read from the last to the first. As many are kept as the memory allows; from these the others are
/// taken again, with the same bits.
pub(crate) struct Tape<'w> {
    world: &'w dyn DynWorld<f64>,
    plan: &'w Plan,
    /// How many steps may be kept, beside the one that is read next.
    capacity: usize,
    /// In the order of their places.
    entries: Vec<TapeEntry>,
    /// The place of the next step to be kept.
    next_checkpoint: usize,
    /// Ends steps that are taken again once it is true.
    stop: Arc<AtomicBool>,
}

struct TapeEntry {
    /// How many steps were taken before it.
    step_count: usize,
    step: RecordedStep,
}

/// A step that was taken.
#[derive(Debug)]
pub(crate) struct RecordedStep {
    /// From where it went on.
    pub before: Checkpoint,
    /// The ways of the islands, if it is implicit.
    pub(super) island_records: Vec<IslandRecord>,
}

impl<'w> Tape<'w> {
    /// Without steps yet, with room for as many as go into this memory (bytes): counted as if none were divided, although
    /// divided steps take more.
    pub fn new(
        world: &'w dyn DynWorld<f64>,
        plan: &'w Plan,
        memory: usize,
        stop: Arc<AtomicBool>,
    ) -> Self {
        let of_body = size_of::<BodyState>()
            + match plan.integrator().kind() {
                Kind::Explicit(_) => 0,
                Kind::Implicit(scheme) => {
                    size_of::<Option<Vector6<f64>>>() + IslandRecord::min_size(scheme)
                }
            };
        let of_step = size_of::<TapeEntry>() + of_body * world.model().bodies.len();
        let capacity = (memory / of_step).max(LEAST);
        let mut entries = Vec::new();
        // Where there is not so much to be had, it grows as far as steps are taken.
        let _ = entries.try_reserve_exact(cmp::min(capacity + 1, plan.steps()));
        Self {
            world,
            plan,
            capacity,
            entries,
            next_checkpoint: 0,
            stop,
        }
    }

    /// Keeps the step that comes next, if it is one to be kept, and how the last one went. To be called before the first step,
    /// and after each, with the number of steps `taken`.
    pub fn record(&mut self, step_count: usize, steps: &Stepper<f64>) {
        self.record_up_to(self.plan.steps(), step_count, steps);
    }

    /// [`Self::keep`], where the steps lead to an end.
    fn record_up_to(&mut self, end: usize, step_count: usize, steps: &Stepper<f64>) {
        if let Some(last) = self.entries.last_mut()
            && last.step_count + 1 == step_count
        {
            last.step.island_records = steps.island_records().to_vec();
        }
        if step_count < end && (step_count == self.next_checkpoint || step_count + 1 == end) {
            let (before, island_records) = (steps.checkpoint(), Vec::new());
            self.entries.push(TapeEntry {
                step_count,
                step: RecordedStep {
                    before,
                    island_records,
                },
            });
            self.plan_next(end);
        }
    }

    /// Chooses which step is to be kept after the last one that is, where the steps lead to an end.
    fn plan_next(&mut self, end: usize) {
        if let Some(last) = self.entries.last() {
            let slots = self.capacity.saturating_sub(self.entries.len());
            self.next_checkpoint = last.step_count + next_checkpoint(end - last.step_count, slots);
        }
    }

    /// The step that so many others came before. Later ones are forgotten: each call is to ask for an earlier step than the last.
    pub fn rewind_to(&mut self, step_count: usize) -> Result<&RecordedStep, RolloutError> {
        let count = self
            .entries
            .partition_point(|entry| entry.step_count <= step_count);
        self.entries.truncate(count);
        if self.entries[count - 1].step_count < step_count {
            self.repeat_steps(step_count + 1)?;
        }
        Ok(&self.entries[self.entries.len() - 1].step)
    }

    /// Takes the steps from the last that is kept to an end.
    fn repeat_steps(&mut self, end: usize) -> Result<(), RolloutError> {
        self.plan_next(end);
        let last = &self.entries[self.entries.len() - 1];
        let first = last.step_count;
        let steps = Stepper::resumed(&last.step.before, self.world, first);
        let mut steps = steps.with_cancel_flag(Arc::clone(&self.stop));
        // They were checked when they were taken first.
        let plan = self.plan.without_stability_check();
        for step_count in first + 1..=end {
            steps.advance(self.world, &plan)?;
            self.record_up_to(end, step_count, &steps);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{HalfSpace, Shape};
    use crate::dynamics::{Body, Integrator, Mass, Material, World};
    use crate::mesh::shapes;
    use crate::spatial::Pose;
    use nalgebra::vector;

    /// A brick that falls on a corner and slides.
    fn world() -> World {
        let skin = Material::elastic(1e6)
            .with_friction(0.3)
            .with_dissipation(0.2);
        let brick = Shape::new(shapes::cuboid([0.2, 0.15, 0.1]).unwrap());
        let start = Pose::from_rotation_vector(&vector![0.2, 0.1, 0.3], vector![0.0, 0.0, 0.1]);
        let brick = Body::dynamic("brick", brick, skin, Mass::Total(1.0)).unwrap();
        let floor = Body::fixed("floor", HalfSpace::rigid(), Material::rigid()).unwrap();
        let bodies = vec![
            brick
                .with_pose(start)
                .with_velocity(vector![0.7, 0.1, -1.0]),
            floor,
        ];
        let world = World::new(bodies).unwrap();
        world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
    }

    /// All steps, the last first, as they are written down to the last bit.
    fn read(world: &World, plan: &Plan, capacity: usize) -> Vec<String> {
        let mut tape = Tape {
            capacity,
            ..Tape::new(world, plan, 0, Arc::default())
        };
        let mut steps = Stepper::from(world.initial_state());
        tape.record(0, &steps);
        for step_count in 1..=plan.steps() {
            steps.advance(world, plan).unwrap();
            tape.record(step_count, &steps);
        }
        let counts = (0..plan.steps()).rev();
        counts
            .map(|step_count| format!("{:?}", tape.rewind_to(step_count).unwrap()))
            .collect()
    }

    #[test]
    fn steps_that_are_not_kept_are_taken_again_with_the_same_bits() {
        for (integrator, time_step) in [
            (Integrator::Leapfrog, 1e-3),
            (Integrator::Sdirk3, 5e-3),
            (Integrator::ImplicitEuler, 5e-3),
        ] {
            let plan = Plan::new(time_step, 40).unwrap();
            let plan = plan.with_integrator(integrator);
            let all = read(&world(), &plan, 40);
            for capacity in [1, 2, 3, 7, 38, 39] {
                assert!(read(&world(), &plan, capacity) == all);
            }
        }
    }

    /// Without the wrenches of the last step, those at the start of the next one would be evaluated anew.
    #[test]
    fn steps_resumed_from_a_checkpoint_take_what_the_others_take() {
        let world = world();
        let plan = Plan::new(5e-3, 40).unwrap();
        let plan = plan.with_integrator(Integrator::Sdirk3);
        let mut steps = Stepper::from(world.initial_state());
        for step_count in 0..plan.steps() {
            let mut resumed = Stepper::resumed(&steps.checkpoint(), &world, step_count);
            let reports = [&mut steps, &mut resumed].map(|steps| {
                steps.advance(&world, &plan).unwrap();
                steps
                    .integrator_state
                    .as_ref()
                    .map(|state| state.report.clone())
            });
            assert_eq!(reports[0], reports[1]);
        }
    }

    /// A rollout that is stopped, or ends early, needs no memory for the steps that it does not take.
    #[test]
    fn plans_longer_than_any_memory_are_begun() {
        let (world, plan) = (world(), Plan::new(5e-3, usize::MAX).unwrap());
        for memory in [0, usize::MAX] {
            let mut tape = Tape::new(&world, &plan, memory, Arc::default());
            let mut steps = Stepper::from(world.initial_state());
            tape.record(0, &steps);
            for step_count in 1..=3 {
                steps.advance(&world, &plan).unwrap();
                tape.record(step_count, &steps);
            }
            assert!(!tape.entries.is_empty());
        }
    }
}
