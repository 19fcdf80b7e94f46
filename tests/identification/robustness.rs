use crate::tosses::{TRUTH, clean, noise, plan, unknowns, world};
use hydroelastic::dynamics::Trajectory;
use hydroelastic::identification::{Identification, Measurement, RobustLoss};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Relative error of estimates from recordings without noise.
const CLEAN: f64 = 1e-4;

/// Returns the largest error of the logarithms of the estimates.
fn error(loss: RobustLoss, measurements: &[Measurement]) -> f64 {
    let guess = TRUTH.map(|value| 1.2 * value);
    let identification = Identification::new(&world(guess), &plan(), &unknowns()).unwrap();
    let identification = identification.with_noise(noise()).with_loss(loss).unwrap();
    let fit = identification.fit(measurements).unwrap();
    let ratios = fit.values().into_iter().zip(TRUTH);
    ratios
        .map(|(value, truth)| (value / truth).ln().abs())
        .fold(0.0, f64::max)
}

/// Returns the recordings with one state in ten at a wrong position.
fn with_outliers(measurements: &[Measurement]) -> Vec<Measurement> {
    let disturbed = |measurement: &Measurement| {
        let mut states = measurement.trajectory().states().to_vec();
        for state in states.iter_mut().skip(5).step_by(10) {
            let pose = &mut state.bodies[0].pose;
            *pose = Pose::from_translation(vector![0.05, 0.0, 0.03]) * *pose;
        }
        Measurement::new(measurement.name(), Trajectory::new(states).unwrap())
    };
    measurements.iter().map(disturbed).collect()
}

#[test]
fn robust_losses_suppress_outliers() {
    let measurements = with_outliers(&clean(3));
    let squared = error(RobustLoss::Squared, &measurements);
    let huber = error(RobustLoss::Huber(3.0), &measurements);
    let cauchy = error(RobustLoss::Cauchy(3.0), &measurements);
    assert!(squared > 0.1, "{squared}");
    assert!(huber < 0.3 * squared, "{huber} beside {squared}");
    assert!(cauchy < 0.03 * squared, "{cauchy} beside {squared}");
}

#[test]
fn measurements_that_cannot_be_simulated_are_reported() {
    let mut measurements = clean(2);
    let mut states = measurements[1].trajectory().states().to_vec();
    let pose = &mut states[0].bodies[0].pose;
    *pose = pose.with_translation(vector![0.0, 0.0, -1.0]);
    measurements.insert(
        1,
        Measurement::new("below", Trajectory::new(states).unwrap()),
    );
    let guess = TRUTH.map(|value| 1.2 * value);
    let identification = Identification::new(&world(guess), &plan(), &unknowns()).unwrap();
    let fit = identification.fit(&measurements).unwrap();
    let errors = fit
        .measurements
        .iter()
        .map(|measurement| measurement.error.is_some());
    assert_eq!(errors.collect::<Vec<_>>(), [false, true, false]);
    for (value, truth) in fit.values().into_iter().zip(TRUTH) {
        assert!((value / truth - 1.0).abs() < CLEAN);
    }
}
