//! Derivatives of random motions with impacts and friction at the default accuracy, in steps of 5 ms, against those of the converged
//! motion.

use crate::converged::tight;
use crate::support::falling::{Scene, scene};
use crate::support::sweep::{in_batches, range_from_environment};
use crate::support::worlds::plan_of;
use hydroelastic::dynamics::{Accuracy, Integrator, Plan, Trajectory, Work};
use hydroelastic::gradient::{Experiment, Outcome, Parameter};
use hydroelastic::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// Duration of a scene (s). Every body has an impact, and most bodies have two or three.
const DURATION: f64 = 0.4;
/// Longest step (s) at the default accuracy.
const TIME_STEP: f64 = 5e-3;
/// Longest step (s) of references. It is short, because the number of substeps in a step is limited.
const REFERENCE_STEP: f64 = 2.5e-4;

/// Smallest scale of errors (m). A column is the displacement of the bodies for a reference change of a parameter: its own value (materials
/// and mass), 0.1 m, 1 m/s or 1 rad/s. The error of a column is relative to its largest entry, and at least to this length. At the default
/// accuracy, values may have errors of this size, which is about 1e-3 of the distance traveled. Smaller columns therefore say nothing about
/// the motion.
const SMALLEST_COLUMN: f64 = 1e-3;

/// Error of a scene above which the scene is counted and printed.
const OFF: f64 = 0.03;
/// Difference of references above which they have not converged.
const CONVERGED: f64 = 0.01;

/// Numbers of the scenes in the short form.
const SHORT: [u64; 12] = [4, 5, 9, 11, 18, 21, 26, 29, 31, 35, 39, 49];
/// Scenes whose references are compared with differences, and their largest difference.
const DIFFERENCED: [u64; 3] = [9, 29, 42];
const DIFFERENCES_OFF: f64 = 1e-3;

/// Final positions (m) of the first bodies.
struct FinalPositions(usize);

impl Outcome for FinalPositions {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = &trajectory.last().bodies[..self.0];
        let positions = bodies.iter().flat_map(|body| body.position().iter());
        positions.copied().collect()
    }
}

/// Returns tolerances ten times as large as [`tight()`]. The comparison shows whether the tight tolerances have converged.
fn looser_reference() -> Accuracy {
    let accuracy = Accuracy::new(1e-5, 3e-4).unwrap();
    accuracy.with_resting_speed(0.05).unwrap()
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number"
)]
fn plan(time_step: f64, accuracy: Accuracy) -> Plan {
    let steps = (DURATION / time_step).round() as usize;
    plan_of(Integrator::Sdirk3, time_step, steps)
        .with_accuracy(accuracy)
        .recording_every(steps)
}

/// Returns the parameters, each with its reference change (in its unit).
fn parameters(scene: &Scene) -> Vec<(Parameter, f64)> {
    let bodies = &scene.world.bodies()[..scene.dynamic_count];
    let of_body = bodies.iter().flat_map(|body| {
        let (name, material) = (body.name(), body.material());
        let mass = body.inertia().unwrap().mass;
        [
            (Parameter::mass(name), mass),
            (Parameter::modulus(name), material.modulus.unwrap()),
            (Parameter::friction(name), material.friction.unwrap()),
            (Parameter::dissipation(name), material.dissipation),
            (Parameter::initial_position(name), 0.1),
            (Parameter::initial_velocity(name), 1.0),
            (Parameter::initial_angular_velocity(name), 1.0),
        ]
    });
    of_body.collect()
}

/// Returns the final positions (m).
fn ends(scene: &Scene, plan: &Plan) -> DVector<f64> {
    let outcome = FinalPositions(scene.dynamic_count);
    let ends = Experiment::new(&scene.world, plan).value(&outcome).unwrap();
    DVector::from_vec(ends)
}

/// Returns the derivatives of the final positions (m), each column scaled by the reference change of its parameter.
fn jacobian(scene: &Scene, plan: &Plan) -> DMatrix<f64> {
    let (by, changes): (Vec<_>, Vec<_>) = parameters(scene).into_iter().unzip();
    let outcome = FinalPositions(scene.dynamic_count);
    let experiment = Experiment::new(&scene.world, plan);
    let mut jacobian = experiment.jacobian(&by, &outcome).unwrap().jacobian;
    let of_columns = by.iter().zip(changes);
    let of_columns = of_columns.flat_map(|(by, change)| vec![change; by.dimension()]);
    for (mut column, change) in jacobian.column_iter_mut().zip(of_columns) {
        column *= change;
    }
    jacobian
}

/// Returns the work of a rollout.
fn work(scene: &Scene, plan: &Plan) -> Work {
    let mut rollout = scene.world.rollout(plan);
    let mut work = Work::default();
    for _ in 0..plan.steps() {
        rollout.advance().unwrap();
        work += rollout.step_report().unwrap().work;
    }
    work
}

/// Returns the largest error of a column, relative to its largest entry, and the index of the column.
fn largest_error(actual: &DMatrix<f64>, expected: &DMatrix<f64>) -> (f64, usize) {
    let columns = actual.column_iter().zip(expected.column_iter());
    let errors = columns.map(|(actual, expected)| {
        (actual - expected).amax() / expected.amax().max(SMALLEST_COLUMN)
    });
    let by_error = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0);
    let errors = errors.zip(0..);
    errors.max_by(by_error).unwrap()
}

/// Returns the parameter of a column.
fn parameter_of(scene: &Scene, column: usize) -> String {
    let mut names = parameters(scene).into_iter().flat_map(|(by, _)| {
        let count = by.dimension();
        (0..count).map(move |index| format!("{by:?} {index}"))
    });
    names.nth(column).unwrap()
}

/// Errors of one scene.
struct Comparison {
    number: usize,
    error: f64,
    /// Difference of the references.
    spread: f64,
    missed: usize,
    text: String,
}

fn compared(number: usize) -> Comparison {
    let scene = scene(number as u64);
    let default = plan(TIME_STEP, Accuracy::default());
    let actual = jacobian(&scene, &default);
    let expected = jacobian(&scene, &plan(REFERENCE_STEP, tight()));
    let looser = jacobian(&scene, &plan(REFERENCE_STEP, looser_reference()));
    let (error, column) = largest_error(&actual, &expected);
    let (spread, _) = largest_error(&looser, &expected);
    let ends_off = ends(&scene, &default) - ends(&scene, &plan(REFERENCE_STEP, looser_reference()));
    let work = work(&scene, &default);
    let text = format!(
        "{number}: {:.2} % by {} ({:.1e} m for {:.1e} m), references {:.2} %, ends off by {:.0e} m, substeps {}, missed {}; {}",
        100.0 * error,
        parameter_of(&scene, column),
        actual.column(column).amax(),
        expected.column(column).amax(),
        100.0 * spread,
        ends_off.amax(),
        work.substeps,
        work.missed,
        scene.label,
    );
    println!("{text}");
    Comparison {
        number,
        error,
        spread,
        missed: work.missed,
        text,
    }
}

/// Returns the errors of the scenes whose references have converged, in ascending order.
fn sorted_errors(comparisons: &[Comparison]) -> Vec<f64> {
    let is_converged = |comparison: &&Comparison| comparison.spread <= CONVERGED;
    let (converged, unconverged_scenes): (Vec<_>, Vec<_>) =
        comparisons.iter().partition(is_converged);
    for unconverged in &unconverged_scenes {
        println!("not converged: {}", unconverged.text);
    }
    for comparison in &converged {
        if comparison.error > OFF {
            println!("off: {}", comparison.text);
        }
    }
    let missed = converged.iter().filter(|comparison| comparison.missed > 0);
    println!(
        "{} scenes, {} not converged, {} with missed substeps",
        comparisons.len(),
        unconverged_scenes.len(),
        missed.count()
    );
    let mut errors: Vec<f64> = converged.iter().map(|scene| scene.error).collect();
    errors.sort_by(f64::total_cmp);
    errors
}

/// Returns the error that a fraction of the scenes does not exceed.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small positive number"
)]
fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * (sorted.len() - 1) as f64).ceil() as usize]
}

fn print_distribution(errors: &[f64]) {
    for share in [0.5, 0.9, 0.95, 0.97, 1.0] {
        let error = 100.0 * quantile(errors, share);
        println!("{:.0} % of scenes within {error:.2} %", 100.0 * share);
    }
    let over = errors.iter().filter(|error| **error > OFF).count();
    println!("{over} of {} over {:.0} %", errors.len(), 100.0 * OFF);
}

/// The scenes have few substeps and include all shapes and all floors. Their reference is the looser one.
#[test]
fn derivatives_of_twelve_scenes() {
    let mut errors = in_batches(
        (0, SHORT.len()),
        1,
        |errors: &mut Vec<f64>, _, range| {
            for number in &SHORT[range] {
                let scene = scene(*number);
                let actual = jacobian(&scene, &plan(TIME_STEP, Accuracy::default()));
                let expected = jacobian(&scene, &plan(REFERENCE_STEP, looser_reference()));
                let (error, column) = largest_error(&actual, &expected);
                let by = parameter_of(&scene, column);
                println!("{number}: {:.2} % by {by}; {}", 100.0 * error, scene.label);
                errors.push(error);
            }
        },
        Extend::extend,
    );
    errors.sort_by(f64::total_cmp);
    print_distribution(&errors);
    assert!(quantile(&errors, 0.5) < 0.006);
    assert!(quantile(&errors, 1.0) < 0.025);
}

/// `RANDOM_SCENES_FIRST` and `RANDOM_SCENES_PAIRS` select other scenes.
#[test]
#[ignore = "300 scenes: half an hour"]
fn derivatives_of_all_scenes() {
    let (first, count) = range_from_environment("RANDOM_SCENES", (0, 300));
    let mut comparisons = in_batches(
        (first, count),
        1,
        |comparisons: &mut Vec<_>, _, numbers| comparisons.extend(numbers.map(compared)),
        Extend::extend,
    );
    comparisons.sort_by_key(|comparison| comparison.number);
    let errors = sorted_errors(&comparisons);
    print_distribution(&errors);
    // Successive impacts amplify the errors of values, and the derivative is then that of another motion.
    assert!(quantile(&errors, 0.5) < 0.012);
    assert!(quantile(&errors, 0.8) < OFF);
}

/// Returns the derivative of the final positions with respect to one component of a parameter, scaled by its reference change, from
/// fourth-order differences. The differences span a fraction of that change to either side.
fn differences(
    scene: &Scene,
    (by, change): &(Parameter, f64),
    index: usize,
    share: f64,
) -> DVector<f64> {
    let outcome = FinalPositions(scene.dynamic_count);
    let motion = Experiment::new(&scene.world, &plan(REFERENCE_STEP, tight()));
    let end = |times: f64| {
        let mut changes = vec![0.0; by.dimension()];
        changes[index] = times * share * change;
        let by = std::slice::from_ref(by);
        DVector::from_vec(motion.value_perturbed(by, &changes, &outcome).unwrap())
    };
    ((end(1.0) - end(-1.0)) * 8.0 - (end(2.0) - end(-2.0))) / (12.0 * share)
}

/// The test differentiates with respect to the last component of each parameter. Changes must be wider than the noise of values and
/// narrower than the curvature of the motion, so the better of two is used.
#[test]
#[ignore = "hundreds of converged motions: minutes"]
fn references_are_slopes_of_values() {
    for number in DIFFERENCED {
        let scene = scene(number);
        let expected = jacobian(&scene, &plan(REFERENCE_STEP, tight()));
        let mut column = 0;
        for parameter in parameters(&scene) {
            let last = parameter.0.dimension() - 1;
            let column_expected = expected.column(column + last);
            let scale = column_expected.amax().max(SMALLEST_COLUMN);
            let [narrow, wide] = [1e-3, 1e-2].map(|share| {
                let actual = differences(&scene, &parameter, last, share);
                (actual - column_expected).amax() / scale
            });
            println!(
                "{number}, {:?} {last}: off by {narrow:.1e} or {wide:.1e} of {scale:.1e} m",
                parameter.0
            );
            assert!(narrow.min(wide) < DIFFERENCES_OFF);
            column += last + 1;
        }
    }
}
