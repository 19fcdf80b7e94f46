//! Numbers, names and settings that bodies and worlds reject, and the names in the errors.

use crate::scenes::{SKIN, assert_names, asymmetric, at, ball, ball_shape, still_at};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, Spring, World, WorldError};
use hydroelastic::spatial::{MassProperties, Pose, PoseError};
use nalgebra::{Matrix3, Vector3, vector};
use std::sync::Arc;

/// Invalid values of numbers that must be positive and finite.
const NOT_POSITIVE: [f64; 4] = [0.0, -1.0, f64::NAN, f64::INFINITY];

/// Invalid values of numbers that must not be negative.
const NEGATIVE: [f64; 3] = [-1e-9, f64::NAN, f64::INFINITY];

const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

#[test]
fn a_material_out_of_range_is_refused_with_the_body_the_quantity_and_the_value() {
    let refused = |skin: Material, quantity: &str, value: f64| {
        let moving = Body::dynamic("cube", ball_shape(), skin, Mass::Total(1.0)).unwrap_err();
        let still = Body::fixed("cube", ball_shape(), skin).unwrap_err();
        let path = Arc::new(|_| still_at(0.0));
        let driven = Body::kinematic("cube", ball_shape(), skin, path).unwrap_err();
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
        let friction = Some(value);
        refused(Material { friction, ..SKIN }, "friction", value);
    }
}

fn assert_mass_refused(mass: Mass, message: &str) {
    let error = Body::dynamic("cube", ball_shape(), SKIN, mass).unwrap_err();
    assert!(matches!(error, WorldError::Mass { .. }), "{error}");
    assert_names(&error, message);
}

#[test]
fn a_mass_or_density_that_is_not_positive_and_finite_is_refused() {
    for value in NOT_POSITIVE {
        let of_body = |quantity: &str| format!("the {quantity} of body \"cube\" is {value}");
        assert_mass_refused(Mass::Density(value), &of_body("density"));
        assert_mass_refused(Mass::Total(value), &of_body("mass"));
        let mass = value;
        let properties = MassProperties {
            mass,
            ..asymmetric()
        };
        assert_mass_refused(Mass::Properties(properties), &of_body("mass"));
    }
}

fn with_inertia(inertia: Matrix3<f64>) -> Mass {
    Mass::Properties(MassProperties {
        inertia,
        ..asymmetric()
    })
}

#[test]
fn an_inertia_that_is_not_positive_definite_and_finite_is_refused() {
    let moments = |smallest: f64| Matrix3::from_diagonal(&vector![0.1, smallest, 0.1]);
    for value in [0.0, -0.1] {
        let message =
            format!("the smallest principal moment of inertia of body \"cube\" is {value}, but");
        assert_mass_refused(with_inertia(moments(value)), &message);
    }
    for value in NOT_FINITE {
        let message = format!("the inertia of body \"cube\" is {value}, but");
        assert_mass_refused(with_inertia(moments(value)), &message);
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
fn a_center_of_mass_that_is_not_finite_is_refused() {
    for value in NOT_FINITE {
        let properties = MassProperties {
            center_of_mass: vector![0.0, value, 0.0],
            ..asymmetric()
        };
        let error =
            Body::dynamic("cube", ball_shape(), SKIN, Mass::Properties(properties)).unwrap_err();
        assert!(matches!(error, WorldError::CenterOfMass { .. }), "{error}");
        assert_names(
            &error,
            &format!("the center of mass of body \"cube\" has the component {value}"),
        );
    }
}

#[test]
fn a_pose_that_is_not_finite_is_refused() {
    for value in NOT_FINITE {
        let error = World::new(vec![
            ball("first"),
            ball("lost").with_pose(at(0.0, value, 0.0)),
        ]);
        let error = error.unwrap_err();
        let WorldError::Pose { body, source } = &error else {
            panic!("{error}")
        };
        assert_eq!(body, "lost");
        assert!(matches!(source, PoseError::NotFinite(_)));
    }
    let spun = Pose::from_rotation_vector(&vector![f64::NAN, 0.0, 0.0], Vector3::zeros());
    let error = World::new(vec![ball("spun").with_pose(spun)]).unwrap_err();
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
            (ball("comet").with_angular_velocity(vector), "spin"),
        ] {
            let error = World::new(vec![body]).unwrap_err();
            assert!(matches!(error, WorldError::Velocity { .. }));
            let message = format!("the {quantity} of body \"comet\" has the component {value}");
            assert_names(&error, &message);
        }
    }
}

#[test]
fn a_path_that_starts_nowhere_is_refused() {
    let path = Arc::new(|_| still_at(f64::NAN));
    let body = Body::kinematic("ghost", ball_shape(), SKIN, path).unwrap();
    let error = World::new(vec![body]).unwrap_err();
    assert_names(&error, "the pose of body \"ghost\" is unusable");
}

#[test]
fn a_body_that_forces_do_not_move_takes_no_start_that_it_would_not_keep() {
    let fixed = || Body::fixed("rock", ball_shape(), SKIN).unwrap();
    let driven = || Body::kinematic("rock", ball_shape(), SKIN, Arc::new(|_| still_at(0.5)));
    let driven = || driven().unwrap();
    let some = vector![0.0, 0.1, 0.0];
    for (body, quantity) in [
        (fixed().with_velocity(some), "velocity"),
        (fixed().with_angular_velocity(some), "spin"),
        (driven().with_pose(at(0.0, 0.0, 0.0)), "pose"),
        (driven().with_velocity(some), "velocity"),
        (driven().with_angular_velocity(some), "spin"),
    ] {
        let error = World::new(vec![body]).unwrap_err();
        assert!(matches!(error, WorldError::NotDynamic { .. }), "{error}");
        assert_names(
            &error,
            &format!("body \"rock\" cannot have a {quantity} of its own"),
        );
    }
    World::new(vec![fixed().with_pose(at(1.0, 2.0, 3.0))]).unwrap();
    World::new(vec![driven()]).unwrap();
}

/// A path belongs to the body. Therefore a body from a world at any time can be added to a new world, which starts at time 0.
#[test]
fn a_body_on_a_path_can_be_taken_from_a_world_at_any_time() {
    let path = Arc::new(|time| still_at(1.0 + time));
    let driven = Body::kinematic("rock", ball_shape(), SKIN, path).unwrap();
    let world = World::new(vec![driven]).unwrap();
    let mut state = world.initial_state();
    state.time = 0.25;
    let later = world.with_initial_state(&state).unwrap();
    let body = &later.bodies()[0];
    assert_eq!(body.initial_time().to_bits(), 0.25_f64.to_bits());
    assert_eq!(body.initial_state().position(), still_at(1.25).position());
    let anew = World::new(later.bodies().to_vec()).unwrap();
    assert_eq!(
        anew.initial_state().bodies[0].position(),
        still_at(1.0).position()
    );
}

#[test]
fn a_force_parameter_needs_a_name() {
    let world = World::new(vec![ball("one")]).unwrap();
    let error = world.with_force_parameter("", 1.0).unwrap_err();
    assert_eq!(error, WorldError::UnnamedForceParameter);
}

#[test]
fn a_spring_between_two_bodies_that_do_not_move_is_refused() {
    let body = |name| Body::fixed(name, ball_shape(), SKIN).unwrap();
    let world = World::new(vec![body("one"), body("two")]).unwrap();
    let spring = Spring {
        bodies: ["one".into(), "two".into()],
        points: [[0.0; 3]; 2],
        rest_length: 0.0.into(),
        stiffness: 1.0.into(),
        damping: 0.0.into(),
    };
    let error = world.with_forces(spring).unwrap_err();
    assert_names(
        &error,
        "a spring between bodies \"one\" and \"two\" moves nothing",
    );
}

#[test]
fn a_change_between_states_that_is_not_finite_is_refused() {
    let world = World::new(vec![ball("one")]).unwrap();
    let [mut from, mut to] = [world.initial_state(), world.initial_state()];
    from.bodies[0].pose = at(-1e308, 0.0, 0.0);
    to.bodies[0].pose = at(1e308, 0.0, 0.0);
    let error = world.difference(&from, &to).unwrap_err();
    assert!(matches!(error, WorldError::Setting { .. }), "{error}");
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
    assert_eq!(world().with_ignored("one", "three").unwrap_err(), unknown);
    assert_eq!(world().with_ignored("three", "one").unwrap_err(), unknown);
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
        let step = Plan::new(value, 0).unwrap_err();
        assert!(matches!(step, WorldError::Setting { .. }));
        let message = format!("the time step is {value}, but must be positive and finite");
        assert_names(&step, &message);
    }
    for value in NOT_POSITIVE.into_iter().chain([0.9e-100, 1.1e100]) {
        let slip = world().with_slip_tolerance(value).unwrap_err();
        assert!(matches!(slip, WorldError::Setting { .. }));
        let message =
            format!("the slip tolerance is {value}, but must be from 1e-100 to 1e100 m/s");
        assert_names(&slip, &message);
    }
}
