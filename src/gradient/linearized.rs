use super::outcome::numbers;
use super::{Experiment, GradientError, Outcome, OutcomeJacobian, Parameter};
use crate::dynamics::{BodyState, STATE_DIM, State, Trajectory};
use crate::scalar::{Scalar, lift};
use crate::spatial::{Pose, Twist};
use nalgebra::{DMatrix, Matrix3, Vector3};
use std::sync::Arc;

/// Linearization of the final state of a rollout: δx⁺ = A·δx + B·δu, with the initial state x and the parameters u.
///
/// Changes of states are in tangent-space coordinates, 12 numbers for each dynamic body, as in
/// [`World::difference`](crate::dynamics::World::difference).
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LinearizedRollout {
    /// Final state x⁺.
    pub end: State,
    /// A: derivatives of the final state with respect to the initial state.
    pub by_state: DMatrix<f64>,
    /// B: derivatives of the final state with respect to the parameters.
    pub by_parameters: DMatrix<f64>,
}

/// Numbers of the state of a body in an outcome: position, columns of the rotation matrix, velocity, angular velocity.
const NUMBERS: usize = 18;

/// Outcome: the final states of all bodies, then their time.
struct FinalStates;

impl Outcome for FinalStates {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let end = trajectory.last();
        let states = (0..end.bodies.len()).flat_map(|body| numbers(end, body));
        states.chain([lift(end.time)]).collect()
    }
}

/// The state whose numbers are a value of [`FinalStates`].
fn state_of(values: &[f64]) -> State {
    let (bodies, time) = values.split_at(values.len() - 1);
    let body = |numbers: &[f64]| BodyState {
        pose: Pose::from_parts(
            Matrix3::from_column_slice(&numbers[3..12]),
            Vector3::from_column_slice(&numbers[..3]),
        ),
        twist: Twist {
            linear: Vector3::from_column_slice(&numbers[12..15]),
            angular: Vector3::from_column_slice(&numbers[15..]),
        },
    };
    State {
        time: time[0],
        bodies: bodies.chunks(NUMBERS).map(body).collect(),
        joints: Vec::new(),
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
    /// assert_eq!(linearized.end.time, 0.5);
    /// assert!((linearized.by_state[(3, 9)] - 0.5).abs() < 1e-12); // ∂x/∂(velocity along x): 0.5 s
    /// assert!((linearized.by_parameters[(9, 3)] - 0.25).abs() < 1e-12); // ∂(velocity along x)/∂(force along x): 0.5 s/2 kg
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Self::jacobian`]. If derivatives are not finite, the error holds the Jacobian of the final states of all bodies in the
    /// layout of [`FinalState`](super::FinalState), then of the time. Its columns are orientation, position, angular velocity and
    /// velocity of each dynamic body, then the parameters.
    pub fn linearize(&self, parameters: &[Parameter]) -> Result<LinearizedRollout, GradientError> {
        let model = self.model();
        if model.has_joints() {
            return Err(GradientError::JointsNotLinearized);
        }
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
        let jacobian = self.jacobian(&all, &FinalStates)?;
        let tangent = in_tangent_coordinates(&jacobian, &bodies);
        let parameter_count = tangent.ncols() - size;
        Ok(LinearizedRollout {
            end: state_of(jacobian.value.as_slice()),
            by_state: tangent.columns(0, size).into_owned(),
            by_parameters: tangent.columns(size, parameter_count).into_owned(),
        })
    }
}

/// Converts the rows of the dynamic bodies in a Jacobian of [`FinalStates`] to tangent-space coordinates.
fn in_tangent_coordinates(states: &OutcomeJacobian, dynamic: &[usize]) -> DMatrix<f64> {
    let mut tangent = DMatrix::zeros(STATE_DIM * dynamic.len(), states.jacobian.ncols());
    for (block, &body) in dynamic.iter().enumerate() {
        let values = &states.value.as_slice()[NUMBERS * body..];
        let rotation = Matrix3::from_column_slice(&values[3..12]);
        let columns = states.jacobian.column_iter();
        for (derivatives, mut column) in columns.zip(tangent.column_iter_mut()) {
            let derivatives = derivatives.rows(NUMBERS * body, NUMBERS);
            let of_rotation = Matrix3::from_iterator(derivatives.rows(3, 9).iter().copied());
            // The rotation vector of a change dR is the axial vector of the skew-symmetric matrix dR·Rᵀ.
            let skew = of_rotation * rotation.transpose();
            let axial = |i: usize, j: usize| (skew[(i, j)] - skew[(j, i)]) / 2.0;
            let angular = Vector3::new(axial(2, 1), axial(0, 2), axial(1, 0));
            let mut rows = column.rows_mut(STATE_DIM * block, STATE_DIM);
            rows.rows_mut(0, 3).copy_from(&angular);
            rows.rows_mut(3, 3).copy_from(&derivatives.rows(0, 3));
            rows.rows_mut(6, 3).copy_from(&derivatives.rows(15, 3));
            rows.rows_mut(9, 3).copy_from(&derivatives.rows(12, 3));
        }
    }
    tangent
}
