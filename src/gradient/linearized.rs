use super::outcome::numbers;
use super::{Experiment, GradientError, Outcome, OutcomeJacobian, Parameter};
use crate::dynamics::{STATE_DIM, Trajectory};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::sync::Arc;

/// Linearization of the final state of a rollout: δx⁺ = A·δx + B·δu, with the initial state x and the parameters u.
///
/// Changes of states are in tangent-space coordinates, 12 numbers for each dynamic body, as in
/// [`World::difference`](crate::dynamics::World::difference).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LinearizedRollout {
    /// A: derivatives of the final state with respect to the initial state.
    pub by_state: DMatrix<f64>,
    /// B: derivatives of the final state with respect to the parameters.
    pub by_parameters: DMatrix<f64>,
}

/// Numbers of the state of a body in an outcome: position, columns of the rotation matrix, velocity, angular velocity.
const NUMBERS: usize = 18;

/// Outcome: the final states of the bodies with these indices.
struct FinalStates(Vec<usize>);

impl Outcome for FinalStates {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let bodies = self.0.iter();
        bodies
            .flat_map(|&body| numbers(trajectory.last(), body))
            .collect()
    }
}

impl Experiment {
    /// Derivatives of the final state with respect to the initial state and to parameters, in tangent-space coordinates, over all
    /// steps of the plan.
    ///
    /// To linearize a later part of a rollout, or a single step, use a world that
    /// [starts from](crate::dynamics::World::with_initial_state) a later state.
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
    /// let linearized = Experiment::new(&world, &Plan::new(1e-2, 50)?).linearize(&[control])?;
    /// assert!((linearized.by_state[(3, 9)] - 0.5).abs() < 1e-12); // ∂x/∂(velocity along x): 0.5 s
    /// assert!((linearized.by_parameters[(9, 3)] - 0.25).abs() < 1e-12); // ∂(velocity along x)/∂(force along x): 0.5 s/2 kg
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::jacobian`]. If derivatives are not finite, the error holds the Jacobian of the final states in the layout of
    /// [`FinalState`](super::FinalState). Its columns are orientation, position, angular velocity and velocity of each dynamic body,
    /// then the parameters.
    pub fn linearize(&self, parameters: &[Parameter]) -> Result<LinearizedRollout, GradientError> {
        let model = self.model();
        let bodies: Vec<usize> = model.dynamic_bodies().collect();
        let initial_states = bodies.iter().flat_map(|&body| {
            let name: Arc<str> = model.bodies[body].name().into();
            [
                Parameter::InitialOrientation(Arc::clone(&name)),
                Parameter::InitialPosition(Arc::clone(&name)),
                Parameter::InitialAngularVelocity(Arc::clone(&name)),
                Parameter::InitialVelocity(name),
            ]
        });
        let all: Vec<_> = initial_states.chain(parameters.iter().cloned()).collect();
        let size = STATE_DIM * bodies.len();
        let jacobian = self.jacobian(&all, &FinalStates(bodies))?;
        let tangent = in_tangent_coordinates(&jacobian, size);
        let parameter_count = tangent.ncols() - size;
        Ok(LinearizedRollout {
            by_state: tangent.columns(0, size).into_owned(),
            by_parameters: tangent.columns(size, parameter_count).into_owned(),
        })
    }
}

/// Converts the rows of a Jacobian from [`FinalStates`] to tangent-space coordinates.
fn in_tangent_coordinates(states: &OutcomeJacobian, size: usize) -> DMatrix<f64> {
    let mut tangent = DMatrix::zeros(size, states.jacobian.ncols());
    let bodies = states.value.as_slice().chunks(NUMBERS);
    for (body, values) in bodies.enumerate() {
        let rotation = Matrix3::from_column_slice(&values[3..12]);
        let columns = states.jacobian.column_iter();
        for (derivatives, mut column) in columns.zip(tangent.column_iter_mut()) {
            let derivatives = derivatives.rows(NUMBERS * body, NUMBERS);
            let of_rotation = Matrix3::from_iterator(derivatives.rows(3, 9).iter().copied());
            // The rotation vector of a change dR is the axial vector of the skew-symmetric matrix dR·Rᵀ.
            let skew = of_rotation * rotation.transpose();
            let axial = |i: usize, j: usize| (skew[(i, j)] - skew[(j, i)]) / 2.0;
            let angular = Vector3::new(axial(2, 1), axial(0, 2), axial(1, 0));
            let mut block = column.rows_mut(STATE_DIM * body, STATE_DIM);
            block.rows_mut(0, 3).copy_from(&angular);
            block.rows_mut(3, 3).copy_from(&derivatives.rows(0, 3));
            block.rows_mut(6, 3).copy_from(&derivatives.rows(15, 3));
            block.rows_mut(9, 3).copy_from(&derivatives.rows(12, 3));
        }
    }
    tangent
}
