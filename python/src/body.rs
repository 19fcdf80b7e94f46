//! Bodies of a world.

use crate::any_shape::{self, AnyShape};
use crate::arrays::{Floats, Numbers, array, numbers, optional_real, row, wrong_shape};
use crate::errors::value_error;
use crate::material::Material;
use crate::path::Path;
use crate::poses::{matrix, one};
use hydroelastic::dynamics::{self, Mass, WorldError};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use hydroelastic::spatial::MassProperties;
use pyo3::prelude::*;

/// A shape with a name, a material, a motion and a place to start. Made by Body.dynamic, Body.fixed or Body.prescribed.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Body {
    pub inner: dynamics::Body,
    /// Of a prescribed one.
    pub path: Option<Path>,
}

/// The mass of a body from the arguments that tell it.
fn mass_of(
    mass: Option<f64>,
    density: Option<f64>,
    center_of_mass: Option<&Bound<'_, PyAny>>,
    inertia: Option<&Bound<'_, PyAny>>,
) -> PyResult<Mass> {
    match (mass, density, center_of_mass, inertia) {
        (Some(mass), None, None, None) => Ok(Mass::Total(mass)),
        (None, Some(density), None, None) => Ok(Mass::Density(density)),
        (Some(mass), None, Some(center), Some(inertia)) => {
            let Numbers { values, shape } = numbers(inertia, "inertia")?;
            if shape != [3, 3] {
                return Err(wrong_shape("inertia", "(3, 3)", &shape));
            }
            Ok(Mass::Properties(MassProperties {
                mass,
                center_of_mass: row::<3>(center, "center_of_mass")?.into(),
                inertia: Matrix3::from_row_slice(&values),
            }))
        }
        (Some(mass), Some(density), ..) => Err(value_error(format!(
            "a dynamic body has a mass or a density, but both were given, mass={mass:?} kg and density={density:?} kg/m³: leave one out"
        ))),
        _ => Err(value_error(
            "a dynamic body needs its mass, or its density, or mass, center_of_mass and inertia together",
        )),
    }
}

/// Returns the velocity or spin of a body; an error names the body.
fn motion_of(
    body: &str,
    quantity: &'static str,
    argument: &Bound<'_, PyAny>,
) -> PyResult<Vector3<f64>> {
    let vector = row::<3>(argument, quantity)?;
    match vector.iter().find(|value| !value.is_finite()) {
        None => Ok(vector.into()),
        Some(&value) => Err(value_error(WorldError::Velocity {
            body: body.to_owned(),
            quantity,
            value,
        })),
    }
}

#[pymethods]
impl Body {
    /// A body that forces move.
    ///
    /// Parameters
    /// ----------
    /// name : str, unlike those of other bodies.
    /// shape, material : what it is made of: a Shape and a Material with a modulus, or a RigidShape and one without.
    /// mass : total (kg), spread uniformly; or density (kg/m³); or mass with center_of_mass (3,) (m) and inertia (3, 3) (kg m²)
    ///     about it, in the body frame.
    /// pose : (4, 4), where it starts; None for the origin.
    /// velocity : (3,) of the center of mass (m/s), world axes.
    /// angular_velocity : (3,) (rad/s), world axes.
    #[staticmethod]
    #[pyo3(signature = (name, shape, material, mass=None, *, density=None, center_of_mass=None, inertia=None, pose=None,
                        velocity=None, angular_velocity=None))]
    fn dynamic(
        name: &str,
        #[pyo3(from_py_with = any_shape::shape)] shape: AnyShape,
        material: &Material,
        #[pyo3(from_py_with = optional_real)] mass: Option<f64>,
        #[pyo3(from_py_with = optional_real)] density: Option<f64>,
        center_of_mass: Option<&Bound<'_, PyAny>>,
        inertia: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mass = mass_of(mass, density, center_of_mass, inertia)?;
        let shape = shape.inner();
        let mut body =
            dynamics::Body::dynamic(name, shape, material.inner(), mass).map_err(value_error)?;
        if let Some(pose) = pose {
            body = body.with_pose(one(pose, "pose")?);
        }
        if let Some(velocity) = velocity {
            body = body.with_velocity(motion_of(name, "velocity", velocity)?);
        }
        if let Some(spin) = angular_velocity {
            body = body.with_angular_velocity(motion_of(name, "angular_velocity", spin)?);
        }
        Ok(Self {
            inner: body,
            path: None,
        })
    }

    /// A body that never moves: of a Shape, a RigidShape or a HalfSpace. pose: (4, 4); None for the origin.
    #[staticmethod]
    #[pyo3(signature = (name, shape, material, *, pose=None))]
    fn fixed(
        name: &str,
        #[pyo3(from_py_with = any_shape::shape)] shape: AnyShape,
        material: &Material,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let shape = shape.inner();
        let mut body = dynamics::Body::fixed(name, shape, material.inner()).map_err(value_error)?;
        if let Some(pose) = pose {
            body = body.with_pose(one(pose, "pose")?);
        }
        Ok(Self {
            inner: body,
            path: None,
        })
    }

    /// A body that follows a path, whatever pushes it: of a Shape, a RigidShape or a HalfSpace.
    #[staticmethod]
    fn kinematic(
        name: &str,
        #[pyo3(from_py_with = any_shape::shape)] shape: AnyShape,
        material: &Material,
        path: &Path,
    ) -> PyResult<Self> {
        let shape = shape.inner();
        let body = dynamics::Body::kinematic(name, shape, material.inner(), path.function());
        let path = Some(path.clone());
        Ok(Self {
            inner: body.map_err(value_error)?,
            path,
        })
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        self.inner.name()
    }

    /// Shape: a Shape, a RigidShape or a HalfSpace.
    #[getter]
    fn shape(&self) -> PyResult<AnyShape> {
        AnyShape::of(self.inner.shape())
    }

    /// Material.
    #[getter]
    fn material(&self) -> Material {
        self.inner.material().into()
    }

    /// The path that it follows, or None.
    #[getter]
    fn path(&self) -> Option<Path> {
        self.path.clone()
    }

    /// Mass (kg), or None for a body that forces do not move.
    #[getter]
    fn mass(&self) -> Option<f64> {
        self.inner.inertia().map(|inertia| inertia.mass)
    }

    /// (3,) float64: the center of mass (m) in the body frame, or None for a body that forces do not move.
    #[getter]
    fn center_of_mass<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        let inertia = self.inner.inertia();
        inertia
            .map(|it| array(py, it.center_of_mass.as_slice().to_vec(), &[3]))
            .transpose()
    }

    /// (4, 4) float64: the pose it starts from.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        matrix(py, &self.inner.initial_state().pose)
    }

    /// (6,) float64: spin (rad/s) and velocity of the center of mass (m/s) that it starts with, world axes.
    #[getter]
    fn twist<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(
            py,
            self.inner
                .initial_state()
                .twist
                .to_vector()
                .as_slice()
                .to_vec(),
            &[6],
        )
    }

    pub fn __repr__(&self) -> String {
        let kind = match (&self.path, self.mass()) {
            (Some(_), _) => "prescribed".to_owned(),
            (None, Some(mass)) => format!("dynamic, {mass:?} kg"),
            (None, None) => "fixed".to_owned(),
        };
        format!(
            "Body({:?}, {kind}, {})",
            self.name(),
            self.material().__repr__()
        )
    }
}
