//! Parameters of a rollout that derivatives can be taken with respect to.

use crate::arrays::{Whole, count, optional_whole, whole};
use crate::errors::value_error;
use crate::lists::names;
use crate::pickle::{Reduced, loaded, reduced};
use hydroelastic::gradient::{self, JointQuantity};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use std::sync::Arc;

/// Input of a world that a derivative can be taken with respect to, such as an initial velocity or a modulus.
///
/// Static methods create parameters. A body is given by its name. The world checks the names when the parameter is used.
#[pyclass(frozen, eq, hash, module = "hydroelastic")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct Parameter(pub gradient::Parameter);

/// Quantities of joints.
const JOINT_QUANTITIES: [JointQuantity; 12] = [
    JointQuantity::InitialPosition,
    JointQuantity::InitialVelocity,
    JointQuantity::Torque,
    JointQuantity::TargetPosition,
    JointQuantity::TargetVelocity,
    JointQuantity::ServoStiffness,
    JointQuantity::ServoDamping,
    JointQuantity::Damping,
    JointQuantity::Friction,
    JointQuantity::Armature,
    JointQuantity::InitialOrientation,
    JointQuantity::InitialAngularVelocity,
];

/// Name of a quantity of a joint in Python.
fn name_of(quantity: JointQuantity) -> String {
    match quantity {
        JointQuantity::ScheduledTorque(_) => SCHEDULED[0].to_owned(),
        JointQuantity::ScheduledTarget(_) => SCHEDULED[1].to_owned(),
        quantity => quantity.to_string().replace(' ', "_"),
    }
}

/// Names of quantities that have an index.
const SCHEDULED: [&str; 2] = ["scheduled_torque", "scheduled_target"];

/// Finds a quantity by its name in Python and its index.
fn quantity_of(name: &str, index: Option<usize>) -> PyResult<JointQuantity> {
    match (name, index) {
        ("scheduled_torque", Some(index)) => return Ok(JointQuantity::ScheduledTorque(index)),
        ("scheduled_target", Some(index)) => return Ok(JointQuantity::ScheduledTarget(index)),
        ("scheduled_torque" | "scheduled_target", None) => {
            return Err(value_error(format!("{name} needs the index of a value")));
        }
        _ => {}
    }
    let mut all = JOINT_QUANTITIES.into_iter();
    match (all.find(|known| name_of(*known) == name), index) {
        (Some(quantity), None) => Ok(quantity),
        (Some(_), Some(_)) => Err(value_error(format!("{name} has no index"))),
        (None, _) => Err(value_error(format!(
            "joints have no quantity {name:?}: expected one of {}, {}",
            JOINT_QUANTITIES.map(name_of).join(", "),
            SCHEDULED.join(", ")
        ))),
    }
}

#[pymethods]
impl Parameter {
    /// Initial position (m) of the origin of a body in the world: 3 numbers.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Initial position.
    #[staticmethod]
    fn initial_position(body: &str) -> Self {
        Self(gradient::Parameter::initial_position(body))
    }

    /// Initial orientation of a body: 3 numbers. They are a rotation vector (rad) in world axes, which turns the body about its origin.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Initial orientation.
    #[staticmethod]
    fn initial_orientation(body: &str) -> Self {
        Self(gradient::Parameter::initial_orientation(body))
    }

    /// Initial velocity (m/s) of the center of mass of a body, in world axes: 3 numbers.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Initial velocity.
    #[staticmethod]
    fn initial_velocity(body: &str) -> Self {
        Self(gradient::Parameter::initial_velocity(body))
    }

    /// Initial angular velocity (rad/s) of a body, in world axes: 3 numbers.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Initial angular velocity.
    #[staticmethod]
    fn initial_angular_velocity(body: &str) -> Self {
        Self(gradient::Parameter::initial_angular_velocity(body))
    }

    /// Hydroelastic modulus (Pa) of a body that is not rigid: 1 number.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Modulus.
    #[staticmethod]
    fn modulus(body: &str) -> Self {
        Self(gradient::Parameter::modulus(body))
    }

    /// Dissipation (s/m) of a body: 1 number.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Dissipation.
    #[staticmethod]
    fn dissipation(body: &str) -> Self {
        Self(gradient::Parameter::dissipation(body))
    }

    /// Friction coefficient of a body: 1 number.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Friction coefficient.
    #[staticmethod]
    fn friction(body: &str) -> Self {
        Self(gradient::Parameter::friction(body))
    }

    /// Mass (kg) of a body, which scales the inertia of the body: 1 number.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Mass.
    #[staticmethod]
    fn mass(body: &str) -> Self {
        Self(gradient::Parameter::mass(body))
    }

    /// Radius of gyration (m) of a body about its center of mass: 1 number.
    ///
    /// It is the square root of the mean principal moment of inertia divided by the mass. The mass and the ratios of the moments stay
    /// constant.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Radius of gyration.
    #[staticmethod]
    fn radius_of_gyration(body: &str) -> Self {
        Self(gradient::Parameter::radius_of_gyration(body))
    }

    /// Gravity (m/s²) in world axes: 3 numbers.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Gravity.
    #[staticmethod]
    fn gravity() -> Self {
        Self(gradient::Parameter::Gravity)
    }

    /// Wrench of one interval of the control of a body: 6 numbers.
    ///
    /// Parameters
    /// ----------
    /// body : str
    ///     Name of the body.
    /// interval : int
    ///     Index of the interval, from 0.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Torque (N m) and force (N) of the interval.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the interval is negative.
    #[staticmethod]
    fn control(body: &str, #[pyo3(from_py_with = whole)] interval: Whole) -> PyResult<Self> {
        let interval = count(interval, "interval")?;
        Ok(Self(gradient::Parameter::control(body, interval)))
    }

    /// Wrenches of the first intervals of the controls of several bodies.
    ///
    /// Parameters
    /// ----------
    /// bodies : list of str
    ///     Names of the bodies.
    /// intervals : int
    ///     Number of intervals.
    ///
    /// Returns
    /// -------
    /// list of Parameter
    ///     Parameters. Their components have the order of an array of the shape (intervals, len(bodies), 6).
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the number of intervals is negative.
    /// MemoryError
    ///     If the list is too long.
    #[staticmethod]
    fn controls(
        #[pyo3(from_py_with = names)] bodies: Vec<String>,
        #[pyo3(from_py_with = whole)] intervals: Whole,
    ) -> PyResult<Vec<Self>> {
        let intervals = count(intervals, "intervals")?;
        let mut all = Vec::new();
        let size = intervals.saturating_mul(bodies.len());
        all.try_reserve_exact(size)
            .map_err(|_| PyMemoryError::new_err(format!("{size} parameters")))?;
        let bodies: Vec<Arc<str>> = bodies.into_iter().map(Into::into).collect();
        let of_interval = |interval| {
            let control =
                move |body: &Arc<str>| gradient::Parameter::Control(Arc::clone(body), interval);
            bodies.iter().map(control).map(Self)
        };
        all.extend((0..intervals).flat_map(of_interval));
        Ok(all)
    }

    /// Force parameter of the world with a name: 1 number. See World.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name of the force parameter.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Value of the force parameter.
    #[staticmethod]
    fn force_parameter(name: &str) -> Self {
        Self(gradient::Parameter::force_parameter(name))
    }

    /// Quantity of a joint: 1 number, or 3 numbers for a ball joint.
    ///
    /// Parameters
    /// ----------
    /// joint : str
    ///     Name of the joint.
    /// quantity : str
    ///     For a revolute or prismatic joint, one of these: "initial_position" (rad or m), "initial_velocity" (rad/s or m/s), "torque"
    ///     (N m or N), "target_position" (rad or m), "target_velocity" (rad/s or m/s), "servo_stiffness" (N m/rad or N/m),
    ///     "servo_damping" and "damping" (N m s/rad or N s/m), "friction" (N m or N), "armature" (kg m² or kg). For a ball joint,
    ///     "initial_orientation" (rotation vector in rad) or "initial_angular_velocity" (rad/s), in the axes of the joint frame. With an
    ///     index, "scheduled_torque" (N m or N) or "scheduled_target" (rad or m): a value of Joint.torques or Joint.targets.
    /// index : int, optional
    ///     Index of a scheduled value, from 0.
    ///
    /// Returns
    /// -------
    /// Parameter
    ///     Quantity of the joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If there is no such quantity, or an index is missing, negative or not expected.
    #[staticmethod]
    #[pyo3(signature = (joint, quantity, index=None))]
    fn joint(
        joint: &str,
        quantity: &str,
        #[pyo3(from_py_with = optional_whole)] index: Option<Whole>,
    ) -> PyResult<Self> {
        let index = index.map(|index| count(index, "index")).transpose()?;
        let quantity = quantity_of(quantity, index)?;
        Ok(Self(gradient::Parameter::joint(joint, quantity)))
    }

    /// Number of components.
    #[getter]
    fn dimension(&self) -> usize {
        self.0.dimension()
    }

    /// Name of the body; None for a parameter that belongs to no body.
    #[getter]
    fn body(&self) -> Option<&str> {
        self.0.body()
    }

    fn __repr__(&self) -> String {
        use gradient::Parameter as P;
        let call = match &self.0 {
            P::InitialPosition(body) => format!("initial_position({body:?})"),
            P::InitialOrientation(body) => format!("initial_orientation({body:?})"),
            P::InitialVelocity(body) => format!("initial_velocity({body:?})"),
            P::InitialAngularVelocity(body) => format!("initial_angular_velocity({body:?})"),
            P::Modulus(body) => format!("modulus({body:?})"),
            P::Dissipation(body) => format!("dissipation({body:?})"),
            P::Friction(body) => format!("friction({body:?})"),
            P::Mass(body) => format!("mass({body:?})"),
            P::RadiusOfGyration(body) => format!("radius_of_gyration({body:?})"),
            P::Gravity => "gravity()".to_owned(),
            P::Control(body, interval) => format!("control({body:?}, {interval})"),
            P::ForceParameter(name) => format!("force_parameter({name:?})"),
            P::Joint(joint, quantity) => {
                let index = match quantity {
                    JointQuantity::ScheduledTorque(index)
                    | JointQuantity::ScheduledTarget(index) => format!(", {index}"),
                    _ => String::new(),
                };
                format!("joint({joint:?}, {:?}{index})", name_of(*quantity))
            }
            // All other parameters have no constructor in Python.
            parameter => format!("{parameter:?}"),
        };
        format!("Parameter.{call}")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_parameter", &self.0)
    }
}

/// Restores a parameter from a pickle.
#[pyfunction]
pub fn _load_parameter(saved: &[u8]) -> PyResult<Parameter> {
    Ok(Parameter(loaded(saved)?))
}

/// Converts a list to parameters of the library.
pub fn inner(parameters: &[Bound<'_, Parameter>]) -> Vec<gradient::Parameter> {
    parameters
        .iter()
        .map(|parameter| parameter.get().0.clone())
        .collect()
}
