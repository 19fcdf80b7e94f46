//! Which modulus, dissipation and friction explain recorded tosses of a cube onto a table, and how well do they predict other tosses?
//!
//! `cargo run --release -p hydroelastic-examples --example cube_tosses [-- --data FOLDER --fit 100 --held-out 100 --plot FILE.svg]`
//!
//! The folder contains the file `cube_tosses.csv`, whose source is in `docs/measured_motions.md`. Without a folder, the tosses are
//! simulated with noise, and the estimates are compared with the true values. Each toss is divided into windows of 25 frames, because
//! motions through several impacts are too sensitive to their initial state. The plot shows the quartiles of the errors along the windows
//! of the fit, and along predictions of fitted and of held-out tosses.

mod quartiles;
#[path = "../show/mod.rs"]
mod show;
mod tosses;

use hydroelastic::dynamics::{Accuracy, Integrator, Plan};
use hydroelastic::gradient::Parameter;
use hydroelastic::identification::{
    Fit, Identification, IdentificationError, Measurement, Noise, Nuisance, Prediction, RobustLoss,
    StartingState, Unknown,
};
use hydroelastic::parallel;
use quartiles::panel;
use show::{Panel, Wanted};
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

/// True values of simulated tosses: modulus (Pa), dissipation (s/m), friction and height (m) of the table.
const TRUTH: [f64; 4] = [1e6, 5.0, 0.2, -0.001];
/// First guess of the same values.
const GUESS: [f64; 4] = [3e5, 8.0, 0.3, 0.0];
/// Number of states of a window.
const WINDOW_STATE_COUNT: usize = 25;
/// Duration (s) of the flight to which initial states of predictions are fitted.
const FLIGHT: f64 = 0.1;
/// Errors of the pressure field as a model of a hard cube: position (m) and rotation (rad).
const MODEL_ERROR: [f64; 2] = [2e-3, 0.03];

fn main() -> Result<(), Box<dyn Error>> {
    let option = |name: &str| {
        std::env::args()
            .skip_while(|argument| argument != name)
            .nth(1)
    };
    let count = |name, default| option(name).map_or(Ok(default), |count| count.parse::<usize>());
    let (fitted, held_out) = (count("--fit", 2)?, count("--held-out", 1)?);
    let plan = Plan::new(1.0 / tosses::RATE, 60)?.with_integrator(Integrator::Sdirk3);
    let plan = plan.with_accuracy(Accuracy::new(3e-3, 3e-2)?);
    let template = tosses::world(GUESS)?;
    let folder = option("--data");
    let all = match &folder {
        Some(folder) => tosses::read(&Path::new(folder).join("cube_tosses.csv"), &template)?,
        None => tosses::simulated(&tosses::world(TRUTH)?, &plan, fitted + held_out)?,
    };
    let (training, rest) = all.split_at_checked(fitted).ok_or("too few tosses")?;
    let identification = Identification::new(&template, &plan, &unknowns())?
        .with_nuisances(&nuisances())?
        .with_noise(Noise::new(MODEL_ERROR[0], MODEL_ERROR[1])?)
        .with_loss(RobustLoss::Cauchy(4.0))?
        .with_max_iterations(if folder.is_some() { 15 } else { 30 })
        .with_progress(|iteration| {
            println!(
                "{}: cost {:.2}, {:.5?}",
                iteration.index, iteration.cost, iteration.values
            );
            ControlFlow::Continue(())
        });
    let windows: Vec<Measurement> = training
        .iter()
        .flat_map(|toss| toss.windows(WINDOW_STATE_COUNT))
        .collect();
    let fit = identification.fit(&windows)?;
    print_fit(&fit);
    let held_out = &rest[rest.len() - held_out..];
    for start in [StartingState::Measured, StartingState::Fitted(FLIGHT)] {
        println!("{} predictions, {start:?}:", held_out.len());
        print_errors(&predictions(&identification, &fit, held_out, start)?);
    }
    let wanted = Wanted::only_plot(option("--plot").map(Into::into));
    if wanted.has_plot() {
        let panels = panels(&identification, &fit, &windows, [training, held_out])?;
        wanted.plot(|| panels)?;
    }
    if folder.is_none() {
        for (estimate, truth) in fit.estimates.iter().zip(TRUTH) {
            let [lower, upper] = estimate.interval;
            assert!(
                lower < truth && truth < upper,
                "{estimate} instead of {truth}"
            );
        }
    }
    Ok(())
}

/// Returns the unknowns that all tosses share. Gravity is an unknown, because measured accelerations in flight differ from 9.81 m/s². The
/// mean of the prior of the radius of gyration follows from the published moments of inertia.
fn unknowns() -> [Unknown; 6] {
    [
        Unknown::new(Parameter::modulus("cube")).logarithmic(),
        Unknown::new(Parameter::dissipation("cube")).logarithmic(),
        Unknown::new(Parameter::friction("cube")).logarithmic(),
        Unknown::new(Parameter::initial_position("table"))
            .component(2)
            .named("height of the table"),
        Unknown::new(Parameter::Gravity)
            .component(2)
            .named("gravity")
            .with_prior(-9.81, 0.1),
        Unknown::new(Parameter::radius_of_gyration("cube"))
            .logarithmic()
            .with_prior((tosses::MOMENT / tosses::MASS).sqrt(), 0.05),
    ]
}

/// Returns the errors of the first state of each window.
fn nuisances() -> [Nuisance; 4] {
    let [position, rotation, velocity, angular] = tosses::NOISE;
    [
        Nuisance::new(Parameter::initial_position("cube"), position),
        Nuisance::new(Parameter::initial_orientation("cube"), rotation),
        Nuisance::new(Parameter::initial_velocity("cube"), velocity),
        Nuisance::new(Parameter::initial_angular_velocity("cube"), angular),
    ]
}

fn print_fit(fit: &Fit) {
    println!("{:?} after {} iterations", fit.termination, fit.iterations);
    for estimate in &fit.estimates {
        println!(
            "{estimate}, sandwich interval {:.4?}",
            estimate.sandwich_interval
        );
    }
    fit.directions
        .iter()
        .for_each(|direction| println!("{direction}"));
}

/// Returns predictions of tosses with the values of a fit.
fn predictions(
    identification: &Identification,
    fit: &Fit,
    tosses: &[Measurement],
    start: StartingState,
) -> Result<Vec<Prediction>, IdentificationError> {
    let values = fit.values();
    let predict = |toss: &Measurement| identification.predict(&values, toss, start);
    parallel::map(tosses, predict).into_iter().collect()
}

/// Returns panels of the errors in the windows of a fit, and of predictions of fitted and held-out tosses.
fn panels(
    identification: &Identification,
    fit: &Fit,
    windows: &[Measurement],
    tosses: [&[Measurement]; 2],
) -> Result<Vec<Panel>, Box<dyn Error>> {
    let residuals = identification.residuals(windows, &fit.checkpoint)?;
    let residuals = residuals
        .iter()
        .flatten()
        .map(|window| &window.normalized_errors);
    let mut panels = vec![panel("windows: error / noise", residuals, 1.0)];
    let names = ["fitted: position (%)", "held out: position (%)"];
    for (name, tosses) in names.into_iter().zip(tosses) {
        let start = StartingState::Fitted(FLIGHT);
        let predictions = predictions(identification, fit, tosses, start)?;
        let errors = predictions.iter().map(|toss| &toss.position_errors);
        panels.push(panel(name, errors, 100.0 / tosses::EDGE));
    }
    Ok(panels)
}

/// Prints the median and the mean over tosses of three errors of predictions: mean position, last position and mean rotation.
fn print_errors(predictions: &[Prediction]) {
    let mut errors = [Vec::new(), Vec::new(), Vec::new()];
    for prediction in predictions {
        let mean = |errors: &[Vec<f64>]| errors.iter().flatten().sum::<f64>() / errors.len() as f64;
        let last = prediction.position_errors.iter().flatten().last();
        errors[0].push(100.0 * mean(&prediction.position_errors) / tosses::EDGE);
        errors[1].push(100.0 * last.unwrap_or(&f64::NAN) / tosses::EDGE);
        errors[2].push(mean(&prediction.rotation_errors).to_degrees());
    }
    let names = [
        "position (% of the edge)",
        "last position (% of the edge)",
        "rotation (°)",
    ];
    for (name, mut errors) in names.into_iter().zip(errors) {
        errors.sort_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        println!(
            "  {name}: median {:.1}, mean {mean:.1}",
            errors[errors.len() / 2]
        );
    }
}
