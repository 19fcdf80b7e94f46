//! Error estimates that decide whether a substep is short enough.
//!
//! The *error of values* is the difference from an embedded formula of lower order, propagated
//! through the last stage. The *error of slopes* is the error of the derivative along the motion.
//! The time derivative of the state obeys the same linearized equations as every other sensitivity.
//! The velocities and accelerations at both ends of a substep give this derivative. The linearized
//! stages propagate the rates at the start to the end. The difference between the propagated rates
//! and the rates at the end is the error of the derivative along the motion. This error serves as
//! the estimate for all derivatives.

use super::island_solver::IslandSolver;
use super::rates::{Change, ChangedBodies, RatesInTime, StartRates};
use super::report::Work;
use super::scheme::ErrorEstimate;
use super::solved_stage::SolvedStage;
use super::stage::{StageStart, Stages};
use crate::dynamics::joint::JointPosition;
use crate::scalar::lift;

/// Errors below this multiple of the solver's tolerance are always accepted, because they may be round-off.
const ROUND_OFF: f64 = 100.0;

/// Above this error of slopes, relative to the tolerance, the estimate uses exact derivatives of contacts. The solver approximates the
/// derivatives of friction and dissipation, and the approximation would count as an error.
const NEGLIGIBLE: f64 = 0.2;

/// Estimator of the errors of a solved substep.
pub(super) struct ErrorEstimator<'a> {
    pub solver: &'a IslandSolver<'a>,
    pub estimate: &'a ErrorEstimate,
    pub stages: &'a Stages<'a>,
    pub solved: Vec<SolvedStage<'a>>,
    /// Rates at the start of the substep.
    pub start_rates: &'a StartRates,
    /// Largest relative speeds (m/s) of the dynamic bodies in the step so far.
    pub speeds: &'a [f64],
    /// Time from the start of the step to the start of the substep (s).
    pub offset: f64,
    pub duration: f64,
}

impl ErrorEstimator<'_> {
    /// Errors of values and of slopes of each dynamic body, relative to its tolerances. Exact
    /// derivatives of contacts are used if the approximate error of slopes is not negligible.
    pub fn errors(&mut self, work: &mut Work) -> Vec<[f64; 2]> {
        let start_rates = self.start_rates;
        let bodies = &start_rates.bodies;
        let control = &self.solver.control;
        let values = self.relative(self.errors_of_values(bodies), |index, speed| {
            control.velocity(index, speed)
        });
        let of_slopes = |estimator: &Self| {
            let errors = estimator.errors_of_slopes(start_rates);
            estimator.relative(errors, |index, speed| control.slope(index, speed))
        };
        let mut slopes = of_slopes(self);
        if slopes.iter().any(|&error| error > NEGLIGIBLE) {
            let stages = self.solved.iter_mut();
            let mut count = 0;
            for stage in stages.filter(|stage| !stage.root.linearization.is_exact) {
                stage.linearize();
                count += 1;
            }
            work.linearizations += count;
            if count > 0 {
                slopes = of_slopes(self);
            }
        }
        let both = values.into_iter().zip(slopes);
        both.map(|(value, slope)| [value, slope]).collect()
    }

    /// Errors (m/s) of the bodies, relative to their tolerances, or infinity if a stage is
    /// singular.
    fn relative(
        &self,
        errors: Option<Vec<f64>>,
        tolerance: impl Fn(usize, f64) -> f64,
    ) -> Vec<f64> {
        let Some(errors) = errors else {
            return vec![f64::INFINITY; self.speeds.len()];
        };
        let relative = |(index, error): (usize, f64)| {
            let allowed =
                tolerance(index, self.speeds[index]) + ROUND_OFF * self.velocity_tolerance();
            // An error of 0 counts as 0, even if 0 is allowed. NaN becomes infinite, because `max`
            // ignores NaN.
            match error / allowed {
                _ if error == 0.0 => 0.0,
                relative if relative.is_nan() => f64::INFINITY,
                relative => relative,
            }
        };
        errors.into_iter().enumerate().map(relative).collect()
    }

    /// Error bound (m/s) of the velocities of the last stage.
    fn velocity_tolerance(&self) -> f64 {
        self.solved.last().map_or(0.0, |stage| stage.root.tolerance)
    }

    /// Error of the velocity (m/s) of each dynamic body, or of its displacement over the duration
    /// if that is larger. `None` if a stage is singular.
    fn errors_of_values(&self, bodies: &ChangedBodies) -> Option<Vec<f64>> {
        let last = self.solved.last()?;
        let start = self.start_with_difference(last, bodies);
        let still = RatesInTime::zero(last.equations.multibody);
        let end = last.response(bodies, &start, &still)?;
        let links = bodies.multibody.links.iter().zip(bodies.changes(&end));
        let errors = links.map(|(link, change)| {
            let shift = link.inertia.real().speed(&change.displacement) / self.duration;
            link.inertia.real().speed(&change.velocities).max(shift)
        });
        Some(errors.collect())
    }

    /// Start of the last stage. Its derivative part is the difference from the embedded formula.
    fn start_with_difference(
        &self,
        last: &SolvedStage,
        bodies: &ChangedBodies,
    ) -> StageStart<Change> {
        let start = &last.equations.start;
        let width = start.momenta.len();
        let rates = self.stages.rates();
        let velocities = rates.iter().map(|rates| &rates.velocities);
        let momenta = rates.iter().map(|rates| &rates.momenta);
        let displacement = self.estimate.of(width, velocities, self.duration);
        let impulse = self.estimate.of(width, momenta, self.duration);
        let positions: Vec<_> = start.positions.iter().map(JointPosition::lifted).collect();
        let change = displacement.map(|change| Change::new(0.0, [change]));
        StageStart {
            positions: bodies.multibody.displaced(&positions, &change),
            momenta: start
                .momenta
                .zip_map(&impulse, |value, change| Change::new(value, [change])),
            closing_rates: start.closing_rates.map(lift),
            displacement: change,
            duration: start.duration,
            time: start.time,
        }
    }

    /// Error of the derivatives of each dynamic body along the motion, or `None` if a stage is
    /// singular or the step should end. It is the error of the rate of displacement (m/s), plus the
    /// error of the acceleration (m/s²) times the flight time (s).
    fn errors_of_slopes(&self, start_rates: &StartRates) -> Option<Vec<f64>> {
        let StartRates {
            bodies,
            neighbors,
            accelerations,
        } = start_rates;
        let (solver, last) = (self.solver, self.solved.last()?);
        let (step, start) = (solver.step, &solver.solved.progress.kinematics);
        let from = bodies.along(start, accelerations, neighbors);
        let mut carried = Stages::new(step, &bodies.multibody, self.offset, &from);
        let mut end = from;
        for (stage, solved) in step.scheme.stages(self.duration).zip(&self.solved) {
            if step.context.is_stopped() {
                return None;
            }
            let start = carried.start(&stage);
            end = solved.response(bodies, &start, &solved.rates_in_time())?;
            carried.push(&start, &end);
        }
        let neighbors = step.neighbor_rates(last.equations.start.time, self.duration);
        let momentum_rates = &self.stages.rates().last()?.momenta;
        let accelerations = bodies.accelerations(step, &last.end, momentum_rates, &neighbors);
        let along = bodies.along(&last.end, &accelerations, &neighbors);
        let changes = bodies.changes(&end).zip(bodies.changes(&along)).enumerate();
        let errors = changes.map(|(index, (carried, rates))| {
            let inertia = &step.multibody.links[index].inertia;
            let flight = self.solver.control.flight(self.speeds[index]);
            inertia.speed(&(carried.displacement - rates.displacement))
                + flight * inertia.speed(&(carried.velocities - rates.velocities))
        });
        Some(errors.collect())
    }
}
