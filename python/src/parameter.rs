//! What a rollout is differentiated by.

use hydroelastic::gradient;
use pyo3::prelude::*;
use std::sync::Arc;

/// Something that went into a world, and that a derivative may be taken by.
#[pyclass(frozen, eq, hash, module = "hydroelastic")]
#[derive(Clone, PartialEq, Eq)]
pub struct Parameter(pub gradient::Parameter);

impl std::hash::Hash for Parameter {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.named().hash(state);
    }
}

impl Parameter {
    /// The name of its constructor, the body and the interval.
    fn named(&self) -> (&'static str, Option<&str>, Option<usize>) {
        use gradient::Parameter as P;
        match &self.0 {
            P::InitialPosition(body) => ("initial_position", Some(body), None),
            P::InitialOrientation(body) => ("initial_orientation", Some(body), None),
            P::InitialVelocity(body) => ("initial_velocity", Some(body), None),
            P::InitialSpin(body) => ("initial_spin", Some(body), None),
            P::Modulus(body) => ("modulus", Some(body), None),
            P::Dissipation(body) => ("dissipation", Some(body), None),
            P::Friction(body) => ("friction", Some(body), None),
            P::Mass(body) => ("mass", Some(body), None),
            P::Control(body, interval) => ("control", Some(body), Some(*interval)),
            _ => ("gravity", None, None),
        }
    }
}

#[pymethods]
impl Parameter {
    /// Initial position (m) of a body's origin: 3 numbers.
    #[staticmethod]
    fn initial_position(body: &str) -> Self {
        Self(gradient::Parameter::InitialPosition(body.into()))
    }

    /// Initial orientation of a body: 3 numbers, a rotation vector (rad) in world axes that turns it about its origin.
    #[staticmethod]
    fn initial_orientation(body: &str) -> Self {
        Self(gradient::Parameter::InitialOrientation(body.into()))
    }

    /// Initial velocity (m/s) of a body's center of mass: 3 numbers.
    #[staticmethod]
    fn initial_velocity(body: &str) -> Self {
        Self(gradient::Parameter::InitialVelocity(body.into()))
    }

    /// Initial spin (rad/s) of a body, in world axes: 3 numbers.
    #[staticmethod]
    fn initial_spin(body: &str) -> Self {
        Self(gradient::Parameter::InitialSpin(body.into()))
    }

    /// Hydroelastic modulus (Pa) of a body that is not rigid.
    #[staticmethod]
    fn modulus(body: &str) -> Self {
        Self(gradient::Parameter::Modulus(body.into()))
    }

    /// Dissipation (s/m) of a body.
    #[staticmethod]
    fn dissipation(body: &str) -> Self {
        Self(gradient::Parameter::Dissipation(body.into()))
    }

    /// Coefficient of friction of a body.
    #[staticmethod]
    fn friction(body: &str) -> Self {
        Self(gradient::Parameter::Friction(body.into()))
    }

    /// Mass (kg) of a body, which scales its inertia.
    #[staticmethod]
    fn mass(body: &str) -> Self {
        Self(gradient::Parameter::Mass(body.into()))
    }

    /// Gravity (m/s²): 3 numbers.
    #[staticmethod]
    fn gravity() -> Self {
        Self(gradient::Parameter::Gravity)
    }

    /// The wrench of an interval, counted from 0, of a body's control: 6 numbers, torque (N m), then force (N).
    #[staticmethod]
    fn control(body: &str, interval: usize) -> Self {
        Self(gradient::Parameter::Control(body.into(), interval))
    }

    /// The wrenches of all of so many intervals of the controls of some bodies: a list, whose numbers together are those of an array
    /// (intervals, bodies, 6).
    #[staticmethod]
    fn controls(bodies: Vec<String>, intervals: usize) -> Vec<Self> {
        let bodies: Vec<Arc<str>> = bodies.into_iter().map(Into::into).collect();
        let of_interval = |interval| {
            let control =
                move |body: &Arc<str>| gradient::Parameter::Control(Arc::clone(body), interval);
            bodies.iter().map(control).map(Self)
        };
        (0..intervals).flat_map(of_interval).collect()
    }

    /// How many numbers it is.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    /// Name of the body that it belongs to, or None.
    #[getter]
    fn body(&self) -> Option<&str> {
        self.named().1
    }

    fn __repr__(&self) -> String {
        let (name, body, interval) = self.named();
        let body = body.map(|body| format!("{body:?}"));
        let interval = interval.map(|interval| interval.to_string());
        let arguments: Vec<String> = body.into_iter().chain(interval).collect();
        format!("Parameter.{name}({})", arguments.join(", "))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (&'py str, Option<String>, Option<usize>))> {
        let load = slf
            .py()
            .import("hydroelastic._core")?
            .getattr("_load_parameter")?;
        let (name, body, interval) = slf.get().named();
        Ok((load, (name, body.map(str::to_owned), interval)))
    }
}

/// A parameter from what pickle has kept.
#[pyfunction]
pub fn _load_parameter<'py>(
    py: Python<'py>,
    name: &str,
    body: Option<&str>,
    interval: Option<usize>,
) -> PyResult<Bound<'py, PyAny>> {
    let class = py.get_type::<Parameter>();
    match (body, interval) {
        (Some(body), Some(interval)) => class.call_method1(name, (body, interval)),
        (Some(body), None) => class.call_method1(name, (body,)),
        _ => class.call_method0(name),
    }
}

/// The parameters of a list.
pub fn inner(parameters: &[Bound<'_, Parameter>]) -> Vec<gradient::Parameter> {
    parameters
        .iter()
        .map(|parameter| parameter.get().0.clone())
        .collect()
}
