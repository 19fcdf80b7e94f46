//! How a world is stepped.

use crate::arrays::{Whole, count, positive_count, real, whole};
use crate::errors::refused;
use hydroelastic::dynamics;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

/// How a state is taken one time step further.
///
/// LEAPFROG and SYMPLECTIC_EULER are explicit: short steps, one evaluation of the contacts each. SDIRK2 and IMPLICIT_EULER are
/// implicit: steps of 1 to 10 ms, however stiff the contact and small the slip tolerance.
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
        .ok_or_else(|| refused(format!("there is no integrator {name:?}: expected {names}")))
}

impl Integrator {
    const ALL: [Self; 4] = [
        Self::SYMPLECTIC_EULER,
        Self::LEAPFROG,
        Self::SDIRK2,
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
    /// Kick, then drift: first order.
    #[classattr]
    const SYMPLECTIC_EULER: Self = Self(dynamics::Integrator::SymplecticEuler);

    /// Half a drift, kick, half a drift: second order. The default.
    #[classattr]
    const LEAPFROG: Self = Self(dynamics::Integrator::Leapfrog);

    /// Two implicit stages of second order; impacts are resolved by halved steps.
    #[classattr]
    const SDIRK2: Self = Self(dynamics::Integrator::Sdirk2);

    /// One implicit stage of first order. It damps fast motion, so use it for scenes that should come to rest.
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

/// How a world is stepped, and which states are recorded.
///
/// Parameters
/// ----------
/// time_step : (s), positive.
/// steps : how many.
/// integrator : an Integrator or its name, such as "sdirk2"; Integrator.LEAPFROG by default.
/// record_every : the initial state, every so many-th after it and the last are recorded.
/// check_stability : whether explicit steps are checked where contact begins or changes fast. The rollout ends with a RolloutError if
///     the time step is above World.largest_stable_step, computed without friction, or if a contact returns
///     more than twice the energy that it has absorbed.
/// solver_tolerance : implicit steps are solved until a correction is below this fraction of the velocities.
///
/// Raises
/// ------
/// HydroelasticError if the time step or the tolerance is not positive and finite, a count is out of range, or the name of the
/// integrator is unknown.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Plan(pub dynamics::Plan);

#[pymethods]
impl Plan {
    #[new]
    #[pyo3(signature = (time_step, steps, integrator=Integrator::LEAPFROG, *, record_every=1, check_stability=true, solver_tolerance=1e-10),
        text_signature = "(time_step, steps, integrator=None, *, record_every=1, check_stability=True, solver_tolerance=1e-10)")]
    fn new(
        #[pyo3(from_py_with = real)] time_step: f64,
        #[pyo3(from_py_with = whole)] steps: Whole,
        #[pyo3(from_py_with = integrator)] integrator: Integrator,
        #[pyo3(from_py_with = whole)] record_every: Whole,
        check_stability: bool,
        #[pyo3(from_py_with = real)] solver_tolerance: f64,
    ) -> PyResult<Self> {
        let plan = dynamics::Plan::new(time_step, count(steps, "steps")?).map_err(refused)?;
        let plan = plan.with_integrator(integrator.0);
        let plan = plan.recording_every(positive_count(record_every, "record_every")?);
        let plan = plan
            .with_solver_tolerance(solver_tolerance)
            .map_err(refused)?;
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

    /// The integrator.
    #[getter]
    fn integrator(&self) -> Integrator {
        Integrator(self.0.integrator())
    }

    /// After how many steps a state is recorded.
    #[getter]
    fn record_every(&self) -> usize {
        self.0.record_every()
    }

    /// Whether explicit steps are checked.
    #[getter]
    fn check_stability(&self) -> bool {
        self.0.checks_stability()
    }

    /// Tolerance of implicit steps.
    #[getter]
    fn solver_tolerance(&self) -> f64 {
        self.0.solver_tolerance()
    }

    /// Time (s) of all steps.
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
        format!(
            "Plan({:?}, {}, {}{every}{check}, solver_tolerance={:?})",
            self.time_step(),
            self.steps(),
            self.integrator().__repr__(),
            self.solver_tolerance()
        )
    }
    fn __getnewargs_ex__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<((f64, usize, Integrator), Bound<'py, pyo3::types::PyDict>)> {
        let keywords = pyo3::types::PyDict::new(py);
        keywords.set_item("record_every", self.record_every())?;
        keywords.set_item("check_stability", self.check_stability())?;
        keywords.set_item("solver_tolerance", self.solver_tolerance())?;
        Ok((
            (self.time_step(), self.steps(), self.integrator()),
            keywords,
        ))
    }
}
