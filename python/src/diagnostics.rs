//! Statistics of implicit steps, and energies of a state.

use crate::arrays::{Floats, array, check_kept, finite, real};
use crate::pickle::{Reduced, loaded, reduced};
use hydroelastic::dynamics;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Solver statistics and energy balance of one implicit step, or of several.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, PartialEq)]
pub struct StepReport(pub dynamics::StepReport);

#[pymethods]
impl StepReport {
    /// Number of islands, which are groups of bodies that were solved separately.
    #[getter]
    fn islands(&self) -> usize {
        self.0.islands
    }

    /// Number of solved systems of equations. Each stage of each substep of an island has one system, or two if the first guess does
    /// not lead to a solution. Rejected substeps count too.
    #[getter]
    fn solves(&self) -> usize {
        self.0.work.solves
    }

    /// Number of evaluations of an island with contacts. They dominate the run time.
    #[getter]
    fn evaluations(&self) -> usize {
        self.0.work.evaluations
    }

    /// Number of contact queries, including those that find no contact.
    #[getter]
    fn looks(&self) -> usize {
        self.0.work.looks
    }

    /// Number of iterations of Newton's method.
    #[getter]
    fn iterations(&self) -> usize {
        self.0.work.iterations
    }

    /// Number of accepted substeps of all islands.
    #[getter]
    fn substeps(&self) -> usize {
        self.0.work.substeps
    }

    /// Number of substeps that were accepted although their error exceeds the tolerance.
    #[getter]
    fn missed(&self) -> usize {
        self.0.work.missed
    }

    /// Number of exact linearizations of the contacts of an island. They serve to estimate the errors of its substeps.
    #[getter]
    fn linearizations(&self) -> usize {
        self.0.work.linearizations
    }

    /// Number of substeps that were rejected because their error exceeds the tolerance.
    #[getter]
    fn rejections(&self) -> usize {
        self.0.work.rejections
    }

    /// Number of substeps that were repeated with a shorter duration because a system was not solved.
    #[getter]
    fn failures(&self) -> usize {
        self.0.work.failures
    }

    /// Change of the kinetic energy (J).
    #[getter]
    fn kinetic(&self) -> f64 {
        self.0.energy.kinetic
    }

    /// Work of gravity and controls (J).
    #[getter]
    fn given(&self) -> f64 {
        self.0.energy.given
    }

    /// Work of contacts and other forces (J).
    #[getter]
    fn acting(&self) -> f64 {
        self.0.energy.acting
    }

    /// Energy (J) that the integrator has lost: the total work minus the change of the kinetic energy. A negative value is a gain.
    #[getter]
    fn numerical_loss(&self) -> f64 {
        self.0.energy.numerical_loss()
    }

    /// Estimated relative error of the velocity of each body, (n,) float64. It is Accuracy.values times the sum of error/tolerance over the
    /// substeps. It is 0 for fixed and kinematic bodies, and without error control.
    #[getter]
    fn errors_of_values<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.of_bodies(py, |errors| errors.values)
    }

    /// Estimated relative error of the derivatives of the motion of each body, (n,) float64. It is Accuracy.slopes times the sum of
    /// error/tolerance over the substeps. It is 0 for fixed and kinematic bodies, and without error control.
    #[getter]
    fn errors_of_slopes<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        self.of_bodies(py, |errors| errors.slopes)
    }

    /// Number of substeps in which an error of a body exceeds the tolerance, for each body.
    #[getter]
    fn missed_by_body(&self) -> Vec<usize> {
        self.0.errors.iter().map(|errors| errors.missed).collect()
    }

    /// Adds two reports.
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
    /// Collects one number of the errors of each body.
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

/// Restores a report from a pickle.
#[pyfunction]
pub fn _load_step_report(saved: &[u8]) -> PyResult<StepReport> {
    loaded(saved).map(StepReport)
}

/// Energies and momentum of a state. Only dynamic bodies have kinetic energy, weight and momentum.
///
/// Parameters
/// ----------
/// kinetic_energy, gravitational_energy, contact_energy, total_energy : float
///     Energies (J).
/// momenta : ((3,) ndarray of float64, (3,) ndarray of float64)
///     Linear momentum (kg m/s) and angular momentum (kg m²/s).
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Diagnostics {
    /// Kinetic energy ½ m v² + ½ ω·I·ω (J).
    kinetic_energy: f64,
    /// Gravitational energy −m g·x (J), with the center of mass x in the world frame.
    gravitational_energy: f64,
    /// Potential energy of all contacts (J).
    contact_energy: f64,
    /// Sum (J) of the kinetic, gravitational and contact energies. It omits the energy that other forces store.
    total_energy: f64,
    /// Linear momentum (kg m/s) in world axes, (3,) float64.
    linear_momentum: Py<PyArrayDyn<f64>>,
    /// Angular momentum (kg m²/s) about the origin of the world, in world axes, (3,) float64.
    angular_momentum: Py<PyArrayDyn<f64>>,
}

impl Diagnostics {
    pub fn of(py: Python<'_>, report: &dynamics::Diagnostics) -> PyResult<Self> {
        let momentum = [&report.momentum.linear, &report.momentum.angular];
        let [linear, angular] = momentum
            .map(|vector| -> PyResult<Floats<'_>> { array(py, vector.as_slice().to_vec(), &[3]) });
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
