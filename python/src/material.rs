//! Materials of bodies and surface laws of pairs.

use crate::arrays::{optional_real, real};
use crate::errors::value_error;
use hydroelastic::{contact, dynamics};
use pyo3::prelude::*;

/// Contact material of a body.
///
/// Parameters
/// ----------
/// modulus : float or None
///     Hydroelastic modulus (Pa), positive. None for a RigidShape, or for a HalfSpace without a layer.
/// dissipation : float
///     Hunt–Crossley dissipation (s/m), at least 0. The dissipation of a rigid body has no effect.
/// friction : float or None
///     Friction coefficient, at least 0. With None, each contact uses the coefficient of the other body.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is out of range or not finite.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Material {
    /// Hydroelastic modulus (Pa); None for a rigid body.
    #[pyo3(get)]
    modulus: Option<f64>,
    /// Hunt–Crossley dissipation (s/m).
    #[pyo3(get)]
    dissipation: f64,
    /// Friction coefficient. With None, each contact uses the coefficient of the other body.
    #[pyo3(get)]
    friction: Option<f64>,
}

impl Material {
    /// Converts to the material of the library.
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

/// Formats a modulus as a Python expression.
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

    /// Creates the material of a rigid body, without modulus and dissipation.
    ///
    /// Parameters
    /// ----------
    /// friction : float, optional
    ///     Friction coefficient, at least 0. With None, the default, each contact uses the coefficient of the other body. With 0,
    ///     contacts are frictionless.
    ///
    /// Returns
    /// -------
    /// Material
    ///     Material without a modulus.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the friction coefficient is out of range or not finite.
    #[staticmethod]
    #[pyo3(signature = (friction=None))]
    fn rigid(#[pyo3(from_py_with = optional_real)] friction: Option<f64>) -> PyResult<Self> {
        Self::new(None, 0.0, friction)
    }

    /// Combines two materials to the surface law of their contact, as a world does.
    ///
    /// Each dissipation is weighted with the modulus of the other body, so a rigid body dissipates nothing. The friction coefficient is
    /// the harmonic mean, or the coefficient of one body if the coefficient of the other body is None.
    ///
    /// Parameters
    /// ----------
    /// other : Material
    ///     Material of the other body.
    /// slip_tolerance : float
    ///     Slip tolerance (m/s).
    ///
    /// Returns
    /// -------
    /// SurfaceLaw
    ///     Law of the contact.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the slip tolerance is not positive and finite.
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

/// Dissipation and friction of the contact between two moving surfaces. They add to the elastic pressure.
///
/// Parameters
/// ----------
/// dissipation : float
///     Hunt–Crossley dissipation (s/m), at least 0.
/// friction : float
///     Friction coefficient, at least 0.
/// slip_tolerance : float
///     Slip speed (m/s) at which friction has 71 % of its full value, positive.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is out of range or not finite.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct SurfaceLaw {
    /// Hunt–Crossley dissipation (s/m).
    #[pyo3(get)]
    dissipation: f64,
    /// Friction coefficient.
    #[pyo3(get)]
    friction: f64,
    /// Slip tolerance (m/s).
    #[pyo3(get)]
    slip_tolerance: f64,
}

impl SurfaceLaw {
    /// Converts to the law of the library, with another dissipation and friction.
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
