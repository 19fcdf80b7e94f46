use super::coordinates::Coordinates;
use super::deviations::Deviations;
use super::equations::{Equations, QuadraticModel};
use super::{Identification, IdentificationError, Measurement};
use crate::dynamics::State;
use crate::gradient::{Experiment, GradientError};
use nalgebra::DVector;

/// Largest distance of a measured time from a multiple of the time step, relative to the time step.
const TIME_TOLERANCE: f64 = 1e-3;

/// Beginning of a measurement: a rollout from its first state, and the measured states.
pub(super) struct Trial<'a> {
    problem: &'a Identification,
    measurement: &'a Measurement,
    experiment: Experiment,
    deviations: Deviations<'a>,
}

/// Coordinates of the unknowns and of the nuisances of one measurement.
pub(super) type Point<'a> = [&'a DVector<f64>; 2];

impl<'a> Trial<'a> {
    /// Beginning of a measurement with a duration (s), and at least one state after the first.
    ///
    /// # Errors
    /// If the measurement does not fit the world or the time steps of the plan.
    pub fn new(
        problem: &'a Identification,
        measurement: &'a Measurement,
        duration: f64,
    ) -> Result<Self, IdentificationError> {
        let plan = problem.template.plan();
        let states = steps_of(measurement, plan.time_step())?;
        let start = states[0].1.time;
        let is_used = |&(_, state): &(usize, &State)| state.time - start <= duration;
        let count = states.iter().take_while(|state| is_used(state)).count();
        let used = &states[1..count.max(2)];
        let steps = used.last().map_or(0, |(step, _)| *step);
        let experiment = problem.template.starting_from(states[0].1)?;
        problem.check_poses(measurement)?;
        Ok(Self {
            problem,
            measurement,
            experiment: experiment.with_plan(plan.with_steps(steps).recording_every(1)),
            deviations: Deviations {
                states: used.to_vec(),
                bodies: &problem.observed,
                noise: problem.noise,
            },
        })
    }

    /// Coordinates of the unknowns and of the nuisances.
    fn coordinates(&self) -> [&Coordinates; 2] {
        [&self.problem.unknowns, &self.problem.nuisances]
    }

    /// The whole measurement.
    pub fn measurement(&self) -> &'a Measurement {
        self.measurement
    }

    /// Numbers of time steps from the first state to all states, beginning with the first.
    pub fn steps(&self) -> impl Iterator<Item = usize> {
        let later = self.deviations.states.iter();
        std::iter::once(0).chain(later.map(|(step, _)| *step))
    }

    /// The experiment at a point.
    pub fn at(&self, point: Point) -> Result<Experiment, GradientError> {
        let mut experiment = self.experiment.clone();
        for (coordinates, at) in self.coordinates().into_iter().zip(point) {
            let changes = coordinates.changes(at);
            experiment = experiment.perturbed(&coordinates.parameters, &changes)?;
        }
        Ok(experiment)
    }

    /// Cost at a point, with the priors of the nuisances.
    pub fn cost(&self, point: Point) -> Result<f64, GradientError> {
        let deviations = self.at(point)?.value(&self.deviations)?;
        let losses = self.problem.loss.of_poses(&deviations);
        let cost: f64 = losses.map(|[loss, _]| 0.5 * loss).sum();
        let nuisances = &self.problem.nuisances;
        let priors = QuadraticModel::zeros(nuisances.len()).add_priors(nuisances, point[1]);
        Ok(cost + priors)
    }

    /// Equations at a point, with the priors of the nuisances.
    pub fn equations(&self, point: Point) -> Result<Equations, GradientError> {
        let experiment = self.at(point)?;
        // Two passes with narrow dual numbers. One pass for all parameters would carry 96 derivatives.
        let [shared, local] = self
            .coordinates()
            .map(|coordinates| experiment.jacobian(&coordinates.parameters, &self.deviations));
        let (shared, local) = (shared?, local?);
        let [unknowns, nuisances] = self.coordinates();
        let mut equations = Equations::new(
            self.problem.loss,
            &shared.value,
            &(shared.jacobian * unknowns.jacobian(point[0])),
            &(local.jacobian * nuisances.jacobian(point[1])),
        );
        equations.cost += equations
            .local
            .add_priors(&self.problem.nuisances, point[1]);
        Ok(equations)
    }
}

impl Identification {
    /// Checks that the poses of the observed bodies are rigid.
    fn check_poses(&self, measurement: &Measurement) -> Result<(), IdentificationError> {
        for (state, measured) in measurement.trajectory().states().iter().enumerate() {
            for &body in &self.observed {
                let pose = measured.bodies[body].pose.checked();
                pose.map_err(|source| IdentificationError::Pose {
                    measurement: measurement.name().to_owned(),
                    state,
                    body,
                    source,
                })?;
            }
        }
        Ok(())
    }
}

/// Returns the states of a measurement, each with the number of time steps after the first state. The time step is in seconds.
fn steps_of(
    measurement: &Measurement,
    time_step: f64,
) -> Result<Vec<(usize, &State)>, IdentificationError> {
    let states = measurement.trajectory().states();
    if states.len() < 2 {
        return Err(IdentificationError::TooFewStates(
            measurement.name().to_owned(),
        ));
    }
    let steps = states.iter().enumerate().map(|(index, state)| {
        let after = state.time - states[0].time;
        let multiple = (after / time_step).round();
        if (after - multiple * time_step).abs() <= TIME_TOLERANCE * time_step {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a whole number that is not negative, because states are in the order of time"
            )]
            return Ok((multiple as usize, state));
        }
        Err(IdentificationError::OffGrid {
            measurement: measurement.name().to_owned(),
            state: index,
            after,
            time_step,
        })
    });
    steps.collect()
}
