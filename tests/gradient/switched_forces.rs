//! Forces that switch at a given time. All passes through a rollout evaluate them at the same times, bit for bit.

use super::reverse::SAME;
use crate::support::scenes::Random;
use crate::support::worlds::{dynamic, falling, fixed, icosphere, plan_of, rubbing, sliding_at};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, BodyState, Force, ForceContext, Integrator, Material, Plan, Trajectory, World,
    WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, Mode, Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

const INTEGRATORS: [Integrator; 4] = [
    Integrator::Leapfrog,
    Integrator::SymplecticEuler,
    Integrator::Sdirk3,
    Integrator::ImplicitEuler,
];

/// Pushes the first body by the parameter "before" until a time, and by the parameter "after" from then on. Records the times of its
/// evaluations.
struct Switched {
    at: f64,
    asked_at: Arc<Mutex<BTreeSet<u64>>>,
}

impl Force for Switched {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        self.asked_at.lock().unwrap().insert(now.time.to_bits());
        let name = if now.time < self.at {
            "before"
        } else {
            "after"
        };
        let push = now.parameter(name).unwrap();
        wrenches.apply_force_at_com(0, &Vector3::new(push, push * 0.3, lift(0.0)));
    }
}

/// A weighted sum of the final velocity and position of the first body.
struct End;

impl Outcome for End {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let body = &trajectory.last().bodies[0];
        let [p, v] = [body.position(), body.velocity()].map(|x| x.x + x.y * 0.7 + x.z * 0.4);
        vec![p * 3.0 + v]
    }
}

struct Case {
    world: World<f64, Switched>,
    plan: Plan,
    asked_at: Arc<Mutex<BTreeSet<u64>>>,
}

/// Returns a ball above a floor or in it, a plate on a path beside the ball, and a switch after a whole or fractional number of steps.
fn case(random: &mut Random, ball: &Arc<Shape>, integrator: Integrator) -> Case {
    let step = [1e-3, 2e-3, 3e-3, 5e-3, 7e-3, 1e-2][random.below(6)];
    let step = step * [1.0, 1.0, random.between(0.5, 1.0)][random.below(3)];
    let steps = 2 + random.below(40);
    let part = [0.0, 0.0, 0.25, 0.5, random.between(0.0, 1.0)][random.below(5)];
    let at = (random.below(steps) as f64 + part) * step;
    let skin = rubbing(3e3, 0.3, 0.2);
    let height = random.between(0.047, 0.07);
    let path = |time: f64| BodyState {
        pose: Pose::from_translation(vector![0.0, 0.2 - 0.3 * time, 0.05]),
        twist: sliding_at(vector![0.0, -0.3, 0.0]),
    };
    let moving = dynamic("ball", Arc::clone(ball), skin, 1.0);
    let mut bodies = vec![
        moving
            .with_pose(Pose::from_translation(vector![0.0, 0.0, height]))
            .with_velocity(random.vector() * 0.3),
        fixed(
            "floor",
            HalfSpace::rigid(),
            Material::rigid().with_friction(0.2),
        ),
    ];
    if random.below(2) == 0 {
        bodies.push(Body::kinematic("plate", Arc::clone(ball), skin, Arc::new(path)).unwrap());
    }
    let asked_at = Arc::default();
    let force = Switched {
        at,
        asked_at: Arc::clone(&asked_at),
    };
    let world = falling(bodies)
        .with_slip_tolerance(0.1)
        .and_then(|world| world.with_forces(force))
        .and_then(|world| world.with_force_parameter("before", random.between(-5.0, 5.0)))
        .and_then(|world| world.with_force_parameter("after", random.between(-50.0, 50.0)))
        .unwrap();
    let plan = plan_of(integrator, step, steps);
    Case {
        world,
        plan,
        asked_at,
    }
}

/// Times that are summed in two orders may differ by one ulp, and a stage may then lie on the other side of the switch. Such a stage would
/// change the derivative by about a thousandth.
#[test]
fn forwards_and_backwards_agree_in_a_thousand_worlds_with_a_switch() {
    let ball = Arc::new(icosphere(0.05, 1));
    let mut random = Random::numbered(4711);
    for number in 0..1_000 {
        let Case {
            world,
            plan,
            asked_at,
        } = case(&mut random, &ball, INTEGRATORS[number % 4]);
        let experiment = Experiment::new(&world, &plan);
        let by = [
            Parameter::force_parameter("before"),
            Parameter::force_parameter("after"),
            Parameter::initial_velocity("ball"),
        ];
        experiment.value(&End).unwrap();
        let in_values = std::mem::take(&mut *asked_at.lock().unwrap());
        let [forward, reverse] = [Mode::Forward, Mode::Reverse]
            .map(|mode| experiment.gradient_with_mode(mode, &by, &End).unwrap().1);
        let error = (&forward - &reverse).amax() / forward.amax();
        assert!(error <= SAME, "{number}, {plan:?}: {forward} {reverse}");
        let asked_at = asked_at.lock().unwrap();
        assert!(
            asked_at.is_subset(&in_values),
            "{number}, {plan:?}: passes with derivatives evaluate forces at other times"
        );
    }
}
