use super::schedule::next_checkpoint;
use crate::dynamics::dyn_world::DynWorld;
use crate::dynamics::implicit::IslandRecord;
use crate::dynamics::integrator::Kind;
use crate::dynamics::stepper::{Checkpoint, Stepper};
use crate::dynamics::{BodyState, Plan, RolloutError};
use nalgebra::Vector6;
use std::cmp;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Minimum number of recorded steps, even if they need more memory than allowed.
const LEAST: usize = 16;

/// Recorded steps of a rollout, which are read from the last to the first. The tape keeps as many
/// steps as the memory allows. The other steps are repeated from the recorded steps, with the same
/// bits.
#[derive(Clone)]
pub(crate) struct Tape {
    world: Arc<dyn DynWorld<f64>>,
    plan: Plan,
    /// Maximum number of recorded steps, besides the step that is read next.
    capacity: usize,
    /// Recorded steps in the order of time.
    entries: Vec<TapeEntry>,
    /// Step count at the next step to be recorded.
    next_checkpoint: usize,
    /// Cancel flag. Once it is true, repeated steps end.
    stop: Arc<AtomicBool>,
}

#[derive(Clone)]
struct TapeEntry {
    /// Number of steps before the recorded step.
    step_count: usize,
    step: RecordedStep,
}

/// Recorded step.
#[derive(Debug, Clone)]
pub(crate) struct RecordedStep {
    /// Checkpoint before the step.
    pub before: Checkpoint,
    /// Records of the islands, if the step is implicit.
    pub(super) island_records: Vec<IslandRecord>,
}

impl Tape {
    /// Empty tape with the capacity of this memory (bytes). The capacity is computed for steps without subdivision, although divided steps
    /// need more memory.
    pub fn new(
        world: Arc<dyn DynWorld<f64>>,
        plan: &Plan,
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
        // If the allocation fails, the list grows as steps are recorded.
        let _ = entries.try_reserve_exact(cmp::min(capacity + 1, plan.steps()));
        Self {
            world,
            plan: *plan,
            capacity,
            entries,
            next_checkpoint: 0,
            stop,
        }
    }

    /// Records the next step if the schedule selects it, and the islands of the last step. Call this method before the first step and after
    /// each step, with the number of steps taken.
    pub fn record(&mut self, step_count: usize, stepper: &Stepper<f64>) {
        self.record_up_to(self.plan.steps(), step_count, stepper);
    }

    /// Records as [`Self::record`], for steps that end at the step count `end`.
    fn record_up_to(&mut self, end: usize, step_count: usize, stepper: &Stepper<f64>) {
        if let Some(last) = self.entries.last_mut()
            && last.step_count + 1 == step_count
        {
            last.step.island_records = stepper.island_records().to_vec();
        }
        if step_count < end && (step_count == self.next_checkpoint || step_count + 1 == end) {
            let (before, island_records) = (stepper.checkpoint(), Vec::new());
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

    /// Chooses the step to record after the last recorded step, for steps that end at the step
    /// count `end`.
    fn plan_next(&mut self, end: usize) {
        if let Some(last) = self.entries.last() {
            let slots = self.capacity.saturating_sub(self.entries.len());
            self.next_checkpoint = last.step_count + next_checkpoint(end - last.step_count, slots);
        }
    }

    /// The step after `step_count` steps. Later steps are removed, so each call must request an earlier step than the last call.
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

    /// Repeats the steps from the last recorded step to the step count `end`.
    fn repeat_steps(&mut self, end: usize) -> Result<(), RolloutError> {
        self.plan_next(end);
        let last = &self.entries[self.entries.len() - 1];
        let first = last.step_count;
        let stepper = Stepper::resumed(&last.step.before, &*self.world, first);
        let mut stepper = stepper.with_cancel_flag(Arc::clone(&self.stop));
        // The steps were checked when they were taken first.
        let plan = self.plan.without_stability_check();
        for step_count in first + 1..=end {
            stepper.advance(&*self.world, &plan)?;
            self.record_up_to(end, step_count, &stepper);
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

    /// All steps from the last to the first, printed to the last bit.
    fn read(world: &World, plan: &Plan, capacity: usize) -> Vec<String> {
        let mut tape = Tape {
            capacity,
            ..Tape::new(Arc::new(world.clone()), plan, 0, Arc::default())
        };
        let mut stepper = Stepper::from(world.initial_state());
        tape.record(0, &stepper);
        for step_count in 1..=plan.steps() {
            stepper.advance(world, plan).unwrap();
            tape.record(step_count, &stepper);
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

    /// Without the wrenches of the last step, a resumed step would evaluate the wrenches at its start again.
    #[test]
    fn steps_resumed_from_a_checkpoint_take_what_the_others_take() {
        let world = world();
        let plan = Plan::new(5e-3, 40).unwrap();
        let plan = plan.with_integrator(Integrator::Sdirk3);
        let mut stepper = Stepper::from(world.initial_state());
        for step_count in 0..plan.steps() {
            let mut resumed = Stepper::resumed(&stepper.checkpoint(), &world, step_count);
            let reports = [&mut stepper, &mut resumed].map(|stepper| {
                stepper.advance(&world, &plan).unwrap();
                stepper
                    .integrator_state
                    .as_ref()
                    .map(|state| state.report.clone())
            });
            assert_eq!(reports[0], reports[1]);
        }
    }

    /// A rollout that ends early needs no memory for the steps that it does not take.
    #[test]
    fn plans_longer_than_any_memory_are_begun() {
        let (world, plan) = (world(), Plan::new(5e-3, usize::MAX).unwrap());
        for memory in [0, usize::MAX] {
            let mut tape = Tape::new(Arc::new(world.clone()), &plan, memory, Arc::default());
            let mut stepper = Stepper::from(world.initial_state());
            tape.record(0, &stepper);
            for step_count in 1..=3 {
                stepper.advance(&world, &plan).unwrap();
                tape.record(step_count, &stepper);
            }
            assert!(!tape.entries.is_empty());
        }
    }
}
