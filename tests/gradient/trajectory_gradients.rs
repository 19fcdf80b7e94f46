//! Gradients of whole rollouts against central differences, and the real parts of dual rollouts
//! against rollouts in `f64`.

use crate::support::worlds::{at, cuboid, dynamic, falling, fixed, icosphere, plan_of, sliding_at};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Body, BodyState, Control, Integrator, Mass, Material, Plan, Trajectory, World,
};
use hydroelastic::gradient::{
    Experiment, FinalState, GradientError, Mode, Outcome, Parameter, RecordedStates,
};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift, real_part};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{DVector, Vector6, vector};
use num_dual::DualSVec64;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Agreement with differences, relative to the largest entry of a column, without and with friction.
const ELASTIC: f64 = 1e-7;
const RUBBING: f64 = 1e-6;

/// Agreement after a thousand steps. Division of dual numbers has other rounding errors than division in `f64`.
const REAL_PARTS: f64 = 1e-11;

fn everything() -> [Parameter; 9] {
    [
        Parameter::initial_position("ball"),
        Parameter::initial_orientation("ball"),
        Parameter::initial_velocity("ball"),
        Parameter::initial_angular_velocity("ball"),
        Parameter::modulus("ball"),
        Parameter::modulus("slab"),
        Parameter::mass("ball"),
        Parameter::radius_of_gyration("ball"),
        Parameter::Gravity,
    ]
}

/// Returns an ellipsoid thrown on a slab, which bounces at least once in 0.4 s.
fn thrown(dissipation: f64, friction: f64) -> World {
    let ball = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.11, 0.09], 2).unwrap()));
    let slab = Arc::new(cuboid([1.0; 3]));
    let skin = |modulus| Material {
        modulus: Some(modulus),
        dissipation,
        friction: Some(friction),
    };
    let ball = Body::dynamic("ball", ball, skin(1e5), Mass::Density(240.0)).unwrap();
    let slab = fixed("slab", slab, skin(4e5));
    falling(vec![
        ball.with_pose(at(0.05, 0.02, 0.15))
            .with_velocity(vector![0.3, 0.1, 0.0])
            .with_angular_velocity(vector![1.0, 2.0, 0.5]),
        slab.with_pose(at(0.0, 0.0, -0.5)),
    ])
}

fn plan() -> Plan {
    Plan::new(4e-4, 1_000).unwrap().recording_every(1_000)
}

#[test]
fn without_friction_every_gradient_over_a_thousand_steps_equals_differences() {
    let world = thrown(0.0, 0.0);
    let check = Experiment::new(&world, &plan())
        .difference_check(&everything(), &FinalState::of_body(&world, "ball").unwrap());
    let check = check.unwrap();
    println!("{check}\nworst: {:.1e}", check.best());
    assert!(check.best() <= ELASTIC, "{check}");
}

#[test]
fn with_friction_and_dissipation_every_gradient_equals_differences() {
    let world = thrown(0.4, 0.3);
    let mut parameters = everything().to_vec();
    parameters.extend([
        Parameter::friction("ball"),
        Parameter::friction("slab"),
        Parameter::dissipation("ball"),
        Parameter::dissipation("slab"),
    ]);
    let check = Experiment::new(&world, &plan())
        .difference_check(&parameters, &FinalState::of_body(&world, "ball").unwrap());
    let check = check.unwrap();
    println!("{check}\nworst: {:.1e}", check.best());
    assert!(check.best() <= RUBBING, "{check}");
}

#[test]
fn the_papers_scheme_has_gradients_too() {
    let world = thrown(0.4, 0.3);
    let experiment = Experiment::new(&world, &plan().with_integrator(Integrator::SymplecticEuler));
    let parameters = [
        Parameter::initial_velocity("ball"),
        Parameter::friction("ball"),
    ];
    let check = experiment
        .difference_check(&parameters, &FinalState::of_body(&world, "ball").unwrap())
        .unwrap();
    assert!(check.best() <= RUBBING, "{check}");
}

#[test]
fn recorded_states_have_the_derivatives_of_shorter_rollouts() {
    let world = thrown(0.0, 0.0);
    let parameters = [
        Parameter::initial_velocity("ball"),
        Parameter::initial_angular_velocity("ball"),
    ];
    let recorded = Experiment::new(&world, &Plan::new(4e-4, 600).unwrap().recording_every(200));
    let all = recorded
        .jacobian(
            &parameters,
            &RecordedStates::of_body(&world, "ball").unwrap(),
        )
        .unwrap();
    assert_eq!(all.jacobian.shape(), (3 * 18, 6));
    let short = Experiment::new(&world, &Plan::new(4e-4, 400).unwrap());
    let short = short
        .jacobian(&parameters, &FinalState::of_body(&world, "ball").unwrap())
        .unwrap();
    assert_eq!(all.value.rows(18, 18), short.value);
    assert_eq!(all.jacobian.rows(18, 18), short.jacobian);
}

#[test]
fn chunks_of_parameters_give_what_each_parameter_gives_alone() {
    let world = thrown(0.4, 0.3);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 300).unwrap());
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let together = experiment
        .jacobian(&everything(), &outcome)
        .unwrap()
        .jacobian;
    let mut first = 0;
    for parameter in everything() {
        let alone = experiment
            .jacobian(std::slice::from_ref(&parameter), &outcome)
            .unwrap()
            .jacobian;
        let columns = together.columns(first, parameter.dimension());
        let error = (columns - &alone).amax();
        assert!(
            error <= REAL_PARTS * alone.amax(),
            "{parameter:?}: {error:e}"
        );
        first += parameter.dimension();
    }
    assert_eq!(first, together.ncols());
}

#[test]
fn real_parts_of_a_dual_rollout_are_the_rollout() {
    for (dissipation, friction) in [(0.0, 0.0), (0.4, 0.3)] {
        let world = thrown(dissipation, friction);
        let lifted = world.lifted::<DualSVec64<6>>();
        let mut start = lifted.initial_state();
        let seeds = Vector6::from_fn(|i, _| {
            let direction = nalgebra::SVector::<f64, 6>::ith(i, 1.0);
            DualSVec64::<6>::new(0.0, num_dual::Derivative::some(direction))
        });
        let ball = &mut start.bodies[0];
        ball.pose = ball.pose.moved_by(&Twist::from_vector(&seeds));
        let plan = plan().recording_every(100);
        let dual = lifted.rollout(&plan).with_state(start).unwrap();
        let dual = dual.run().unwrap().real();
        let real = world.rollout(&plan).run().unwrap();
        for (a, b) in dual.states().iter().zip(real.states()) {
            let (a, b) = (&a.bodies[0], &b.bodies[0]);
            let pose = (a.pose.translation() - b.pose.translation()).amax();
            let turn = (a.pose.rotation() - b.pose.rotation()).amax();
            let speed = (a.twist.linear - b.twist.linear).amax();
            assert!(
                pose.max(turn).max(speed) <= REAL_PARTS,
                "{pose:e} {turn:e} {speed:e}"
            );
        }
    }
}

#[test]
fn jacobians_by_more_than_96_numbers_take_two_rollouts() {
    const INTERVALS: usize = 17;
    let ball = icosphere(0.1, 0);
    let ball = dynamic("ball", ball, Material::elastic(1e5), 1.0);
    let control = Control::new("ball", 0.1, vec![Wrench::zero(); INTERVALS]).unwrap();
    let world = World::new(vec![ball]).unwrap();
    let world = world.with_control(control).unwrap();
    let experiment = Experiment::new(&world, &Plan::new(0.1, 5).unwrap());
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    assert_eq!(experiment.step_count_for(0), Ok(5));
    // The controls have 6, 96 and 102 components.
    for (intervals, steps) in [(1, 5), (16, 5), (INTERVALS, 10)] {
        let by = (0..intervals).map(|interval| Parameter::control("ball", interval));
        let by: Vec<_> = by.collect();
        let step_counter = Arc::new(AtomicUsize::new(0));
        let counted = experiment
            .clone()
            .with_step_counter(Arc::clone(&step_counter));
        counted.jacobian(&by, &outcome).unwrap();
        assert_eq!(step_counter.load(Ordering::Relaxed), steps);
        assert_eq!(experiment.step_count_for(6 * intervals), Ok(steps));
    }
}

#[test]
fn a_step_count_above_the_largest_integer_is_refused() {
    let plan = Plan::new(1e-3, usize::MAX).unwrap();
    let experiment = Experiment::new(thrown(0.0, 0.0), &plan);
    assert_eq!(experiment.step_count_for(96), Ok(usize::MAX));
    let refused = GradientError::TooManySteps {
        steps: usize::MAX,
        rollouts: 2,
    };
    assert_eq!(experiment.step_count_for(97), Err(refused));
}

/// `test_pullbacks.py` of the Python package tests the same numbers.
#[test]
fn gradients_use_reverse_mode_from_13_numbers_or_97_with_implicit_steps() {
    let world = thrown(0.0, 0.0);
    let mass = || Parameter::mass("ball");
    for (integrator, most) in [
        (Integrator::Leapfrog, 12),
        (Integrator::SymplecticEuler, 12),
        (Integrator::Sdirk3, 96),
        (Integrator::ImplicitEuler, 96),
    ] {
        let plan = plan_of(integrator, 1e-3, 2);
        let experiment = Experiment::new(&world, &plan);
        let mode = |count: usize| experiment.mode_for(&vec![mass(); count]);
        assert_eq!([mode(most), mode(most + 1)], [Mode::Forward, Mode::Reverse]);
    }
}

/// In free fall, the paper's scheme moves a body by g·h² in the first step, and by g·h² more in each further step.
#[test]
fn an_experiment_takes_the_steps_of_its_integrator() {
    let world = thrown(0.0, 0.0);
    let (time_step, steps) = (1e-3, 20);
    let height = |integrator| {
        let plan = Plan::new(time_step, steps).unwrap();
        let experiment = Experiment::new(&world, &plan.with_integrator(integrator));
        let outcome = FinalState::of_body(&world, "ball").unwrap();
        experiment.value(&outcome).unwrap()[2]
    };
    let fall = 9.81 * time_step * time_step;
    let count = steps as f64;
    let leapfrog = 0.15 - fall * count * count / 2.0;
    let paper = 0.15 - fall * count * (count + 1.0) / 2.0;
    assert!((height(Integrator::Leapfrog) - leapfrog).abs() <= REAL_PARTS);
    assert!((height(Integrator::SymplecticEuler) - paper).abs() <= REAL_PARTS);
}

/// The documented steps are relative to the material's parameter.
#[test]
fn differences_by_a_material_are_taken_over_parts_of_its_number() {
    let world = thrown(0.4, 0.3);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 200).unwrap());
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let numbers = [
        (Parameter::modulus("ball"), 1e5),
        (Parameter::dissipation("ball"), 0.4),
        (Parameter::friction("slab"), 0.3),
    ];
    for (parameter, number) in numbers {
        let parameters = [parameter];
        let check = experiment.difference_check(&parameters, &outcome).unwrap();
        let step = check.steps[0] * number;
        let after = |change| {
            DVector::from(
                experiment
                    .value_perturbed(&parameters, &[change], &outcome)
                    .unwrap(),
            )
        };
        let difference = (after(step) - after(-step)) / (2.0 * step);
        let derivative = experiment.jacobian(&parameters, &outcome).unwrap().jacobian;
        let error = (&difference - derivative.column(0)).amax();
        let expected = error / derivative.amax().max(difference.amax());
        assert!(
            expected > 1e-9,
            "the step is too short for the check: {expected:e}"
        );
        let actual = check.errors[(0, 0)];
        assert!(
            (actual - expected).abs() <= 1e-2 * expected,
            "{actual:e} {expected:e}"
        );
    }
}

/// Steps are relative to the parameter, or absolute if the parameter is 0.
#[test]
fn a_derivative_by_a_dissipation_of_zero_is_checked() {
    struct Forgotten;
    impl Outcome for Forgotten {
        fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
            vec![lift(real_part(trajectory.last().bodies[0].position().z))]
        }
    }
    let world = thrown(0.0, 0.0);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 200).unwrap());
    let check = experiment
        .difference_check(&[Parameter::dissipation("ball")], &Forgotten)
        .unwrap();
    assert!((check.best() - 1.0).abs() <= REAL_PARTS, "{check}");
}

/// A path prescribes the motion of a body, but not its material.
#[test]
fn a_body_on_a_path_has_derivatives_by_its_material() {
    let skin = Material::elastic(1e5).with_friction(0.3);
    let ball = icosphere(0.1, 1);
    let table = cuboid([1.0, 1.0, 0.2]);
    let ball = dynamic("ball", ball, skin, 1.0);
    let velocity = vector![0.01, 0.0, 0.1];
    let rising = move |time: f64| {
        let pose = Pose::from_translation(vector![0.0, 0.0, -0.1] + velocity * time);
        let twist = sliding_at(velocity);
        BodyState { pose, twist }
    };
    let table = Body::kinematic("table", table, skin, Arc::new(rising)).unwrap();
    let ball = ball.with_pose(at(0.0, 0.0, 0.099));
    let world = World::new(vec![ball, table]).unwrap();
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 100).unwrap());
    let parameters = [Parameter::modulus("table"), Parameter::friction("table")];
    let check = experiment
        .difference_check(&parameters, &FinalState::of_body(&world, "ball").unwrap())
        .unwrap();
    assert!(check.best() <= RUBBING, "{check}");
    let start = experiment.jacobian(
        &[Parameter::initial_position("table")],
        &FinalState::of_body(&world, "ball").unwrap(),
    );
    assert!(matches!(start, Err(GradientError::NotDynamic { .. })));
}

#[test]
fn a_world_changed_to_zero_friction_has_the_bits_of_a_world_made_without_friction() {
    let by = ["ball", "slab"].map(Parameter::friction);
    let changed = [
        thrown(0.0, 0.3).with_values(&by, &[0.0; 2]).unwrap(),
        thrown(0.0, 0.3).perturbed(&by, &[-0.3; 2]).unwrap(),
        thrown(0.0, 0.0).with_values(&by, &[0.0; 2]).unwrap(),
    ];
    let plan = Plan::new(1e-3, 400).unwrap().recording_ends();
    let end = |world: &World| {
        let trajectory = world.rollout(&plan).run().unwrap();
        let BodyState { pose, twist } = trajectory.last().bodies[0];
        (*pose.translation(), *pose.rotation(), twist.to_vector())
    };
    let expected = end(&thrown(0.0, 0.0));
    for world in changed {
        assert_eq!(end(&world), expected);
    }
}

/// A change is added to the original parameters of a world.
#[test]
fn a_changed_world_is_the_one_that_is_made_of_the_sums() {
    let (modulus, dissipation, friction) = (2e4, 0.15, 0.05);
    let changes = [
        modulus,
        dissipation,
        friction,
        modulus,
        dissipation,
        friction,
    ];
    let of = |name: &str| {
        [
            Parameter::modulus(name),
            Parameter::dissipation(name),
            Parameter::friction(name),
        ]
    };
    let parameters = [of("ball"), of("slab")].concat();
    let changed = thrown(0.4, 0.3).perturbed(&parameters, &changes).unwrap();
    let made = thrown(0.4, 0.3);
    for (body, start) in changed.bodies().iter().zip(made.bodies()) {
        let (actual, material) = (body.material(), start.material());
        let pairs = [
            (actual.modulus.unwrap(), material.modulus.unwrap() + modulus),
            (actual.dissipation, material.dissipation + dissipation),
            (
                actual.friction.unwrap(),
                material.friction.unwrap() + friction,
            ),
        ];
        for (actual, expected) in pairs {
            assert!(
                (actual - expected).abs() <= REAL_PARTS * expected,
                "{actual} {expected}"
            );
        }
    }
}
