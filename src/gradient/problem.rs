use super::{Experiment, GradientError, Outcome, OutcomeJacobian, Parameter};
use nalgebra::DVector;

/// An outcome as a function of the values of parameters, for optimizers and for solvers of least squares.
///
/// With the feature `argmin`, a problem implements the traits of the crate argmin: `CostFunction` and `Gradient` for losses, and
/// `Operator` and `Jacobian` for residuals. Derivatives with respect to an orientation are with respect to a small rotation, not to
/// its value (see [`World::with_values`](crate::dynamics::World::with_values)), so orientations do not suit these solvers. A value out of range, or a rollout that ends early, is an error, which ends a solver of
/// argmin.
///
/// ```
/// # use hydroelastic::contact::Shape;
/// # use hydroelastic::dynamics::{Body, Mass, Material, Plan, Trajectory, World};
/// # use hydroelastic::gradient::{Experiment, Outcome, Parameter};
/// # use hydroelastic::mesh::shapes;
/// # use hydroelastic::scalar::Scalar;
/// /// Half the squared distance (m²) of the ball from x = 3 m at the end.
/// struct Miss;
///
/// impl Outcome for Miss {
///     fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
///         let away = trajectory.last().bodies[0].position().x - 3.0;
///         vec![away * away * 0.5]
///     }
/// }
/// # let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// # let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(1.0))?;
/// # let world = World::new(vec![ball])?;
/// let experiment = Experiment::new(&world, &Plan::new(1e-3, 500)?);
/// let problem = experiment.problem(&[Parameter::initial_velocity("ball")], Miss)?;
/// let mut velocity = problem.initial_values().clone();
/// for _ in 0..2 {
///     let (_, gradient) = problem.gradient(velocity.as_slice())?;
///     velocity -= gradient * 4.0; // 0.5 s of flight: Newton's step is the gradient over 0.25 s²
/// }
/// assert!((velocity[0] - 6.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Problem<O> {
    experiment: Experiment,
    parameters: Vec<Parameter>,
    outcome: O,
    initial_values: DVector<f64>,
}

impl Experiment {
    /// The outcome as a function of the values of parameters.
    ///
    /// # Errors
    /// If the world does not have one of the parameters.
    pub fn problem<O: Outcome>(
        &self,
        parameters: &[Parameter],
        outcome: O,
    ) -> Result<Problem<O>, GradientError> {
        Ok(Problem {
            experiment: self.clone(),
            parameters: parameters.to_vec(),
            outcome,
            initial_values: self.values(parameters)?,
        })
    }
}

impl<O: Outcome> Problem<O> {
    /// Values of the parameters in the world of the experiment, in the order of
    /// [`World::values`](crate::dynamics::World::values).
    #[must_use]
    pub fn initial_values(&self) -> &DVector<f64> {
        &self.initial_values
    }

    /// The outcome at values of the parameters.
    ///
    /// # Errors
    /// As [`Experiment::value_at`].
    pub fn value(&self, values: &[f64]) -> Result<Vec<f64>, GradientError> {
        self.experiment
            .value_at(&self.parameters, values, &self.outcome)
    }

    /// A loss and its gradient at values of the parameters.
    ///
    /// # Errors
    /// As [`Experiment::at`] and [`Experiment::gradient`].
    pub fn gradient(&self, values: &[f64]) -> Result<(f64, DVector<f64>), GradientError> {
        let experiment = self.experiment.at(&self.parameters, values)?;
        experiment.gradient(&self.parameters, &self.outcome)
    }

    /// The outcome and its Jacobian at values of the parameters.
    ///
    /// # Errors
    /// As [`Experiment::at`] and [`Experiment::jacobian`].
    pub fn jacobian(&self, values: &[f64]) -> Result<OutcomeJacobian, GradientError> {
        let experiment = self.experiment.at(&self.parameters, values)?;
        experiment.jacobian(&self.parameters, &self.outcome)
    }
}
