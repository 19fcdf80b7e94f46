use crate::tosses::{TRUTH, clean, plan, unknowns, world};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Body, Material, Plan, Trajectory, World};
use hydroelastic::gradient::Parameter;
use hydroelastic::identification::{
    Identification, IdentificationError, Measurement, Noise, Nuisance, RobustLoss, StartingState,
    Unknown,
};

fn refused(unknowns: &[Unknown]) -> String {
    let result = Identification::new(&world(TRUTH), &plan(), unknowns);
    result.unwrap_err().to_string()
}

#[test]
fn invalid_unknowns_are_refused() {
    let friction = || Unknown::new(Parameter::friction("ball"));
    assert_eq!(
        refused(&[friction().bounded(0.3, 0.5)]),
        "the initial guess of the unknown \"the friction of \\\"ball\\\"\" is 0.2, but must be between 0.3 and 0.5, both excluded: change the value or the range"
    );
    assert!(refused(&[friction().component(1)]).contains("has no component 1"));
    assert!(refused(&[friction(), friction().named("other")]).contains("set the same component"));
    for deviation in [0.0, 1e-200, 1e200] {
        let message = refused(&[friction().with_prior(0.2, deviation)]);
        assert!(message.contains("must be positive, from 1e-150 to 1e150"));
    }
    assert!(
        refused(&[friction().logarithmic().with_prior(-1.0, 1.0)])
            .contains("is -1, but must be between 0 and inf")
    );
    assert!(refused(&[Unknown::new(Parameter::modulus("table"))]).contains("is rigid"));
}

#[test]
fn invalid_settings_are_refused() {
    let identification = || Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    for wrong in [0.0, -1.0, 1e-160, 1e-200, 1e200, f64::NAN] {
        assert!(Noise::new(wrong, 1.0).is_err() && Noise::new(1.0, wrong).is_err());
        let nuisance = Nuisance::new(Parameter::initial_velocity("ball"), wrong);
        assert!(identification().with_nuisances(&[nuisance]).is_err());
        let loss = RobustLoss::Cauchy(wrong);
        assert!(identification().with_loss(loss).is_err());
    }
    let nuisance = Nuisance::new(Parameter::initial_velocity("ball"), 1.0).component(3);
    assert!(identification().with_nuisances(&[nuisance]).is_err());
    assert!(identification().with_horizons(&[0.1, 0.0]).is_err());
    let predict = |start| identification().predict(&TRUTH, &clean(1)[0], start);
    assert!(predict(StartingState::Fitted(-1.0)).is_err());
    let start = StartingState::Measured;
    let error = identification()
        .predict(&[1.0], &clean(1)[0], start)
        .unwrap_err();
    assert_eq!(error.to_string(), "expected 3 values, but found 1");
    let negative = [-1.0, 1.0, 0.2];
    let error = identification()
        .predict(&negative, &clean(1)[0], start)
        .unwrap_err();
    assert!(
        matches!(error, IdentificationError::OutOfRange { .. }),
        "{error}"
    );
}

#[test]
fn worlds_without_a_dynamic_body_are_refused() {
    let table = Body::fixed("table", HalfSpace::rigid(), Material::rigid()).unwrap();
    let world = World::new(vec![table]).unwrap();
    let error = Identification::new(&world, &plan(), &[]).unwrap_err();
    assert_eq!(error, IdentificationError::NoDynamicBody(1));
}

#[test]
fn nuisances_that_change_the_same_component_are_refused() {
    let with = |nuisances: &[Nuisance]| {
        let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
        identification.with_nuisances(nuisances).map(|_| ())
    };
    let velocity = || Nuisance::new(Parameter::initial_velocity("ball"), 1.0);
    let duplicate = |component| {
        let parameter = Parameter::initial_velocity("ball").to_string();
        Err(IdentificationError::DuplicateNuisance {
            parameter,
            component,
        })
    };
    assert_eq!(with(&[velocity(), velocity()]), duplicate(0));
    assert_eq!(with(&[velocity(), velocity().component(2)]), duplicate(2));
    assert_eq!(
        with(&[velocity().component(1), velocity().component(2)]),
        Ok(())
    );
}

#[test]
fn observed_bodies_are_distinct_and_dynamic() {
    let refused = |bodies: &[&str]| {
        let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
        identification.with_observed_bodies(bodies).unwrap_err()
    };
    assert_eq!(refused(&[]), IdentificationError::NoObservedBody);
    assert_eq!(
        refused(&["ball", "ball"]),
        IdentificationError::ObservedTwice("ball".into())
    );
    assert_eq!(
        refused(&["ball", "table"]),
        IdentificationError::ObservedNotDynamic("table".into())
    );
    assert!(matches!(refused(&["cube"]), IdentificationError::World(_)));
}

#[test]
fn invalid_measurements_are_refused() {
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let fitted = |measurement: Measurement| identification.fit(&[measurement]).unwrap_err();
    assert_eq!(
        identification.fit(&[]).unwrap_err(),
        IdentificationError::NoMeasurement
    );
    let states = clean(1)[0].trajectory().states().to_vec();
    let measurement = |states| Measurement::new("toss", Trajectory::new(states).unwrap());
    assert_eq!(
        fitted(measurement(states[..1].to_vec())),
        IdentificationError::TooFewStates("toss".into())
    );
    let mut late = states.clone();
    late[30].time += 0.004;
    assert!(
        fitted(measurement(late))
            .to_string()
            .contains("is not a multiple of the time step")
    );
    let mut lost = states.clone();
    lost[7].bodies[0].pose = lost[7].bodies[0]
        .pose
        .with_translation([f64::NAN; 3].into());
    assert!(
        fitted(measurement(lost))
            .to_string()
            .starts_with("the pose of body 0 in state 7 of measurement \"toss\" is invalid")
    );
    let mut fewer = states;
    for state in &mut fewer {
        state.bodies.truncate(1);
    }
    assert!(matches!(
        fitted(measurement(fewer)),
        IdentificationError::Gradient(_)
    ));
    let explicit = Plan::new(0.01, 1).unwrap();
    let identification = Identification::new(&world([1e9, 0.0, 0.0]), &explicit, &[]).unwrap();
    let error = identification.fit(&clean(1)).unwrap_err();
    assert!(
        matches!(error, IdentificationError::NoRollout { .. }),
        "{error}"
    );
}

#[test]
fn a_horizon_index_beyond_the_horizons_is_refused() {
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let identification = identification.with_horizons(&[0.1]).unwrap();
    let mut checkpoint = identification.fit(&clean(1)).unwrap().checkpoint;
    assert_eq!(checkpoint.horizon, 1);
    checkpoint.horizon = 2;
    let error = identification.resume(&clean(1), checkpoint).unwrap_err();
    assert_eq!(
        error,
        IdentificationError::HorizonIndex { found: 2, count: 1 }
    );
}
