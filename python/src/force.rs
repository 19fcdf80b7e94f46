//! Forces other than contact and gravity.

use crate::arrays::{Floats, array, finite_row, real};
use crate::errors::value_error;
use hydroelastic::dynamics::{
    self, Body, Force, ForceContext, ForceNumber, WorldError, WrenchAccumulator,
};
use hydroelastic::scalar::Scalar;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyString;
use serde::{Deserialize, Serialize};

/// Force of a world.
#[derive(Clone, Serialize, Deserialize)]
pub enum AnyForce {
    Spring(dynamics::Spring),
    Drag(dynamics::Drag),
    Thruster(dynamics::Thruster),
}

impl Force for AnyForce {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        match self {
            Self::Spring(force) => force.add_to(wrenches, now),
            Self::Drag(force) => force.add_to(wrenches, now),
            Self::Thruster(force) => force.add_to(wrenches, now),
        }
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        match self {
            Self::Spring(force) => force.coupling_groups(bodies),
            Self::Drag(force) => force.coupling_groups(bodies),
            Self::Thruster(force) => force.coupling_groups(bodies),
        }
    }

    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        match self {
            Self::Spring(force) => force.check(bodies, parameters),
            Self::Drag(force) => force.check(bodies, parameters),
            Self::Thruster(force) => force.check(bodies, parameters),
        }
    }
}

/// Number of a force: a value, or the name of a force parameter.
#[derive(IntoPyObject)]
pub enum Number {
    Value(f64),
    Name(String),
}

impl Number {
    /// Converts to the library's type. Returns an error if a value is negative or not finite.
    fn not_negative(self, quantity: &'static str) -> PyResult<ForceNumber> {
        match self {
            Self::Value(value) if value >= 0.0 && value.is_finite() => {
                Ok(ForceNumber::Constant(value))
            }
            Self::Value(value) => Err(value_error(WorldError::Setting {
                quantity,
                value,
                expected: "not negative and finite",
            })),
            Self::Name(name) => Ok(ForceNumber::Parameter(name)),
        }
    }

    fn of(number: &ForceNumber) -> Self {
        match number {
            ForceNumber::Constant(value) => Self::Value(*value),
            ForceNumber::Parameter(name) => Self::Name(name.clone()),
        }
    }
}

/// Formats a number of a force as a Python expression.
fn shown(number: &ForceNumber) -> String {
    match number {
        ForceNumber::Constant(value) => format!("{value:?}"),
        ForceNumber::Parameter(name) => format!("{name:?}"),
    }
}

/// Converts an argument to a number of a force.
fn number(argument: &Bound<'_, PyAny>) -> PyResult<Number> {
    match argument.cast::<PyString>() {
        Ok(name) => Ok(Number::Name(name.to_string())),
        Err(_) => real(argument).map(Number::Value),
    }
}

/// Converts an argument to a list of forces, or None.
pub fn forces(argument: &Bound<'_, PyAny>) -> PyResult<Option<Vec<AnyForce>>> {
    if argument.is_none() {
        return Ok(None);
    }
    let forces = argument.try_iter()?.map(|force| of_class(&force?));
    forces.collect::<PyResult<_>>().map(Some)
}

fn of_class(force: &Bound<'_, PyAny>) -> PyResult<AnyForce> {
    if let Ok(spring) = force.cast::<Spring>() {
        return Ok(AnyForce::Spring(spring.get().0.clone()));
    }
    if let Ok(drag) = force.cast::<Drag>() {
        return Ok(AnyForce::Drag(drag.get().0.clone()));
    }
    match force.cast::<Thruster>() {
        Ok(thruster) => Ok(AnyForce::Thruster(thruster.get().0.clone())),
        Err(_) => Err(PyTypeError::new_err(format!(
            "a force must be a Spring, a Drag or a Thruster, but is {}",
            force.repr()?
        ))),
    }
}

/// Force as a Python object.
#[derive(IntoPyObject)]
pub enum ForceObject {
    Spring(Spring),
    Drag(Drag),
    Thruster(Thruster),
}

impl From<&AnyForce> for ForceObject {
    fn from(force: &AnyForce) -> Self {
        match force {
            AnyForce::Spring(spring) => Self::Spring(Spring(spring.clone())),
            AnyForce::Drag(drag) => Self::Drag(Drag(drag.clone())),
            AnyForce::Thruster(thruster) => Self::Thruster(Thruster(thruster.clone())),
        }
    }
}

/// Spring and damper between two points of two bodies, along the line through the points.
///
/// The rest length, stiffness and damping are numbers, or names of force parameters of the world. The world checks the names.
///
/// Parameters
/// ----------
/// bodies : pair of str
///     Names of the bodies.
/// points : pair of (3,) array_like
///     Point (m) of each body, in its body frame.
/// rest_length : float or str
///     Length (m) at which the spring exerts no force.
/// stiffness : float or str
///     Stiffness (N/m).
/// damping : float or str
///     Damping (N s/m).
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is negative or not finite.
/// TypeError
///     If bodies is not two names, or points is not two points.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Spring(dynamics::Spring);

#[pymethods]
impl Spring {
    #[new]
    #[pyo3(
        signature = (bodies, points, rest_length, stiffness, damping=Number::Value(0.0)),
        text_signature = "(bodies, points, rest_length, stiffness, damping=0.0)"
    )]
    fn new(
        bodies: &Bound<'_, PyAny>,
        points: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = number)] rest_length: Number,
        #[pyo3(from_py_with = number)] stiffness: Number,
        #[pyo3(from_py_with = number)] damping: Number,
    ) -> PyResult<Self> {
        let names = two(bodies, "bodies", "the names of two bodies")?;
        let points = two(points, "points", "a point (3,) of each body")?;
        let name = |name: &Bound<'_, PyAny>| {
            name.extract::<String>()
                .map_err(|_| not_two(bodies, "bodies", "the names of two bodies"))
        };
        Ok(Self(dynamics::Spring {
            bodies: [name(&names[0])?, name(&names[1])?],
            points: [
                finite_row(&points[0], "points[0]")?,
                finite_row(&points[1], "points[1]")?,
            ],
            rest_length: rest_length.not_negative("rest length of a spring")?,
            stiffness: stiffness.not_negative("stiffness of a spring")?,
            damping: damping.not_negative("damping of a spring")?,
        }))
    }

    /// Names of the bodies.
    #[getter]
    fn bodies(&self) -> (String, String) {
        self.0.bodies.clone().into()
    }

    /// Point (m) of each body in its body frame, two arrays (3,) of float64.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let [a, b] = self.0.points.map(|point| array(py, point.to_vec(), &[3]));
        Ok((a?, b?))
    }

    /// Length (m) at which the spring exerts no force, or the name of a force parameter.
    #[getter]
    fn rest_length(&self) -> Number {
        Number::of(&self.0.rest_length)
    }

    /// Stiffness (N/m), or the name of a force parameter.
    #[getter]
    fn stiffness(&self) -> Number {
        Number::of(&self.0.stiffness)
    }

    /// Damping (N s/m), or the name of a force parameter.
    #[getter]
    fn damping(&self) -> Number {
        Number::of(&self.0.damping)
    }

    fn __repr__(&self) -> String {
        let dynamics::Spring {
            bodies: [a, b],
            rest_length,
            stiffness,
            damping,
            ..
        } = &self.0;
        let [rest_length, stiffness, damping] = [rest_length, stiffness, damping].map(shown);
        format!(
            "Spring({a:?} to {b:?}, rest_length={rest_length}, stiffness={stiffness}, damping={damping})"
        )
    }

    fn __getnewargs__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        (String, String),
        (Floats<'py>, Floats<'py>),
        Number,
        Number,
        Number,
    )> {
        Ok((
            self.bodies(),
            self.points(py)?,
            self.rest_length(),
            self.stiffness(),
            self.damping(),
        ))
    }
}

/// Returns the two items of a list or a tuple.
fn two<'py>(
    argument: &Bound<'py, PyAny>,
    name: &str,
    expected: &str,
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let is_text = argument.is_instance_of::<PyString>();
    let items = (!is_text).then(|| argument.try_iter()?.collect::<PyResult<Vec<_>>>());
    items
        .and_then(Result::ok)
        .and_then(|items| items.try_into().ok())
        .ok_or_else(|| not_two(argument, name, expected))
}

fn not_two(argument: &Bound<'_, PyAny>, name: &str, expected: &str) -> PyErr {
    PyTypeError::new_err(format!(
        "{name} must be {expected}, but is {argument}: write Spring((\"a\", \"b\"), ([0.0, 0.0, 0.0], [0.0, 0.0, 0.1]), rest_length, \
         stiffness, damping)"
    ))
}

/// Linear drag: a force against the velocity of the center of mass of a body, and a torque against its angular velocity.
///
/// Parameters
/// ----------
/// body : str
///     Name of the body.
/// linear : float or str
///     Force over velocity (N s/m), or the name of a force parameter of the world.
/// angular : float or str
///     Torque over angular velocity (N m s/rad), or the name of a force parameter of the world.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is negative or not finite.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Drag(dynamics::Drag);

#[pymethods]
impl Drag {
    #[new]
    #[pyo3(
        signature = (body, linear=Number::Value(0.0), angular=Number::Value(0.0)),
        text_signature = "(body, linear=0.0, angular=0.0)"
    )]
    fn new(
        body: String,
        #[pyo3(from_py_with = number)] linear: Number,
        #[pyo3(from_py_with = number)] angular: Number,
    ) -> PyResult<Self> {
        Ok(Self(dynamics::Drag {
            body,
            linear: linear.not_negative("drag on the velocity")?,
            angular: angular.not_negative("drag on the spin")?,
        }))
    }

    /// Name of the body.
    #[getter]
    fn body(&self) -> &str {
        &self.0.body
    }

    /// Force over velocity (N s/m), or the name of a force parameter.
    #[getter]
    fn linear(&self) -> Number {
        Number::of(&self.0.linear)
    }

    /// Torque over angular velocity (N m s/rad), or the name of a force parameter.
    #[getter]
    fn angular(&self) -> Number {
        Number::of(&self.0.angular)
    }

    fn __repr__(&self) -> String {
        let dynamics::Drag {
            body,
            linear,
            angular,
        } = &self.0;
        let [linear, angular] = [linear, angular].map(shown);
        format!("Drag({body:?}, linear={linear}, angular={angular})")
    }

    fn __getnewargs__(&self) -> (&str, Number, Number) {
        (&self.0.body, self.linear(), self.angular())
    }
}

/// Constant force at a point of a body. The point and the force are fixed in the body frame, so they turn with the body.
///
/// Parameters
/// ----------
/// body : str
///     Name of the body.
/// point : (3,) array_like
///     Point of application (m), in the body frame.
/// force : (3,) array_like
///     Force (N), in the axes of the body frame.
///
/// Raises
/// ------
/// HydroelasticError
///     If a number is not finite.
#[pyclass(frozen, module = "hydroelastic")]
pub struct Thruster(dynamics::Thruster);

#[pymethods]
impl Thruster {
    #[new]
    fn new(body: String, point: &Bound<'_, PyAny>, force: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (point, force) = (finite_row(point, "point")?, finite_row(force, "force")?);
        Ok(Self(dynamics::Thruster { body, point, force }))
    }

    /// Name of the body.
    #[getter]
    fn body(&self) -> &str {
        &self.0.body
    }

    /// Point of application (m) in the body frame, (3,) float64.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.point.to_vec(), &[3])
    }

    /// Force (N) in the axes of the body frame, (3,) float64.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> PyResult<Floats<'py>> {
        array(py, self.0.force.to_vec(), &[3])
    }

    fn __repr__(&self) -> String {
        let dynamics::Thruster { body, point, force } = &self.0;
        format!("Thruster({body:?}, point={point:?}, force={force:?})")
    }

    fn __getnewargs__<'py>(&self, py: Python<'py>) -> PyResult<(&str, Floats<'py>, Floats<'py>)> {
        Ok((&self.0.body, self.point(py)?, self.force(py)?))
    }
}
