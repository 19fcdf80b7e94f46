//! What a step took, and the energies of a state.

use crate::arrays::{Floats, array, check_kept, finite, real};
use crate::pickle::{Reduced, loaded, reduced};
use hydroelastic::dynamics;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// What one implicit step, or several, took.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, PartialEq)]
pub struct StepReport(pub dynamics::StepReport);

#[pymethods]
impl StepReport {
    /// Groups of bodies that were solved by themselves.
    #[getter]
    fn islands(&self) -> usize {
        self.0.islands
    }

    /// Systems of equations: one for each stage of each substep of an island, rejected ones included, and two if the first guess does
    /// not lead to a solution.
    #[getter]
    fn solves(&self) -> usize {
        self.0.work.solves
    }

    /// Evaluations of an island that has contacts. They dominate the run time.
    #[getter]
    fn evaluations(&self) -> usize {
        self.0.work.evaluations
    }

    /// Looks at the contacts, whether anything is near or not.
    #[getter]
    fn looks(&self) -> usize {
        self.0.work.looks
    }

    /// Iterations of Newton's method.
    #[getter]
    fn iterations(&self) -> usize {
        self.0.work.iterations
    }

    /// Substeps that were taken, of all islands.
    #[getter]
    fn substeps(&self) -> usize {
        self.0.work.substeps
    }

    /// Substeps that were taken although their error exceeds the tolerance.
    #[getter]
    fn missed(&self) -> usize {
        self.0.work.missed
    }

    /// Exact linearizations of an island's contacts, for the errors of its substeps.
    #[getter]
    fn linearizations(&self) -> usize {
        self.0.work.linearizations
    }

    /// Substeps that were rejected because their error exceeds the tolerance.
    #[getter]
    fn rejections(&self) -> usize {
        self.0.work.rejections
    }

    /// Substeps that were repeated with a shorter duration because a system was not solved.
    #[getter]
    fn failures(&self) -> usize {
        self.0.work.failures
    }

    /// Change of the kinetic energy (J).
    #[getter]
    fn kinetic(&self) -> f64 {
        self.0.energy.kinetic
    }

    /// The work of gravity and controls (J).
    #[getter]
    fn given(&self) -> f64 {
        self.0.energy.given
    }

    /// The work of contacts and other forces (J).
    #[getter]
    fn acting(&self) -> f64 {
        self.0.energy.acting
    }

    /// Work minus the change of kinetic energy (J): what the integrator has lost, or made if negative.
    #[getter]
    fn numerical_loss(&self) -> f64 {
        self.0.energy.numerical_loss()
    }

    /// (n,) float64: the estimated error of the velocity of each body, as the sum over substeps of error over tolerance, times
    /// Accuracy.values. 0 for bodies that forces do not move, and without error control.
    #[getter]
    fn errors_of_values<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.of_bodies(py, |errors| errors.values)
    }

    /// (n,) float64: the same for the derivatives of each body's motion, times Accuracy.slopes.
    #[getter]
    fn errors_of_slopes<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.of_bodies(py, |errors| errors.slopes)
    }

    /// For each body the substeps in which one of its errors exceeds the tolerance.
    #[getter]
    fn missed_by_body(&self) -> Vec<usize> {
        self.0.errors.iter().map(|errors| errors.missed).collect()
    }

    /// The sum of two reports.
    fn __add__(&self, other: &Self) -> Self {
        let mut sum = self.0.clone();
        sum += other.0.clone();
        Self(sum)
    }

    fn __repr__(&self) -> String {
        let dynamics::StepReport {
            islands,
            work,
            energy,
            ..
        } = &self.0;
        format!(
            "StepReport(islands={islands}, solves={}, evaluations={}, looks={}, iterations={}, substeps={}, missed={}, \
             linearizations={}, rejections={}, failures={}, \
             kinetic={:?}, given={:?}, acting={:?}, numerical_loss={:?})",
            work.solves,
            work.evaluations,
            work.looks,
            work.iterations,
            work.substeps,
            work.missed,
            work.linearizations,
            work.rejections,
            work.failures,
            energy.kinetic,
            energy.given,
            energy.acting,
            energy.numerical_loss()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_step_report", &self.0)
    }
}

impl StepReport {
    /// A number of the errors of each body.
    fn of_bodies<'py>(
        &self,
        py: Python<'py>,
        number: fn(&dynamics::BodyErrors) -> f64,
    ) -> PyResult<Floats<'py>> {
        let numbers: Vec<f64> = self.0.errors.iter().map(number).collect();
        let count = numbers.len();
        array(py, numbers, &[count])
    }
}

/// A report from what pickle has kept.
#[pyfunction]
pub fn _load_step_report(saved: &[u8]) -> PyResult<StepReport> {
    loaded(saved).map(StepReport)
}

/// Energies and momentum of a state. Only dynamic bodies have kinetic energy, weight and momentum.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Diagnostics {
    /// ½ m v² + ½ ω·I·ω (J).
    kinetic_energy: f64,
    /// −m g·x (J), x the center of mass from the origin of the world.
    gravitational_energy: f64,
    /// Potential energy of all contacts (J).
    contact_energy: f64,
    /// The sum of these (J), without what is stored in forces of other kinds.
    total_energy: f64,
    /// (3,) float64: linear momentum (kg m/s).
    linear_momentum: Py<PyArrayDyn<f64>>,
    /// (3,) float64: angular momentum (kg m²/s) about the origin of the world.
    angular_momentum: Py<PyArrayDyn<f64>>,
}

impl Diagnostics {
    pub fn of(py: Python<'_>, report: &dynamics::Diagnostics) -> PyResult<Self> {
        let momentum = [&report.momentum.linear, &report.momentum.angular];
        let [linear, angular] =
            momentum.map(|it| -> PyResult<Floats<'_>> { array(py, it.as_slice().to_vec(), &[3]) });
        Self::new(
            py,
            report.kinetic_energy,
            report.gravitational_energy,
            report.contact_energy,
            report.total_energy(),
            (linear?.unbind(), angular?.unbind()),
        )
    }
}

#[pymethods]
impl Diagnostics {
    #[new]
    fn new(
        py: Python<'_>,
        #[pyo3(from_py_with = real)] kinetic_energy: f64,
        #[pyo3(from_py_with = real)] gravitational_energy: f64,
        #[pyo3(from_py_with = real)] contact_energy: f64,
        #[pyo3(from_py_with = real)] total_energy: f64,
        momenta: (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>),
    ) -> PyResult<Self> {
        let (linear_momentum, angular_momentum) = momenta;
        check_kept(
            py,
            &[
                (&linear_momentum, "linear_momentum", &["3"]),
                (&angular_momentum, "angular_momentum", &["3"]),
            ],
        )?;
        finite(kinetic_energy, "kinetic_energy")?;
        finite(gravitational_energy, "gravitational_energy")?;
        finite(contact_energy, "contact_energy")?;
        finite(total_energy, "total_energy")?;
        Ok(Self {
            kinetic_energy,
            gravitational_energy,
            contact_energy,
            total_energy,
            linear_momentum,
            angular_momentum,
        })
    }

    fn __repr__(&self) -> String {
        format!(
            "Diagnostics(kinetic_energy={:?}, gravitational_energy={:?}, contact_energy={:?}, total_energy={:?} J)",
            self.kinetic_energy, self.gravitational_energy, self.contact_energy, self.total_energy
        )
    }
    fn __getnewargs__(
        &self,
        py: Python<'_>,
    ) -> (
        f64,
        f64,
        f64,
        f64,
        (Py<PyArrayDyn<f64>>, Py<PyArrayDyn<f64>>),
    ) {
        let momenta = (
            self.linear_momentum.clone_ref(py),
            self.angular_momentum.clone_ref(py),
        );
        (
            self.kinetic_energy,
            self.gravitational_energy,
            self.contact_energy,
            self.total_energy,
            momenta,
        )
    }
}
