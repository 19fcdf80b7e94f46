//! Solver of one stage. Outer iterations evaluate the contacts. Inner iterations of Newton's method hold the contact polygons fixed. Inner
//! steps are [damped](super::damping). Outer steps are halved until the next correction, with the new matrix, is smaller.

use super::damping::{DampedStep, SimplifiedCorrection};
use super::evaluation::Evaluation;
use super::frozen_contact_model::PairWrenches;
use super::linearization::Linearization;
use super::matrix::Factors;
use super::report::Work;
use super::stage::StageEquations;
use crate::dynamics::rigid_motion::six;
use nalgebra::{DVector, Vector3};

/// Maximum number of outer iterations. After them, a stage counts as not solved.
const MOST_EVALUATIONS: usize = 25;

/// Maximum number of iterations on frozen polygons.
const MOST_ITERATIONS: usize = 30;

/// Shortest fraction of an outer step that is tried.
const SHORTEST_FRACTION: f64 = 1.0 / 8.0;

/// Inner iterations end when the correction is below this fraction of the first correction.
const INNER_REDUCTION: f64 = 1e-4;

/// Iterations end if the predicted next correction is below this fraction of the tolerance. The
/// prediction is the last correction times the rate of convergence.
const PREDICTED_FRACTION: f64 = 0.01;

/// If a correction is larger than this fraction of the previous correction, later evaluations use the exact derivatives of friction and
/// dissipation, which doubles their time.
const SLOW_CONVERGENCE: f64 = 0.1;

/// Upper bound of the reference size in the natural test, relative to the size of the last
/// correction. A longer inner solution is outside the region in which the frozen polygons are
/// valid.
const MOST_GROWTH: f64 = 4.0;

/// Solution of a stage.
pub(super) struct Root {
    /// Velocities, then the multipliers of loops.
    pub unknowns: DVector<f64>,
    /// Error bound of the velocities (m/s).
    pub tolerance: f64,
    /// Linearization at the last evaluation of the contacts.
    pub linearization: Linearization,
}

/// Failure to solve a stage, with the last correction. If the matrix is singular or the step was
/// stopped, the failure contains the velocities instead.
pub(super) struct Unsolved(pub DVector<f64>);

/// Evaluation of the contacts, with the step of Newton's method from the evaluated state.
struct NewtonIterate {
    evaluation: Evaluation,
    contacts: Vec<PairWrenches>,
    factors: Factors,
    step: DVector<f64>,
    size: f64,
}

impl NewtonIterate {
    /// Root with the linearization of this iterate.
    fn root(self, unknowns: DVector<f64>, tolerance: f64) -> Root {
        Root {
            unknowns,
            tolerance,
            linearization: Linearization {
                wrenches: self.evaluation.wrenches,
                contacts: self.contacts,
                forces: self.evaluation.force_jacobians,
                factors: self.factors,
                is_exact: self.evaluation.is_exact,
            },
        }
    }
}

impl StageEquations<'_> {
    /// Solves the stage for its unknowns, starting at a guess. The tolerance is relative to the current velocities.
    pub fn solve(
        &self,
        guess: &DVector<f64>,
        tolerance: f64,
        work: &mut Work,
    ) -> Result<Root, Unsolved> {
        work.solves += 1;
        let queries_before = work.looks;
        let mut iterate = self.iterate_at(guess.clone(), false, work)?;
        let mut is_exact = false;
        let momentum_speed = self.step.largest_speed_of(self.start.momenta.clone());
        let mut scale = f64::INFINITY;
        let mut rate = f64::INFINITY;
        while work.looks - queries_before < MOST_EVALUATIONS {
            // The smallest scale so far, because diverging velocities must not loosen the tolerance.
            scale = scale.min(self.scale(&iterate.evaluation, momentum_speed));
            let absolute_tolerance = tolerance * scale + self.rounding();
            let at = iterate.evaluation.end.coordinates.unknowns();
            if iterate.size <= absolute_tolerance {
                let unknowns = at + &iterate.step;
                return Ok(iterate.root(unknowns, absolute_tolerance));
            }
            let unknowns = self.solve_frozen(&iterate, 0.1 * absolute_tolerance, work);
            if iterate.size * rate <= PREDICTED_FRACTION * absolute_tolerance {
                return Ok(iterate.root(unknowns, absolute_tolerance));
            }
            let mut step = unknowns - at;
            if self.speed(&step) <= 0.0 {
                step.copy_from(&iterate.step);
            }
            let before = iterate.size;
            iterate = self.damped(&iterate, &step, is_exact, work)?;
            rate = iterate.size / before;
            is_exact |= rate > SLOW_CONVERGENCE;
        }
        Err(Unsolved(iterate.step))
    }

    /// Next iterate after a step. The step is halved until the correction decreases.
    fn damped(
        &self,
        from: &NewtonIterate,
        step: &DVector<f64>,
        is_exact: bool,
        work: &mut Work,
    ) -> Result<NewtonIterate, Unsolved> {
        let size = self.speed(step).clamp(from.size, MOST_GROWTH * from.size);
        let mut best: Option<NewtonIterate> = None;
        let mut fraction = 1.0;
        while fraction >= SHORTEST_FRACTION {
            let unknowns = from.evaluation.end.coordinates.unknowns() + step * fraction;
            if let Ok(iterate) = self.iterate_at(unknowns, is_exact, work) {
                if iterate.size <= (1.0 - fraction / 4.0) * size {
                    return Ok(iterate);
                }
                if best.as_ref().is_none_or(|best| iterate.size < best.size) {
                    best = Some(iterate);
                }
            }
            fraction *= 0.5;
        }
        // New contacts change the matrix that measures corrections. A correction that does not grow is therefore also accepted, and with
        // more contacts, one of any size.
        best.filter(|best| best.size <= from.size || best.contacts.len() > from.contacts.len())
            .ok_or_else(|| Unsolved(step.clone()))
    }

    fn iterate_at(
        &self,
        unknowns: DVector<f64>,
        is_exact: bool,
        work: &mut Work,
    ) -> Result<NewtonIterate, Unsolved> {
        if self.step.context.is_stopped() {
            return Err(Unsolved(unknowns));
        }
        let evaluation = self.evaluation(unknowns, is_exact);
        work.looks += 1;
        work.evaluations += usize::from(!evaluation.contacts.is_empty());
        work.iterations += 1;
        let contacts: Vec<_> = evaluation
            .contacts
            .iter()
            .map(|model| model.evaluated())
            .collect();
        let matrix = self.matrix(
            &evaluation.end,
            &evaluation.wrenches,
            &contacts,
            &evaluation.force_jacobians,
        );
        let factors = matrix.factorized(self.step.context.symbolic_cache);
        let step = factors.solve(-self.residual_in(&evaluation));
        let size = step.as_ref().map_or(f64::INFINITY, |step| self.speed(step));
        match step {
            Some(step) if size.is_finite() => Ok(NewtonIterate {
                evaluation,
                contacts,
                factors,
                step,
                size,
            }),
            _ => Err(Unsolved(evaluation.end.coordinates.velocities)),
        }
    }

    /// Unknowns that solve the stage with the polygons held fixed.
    fn solve_frozen(
        &self,
        iterate: &NewtonIterate,
        tolerance: f64,
        work: &mut Work,
    ) -> DVector<f64> {
        let speed = |step: &DVector<f64>| self.speed(step);
        let mut unknowns = iterate.evaluation.end.coordinates.unknowns();
        let mut damped = DampedStep::full(iterate.step.clone(), iterate.size);
        let mut new_factors = None;
        for _ in 0..MOST_ITERATIONS {
            let factors = new_factors.as_ref().unwrap_or(&iterate.factors);
            let (state, simplified) = loop {
                let ahead = &unknowns + &damped.step * damped.fraction;
                let state = self.near(&iterate.evaluation, ahead);
                let Some(step) = factors.solve(-&state.residual) else {
                    return unknowns;
                };
                let size = speed(&step);
                let simplified = SimplifiedCorrection { step, size };
                if damped.is_accepted(&simplified) {
                    unknowns = state.end.coordinates.unknowns();
                    break (state, simplified);
                }
                if !damped.shorten(&simplified, speed) {
                    return unknowns;
                }
            };
            if simplified.size <= tolerance.max(INNER_REDUCTION * iterate.size)
                || self.step.context.is_stopped()
            {
                break;
            }
            work.iterations += 1;
            let matrix = self.matrix_near(&iterate.evaluation, &state);
            let factors = matrix.factorized(self.step.context.symbolic_cache);
            let Some(step) = factors.solve(-&state.residual) else {
                break;
            };
            damped = damped.followed_by(&simplified, step, speed);
            new_factors = Some(factors);
        }
        unknowns
    }

    /// Sum of the largest speeds (m/s) that momenta, applied wrenches, other wrenches and joint forces give to a body in the stage, or the
    /// largest speed of a neighbor, or the largest speed that the spin of a body would give to a body that a loop joint connects to it.
    /// `momentum_speed` is the largest speed that the momenta give to a body.
    fn scale(&self, evaluation: &Evaluation, momentum_speed: f64) -> f64 {
        let duration = self.start.duration;
        let (multibody, end) = (self.multibody, &evaluation.end);
        let applied = (0..evaluation.wrenches.len()).map(|index| self.applied_wrench(index));
        let forces = [
            multibody.generalized_forces(end, applied),
            multibody.generalized_forces(end, &evaluation.wrenches),
            multibody.joint_forces(&end.coordinates, self.start.time),
        ];
        let impulses = forces.into_iter().map(|forces| forces * duration);
        let speeds = impulses.map(|impulse| self.step.largest_speed_of(impulse));
        let bodies = momentum_speed + speeds.sum::<f64>();
        let neighbors = self.neighbors.iter().map(|state| state.twist.linear.norm());
        let driven = self.multibody.loops.iter().flat_map(|joint| {
            let [first, second] = joint.participants;
            [(first, second), (second, first)].map(|(body, neighbor)| {
                let link = multibody.links.get(body)?;
                let spin = end.states[neighbor].twist.angular;
                Some(link.inertia.speed(&six(&spin, &Vector3::zeros())))
            })
        });
        neighbors.chain(driven.flatten()).fold(bodies, f64::max)
    }

    /// Velocity error (m/s) from the rounding of coordinates.
    fn rounding(&self) -> f64 {
        let neighbors = self.neighbors.iter().map(|state| &state.pose);
        let bodies = self
            .step
            .island
            .dynamic
            .iter()
            .map(|&body| &self.step.context.start.bodies[body].pose);
        let sizes = bodies
            .chain(neighbors)
            .map(|pose| pose.translation().amax());
        4.0 * f64::EPSILON * sizes.fold(0.0, f64::max) / self.start.duration
    }
}
