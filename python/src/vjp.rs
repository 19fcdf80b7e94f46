//! Vector–Jacobian products of rollouts.

use crate::arrays::{Floats, array};
use crate::errors::gradient_error;
use crate::interrupt::{Shared, run};
use crate::state_cotangents::StateCotangents;
use hydroelastic::{dynamics, gradient};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Vector–Jacobian product of a rollout with respect to parameters: see World.vjp.
///
/// It keeps the recorded steps of the rollout, so that several losses of one rollout cost one rollout and one sweep back each.
#[pyclass(frozen, module = "hydroelastic")]
pub struct VectorJacobianProduct {
    inner: gradient::VectorJacobianProduct,
    plan: dynamics::Plan,
}

impl VectorJacobianProduct {
    /// Wraps the product of a rollout with a plan.
    pub fn new(inner: gradient::VectorJacobianProduct, plan: dynamics::Plan) -> Self {
        Self { inner, plan }
    }
}

#[pymethods]
impl VectorJacobianProduct {
    /// Computes the gradient of a loss with respect to the parameters from its gradient with respect to the recorded states.
    ///
    /// The result is np.tensordot(by_poses, jacobian.poses, 4) + np.tensordot(by_twists, jacobian.twists, 3), plus the same products
    /// for joints. A sweep back from the last state computes it in a time that does not depend on p.
    ///
    /// Derivatives with respect to a rotation matrix have an effect only in the directions of rotations. Derivatives with respect to
    /// kinematic bodies have no effect.
    ///
    /// Parameters
    /// ----------
    /// by_poses : (k, n, 4, 4) array_like
    ///     Derivatives of the loss with respect to the poses of the recorded states.
    /// by_twists : (k, n, 6) array_like
    ///     Derivatives of the loss with respect to the twists of the recorded states.
    /// by_joint_positions, by_joint_velocities : (k, m) array_like, optional
    ///     Derivatives with respect to the positions and velocities of the revolute and prismatic joints. Default: zero.
    /// by_ball_joint_rotations : (k, b, 3, 3) array_like, optional
    ///     Derivatives with respect to the rotations of the ball joints. Default: zero.
    /// by_ball_joint_velocities : (k, b, 3) array_like, optional
    ///     Derivatives with respect to the angular velocities of the ball joints. Default: zero.
    ///
    /// Returns
    /// -------
    /// (p,) ndarray of float64
    ///     Gradient of the loss.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an array has an unexpected shape, or a derivative is not finite.
    #[pyo3(signature = (by_poses, by_twists, *, by_joint_positions=None, by_joint_velocities=None,
                        by_ball_joint_rotations=None, by_ball_joint_velocities=None))]
    fn __call__<'py>(
        &self,
        py: Python<'py>,
        by_poses: &Bound<'py, PyAny>,
        by_twists: &Bound<'py, PyAny>,
        by_joint_positions: Option<&Bound<'py, PyAny>>,
        by_joint_velocities: Option<&Bound<'py, PyAny>>,
        by_ball_joint_rotations: Option<&Bound<'py, PyAny>>,
        by_ball_joint_velocities: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Floats<'py>> {
        let arrays = [
            Some(by_poses),
            Some(by_twists),
            by_joint_positions,
            by_joint_velocities,
            by_ball_joint_rotations,
            by_ball_joint_velocities,
        ];
        let last = self.inner.trajectory().last();
        let cotangents = StateCotangents::of(arrays, &self.plan, last, None)?;
        // Each call has its own flag, because several threads can call at the same time.
        let shared = Shared::default();
        let result = run(py, &shared, None, || {
            let by_states = cotangents.covectors(0, self.inner.trajectory());
            let product = self.inner.clone();
            let product = product.with_cancel_flag(Arc::clone(&shared.stop));
            product.pull_back(&by_states)
        })?;
        let result = result.map_err(|why| gradient_error(&why))?;
        array(py, result.as_slice().to_vec(), &[result.len()])
    }

    #[allow(clippy::unused_self, reason = "a method, to pickle")]
    fn __reduce__(&self) -> PyResult<()> {
        Err(PyTypeError::new_err(
            "a VectorJacobianProduct cannot be pickled or copied: it holds the steps of its rollout. World.vjp makes another one",
        ))
    }
}
