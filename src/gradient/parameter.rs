use super::GradientError;
use crate::dynamics::{Body, Motion, System, SystemGradient};
use crate::scalar::{Scalar, lift_vector};
use crate::spatial::Twist;
use nalgebra::Vector3;
use std::fmt;
use std::sync::Arc;

/// Something that went into a world, and that a derivative may be taken by.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Parameter {
    /// Initial position (m) of the named body's origin: 3 numbers.
    InitialPosition(Arc<str>),
    /// Initial orientation of the named body: 3 numbers, a rotation vector (rad) in world axes that
    /// turns the body about its origin from where it starts.
    InitialOrientation(Arc<str>),
    /// Initial velocity (m/s) of the named body's center of mass: 3 numbers.
    InitialVelocity(Arc<str>),
    /// Initial spin (rad/s) of the named body, in world axes: 3 numbers.
    InitialSpin(Arc<str>),
    /// Hydroelastic modulus (Pa) of the named body.
    Modulus(Arc<str>),
    /// Dissipation (s/m) of the named body.
    Dissipation(Arc<str>),
    /// Coefficient of friction of the named body.
    Friction(Arc<str>),
    /// Mass (kg) of the named body, which scales its inertia.
    Mass(Arc<str>),
    /// Gravity (m/s²): 3 numbers.
    Gravity,
    /// The wrench of an interval, counted from 0, of the named body's [`Control`](crate::dynamics::Control): 6 numbers, torque
    /// (N m), then force (N), about the center of mass in world axes.
    Control(Arc<str>, usize),
    /// The number of this name that forces read:
    /// [`World::with_force_parameter`](crate::dynamics::World::with_force_parameter).
    OfForces(Arc<str>),
}

impl Parameter {
    /// How many numbers it is.
    #[must_use]
    pub fn dimension(&self) -> usize {
        match self {
            Self::InitialPosition(_)
            | Self::InitialOrientation(_)
            | Self::InitialVelocity(_)
            | Self::InitialSpin(_)
            | Self::Gravity => 3,
            Self::Modulus(_)
            | Self::Dissipation(_)
            | Self::Friction(_)
            | Self::Mass(_)
            | Self::OfForces(_) => 1,
            Self::Control(..) => 6,
        }
    }

    /// A name for each of its numbers, for messages.
    pub(super) fn number_names(&self) -> Vec<String> {
        let numbers: &[&str] = match self.dimension() {
            1 => return vec![format!("{self:?}")],
            3 => &["x", "y", "z"],
            _ => &[
                "torque x", "torque y", "torque z", "force x", "force y", "force z",
            ],
        };
        let name = |number: &&str| format!("{self:?} {number}");
        numbers.iter().map(name).collect()
    }

    /// Name of the body; `None` for gravity and force parameters.
    #[must_use]
    pub fn body(&self) -> Option<&str> {
        match self {
            Self::InitialPosition(name)
            | Self::InitialOrientation(name)
            | Self::InitialVelocity(name)
            | Self::InitialSpin(name)
            | Self::Modulus(name)
            | Self::Dissipation(name)
            | Self::Friction(name)
            | Self::Mass(name)
            | Self::Control(name, _) => Some(name),
            Self::Gravity | Self::OfForces(_) => None,
        }
    }

    /// Its place among the numbers that the system's forces read, if it is one of them.
    fn place_of_forces<T>(&self, system: &System<T>) -> Option<usize> {
        let Self::OfForces(name) = self else {
            return None;
        };
        let mut numbers = system.force_parameters.iter();
        numbers.position(|(own, _)| **own == **name)
    }

    /// Checks that the system has the parameter.
    pub(super) fn check(&self, system: &System) -> Result<(), GradientError> {
        if let Self::OfForces(name) = self {
            let place = self.place_of_forces(system);
            return place.map_or_else(
                || Err(GradientError::NoForceParameter(name.to_string())),
                |_| Ok(()),
            );
        }
        let Some(name) = self.body() else {
            return Ok(());
        };
        let body = &system.bodies[system.index_of(name)?];
        if matches!(self, Self::Modulus(_)) && body.material.modulus.is_none() {
            return Err(GradientError::NoModulus {
                body: name.to_owned(),
            });
        }
        if matches!(self, Self::Friction(_)) && body.material.friction.is_none() {
            return Err(GradientError::NoOwnFriction {
                body: name.to_owned(),
            });
        }
        if let Self::Control(_, interval) = self {
            let mut controls = system.controls.iter();
            let control = controls.find(|control| control.body() == name);
            let intervals = control.map_or(0, |control| control.wrenches().len());
            return if *interval < intervals {
                Ok(())
            } else {
                Err(GradientError::NoControl {
                    body: name.to_owned(),
                    interval: *interval,
                    intervals,
                })
            };
        }
        let is_missing = match self {
            Self::InitialPosition(_) | Self::InitialOrientation(_) => body.motion.is_prescribed(),
            Self::InitialVelocity(_) | Self::InitialSpin(_) | Self::Mass(_) | Self::Control(..) => {
                body.inertia().is_none()
            }
            Self::Modulus(_)
            | Self::Dissipation(_)
            | Self::Friction(_)
            | Self::Gravity
            | Self::OfForces(_) => false,
        };
        if is_missing {
            return Err(GradientError::NotDynamic {
                body: name.to_owned(),
                parameter: self.to_string(),
            });
        }
        Ok(())
    }

    /// A typical change of the parameter, which difference steps are multiples of: the value itself
    /// for a material, a mass or a number of forces, 1 in SI units for all else.
    pub(super) fn scale(&self, system: &System) -> f64 {
        if let Some(place) = self.place_of_forces(system) {
            let value = system.force_parameters[place].1.abs();
            return if value > 0.0 { value } else { 1.0 };
        }
        let body = self.body().and_then(|name| system.index_of(name).ok());
        let Some(body) = body.map(|index| &system.bodies[index]) else {
            return 1.0;
        };
        let value = match self {
            Self::Modulus(_) => body.material.modulus.unwrap_or(1.0),
            Self::Dissipation(_) => body.material.dissipation,
            Self::Friction(_) => body.material.friction.unwrap_or(1.0),
            Self::Mass(_) => body.inertia().map_or(1.0, |inertia| inertia.mass),
            Self::InitialPosition(_)
            | Self::InitialOrientation(_)
            | Self::InitialVelocity(_)
            | Self::InitialSpin(_)
            | Self::Gravity
            | Self::Control(..)
            | Self::OfForces(_) => 1.0,
        };
        if value > 0.0 { value } else { 1.0 }
    }

    /// Its derivatives, one for each of its numbers, in a system that has it.
    pub(super) fn own(&self, system: &System, gradient: &SystemGradient) -> Vec<f64> {
        if let Some(place) = self.place_of_forces(system) {
            return vec![gradient.force_parameters[place]];
        }
        let body = self.body().and_then(|name| system.index_of(name).ok());
        if let Self::Gravity = self {
            return gradient.gravity.as_slice().to_vec();
        }
        let Some(body) = body else {
            return Vec::new();
        };
        if let Self::Control(name, interval) = self {
            let mut controls = system.controls.iter().zip(&gradient.controls);
            let own = controls.find(|(control, _)| *control.body() == **name);
            return own.map_or_else(Vec::new, |(_, by)| by[*interval].as_slice().to_vec());
        }
        let own = &gradient.bodies[body];
        let initial = &own.initial;
        match self {
            Self::InitialPosition(_) => initial.shift.as_slice().to_vec(),
            Self::InitialOrientation(_) => initial.turn.as_slice().to_vec(),
            Self::InitialVelocity(_) => initial.velocity.as_slice().to_vec(),
            Self::InitialSpin(_) => initial.spin.as_slice().to_vec(),
            Self::Modulus(_) => vec![own.modulus],
            Self::Dissipation(_) => vec![own.dissipation],
            Self::Friction(_) => vec![own.friction],
            Self::Mass(_) => vec![own.mass],
            Self::Gravity | Self::Control(..) | Self::OfForces(_) => Vec::new(),
        }
    }

    /// Changes the parameter in a system that has it.
    pub(super) fn change<T: Scalar>(&self, system: &mut System<T>, change: &[T]) {
        if let Some(place) = self.place_of_forces(system) {
            system.force_parameters[place].1 += change[0];
            return;
        }
        let zero = lift_vector(&Vector3::zeros());
        let vector = || Vector3::new(change[0], change[1], change[2]);
        if let Self::Gravity = self {
            system.gravity += vector();
        }
        let Some(name) = self.body() else {
            return;
        };
        if let Self::Control(_, interval) = self {
            let control = system.controls.iter_mut().find(|it| it.body() == name);
            if let Some(wrench) = control.and_then(|control| control.wrench_mut(*interval)) {
                wrench.torque += vector();
                wrench.force += Vector3::new(change[3], change[4], change[5]);
            }
            return;
        }
        let Some(body) = system.bodies.iter_mut().find(|body| body.name() == name) else {
            return;
        };
        match self {
            Self::Modulus(_) => {
                if let Some(modulus) = &mut body.material.modulus {
                    *modulus += change[0];
                }
            }
            Self::Dissipation(_) => {
                body.material.dissipation += change[0];
                body.rubs = true;
            }
            Self::Friction(_) => {
                if let Some(friction) = &mut body.material.friction {
                    *friction += change[0];
                    body.rubs = true;
                }
            }
            Self::Mass(_) => change_mass(body, change[0]),
            Self::InitialVelocity(_) => body.initial.twist.linear += vector(),
            Self::InitialSpin(_) => body.initial.twist.angular += vector(),
            Self::InitialPosition(_) => move_start(body, zero, vector()),
            Self::InitialOrientation(_) => move_start(body, vector(), zero),
            Self::Gravity | Self::Control(..) | Self::OfForces(_) => {}
        }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let quantity = match self {
            Self::InitialPosition(_) => "the initial position",
            Self::InitialOrientation(_) => "the initial orientation",
            Self::InitialVelocity(_) => "the initial velocity",
            Self::InitialSpin(_) => "the initial spin",
            Self::Modulus(_) => "the modulus",
            Self::Dissipation(_) => "the dissipation",
            Self::Friction(_) => "the friction",
            Self::Mass(_) => "the mass",
            Self::Gravity => "gravity",
            Self::OfForces(name) => return write!(formatter, "the force parameter {name:?}"),
            Self::Control(_, interval) => {
                write!(formatter, "interval {interval} of ")?;
                "the control"
            }
        };
        write!(formatter, "{quantity}")?;
        self.body()
            .map_or(Ok(()), |body| write!(formatter, " of {body:?}"))
    }
}

fn change_mass<T: Scalar>(body: &mut Body<T>, change: T) {
    if let Motion::Dynamic(inertia) = &mut body.motion {
        inertia.mass += change;
    }
}

fn move_start<T: Scalar>(body: &mut Body<T>, angular: Vector3<T>, linear: Vector3<T>) {
    body.initial.pose = body.initial.pose.moved_by(&Twist { angular, linear });
}
