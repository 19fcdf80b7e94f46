//! Worlds: what is refused and by which name, how rollouts end, what moves and what does not.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Batch, Body, BodyState, Force, Integrator, Mass, Material, Plan, Rollout, RolloutError,
    Situation, State, World, WorldError, Wrenches,
};
use hydroelastic::gradient::{
    Experiment, FinalPosition, FinalState, GradientError, Parameter, RecordedStates,
};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{MassProperties, Pose, PoseError, Twist, Wrench, rotation_from_vector};
use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3, vector};
use std::slice;
use std::sync::Arc;

const GRAVITY: f64 = 9.81;

/// What a few thousand steps add up to in round-off.
const ROUND_OFF: f64 = 1e-12;

/// Round-off that the sensitivity of a tumbling or bouncing body has magnified.
const REVERSED: f64 = 1e-9;

/// What no number may be that must be positive and finite.
const NOT_POSITIVE: [f64; 4] = [0.0, -1.0, f64::NAN, f64::INFINITY];

/// What no number may be that must not be negative.
const NEGATIVE: [f64; 3] = [-1e-9, f64::NAN, f64::INFINITY];

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

const SKIN: Material = Material {
    modulus: 1e5,
    dissipation: 0.0,
    friction: 0.0,
};

fn ball_shape() -> Arc<Shape> {
    Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()))
}

fn box_shape(lengths: [f64; 3]) -> Arc<Shape> {
    Arc::new(Shape::new(shapes::cuboid(lengths).unwrap()))
}

fn ball(name: &str) -> Body {
    Body::dynamic(name, ball_shape(), SKIN, Mass::Total(1.0)).unwrap()
}

/// A body whose top is z = 0.
fn floor(skin: Material) -> Body {
    let slab = box_shape([1.0, 1.0, 0.4]);
    let floor = Body::fixed("floor", slab, skin).unwrap();
    floor.at(at(0.0, 0.0, -0.2))
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

fn down() -> Vector3<f64> {
    vector![0.0, 0.0, -GRAVITY]
}

/// That an error's message starts with what was found where.
fn assert_names(error: &WorldError, found: &str) {
    let message = error.to_string();
    assert!(message.starts_with(found), "{message:?}, not {found:?}");
}

// Numbers that are refused.

#[test]
fn a_material_out_of_range_is_refused_with_the_body_the_quantity_and_the_value() {
    let refused = |skin: Material, quantity: &str, value: f64| {
        let moving = Body::dynamic("cube", ball_shape(), skin, Mass::Total(1.0)).unwrap_err();
        let still = Body::fixed("cube", ball_shape(), skin).unwrap_err();
        let path = Arc::new(|_| still_at(0.0));
        let driven = Body::prescribed("cube", ball_shape(), skin, path).unwrap_err();
        for error in [moving, still, driven] {
            assert!(matches!(error, WorldError::Material { .. }));
            assert_names(
                &error,
                &format!("the {quantity} of body \"cube\" is {value}"),
            );
        }
    };
    for value in NOT_POSITIVE {
        refused(Material::elastic(value), "hydroelastic modulus", value);
    }
    for value in NEGATIVE {
        let dissipation = value;
        let sticky = Material {
            dissipation,
            ..SKIN
        };
        refused(sticky, "dissipation", value);
        let friction = value;
        refused(Material { friction, ..SKIN }, "friction", value);
    }
}

fn still_at(x: f64) -> BodyState {
    BodyState {
        pose: at(x, 0.0, 0.0),
        twist: Twist::zero(),
    }
}

fn assert_mass_refused(mass: Mass, found: &str) {
    let error = Body::dynamic("cube", ball_shape(), SKIN, mass).unwrap_err();
    assert!(matches!(error, WorldError::Mass { .. }), "{error}");
    assert_names(&error, found);
}

#[test]
fn a_mass_or_density_that_is_not_positive_and_finite_is_refused() {
    for value in NOT_POSITIVE {
        let of_body = |quantity: &str| format!("the {quantity} of body \"cube\" is {value}");
        assert_mass_refused(Mass::Density(value), &of_body("density"));
        assert_mass_refused(Mass::Total(value), &of_body("mass"));
        let mass = value;
        let given = MassProperties {
            mass,
            ..asymmetric()
        };
        assert_mass_refused(Mass::Given(given), &of_body("mass"));
    }
}

/// Mass properties of a body whose centre of mass is off its origin and whose principal axes are
/// askew.
fn asymmetric() -> MassProperties {
    let axes = rotation_from_vector(&vector![0.4, -0.3, 0.8]);
    let moments = Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]);
    let inertia = axes * moments * axes.transpose();
    MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.03, -0.01, 0.02],
        inertia: (inertia + inertia.transpose()) / 2.0,
    }
}

fn with_inertia(inertia: Matrix3<f64>) -> Mass {
    Mass::Given(MassProperties {
        inertia,
        ..asymmetric()
    })
}

#[test]
fn an_inertia_that_is_not_positive_definite_and_finite_is_refused() {
    let moments = |smallest: f64| Matrix3::from_diagonal(&vector![0.1, smallest, 0.1]);
    for value in [0.0, -0.1] {
        let found =
            format!("the smallest principal moment of inertia of body \"cube\" is {value}, but");
        assert_mass_refused(with_inertia(moments(value)), &found);
    }
    for value in NOT_FINITE {
        let found = format!("the inertia of body \"cube\" is {value}, but");
        assert_mass_refused(with_inertia(moments(value)), &found);
    }
}

#[test]
fn an_inertia_that_is_not_symmetric_is_refused() {
    let mut inertia = asymmetric().inertia;
    inertia[(0, 2)] += 1e-3;
    let error = Body::dynamic("cube", ball_shape(), SKIN, with_inertia(inertia)).unwrap_err();
    assert!(matches!(error, WorldError::AsymmetricInertia { .. }));
    assert_names(
        &error,
        "the inertia of body \"cube\" differs from its transpose by",
    );
}

#[test]
fn a_body_has_no_contact_with_itself() {
    let world = World::new(vec![ball("one"), ball("two")]).unwrap();
    let error = world
        .contact_between(&world.initial_state(), "one", "one")
        .unwrap_err();
    assert_eq!(error, WorldError::SameBody("one".into()));
    let copy = world.clone();
    let error = copy.contact_between(&world.initial_state(), "one", "three");
    assert!(matches!(error, Err(WorldError::UnknownBody { .. })));
}

#[test]
fn an_inertia_that_no_solid_has_is_refused() {
    let of = |moments: [f64; 3]| with_inertia(Matrix3::from_diagonal(&Vector3::from(moments)));
    let error = Body::dynamic("cube", ball_shape(), SKIN, of([1.0, 10.0, 1.0])).unwrap_err();
    assert!(matches!(error, WorldError::ImpossibleInertia { .. }));
    assert_names(
        &error,
        "the largest principal moment of inertia of body \"cube\" is 10 kg m², but",
    );
    // A plate, rounded to six digits.
    assert!(
        Body::dynamic(
            "plate",
            ball_shape(),
            SKIN,
            of([0.333_333, 0.333_333, 0.666_667])
        )
        .is_ok()
    );
}

#[test]
fn a_centre_of_mass_that_is_not_finite_is_refused() {
    for value in NOT_FINITE {
        let given = MassProperties {
            center_of_mass: vector![0.0, value, 0.0],
            ..asymmetric()
        };
        let error = Body::dynamic("cube", ball_shape(), SKIN, Mass::Given(given)).unwrap_err();
        assert!(matches!(error, WorldError::CenterOfMass { .. }), "{error}");
        assert_names(
            &error,
            &format!("the centre of mass of body \"cube\" has the component {value}"),
        );
    }
}

#[test]
fn a_pose_that_is_not_finite_is_refused() {
    for value in NOT_FINITE {
        let error = World::new(vec![ball("first"), ball("lost").at(at(0.0, value, 0.0))]);
        let error = error.unwrap_err();
        let WorldError::Pose { body, source } = &error else {
            panic!("{error}")
        };
        assert_eq!(body, "lost");
        assert!(matches!(source, PoseError::NotFinite(_)));
    }
    let spun = Pose::from_rotation_vector(&vector![f64::NAN, 0.0, 0.0], Vector3::zeros());
    let error = World::new(vec![ball("spun").at(spun)]).unwrap_err();
    assert_names(
        &error,
        "the pose of body \"spun\" is unusable: a pose must be finite",
    );
}

#[test]
fn a_velocity_or_a_spin_that_is_not_finite_is_refused() {
    for value in NOT_FINITE {
        let vector = vector![0.0, 0.0, value];
        for (body, quantity) in [
            (ball("comet").with_velocity(vector), "velocity"),
            (ball("comet").with_spin(vector), "spin"),
        ] {
            let error = World::new(vec![body]).unwrap_err();
            assert!(matches!(error, WorldError::Velocity { .. }));
            let found = format!("the {quantity} of body \"comet\" has the component {value}");
            assert_names(&error, &found);
        }
    }
}

#[test]
fn a_path_that_starts_nowhere_is_refused() {
    let path = Arc::new(|_| still_at(f64::NAN));
    let body = Body::prescribed("ghost", ball_shape(), SKIN, path).unwrap();
    let error = World::new(vec![body]).unwrap_err();
    assert_names(&error, "the pose of body \"ghost\" is unusable");
}

#[test]
fn a_body_that_forces_do_not_move_takes_no_start_that_it_would_not_keep() {
    let fixed = || Body::fixed("rock", ball_shape(), SKIN).unwrap();
    let driven = || Body::prescribed("rock", ball_shape(), SKIN, Arc::new(|_| still_at(0.5)));
    let driven = || driven().unwrap();
    let some = vector![0.0, 0.1, 0.0];
    for (body, quantity) in [
        (fixed().with_velocity(some), "velocity"),
        (fixed().with_spin(some), "spin"),
        (driven().at(at(0.0, 0.0, 0.0)), "pose"),
        (driven().with_velocity(some), "velocity"),
        (driven().with_spin(some), "spin"),
    ] {
        let error = World::new(vec![body]).unwrap_err();
        assert!(matches!(error, WorldError::NotDynamic { .. }), "{error}");
        assert_names(
            &error,
            &format!("body \"rock\" cannot have a {quantity} of its own"),
        );
    }
    World::new(vec![fixed().at(at(1.0, 2.0, 3.0))]).unwrap();
    World::new(vec![driven()]).unwrap();
}

#[test]
fn a_name_can_be_had_only_once() {
    let error = World::new(vec![ball("one"), ball("two"), ball("one")]).unwrap_err();
    assert_eq!(error, WorldError::DuplicateName("one".into()));
    assert_names(&error, "two bodies are named \"one\"");
}

#[test]
fn an_unknown_name_is_refused_with_the_names_there_are() {
    let world = || World::new(vec![ball("one"), ball("two")]).unwrap();
    let unknown = WorldError::UnknownBody {
        name: "three".into(),
        known: vec!["one".into(), "two".into()],
    };
    assert_eq!(world().index_of("two"), Ok(1));
    assert_eq!(world().index_of("three"), Err(unknown.clone()));
    assert_eq!(world().ignoring("one", "three").unwrap_err(), unknown);
    assert_eq!(world().ignoring("three", "one").unwrap_err(), unknown);
    assert_names(
        &unknown,
        "no body is named \"three\"; there are [\"one\", \"two\"]",
    );
}

#[test]
fn settings_of_the_world_out_of_range_are_refused() {
    let world = || World::new(vec![ball("ball")]).unwrap();
    for value in NOT_FINITE {
        let error = world().with_gravity(vector![0.0, value, 0.0]).unwrap_err();
        assert!(matches!(error, WorldError::Setting { .. }));
        assert_names(
            &error,
            &format!("the gravity is {value}, but must be finite"),
        );
    }
    for value in NOT_POSITIVE {
        let slip = world().with_slip_tolerance(value).unwrap_err();
        let step = Plan::new(value, 0).unwrap_err();
        for (error, quantity) in [(slip, "slip tolerance"), (step, "time step")] {
            assert!(matches!(error, WorldError::Setting { .. }));
            let found = format!("the {quantity} is {value}, but must be positive and finite");
            assert_names(&error, &found);
        }
    }
}

// Gradients that are refused.

#[test]
fn an_experiment_refuses_a_time_step_that_is_not_positive() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let experiment = |time_step| -> Result<Experiment, GradientError> {
        Ok(Experiment::new(&world, &Plan::new(time_step, 10)?))
    };
    experiment(1e-3).unwrap();
    assert!(matches!(
        experiment(0.0).unwrap_err(),
        GradientError::World(WorldError::Setting {
            quantity: "time step",
            ..
        })
    ));
}

/// The error of the derivatives of the first body's position by a parameter.
fn refused_gradient(world: &World, parameter: &Parameter) -> GradientError {
    let by = slice::from_ref(parameter);
    let experiment = Experiment::new(world, &Plan::new(1e-3, 10).unwrap());
    let outcome = FinalPosition::of_body(world, world.bodies()[0].name()).unwrap();
    let error = experiment.jacobian(by, &outcome).unwrap_err();
    let check = experiment.difference_check(by, &outcome);
    let after = experiment.value_after(by, &[0.0; 3], &outcome);
    assert_eq!(check.unwrap_err(), error);
    assert_eq!(after.unwrap_err(), error);
    error
}

#[test]
fn a_parameter_of_no_body_of_the_world_is_refused() {
    let world = World::new(vec![ball("ball"), floor(SKIN)]).unwrap();
    for parameter in [
        Parameter::InitialPosition("bal".into()),
        Parameter::Modulus("bal".into()),
        Parameter::Mass("bal".into()),
    ] {
        let unknown = WorldError::UnknownBody {
            name: "bal".into(),
            known: vec!["ball".into(), "floor".into()],
        };
        assert_eq!(
            refused_gradient(&world, &parameter),
            GradientError::World(unknown)
        );
    }
}

#[test]
fn a_parameter_without_effect_on_a_body_that_forces_do_not_move_is_refused() {
    let driven = Body::prescribed("cart", ball_shape(), SKIN, Arc::new(|_| still_at(2.0)));
    let world = World::new(vec![ball("ball"), floor(SKIN), driven.unwrap()]).unwrap();
    for (parameter, body) in [
        (Parameter::Mass("floor".into()), "floor"),
        (Parameter::InitialVelocity("floor".into()), "floor"),
        (Parameter::InitialSpin("floor".into()), "floor"),
        (Parameter::Mass("cart".into()), "cart"),
        (Parameter::InitialPosition("cart".into()), "cart"),
        (Parameter::InitialOrientation("cart".into()), "cart"),
    ] {
        let error = refused_gradient(&world, &parameter);
        let expected = GradientError::NotDynamic {
            body: body.into(),
            parameter: format!("{parameter:?}"),
        };
        assert_eq!(error, expected);
    }
    let error = refused_gradient(&world, &Parameter::Mass("floor".into()));
    assert_eq!(
        error.to_string(),
        "Mass(\"floor\") has no effect, because body \"floor\" is not dynamic"
    );
}

#[test]
fn an_outcome_of_no_body_of_the_world_is_refused() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let unknown = world.index_of("bal").unwrap_err();
    let errors = [
        FinalPosition::of_body(&world, "bal").unwrap_err(),
        FinalState::of_body(&world, "bal").unwrap_err(),
        RecordedStates::of_body(&world, "bal").unwrap_err(),
    ];
    assert!(errors.iter().all(|error| error == &unknown));
}

#[test]
fn a_world_is_changed_by_as_many_numbers_as_its_parameters_have_and_to_usable_ones_only() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let parameters = [Parameter::Mass("ball".into()), Parameter::Gravity];
    let error = world.changed(&parameters, &[0.0; 3]).unwrap_err();
    let (found, expected) = (3, 4);
    assert_eq!(error, GradientError::ChangeCount { found, expected });
    for change in [-1.0, -2.0, f64::NAN] {
        let error = world.changed(&parameters, &[change, 0.0, 0.0, 0.0]);
        let GradientError::World(error) = error.unwrap_err() else {
            panic!("not of the world")
        };
        assert_names(
            &error,
            &format!("the mass of body \"ball\" is {}", 1.0 + change),
        );
    }
}

#[test]
fn a_gradient_of_more_than_one_number_is_refused() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 10).unwrap());
    let outcome = FinalPosition::of_body(&world, world.bodies()[0].name()).unwrap();
    let error = experiment.gradient(&[Parameter::Gravity], &outcome);
    assert_eq!(error.unwrap_err(), GradientError::NotALoss { count: 3 });
}

// Rollouts that end.

/// A ball without weight to speak of that falls on a floor as stiff as a modulus can be, and one far
/// away.
fn exploding() -> World {
    let stiff = Material::elastic(1e150);
    let falling = Body::dynamic("falling", ball_shape(), stiff, Mass::Total(1e-200)).unwrap();
    let falling = falling.at(at(0.0, 0.0, 1.0));
    let world = World::new(vec![
        ball("far").at(at(5.0, 0.0, 0.0)),
        falling,
        floor(stiff),
    ]);
    world.unwrap().with_gravity(down()).unwrap()
}

/// The fall of 0.9 m takes 0.428 s: the first evaluation in the floor is at 0.45 s, in the fifth
/// step of 0.1 s.
const LONG_STEP: f64 = 0.1;

fn explosion() -> RolloutError {
    RolloutError::NotFinite {
        step: 5,
        time: 5.0 * LONG_STEP,
        body: "falling".into(),
    }
}

#[test]
fn a_blow_up_ends_the_rollout_with_its_step_time_and_body() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 5).unwrap());
    for _ in 0..4 {
        rollout.next().unwrap().unwrap();
    }
    let last = rollout.state().clone();
    let error = rollout.next().unwrap().unwrap_err();
    assert_eq!(error, explosion());
    assert_eq!(
        error.to_string(),
        "step 5 (t = 0.5 s) took body \"falling\" to a state that is not finite: the time step \
         may be too long for its stiffness (see World::largest_stable_step)"
    );
    assert!(rollout.next().is_none() && rollout.next().is_none());
    assert_eq!(rollout.state().time.to_bits(), last.time.to_bits());
}

#[test]
fn a_recording_that_blows_up_gives_what_it_has_recorded() {
    let world = exploding();
    for (every, count) in [(1, 5), (2, 3), (10, 1)] {
        let plan = Plan::new(LONG_STEP, 100).unwrap().recording_every(every);
        let interrupted = world.rollout(&plan).recorded().unwrap_err();
        assert_eq!(interrupted.error, explosion());
        assert_eq!(interrupted.to_string(), explosion().to_string());
        let states = interrupted.trajectory.states();
        assert_eq!(states.len(), count);
        let mut bodies = states.iter().flat_map(|state| &state.bodies);
        assert!(bodies.all(BodyState::is_finite));
    }
}

#[test]
fn a_rollout_that_has_blown_up_does_so_again_at_the_same_step() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 1).unwrap());
    assert_eq!(rollout.by_ref().take(100).filter(Result::is_err).count(), 1);
    assert_eq!(rollout.recorded().unwrap_err().error, explosion());
}

#[test]
fn a_rollout_that_has_blown_up_starts_anew_from_another_state() {
    let world = exploding();
    let mut rollout = world.rollout(&Plan::new(LONG_STEP, 100).unwrap());
    assert_eq!(rollout.by_ref().take(100).filter(Result::is_err).count(), 1);
    let anew = rollout.starting_from(world.initial_state()).unwrap();
    let (states, errors): (Vec<_>, Vec<_>) = anew.take(100).partition(Result::is_ok);
    assert_eq!(states.len(), 4);
    assert_eq!(errors[0].as_ref().unwrap_err(), &explosion());
}

#[test]
fn a_blow_up_ends_a_gradient() {
    let world = exploding();
    let experiment = Experiment::new(&world, &Plan::new(LONG_STEP, 20).unwrap());
    let outcome = FinalPosition::of_body(&world, world.bodies()[0].name()).unwrap();
    let expected = GradientError::Rollout(explosion());
    let jacobian = experiment.jacobian(&[Parameter::Gravity], &outcome);
    assert_eq!(jacobian.unwrap_err(), expected);
    assert_eq!(experiment.value(&outcome).unwrap_err(), expected);
}

#[test]
fn a_path_that_leads_nowhere_ends_the_rollout() {
    let path = |time: f64| still_at(if time < 0.25 { 1.0 } else { f64::NAN });
    let lost = Body::prescribed("lost", ball_shape(), SKIN, Arc::new(path)).unwrap();
    let world = World::new(vec![ball("ball"), lost]).unwrap();
    let between = |time: f64| {
        still_at(if (time - 0.25).abs() < 0.01 {
            f64::NAN
        } else {
            1.0
        })
    };
    let between = Body::prescribed("lost", ball_shape(), SKIN, Arc::new(between)).unwrap();
    let between = World::new(vec![ball("ball"), between]).unwrap();
    let plan = Plan::new(0.1, 10).unwrap();
    for every in [1, 100] {
        // The middle of the third step, where the leapfrog asks for the contacts.
        let rollout = between.rollout(&plan.with_stability_check(every));
        let error = rollout.recorded().unwrap_err().error;
        assert!(
            matches!(error, RolloutError::PathNotFinite { step: 3, .. }),
            "{error}"
        );
    }
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        let rollout = world.rollout(&plan.with_integrator(integrator));
        let error = rollout.recorded().unwrap_err().error;
        let RolloutError::PathNotFinite { step, body, .. } = error else {
            panic!("{error}")
        };
        assert_eq!((step, body.as_str()), (3, "lost"));
    }
}

#[test]
fn a_state_of_another_world_is_no_start() {
    let small = World::new(vec![ball("ball")]).unwrap();
    let large = exploding();
    let rollout = large.rollout(&Plan::new(LONG_STEP, 0).unwrap());
    let error = rollout.starting_from(small.initial_state()).unwrap_err();
    let (found, expected) = (1, 3);
    assert_eq!(error, WorldError::StateSize { found, expected });
}

#[test]
fn a_rollout_does_not_start_from_a_state_that_is_not_usable() {
    let world = World::new(vec![ball("a"), ball("b").at(at(1.0, 0.0, 0.0))]).unwrap();
    let changed = |change: fn(&mut BodyState)| {
        let mut state = world.initial_state();
        change(&mut state.bodies[1]);
        let plan = Plan::new(1e-3, 10).unwrap();
        let rollout = world.rollout(&plan);
        let error = rollout.starting_from(state.clone()).unwrap_err();
        let batch = Batch::new(&plan);
        let errors = batch.starting_from(&world, &[state]).unwrap_err();
        assert_eq!(error.to_string(), errors.to_string());
        error.to_string()
    };
    let spin = changed(|body| body.twist.angular.y = f64::NAN);
    assert!(spin.contains("the spin of body \"b\""), "{spin}");
    let velocity = changed(|body| body.twist.linear.x = f64::INFINITY);
    assert!(
        velocity.contains("the velocity of body \"b\""),
        "{velocity}"
    );
    let stretched = changed(|body| {
        let quaternion = UnitQuaternion::new_unchecked(Quaternion::new(2.0, 0.0, 0.0, 0.0));
        body.pose = Isometry3::from_parts(Translation3::identity(), quaternion).into();
    });
    assert!(stretched.contains("the pose of body \"b\""), "{stretched}");
}

#[test]
fn time_is_counted_in_steps_from_any_start() {
    let world = World::new(vec![ball("ball")]).unwrap();
    for start in [0.0, 1.0 / 3.0] {
        let mut state = world.initial_state();
        state.time = start;
        let rollout = world.rollout(&Plan::new(1e-3, 10_000).unwrap());
        let mut rollout = rollout.starting_from(state).unwrap();
        let last = rollout.nth(9_999).unwrap().unwrap();
        assert_eq!(last.time.to_bits(), (start + 1e4 * 1e-3_f64).to_bits());
    }
}

// What moves, and what does not.

fn leapfrog(world: &World, time_step: f64) -> Rollout {
    world.rollout(&Plan::new(time_step, 0).unwrap())
}

/// That two states of a body are the same, bit for bit.
fn assert_same(a: &BodyState, b: &BodyState) {
    assert_eq!(a.pose.translation(), b.pose.translation());
    assert_eq!(a.pose.rotation(), b.pose.rotation());
    assert_eq!(a.twist.linear, b.twist.linear);
    assert_eq!(a.twist.angular, b.twist.angular);
}

#[test]
fn ignored_pairs_do_not_push() {
    let falling = || ball("ball").at(at(0.0, 0.0, 0.15));
    let alone = World::new(vec![falling()]).unwrap();
    let alone = alone.with_gravity(down()).unwrap();
    for names in [["ball", "floor"], ["floor", "ball"]] {
        let world = World::new(vec![falling(), floor(SKIN)]).unwrap();
        let world = world.with_gravity(down()).unwrap();
        let last = |world: &World| leapfrog(world, 1e-3).nth(199).unwrap().unwrap();
        let bounced = last(&world);
        let world = world.ignoring(names[0], names[1]).unwrap();
        let passed = last(&world);
        assert_same(&passed.bodies[0], &last(&alone).bodies[0]);
        assert!(passed.bodies[0].pose.translation().z < -0.04);
        assert!(bounced.bodies[0].pose.translation().z > 0.05);
        let inside = leapfrog(&world, 1e-3).take(200).map(Result::unwrap);
        let polygons = inside.map(|state| world.topology(&state).unwrap().polygon_count());
        assert_eq!(polygons.sum::<usize>(), 0);
    }
}

#[test]
fn an_ignored_pair_leaves_the_other_pairs() {
    let world = World::new(vec![
        ball("left").at(at(-0.1, 0.0, 0.09)),
        ball("right").at(at(0.05, 0.0, 0.09)),
        floor(SKIN),
    ]);
    let world = world.unwrap().ignoring("left", "right").unwrap();
    let next = leapfrog(&world, 1e-3).next().unwrap().unwrap();
    for body in &next.bodies[..2] {
        assert!(body.twist.linear.z > 0.0);
        assert!(body.twist.linear.x.abs() < 1e-6 * body.twist.linear.z);
    }
}

#[test]
fn fixed_bodies_never_move() {
    let skin = Material {
        friction: 0.5,
        ..SKIN
    };
    let tilted = Pose::from_rotation_vector(&vector![0.1, 0.2, 0.3], vector![0.0, 0.0, -0.25]);
    let rock = Body::fixed("rock", box_shape([1.0, 1.0, 0.4]), skin).unwrap();
    let rock = rock.at(tilted);
    let thrown = ball("ball").with_velocity(vector![0.0, 0.0, -5.0]);
    let world = World::new(vec![rock, thrown.at(at(0.0, 0.0, 0.1))]).unwrap();
    let start = world.initial_state();
    let mut hits = 0;
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        for state in world
            .rollout(&Plan::new(1e-4, 1_000).unwrap().with_integrator(integrator))
            .take(1_000)
        {
            let state = state.unwrap();
            assert_same(&state.bodies[0], &start.bodies[0]);
            hits += usize::from(world.topology(&state).unwrap().polygon_count() > 0);
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn bodies_that_forces_do_not_move_do_not_touch_each_other() {
    let slab = Body::fixed("slab", box_shape([1.0, 1.0, 1.0]), SKIN).unwrap();
    let sunk = Body::prescribed("sunk", ball_shape(), SKIN, Arc::new(|_| still_at(0.4))).unwrap();
    let world = World::new(vec![slab, sunk, floor(SKIN)]).unwrap();
    assert_eq!(
        world
            .topology(&world.initial_state())
            .unwrap()
            .polygon_count(),
        0
    );
}

/// A block that moves along x at 1 m/s, starting just off a ball of 1 kg.
fn pushed_ball() -> World {
    let path = |time: f64| BodyState {
        pose: at(time, 0.0, 0.0),
        twist: Twist {
            angular: Vector3::zeros(),
            linear: Vector3::x(),
        },
    };
    let block = box_shape([0.2, 0.4, 0.4]);
    let pusher = Body::prescribed("pusher", block, SKIN, Arc::new(path)).unwrap();
    World::new(vec![ball("ball").at(at(0.205, 0.0, 0.0)), pusher]).unwrap()
}

#[test]
fn a_prescribed_body_follows_its_path_whatever_it_pushes() {
    let world = pushed_ball();
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        for state in world
            .rollout(&Plan::new(1e-3, 200).unwrap().with_integrator(integrator))
            .take(200)
        {
            let state = state.unwrap();
            let pusher = &state.bodies[1];
            let off_path = pusher.pose.translation() - vector![state.time, 0.0, 0.0];
            assert!(off_path.amax() < ROUND_OFF);
            assert_eq!(pusher.pose.rotation(), &Matrix3::identity());
            assert_eq!(pusher.twist.linear, Vector3::x());
        }
    }
}

/// Energies after a bounce at five hundred steps a bounce.
const BOUNCE: f64 = 1e-4;

#[test]
fn a_ball_leaves_a_pusher_at_twice_the_speed_of_the_pusher() {
    let world = pushed_ball();
    let mut before = world.initial_state();
    let mut touched = 0;
    for state in leapfrog(&world, 5e-5).take(4_000) {
        let state = state.unwrap();
        let gained = state.bodies[0].twist.linear.x - before.bodies[0].twist.linear.x;
        assert!(gained >= 0.0, "a pusher never pulls");
        // In the pusher's frame nothing does work.
        let relative = state.bodies[0].twist.linear - Vector3::x();
        let contact = world.report(&state).unwrap().contact_energy;
        let energy = relative.norm_squared() / 2.0 + contact;
        assert!((energy - 0.5).abs() < 10.0 * BOUNCE, "{energy}");
        touched += usize::from(contact > 0.0);
        before = state;
    }
    assert!(touched > 100, "{touched}");
    let momentum = world.report(&before).unwrap().momentum.linear;
    assert!(
        (momentum - vector![2.0, 0.0, 0.0]).amax() < BOUNCE,
        "{momentum}"
    );
}

#[test]
fn a_turning_pusher_pushes_with_the_velocity_of_its_surface() {
    // A roller turns under a ball that lies on it, both of the same shape: friction drives the ball
    // the way the roller's top goes, and turns it the other way round.
    let skin = Material {
        friction: 0.5,
        dissipation: 1.0,
        ..SKIN
    };
    let turning = |time: f64| BodyState {
        pose: Pose::from_rotation_vector(&vector![0.0, 10.0 * time, 0.0], Vector3::zeros()),
        twist: Twist {
            angular: vector![0.0, 10.0, 0.0],
            linear: Vector3::zeros(),
        },
    };
    let roller = Body::prescribed("roller", ball_shape(), skin, Arc::new(turning)).unwrap();
    let load = Body::dynamic("load", ball_shape(), skin, Mass::Total(1.0)).unwrap();
    let world = World::new(vec![roller, load.at(at(0.0, 0.0, 0.19))]).unwrap();
    let world = world.with_gravity(down()).unwrap();
    let last = leapfrog(&world, 1e-4).nth(99).unwrap().unwrap();
    let twist = &last.bodies[1].twist;
    assert!(twist.linear.x > 1e-3, "{}", twist.linear);
    assert!(twist.angular.y < -1e-2, "{}", twist.angular);
}

#[test]
fn bodies_may_share_a_shape() {
    let shape = ball_shape();
    let body = |name: &str| Body::dynamic(name, Arc::clone(&shape), SKIN, Mass::Total(1.0));
    let fixed = Body::fixed("three", Arc::clone(&shape), SKIN).unwrap();
    let world = World::new(vec![body("one").unwrap(), body("two").unwrap(), fixed]).unwrap();
    assert_eq!(Arc::strong_count(&shape), 4);
    assert!(
        world
            .bodies()
            .iter()
            .all(|body| Arc::ptr_eq(body.shape(), &shape))
    );
    let lifted = world.lifted::<num_dual::Dual64>();
    assert_eq!(Arc::strong_count(&shape), 7);
    drop((world, lifted));
    assert_eq!(Arc::strong_count(&shape), 1);
}

// Forces of the user's own.

/// A drag of so many N s/m.
struct ViscousAir(f64);

impl Force for ViscousAir {
    fn add_to<T: Scalar>(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>) {
        for (body, state) in now.states.iter().enumerate() {
            wrenches.push_center(body, &(state.twist.linear * lift::<T>(-self.0)));
        }
    }
}

type AiryWorld = World<f64, ViscousAir>;

/// Drag (N s/m) and mass (kg): velocities decay in 0.5 s.
const DRAG: f64 = 2.0;
const RELAXATION: f64 = 1.0 / DRAG;

fn in_air(velocity: f64, gravity: f64) -> AiryWorld {
    let thrown = ball("ball").with_velocity(vector![velocity, 0.0, 0.0]);
    let world = World::new(vec![thrown]).unwrap();
    let world = world.with_gravity(vector![-gravity, 0.0, 0.0]).unwrap();
    world.with_forces(ViscousAir(DRAG)).unwrap()
}

fn final_speed(world: &AiryWorld, steps: usize, duration: f64) -> f64 {
    let mut rollout = world.rollout(&Plan::new(duration / steps as f64, steps).unwrap());
    let last = rollout.nth(steps - 1).unwrap().unwrap();
    last.bodies[0].twist.linear.x
}

#[test]
fn a_ball_in_viscous_air_falls_at_its_terminal_velocity() {
    let speed = final_speed(&in_air(0.0, GRAVITY), 20_000, 20.0);
    assert!((speed + GRAVITY * RELAXATION).abs() < ROUND_OFF, "{speed}");
}

#[test]
fn drag_decays_exponentially_to_first_order_in_the_time_step() {
    let exact = 3.0 * (-1.0 / RELAXATION).exp();
    let error = |steps| final_speed(&in_air(3.0, 0.0), steps, 1.0) / exact - 1.0;
    // To first order the relative error is half the duration times the step over RELAXATION².
    let (coarse, fine) = (error(1_000), error(10_000));
    assert!(
        (fine / (-0.5 * 1e-4 / RELAXATION.powi(2)) - 1.0).abs() < 1e-3,
        "{fine:e}"
    );
    assert!((coarse / fine / 10.0 - 1.0).abs() < 1e-2, "{coarse:e}");
}

#[test]
fn derivatives_flow_through_forces_of_the_users_own() {
    let (speed, steps, time_step) = (3.0, 1_000, 1e-3_f64);
    let world = in_air(speed, 0.0);
    let experiment = Experiment::new(&world, &Plan::new(time_step, steps).unwrap());
    let parameters = [
        Parameter::InitialVelocity("ball".into()),
        Parameter::Mass("ball".into()),
        Parameter::Gravity,
    ];
    let outcome = FinalState::of_body(&world, "ball").unwrap();
    let jacobian = experiment.jacobian(&parameters, &outcome).unwrap().jacobian;
    let (position, velocity) = (0, 12);
    // Of the scheme: each kick leaves a share q of the velocity, each step moves by the mean.
    let q = 1.0 - time_step / RELAXATION;
    let left = q.powi(i32::try_from(steps).unwrap());
    let way = time_step * (1.0 + q) / 2.0 * (1.0 - left) / (1.0 - q);
    assert!((jacobian[(velocity, 0)] - left).abs() < ROUND_OFF);
    assert!((jacobian[(position, 0)] - way).abs() < ROUND_OFF);
    // Of the motion itself: v = v₀ exp(−c t/m), by the mass m and by gravity g.
    let decayed = (-1.0 / RELAXATION).exp();
    let by_mass = speed * DRAG * decayed;
    let by_gravity = RELAXATION * (1.0 - decayed);
    assert!((jacobian[(velocity, 3)] / by_mass - 1.0).abs() < 2e-3);
    assert!((jacobian[(velocity, 4)] / by_gravity - 1.0).abs() < 2e-3);
    let check = experiment.difference_check(&parameters, &outcome).unwrap();
    assert!(check.best() < 1e-8, "{check}");
}

/// A thrust along x on the body named "rocket" that grows with time (m/s³), and no gravity: in the paper's form, where a
/// body's true accelerations are a function of those that contact gives it.
struct Rocket(f64);

impl Rocket {
    fn true_acceleration<T: Scalar>(&self, time: f64, body: &str, contact: Twist<T>) -> Twist<T> {
        let mut linear = contact.linear;
        if body == "rocket" {
            linear.x += lift::<T>(self.0 * time);
        }
        Twist { linear, ..contact }
    }
}

impl Force for Rocket {
    fn add_to<T: Scalar>(&self, wrenches: &mut Wrenches<T>, now: &Situation<T>) {
        for (index, body) in now.bodies.iter().enumerate() {
            let Some(inertia) = body.inertia() else {
                continue;
            };
            let rotation = now.states[index].pose.rotation();
            let contact = Twist {
                angular: inertia.angular_velocity(rotation, &now.contact[index].torque),
                linear: now.contact[index].force / inertia.mass,
            };
            let wanted = self.true_acceleration(now.time, body.name(), contact);
            let linear = wanted.linear - contact.linear - now.gravity;
            let angular = wanted.angular - contact.angular;
            let wrench = Wrench {
                torque: inertia.angular_momentum(rotation, &angular),
                force: linear * inertia.mass,
            };
            wrenches.add(index, &wrench);
        }
    }
}

#[test]
fn forces_of_the_users_own_know_the_time_and_the_body() {
    let rocket = ball("rocket").at(at(0.0, 1.0, 0.0));
    let world = World::new(vec![ball("ball"), rocket]).unwrap();
    let world = world.with_gravity(down()).unwrap();
    let world = world.with_forces(Rocket(4.0)).unwrap();
    let plan = Plan::new(1e-2, 100).unwrap().recording_every(100);
    let last = world.rollout(&plan).recorded().unwrap().last().clone();
    // Kicks are in the middle of steps, where the midpoint rule is exact for a linear force.
    let thrust = last.bodies[1].twist.linear - vector![2.0, 0.0, 0.0];
    assert!(thrust.amax() < ROUND_OFF, "{thrust}");
    assert_eq!(
        last.bodies[0].twist.linear,
        Vector3::zeros(),
        "the force takes gravity away"
    );
}

// Free bodies that turn.

/// A free body with mass properties as given, which moves and turns.
fn tumbling(properties: MassProperties, spin: Vector3<f64>) -> World {
    let body = Body::dynamic("body", ball_shape(), SKIN, Mass::Given(properties)).unwrap();
    let start = Pose::from_rotation_vector(&vector![0.5, 0.1, -0.4], vector![0.3, -0.2, 0.1]);
    let moving = body.at(start).with_velocity(vector![0.2, -0.1, 0.3]);
    World::new(vec![moving.with_spin(spin)]).unwrap()
}

/// Equal moments about a centre of mass that is off the origin.
fn off_center_sphere() -> MassProperties {
    MassProperties {
        inertia: Matrix3::identity() * 0.02,
        ..asymmetric()
    }
}

fn center_of_mass(world: &World, state: &State) -> Vector3<f64> {
    let inertia = world.bodies()[0].inertia().unwrap();
    state.bodies[0]
        .pose
        .transformed_point(&inertia.center_of_mass)
}

#[test]
fn a_free_body_turns_about_its_centre_of_mass_which_moves_straight() {
    for properties in [asymmetric(), off_center_sphere()] {
        let world = tumbling(properties, vector![3.0, -2.0, 5.0]);
        let start = world.initial_state();
        let [from, velocity] = [center_of_mass(&world, &start), start.bodies[0].twist.linear];
        for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
            let mut origin_strayed = 0.0_f64;
            for state in world
                .rollout(&Plan::new(1e-3, 5_000).unwrap().with_integrator(integrator))
                .take(5_000)
            {
                let state = state.unwrap();
                let straight = from + velocity * state.time;
                let off = center_of_mass(&world, &state) - straight;
                assert!(off.amax() <= ROUND_OFF, "{off}");
                assert_eq!(state.bodies[0].twist.linear, velocity);
                let origin = state.bodies[0].pose.translation() - velocity * state.time;
                let strayed = origin - start.bodies[0].pose.translation();
                origin_strayed = origin_strayed.max(strayed.norm());
            }
            assert!(
                origin_strayed > 0.01,
                "the origin circles: {origin_strayed}"
            );
        }
    }
}

#[test]
fn a_body_of_equal_moments_turns_as_the_exponential_map_says() {
    let spin = vector![3.0, -2.0, 5.0];
    let world = tumbling(off_center_sphere(), spin);
    let start = *world.initial_state().bodies[0].pose.rotation();
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        let last = world
            .rollout(&Plan::new(1e-2, 1_000).unwrap().with_integrator(integrator))
            .nth(999);
        let last = last.unwrap().unwrap();
        let exact = rotation_from_vector(&(spin * 10.0)) * start;
        let off = (last.bodies[0].pose.rotation() - exact).amax();
        assert!(off <= ROUND_OFF, "{off:e}");
        assert_eq!(last.bodies[0].twist.angular, spin);
    }
}

/// Largest relative deviation of the kinetic energy of the asymmetric top in 50 s of so many steps.
fn energy_deviation(steps: usize) -> f64 {
    let world = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let kinetic = |state: &State| world.report(state).unwrap().kinetic_energy;
    let start = kinetic(&world.initial_state());
    let states = leapfrog(&world, 50.0 / steps as f64).take(steps);
    states
        .map(|state| (kinetic(&state.unwrap()) / start - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn an_asymmetric_top_keeps_its_energy_to_second_order_without_drift() {
    let (coarse, fine) = (energy_deviation(12_500), energy_deviation(50_000));
    assert!(fine < 1e-5, "{fine:e}");
    assert!(
        (coarse / fine / 16.0 - 1.0).abs() < 0.1,
        "{coarse:e} {fine:e}"
    );
}

#[test]
fn an_asymmetric_top_keeps_its_angular_momentum() {
    let world = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let start = world
        .report(&world.initial_state())
        .unwrap()
        .momentum
        .angular;
    for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
        for state in world
            .rollout(&Plan::new(1e-3, 10_000).unwrap().with_integrator(integrator))
            .take(10_000)
        {
            let now = world.report(&state.unwrap()).unwrap().momentum.angular;
            let off = (now - start).amax() / start.amax();
            assert!(off <= 10.0 * ROUND_OFF, "{off:e}");
        }
    }
}

#[test]
fn the_leapfrog_run_backwards_returns_to_the_start() {
    // A free top, and an elastic bounce with a spin.
    let top = tumbling(asymmetric(), vector![3.0, -2.0, 5.0]);
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.14, 0.12], 1).unwrap()));
    let egg = Body::dynamic("egg", egg, SKIN, Mass::Total(1.0)).unwrap();
    let thrown = egg.at(at(0.0, 0.0, 0.2)).with_spin(vector![1.0, 2.0, 0.5]);
    let bounce = World::new(vec![thrown, floor(SKIN)]).unwrap();
    let bounce = bounce.with_gravity(down()).unwrap();
    for (world, touches) in [(top, false), (bounce, true)] {
        let plan = Plan::new(1e-3, 400).unwrap();
        let there = world.rollout(&plan).recorded().unwrap();
        let mut touching = there
            .states()
            .iter()
            .filter(|state| world.topology(state).unwrap().polygon_count() > 0);
        assert_eq!(touching.next().is_some(), touches);
        let turned = world
            .rollout(&plan.recording_every(400))
            .starting_from(reversed(there.last()))
            .unwrap();
        let back = reversed(turned.recorded().unwrap().last());
        let off = distance(&back.bodies[0], &world.initial_state().bodies[0]);
        assert!(off <= REVERSED, "{off:e}");
    }
}

fn reversed(state: &State) -> State {
    let mut state = state.clone();
    for body in &mut state.bodies {
        body.twist.linear.neg_mut();
        body.twist.angular.neg_mut();
    }
    state
}

/// Largest difference of any number of two states.
fn distance(a: &BodyState, b: &BodyState) -> f64 {
    let pose = (a.pose.translation() - b.pose.translation()).amax();
    let turn = (a.pose.rotation() - b.pose.rotation()).amax();
    let linear = (a.twist.linear - b.twist.linear).amax();
    let angular = (a.twist.angular - b.twist.angular).amax();
    pose.max(turn).max(linear).max(angular)
}

/// Spins (rad/s) about a principal axis, seen from the body, over 60 s after a slightly skew start.
fn spins_about(axis: usize) -> Vec<f64> {
    let properties = MassProperties {
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&vector![0.01, 0.02, 0.025]),
        mass: 1.0,
    };
    let spin = Vector3::ith(axis, 5.0) + vector![0.01, 0.01, 0.01];
    let body = Body::dynamic("wingnut", ball_shape(), SKIN, Mass::Given(properties)).unwrap();
    let world = World::new(vec![body.with_spin(spin)]).unwrap();
    let states = leapfrog(&world, 2e-3).take(30_000).map(Result::unwrap);
    let seen_from_body = |state: State| {
        let BodyState { pose, twist } = &state.bodies[0];
        (pose.rotation().transpose() * twist.angular)[axis]
    };
    states.map(seen_from_body).collect()
}

#[test]
fn a_wingnut_flips_about_its_intermediate_axis_and_no_other() {
    for axis in [0, 2] {
        let spins = spins_about(axis);
        assert!(spins.iter().all(|spin| (spin / 5.0 - 1.0).abs() < 0.01));
    }
    let spins = spins_about(1);
    let flips = spins.windows(2).filter(|pair| pair[0] * pair[1] < 0.0);
    let flips = flips.count();
    assert!((8..40).contains(&flips), "{flips}");
    let (low, high) = spins.iter().fold((0.0_f64, 0.0_f64), |(low, high), &spin| {
        (low.min(spin), high.max(spin))
    });
    assert!(
        (low / 5.0 + 1.0).abs() < 0.01 && (high / 5.0 - 1.0).abs() < 0.01,
        "{low} {high}"
    );
}

#[test]
fn a_world_with_a_body_on_a_turning_path_can_be_changed() {
    let path = |time: f64| BodyState {
        pose: Pose::from_rotation_vector(&vector![0.3, 0.7 + time, -0.4], vector![3.0, 0.0, 0.0]),
        twist: Twist::zero(),
    };
    // Many starts: for some the rounding of the path's rotation happens to be left as it is.
    for start in 0..50 {
        let turning = Arc::new(move |time: f64| path(time + 0.1 * f64::from(start)));
        let skin = Material::elastic(1e5);
        let world = World::new(vec![
            Body::dynamic("ball", ball_shape(), skin, Mass::Total(1.0)).unwrap(),
            Body::prescribed("arm", ball_shape(), skin, turning).unwrap(),
        ]);
        let world = world.unwrap();
        let by = [Parameter::InitialVelocity("ball".into())];
        let changed = world.changed(&by, &[1.0, 0.0, 0.0]).unwrap();
        assert!((changed.bodies()[0].initial().velocity().x - 1.0).abs() <= 0.0);
    }
}
