//! Joints that close loops of bodies.

use crate::arrays::Floats;
use crate::errors::value_error;
use crate::joint::{axis_array, axis_of, kind_name};
use crate::pickle::{Reduced, loaded, reduced};
use crate::poses::{matrix, single_pose};
use hydroelastic::dynamics::{self, JointKind};
use pyo3::prelude::*;

/// Joint that closes a loop of bodies, such as the last joint of a four-bar linkage. It can also connect two free bodies.
///
/// A Joint gives a body its coordinates. A loop joint is a set of constraints on bodies that already have coordinates. Redundant constraints
/// are allowed: for example, all joints of a planar linkage can be revolute joints. The two bodies pass through each other. Only implicit
/// integrators support loop joints.
///
/// Create loop joints with LoopJoint.revolute, LoopJoint.prismatic, LoopJoint.ball or LoopJoint.fixed. Each of the two bodies is given by its
/// name and the pose of the joint frame in its body frame. The joint frames coincide in the initial state, up to the motion that the joint
/// allows.
///
/// Each step enforces the constraints on velocities. Position errors decay within about one time step, and stay as small as the integration
/// error of one step. If initial velocities violate the constraints, the velocities change in the first step, as in an inelastic impact.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct LoopJoint(pub dynamics::LoopJoint);

/// Name of a body and pose of the joint frame in the body frame.
type Attachment<'py> = (String, Bound<'py, PyAny>);

fn new(name: &str, kind: JointKind, attachments: [&Attachment<'_>; 2]) -> PyResult<LoopJoint> {
    let [first, second] = attachments;
    let [on_first, on_second] = [
        single_pose(&first.1, "the pose of first")?,
        single_pose(&second.1, "the pose of second")?,
    ];
    let bodies = ((first.0.as_str(), on_first), (second.0.as_str(), on_second));
    let joint = dynamics::LoopJoint::new(name, kind, bodies.0, bodies.1);
    joint.check().map_err(value_error)?;
    Ok(LoopJoint(joint))
}

#[pymethods]
impl LoopJoint {
    /// Creates a loop joint that allows rotation about an axis.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which no other joint of the world has.
    /// axis : (3,) array_like
    ///     Direction of the axis in the joint frame. Its length does not matter.
    /// first : (str, (4, 4) array_like)
    ///     Name of a body and pose of the joint frame in its body frame.
    /// second : (str, (4, 4) array_like)
    ///     Name of the other body and pose of the joint frame in its body frame. At least one of the two bodies must be dynamic.
    ///
    /// Returns
    /// -------
    /// LoopJoint
    ///     Revolute joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the axis is zero, a pose is not rigid, or a number is not finite.
    #[staticmethod]
    fn revolute(
        name: &str,
        axis: &Bound<'_, PyAny>,
        first: Attachment<'_>,
        second: Attachment<'_>,
    ) -> PyResult<Self> {
        new(name, JointKind::Revolute(axis_of(axis)?), [&first, &second])
    }

    /// Creates a loop joint that allows translation along an axis.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which no other joint of the world has.
    /// axis : (3,) array_like
    ///     Direction of the axis in the joint frame. Its length does not matter.
    /// first : (str, (4, 4) array_like)
    ///     Name of a body and pose of the joint frame in its body frame.
    /// second : (str, (4, 4) array_like)
    ///     Name of the other body and pose of the joint frame in its body frame. At least one of the two bodies must be dynamic.
    ///
    /// Returns
    /// -------
    /// LoopJoint
    ///     Prismatic joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the axis is zero, a pose is not rigid, or a number is not finite.
    #[staticmethod]
    fn prismatic(
        name: &str,
        axis: &Bound<'_, PyAny>,
        first: Attachment<'_>,
        second: Attachment<'_>,
    ) -> PyResult<Self> {
        new(
            name,
            JointKind::Prismatic(axis_of(axis)?),
            [&first, &second],
        )
    }

    /// Creates a loop joint that allows all rotations about the origin of the joint frame.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which no other joint of the world has.
    /// first : (str, (4, 4) array_like)
    ///     Name of a body and pose of the joint frame in its body frame.
    /// second : (str, (4, 4) array_like)
    ///     Name of the other body and pose of the joint frame in its body frame. At least one of the two bodies must be dynamic.
    ///
    /// Returns
    /// -------
    /// LoopJoint
    ///     Ball joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a pose is not rigid, or a number is not finite.
    #[staticmethod]
    fn ball(name: &str, first: Attachment<'_>, second: Attachment<'_>) -> PyResult<Self> {
        new(name, JointKind::Ball, [&first, &second])
    }

    /// Creates a loop joint without motion, which welds two bodies together.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which no other joint of the world has.
    /// first : (str, (4, 4) array_like)
    ///     Name of a body and pose of the joint frame in its body frame.
    /// second : (str, (4, 4) array_like)
    ///     Name of the other body and pose of the joint frame in its body frame. At least one of the two bodies must be dynamic.
    ///
    /// Returns
    /// -------
    /// LoopJoint
    ///     Fixed joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a pose is not rigid, or a number is not finite.
    #[staticmethod]
    fn fixed(name: &str, first: Attachment<'_>, second: Attachment<'_>) -> PyResult<Self> {
        new(name, JointKind::Fixed, [&first, &second])
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Kind: "revolute", "prismatic", "ball" or "fixed".
    #[getter]
    fn kind(&self) -> &'static str {
        kind_name(self.0.kind())
    }

    /// Unit vector of the axis of a revolute or prismatic joint in the joint frame, (3,) float64; None for other joints.
    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        axis_array(py, self.0.kind())
    }

    /// Names of the two bodies.
    #[getter]
    fn bodies(&self) -> (&str, &str) {
        self.0.bodies().into()
    }

    /// Pose of the joint frame in the body frame of each body, two (4, 4) float64.
    #[getter]
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let [first, second] = self.0.frames();
        Ok((matrix(py, first)?, matrix(py, second)?))
    }

    fn __repr__(&self) -> String {
        let [first, second] = self.0.bodies();
        let (kind, name) = (self.kind(), self.name());
        format!("LoopJoint.{kind}({name:?}, between {first:?} and {second:?})")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_loop_joint", &self.0)
    }
}

/// Restores a loop joint from a pickle.
#[pyfunction]
pub fn _load_loop_joint(saved: &[u8]) -> PyResult<LoopJoint> {
    loaded(saved).map(LoopJoint)
}
