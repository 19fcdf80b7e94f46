use crate::tosses::{NOISE, TRUTH, clean, noise, noisy, nuisances, plan, unknowns, world};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, Trajectory, World};
use hydroelastic::gradient::Parameter;
use hydroelastic::identification::{
    Checkpoint, Identification, IdentificationError, Measurement, Prediction, Unknown,
};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Round-off of sums of a few hundred squares, relative to the sum.
const ROUND_OFF: f64 = 1e-10;

fn residuals(
    identification: &Identification,
    measurements: &[Measurement],
    checkpoint: &Checkpoint,
) -> Vec<Prediction> {
    let residuals = identification.residuals(measurements, checkpoint).unwrap();
    residuals.into_iter().map(Result::unwrap).collect()
}

/// Returns the recording with the body moved by 2 cm in one state.
fn displaced(measurement: &Measurement, state: usize, body: usize) -> Measurement {
    let mut states = measurement.trajectory().states().to_vec();
    let pose = &mut states[state].bodies[body].pose;
    *pose = Pose::from_translation(vector![0.02, 0.0, 0.0]) * *pose;
    Measurement::new(measurement.name(), Trajectory::new(states).unwrap())
}

#[test]
fn squared_residuals_and_priors_add_up_to_the_costs_of_a_fit() {
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let identification = identification.with_noise(noise());
    let identification = identification.with_nuisances(&nuisances()).unwrap();
    let measurements = noisy(&clean(2), 0);
    let fit = identification.fit(&measurements).unwrap();
    let residuals = residuals(&identification, &measurements, &fit.checkpoint);
    let deviations = [NOISE[0], NOISE[1], 0.02, 0.2];
    for ((residual, fitted), nuisances) in residuals
        .iter()
        .zip(&fit.measurements)
        .zip(&fit.checkpoint.nuisances)
    {
        let priors = nuisances.iter().enumerate();
        let priors: f64 = priors.map(|(i, x)| (x / deviations[i / 3]).powi(2)).sum();
        let cost = 0.5 * (30.0 * residual.mean_squares()[0] + priors);
        assert!(
            (cost / fitted.cost - 1.0).abs() < ROUND_OFF,
            "{cost} instead of {}",
            fitted.cost
        );
        // 180 numbers per toss have a mean square of 1 ± 0.11, of which the fit absorbs 7 %.
        let mean = residual.mean_squares()[0] / 6.0;
        assert!((0.6..1.3).contains(&mean), "{mean}");
    }
}

#[test]
fn normalized_errors_combine_the_errors_of_positions_and_rotations() {
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let identification = identification.with_noise(noise());
    let measurements = noisy(&clean(1), 1);
    let checkpoint = identification.fit(&measurements).unwrap().checkpoint;
    let residual = &residuals(&identification, &measurements, &checkpoint)[0];
    for (state, normalized) in residual.normalized_errors.iter().enumerate() {
        let position = residual.position_errors[state][0] / NOISE[0];
        let rotation = 2.0 * (0.5 * residual.rotation_errors[state][0]).sin() / NOISE[1];
        let expected = position.hypot(rotation);
        assert!((normalized[0] - expected).abs() < ROUND_OFF * expected.max(1.0));
    }
}

#[test]
fn the_largest_residual_is_that_of_the_displaced_body_in_its_state() {
    let ball = |name, x| {
        let shape = Shape::new(shapes::icosphere(0.05, 1).unwrap());
        let ball = Body::dynamic(name, shape, Material::elastic(1e5), Mass::Total(0.2)).unwrap();
        ball.with_pose(Pose::from_translation(vector![x, 0.0, 0.0]))
    };
    let world = World::new(vec![ball("near", 0.0), ball("far", 1.0)]).unwrap();
    let world = world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap();
    let recorded = Measurement::new("fall", world.rollout(&plan()).run().unwrap());
    let measurements = [recorded.clone(), displaced(&recorded, 7, 1)];
    let gravity = Unknown::new(Parameter::Gravity).component(2);
    let identification = Identification::new(&world, &plan(), &[gravity]).unwrap();
    let checkpoint = identification.fit(&measurements).unwrap().checkpoint;
    let [undisturbed, disturbed] = &residuals(&identification, &measurements, &checkpoint)[..]
    else {
        panic!("each measurement has residuals");
    };
    assert!(undisturbed.mean_squares().iter().all(|mean| *mean < 1e-3));
    let [near, far] = disturbed.mean_squares()[..] else {
        panic!("both bodies are observed");
    };
    // 2 cm are 20 standard deviations of 1 mm, in one of 30 states.
    assert!(near < 1e-3 && (far / (400.0 / 30.0) - 1.0).abs() < 1e-3);
    assert!((disturbed.position_errors[7][1] - 0.02).abs() < 1e-5);
}

#[test]
fn a_measurement_that_cannot_be_simulated_has_an_error_alone() {
    let mut measurements = clean(2);
    let mut states = measurements[0].trajectory().states().to_vec();
    let BodyState { pose, .. } = &mut states[0].bodies[0];
    *pose = pose.with_translation(vector![0.0, 0.0, -1.0]);
    measurements[0] = Measurement::new("below", Trajectory::new(states).unwrap());
    let identification = Identification::new(&world(TRUTH), &plan(), &unknowns()).unwrap();
    let mut checkpoint = identification.fit(&measurements).unwrap().checkpoint;
    let residuals = identification.residuals(&measurements, &checkpoint);
    let [failed, simulated] = &residuals.unwrap()[..] else {
        panic!("each measurement has a result");
    };
    assert!(failed.is_err() && simulated.is_ok());
    checkpoint.nuisances.pop();
    let error = identification
        .residuals(&measurements, &checkpoint)
        .unwrap_err();
    assert_eq!(
        error,
        IdentificationError::WrongCount {
            quantity: "measurements",
            found: 1,
            expected: 2
        }
    );
}
