//! What a rollout is differentiated by.

use crate::arrays::{Whole, count, whole};
use crate::pickle::{Reduced, loaded, reduced};
use hydroelastic::gradient;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Something that went into a world, and that a derivative may be taken by.
#[pyclass(frozen, eq, hash, module = "hydroelastic")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Parameter(pub gradient::Parameter);

#[pymethods]
impl Parameter {
    /// Initial position (m) of a body's origin: 3 numbers.
    #[staticmethod]
    fn initial_position(body: &str) -> Self {
        Self(gradient::Parameter::initial_position(body))
    }

    /// Initial orientation of a body: 3 numbers, a rotation vector (rad) in world axes that turns it about its origin.
    #[staticmethod]
    fn initial_orientation(body: &str) -> Self {
        Self(gradient::Parameter::initial_orientation(body))
    }

    /// Initial velocity (m/s) of a body's center of mass: 3 numbers.
    #[staticmethod]
    fn initial_velocity(body: &str) -> Self {
        Self(gradient::Parameter::initial_velocity(body))
    }

    /// Initial spin (rad/s) of a body, in world axes: 3 numbers.
    #[staticmethod]
    fn initial_angular_velocity(body: &str) -> Self {
        Self(gradient::Parameter::initial_angular_velocity(body))
    }

    /// Hydroelastic modulus (Pa) of a body that is not rigid.
    #[staticmethod]
    fn modulus(body: &str) -> Self {
        Self(gradient::Parameter::modulus(body))
    }

    /// Dissipation (s/m) of a body.
    #[staticmethod]
    fn dissipation(body: &str) -> Self {
        Self(gradient::Parameter::dissipation(body))
    }

    /// Coefficient of friction of a body.
    #[staticmethod]
    fn friction(body: &str) -> Self {
        Self(gradient::Parameter::friction(body))
    }

    /// Mass (kg) of a body, which scales its inertia.
    #[staticmethod]
    fn mass(body: &str) -> Self {
        Self(gradient::Parameter::mass(body))
    }

    /// Gravity (m/s²): 3 numbers.
    #[staticmethod]
    fn gravity() -> Self {
        Self(gradient::Parameter::Gravity)
    }

    /// The wrench of an interval, counted from 0, of a body's control: 6 numbers, torque (N m), then force (N).
    #[staticmethod]
    fn control(body: &str, #[pyo3(from_py_with = whole)] interval: Whole) -> PyResult<Self> {
        let interval = count(interval, "interval")?;
        Ok(Self(gradient::Parameter::control(body, interval)))
    }

    /// The wrenches of all of so many intervals of the controls of some bodies: a list, whose numbers together are those of an array
    /// (intervals, bodies, 6).
    #[staticmethod]
    fn controls(
        bodies: Vec<String>,
        #[pyo3(from_py_with = whole)] intervals: Whole,
    ) -> PyResult<Vec<Self>> {
        let intervals = count(intervals, "intervals")?;
        let mut all = Vec::new();
        let size = intervals.saturating_mul(bodies.len());
        all.try_reserve_exact(size)
            .map_err(|_| PyMemoryError::new_err(format!("{size} parameters")))?;
        let bodies: Vec<Arc<str>> = bodies.into_iter().map(Into::into).collect();
        let of_interval = |interval| {
            let control =
                move |body: &Arc<str>| gradient::Parameter::Control(Arc::clone(body), interval);
            bodies.iter().map(control).map(Self)
        };
        all.extend((0..intervals).flat_map(of_interval));
        Ok(all)
    }

    /// A force parameter of the world, by its name: see World.
    #[staticmethod]
    fn force_parameter(name: &str) -> Self {
        Self(gradient::Parameter::force_parameter(name))
    }

    /// How many numbers it is.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    /// Name of the body that it belongs to, or None.
    #[getter]
    fn body(&self) -> Option<&str> {
        self.0.body()
    }

    fn __repr__(&self) -> String {
        use gradient::Parameter as P;
        let call = match &self.0 {
            P::InitialPosition(body) => format!("initial_position({body:?})"),
            P::InitialOrientation(body) => format!("initial_orientation({body:?})"),
            P::InitialVelocity(body) => format!("initial_velocity({body:?})"),
            P::InitialAngularVelocity(body) => format!("initial_angular_velocity({body:?})"),
            P::Modulus(body) => format!("modulus({body:?})"),
            P::Dissipation(body) => format!("dissipation({body:?})"),
            P::Friction(body) => format!("friction({body:?})"),
            P::Mass(body) => format!("mass({body:?})"),
            P::Gravity => "gravity()".to_owned(),
            P::Control(body, interval) => format!("control({body:?}, {interval})"),
            P::ForceParameter(name) => format!("force_parameter({name:?})"),
            // Other parameters have no constructor in Python.
            other => format!("{other:?}"),
        };
        format!("Parameter.{call}")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_parameter", &self.0)
    }
}

/// A parameter from what pickle has kept.
#[pyfunction]
pub fn _load_parameter(saved: &[u8]) -> PyResult<Parameter> {
    Ok(Parameter(loaded(saved)?))
}

/// The parameters of a list.
pub fn inner(parameters: &[Bound<'_, Parameter>]) -> Vec<gradient::Parameter> {
    parameters
        .iter()
        .map(|parameter| parameter.get().0.clone())
        .collect()
}
