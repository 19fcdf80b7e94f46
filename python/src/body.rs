//! Bodies of a world.

use crate::any_shape::{self, AnyShape};
use crate::arrays::{Floats, Numbers, array, numbers, optional_real, row, wrong_shape};
use crate::errors::value_error;
use crate::joint::Joint;
use crate::material::Material;
use crate::path::Path;
use crate::poses::{matrix, single_pose};
use crate::world_joints::connecting_joint;
use hydroelastic::dynamics::{self, BodyShape, Mass, WorldError};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use hydroelastic::spatial::MassProperties;
use pyo3::prelude::*;

/// Body of a world: a shape with a name, a material, a kind of motion and an initial state.
///
/// Create bodies with Body.dynamic, Body.fixed or Body.kinematic.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Body {
    pub inner: dynamics::Body,
    /// Path of a kinematic body.
    pub path: Option<Path>,
}

/// Reads the mass of a body from the arguments of `Body.dynamic`.
fn mass_of(
    has_shape: bool,
    mass: Option<f64>,
    density: Option<f64>,
    center_of_mass: Option<&Bound<'_, PyAny>>,
    inertia: Option<&Bound<'_, PyAny>>,
) -> PyResult<Mass> {
    match (mass, density, center_of_mass, inertia) {
        (Some(mass), None, _, _) if !has_shape => link_mass(mass, center_of_mass, inertia),
        (Some(mass), None, None, None) => Ok(Mass::Total(mass)),
        (None, Some(density), None, None) if has_shape => Ok(Mass::Density(density)),
        (Some(mass), None, Some(center), Some(inertia)) => Ok(Mass::Properties(MassProperties {
            mass,
            center_of_mass: row::<3>(center, "center_of_mass")?.into(),
            inertia: inertia_of(inertia)?,
        })),
        (Some(mass), Some(density), ..) => Err(value_error(format!(
            "a dynamic body has a mass or a density, but both were given, mass={mass:?} kg and density={density:?} kg/m³: leave one out"
        ))),
        (None, Some(_), ..) if !has_shape => Err(value_error(
            "a body without a shape has no volume: give mass, center_of_mass and inertia in place of density",
        )),
        _ => Err(value_error(
            "a dynamic body needs its mass, or its density, or mass, center_of_mass and inertia together",
        )),
    }
}

/// Reads the mass of a body without a shape. Center of mass and inertia are zero by default.
fn link_mass(
    mass: f64,
    center_of_mass: Option<&Bound<'_, PyAny>>,
    inertia: Option<&Bound<'_, PyAny>>,
) -> PyResult<Mass> {
    let center = center_of_mass.map(|center| row::<3>(center, "center_of_mass"));
    let inertia = inertia.map(inertia_of).transpose()?;
    Ok(Mass::Link(MassProperties {
        mass,
        center_of_mass: center.transpose()?.unwrap_or_default().into(),
        inertia: inertia.unwrap_or_else(Matrix3::zeros),
    }))
}

/// Reads an inertia.
fn inertia_of(argument: &Bound<'_, PyAny>) -> PyResult<Matrix3<f64>> {
    let Numbers { values, shape } = numbers(argument, "inertia")?;
    if shape != [3, 3] {
        return Err(wrong_shape("inertia", "(3, 3)", &shape));
    }
    Ok(Matrix3::from_row_slice(&values))
}

/// Shape and material of the library. Only a body without a shape may have no material.
fn surface_of(
    body: &str,
    shape: Option<&AnyShape>,
    material: Option<&Material>,
) -> PyResult<(BodyShape, dynamics::Material)> {
    match (shape, material) {
        (None, _) => Ok((BodyShape::None, dynamics::Material::rigid())),
        (Some(shape), Some(material)) => Ok((shape.inner(), material.inner())),
        (Some(_), None) => Err(value_error(format!(
            "body {body:?} has a shape but no material: pass a Material"
        ))),
    }
}

/// Reads the velocity or angular velocity of a body. An error names the body.
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
    /// Creates a body that forces move.
    ///
    /// The mass properties follow from one of these: mass alone, which is distributed uniformly; density alone; or mass,
    /// center_of_mass and inertia together. Without a shape, center_of_mass and inertia are zero by default, and the mass may be zero if
    /// the body is on a joint and each joint moves inertia.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// shape : Shape or RigidShape or None
    ///     Shape in the body frame. None for a body without a shape, such as a link of a robot.
    /// material : Material, optional
    ///     Material, with a modulus for a Shape and without a modulus for a RigidShape. A body without a shape needs no material.
    /// mass : float, optional
    ///     Total mass (kg).
    /// density : float, optional
    ///     Density (kg/m³).
    /// center_of_mass : (3,) array_like, optional
    ///     Center of mass (m) in the body frame.
    /// inertia : (3, 3) array_like, optional
    ///     Inertia (kg m²) about the center of mass, in the axes of the body frame.
    /// pose : (4, 4) array_like, optional
    ///     Initial pose of the body frame in the world. Default: the identity.
    /// velocity : (3,) array_like, optional
    ///     Initial velocity (m/s) of the center of mass, in world axes. Default: zero.
    /// angular_velocity : (3,) array_like, optional
    ///     Initial angular velocity (rad/s), in world axes. Default: zero.
    /// joint : Joint, optional
    ///     Joint to the parent of the body. The joint gives the pose and the velocity of the body. Default: the body is free.
    ///
    /// Returns
    /// -------
    /// Body
    ///     Dynamic body.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the mass properties are missing, contradictory or out of range, the material does not fit the shape, the shape is a
    ///     HalfSpace, the pose is not rigid, a number is not finite, or a pose or velocity is given together with a joint.
    #[staticmethod]
    #[pyo3(signature = (name, shape, material=None, mass=None, *, density=None, center_of_mass=None, inertia=None, pose=None,
                        velocity=None, angular_velocity=None, joint=None))]
    fn dynamic(
        name: &str,
        #[pyo3(from_py_with = any_shape::optional_shape)] shape: Option<AnyShape>,
        material: Option<PyRef<'_, Material>>,
        #[pyo3(from_py_with = optional_real)] mass: Option<f64>,
        #[pyo3(from_py_with = optional_real)] density: Option<f64>,
        center_of_mass: Option<&Bound<'_, PyAny>>,
        inertia: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        velocity: Option<&Bound<'_, PyAny>>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        joint: Option<PyRef<'_, Joint>>,
    ) -> PyResult<Self> {
        let mass = mass_of(shape.is_some(), mass, density, center_of_mass, inertia)?;
        let (shape, material) = surface_of(name, shape.as_ref(), material.as_deref())?;
        let mut body = dynamics::Body::dynamic(name, shape, material, mass).map_err(value_error)?;
        if let Some(joint) = joint {
            if pose.is_some() || velocity.is_some() || angular_velocity.is_some() {
                return Err(value_error(format!(
                    "body {name:?} is on a joint, which gives its pose and velocity: leave out pose, velocity and angular_velocity"
                )));
            }
            body = body.with_joint(joint.0.clone()).map_err(value_error)?;
        }
        if let Some(pose) = pose {
            body = body.with_pose(single_pose(pose, "pose")?);
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

    /// Creates a body that never moves.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// shape : Shape, RigidShape, HalfSpace or None
    ///     Shape in the body frame. None for a body without a shape.
    /// material : Material, optional
    ///     Material, with a modulus exactly if the shape is not rigid. A body without a shape needs no material.
    /// pose : (4, 4) array_like, optional
    ///     Pose of the body frame in the world. Default: the identity.
    ///
    /// Returns
    /// -------
    /// Body
    ///     Fixed body.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the material does not fit the shape, or the pose is not rigid.
    #[staticmethod]
    #[pyo3(signature = (name, shape, material=None, *, pose=None))]
    fn fixed(
        name: &str,
        #[pyo3(from_py_with = any_shape::optional_shape)] shape: Option<AnyShape>,
        material: Option<PyRef<'_, Material>>,
        pose: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (shape, material) = surface_of(name, shape.as_ref(), material.as_deref())?;
        let mut body = dynamics::Body::fixed(name, shape, material).map_err(value_error)?;
        if let Some(pose) = pose {
            body = body.with_pose(single_pose(pose, "pose")?);
        }
        Ok(Self {
            inner: body,
            path: None,
        })
    }

    /// Creates a body that follows a path. No force changes its motion.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// shape : Shape, RigidShape or HalfSpace
    ///     Shape in the body frame.
    /// material : Material
    ///     Material, with a modulus exactly if the shape is not rigid.
    /// path : Path
    ///     Pose and twist as functions of time.
    ///
    /// Returns
    /// -------
    /// Body
    ///     Kinematic body.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the material does not fit the shape.
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

    /// Shape, which is a Shape, a RigidShape or a HalfSpace; None for a body without a shape.
    #[getter]
    fn shape(&self) -> PyResult<Option<AnyShape>> {
        AnyShape::of(self.inner.shape())
    }

    /// Material.
    #[getter]
    fn material(&self) -> Material {
        self.inner.material().into()
    }

    /// Path of a kinematic body; None for other bodies.
    #[getter]
    fn path(&self) -> Option<Path> {
        self.path.clone()
    }

    /// Joint to the parent of the body; None for a body that is free or not dynamic.
    #[getter]
    fn joint(&self) -> Option<Joint> {
        connecting_joint(&self.inner).cloned().map(Joint)
    }

    /// Mass (kg) of a dynamic body; None for other bodies.
    #[getter]
    fn mass(&self) -> Option<f64> {
        self.inner.inertia().map(|inertia| inertia.mass)
    }

    /// Center of mass (m) of a dynamic body in the body frame, (3,) float64; None for other bodies.
    #[getter]
    fn center_of_mass<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        let inertia = self.inner.inertia();
        inertia
            .map(|properties| array(py, properties.center_of_mass.as_slice().to_vec(), &[3]))
            .transpose()
    }

    /// Initial pose of the body frame in the world, (4, 4) float64. For a body on a joint, use World.initial_state.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        matrix(py, &self.inner.initial_state().pose)
    }

    /// Initial angular velocity (rad/s) and velocity of the center of mass (m/s), in world axes, (6,) float64. For a body on a joint, use
    /// World.initial_state.
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
            (Some(_), _) => "kinematic".to_owned(),
            (None, Some(mass)) => format!("dynamic, {mass:?} kg"),
            (None, None) => "fixed".to_owned(),
        };
        let joint = self.joint().map(|joint| format!(", {}", joint.__repr__()));
        format!(
            "Body({:?}, {kind}, {}{})",
            self.name(),
            self.material().__repr__(),
            joint.unwrap_or_default()
        )
    }
}
