//! Mechanisms: bodies that are connected by joints, such as robots.

use crate::arrays::{name_pairs, optional_real};
use crate::body::Body;
use crate::errors::value_error;
use crate::joint::{Joint, Numbers, Stops, Timed, timed};
use crate::lists::list_of;
use crate::world_joints::connecting_joint;
use hydroelastic::dynamics::{self, JointKind};
use pyo3::prelude::*;

/// Bodies that are connected by joints, such as a robot, and the pairs of them that pass through each other.
///
/// Robot.mechanism makes a mechanism from a URDF file. The argument mechanisms of World adds mechanisms to a world.
///
/// Parameters
/// ----------
/// bodies : list of Body
///     Bodies, parents before children.
/// ignoring : list of (str, str), optional
///     Names of pairs of bodies that pass through each other. Default: none.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Mechanism {
    pub bodies: Vec<Body>,
    pub ignored: Vec<(String, String)>,
}

impl Mechanism {
    /// Joints of the bodies that are not free.
    fn connecting(&self) -> impl Iterator<Item = &dynamics::Joint> {
        let bodies = self.bodies.iter();
        bodies.filter_map(|body| connecting_joint(&body.inner))
    }

    /// Sets the stiffness and the damping of the servo of the named joint.
    pub fn with_servo(&self, name: &str, [stiffness, damping]: [f64; 2]) -> PyResult<Self> {
        let numbers = Numbers {
            servo_stiffness: Some(stiffness),
            servo_damping: Some(damping),
            ..Numbers::default()
        };
        self.changed(name, numbers)
    }

    /// Sets numbers of the named joint.
    fn changed(&self, name: &str, numbers: Numbers) -> PyResult<Self> {
        let mut copy = self.clone();
        for body in &mut copy.bodies {
            let joint = connecting_joint(&body.inner).filter(|joint| joint.name() == name);
            let Some(joint) = joint else { continue };
            if !matches!(
                joint.kind(),
                JointKind::Revolute(_) | JointKind::Prismatic(_)
            ) {
                return Err(value_error(format!(
                    "joint {name:?} is neither revolute nor prismatic, so it has no such numbers"
                )));
            }
            let joint = numbers.applied(joint.clone())?;
            joint.check().map_err(value_error)?;
            body.inner = body.inner.clone().with_joint(joint).map_err(value_error)?;
            return Ok(copy);
        }
        Err(value_error(format!(
            "no joint is named {name:?}: the names are {:?}",
            self.joint_names()
        )))
    }
}

#[pymethods]
impl Mechanism {
    #[new]
    #[pyo3(signature = (bodies, *, ignoring=None))]
    fn new(
        #[pyo3(from_py_with = list_of)] bodies: Vec<Bound<'_, Body>>,
        #[pyo3(from_py_with = name_pairs)] ignoring: Option<Vec<(String, String)>>,
    ) -> Self {
        Self {
            bodies: bodies.iter().map(|body| body.get().clone()).collect(),
            ignored: ignoring.unwrap_or_default(),
        }
    }

    /// Copies the mechanism with other settings of a revolute or prismatic joint.
    ///
    /// Settings that are None stay the same.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the joint.
    /// position, velocity : float, optional
    ///     Initial position (rad or m) and velocity (rad/s or m/s).
    /// armature : float, optional
    ///     Reflected inertia (kg m² or kg) of the rotor.
    /// damping : float, optional
    ///     Viscous damping (N m s/rad or N s/m).
    /// friction : float, optional
    ///     Coulomb friction (N m or N).
    /// slip_tolerance : float, optional
    ///     Slip tolerance (rad/s or m/s) of the friction.
    /// stops : Stops, optional
    ///     Stops at the ends of the range.
    /// servo_stiffness, servo_damping : float, optional
    ///     Stiffness (N m/rad or N/m) and damping (N m s/rad or N s/m) of the servo.
    /// target_position, target_velocity : float, optional
    ///     Target position (rad or m) and target velocity (rad/s or m/s) of the servo.
    /// torque : float, optional
    ///     Torque (N m) or force (N) of the actuator in addition to the servo.
    /// torque_limit : float, optional
    ///     Largest magnitude of the torque (N m) or force (N) of the actuator.
    /// torques : (float, (k,) array_like), optional
    ///     Interval (s), and torques (N m) or forces (N), each during one interval.
    /// targets : (float, (k,) array_like), optional
    ///     Interval (s), and target positions (rad or m) at its multiples.
    ///
    /// Returns
    /// -------
    /// Mechanism
    ///     Changed copy.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If no revolute or prismatic joint has this name, or a number is out of range or not finite.
    #[pyo3(signature = (name, *, position=None, velocity=None, armature=None, damping=None, friction=None, slip_tolerance=None, stops=None,
                        servo_stiffness=None, servo_damping=None, target_position=None, target_velocity=None, torque=None,
                        torque_limit=None, torques=None, targets=None))]
    fn with_joint(
        &self,
        name: &str,
        #[pyo3(from_py_with = optional_real)] position: Option<f64>,
        #[pyo3(from_py_with = optional_real)] velocity: Option<f64>,
        #[pyo3(from_py_with = optional_real)] armature: Option<f64>,
        #[pyo3(from_py_with = optional_real)] damping: Option<f64>,
        #[pyo3(from_py_with = optional_real)] friction: Option<f64>,
        #[pyo3(from_py_with = optional_real)] slip_tolerance: Option<f64>,
        stops: Option<PyRef<'_, Stops>>,
        #[pyo3(from_py_with = optional_real)] servo_stiffness: Option<f64>,
        #[pyo3(from_py_with = optional_real)] servo_damping: Option<f64>,
        #[pyo3(from_py_with = optional_real)] target_position: Option<f64>,
        #[pyo3(from_py_with = optional_real)] target_velocity: Option<f64>,
        #[pyo3(from_py_with = optional_real)] torque: Option<f64>,
        #[pyo3(from_py_with = optional_real)] torque_limit: Option<f64>,
        #[pyo3(from_py_with = timed)] torques: Option<Timed>,
        #[pyo3(from_py_with = timed)] targets: Option<Timed>,
    ) -> PyResult<Self> {
        let numbers = Numbers {
            position,
            velocity,
            armature,
            damping,
            friction,
            slip_tolerance,
            stops: stops.map(|stops| *stops),
            servo_stiffness,
            servo_damping,
            target_position,
            target_velocity,
            torque,
            torque_limit,
            torques,
            targets,
            mimic: None,
        };
        self.changed(name, numbers)
    }

    /// Copies the mechanism with another body at its end, for example a tool on a joint.
    ///
    /// Parameters
    /// ----------
    /// body : Body
    ///     Body to add.
    ///
    /// Returns
    /// -------
    /// Mechanism
    ///     Changed copy.
    fn with_body(&self, body: &Body) -> Self {
        let mut copy = self.clone();
        copy.bodies.push(body.clone());
        copy
    }

    /// Bodies, parents before children.
    #[getter]
    fn bodies(&self) -> Vec<Body> {
        self.bodies.clone()
    }

    /// Joints of the bodies, in the order of the bodies. Free bodies have no joint.
    #[getter]
    fn joints(&self) -> Vec<Joint> {
        self.connecting().cloned().map(Joint).collect()
    }

    /// Names of the joints, in the order of the bodies.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.connecting().map(dynamics::Joint::name).collect()
    }

    /// Names of the pairs of bodies that pass through each other.
    #[getter]
    fn ignored(&self) -> Vec<(String, String)> {
        self.ignored.clone()
    }

    fn __repr__(&self) -> String {
        let bodies = self.bodies.iter();
        let names: Vec<&str> = bodies.map(|body| body.inner.name()).collect();
        format!("Mechanism({names:?}, joints={:?})", self.joint_names())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Saved<'py>> {
        let load = py
            .import("hydroelastic._core")?
            .getattr("_load_mechanism")?;
        Ok((load, (self.bodies(), self.ignored())))
    }
}

/// Function that restores a mechanism, and its arguments.
type Saved<'py> = (Bound<'py, PyAny>, (Vec<Body>, Vec<(String, String)>));

/// Restores a mechanism from a pickle.
#[pyfunction]
pub fn _load_mechanism(bodies: Vec<Bound<'_, Body>>, ignored: Vec<(String, String)>) -> Mechanism {
    Mechanism::new(bodies, Some(ignored))
}
