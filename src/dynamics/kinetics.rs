//! Equations of motion of a world in generalized coordinates.

use super::model::Model;
use super::multibody::{Accelerations, Kinematics, MassFactors, Multibody, convective, zeros};
use super::validate::check_finite;
use super::{BodyState, Force, State, World, WorldError};
use crate::scalar::{Scalar, lift, lift_vector, real_part};
use crate::spatial::{Twist, Wrench};
use nalgebra::{DMatrix, DVector, Matrix6xX, Vector3, Vector6};
use std::ops::Range;

/// Terms of the equations of motion M·u̇ + b = τ of all dynamic bodies at one state.
///
/// u are the generalized velocities. M is the mass matrix, and b is the bias: Coriolis, centrifugal and gravity forces. τ are the
/// generalized forces of joints, contacts and other forces. [`World::kinetics`] creates the terms. The generalized velocities of a body are
/// the [columns](Self::columns) of its joint:
///
/// | joint | generalized velocities | generalized forces |
/// |---|---|---|
/// | free | angular velocity (rad/s) and velocity of the center of mass (m/s), in world axes | torque about the center of mass (N m) and force (N) |
/// | ball | angular velocity (rad/s), in the axes of the joint frame | torque (N m) |
/// | revolute | rate of the angle (rad/s) | torque (N m) |
/// | prismatic | rate of the displacement (m/s) | force (N) |
/// | fixed | none | none |
///
/// Derivatives with respect to positions have one column for each generalized velocity. The column is the derivative with respect to a
/// displacement in the direction of this velocity, at constant generalized velocities. Fixed and kinematic bodies have no columns. The
/// spatial acceleration of a kinematic parent is assumed to be zero, because a path does not define accelerations.
///
/// Loop joints have no columns. The terms do not include the forces of loop joints, and forward dynamics return an error.
///
/// A mimicking joint also has columns. Only the forward dynamics include the forces that couple it to its leader. All other quantities
/// treat the joints as independent. Let w be the independent velocities, and u = E·w. Then the forward dynamics use E·(EᵀME)⁻¹·Eᵀ in place
/// of M⁻¹.
///
/// The symbols and algorithms follow Featherstone 2008, Rigid Body Dynamics Algorithms.
///
/// ```
/// use hydroelastic::contact::Shape;
/// use hydroelastic::dynamics::{Body, Joint, Mass, Material, World};
/// use hydroelastic::mesh::shapes;
/// use nalgebra::{dvector, vector};
///
/// // A ball of 2 kg on a slide that points upward.
/// let ball = Shape::new(shapes::icosphere(0.1, 1)?);
/// let slide = Joint::prismatic("slide", nalgebra::Vector3::z_axis()).with_armature(0.5);
/// let ball = Body::dynamic("ball", ball, Material::elastic(1e5), Mass::Total(2.0))?.with_joint(slide)?;
/// let world = World::new(vec![ball])?.with_gravity(vector![0.0, 0.0, -10.0])?;
///
/// let kinetics = world.kinetics(&world.initial_state())?;
/// assert!((kinetics.mass_matrix()[(0, 0)] - 2.5).abs() < 1e-12);
/// assert!((kinetics.bias()[0] - 20.0).abs() < 1e-12); // holds the ball
/// let acceleration = kinetics.forward_dynamics(&dvector![25.0])?;
/// assert!((acceleration[0] - 2.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Kinetics<T = f64> {
    multibody: Multibody<T>,
    kinematics: Kinematics<T>,
    gravity: Vector3<T>,
    /// State of each body, and the index of its link if it is dynamic.
    bodies: Vec<(BodyState<T>, Option<usize>)>,
    /// Name of the body of each link.
    names: Vec<String>,
    /// Time (s).
    time: f64,
}

/// Derivatives of the inverse dynamics, with one row for each generalized force.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct InverseDynamicsDerivatives {
    /// With respect to positions, at constant velocities and accelerations.
    pub by_positions: DMatrix<f64>,
    /// With respect to generalized velocities.
    pub by_velocities: DMatrix<f64>,
    /// With respect to generalized accelerations: the mass matrix.
    pub by_accelerations: DMatrix<f64>,
}

/// Derivatives of the forward dynamics, with one row for each generalized acceleration.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ForwardDynamicsDerivatives {
    /// With respect to positions, at constant velocities and forces.
    pub by_positions: DMatrix<f64>,
    /// With respect to generalized velocities.
    pub by_velocities: DMatrix<f64>,
    /// With respect to generalized forces: M⁻¹.
    pub by_forces: DMatrix<f64>,
}

impl<T: Scalar, F: Force> World<T, F> {
    /// Terms of the equations of motion at a state. [`State::joints`] determines the poses and the twists of bodies on joints.
    ///
    /// # Errors
    /// If the state has another number of bodies or joints than the world, a pose that is not rigid, or a number that is not finite.
    pub fn kinetics(&self, state: &State<T>) -> Result<Kinetics<T>, WorldError> {
        state.check_fits(self.bodies())?;
        Ok(self.model.kinetics(state))
    }
}

impl<T: Scalar> Model<T> {
    /// Terms of the equations of motion at a state that fits the bodies.
    fn kinetics(&self, state: &State<T>) -> Kinetics<T> {
        let (multibody, kinematics) = self.kinematics_at(state);
        let mut updated = state.clone();
        multibody.store(&kinematics, &mut updated);
        let mut bodies: Vec<_> = updated
            .bodies
            .into_iter()
            .map(|body| (body, None))
            .collect();
        for (index, link) in multibody.links.iter().enumerate() {
            bodies[link.body].1 = Some(index);
        }
        let links = multibody.links.iter();
        let names = links.map(|link| self.bodies[link.body].name().to_owned());
        Kinetics {
            names: names.collect(),
            multibody,
            kinematics,
            gravity: self.gravity,
            bodies,
            time: state.time,
        }
    }
}

impl<T: Scalar> Kinetics<T> {
    /// Number n of generalized velocities.
    #[must_use]
    pub fn velocity_count(&self) -> usize {
        self.multibody.width()
    }

    /// Generalized velocities of the state.
    #[must_use]
    pub fn velocities(&self) -> &DVector<T> {
        self.kinematics.velocities()
    }

    /// Columns of the joint of the body with this index: 6 for a free body, 3 for a ball joint, 1 for a revolute or prismatic
    /// joint. The range is empty for a body that is welded, fixed or kinematic.
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn columns(&self, body: usize) -> Result<Range<usize>, WorldError> {
        let (_, link) = self.body(body)?;
        Ok(link.map_or(0..0, |link| self.multibody.links[link].columns.clone()))
    }

    /// Mass matrix M (n×n) with the armatures. The kinetic energy is ½ uᵀMu if all kinematic parents are at rest.
    #[must_use]
    pub fn mass_matrix(&self) -> DMatrix<T> {
        let matrices = self.multibody.mass_matrices(&self.kinematics);
        self.multibody.assembled(&matrices)
    }

    /// Bias b: generalized forces that keep the generalized velocities constant. It includes Coriolis, centrifugal and gravity forces.
    #[must_use]
    pub fn bias(&self) -> DVector<T> {
        self.forces_at(zeros(self.velocity_count()))
    }

    /// Gravity part of the bias: generalized forces that hold all bodies at rest.
    #[must_use]
    pub fn gravity_bias(&self) -> DVector<T> {
        let weights = self.multibody.links.iter().map(|link| {
            let weight = self.gravity.map(|component| component * link.inertia.mass);
            let torque = lift_vector(&Vector3::zeros());
            Wrench {
                torque,
                force: weight,
            }
            .to_vector()
        });
        let weights: Vec<_> = weights.collect();
        -self
            .multibody
            .generalized_forces(&self.kinematics, &weights)
    }

    /// Generalized forces of damping, friction, stops and actuators of the joints, at the time of the state.
    #[must_use]
    pub fn joint_forces(&self) -> DVector<T> {
        let coordinates = &self.kinematics.coordinates;
        self.multibody.joint_forces(coordinates, self.time)
    }

    /// Generalized forces of wrenches on bodies. Each item has the index of a body and a wrench about the origin of the body frame, in world
    /// axes, as in [`Contact::wrench`](super::Contact::wrench). Wrenches on fixed and kinematic bodies have no effect.
    ///
    /// # Errors
    /// If an index is not the index of a body, or the result is not finite.
    pub fn generalized_forces(
        &self,
        wrenches: &[(usize, Wrench<T>)],
    ) -> Result<DVector<T>, WorldError> {
        let zero = Wrench::zero().to_vector();
        let mut about_centers = vec![zero; self.multibody.links.len()];
        for (body, wrench) in wrenches {
            if let (state, Some(link)) = self.body(*body)? {
                let center = &self.multibody.links[link].inertia.center_of_mass;
                let offset = state.pose.rotated_constant(center);
                about_centers[link] += wrench.about(&offset).to_vector();
            }
        }
        let forces = self
            .multibody
            .generalized_forces(&self.kinematics, &about_centers);
        finite("generalized force", forces)
    }

    /// Jacobian J (6×n) of the velocity of a point (m, in the body frame) of the body with this index. J·u is the angular velocity (rad/s)
    /// followed by the velocity of the point (m/s), in world axes. The motion of a kinematic parent is not included. The Jacobian of a
    /// fixed or kinematic body is zero.
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn jacobian(&self, body: usize, point: &Vector3<T>) -> Result<Matrix6xX<T>, WorldError> {
        let (_, link) = self.body(body)?;
        Ok(match link {
            Some(link) => self.multibody.jacobian(&self.kinematics, link, point),
            None => Matrix6xX::from_element(self.velocity_count(), lift(0.0)),
        })
    }

    /// Jacobian (6×n) of the velocity of the center of mass of a body: see [`Self::jacobian`].
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn center_of_mass_jacobian(&self, body: usize) -> Result<Matrix6xX<T>, WorldError> {
        self.jacobian(body, &self.center_of_mass(body)?)
    }

    /// Bias acceleration J̇·u of a point of a body, in world axes: the angular acceleration (rad/s²), then the acceleration of the point
    /// (m/s²), if all generalized accelerations are zero. The arguments and frames are those of [`Self::jacobian`]. The bias acceleration
    /// includes the motion of a kinematic parent.
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn bias_acceleration(
        &self,
        body: usize,
        point: &Vector3<T>,
    ) -> Result<Vector6<T>, WorldError> {
        let (BodyState { pose, twist }, link) = self.body(body)?;
        let Some(link) = link else {
            let arm = pose.rotation() * point;
            let linear = twist.linear + twist.angular.cross(&arm);
            let angular = twist.angular;
            return Ok(convective(&Twist { angular, linear }.to_vector()));
        };
        let (multibody, kinematics) = (&self.multibody, &self.kinematics);
        let no_gravity = lift_vector(&Vector3::zeros());
        let rates = zeros(self.velocity_count());
        let accelerations = multibody.accelerations(kinematics, rates, &no_gravity);
        Ok(kinematics.point_acceleration(&accelerations, link, point))
    }

    /// Bias acceleration of the center of mass of a body: see [`Self::bias_acceleration`].
    ///
    /// # Errors
    /// If the world has no body with the index.
    pub fn center_of_mass_bias_acceleration(&self, body: usize) -> Result<Vector6<T>, WorldError> {
        self.bias_acceleration(body, &self.center_of_mass(body)?)
    }

    /// Generalized forces τ = M·u̇ + b that cause generalized accelerations u̇ (rad/s² or m/s²).
    ///
    /// # Errors
    /// - If the number of accelerations is not the [number of velocities](Self::velocity_count).
    /// - If the result is not finite.
    pub fn inverse_dynamics(&self, accelerations: &DVector<T>) -> Result<DVector<T>, WorldError> {
        self.check_size("generalized accelerations", accelerations)?;
        let forces = self.forces_at(accelerations.clone());
        finite("generalized force", forces)
    }

    /// Generalized accelerations u̇ = M⁻¹(τ − b) that generalized forces τ cause. Add [`Self::joint_forces`] to τ to include joint forces.
    ///
    /// # Errors
    /// - If the number of forces is not the [number of velocities](Self::velocity_count), or a joint moves no inertia.
    /// - If the world has loop joints.
    /// - If the result is not finite.
    pub fn forward_dynamics(&self, forces: &DVector<T>) -> Result<DVector<T>, WorldError> {
        self.check_size("generalized forces", forces)?;
        let accelerations = self.mass_factors()?.velocities(forces - self.bias());
        finite("generalized acceleration", accelerations)
    }

    fn mass_factors(&self) -> Result<MassFactors<T>, WorldError> {
        if !self.multibody.loops.is_empty() {
            return Err(WorldError::ForwardDynamicsOfLoops);
        }
        let factors = self.multibody.positive_mass_factors(&self.kinematics);
        factors.map_err(|link| WorldError::NoInertia(self.names[link].clone()))
    }

    fn forces_at(&self, accelerations: DVector<T>) -> DVector<T> {
        let accelerations = self.accelerations(accelerations);
        self.multibody
            .inverse_dynamics(&self.kinematics, &accelerations)
    }

    fn accelerations(&self, generalized: DVector<T>) -> Accelerations<T> {
        let kinematics = &self.kinematics;
        self.multibody
            .accelerations(kinematics, generalized, &self.gravity)
    }

    /// Center of mass of a dynamic body (m), in the body frame, or the origin of a fixed or kinematic body.
    fn center_of_mass(&self, body: usize) -> Result<Vector3<T>, WorldError> {
        let (_, link) = self.body(body)?;
        let center = |link: usize| self.multibody.links[link].inertia.center_of_mass;
        Ok(lift_vector(&link.map_or_else(Vector3::zeros, center)))
    }

    /// State of a body, and the index of its link if it is dynamic.
    fn body(&self, index: usize) -> Result<(&BodyState<T>, Option<usize>), WorldError> {
        let body = self.bodies.get(index);
        let (state, link) = body.ok_or(WorldError::BodyIndex {
            index,
            bodies: self.bodies.len(),
        })?;
        Ok((state, *link))
    }

    fn check_size(&self, quantity: &'static str, vector: &DVector<T>) -> Result<(), WorldError> {
        let (found, expected) = (vector.len(), self.velocity_count());
        if found == expected {
            return Ok(());
        }
        Err(WorldError::VelocityCount {
            quantity,
            found,
            expected,
        })
    }
}

impl Kinetics {
    /// Derivatives of [`Self::inverse_dynamics`] in closed form.
    ///
    /// # Errors
    /// As [`Self::inverse_dynamics`].
    pub fn inverse_dynamics_derivatives(
        &self,
        accelerations: &DVector<f64>,
    ) -> Result<InverseDynamicsDerivatives, WorldError> {
        self.check_size("generalized accelerations", accelerations)?;
        let accelerations = self.accelerations(accelerations.clone());
        let slopes = self
            .multibody
            .inverse_dynamics_slopes(&self.kinematics, &accelerations);
        let [by_positions, by_velocities] = slopes;
        for derivative in [&by_positions, &by_velocities] {
            check_finite("derivative of the generalized force", derivative.as_slice())?;
        }
        Ok(InverseDynamicsDerivatives {
            by_positions,
            by_velocities,
            by_accelerations: self.mass_matrix(),
        })
    }

    /// Derivatives of [`Self::forward_dynamics`] in closed form: −M⁻¹ times the derivatives of the inverse dynamics.
    ///
    /// # Errors
    /// As [`Self::forward_dynamics`].
    pub fn forward_dynamics_derivatives(
        &self,
        forces: &DVector<f64>,
    ) -> Result<ForwardDynamicsDerivatives, WorldError> {
        let inverse = self.inverse_dynamics_derivatives(&self.forward_dynamics(forces)?)?;
        let factors = self.mass_factors()?;
        let count = self.velocity_count();
        Ok(ForwardDynamicsDerivatives {
            by_positions: factors.velocities_of(&-inverse.by_positions),
            by_velocities: factors.velocities_of(&-inverse.by_velocities),
            by_forces: factors.velocities_of(&DMatrix::identity(count, count)),
        })
    }
}

/// Returns numbers that are finite.
fn finite<T: Scalar>(
    quantity: &'static str,
    numbers: DVector<T>,
) -> Result<DVector<T>, WorldError> {
    let real: Vec<f64> = numbers.iter().copied().map(real_part).collect();
    check_finite(quantity, &real)?;
    Ok(numbers)
}
