//! Joints between bodies.

use crate::arrays::{Floats, array, finite_row, list, named_real, optional_real, parts, real};
use crate::errors::value_error;
use crate::pickle::{Reduced, loaded, reduced};
use crate::poses::{entries, matrix, rotation, single_pose};
use hydroelastic::dynamics::{
    self, Actuator, JointKind, JointLaw, JointState, Schedule, WorldError,
};
use hydroelastic::nalgebra::{Matrix3, Unit, UnitVector3, Vector3};
use pyo3::prelude::*;

/// Compliant stops at the ends of the range of a joint. The force of a stop at the depth d beyond the range is k·d·max(0, 1 + c·ḋ).
///
/// Parameters
/// ----------
/// range : (2,) array_like
///     Smallest and largest position (rad or m).
/// stiffness : float
///     Stiffness k (N m/rad or N/m), at least 0.
/// dissipation : float
///     Dissipation c (s/rad or s/m), at least 0.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is out of range or not finite.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone, Copy, PartialEq)]
pub struct Stops(dynamics::Stops);

/// Checks that a number is finite and in range.
fn check_setting(
    quantity: &'static str,
    value: f64,
    is_in_range: bool,
    expected: &'static str,
) -> PyResult<()> {
    if is_in_range && value.is_finite() {
        return Ok(());
    }
    Err(value_error(WorldError::Setting {
        quantity,
        value,
        expected,
    }))
}

/// Checks the stiffness and the dissipation of stops.
pub fn check_stops(stiffness: f64, dissipation: f64) -> PyResult<()> {
    for (quantity, value) in [
        ("stiffness of stops", stiffness),
        ("dissipation of stops", dissipation),
    ] {
        check_setting(quantity, value, value >= 0.0, "not negative and finite")?;
    }
    Ok(())
}

#[pymethods]
impl Stops {
    #[new]
    #[pyo3(signature = (range, stiffness, dissipation=0.0))]
    fn new(
        range: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = real)] stiffness: f64,
        #[pyo3(from_py_with = real)] dissipation: f64,
    ) -> PyResult<Self> {
        let [low, high] = finite_row(range, "range")?;
        let expected = "at least the smallest position";
        check_setting("largest position", high, high >= low, expected)?;
        check_stops(stiffness, dissipation)?;
        let stops = dynamics::Stops::new([low, high], stiffness, dissipation);
        Ok(Self(stops))
    }

    /// Smallest and largest position (rad or m).
    #[getter]
    fn range(&self) -> (f64, f64) {
        self.0.range.into()
    }

    /// Stiffness (N m/rad or N/m).
    #[getter]
    fn stiffness(&self) -> f64 {
        self.0.stiffness
    }

    /// Dissipation (s/rad or s/m).
    #[getter]
    fn dissipation(&self) -> f64 {
        self.0.dissipation
    }

    fn __repr__(&self) -> String {
        let dynamics::Stops {
            range: [low, high],
            stiffness,
            dissipation,
            ..
        } = self.0;
        format!("Stops(({low:?}, {high:?}), {stiffness:?}, {dissipation:?})")
    }

    fn __getnewargs__(&self) -> ((f64, f64), f64, f64) {
        (self.range(), self.stiffness(), self.dissipation())
    }
}

/// Joint that connects a dynamic body to its parent: another body, or the world.
///
/// The origin of the joint is the pose of the joint frame in the frame of the parent. At position zero, the joint frame coincides with the
/// body frame. A body without a joint is free. Only implicit steps integrate joints.
///
/// Create joints with Joint.revolute, Joint.prismatic, Joint.ball or Joint.fixed, and pass them to Body.dynamic. Units are written for
/// revolute joints. For prismatic joints, replace rad by m, N m by N, and kg m² by kg.
#[pyclass(frozen, eq, module = "hydroelastic")]
#[derive(Clone)]
pub struct Joint(pub dynamics::Joint);

impl PartialEq for Joint {
    fn eq(&self, other: &Self) -> bool {
        let (a, b) = (&self.0, &other.0);
        (a.name(), a.parent(), a.kind()) == (b.name(), b.parent(), b.kind())
            && entries(a.origin()) == entries(b.origin())
            && (a.law(), a.initial_state()) == (b.law(), b.initial_state())
            && numbers_of(a.torques()) == numbers_of(b.torques())
            && (numbers_of(a.targets()), a.mimic()) == (numbers_of(b.targets()), b.mimic())
    }
}

/// Place of a joint: its parent and the pose of the joint frame.
struct Place<'a, 'py> {
    parent: Option<&'a str>,
    origin: Option<&'a Bound<'py, PyAny>>,
}

impl Place<'_, '_> {
    /// Places a joint, and checks its numbers.
    fn applied(self, mut joint: dynamics::Joint) -> PyResult<Joint> {
        if let Some(parent) = self.parent {
            joint = joint.with_parent(parent);
        }
        if let Some(origin) = self.origin {
            joint = joint.with_origin(single_pose(origin, "origin")?);
        }
        joint.check().map_err(value_error)?;
        Ok(Joint(joint))
    }
}

/// Numbers of a revolute or prismatic joint, or None to keep the number of the joint.
#[derive(Default)]
pub struct Numbers {
    pub position: Option<f64>,
    pub velocity: Option<f64>,
    pub armature: Option<f64>,
    pub damping: Option<f64>,
    pub friction: Option<f64>,
    pub slip_tolerance: Option<f64>,
    pub stops: Option<Stops>,
    pub servo_stiffness: Option<f64>,
    pub servo_damping: Option<f64>,
    pub target_position: Option<f64>,
    pub target_velocity: Option<f64>,
    pub torque: Option<f64>,
    pub torque_limit: Option<f64>,
    pub torques: Option<Timed>,
    pub targets: Option<Timed>,
    pub mimic: Option<Leader>,
}

/// Interval (s) and values of a schedule.
pub type Timed = (f64, Vec<f64>);

/// Name of a leader, multiplier and offset.
pub type Leader = (String, f64, f64);

/// Converts an argument to an interval and the values of a schedule, or None.
pub fn timed(argument: &Bound<'_, PyAny>) -> PyResult<Option<Timed>> {
    if argument.is_none() {
        return Ok(None);
    }
    let [interval, values] = parts(argument, "a schedule", "an interval and its values")?;
    let interval = named_real(&interval, "the interval of a schedule")?;
    Ok(Some((interval, list(&values, "values of a schedule")?)))
}

/// Converts an argument to a leader, or None.
fn leader(argument: &Bound<'_, PyAny>) -> PyResult<Option<Leader>> {
    if argument.is_none() {
        return Ok(None);
    }
    let expected = "the name of a leader, a multiplier and an offset";
    let [name, multiplier, offset] = parts(argument, "mimic", expected)?;
    let multiplier = named_real(&multiplier, "the multiplier of mimic")?;
    let offset = named_real(&offset, "the offset of mimic")?;
    Ok(Some((name.extract()?, multiplier, offset)))
}

impl Numbers {
    /// Sets the numbers of a joint.
    pub fn applied(self, mut joint: dynamics::Joint) -> PyResult<dynamics::Joint> {
        let moves = [self.position, self.velocity];
        let moves = moves.into_iter().flatten().any(|number| number != 0.0);
        let leader = self.mimic.as_ref().map(|(leader, ..)| leader.as_str());
        let leader = leader.or(joint.mimic().map(|mimic| mimic.joint.as_str()));
        if let Some(leader) = leader.filter(|_| moves) {
            return Err(mimicking_state(joint.name(), leader));
        }
        let mut law = *joint.law();
        let actuator = &mut law.actuator;
        for (number, change) in [
            (&mut law.armature, self.armature),
            (&mut law.damping, self.damping),
            (&mut law.friction, self.friction),
            (&mut law.slip_tolerance, self.slip_tolerance),
            (&mut actuator.stiffness, self.servo_stiffness),
            (&mut actuator.damping, self.servo_damping),
            (&mut actuator.target_position, self.target_position),
            (&mut actuator.target_velocity, self.target_velocity),
            (&mut actuator.torque, self.torque),
        ] {
            *number = change.unwrap_or(*number);
        }
        actuator.limit = self.torque_limit.or(actuator.limit);
        law.stops = self.stops.map(|stops| stops.0).or(law.stops);
        joint = joint.with_law(law);
        if let Some(position) = self.position {
            joint = joint.with_position(position);
        }
        if let Some(velocity) = self.velocity {
            joint = joint.with_velocity(velocity);
        }
        if let Some((interval, values)) = self.torques {
            joint = joint.with_torques(interval, values);
        }
        if let Some((interval, values)) = self.targets {
            joint = joint.with_targets(interval, values);
        }
        if let Some((leader, multiplier, offset)) = self.mimic {
            joint = joint.with_mimic(&leader, multiplier, offset);
        }
        Ok(joint)
    }
}

/// Creates the exception for the position or velocity of a joint that mimics another joint.
pub fn mimicking_state(name: &str, leader: &str) -> PyErr {
    value_error(format!(
        "joint {name:?} mimics {leader:?}, which gives its position and velocity: leave out position and velocity"
    ))
}

/// Reads the direction of an axis.
pub fn axis_of(argument: &Bound<'_, PyAny>) -> PyResult<UnitVector3<f64>> {
    let axis = Vector3::from(finite_row::<3>(argument, "axis")?);
    // The division prevents an overflow of the square.
    Unit::try_new(axis / axis.amax(), 0.0)
        .ok_or_else(|| value_error("the axis of a joint must not be zero"))
}

impl Joint {
    fn law(&self) -> &JointLaw {
        self.0.law()
    }

    fn actuator(&self) -> &Actuator {
        &self.0.law().actuator
    }

    /// Rotation and angular velocity of a ball joint.
    fn ball_state(&self) -> Option<(&Matrix3<f64>, &Vector3<f64>)> {
        match self.0.initial_state()? {
            JointState::Ball {
                rotation,
                angular_velocity,
            } => Some((rotation, angular_velocity)),
            _ => None,
        }
    }
}

#[pymethods]
impl Joint {
    /// Creates a joint that rotates about an axis.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// axis : (3,) array_like
    ///     Axis in the joint frame, of any length. It goes through the origin of the frame.
    /// parent : str, optional
    ///     Name of the parent body, which must come before the body in the world. Default: the world.
    /// origin : (4, 4) array_like, optional
    ///     Pose of the joint frame in the body frame of the parent, or in the world. Default: the identity.
    /// position, velocity : float
    ///     Initial angle (rad) and its rate (rad/s).
    /// armature : float
    ///     Reflected inertia of the rotor (kg m²).
    /// damping : float
    ///     Viscous damping (N m s/rad).
    /// friction : float
    ///     Coulomb friction (N m). At the velocity u, it is friction·u/√(u² + s²) with the slip tolerance s.
    /// slip_tolerance : float
    ///     Slip tolerance (rad/s) of the friction.
    /// stops : Stops, optional
    ///     Stops at the ends of the range. Default: no limits.
    /// servo_stiffness, servo_damping : float
    ///     Stiffness (N m/rad) and damping (N m s/rad) of the servo of the actuator.
    /// target_position, target_velocity : float
    ///     Target angle (rad) and target velocity (rad/s) of the servo.
    /// torque : float
    ///     Torque (N m) of the actuator in addition to the servo.
    /// torque_limit : float, optional
    ///     Largest magnitude of the torque (N m) of the actuator. Default: no limit.
    /// torques : (float, (k,) array_like), optional
    ///     Interval (s), and torques (N m) that the actuator applies in addition, each during one interval from time 0. During a time
    ///     step, the mean over the step acts. Default: none.
    /// targets : (float, (k,) array_like), optional
    ///     Interval (s), and target positions (rad) at the times 0, interval, 2·interval and so on. Between them the target moves at
    ///     constant velocity, and after the last it rests. They replace target_position and target_velocity. Default: none.
    /// mimic : (str, float, float), optional
    ///     Name of a leader joint, multiplier and offset. The position is multiplier · position of the leader + offset. The joint then has
    ///     no state of its own. Default: the joint moves by itself.
    ///
    /// Returns
    /// -------
    /// Joint
    ///     Revolute joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the axis is zero, the origin is not rigid, or a number is out of range or not finite.
    #[staticmethod]
    #[pyo3(signature = (name, axis, *, parent=None, origin=None, position=0.0, velocity=0.0, armature=0.0, damping=0.0, friction=0.0,
                        slip_tolerance=1e-3, stops=None, servo_stiffness=0.0, servo_damping=0.0, target_position=0.0,
                        target_velocity=0.0, torque=0.0, torque_limit=None, torques=None, targets=None, mimic=None))]
    fn revolute(
        name: &str,
        axis: &Bound<'_, PyAny>,
        parent: Option<&str>,
        origin: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = real)] position: f64,
        #[pyo3(from_py_with = real)] velocity: f64,
        #[pyo3(from_py_with = real)] armature: f64,
        #[pyo3(from_py_with = real)] damping: f64,
        #[pyo3(from_py_with = real)] friction: f64,
        #[pyo3(from_py_with = real)] slip_tolerance: f64,
        stops: Option<PyRef<'_, Stops>>,
        #[pyo3(from_py_with = real)] servo_stiffness: f64,
        #[pyo3(from_py_with = real)] servo_damping: f64,
        #[pyo3(from_py_with = real)] target_position: f64,
        #[pyo3(from_py_with = real)] target_velocity: f64,
        #[pyo3(from_py_with = real)] torque: f64,
        #[pyo3(from_py_with = optional_real)] torque_limit: Option<f64>,
        #[pyo3(from_py_with = timed)] torques: Option<Timed>,
        #[pyo3(from_py_with = timed)] targets: Option<Timed>,
        #[pyo3(from_py_with = leader)] mimic: Option<Leader>,
    ) -> PyResult<Self> {
        let numbers = Numbers {
            position: Some(position),
            velocity: Some(velocity),
            armature: Some(armature),
            damping: Some(damping),
            friction: Some(friction),
            slip_tolerance: Some(slip_tolerance),
            stops: stops.map(|stops| *stops),
            servo_stiffness: Some(servo_stiffness),
            servo_damping: Some(servo_damping),
            target_position: Some(target_position),
            target_velocity: Some(target_velocity),
            torque: Some(torque),
            torque_limit,
            torques,
            targets,
            mimic,
        };
        let joint = dynamics::Joint::revolute(name, axis_of(axis)?);
        Place { parent, origin }.applied(numbers.applied(joint)?)
    }

    /// Creates a joint that slides along an axis.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// axis : (3,) array_like
    ///     Axis in the joint frame, of any length.
    /// parent : str, optional
    ///     Name of the parent body, which must come before the body in the world. Default: the world.
    /// origin : (4, 4) array_like, optional
    ///     Pose of the joint frame in the body frame of the parent, or in the world. Default: the identity.
    /// position, velocity : float
    ///     Initial displacement (m) and its rate (m/s).
    /// armature : float
    ///     Reflected inertia of the drive (kg).
    /// damping : float
    ///     Viscous damping (N s/m).
    /// friction : float
    ///     Coulomb friction (N). At the velocity u, it is friction·u/√(u² + s²) with the slip tolerance s.
    /// slip_tolerance : float
    ///     Slip tolerance (m/s) of the friction.
    /// stops : Stops, optional
    ///     Stops at the ends of the range. Default: no limits.
    /// servo_stiffness, servo_damping : float
    ///     Stiffness (N/m) and damping (N s/m) of the servo of the actuator.
    /// target_position, target_velocity : float
    ///     Target displacement (m) and target velocity (m/s) of the servo.
    /// torque : float
    ///     Force (N) of the actuator in addition to the servo.
    /// torque_limit : float, optional
    ///     Largest magnitude of the force (N) of the actuator. Default: no limit.
    /// torques : (float, (k,) array_like), optional
    ///     Interval (s), and forces (N) that the actuator applies in addition, each during one interval from time 0. During a time
    ///     step, the mean over the step acts. Default: none.
    /// targets : (float, (k,) array_like), optional
    ///     Interval (s), and target positions (m) at the times 0, interval, 2·interval and so on. Between them the target moves at
    ///     constant velocity, and after the last it rests. They replace target_position and target_velocity. Default: none.
    /// mimic : (str, float, float), optional
    ///     Name of a leader joint, multiplier and offset. The position is multiplier · position of the leader + offset. The joint then has
    ///     no state of its own. Default: the joint moves by itself.
    ///
    /// Returns
    /// -------
    /// Joint
    ///     Prismatic joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the axis is zero, the origin is not rigid, or a number is out of range or not finite.
    #[staticmethod]
    #[pyo3(signature = (name, axis, *, parent=None, origin=None, position=0.0, velocity=0.0, armature=0.0, damping=0.0, friction=0.0,
                        slip_tolerance=1e-3, stops=None, servo_stiffness=0.0, servo_damping=0.0, target_position=0.0,
                        target_velocity=0.0, torque=0.0, torque_limit=None, torques=None, targets=None, mimic=None))]
    fn prismatic(
        name: &str,
        axis: &Bound<'_, PyAny>,
        parent: Option<&str>,
        origin: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = real)] position: f64,
        #[pyo3(from_py_with = real)] velocity: f64,
        #[pyo3(from_py_with = real)] armature: f64,
        #[pyo3(from_py_with = real)] damping: f64,
        #[pyo3(from_py_with = real)] friction: f64,
        #[pyo3(from_py_with = real)] slip_tolerance: f64,
        stops: Option<PyRef<'_, Stops>>,
        #[pyo3(from_py_with = real)] servo_stiffness: f64,
        #[pyo3(from_py_with = real)] servo_damping: f64,
        #[pyo3(from_py_with = real)] target_position: f64,
        #[pyo3(from_py_with = real)] target_velocity: f64,
        #[pyo3(from_py_with = real)] torque: f64,
        #[pyo3(from_py_with = optional_real)] torque_limit: Option<f64>,
        #[pyo3(from_py_with = timed)] torques: Option<Timed>,
        #[pyo3(from_py_with = timed)] targets: Option<Timed>,
        #[pyo3(from_py_with = leader)] mimic: Option<Leader>,
    ) -> PyResult<Self> {
        let numbers = Numbers {
            position: Some(position),
            velocity: Some(velocity),
            armature: Some(armature),
            damping: Some(damping),
            friction: Some(friction),
            slip_tolerance: Some(slip_tolerance),
            stops: stops.map(|stops| *stops),
            servo_stiffness: Some(servo_stiffness),
            servo_damping: Some(servo_damping),
            target_position: Some(target_position),
            target_velocity: Some(target_velocity),
            torque: Some(torque),
            torque_limit,
            torques,
            targets,
            mimic,
        };
        let joint = dynamics::Joint::prismatic(name, axis_of(axis)?);
        Place { parent, origin }.applied(numbers.applied(joint)?)
    }

    /// Creates a joint that rotates about all axes. It has no damping, friction, stops or actuator.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// parent : str, optional
    ///     Name of the parent body, which must come before the body in the world. Default: the world.
    /// origin : (4, 4) array_like, optional
    ///     Pose of the joint frame in the body frame of the parent, or in the world. Default: the identity.
    /// rotation : (3, 3) array_like, optional
    ///     Initial rotation from the body frame to the joint frame. Default: the identity.
    /// angular_velocity : (3,) array_like, optional
    ///     Initial angular velocity (rad/s) in the axes of the joint frame. Default: zero.
    /// armature : float
    ///     Reflected inertia of the rotors (kg m²).
    ///
    /// Returns
    /// -------
    /// Joint
    ///     Ball joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the origin is not rigid, the rotation is not orthonormal, or a number is out of range or not finite.
    #[staticmethod]
    #[pyo3(signature = (name, *, parent=None, origin=None, rotation=None, angular_velocity=None, armature=0.0))]
    fn ball(
        name: &str,
        parent: Option<&str>,
        origin: Option<&Bound<'_, PyAny>>,
        rotation: Option<&Bound<'_, PyAny>>,
        angular_velocity: Option<&Bound<'_, PyAny>>,
        #[pyo3(from_py_with = real)] armature: f64,
    ) -> PyResult<Self> {
        let rotation = rotation.map(|argument| self::rotation(argument, "rotation"));
        let spin = angular_velocity.map(|argument| finite_row::<3>(argument, "angular_velocity"));
        let initial = JointState::Ball {
            rotation: rotation.transpose()?.unwrap_or_else(Matrix3::identity),
            angular_velocity: spin.transpose()?.unwrap_or_default().into(),
        };
        let joint = dynamics::Joint::ball(name).with_armature(armature);
        Place { parent, origin }.applied(joint.with_initial_state(initial))
    }

    /// Creates a joint without motion, which welds a body to its parent.
    ///
    /// Parameters
    /// ----------
    /// name : str
    ///     Name, which must be unique in a world.
    /// parent : str, optional
    ///     Name of the parent body, which must come before the body in the world. Default: the world.
    /// origin : (4, 4) array_like, optional
    ///     Pose of the body frame in the body frame of the parent, or in the world. Default: the identity.
    ///
    /// Returns
    /// -------
    /// Joint
    ///     Fixed joint.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the origin is not rigid.
    #[staticmethod]
    #[pyo3(signature = (name, *, parent=None, origin=None))]
    fn fixed(
        name: &str,
        parent: Option<&str>,
        origin: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Place { parent, origin }.applied(dynamics::Joint::fixed(name))
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Kind: "revolute", "prismatic", "ball" or "fixed".
    #[getter]
    pub fn kind(&self) -> &'static str {
        kind_name(self.0.kind())
    }

    /// Unit vector of the axis of a revolute or prismatic joint in the joint frame, (3,) float64; None for other joints.
    #[getter]
    fn axis<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        axis_array(py, self.0.kind())
    }

    /// Name of the parent body; None for the world.
    #[getter]
    fn parent(&self) -> Option<&str> {
        self.0.parent()
    }

    /// Pose of the joint frame in the body frame of the parent, or in the world, (4, 4) float64.
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        matrix(py, self.0.origin())
    }

    /// Initial position (rad) of a revolute or prismatic joint; None for other joints and for joints that mimic.
    #[getter]
    fn position(&self) -> Option<f64> {
        self.0.initial_state()?.position()
    }

    /// Initial velocity (rad/s) of a revolute or prismatic joint; None for other joints and for joints that mimic.
    #[getter]
    fn velocity(&self) -> Option<f64> {
        self.0.initial_state()?.velocity()
    }

    /// Initial rotation of a ball joint from the body frame to the joint frame, (3, 3) float64; None for other joints.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        let rows = |(rotation, _): (&Matrix3<f64>, _)| rotation.transpose().as_slice().to_vec();
        let numbers = self.ball_state().map(rows);
        numbers.map(|rows| array(py, rows, &[3, 3])).transpose()
    }

    /// Initial angular velocity (rad/s) of a ball joint in the axes of the joint frame, (3,) float64; None for other joints.
    #[getter]
    fn angular_velocity<'py>(&self, py: Python<'py>) -> PyResult<Option<Floats<'py>>> {
        let numbers = self.ball_state().map(|(_, spin)| spin.as_slice().to_vec());
        numbers.map(|spin| array(py, spin, &[3])).transpose()
    }

    /// Reflected inertia (kg m²) of the rotor.
    #[getter]
    fn armature(&self) -> f64 {
        self.law().armature
    }

    /// Viscous damping (N m s/rad).
    #[getter]
    fn damping(&self) -> f64 {
        self.law().damping
    }

    /// Coulomb friction (N m).
    #[getter]
    fn friction(&self) -> f64 {
        self.law().friction
    }

    /// Slip tolerance (rad/s) of the friction.
    #[getter]
    fn slip_tolerance(&self) -> f64 {
        self.law().slip_tolerance
    }

    /// Stops; None for a joint without limits.
    #[getter]
    fn stops(&self) -> Option<Stops> {
        self.law().stops.map(Stops)
    }

    /// Stiffness (N m/rad) of the servo.
    #[getter]
    fn servo_stiffness(&self) -> f64 {
        self.actuator().stiffness
    }

    /// Damping (N m s/rad) of the servo.
    #[getter]
    fn servo_damping(&self) -> f64 {
        self.actuator().damping
    }

    /// Target position (rad) of the servo.
    #[getter]
    fn target_position(&self) -> f64 {
        self.actuator().target_position
    }

    /// Target velocity (rad/s) of the servo.
    #[getter]
    fn target_velocity(&self) -> f64 {
        self.actuator().target_velocity
    }

    /// Torque (N m) of the actuator in addition to the servo.
    #[getter]
    fn torque(&self) -> f64 {
        self.actuator().torque
    }

    /// Largest magnitude of the torque (N m) of the actuator; None without a limit.
    #[getter]
    fn torque_limit(&self) -> Option<f64> {
        self.actuator().limit
    }

    /// Interval (s) and values (k,) of the torques (N m) that the actuator applies in addition; None without them.
    #[getter]
    fn torques<'py>(&self, py: Python<'py>) -> PyResult<Option<(f64, Floats<'py>)>> {
        arrays_of(py, self.0.torques())
    }

    /// Interval (s) and values (k,) of the target positions (rad); None without them.
    #[getter]
    fn targets<'py>(&self, py: Python<'py>) -> PyResult<Option<(f64, Floats<'py>)>> {
        arrays_of(py, self.0.targets())
    }

    /// Name of the leader, multiplier and offset (rad); None for a joint that mimics no other joint.
    #[getter]
    fn mimic(&self) -> Option<(String, f64, f64)> {
        let mimic = self.0.mimic()?;
        Some((mimic.joint.clone(), mimic.multiplier, mimic.offset))
    }

    pub fn __repr__(&self) -> String {
        let axis = match self.0.kind() {
            JointKind::Revolute(axis) | JointKind::Prismatic(axis) => {
                format!(", {:?}", axis.as_slice())
            }
            _ => String::new(),
        };
        let parent = self.parent().map(|parent| format!(", parent={parent:?}"));
        let mimic = self.mimic().map(|mimic| format!(", mimic={mimic:?}"));
        let schedule = |name: &str, schedule: Option<&Schedule>| {
            let text = |(interval, values)| format!(", {name}=({interval:?}, {values:?})");
            numbers_of(schedule).map(text).unwrap_or_default()
        };
        let torques = schedule("torques", self.0.torques());
        let targets = schedule("targets", self.0.targets());
        let (kind, name) = (self.kind(), self.name());
        let (parent, mimic) = (parent.unwrap_or_default(), mimic.unwrap_or_default());
        format!("Joint.{kind}({name:?}{axis}{parent}{torques}{targets}{mimic})")
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_joint", &self.0)
    }
}

/// Axis of a revolute or prismatic joint as an array, or None.
pub fn axis_array<'py>(py: Python<'py>, kind: &JointKind) -> PyResult<Option<Floats<'py>>> {
    match kind {
        JointKind::Revolute(axis) | JointKind::Prismatic(axis) => {
            array(py, axis.as_slice().to_vec(), &[3]).map(Some)
        }
        _ => Ok(None),
    }
}

/// Name of a kind of joint.
pub fn kind_name(kind: &JointKind) -> &'static str {
    match kind {
        JointKind::Revolute(_) => "revolute",
        JointKind::Prismatic(_) => "prismatic",
        JointKind::Ball => "ball",
        _ => "fixed",
    }
}

/// Interval and values of a schedule.
fn numbers_of(schedule: Option<&Schedule>) -> Option<(f64, &[f64])> {
    schedule.map(|schedule| (schedule.interval(), schedule.values()))
}

/// Interval and values of a schedule as an array.
fn arrays_of<'py>(
    py: Python<'py>,
    schedule: Option<&Schedule>,
) -> PyResult<Option<(f64, Floats<'py>)>> {
    let Some((interval, values)) = numbers_of(schedule) else {
        return Ok(None);
    };
    let array = array(py, values.to_vec(), &[values.len()])?;
    Ok(Some((interval, array)))
}

/// Restores a joint from a pickle.
#[pyfunction]
pub fn _load_joint(saved: &[u8]) -> PyResult<Joint> {
    loaded(saved).map(Joint)
}
