//! Controls: wrenches that are constant over intervals of time.

use crate::arrays::{Floats, array, real, table};
use crate::errors::value_error;
use hydroelastic::dynamics;
use hydroelastic::nalgebra::Vector6;
use hydroelastic::spatial::Wrench;
use pyo3::prelude::*;

/// Control input: a wrench on a body that is constant over intervals of time.
///
/// The wrench is zero before time 0 and after the last interval. Parameter.control differentiates with respect to the wrench of an
/// interval.
///
/// Parameters
/// ----------
/// body : str
///     Name of a dynamic body.
/// interval : float
///     Duration (s) of an interval. Use a whole number of time steps.
/// wrenches : (k, 6) array_like
///     Torque (N m) and force (N) of each interval, about the center of mass, in world axes.
///
/// Raises
/// ------
/// HydroelasticError
///     If the interval is not positive, or a number is not finite.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Control(pub dynamics::Control);

#[pymethods]
impl Control {
    #[new]
    fn new(
        body: &str,
        #[pyo3(from_py_with = real)] interval: f64,
        wrenches: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let wrenches = table::<6>(wrenches, "wrenches")?.into_iter();
        let wrenches = wrenches.map(|numbers| Wrench::from_vector(&Vector6::from(numbers)));
        let control = dynamics::Control::new(body, interval, wrenches.collect());
        Ok(Self(control.map_err(value_error)?))
    }

    /// Name of the body.
    #[getter]
    fn body(&self) -> &str {
        self.0.body()
    }

    /// Duration (s) of an interval.
    #[getter]
    fn interval(&self) -> f64 {
        self.0.interval()
    }

    /// Torque (N m) and force (N) of each interval, about the center of mass, in world axes, (k, 6) float64.
    #[getter]
    fn wrenches<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let wrenches = self.0.wrenches();
        let numbers = wrenches
            .iter()
            .flat_map(|wrench| wrench.to_vector().as_slice().to_vec());
        array(py, numbers.collect(), &[wrenches.len(), 6])
    }

    fn __repr__(&self) -> String {
        let intervals = self.0.wrenches().len();
        format!(
            "Control({:?}, {intervals} intervals of {:?} s)",
            self.body(),
            self.interval()
        )
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(&str, f64, Floats<'py>)> {
        Ok((self.body(), self.interval(), self.wrenches(py)?))
    }
}
