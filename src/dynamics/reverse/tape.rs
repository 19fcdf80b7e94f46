use super::schedule::next_kept;
use crate::dynamics::any_world::DynWorld;
use crate::dynamics::implicit::Trace;
use crate::dynamics::integrator::Kind;
use crate::dynamics::steps::{Checkpoint, Steps};
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
    room: usize,
    /// In the order of their places.
    kept: Vec<Kept>,
    /// The place of the next step to be kept.
    next: usize,
    /// Ends steps that are taken again once it is true.
    stop: Arc<AtomicBool>,
}

struct Kept {
    /// How many steps were taken before it.
    place: usize,
    step: StepTaken,
}

/// A step that was taken.
#[derive(Debug)]
pub(crate) struct StepTaken {
    /// From where it went on.
    pub before: Checkpoint,
    /// The ways of the islands, if it is implicit.
    pub(super) traces: Vec<Trace>,
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
                    size_of::<Option<Vector6<f64>>>() + Trace::least_size(scheme)
                }
            };
        let of_step = size_of::<Kept>() + of_body * world.system().bodies.len();
        let room = (memory / of_step).max(LEAST);
        let mut kept = Vec::new();
        // Where there is not so much to be had, it grows as far as steps are taken.
        let _ = kept.try_reserve_exact(cmp::min(room + 1, plan.steps()));
        Self {
            world,
            plan,
            room,
            kept,
            next: 0,
            stop,
        }
    }

    /// Keeps the step that comes next, if it is one to be kept, and how the last one went. To be called before the first step,
    /// and after each, with the number of steps `taken`.
    pub fn keep(&mut self, taken: usize, steps: &Steps<f64>) {
        self.keep_up_to(self.plan.steps(), taken, steps);
    }

    /// [`Self::keep`], where the steps lead to an end.
    fn keep_up_to(&mut self, end: usize, taken: usize, steps: &Steps<f64>) {
        if let Some(last) = self.kept.last_mut()
            && last.place + 1 == taken
        {
            last.step.traces = steps.traces().to_vec();
        }
        if taken < end && (taken == self.next || taken + 1 == end) {
            let (before, traces) = (steps.checkpoint(), Vec::new());
            self.kept.push(Kept {
                place: taken,
                step: StepTaken { before, traces },
            });
            self.plan_next(end);
        }
    }

    /// Chooses which step is to be kept after the last one that is, where the steps lead to an end.
    fn plan_next(&mut self, end: usize) {
        if let Some(last) = self.kept.last() {
            let others = self.room.saturating_sub(self.kept.len());
            self.next = last.place + next_kept(end - last.place, others);
        }
    }

    /// The step that so many others came before. Later ones are forgotten: each call is to ask for an earlier step than the last.
    pub fn back_to(&mut self, taken: usize) -> Result<&StepTaken, RolloutError> {
        let kept = self.kept.partition_point(|kept| kept.place <= taken);
        self.kept.truncate(kept);
        if self.kept[kept - 1].place < taken {
            self.take_again(taken + 1)?;
        }
        Ok(&self.kept[self.kept.len() - 1].step)
    }

    /// Takes the steps from the last that is kept to an end.
    fn take_again(&mut self, end: usize) -> Result<(), RolloutError> {
        self.plan_next(end);
        let last = &self.kept[self.kept.len() - 1];
        let first = last.place;
        let steps = Steps::resumed(&last.step.before, self.world, first);
        let mut steps = steps.with_cancel_flag(Arc::clone(&self.stop));
        // They were checked when they were taken first.
        let plan = self.plan.without_stability_check();
        for taken in first + 1..=end {
            steps.advance(self.world, &plan)?;
            self.keep_up_to(end, taken, &steps);
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
    fn read(world: &World, plan: &Plan, room: usize) -> Vec<String> {
        let mut tape = Tape {
            room,
            ..Tape::new(world, plan, 0, Arc::default())
        };
        let mut steps = Steps::from(world.initial_state());
        tape.keep(0, &steps);
        for taken in 1..=plan.steps() {
            steps.advance(world, plan).unwrap();
            tape.keep(taken, &steps);
        }
        let places = (0..plan.steps()).rev();
        places
            .map(|taken| format!("{:?}", tape.back_to(taken).unwrap()))
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
            for room in [1, 2, 3, 7, 38, 39] {
                assert!(read(&world(), &plan, room) == all);
            }
        }
    }

    /// Without the wrenches of the last step, those at the start of the next one would be evaluated anew.
    #[test]
    fn steps_resumed_from_a_checkpoint_take_what_the_others_take() {
        let world = world();
        let plan = Plan::new(5e-3, 40).unwrap();
        let plan = plan.with_integrator(Integrator::Sdirk3);
        let mut steps = Steps::from(world.initial_state());
        for taken in 0..plan.steps() {
            let mut resumed = Steps::resumed(&steps.checkpoint(), &world, taken);
            let reports = [&mut steps, &mut resumed].map(|steps| {
                steps.advance(&world, &plan).unwrap();
                steps.memory.as_ref().map(|memory| memory.report.clone())
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
            let mut steps = Steps::from(world.initial_state());
            tape.keep(0, &steps);
            for taken in 1..=3 {
                steps.advance(&world, &plan).unwrap();
                tape.keep(taken, &steps);
            }
            assert!(!tape.kept.is_empty());
        }
    }
}
