//! Results of identifications.

use crate::arrays::{
    Floats, Numbers, Whole, array, check_finite, copied, count, list, numbers, whole, wrong_shape,
};
use crate::pickle::{Reduced, loaded, reduced};
use crate::trajectory::Trajectory;
use crate::world_gradients::by_rows;
use hydroelastic::identification::{self, Termination};
use hydroelastic::nalgebra::DVector;
use pyo3::prelude::*;

/// Checkpoint from which a fit can continue: coordinates of the u unknowns, and of the n nuisances of each of m measurements. A checkpoint
/// can be pickled.
///
/// Parameters
/// ----------
/// horizon : int
///     Index of the horizon that is fitted. If it is the number of horizons, whole measurements are fitted.
/// unknowns : (u,) array_like
///     Coordinates of the unknowns.
/// nuisances : (m, n) array_like
///     Coordinates of the nuisances of each measurement.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Checkpoint(pub identification::Checkpoint);

#[pymethods]
impl Checkpoint {
    #[new]
    fn new(
        #[pyo3(from_py_with = whole)] horizon: Whole,
        unknowns: &Bound<'_, PyAny>,
        nuisances: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let unknowns = list(unknowns, "unknowns")?;
        check_finite(&unknowns, "unknowns")?;
        let Numbers { values, shape } = numbers(nuisances, "nuisances")?;
        check_finite(&values, "nuisances")?;
        let [measurements, width] = shape[..] else {
            return Err(wrong_shape("nuisances", "(m, n)", &shape));
        };
        let row = |row: usize| DVector::from_column_slice(&values[row * width..(row + 1) * width]);
        Ok(Self(identification::Checkpoint {
            horizon: count(horizon, "horizon")?,
            unknowns: unknowns.into(),
            nuisances: (0..measurements).map(row).collect(),
        }))
    }

    /// Index of the horizon that is fitted.
    #[getter]
    fn horizon(&self) -> usize {
        self.0.horizon
    }

    /// Coordinates of the unknowns, (u,) float64.
    #[getter]
    fn unknowns<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let unknowns = &self.0.unknowns;
        copied(py, unknowns.as_slice(), &[unknowns.len()])
    }

    /// Coordinates of the nuisances of each measurement, (m, n) float64.
    #[getter]
    fn nuisances<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let rows = &self.0.nuisances;
        let values = rows.iter().flat_map(|row| row.iter().copied()).collect();
        array(
            py,
            values,
            &[rows.len(), rows.first().map_or(0, DVector::len)],
        )
    }

    fn __repr__(&self) -> String {
        let (unknowns, measurements) = (self.0.unknowns.len(), self.0.nuisances.len());
        format!("Checkpoint({unknowns} unknowns, {measurements} measurements)")
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(usize, Floats<'py>, Floats<'py>)> {
        Ok((self.horizon(), self.unknowns(py)?, self.nuisances(py)?))
    }
}

/// Simulated motion of a measurement and its errors, for k states and b observed bodies. A prediction can be pickled.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Prediction(pub identification::Prediction);

#[pymethods]
impl Prediction {
    /// Simulated states at the measured times.
    #[getter]
    fn trajectory(&self) -> Trajectory {
        self.0.trajectory.clone().into()
    }

    /// Distances (m) of the simulated from the measured position of each observed body, in each state, (k, b) float64.
    #[getter]
    fn position_errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_state(py, &self.0.position_errors)
    }

    /// Angles (rad) of the rotations from the measured to the simulated orientation, (k, b) float64.
    #[getter]
    fn rotation_errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_state(py, &self.0.rotation_errors)
    }

    /// Errors of position and rotation in units of the noise, combined as the root of the sum of their squares, (k, b) float64.
    #[getter]
    fn normalized_errors<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_state(py, &self.0.normalized_errors)
    }

    /// Mean squared normalized error of each observed body in the states after the first, (b,) float64. If the world and the noise
    /// are correct, it is near 6, or less if few states determine the nuisances.
    #[getter]
    fn mean_squares<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let means = self.0.mean_squares();
        let shape = [means.len()];
        array(py, means, &shape)
    }

    fn __repr__(&self) -> String {
        let [states, bodies] = [
            self.0.position_errors.len(),
            self.0.position_errors.first().map_or(0, Vec::len),
        ];
        format!("Prediction({states} states, {bodies} bodies)")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_prediction", &self.0)
    }
}

/// Restores a prediction from a pickle.
#[pyfunction]
pub fn _load_prediction(saved: &[u8]) -> PyResult<Prediction> {
    loaded(saved).map(Prediction)
}

/// Array of numbers for each state and each observed body.
fn by_state<'py>(py: Python<'py>, errors: &[Vec<f64>]) -> PyResult<Floats<'py>> {
    let shape = [errors.len(), errors.first().map_or(0, Vec::len)];
    array(py, errors.concat(), &shape)
}

/// Result of Identification.fit, with u unknowns and m measurements. A fit can be pickled.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Fit(pub identification::Fit);

#[pymethods]
impl Fit {
    /// Names of the unknowns.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.0
            .estimates
            .iter()
            .map(|estimate| estimate.name.clone())
            .collect()
    }

    /// Estimates, (u,) float64.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let values = self.0.values();
        let shape = [values.len()];
        array(py, values, &shape)
    }

    /// 95 % intervals of the estimates, if the world and the deviations of the noise are correct, (u, 2) float64.
    #[getter]
    fn intervals<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let ends = self
            .0
            .estimates
            .iter()
            .flat_map(|estimate| estimate.interval);
        array(py, ends.collect(), &[self.0.estimates.len(), 2])
    }

    /// 95 % intervals of the estimates from the spread between measurements, (u, 2) float64. They remain valid if the world is only
    /// approximate, and need many more measurements than unknowns.
    #[getter]
    fn sandwich_intervals<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let estimates = self.0.estimates.iter();
        let ends = estimates.flat_map(|estimate| estimate.sandwich_interval);
        array(py, ends.collect(), &[self.0.estimates.len(), 2])
    }

    /// Covariance of the coordinates of the unknowns, (u, u) float64. An unknown without effect has an infinite variance.
    /// If a direction of the others is not determined, all their entries are infinite.
    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_rows(py, &self.0.covariance)
    }

    /// Covariance of the coordinates from the spread between measurements (sandwich estimator), (u, u) float64.
    #[getter]
    fn sandwich_covariance<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        by_rows(py, &self.0.sandwich_covariance)
    }

    /// Unit vectors along the principal directions of the information about the coordinates, the least known first, (u, u) float64. Each row
    /// is a direction.
    #[getter]
    fn directions<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let directions = self.0.directions.iter();
        let weights =
            directions.flat_map(|direction| direction.weights.iter().map(|(_, weight)| *weight));
        array(py, weights.collect(), &[self.0.directions.len(); 2])
    }

    /// Standard deviation of the coordinates along each direction, (u,) float64. Infinite if the measurements do not determine it. For
    /// logarithms, 1 is an uncertainty by a factor of e.
    #[getter]
    fn direction_deviations<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let directions = self.0.directions.iter();
        let deviations = directions.map(|direction| direction.standard_deviation);
        array(py, deviations.collect(), &[self.0.directions.len()])
    }

    /// Cost, in units of ½χ².
    #[getter]
    fn cost(&self) -> f64 {
        self.0.cost
    }

    /// Cost of each measurement, (m,) float64. Zero if it was omitted.
    #[getter]
    fn costs<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        let costs = self
            .0
            .measurements
            .iter()
            .map(|measurement| measurement.cost);
        array(py, costs.collect(), &[self.0.measurements.len()])
    }

    /// Reason why each measurement was omitted, or None.
    #[getter]
    fn errors(&self) -> Vec<Option<String>> {
        let measurements = self.0.measurements.iter();
        measurements
            .map(|measurement| measurement.error.as_ref().map(ToString::to_string))
            .collect()
    }

    /// Checkpoint from which another fit can continue.
    #[getter]
    fn checkpoint(&self) -> Checkpoint {
        Checkpoint(self.0.checkpoint.clone())
    }

    /// Number of iterations, over all horizons.
    #[getter]
    fn iterations(&self) -> usize {
        self.0.iterations
    }

    /// Reason why the fit ended: "converged", "stalled", "iteration limit" or "stopped".
    #[getter]
    fn termination(&self) -> &'static str {
        match self.0.termination {
            Termination::Converged => "converged",
            Termination::Stalled => "stalled",
            Termination::IterationLimit => "iteration limit",
            _ => "stopped",
        }
    }

    fn __repr__(&self) -> String {
        let estimates: Vec<String> = self.0.estimates.iter().map(ToString::to_string).collect();
        format!("Fit({})", estimates.join(", "))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_fit", &self.0)
    }
}

/// Restores a fit from a pickle.
#[pyfunction]
pub fn _load_fit(saved: &[u8]) -> PyResult<Fit> {
    loaded(saved).map(Fit)
}
