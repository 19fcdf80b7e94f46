//! Parameters with names resolved to indices: [`Slots::resolve`] looks each name up once and checks that the model has the parameter.

use super::{GradientError, JointQuantity, Parameter};
use crate::dynamics::{
    Body, Inertia, Joint, JointState, Model, ModelGradient, Motion, Schedule, WorldError,
    check_mass_number, turn_between,
};
use crate::scalar::{Scalar, lift_vector};
use crate::spatial::{Pose, Twist, rotation_from_vector, turned_by};
use nalgebra::{Matrix3, Vector3};

/// Location of the numbers of one parameter in a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slot {
    Gravity,
    /// Index of a force parameter.
    ForceParameter(usize),
    /// Index of a control, and of an interval.
    Control(usize, usize),
    /// Index of the body on a joint, index of the state of the joint (`None` for a mimicking joint), and a quantity of the joint.
    Joint(usize, Option<usize>, JointQuantity),
    /// Index of a body, and a quantity of the body.
    Body(usize, Quantity),
}

/// A quantity of a body that can be a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Position,
    Orientation,
    Velocity,
    AngularVelocity,
    Modulus,
    Dissipation,
    Friction,
    Mass,
    RadiusOfGyration,
}

/// Locations of the numbers of several parameters, in their order.
#[derive(Debug, Clone)]
pub(super) struct Slots(Vec<Slot>);

impl Slots {
    /// Resolves the names of parameters.
    ///
    /// # Errors
    /// If the model does not have one of the parameters.
    pub fn resolve(parameters: &[Parameter], model: &Model) -> Result<Self, GradientError> {
        let slots = parameters
            .iter()
            .map(|parameter| Slot::of(parameter, model));
        Ok(Self(slots.collect::<Result<_, _>>()?))
    }

    /// Number of numbers.
    pub fn dimension(&self) -> usize {
        self.0.iter().map(Slot::dimension).sum()
    }

    /// Values of all numbers. The value of an orientation is a rotation vector (rad, at most π long).
    pub fn values(&self, model: &Model) -> Vec<f64> {
        let mut model = model.clone();
        let slots = self.0.iter();
        slots.flat_map(|slot| slot.values(&mut model)).collect()
    }

    /// Typical change of each number. The steps of differences are multiples of it.
    pub fn scales(&self, model: &Model) -> Vec<f64> {
        let mut model = model.clone();
        let slots = self.0.iter();
        slots.flat_map(|slot| slot.scales(&mut model)).collect()
    }

    /// Returns the derivatives with respect to the numbers of all parameters in a model.
    pub fn gradient(&self, model: &Model, gradient: &ModelGradient) -> Vec<f64> {
        let slots = self.0.iter();
        slots
            .flat_map(|slot| slot.gradient(model, gradient))
            .collect()
    }

    /// Checks that the radii of gyration among the parameters are positive in a model.
    ///
    /// # Errors
    /// If a radius is not positive and finite.
    pub fn check_radii(&self, model: &Model) -> Result<(), WorldError> {
        let bodies = self.0.iter().filter_map(|slot| match slot {
            Slot::Body(body, Quantity::RadiusOfGyration) => Some(&model.bodies[*body]),
            _ => None,
        });
        let mut inertias = bodies.filter_map(|body| Some((body.name(), body.inertia()?)));
        inertias.try_for_each(|(body, inertia)| {
            check_mass_number(body, "radius of gyration", inertia.radius_of_gyration())
        })
    }

    /// The model for derivatives with respect to the parameters. If the dissipation or friction of a body is a parameter, contacts
    /// of the body are integrated with dissipation and friction even if the value is zero.
    pub fn differentiated(&self, model: &Model) -> Model {
        let mut model = model.clone();
        for slot in &self.0 {
            if let Slot::Body(body, Quantity::Dissipation | Quantity::Friction) = *slot {
                model.bodies[body].is_law_differentiated = true;
            }
        }
        model
    }

    /// The model with a change added to each number.
    pub fn perturbed<T: Scalar>(&self, model: &Model, changes: &[T]) -> Model<T> {
        let mut model = model.lifted();
        self.for_each(changes, |slot, changes| slot.add(&mut model, changes));
        model
    }

    /// The model with a new value for each number.
    pub fn with_values(&self, model: &Model, values: &[f64]) -> Model {
        let mut model = model.clone();
        self.for_each(values, |slot, values| slot.set(&mut model, values));
        model
    }

    /// Calls a function with each slot and its part of the numbers.
    fn for_each<'a, T>(&self, numbers: &'a [T], mut apply: impl FnMut(&Slot, &'a [T])) {
        let mut rest = numbers;
        for slot in &self.0 {
            let (part, others) = rest.split_at(slot.dimension());
            apply(slot, part);
            rest = others;
        }
    }

    /// Checks that a slice has one entry for each parameter component.
    ///
    /// # Errors
    /// [`GradientError::NumberCount`] if the counts differ.
    pub fn check_count(&self, found: usize) -> Result<(), GradientError> {
        let expected = self.dimension();
        if found == expected {
            Ok(())
        } else {
            Err(GradientError::NumberCount { found, expected })
        }
    }

    /// Checks that each contact law can be differentiated with respect to the parameters together: the coefficient of friction of
    /// a pair, 2ab/(a + b), has no derivative with respect to both coefficients if both are zero.
    ///
    /// # Errors
    /// [`GradientError::NoFriction`] if two bodies that can collide have zero friction, and both coefficients are parameters.
    pub fn check_friction(&self, model: &Model) -> Result<(), GradientError> {
        let differentiated = self.0.iter().filter_map(|slot| match slot {
            Slot::Body(body, Quantity::Friction) => Some(*body),
            _ => None,
        });
        let is_zero = |body: &usize| {
            let friction = model.bodies[*body].material.friction;
            friction.is_some_and(|friction| friction <= 0.0)
        };
        let mut bodies: Vec<usize> = differentiated.filter(is_zero).collect();
        bodies.sort_unstable();
        bodies.dedup();
        for (index, &i) in bodies.iter().enumerate() {
            let mut others = bodies[index + 1..].iter();
            if let Some(&j) = others.find(|&&j| model.ordered_pair(i, j).is_some()) {
                let bodies = [i, j].map(|index| model.bodies[index].name().to_owned());
                return Err(GradientError::NoFriction { bodies });
            }
        }
        Ok(())
    }
}

impl Slot {
    fn of(parameter: &Parameter, model: &Model) -> Result<Self, GradientError> {
        let quantity = match parameter {
            Parameter::Gravity => return Ok(Self::Gravity),
            Parameter::ForceParameter(name) => return Self::of_force_parameter(name, model),
            Parameter::Control(body, interval) => {
                model.index_of(body)?;
                return Self::of_control(body, *interval, model);
            }
            Parameter::Joint(name, quantity) => {
                let body = model.body_on(name, quantity.is_for_ball_joint())?;
                check_schedule(model.bodies[body].joint(), *quantity)?;
                let state_index = model.joint_state_index(body);
                if quantity.is_initial() && state_index.is_none() {
                    return Err(GradientError::MimickingJoint {
                        joint: name.to_string(),
                        quantity: *quantity,
                        leader: model.leader_name(body).unwrap_or_default().to_owned(),
                    });
                }
                return Ok(Self::Joint(body, state_index, *quantity));
            }
            Parameter::InitialPosition(_) => Quantity::Position,
            Parameter::InitialOrientation(_) => Quantity::Orientation,
            Parameter::InitialVelocity(_) => Quantity::Velocity,
            Parameter::InitialAngularVelocity(_) => Quantity::AngularVelocity,
            Parameter::Modulus(_) => Quantity::Modulus,
            Parameter::Dissipation(_) => Quantity::Dissipation,
            Parameter::Friction(_) => Quantity::Friction,
            Parameter::Mass(_) => Quantity::Mass,
            Parameter::RadiusOfGyration(_) => Quantity::RadiusOfGyration,
        };
        let name = parameter.body().unwrap_or_default();
        let index = model.index_of(name)?;
        quantity.check(&model.bodies[index], parameter)?;
        Ok(Self::Body(index, quantity))
    }

    fn of_force_parameter(name: &str, model: &Model) -> Result<Self, GradientError> {
        let mut parameters = model.force_parameters.iter();
        let index = parameters.position(|(candidate, _)| candidate == name);
        let index = index.ok_or_else(|| GradientError::NoForceParameter(name.to_owned()))?;
        Ok(Self::ForceParameter(index))
    }

    fn of_control(body: &str, interval: usize, model: &Model) -> Result<Self, GradientError> {
        let mut controls = model.controls.iter().enumerate();
        let control = controls.find(|(_, control)| control.body() == body);
        let intervals = control.map_or(0, |(_, control)| control.wrenches().len());
        match control {
            Some((index, _)) if interval < intervals => Ok(Self::Control(index, interval)),
            _ => Err(GradientError::NoControl {
                body: body.to_owned(),
                interval,
                intervals,
            }),
        }
    }

    fn dimension(&self) -> usize {
        match self {
            Self::Gravity => 3,
            Self::ForceParameter(_) => 1,
            Self::Joint(.., quantity) => quantity.dimension(),
            Self::Control(..) => 6,
            Self::Body(_, quantity) => quantity.dimension(),
        }
    }

    /// Numbers of the parameter in a model. The list is empty for a position, an orientation or a radius of gyration, which have their own
    /// methods.
    fn numbers<'a, T: Scalar>(&self, model: &'a mut Model<T>) -> Vec<&'a mut T> {
        match *self {
            Self::Gravity => model.gravity.iter_mut().collect(),
            Self::ForceParameter(index) => vec![&mut model.force_parameters[index].1],
            Self::Control(control, interval) => {
                let wrench = model.controls[control].wrench_mut(interval);
                wrench.map_or_else(Vec::new, |wrench| {
                    wrench.torque.iter_mut().chain(&mut wrench.force).collect()
                })
            }
            Self::Joint(body, _, quantity) => match &mut model.bodies[body].motion {
                Motion::Dynamic { joint, .. } => joint_numbers(joint, quantity),
                Motion::Fixed | Motion::Kinematic(_) => Vec::new(),
            },
            Self::Body(body, quantity) => quantity.numbers(&mut model.bodies[body]),
        }
    }

    /// Initial pose of the body, if the parameter is a position or an orientation.
    fn pose<'a, T>(&self, model: &'a mut Model<T>) -> Option<(&'a mut Pose<T>, Quantity)> {
        match *self {
            Self::Body(body, quantity @ (Quantity::Position | Quantity::Orientation)) => {
                Some((&mut model.bodies[body].initial.pose, quantity))
            }
            _ => None,
        }
    }

    /// Initial rotation of a ball joint, or `None` for other parameters.
    fn ball_rotation<'a, T>(&self, model: &'a mut Model<T>) -> Option<&'a mut Matrix3<T>> {
        let Self::Joint(body, _, JointQuantity::InitialOrientation) = *self else {
            return None;
        };
        match &mut model.bodies[body].motion {
            Motion::Dynamic { joint, .. } => match &mut joint.initial {
                JointState::Ball { rotation, .. } => Some(rotation),
                JointState::Scalar { .. } => None,
            },
            Motion::Fixed | Motion::Kinematic(_) => None,
        }
    }

    /// Inertia of the body, if the parameter is the radius of gyration.
    fn inertia<'a, T: Scalar>(&self, model: &'a mut Model<T>) -> Option<&'a mut Inertia<T>> {
        match *self {
            Self::Body(body, Quantity::RadiusOfGyration) => model.bodies[body].motion.inertia_mut(),
            _ => None,
        }
    }

    fn values(&self, model: &mut Model) -> Vec<f64> {
        let rotation_vector = |rotation: &Matrix3<f64>| {
            let turn = turn_between(&Matrix3::identity(), rotation);
            turn.iter().copied().collect()
        };
        if let Some(rotation) = self.ball_rotation(model) {
            return rotation_vector(rotation);
        }
        if let Some(inertia) = self.inertia(model) {
            return vec![inertia.radius_of_gyration()];
        }
        match self.pose(model) {
            Some((pose, Quantity::Position)) => pose.translation().iter().copied().collect(),
            Some((pose, _)) => rotation_vector(pose.rotation()),
            None => self
                .numbers(model)
                .into_iter()
                .map(|number| *number)
                .collect(),
        }
    }

    /// The value itself for a material, a mass or a force parameter, and 1 in SI units otherwise.
    fn scales(&self, model: &mut Model) -> Vec<f64> {
        match self {
            Self::ForceParameter(_)
            | Self::Joint(
                ..,
                JointQuantity::ServoStiffness
                | JointQuantity::ServoDamping
                | JointQuantity::Damping
                | JointQuantity::Friction
                | JointQuantity::Armature,
            )
            | Self::Body(
                _,
                Quantity::Modulus
                | Quantity::Dissipation
                | Quantity::Friction
                | Quantity::Mass
                | Quantity::RadiusOfGyration,
            ) => {
                let sizes = self.values(model).into_iter().map(f64::abs);
                sizes
                    .map(|size| if size > 0.0 { size } else { 1.0 })
                    .collect()
            }
            Self::Gravity | Self::Control(..) | Self::Body(..) | Self::Joint(..) => {
                vec![1.0; self.dimension()]
            }
        }
    }

    fn add<T: Scalar>(&self, model: &mut Model<T>, changes: &[T]) {
        if let Some((pose, quantity)) = self.pose(model) {
            let zero = lift_vector(&Vector3::zeros());
            let change = Vector3::from_column_slice(changes);
            let [angular, linear] = match quantity {
                Quantity::Orientation => [change, zero],
                _ => [zero, change],
            };
            *pose = pose.moved_by(&Twist { angular, linear });
            return;
        }
        if let Some(rotation) = self.ball_rotation(model) {
            *rotation = turned_by(rotation, &Vector3::from_column_slice(changes));
            return;
        }
        if let Some(inertia) = self.inertia(model) {
            inertia.set_radius_of_gyration(changes[0] + inertia.radius_of_gyration());
            return;
        }
        for (number, change) in self.numbers(model).into_iter().zip(changes) {
            *number += *change;
        }
    }

    fn set(&self, model: &mut Model, values: &[f64]) {
        if let Some((pose, quantity)) = self.pose(model) {
            let value = Vector3::from_column_slice(values);
            *pose = match quantity {
                Quantity::Orientation => Pose::from_rotation_vector(&value, *pose.translation()),
                _ => pose.with_translation(value),
            };
            return;
        }
        if let Some(rotation) = self.ball_rotation(model) {
            *rotation = rotation_from_vector(&Vector3::from_column_slice(values));
            return;
        }
        if let Some(inertia) = self.inertia(model) {
            inertia.set_radius_of_gyration(values[0]);
            return;
        }
        for (number, value) in self.numbers(model).into_iter().zip(values) {
            *number = *value;
        }
    }

    fn gradient(&self, model: &Model, gradient: &ModelGradient) -> Vec<f64> {
        match *self {
            Self::Gravity => gradient.gravity.as_slice().to_vec(),
            Self::ForceParameter(index) => vec![gradient.force_parameters[index]],
            Self::Control(control, interval) => {
                gradient.controls[control][interval].as_slice().to_vec()
            }
            Self::Joint(body, state_index, quantity) => {
                let by_body = &gradient.bodies[body];
                if let Some(index) = quantity.law_index() {
                    return vec![by_body.joint_law[index]];
                }
                let by_state = state_index.map(|index| &gradient.joints[index]);
                let by_state = match quantity {
                    JointQuantity::ScheduledTorque(index) => return vec![by_body.torques[index]],
                    JointQuantity::ScheduledTarget(index) => return vec![by_body.targets[index]],
                    JointQuantity::InitialVelocity | JointQuantity::InitialAngularVelocity => {
                        by_state.map(|by_state| by_state.velocity)
                    }
                    _ => by_state.map(|by_state| by_state.position),
                };
                let numbers = by_state.iter().flat_map(|by_state| by_state.iter());
                numbers.take(quantity.dimension()).copied().collect()
            }
            Self::Body(body, quantity) => {
                let by_body = &gradient.bodies[body];
                match quantity {
                    Quantity::Position => by_body.initial.shift.as_slice().to_vec(),
                    Quantity::Orientation => by_body.initial.turn.as_slice().to_vec(),
                    Quantity::Velocity => by_body.initial.velocity.as_slice().to_vec(),
                    Quantity::AngularVelocity => by_body.initial.spin.as_slice().to_vec(),
                    Quantity::Modulus => vec![by_body.modulus],
                    Quantity::Dissipation => vec![by_body.dissipation],
                    Quantity::Friction => vec![by_body.friction],
                    Quantity::Mass => vec![by_body.mass],
                    Quantity::RadiusOfGyration => {
                        // The inertia per mass is proportional to the square of the radius.
                        let by_radius = |inertia: &Inertia| {
                            2.0 * by_body.inertia.dot(&inertia.per_mass())
                                / inertia.radius_of_gyration()
                        };
                        let inertia = model.bodies[body].inertia();
                        inertia.map(by_radius).into_iter().collect()
                    }
                }
            }
        }
    }
}

/// Checks that a joint has the scheduled torque or target of a quantity.
fn check_schedule(joint: Option<&Joint>, quantity: JointQuantity) -> Result<(), GradientError> {
    let count = |schedule: Option<&Schedule>| schedule.map_or(0, |found| found.values().len());
    let (count, index) = match quantity {
        JointQuantity::ScheduledTorque(index) => (count(joint.and_then(Joint::torques)), index),
        JointQuantity::ScheduledTarget(index) => (count(joint.and_then(Joint::targets)), index),
        _ => return Ok(()),
    };
    if index < count {
        return Ok(());
    }
    Err(GradientError::NotScheduled {
        joint: joint.map_or_else(String::new, |joint| joint.name().to_owned()),
        quantity,
        count,
    })
}

/// Numbers of a joint. The list is empty for the orientation of a ball joint.
fn joint_numbers<T>(joint: &mut Joint<T>, quantity: JointQuantity) -> Vec<&mut T> {
    if let Some(index) = quantity.law_index() {
        return joint
            .law
            .numbers_mut()
            .into_iter()
            .skip(index)
            .take(1)
            .collect();
    }
    let scheduled = match quantity {
        JointQuantity::ScheduledTorque(index) => Some((&mut joint.torques, index)),
        JointQuantity::ScheduledTarget(index) => Some((&mut joint.targets, index)),
        _ => None,
    };
    if let Some((schedule, index)) = scheduled {
        let schedule = schedule.as_mut();
        let value = schedule.and_then(|schedule| schedule.value_mut(index));
        return value.into_iter().collect();
    }
    match (&mut joint.initial, quantity) {
        (JointState::Scalar { velocity, .. }, JointQuantity::InitialVelocity) => vec![velocity],
        (JointState::Scalar { position, .. }, _) => vec![position],
        (
            JointState::Ball {
                angular_velocity, ..
            },
            JointQuantity::InitialAngularVelocity,
        ) => angular_velocity.iter_mut().collect(),
        _ => Vec::new(),
    }
}

impl Quantity {
    fn dimension(self) -> usize {
        match self {
            Self::Position | Self::Orientation | Self::Velocity | Self::AngularVelocity => 3,
            Self::Modulus
            | Self::Dissipation
            | Self::Friction
            | Self::Mass
            | Self::RadiusOfGyration => 1,
        }
    }

    /// Checks that the quantity of a body has an effect.
    fn check(self, body: &Body, parameter: &Parameter) -> Result<(), GradientError> {
        let name = || body.name().to_owned();
        let has_effect = match self {
            Self::Modulus if body.material.modulus.is_none() => {
                return Err(GradientError::NoModulus { body: name() });
            }
            Self::Friction if body.material.friction.is_none() => {
                return Err(GradientError::NoOwnFriction { body: name() });
            }
            Self::Position | Self::Orientation | Self::Velocity | Self::AngularVelocity
                if body.is_on_joint() =>
            {
                return Err(GradientError::OnJoint {
                    body: name(),
                    parameter: parameter.to_string(),
                });
            }
            Self::Position | Self::Orientation => !body.motion.is_kinematic(),
            Self::Velocity | Self::AngularVelocity | Self::Mass => body.inertia().is_some(),
            Self::RadiusOfGyration => match body.inertia() {
                Some(inertia) => {
                    check_mass_number(&name(), "radius of gyration", inertia.radius_of_gyration())?;
                    true
                }
                None => false,
            },
            Self::Modulus | Self::Dissipation | Self::Friction => true,
        };
        if has_effect {
            Ok(())
        } else {
            Err(GradientError::NotDynamic {
                body: name(),
                parameter: parameter.to_string(),
            })
        }
    }

    fn numbers<T>(self, body: &mut Body<T>) -> Vec<&mut T> {
        match self {
            Self::Position | Self::Orientation | Self::RadiusOfGyration => Vec::new(),
            Self::Velocity => body.initial.twist.linear.iter_mut().collect(),
            Self::AngularVelocity => body.initial.twist.angular.iter_mut().collect(),
            Self::Modulus => body.material.modulus.iter_mut().collect(),
            Self::Dissipation => vec![&mut body.material.dissipation],
            Self::Friction => body.material.friction.iter_mut().collect(),
            Self::Mass => {
                let inertia = body.motion.inertia_mut();
                inertia
                    .map(|inertia| &mut inertia.mass)
                    .into_iter()
                    .collect()
            }
        }
    }
}
