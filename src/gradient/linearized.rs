use super::outcome::numbers;
use super::{Experiment, GradientError, Outcome, OutcomeJacobian, Parameter};
use crate::dynamics::{STATE_DIM, Trajectory};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::sync::Arc;

/// The end of a rollout to first order: x⁺ changes by A·δx + B·δu, with its start by δx and parameters by δu.
///
/// States are in local coordinates, 12 numbers for each dynamic body, as of
/// [`World::difference`](crate::dynamics::World::difference): how far the start is displaced, and how far the end is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LinearizedRollout {
    /// A: the end by the start.
    pub by_state: DMatrix<f64>,
    /// B: the end by the parameters.
    pub by_parameters: DMatrix<f64>,
}

/// Numbers of a body's state as an outcome has it: position, columns of the rotation matrix, velocity, spin.
const NUMBERS: usize = 18;

/// The last state of bodies.
struct LastStates(Vec<usize>);

impl Outcome for LastStates {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = self.0.iter();
        bodies
            .flat_map(|&body| numbers(trajectory.last(), body))
            .collect()
    }
}

impl Experiment {
    /// The last state by the initial one and by parameters, in local coordinates, over all steps of the plan. A world that
    /// [starts from](crate::dynamics::World::with_initial_state) a later state gives the rest of a rollout, or one step of it.
    ///
    /// ```
    /// # use hydroelastic::contact::Shape;
    /// # use hydroelastic::dynamics::{Body, Control, Mass, Material, Plan, World};
    /// # use hydroelastic::gradient::{Experiment, Parameter};
    /// # use hydroelastic::mesh::shapes;
    /// # use hydroelastic::spatial::Wrench;
    /// let cube = Shape::new(shapes::cuboid([0.1; 3])?);
    /// let cube = Body::dynamic("cube", cube, Material::elastic(1e5), Mass::Total(2.0))?;
    /// let world = World::new(vec![cube])?.with_control(Control::new("cube", 0.5, vec![Wrench::zero()])?)?;
    /// let control = Parameter::control("cube", 0);
    /// let found = Experiment::new(&world, &Plan::new(1e-2, 50)?).linearize(&[control])?;
    /// assert!((found.by_state[(3, 9)] - 0.5).abs() < 1e-12); // x by the velocity along x: 0.5 s
    /// assert!((found.by_parameters[(9, 3)] - 0.25).abs() < 1e-12); // that velocity by the force along x: 0.5 s/2 kg
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::jacobian`]. What was found of derivatives that are not finite is that of the bodies' last states as of
    /// [`FinalState`](super::FinalState), by orientation, position, spin and velocity of each dynamic body, then by the
    /// parameters.
    pub fn linearize(&self, parameters: &[Parameter]) -> Result<LinearizedRollout, GradientError> {
        let system = self.system();
        let bodies: Vec<usize> = system.dynamic_bodies().collect();
        let start = bodies.iter().flat_map(|&body| {
            let name: Arc<str> = system.bodies[body].name().into();
            [
                Parameter::InitialOrientation(Arc::clone(&name)),
                Parameter::InitialPosition(Arc::clone(&name)),
                Parameter::InitialAngularVelocity(Arc::clone(&name)),
                Parameter::InitialVelocity(name),
            ]
        });
        let all: Vec<_> = start.chain(parameters.iter().cloned()).collect();
        let size = STATE_DIM * bodies.len();
        let found = self.jacobian(&all, &LastStates(bodies))?;
        let local = in_local_coordinates(&found, size);
        let count = local.ncols() - size;
        Ok(LinearizedRollout {
            by_state: local.columns(0, size).into_owned(),
            by_parameters: local.columns(size, count).into_owned(),
        })
    }
}

/// Rows of local coordinates, from those of the bodies' states.
fn in_local_coordinates(found: &OutcomeJacobian, size: usize) -> DMatrix<f64> {
    let mut local = DMatrix::zeros(size, found.jacobian.ncols());
    let bodies = found.value.as_slice().chunks(NUMBERS);
    for (body, values) in bodies.enumerate() {
        let rotation = Matrix3::from_column_slice(&values[3..12]);
        for (rates, mut column) in found.jacobian.column_iter().zip(local.column_iter_mut()) {
            let rates = rates.rows(NUMBERS * body, NUMBERS);
            let turning = Matrix3::from_iterator(rates.rows(3, 9).iter().copied());
            // A rotation turns by dR·Rᵀ, which is skew.
            let spin = turning * rotation.transpose();
            let half = |i: usize, j: usize| (spin[(i, j)] - spin[(j, i)]) / 2.0;
            let angular = Vector3::new(half(2, 1), half(0, 2), half(1, 0));
            let mut own = column.rows_mut(STATE_DIM * body, STATE_DIM);
            own.rows_mut(0, 3).copy_from(&angular);
            own.rows_mut(3, 3).copy_from(&rates.rows(0, 3));
            own.rows_mut(6, 3).copy_from(&rates.rows(15, 3));
            own.rows_mut(9, 3).copy_from(&rates.rows(12, 3));
        }
    }
    local
}
