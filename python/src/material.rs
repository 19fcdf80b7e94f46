//! Materials of bodies, and the surface law of a pair.

use crate::arrays::{optional_real, real};
use crate::errors::value_error;
use hydroelastic::{contact, dynamics};
use pyo3::prelude::*;

/// The skin of a body.
///
/// Parameters
/// ----------
/// modulus : hydroelastic modulus (Pa), positive; None for a RigidShape, or a HalfSpace without a layer.
/// dissipation : Hunt–Crossley dissipation (s/m), not negative. That of a rigid body does not count.
/// friction : coefficient of friction, not negative; None takes the coefficient of the partner in each contact.
///
/// Raises
/// ------
/// HydroelasticError if a number is out of range.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Material {
    /// Hydroelastic modulus (Pa); None for a rigid body.
    #[pyo3(get)]
    modulus: Option<f64>,
    /// Hunt–Crossley dissipation (s/m).
    #[pyo3(get)]
    dissipation: f64,
    /// Coefficient of friction; None takes the coefficient of the partner.
    #[pyo3(get)]
    friction: Option<f64>,
}

impl Material {
    /// The material of the library.
    pub fn inner(&self) -> dynamics::Material {
        dynamics::Material {
            modulus: self.modulus,
            dissipation: self.dissipation,
            friction: self.friction,
        }
    }
}

impl From<&dynamics::Material> for Material {
    fn from(material: &dynamics::Material) -> Self {
        Self {
            modulus: material.modulus,
            dissipation: material.dissipation,
            friction: material.friction,
        }
    }
}

/// A modulus as Python writes it.
pub fn modulus_repr(modulus: Option<f64>) -> String {
    modulus.map_or_else(|| "None".to_owned(), |modulus| format!("{modulus:?}"))
}

#[pymethods]
impl Material {
    #[new]
    #[pyo3(signature = (modulus, dissipation=0.0, friction=0.0))]
    fn new(
        #[pyo3(from_py_with = optional_real)] modulus: Option<f64>,
        #[pyo3(from_py_with = real)] dissipation: f64,
        #[pyo3(from_py_with = optional_real)] friction: Option<f64>,
    ) -> PyResult<Self> {
        let is_in_range = [
            (
                "hydroelastic modulus",
                modulus,
                modulus.is_none_or(|value| value > 0.0),
            ),
            ("dissipation", Some(dissipation), dissipation >= 0.0),
            (
                "friction",
                friction,
                friction.is_none_or(|value| value >= 0.0),
            ),
        ];
        for (quantity, value, is_in_range) in is_in_range {
            if let Some(value) = value.filter(|value| !(is_in_range && value.is_finite())) {
                return Err(value_error(format!(
                    "the {quantity} of a material is {value}: a modulus must be positive, dissipation and friction not \
                     negative, and all finite"
                )));
            }
        }
        Ok(Self {
            modulus,
            dissipation,
            friction,
        })
    }

    /// Material of a rigid body, without modulus and dissipation. If friction is None, contacts have the friction of the partner; 0
    /// makes them frictionless.
    #[staticmethod]
    #[pyo3(signature = (friction=None))]
    fn rigid(#[pyo3(from_py_with = optional_real)] friction: Option<f64>) -> PyResult<Self> {
        Self::new(None, 0.0, friction)
    }

    /// The law of two surfaces, as in a world: each dissipation is weighted with the other body's modulus, so a rigid body
    /// dissipates nothing. Friction is the harmonic mean, or the coefficient of one body if the other has none. slip_tolerance in
    /// m/s.
    #[pyo3(signature = (other, slip_tolerance=1e-3))]
    fn combined_with(
        &self,
        other: &Self,
        #[pyo3(from_py_with = real)] slip_tolerance: f64,
    ) -> PyResult<SurfaceLaw> {
        let law = self.inner().combined_with(&other.inner(), slip_tolerance);
        SurfaceLaw::new(law.dissipation(), law.friction(), law.slip_tolerance())
    }

    pub fn __repr__(&self) -> String {
        let Self {
            modulus,
            dissipation,
            friction,
        } = self;
        let [modulus, friction] = [*modulus, *friction].map(modulus_repr);
        format!("Material(modulus={modulus}, dissipation={dissipation:?}, friction={friction})")
    }

    fn __getnewargs__(&self) -> (Option<f64>, f64, Option<f64>) {
        (self.modulus, self.dissipation, self.friction)
    }
}

/// What two surfaces in motion add to the elastic pressure.
///
/// Parameters
/// ----------
/// dissipation : Hunt–Crossley dissipation (s/m), not negative.
/// friction : coefficient of friction, not negative.
/// slip_tolerance : speed (m/s) at which friction has 71 % of its full value, positive.
///
/// Raises
/// ------
/// HydroelasticError if a number is out of range.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct SurfaceLaw {
    /// Hunt–Crossley dissipation (s/m).
    #[pyo3(get)]
    dissipation: f64,
    /// Coefficient of friction.
    #[pyo3(get)]
    friction: f64,
    /// Slip tolerance (m/s).
    #[pyo3(get)]
    slip_tolerance: f64,
}

impl SurfaceLaw {
    /// The law of the library with other numbers: dissipation and friction.
    pub fn inner_with(&self, [dissipation, friction]: [f64; 2]) -> PyResult<contact::SurfaceLaw> {
        contact::SurfaceLaw::new(dissipation, friction, self.slip_tolerance).map_err(value_error)
    }

    /// Dissipation and friction.
    pub fn numbers(&self) -> [f64; 2] {
        [self.dissipation, self.friction]
    }
}

#[pymethods]
impl SurfaceLaw {
    #[new]
    #[pyo3(signature = (dissipation=0.0, friction=0.0, slip_tolerance=1e-3))]
    pub fn new(
        #[pyo3(from_py_with = real)] dissipation: f64,
        #[pyo3(from_py_with = real)] friction: f64,
        #[pyo3(from_py_with = real)] slip_tolerance: f64,
    ) -> PyResult<Self> {
        let law = Self {
            dissipation,
            friction,
            slip_tolerance,
        };
        law.inner_with(law.numbers())?;
        Ok(law)
    }

    pub fn __repr__(&self) -> String {
        let Self {
            dissipation,
            friction,
            slip_tolerance,
        } = self;
        format!(
            "SurfaceLaw(dissipation={dissipation:?}, friction={friction:?}, slip_tolerance={slip_tolerance:?})"
        )
    }

    fn __getnewargs__(&self) -> (f64, f64, f64) {
        (self.dissipation, self.friction, self.slip_tolerance)
    }
}
