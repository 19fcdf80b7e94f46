//! Worlds: bodies, forces and the initial state.

use crate::arrays::{Floats, array, name_pairs, optional_real, real, row};
use crate::body::Body;
use crate::control::Control;
use crate::errors::{gradient_error, value_error};
use crate::force::{AnyForce, ForceObject, forces};
use crate::lists::{list_of, optional_list_of};
use crate::loop_joint::LoopJoint;
use crate::mechanism::Mechanism;
use crate::parameter::{Parameter, inner};
use crate::path::Path;
use crate::state::State;
use hydroelastic::dynamics::{self, WorldError};
use hydroelastic::nalgebra::Vector3;
use numpy::PyUntypedArray;
use pyo3::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// World of the library with forces that can be serialized.
pub type Inner = dynamics::World<f64, Vec<AnyForce>>;

/// World: bodies, gravity, forces and controls, with an initial state.
///
/// Worlds are immutable. Methods that change a world return a new world, which shares the shapes.
///
/// Parameters
/// ----------
/// bodies : list of Body
///     Bodies with different names.
/// mechanisms : list of Mechanism, optional
///     Mechanisms, such as robots. Their bodies come after the other bodies. Default: none.
/// loop_joints : list of LoopJoint, optional
///     Joints that close loops of bodies. Default: none.
/// gravity : (3,) array_like or float, optional
///     Gravity (m/s²) in world axes, or its z component, such as -9.81. Default: no gravity.
/// forces : list of Spring, Drag and Thruster, optional
///     Forces. Default: none.
/// force_parameters : dict of str to float, optional
///     Values of the force parameters that forces name. Parameter.force_parameter(name) differentiates with respect to a value.
/// controls : list of Control, optional
///     Controls, at most one for each body. Default: none.
/// ignoring : list of (str, str), optional
///     Names of pairs of bodies that pass through each other. Two bodies that are each a RigidShape or a HalfSpace have no contact, so
///     such a pair must be in this list if one of the bodies is dynamic.
/// slip_tolerance : float, optional
///     Slip tolerance (m/s) of friction in all contacts. Default: 1e-3.
/// start : State, optional
///     Initial state of rollouts, with its time. Default: the initial states of the bodies, at time 0.
///
/// Raises
/// ------
/// HydroelasticError
///     If a name, a number or a state is not valid. The message names the body, force or parameter.
/// TypeError
///     If a force is not a Spring, a Drag or a Thruster.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct World {
    pub inner: Inner,
    /// Paths of kinematic bodies, by name. The library has them as functions only.
    pub paths: Vec<(String, Path)>,
}

/// Settings of a new world, or changes of the settings of a world.
struct Settings<'a, 'py> {
    gravity: Option<Vector3<f64>>,
    forces: Option<Vec<AnyForce>>,
    force_parameters: Option<BTreeMap<String, f64>>,
    controls: Option<Vec<Bound<'py, Control>>>,
    slip_tolerance: Option<f64>,
    start: Option<&'a Bound<'py, State>>,
}

impl Settings<'_, '_> {
    fn applied(self, mut world: Inner) -> PyResult<Inner> {
        if let Some(gravity) = self.gravity {
            world = world.with_gravity(gravity).map_err(value_error)?;
        }
        if let Some(tolerance) = self.slip_tolerance {
            world = world.with_slip_tolerance(tolerance).map_err(value_error)?;
        }
        for (name, value) in self.force_parameters.into_iter().flatten() {
            world = world
                .with_force_parameter(&name, value)
                .map_err(value_error)?;
        }
        if let Some(forces) = self.forces {
            world = world.with_forces(forces).map_err(value_error)?;
        }
        let mut controlled = BTreeSet::new();
        for control in self.controls.into_iter().flatten() {
            let body = control.get().0.body();
            if !controlled.insert(body.to_owned()) {
                return Err(value_error(format!(
                    "body {body:?} has two controls, but must have one at most"
                )));
            }
            world = world
                .with_control(control.get().0.clone())
                .map_err(value_error)?;
        }
        match self.start {
            Some(state) => world
                .with_initial_state(&state.get().0)
                .map_err(value_error),
            None => Ok(world),
        }
    }
}

/// Converts an argument to gravity (m/s²): from a vector, its component along z or None.
pub fn gravity(argument: &Bound<'_, PyAny>) -> PyResult<Option<Vector3<f64>>> {
    if argument.is_none() {
        return Ok(None);
    }
    let is_number = argument.hasattr("__float__")? && argument.cast::<PyUntypedArray>().is_err();
    Ok(Some(if is_number {
        Vector3::new(0.0, 0.0, real(argument)?)
    } else {
        row::<3>(argument, "gravity")?.into()
    }))
}

/// Converts an argument to numbers by name, or None.
fn reals(argument: &Bound<'_, PyAny>) -> PyResult<Option<BTreeMap<String, f64>>> {
    let numbers: Option<BTreeMap<String, Bound<'_, PyAny>>> = argument.extract()?;
    let number = |(name, value)| Ok((name, real(&value)?));
    let numbers = numbers.map(|numbers| numbers.into_iter().map(number).collect());
    numbers.transpose()
}

/// Creates a world without forces.
fn of_bodies(
    bodies: &[Body],
    loop_joints: Vec<dynamics::LoopJoint>,
    start: Option<&Bound<'_, State>>,
    ignoring: &[(String, String)],
) -> Result<Inner, WorldError> {
    let bodies = bodies.iter().map(|body| body.inner.clone());
    let builder = dynamics::World::builder().bodies(bodies);
    let builder = match start {
        Some(state) => builder.initial_state(state.get().0.clone()),
        None => builder,
    };
    let builder = loop_joints
        .into_iter()
        .fold(builder, dynamics::WorldBuilder::loop_joint);
    let ignored = ignoring.iter();
    let builder = ignored.fold(builder, |builder, (first, second)| {
        builder.ignore(first, second)
    });
    builder.build()?.with_forces(Vec::new())
}

impl World {
    /// Names of the bodies.
    pub fn names_of(&self) -> Vec<&str> {
        self.inner
            .bodies()
            .iter()
            .map(dynamics::Body::name)
            .collect()
    }

    /// Creates a world with the same paths from a changed world of the library.
    pub fn with_inner(&self, inner: Inner) -> Self {
        let paths = self.paths.clone();
        Self { inner, paths }
    }
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (bodies, *, mechanisms=None, loop_joints=None, gravity=None, forces=None, force_parameters=None, controls=None, ignoring=None, slip_tolerance=None, start=None))]
    pub fn new(
        #[pyo3(from_py_with = list_of)] bodies: Vec<Bound<'_, Body>>,
        #[pyo3(from_py_with = optional_list_of)] mechanisms: Option<Vec<Bound<'_, Mechanism>>>,
        #[pyo3(from_py_with = optional_list_of)] loop_joints: Option<Vec<Bound<'_, LoopJoint>>>,
        #[pyo3(from_py_with = gravity)] gravity: Option<Vector3<f64>>,
        #[pyo3(from_py_with = forces)] forces: Option<Vec<AnyForce>>,
        #[pyo3(from_py_with = reals)] force_parameters: Option<BTreeMap<String, f64>>,
        #[pyo3(from_py_with = optional_list_of)] controls: Option<Vec<Bound<'_, Control>>>,
        #[pyo3(from_py_with = name_pairs)] ignoring: Option<Vec<(String, String)>>,
        #[pyo3(from_py_with = optional_real)] slip_tolerance: Option<f64>,
        start: Option<&Bound<'_, State>>,
    ) -> PyResult<Self> {
        let mut bodies: Vec<Body> = bodies.iter().map(|body| body.get().clone()).collect();
        let mut ignoring = ignoring.unwrap_or_default();
        for mechanism in mechanisms.iter().flatten() {
            bodies.extend_from_slice(&mechanism.get().bodies);
            ignoring.extend_from_slice(&mechanism.get().ignored);
        }
        let loop_joints = loop_joints.iter().flatten();
        let loop_joints = loop_joints.map(|joint| joint.get().0.clone()).collect();
        let world = of_bodies(&bodies, loop_joints, start, &ignoring).map_err(value_error)?;
        let path = |body: &Body| Some((body.inner.name().to_owned(), body.path.clone()?));
        let paths = bodies.iter().filter_map(path).collect();
        let settings = Settings {
            gravity,
            forces,
            force_parameters,
            controls,
            slip_tolerance,
            start: None,
        };
        Ok(Self {
            inner: settings.applied(world)?,
            paths,
        })
    }

    /// Copies the world with other settings.
    ///
    /// Settings that are None stay the same.
    ///
    /// Parameters
    /// ----------
    /// gravity : (3,) array_like or float, optional
    ///     Gravity (m/s²) in world axes, or its z component.
    /// forces : list of Spring, Drag and Thruster, optional
    ///     Forces, which replace all forces.
    /// force_parameters : dict of str to float, optional
    ///     Values of force parameters. Each replaces the parameter of the same name.
    /// controls : list of Control, optional
    ///     Controls. Each replaces the control of its body.
    /// slip_tolerance : float, optional
    ///     Slip tolerance (m/s) of friction in all contacts.
    /// start : State, optional
    ///     Initial state of rollouts, with its time.
    ///
    /// Returns
    /// -------
    /// World
    ///     Changed copy.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a name, a number or a state is not valid.
    /// TypeError
    ///     If a force is not a Spring, a Drag or a Thruster.
    #[pyo3(signature = (*, gravity=None, forces=None, force_parameters=None, controls=None, slip_tolerance=None, start=None))]
    fn replace(
        &self,
        #[pyo3(from_py_with = gravity)] gravity: Option<Vector3<f64>>,
        #[pyo3(from_py_with = forces)] forces: Option<Vec<AnyForce>>,
        #[pyo3(from_py_with = reals)] force_parameters: Option<BTreeMap<String, f64>>,
        #[pyo3(from_py_with = optional_list_of)] controls: Option<Vec<Bound<'_, Control>>>,
        #[pyo3(from_py_with = optional_real)] slip_tolerance: Option<f64>,
        start: Option<&Bound<'_, State>>,
    ) -> PyResult<Self> {
        let settings = Settings {
            gravity,
            forces,
            force_parameters,
            controls,
            slip_tolerance,
            start,
        };
        Ok(self.with_inner(settings.applied(self.inner.clone())?))
    }

    /// Copies the world with a change added to each number of its parameters.
    ///
    /// Parameters
    /// ----------
    /// parameters : list of Parameter
    ///     Parameters to change, with p components in total.
    /// changes : (p,) array_like
    ///     Changes. The change of an orientation is a rotation vector (rad) in world axes.
    ///
    /// Returns
    /// -------
    /// World
    ///     Changed copy.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world, or a changed number is out of range.
    fn perturbed(
        &self,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        changes: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let changes = crate::arrays::list(changes, "changes")?;
        let changed = self.inner.perturbed(&inner(&parameters), &changes);
        Ok(self.with_inner(changed.map_err(|why| gradient_error(&why))?))
    }

    /// Returns the values of parameters.
    ///
    /// Parameters
    /// ----------
    /// parameters : list of Parameter
    ///     Parameters, with p components in total.
    ///
    /// Returns
    /// -------
    /// (p,) ndarray of float64
    ///     Values. The value of an orientation is a rotation vector (rad) with a length of at most π.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world.
    fn values<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
    ) -> PyResult<Floats<'py>> {
        let values = self.inner.values(&inner(&parameters));
        let values = values.map_err(|why| gradient_error(&why))?;
        array(py, values.as_slice().to_vec(), &[values.len()])
    }

    /// Copies the world with new values of its parameters.
    ///
    /// Derivatives with respect to an orientation are with respect to a small rotation in world axes. Therefore an optimizer of
    /// orientations should use perturbed.
    ///
    /// Parameters
    /// ----------
    /// parameters : list of Parameter
    ///     Parameters to set, with p components in total.
    /// values : (p,) array_like
    ///     New values, in the order of the method values.
    ///
    /// Returns
    /// -------
    /// World
    ///     Changed copy.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If a parameter does not belong to the world or is named twice, or a value is out of range.
    fn with_values(
        &self,
        #[pyo3(from_py_with = list_of)] parameters: Vec<Bound<'_, Parameter>>,
        values: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let values = crate::arrays::list(values, "values")?;
        let world = self.inner.with_values(&inner(&parameters), &values);
        Ok(self.with_inner(world.map_err(|why| gradient_error(&why))?))
    }

    /// Bodies with their current settings, in the order of every state.
    #[getter]
    pub fn bodies(&self) -> Vec<Body> {
        let path = |name: &str| {
            let mut paths = self.paths.iter();
            paths
                .find(|(owner, _)| owner == name)
                .map(|(_, path)| path.clone())
        };
        let bodies = self.inner.bodies().iter();
        bodies
            .map(|body| Body {
                inner: body.clone(),
                path: path(body.name()),
            })
            .collect()
    }

    /// Names of the bodies, in the order of every state.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.names_of()
    }

    /// Returns the index of a body in every state.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// int
    ///     Index, from 0.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the world has no such body.
    fn index_of(&self, name: &str) -> PyResult<usize> {
        self.inner.index_of(name).map_err(value_error)
    }

    /// Gravity (m/s²) in world axes, (3,) float64.
    #[getter]
    fn gravity<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.inner.gravity().as_slice().to_vec(), &[3])
    }

    /// Slip tolerance (m/s) of friction in all contacts.
    #[getter]
    fn slip_tolerance(&self) -> f64 {
        self.inner.slip_tolerance()
    }

    /// Forces, without gravity and contact.
    #[getter]
    fn forces(&self) -> Vec<ForceObject> {
        self.inner.forces().iter().map(ForceObject::from).collect()
    }

    /// Values of the force parameters, by name.
    #[getter]
    fn force_parameters(&self) -> BTreeMap<String, f64> {
        self.inner.force_parameters().iter().cloned().collect()
    }

    /// Controls of bodies.
    #[getter]
    fn controls(&self) -> Vec<Control> {
        self.inner.controls().iter().cloned().map(Control).collect()
    }

    /// Joints that close loops of bodies.
    #[getter]
    fn loop_joints(&self) -> Vec<LoopJoint> {
        self.inner.loop_joints().cloned().map(LoopJoint).collect()
    }

    /// Names of the pairs of bodies that pass through each other.
    #[getter]
    fn ignored(&self) -> Vec<(&str, &str)> {
        let names = self.names_of();
        self.inner
            .ignored()
            .map(|(i, j)| (names[i], names[j]))
            .collect()
    }

    /// Initial state of rollouts.
    #[getter]
    fn initial_state(&self) -> State {
        State(self.inner.initial_state())
    }

    fn __repr__(&self) -> String {
        let gravity = self.inner.gravity();
        let counts = [
            (self.inner.forces().len(), "forces"),
            (self.inner.controls().len(), "controls"),
            (self.inner.loop_joints().count(), "loop joints"),
        ];
        let others = counts.iter().filter(|(count, _)| *count > 0);
        let others: Vec<String> = others
            .map(|(count, noun)| format!(", {count} {noun}"))
            .collect();
        let others = others.concat();
        format!(
            "World({:?}, gravity={:?}{others})",
            self.names_of(),
            gravity.as_slice()
        )
    }
}
