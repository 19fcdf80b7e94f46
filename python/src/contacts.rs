//! Which bodies of a world touch.

use crate::arrays::{Whole, array, check_finite, check_kept, count, whole};
use crate::pair::wrench_numbers;
use crate::pickle::{Reduced, loaded, reduced};
use crate::surface::Surface;
use hydroelastic::dynamics;
use numpy::PyArrayDyn;
use pyo3::prelude::*;

/// Two bodies of a world that touch, A and B.
#[pyclass(frozen, get_all, module = "hydroelastic")]
pub struct Contact {
    /// The names of A and B.
    bodies: (String, String),
    /// (12,) float64: torque (N m) and force (N) on A about the origin of its frame, then on B, in world axes, with friction
    /// and dissipation.
    wrench: Py<PyArrayDyn<f64>>,
    /// The contact surface, in the world frame.
    surface: Py<Surface>,
}

impl Contact {
    pub fn of(py: Python<'_>, contact: &dynamics::Contact, names: &[&str]) -> PyResult<Self> {
        let [a, b] = contact.bodies.map(|place| names[place].to_owned());
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

/// Which tetrahedra touch in a state. Where it changes from one state to the next, a derivative may be one-sided.
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

    /// Whether two bodies, by their places in the world's list, touch.
    fn touches(
        &self,
        #[pyo3(from_py_with = whole)] first: Whole,
        #[pyo3(from_py_with = whole)] second: Whole,
    ) -> PyResult<bool> {
        Ok(self
            .0
            .touches(count(first, "first")?, count(second, "second")?))
    }

    /// Number of pairs of tetrahedra that touch in one of two states and not in the other.
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

/// A topology from what pickle has kept.
#[pyfunction]
pub fn _load_topology(saved: &[u8]) -> PyResult<ContactTopology> {
    loaded(saved).map(ContactTopology)
}
