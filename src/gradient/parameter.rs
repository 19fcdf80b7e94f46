use super::GradientError;
use crate::dynamics::{Body, ExternalForces, Motion, World};
use crate::scalar::{Scalar, lift_vector};
use crate::spatial::Twist;
use nalgebra::Vector3;

/// Something that went into a world, and that a derivative may be taken by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Parameter<'a> {
    /// Initial position (m) of the named body's origin: 3 numbers.
    InitialPosition(&'a str),
    /// Initial orientation of the named body: 3 numbers, a rotation vector (rad) in world axes that
    /// turns the body about its origin from where it starts.
    InitialOrientation(&'a str),
    /// Initial velocity (m/s) of the named body's centre of mass: 3 numbers.
    InitialVelocity(&'a str),
    /// Initial spin (rad/s) of the named body, in world axes: 3 numbers.
    InitialSpin(&'a str),
    /// Hydroelastic modulus (Pa) of the named body.
    Modulus(&'a str),
    /// Dissipation (s/m) of the named body.
    Dissipation(&'a str),
    /// Coefficient of friction of the named body.
    Friction(&'a str),
    /// Mass (kg) of the named body, which scales its inertia.
    Mass(&'a str),
    /// Gravity (m/s²): 3 numbers.
    Gravity,
}

impl Parameter<'_> {
    /// How many numbers it is.
    #[must_use]
    pub fn dimension(&self) -> usize {
        match self {
            Self::InitialPosition(_)
            | Self::InitialOrientation(_)
            | Self::InitialVelocity(_)
            | Self::InitialSpin(_)
            | Self::Gravity => 3,
            Self::Modulus(_) | Self::Dissipation(_) | Self::Friction(_) | Self::Mass(_) => 1,
        }
    }

    /// A name for each of its numbers, for messages.
    pub(super) fn number_names(&self) -> Vec<String> {
        match self.dimension() {
            1 => vec![format!("{self:?}")],
            _ => ["x", "y", "z"]
                .map(|axis| format!("{self:?} {axis}"))
                .into(),
        }
    }

    /// Name of the body it belongs to.
    fn body(&self) -> Option<&str> {
        match self {
            Self::InitialPosition(name)
            | Self::InitialOrientation(name)
            | Self::InitialVelocity(name)
            | Self::InitialSpin(name)
            | Self::Modulus(name)
            | Self::Dissipation(name)
            | Self::Friction(name)
            | Self::Mass(name) => Some(name),
            Self::Gravity => None,
        }
    }

    /// Checks that the world has the parameter.
    pub(super) fn check<F: ExternalForces>(
        &self,
        world: &World<f64, F>,
    ) -> Result<(), GradientError> {
        let Some(name) = self.body() else {
            return Ok(());
        };
        let body = &world.bodies()[world.index_of(name)?];
        let needs_forces = !matches!(
            self,
            Self::InitialPosition(_)
                | Self::InitialOrientation(_)
                | Self::Modulus(_)
                | Self::Dissipation(_)
                | Self::Friction(_)
        );
        let follows_path = matches!(body.motion, Motion::Prescribed(_)) && self.is_initial();
        if (needs_forces && body.inertia().is_none()) || follows_path {
            return Err(GradientError::NotDynamic {
                body: name.to_owned(),
                parameter: format!("{self:?}"),
            });
        }
        Ok(())
    }

    fn is_initial(&self) -> bool {
        matches!(
            self,
            Self::InitialPosition(_)
                | Self::InitialOrientation(_)
                | Self::InitialVelocity(_)
                | Self::InitialSpin(_)
        )
    }

    /// A typical change of the parameter, which difference steps are multiples of: the value itself
    /// for a material or a mass, 1 in SI units for all else.
    pub(super) fn scale<F: ExternalForces>(&self, world: &World<f64, F>) -> f64 {
        let body = self.body().and_then(|name| world.index_of(name).ok());
        let Some(body) = body.map(|index| &world.bodies()[index]) else {
            return 1.0;
        };
        let value = match self {
            Self::Modulus(_) => body.material.modulus,
            Self::Dissipation(_) => body.material.dissipation,
            Self::Friction(_) => body.material.friction,
            Self::Mass(_) => body.inertia().map_or(1.0, |inertia| inertia.mass),
            _ => 1.0,
        };
        if value > 0.0 { value } else { 1.0 }
    }

    /// Changes the parameter in a world that has it.
    pub(super) fn change<T: Scalar, F: ExternalForces>(
        &self,
        world: &mut World<T, F>,
        change: &[T],
    ) {
        let zero = lift_vector(&Vector3::zeros());
        let vector = || Vector3::new(change[0], change[1], change[2]);
        let Some(name) = self.body() else {
            world.gravity += vector();
            return;
        };
        let Some(body) = world.bodies.iter_mut().find(|body| body.name() == name) else {
            return;
        };
        match self {
            Self::Modulus(_) => body.material.modulus += change[0],
            Self::Dissipation(_) => {
                body.material.dissipation += change[0];
                body.rubs = true;
            }
            Self::Friction(_) => {
                body.material.friction += change[0];
                body.rubs = true;
            }
            Self::Mass(_) => change_mass(body, change[0]),
            Self::InitialVelocity(_) => body.initial.twist.linear += vector(),
            Self::InitialSpin(_) => body.initial.twist.angular += vector(),
            Self::InitialPosition(_) => move_start(body, zero, vector()),
            Self::InitialOrientation(_) => move_start(body, vector(), zero),
            Self::Gravity => {}
        }
    }
}

/// Checks that all pairs of a world have a law that can be differentiated by the parameters together.
pub(super) fn check_together<F: ExternalForces>(
    parameters: &[Parameter],
    world: &World<f64, F>,
) -> Result<(), GradientError> {
    let without_friction = |index: &usize| {
        let name = world.bodies()[*index].name();
        let is_parameter = parameters.contains(&Parameter::Friction(name));
        is_parameter && world.bodies()[*index].material.friction <= 0.0
    };
    let bodies: Vec<usize> = (0..world.bodies().len()).filter(without_friction).collect();
    for (place, &i) in bodies.iter().enumerate() {
        let mut others = bodies[place + 1..].iter();
        if let Some(&j) = others.find(|&&j| world.may_touch(i, j)) {
            let bodies = [i, j].map(|index| world.bodies()[index].name().to_owned());
            return Err(GradientError::NoFriction { bodies });
        }
    }
    Ok(())
}

fn change_mass<T: Scalar>(body: &mut Body<T>, change: T) {
    if let Motion::Dynamic(inertia) = &mut body.motion {
        inertia.mass += change;
    }
}

fn move_start<T: Scalar>(body: &mut Body<T>, angular: Vector3<T>, linear: Vector3<T>) {
    body.initial.pose = body.initial.pose.moved_by(&Twist { angular, linear });
}
