use super::{Experiment, GradientError, JointQuantity, Outcome, Parameter};
use crate::dynamics::{BodyState, Joint, JointState, Model, State, TangentPart, Trajectory};
use crate::scalar::Scalar;
use crate::spatial::turn_from_real;
use nalgebra::DMatrix;
use std::sync::{Arc, OnceLock};

/// Linearization of the final state of a rollout: δx⁺ = A·δx + B·δu, with the initial state x and the parameters u.
///
/// Changes of states are in tangent-space coordinates, as in [`World::difference`](crate::dynamics::World::difference).
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

/// Final state in tangent-space coordinates about itself. Rotation vectors are zero, and only their derivatives are used.
struct FinalTangent {
    parts: Vec<TangentPart>,
    /// Final state without derivatives, set by the first evaluation.
    end: OnceLock<State>,
}

impl Outcome for FinalTangent {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let end = trajectory.last();
        self.end.get_or_init(|| end.real());
        let parts = self.parts.iter();
        parts
            .flat_map(|part| match part.joint {
                Some(joint) => joint_numbers(&end.joints[joint]),
                None => body_numbers(&end.bodies[part.body]),
            })
            .collect()
    }
}

fn body_numbers<T: Scalar>(BodyState { pose, twist }: &BodyState<T>) -> Vec<T> {
    let turn = turn_from_real(pose.rotation());
    let pose = turn.iter().chain(pose.translation());
    pose.chain(&twist.to_vector()).copied().collect()
}

fn joint_numbers<T: Scalar>(state: &JointState<T>) -> Vec<T> {
    match state {
        JointState::Scalar { position, velocity } => vec![*position, *velocity],
        JointState::Ball {
            rotation,
            angular_velocity,
        } => {
            let turn = turn_from_real(rotation);
            turn.iter().chain(angular_velocity).copied().collect()
        }
    }
}

/// Parameters for the initial values of the tangent-space coordinates of a part.
fn initial_values(part: TangentPart, model: &Model) -> Vec<Parameter> {
    use JointQuantity::{
        InitialAngularVelocity, InitialOrientation, InitialPosition, InitialVelocity,
    };
    let body = &model.bodies[part.body];
    if part.joint.is_none() {
        let name: Arc<str> = body.name().into();
        return vec![
            Parameter::InitialOrientation(Arc::clone(&name)),
            Parameter::InitialPosition(Arc::clone(&name)),
            Parameter::InitialAngularVelocity(Arc::clone(&name)),
            Parameter::InitialVelocity(name),
        ];
    }
    let joint: Arc<str> = body.joint().map_or("", Joint::name).into();
    let quantities = if part.dimension == 2 {
        [InitialPosition, InitialVelocity]
    } else {
        [InitialOrientation, InitialAngularVelocity]
    };
    let parameters = quantities.map(|quantity| Parameter::Joint(Arc::clone(&joint), quantity));
    parameters.into()
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
    /// As [`Self::jacobian`]. If derivatives are not finite, the error holds A and B beside each other, as the Jacobian of an outcome.
    pub fn linearize(&self, parameters: &[Parameter]) -> Result<LinearizedRollout, GradientError> {
        let model = self.model();
        let outcome = FinalTangent {
            parts: model.tangent_parts().collect(),
            end: OnceLock::new(),
        };
        let parts = outcome.parts.iter();
        let initial_values = parts.flat_map(|part| initial_values(*part, model));
        let all: Vec<_> = initial_values.chain(parameters.iter().cloned()).collect();
        let jacobian = self.jacobian(&all, &outcome)?.jacobian;
        let (size, count) = jacobian.shape();
        Ok(LinearizedRollout {
            by_state: jacobian.columns(0, size).into_owned(),
            by_parameters: jacobian.columns(size, count - size).into_owned(),
            end: match outcome.end.into_inner() {
                Some(end) => end,
                None => self.trajectory()?.last().clone(),
            },
        })
    }
}
