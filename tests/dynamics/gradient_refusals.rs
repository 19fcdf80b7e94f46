//! Parameters, outcomes and changes that gradients reject.

use crate::scenes::{SKIN, assert_names, ball, ball_shape, floor, still_at};
use approx::assert_relative_eq;
use hydroelastic::dynamics::{Body, Plan, World, WorldError};
use hydroelastic::gradient::{
    Experiment, FinalPosition, FinalState, GradientError, Parameter, RecordedStates,
};
use nalgebra::{Matrix3, Vector3};
use std::slice;
use std::sync::Arc;

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

/// Returns the error of the derivatives of the first body's position with respect to a parameter.
fn refused_gradient(world: &World, parameter: &Parameter) -> GradientError {
    let by = slice::from_ref(parameter);
    let experiment = Experiment::new(world, &Plan::new(1e-3, 10).unwrap());
    let outcome = FinalPosition::of_body(world, world.bodies()[0].name()).unwrap();
    let error = experiment.jacobian(by, &outcome).unwrap_err();
    let check = experiment.difference_check(by, &outcome);
    let after = experiment.value_perturbed(by, &[0.0; 3], &outcome);
    assert_eq!(check.unwrap_err(), error);
    assert_eq!(after.unwrap_err(), error);
    error
}

#[test]
fn a_parameter_of_no_body_of_the_world_is_refused() {
    let world = World::new(vec![ball("ball"), floor(SKIN)]).unwrap();
    for parameter in [
        Parameter::initial_position("bal"),
        Parameter::modulus("bal"),
        Parameter::mass("bal"),
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
    let driven = Body::kinematic("cart", ball_shape(), SKIN, Arc::new(|_| still_at(2.0)));
    let world = World::new(vec![ball("ball"), floor(SKIN), driven.unwrap()]).unwrap();
    for (parameter, body) in [
        (Parameter::mass("floor"), "floor"),
        (Parameter::radius_of_gyration("floor"), "floor"),
        (Parameter::initial_velocity("floor"), "floor"),
        (Parameter::initial_angular_velocity("floor"), "floor"),
        (Parameter::mass("cart"), "cart"),
        (Parameter::initial_position("cart"), "cart"),
        (Parameter::initial_orientation("cart"), "cart"),
    ] {
        let error = refused_gradient(&world, &parameter);
        let expected = GradientError::NotDynamic {
            body: body.into(),
            parameter: parameter.to_string(),
        };
        assert_eq!(error, expected);
    }
    let error = refused_gradient(&world, &Parameter::mass("floor"));
    assert_eq!(
        error.to_string(),
        "the mass of \"floor\" has no effect, because forces do not move body \"floor\": it is fixed or follows a path"
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
    let parameters = [Parameter::mass("ball"), Parameter::Gravity];
    let error = world.perturbed(&parameters, &[0.0; 3]).unwrap_err();
    let (found, expected) = (3, 4);
    assert_eq!(error, GradientError::NumberCount { found, expected });
    for change in [-1.0, -2.0, f64::NAN] {
        let error = world.perturbed(&parameters, &[change, 0.0, 0.0, 0.0]);
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
fn a_radius_of_gyration_scales_the_inertia_and_must_be_positive() {
    let world = World::new(vec![ball("ball")]).unwrap();
    let radius = [Parameter::radius_of_gyration("ball")];
    let value = world.values(&radius).unwrap()[0];
    let momentum = |world: &World| {
        let inertia = world.bodies()[0].inertia().unwrap();
        inertia
            .angular_momentum(&Matrix3::identity(), &Vector3::x())
            .x
    };
    let larger = world.with_values(&radius, &[2.0 * value]).unwrap();
    assert_relative_eq!(larger.values(&radius).unwrap()[0], 2.0 * value);
    assert_relative_eq!(
        momentum(&larger),
        4.0 * momentum(&world),
        max_relative = 1e-14
    );
    for wrong in [0.0, -0.1, f64::NAN] {
        let GradientError::World(error) = world.with_values(&radius, &[wrong]).unwrap_err() else {
            panic!("not of the world")
        };
        assert_names(&error, "the radius of gyration of body \"ball\"");
    }
}

#[test]
fn a_world_is_not_given_two_values_of_one_parameter() {
    let world = World::new(vec![ball("ball"), ball("other")]).unwrap();
    let mass = Parameter::mass;
    let distinct = [mass("ball"), Parameter::modulus("ball"), mass("other")];
    world.with_values(&distinct, &[1.0, 2e5, 3.0]).unwrap();
    let parameters = [mass("ball"), Parameter::modulus("ball"), mass("ball")];
    let values = [1.0, 2e5, 3.0];
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 10).unwrap());
    let errors = [
        world.with_values(&parameters, &values).unwrap_err(),
        experiment.at(&parameters, &values).unwrap_err(),
    ];
    for error in errors {
        let message = error.to_string();
        assert_eq!(
            message,
            "the mass of \"ball\" has two values, but must have one"
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
