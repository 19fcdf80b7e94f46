//! Contacts between the bodies of a world.

use crate::arrays::{Whole, array, check_finite, check_kept, count, whole};
use crate::pair::wrench_numbers;
use crate::pickle::{Reduced, loaded, reduced};
use crate::surface::Surface;
use hydroelastic::dynamics;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Contact between two bodies A and B of a world.
///
/// Parameters
/// ----------
/// bodies : (str, str)
///     Names of A and B.
/// wrench : (12,) ndarray of float64
///     Torque (N m) and force (N) on A about the origin of the frame of A, then on B about the origin of the frame of B, in world
///     axes.
/// surface : Surface
///     Contact surface in the world frame.
///
/// Raises
/// ------
/// HydroelasticError
///     If the wrench has an unexpected shape, or a number is not finite.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Contact {
    /// Names of A and B.
    bodies: (String, String),
    /// Torque (N m) and force (N) on A about the origin of the frame of A, then on B about the origin of the frame of B, in world
    /// axes, (12,) float64. The wrenches include friction and dissipation.
    wrench: Py<PyArrayDyn<f64>>,
    /// Contact surface in the world frame.
    surface: Py<Surface>,
}

impl Contact {
    pub fn of(py: Python<'_>, contact: &dynamics::Contact, names: &[&str]) -> PyResult<Self> {
        let [a, b] = contact.bodies.map(|index| names[index].to_owned());
        let wrench = wrench_numbers(&contact.wrench);
        check_finite(&wrench, &format!("the wrench of {a:?} and {b:?}"))?;
        let wrench = array(py, wrench.to_vec(), &[12])?;
        let surface = Py::new(py, Surface::of(py, &contact.surface)?)?;
        Ok(Self {
            bodies: (a, b),
            wrench: wrench.unbind(),
            surface,
        })
    }
}

#[pymethods]
impl Contact {
    #[new]
    fn new(
        py: Python<'_>,
        bodies: (String, String),
        wrench: Py<PyArrayDyn<f64>>,
        surface: Py<Surface>,
    ) -> PyResult<Self> {
        check_kept(py, &[(&wrench, "wrench", &["12"])])?;
        Ok(Self {
            bodies,
            wrench,
            surface,
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (a, b) = &self.bodies;
        Ok(format!(
            "Contact({a:?} and {b:?}, {})",
            self.surface.bind(py).repr()?
        ))
    }

    fn __getnewargs__(
        &self,
        py: Python<'_>,
    ) -> ((String, String), Py<PyArrayDyn<f64>>, Py<Surface>) {
        (
            self.bodies.clone(),
            self.wrench.clone_ref(py),
            self.surface.clone_ref(py),
        )
    }
}

/// Set of the pairs of tetrahedra that touch in a state.
///
/// If the set changes from one state to the next, a derivative may be one-sided.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, PartialEq, Eq)]
pub struct ContactTopology(pub dynamics::ContactTopology);

#[pymethods]
impl ContactTopology {
    /// Number of contact polygons.
    #[getter]
    fn polygon_count(&self) -> usize {
        self.0.polygon_count()
    }

    /// Returns whether two bodies touch.
    ///
    /// Parameters
    /// ----------
    /// first, second : int
    ///     Indices of the bodies in the list of the world.
    ///
    /// Returns
    /// -------
    /// bool
    ///     True if the bodies touch.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If an index is negative.
    fn touches(
        &self,
        #[pyo3(from_py_with = whole)] first: Whole,
        #[pyo3(from_py_with = whole)] second: Whole,
    ) -> PyResult<bool> {
        Ok(self
            .0
            .touches(count(first, "first")?, count(second, "second")?))
    }

    /// Counts the pairs of tetrahedra that touch in exactly one of two states.
    ///
    /// Parameters
    /// ----------
    /// before : ContactTopology
    ///     Topology of the other state.
    ///
    /// Returns
    /// -------
    /// int
    ///     Number of pairs.
    fn changes_since(&self, before: &Self) -> usize {
        self.0.changes_since(&before.0)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_topology", &self.0)
    }

    fn __repr__(&self) -> String {
        format!("ContactTopology({} polygons)", self.0.polygon_count())
    }
}

/// Restores a topology from a pickle.
#[pyfunction]
pub fn _load_topology(saved: &[u8]) -> PyResult<ContactTopology> {
    loaded(saved).map(ContactTopology)
}
