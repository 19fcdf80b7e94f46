//! Equations of motion in generalized coordinates.

use crate::arrays::{Floats, array, finite_row, list, slice};
use crate::errors::value_error;
use crate::state::State;
use crate::world::World;
use hydroelastic::dynamics;
use hydroelastic::nalgebra::{DVector, Dim, Matrix, RawStorage, Vector3};
use hydroelastic::spatial::Wrench;
use pyo3::prelude::*;
use pyo3::types::PySlice;
use std::collections::BTreeMap;

/// Terms of the equations of motion M·u̇ + b = τ at a state: World.kinetics.
///
/// u are the n generalized velocities of all joints and free bodies, in the order of the bodies. A free body has 6: its angular velocity
/// (rad/s) and the velocity of its center of mass (m/s), in world axes. A ball joint has 3 and a revolute or prismatic joint has 1.
/// The generalized forces τ have the order of u.
///
/// A mimicking joint has its own velocity and force here. Only the forward dynamics couple it to its leader. The terms do not include the
/// forces of loop joints, and forward dynamics of a world with loop joints are an error.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Kinetics {
    inner: dynamics::Kinetics,
    names: Vec<String>,
}

#[pymethods]
impl World {
    /// Returns the terms of the equations of motion at a state.
    ///
    /// Parameters
    /// ----------
    /// state : State, optional
    ///     State of this world. Default: the initial state.
    ///
    /// Returns
    /// -------
    /// Kinetics
    ///     Terms of the equations of motion.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the state does not fit the world.
    #[pyo3(signature = (state=None))]
    fn kinetics(&self, state: Option<&State>) -> PyResult<Kinetics> {
        let initial = self.inner.initial_state();
        let state = state.map_or(&initial, |state| &state.0);
        let names = self.names_of().into_iter().map(str::to_owned);
        Ok(Kinetics {
            inner: self.inner.kinetics(state).map_err(value_error)?,
            names: names.collect(),
        })
    }
}

/// Returns terms of the equations of motion, or an error if a number is not finite.
fn finite_terms(numbers: Vec<f64>) -> PyResult<Vec<f64>> {
    if numbers.iter().all(|number| number.is_finite()) {
        return Ok(numbers);
    }
    Err(value_error(
        "a term of the equations of motion is not finite: a number of the state or of the arguments is too large",
    ))
}

/// Converts a matrix to an array.
fn array_of<'py, R: Dim, C: Dim, S: RawStorage<f64, R, C>>(
    py: Python<'py>,
    matrix: &Matrix<f64, R, C, S>,
) -> PyResult<Floats<'py>> {
    let rows = matrix.row_iter();
    let numbers = rows.flat_map(|row| row.iter().copied().collect::<Vec<f64>>());
    let numbers = finite_terms(numbers.collect())?;
    array(py, numbers, &[matrix.nrows(), matrix.ncols()])
}

fn vector_array<'py>(py: Python<'py>, vector: &DVector<f64>) -> PyResult<Floats<'py>> {
    let numbers = finite_terms(vector.as_slice().to_vec())?;
    array(py, numbers, &[vector.len()])
}

/// Reads a vector of finite numbers.
fn vector(argument: &Bound<'_, PyAny>, name: &str) -> PyResult<DVector<f64>> {
    let numbers = list(argument, name)?;
    crate::arrays::check_finite(&numbers, name)?;
    Ok(numbers.into())
}

impl Kinetics {
    fn body(&self, name: &str) -> PyResult<usize> {
        let index = self.names.iter().position(|known| known == name);
        index.ok_or_else(|| {
            value_error(format!(
                "no body is named {name:?}: the names are {:?}",
                self.names
            ))
        })
    }
}

#[pymethods]
impl Kinetics {
    /// Generalized velocities u of the state, (n,) float64.
    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, self.inner.velocities())
    }

    /// Returns the columns of the generalized velocities of a body.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// slice
    ///     Columns. They are empty for a body that is welded, fixed or kinematic.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body.
    fn columns<'py>(&self, py: Python<'py>, body: &str) -> PyResult<Bound<'py, PySlice>> {
        let columns = self.inner.columns(self.body(body)?).map_err(value_error)?;
        slice(py, &columns)
    }

    /// Mass matrix M with the armatures, (n, n) float64. Kinetic energy is ½ uᵀMu if all parents are at rest.
    #[getter]
    fn mass_matrix<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array_of(py, &self.inner.mass_matrix())
    }

    /// Bias b, (n,) float64: generalized forces that keep u constant. It has the Coriolis, centrifugal and gravity forces.
    #[getter]
    fn bias<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, &self.inner.bias())
    }

    /// Gravity part of the bias, (n,) float64: generalized forces that hold all bodies at rest.
    #[getter]
    fn gravity_bias<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, &self.inner.gravity_bias())
    }

    /// Generalized forces of the joints, (n,) float64: damping, friction, stops and actuators.
    #[getter]
    fn joint_forces<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        vector_array(py, &self.inner.joint_forces())
    }

    /// Returns the Jacobian J of the velocity of a point of a body.
    ///
    /// J·u is the angular velocity (rad/s) and the velocity of the point (m/s), in world axes.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    /// point : (3,) array_like
    ///     Point (m) in the body frame.
    ///
    /// Returns
    /// -------
    /// (6, n) ndarray of float64
    ///     Jacobian.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body, or a number is not finite.
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        body: &str,
        point: &Bound<'_, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let point = Vector3::from(finite_row::<3>(point, "point")?);
        let jacobian = self.inner.jacobian(self.body(body)?, &point);
        array_of(py, &jacobian.map_err(value_error)?)
    }

    /// Returns the bias acceleration J̇·u of a point of a body.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    /// point : (3,) array_like
    ///     Point (m) in the body frame.
    ///
    /// Returns
    /// -------
    /// (6,) ndarray of float64
    ///     Angular acceleration (rad/s²) and acceleration of the point (m/s²) in world axes, if u̇ is zero.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body, or a number is not finite.
    fn bias_acceleration<'py>(
        &self,
        py: Python<'py>,
        body: &str,
        point: &Bound<'_, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let point = Vector3::from(finite_row::<3>(point, "point")?);
        let acceleration = self.inner.bias_acceleration(self.body(body)?, &point);
        let acceleration = acceleration.map_err(value_error)?;
        let numbers = finite_terms(acceleration.as_slice().to_vec())?;
        array(py, numbers, &[6])
    }

    /// Returns the generalized forces of wrenches on bodies, such as the wrenches of contacts.
    ///
    /// Parameters
    /// ----------
    /// wrenches : dict of str to (6,) array_like
    ///     Torque (N m) about the origin of the body frame and force (N), in world axes, by the name of the body.
    ///
    /// Returns
    /// -------
    /// (n,) ndarray of float64
    ///     Generalized forces.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body, or a number is not finite.
    fn generalized_forces<'py>(
        &self,
        py: Python<'py>,
        wrenches: BTreeMap<String, Bound<'_, PyAny>>,
    ) -> PyResult<Floats<'py>> {
        let wrench = |(name, wrench): (String, Bound<'_, PyAny>)| {
            let numbers = finite_row::<6>(&wrench, "wrench")?;
            Ok((self.body(&name)?, Wrench::from_vector(&numbers.into())))
        };
        let wrenches: PyResult<Vec<_>> = wrenches.into_iter().map(wrench).collect();
        let forces = self.inner.generalized_forces(&wrenches?);
        vector_array(py, &forces.map_err(value_error)?)
    }

    /// Returns the generalized forces τ = M·u̇ + b that cause accelerations.
    ///
    /// Parameters
    /// ----------
    /// accelerations : (n,) array_like
    ///     Generalized accelerations u̇.
    ///
    /// Returns
    /// -------
    /// (n,) ndarray of float64
    ///     Generalized forces τ.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the array has another length, or a number is not finite.
    fn inverse_dynamics<'py>(
        &self,
        py: Python<'py>,
        accelerations: &Bound<'_, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let accelerations = vector(accelerations, "accelerations")?;
        let forces = self.inner.inverse_dynamics(&accelerations);
        vector_array(py, &forces.map_err(value_error)?)
    }

    /// Returns the accelerations u̇ = M⁻¹(τ − b) that forces cause. The forces of joints are not included: see joint_forces.
    ///
    /// Parameters
    /// ----------
    /// forces : (n,) array_like
    ///     Generalized forces τ.
    ///
    /// Returns
    /// -------
    /// (n,) ndarray of float64
    ///     Generalized accelerations u̇.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the array has another length, a number is not finite, a joint moves no inertia, or the world has loop joints.
    fn forward_dynamics<'py>(
        &self,
        py: Python<'py>,
        forces: &Bound<'_, PyAny>,
    ) -> PyResult<Floats<'py>> {
        let accelerations = self.inner.forward_dynamics(&vector(forces, "forces")?);
        vector_array(py, &accelerations.map_err(value_error)?)
    }

    /// Returns the derivatives of the inverse dynamics in closed form.
    ///
    /// Parameters
    /// ----------
    /// accelerations : (n,) array_like
    ///     Generalized accelerations u̇.
    ///
    /// Returns
    /// -------
    /// by_positions : (n, n) ndarray of float64
    ///     Derivative of τ with respect to displacements in the directions of the generalized velocities.
    /// by_velocities : (n, n) ndarray of float64
    ///     Derivative with respect to the generalized velocities.
    /// by_accelerations : (n, n) ndarray of float64
    ///     Derivative with respect to the generalized accelerations: the mass matrix.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the array has another length, or a number is not finite.
    fn inverse_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        accelerations: &Bound<'_, PyAny>,
    ) -> PyResult<(Floats<'py>, Floats<'py>, Floats<'py>)> {
        let accelerations = vector(accelerations, "accelerations")?;
        let derivatives = self.inner.inverse_dynamics_derivatives(&accelerations);
        let derivatives = derivatives.map_err(value_error)?;
        Ok((
            array_of(py, &derivatives.by_positions)?,
            array_of(py, &derivatives.by_velocities)?,
            array_of(py, &derivatives.by_accelerations)?,
        ))
    }

    /// Returns the derivatives of the forward dynamics in closed form.
    ///
    /// Parameters
    /// ----------
    /// forces : (n,) array_like
    ///     Generalized forces τ.
    ///
    /// Returns
    /// -------
    /// by_positions : (n, n) ndarray of float64
    ///     Derivative of u̇ with respect to displacements in the directions of the generalized velocities.
    /// by_velocities : (n, n) ndarray of float64
    ///     Derivative with respect to the generalized velocities.
    /// by_forces : (n, n) ndarray of float64
    ///     Derivative with respect to the generalized forces: the inverse of the mass matrix.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the array has another length, a number is not finite, a joint moves no inertia, or the world has loop joints.
    fn forward_dynamics_derivatives<'py>(
        &self,
        py: Python<'py>,
        forces: &Bound<'_, PyAny>,
    ) -> PyResult<(Floats<'py>, Floats<'py>, Floats<'py>)> {
        let derivatives = self
            .inner
            .forward_dynamics_derivatives(&vector(forces, "forces")?);
        let derivatives = derivatives.map_err(value_error)?;
        Ok((
            array_of(py, &derivatives.by_positions)?,
            array_of(py, &derivatives.by_velocities)?,
            array_of(py, &derivatives.by_forces)?,
        ))
    }

    fn __repr__(&self) -> String {
        format!("Kinetics({} velocities)", self.inner.velocity_count())
    }
}
