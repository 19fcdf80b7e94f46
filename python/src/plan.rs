//! Simulation options: integrators, tolerances and plans.

use crate::arrays::{Whole, count, optional_real, positive_count, real, whole};
use crate::errors::value_error;
use hydroelastic::dynamics;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Time integrator, which computes the state one time step later.
///
/// LEAPFROG and SYMPLECTIC_EULER are explicit: they need short steps with one evaluation of the contacts each. SDIRK3 and
/// IMPLICIT_EULER are implicit: they allow steps of 1 to 10 ms for any contact stiffness and slip tolerance.
#[pyclass(frozen, eq, hash, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Integrator(dynamics::Integrator);

/// Converts an argument that is an Integrator, its name or None.
fn integrator(argument: &Bound<'_, PyAny>) -> PyResult<Integrator> {
    if argument.is_none() {
        return Ok(Integrator::LEAPFROG);
    }
    if let Ok(integrator) = argument.cast::<Integrator>() {
        return Ok(*integrator.get());
    }
    let names = Integrator::ALL.map(|known| format!("{:?}", known.name().to_lowercase()));
    let names = names.join(", ");
    let Ok(name) = argument.extract::<String>() else {
        return Err(PyTypeError::new_err(format!(
            "integrator must be an Integrator or its name, {names}, but is {}",
            argument.repr()?
        )));
    };
    let mut all = Integrator::ALL.into_iter();
    all.find(|integrator| integrator.name().eq_ignore_ascii_case(&name))
        .ok_or_else(|| value_error(format!("there is no integrator {name:?}: expected {names}")))
}

impl Integrator {
    const ALL: [Self; 4] = [
        Self::SYMPLECTIC_EULER,
        Self::LEAPFROG,
        Self::SDIRK3,
        Self::IMPLICIT_EULER,
    ];

    /// Name of the class attribute: the name in the library, in capitals and with underscores.
    fn name(&self) -> String {
        let mut name = String::new();
        for character in format!("{:?}", self.0).chars() {
            if character.is_uppercase() && !name.is_empty() {
                name.push('_');
            }
            name.push(character.to_ascii_uppercase());
        }
        name
    }
}

#[pymethods]
impl Integrator {
    /// Explicit integrator of first order: kick, then drift.
    #[classattr]
    const SYMPLECTIC_EULER: Self = Self(dynamics::Integrator::SymplecticEuler);

    /// Explicit integrator of second order: half a drift, kick, half a drift. The default.
    #[classattr]
    const LEAPFROG: Self = Self(dynamics::Integrator::Leapfrog);

    /// Implicit integrator of third order with three stages. Steps are divided to meet the tolerances of Accuracy, so that derivatives
    /// are those of the motion.
    #[classattr]
    const SDIRK3: Self = Self(dynamics::Integrator::Sdirk3);

    /// Implicit integrator of first order with one stage. It damps fast motion, so use it for scenes that should come to rest.
    /// Derivatives are those of the damped motion.
    #[classattr]
    const IMPLICIT_EULER: Self = Self(dynamics::Integrator::ImplicitEuler);

    fn __repr__(&self) -> String {
        format!("Integrator.{}", self.name())
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyAny>, String))> {
        let getattr = slf.py().import("builtins")?.getattr("getattr")?;
        Ok((
            getattr,
            (slf.as_any().get_type().into_any(), slf.get().name()),
        ))
    }
}

/// Error tolerances with which Integrator.SDIRK3 divides a time step.
///
/// The relative tolerances hold for a body that moves faster than the resting speed. Below this speed the tolerances grow: impacts below
/// 0.18 times the resting speed are not resolved at the default tolerances, and bodies come to rest.
///
/// Parameters
/// ----------
/// values : float
///     Relative tolerance of velocities, positive.
/// slopes : float
///     Relative tolerance of the derivatives of the motion, positive.
/// resting_speed : float, optional
///     Resting speed (m/s) of all bodies, positive. Default: the speed of each body after a fall by a hundredth of its smallest extent.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not positive and finite.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Accuracy(dynamics::Accuracy);

#[pymethods]
impl Accuracy {
    #[new]
    #[pyo3(signature = (values=3e-4, slopes=2e-3, resting_speed=None))]
    fn new(
        #[pyo3(from_py_with = real)] values: f64,
        #[pyo3(from_py_with = real)] slopes: f64,
        #[pyo3(from_py_with = optional_real)] resting_speed: Option<f64>,
    ) -> PyResult<Self> {
        let accuracy = dynamics::Accuracy::new(values, slopes).map_err(value_error)?;
        let accuracy = match resting_speed {
            Some(speed) => accuracy.with_resting_speed(speed).map_err(value_error)?,
            None => accuracy,
        };
        Ok(Self(accuracy))
    }

    /// Relative tolerance of velocities.
    #[getter]
    fn values(&self) -> f64 {
        self.0.values()
    }

    /// Relative tolerance of the derivatives of the motion.
    #[getter]
    fn slopes(&self) -> f64 {
        self.0.slopes()
    }

    /// Resting speed (m/s) of all bodies; None if the speeds follow from the sizes of the bodies.
    #[getter]
    fn resting_speed(&self) -> Option<f64> {
        self.0.resting_speed()
    }

    fn __repr__(&self) -> String {
        let resting = self.resting_speed();
        let resting = resting.map_or(String::new(), |speed| format!(", resting_speed={speed:?}"));
        format!(
            "Accuracy(values={:?}, slopes={:?}{resting})",
            self.values(),
            self.slopes()
        )
    }

    fn __getnewargs__(&self) -> (f64, f64, Option<f64>) {
        (self.values(), self.slopes(), self.resting_speed())
    }
}

/// Plan of a rollout: time step, number of steps, integrator, and the states to record.
///
/// Parameters
/// ----------
/// time_step : float
///     Time step (s), positive.
/// steps : int
///     Number of steps, at least 0.
/// integrator : Integrator or str, optional
///     Integrator or its name: "leapfrog", "symplectic_euler", "sdirk3" or "implicit_euler". Default: Integrator.LEAPFROG.
/// record_every : int
///     Number of steps between recorded states, at least 1. The initial state and the last state are always recorded.
/// check_stability : bool
///     True to check explicit steps if a contact begins or changes fast. The rollout ends with a RolloutError if the time step is above
///     World.largest_stable_step, computed without friction, or if a contact returns more than twice the energy that it has absorbed.
/// solver_tolerance : float
///     Relative tolerance of implicit steps, positive. A step is solved if the last correction is below this fraction of the velocities.
/// accuracy : Accuracy, optional
///     Error tolerances of Integrator.SDIRK3. Default: Accuracy().
///
/// Raises
/// ------
/// HydroelasticError
///     If the time step or the tolerance is not positive and finite, a count is out of range, or the name of the integrator is unknown.
/// TypeError
///     If the integrator is neither an Integrator nor a name.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Plan(pub dynamics::Plan);

#[pymethods]
impl Plan {
    #[new]
    #[pyo3(signature = (time_step, steps, integrator=Integrator::LEAPFROG, *, record_every=1, check_stability=true, solver_tolerance=1e-10, accuracy=None),
        text_signature = "(time_step, steps, integrator=None, *, record_every=1, check_stability=True, solver_tolerance=1e-10, accuracy=None)")]
    fn new(
        #[pyo3(from_py_with = real)] time_step: f64,
        #[pyo3(from_py_with = whole)] steps: Whole,
        #[pyo3(from_py_with = integrator)] integrator: Integrator,
        #[pyo3(from_py_with = whole)] record_every: Whole,
        check_stability: bool,
        #[pyo3(from_py_with = real)] solver_tolerance: f64,
        accuracy: Option<PyRef<'_, Accuracy>>,
    ) -> PyResult<Self> {
        let plan = dynamics::Plan::new(time_step, count(steps, "steps")?).map_err(value_error)?;
        let plan = plan.with_integrator(integrator.0);
        let plan = plan.recording_every(positive_count(record_every, "record_every")?);
        let plan = plan
            .with_solver_tolerance(solver_tolerance)
            .map_err(value_error)?;
        let plan = plan.with_accuracy(accuracy.map(|accuracy| accuracy.0).unwrap_or_default());
        Ok(Self(if check_stability {
            plan
        } else {
            plan.without_stability_check()
        }))
    }

    /// Time step (s).
    #[getter]
    fn time_step(&self) -> f64 {
        self.0.time_step()
    }

    /// Number of steps.
    #[getter]
    fn steps(&self) -> usize {
        self.0.steps()
    }

    /// Integrator of the steps.
    #[getter]
    fn integrator(&self) -> Integrator {
        Integrator(self.0.integrator())
    }

    /// Number of steps between recorded states.
    #[getter]
    fn record_every(&self) -> usize {
        self.0.record_every()
    }

    /// True if explicit steps are checked for stability.
    #[getter]
    fn check_stability(&self) -> bool {
        self.0.checks_stability()
    }

    /// Relative tolerance of implicit steps.
    #[getter]
    fn solver_tolerance(&self) -> f64 {
        self.0.solver_tolerance()
    }

    /// Error tolerances of Integrator.SDIRK3.
    #[getter]
    fn accuracy(&self) -> Accuracy {
        Accuracy(self.0.accuracy())
    }

    /// Duration (s) of all steps.
    #[getter]
    fn duration(&self) -> f64 {
        self.0.duration()
    }

    pub fn __repr__(&self) -> String {
        let every = match self.record_every() {
            1 => String::new(),
            every => format!(", record_every={every}"),
        };
        let check = if self.check_stability() {
            ""
        } else {
            ", check_stability=False"
        };
        let accuracy = if self.0.accuracy() == dynamics::Accuracy::default() {
            String::new()
        } else {
            format!(", accuracy={}", self.accuracy().__repr__())
        };
        format!(
            "Plan({:?}, {}, {}{every}{check}, solver_tolerance={:?}{accuracy})",
            self.time_step(),
            self.steps(),
            self.integrator().__repr__(),
            self.solver_tolerance()
        )
    }
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((f64, usize, Integrator), Bound<'py, PyDict>)> {
        let keywords = PyDict::new(py);
        keywords.set_item("record_every", self.record_every())?;
        keywords.set_item("check_stability", self.check_stability())?;
        keywords.set_item("solver_tolerance", self.solver_tolerance())?;
        keywords.set_item("accuracy", self.accuracy())?;
        Ok((
            (self.time_step(), self.steps(), self.integrator()),
            keywords,
        ))
    }
}
