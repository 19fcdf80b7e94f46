use super::ForceNumber;
use super::{Force, ForceContext, WrenchAccumulator};
use crate::dynamics::body::{index_of, require_index_of};
use crate::dynamics::validate::check_finite;
use crate::dynamics::{Body, WorldError};
use crate::scalar::{Scalar, real_part, real_vector};
use crate::spatial::Wrench;
use std::slice;

/// Spring and damper between points of two bodies, along the line that joins the points.
///
/// The force on the first point is k·r − k·L·d + c·(v·d)·d, with the stiffness k, the damping c and the rest length L. The vector r points
/// from the first point to the second, v is its rate of change and d its direction. Without rest length and damping the force is linear in
/// r, so it has derivatives even if the points coincide.
///
/// The direction d is undefined if the points are closer than a billionth of the rest length, or closer than the rounding error of their
/// coordinates. The force is then k·r + c·v.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Spring {
    /// Names of the bodies.
    pub bodies: [String; 2],
    /// Point (m) of each body, in its body frame.
    pub points: [[f64; 3]; 2],
    /// Rest length (m), at which the spring has no force.
    pub rest_length: ForceNumber,
    /// Stiffness (N/m).
    pub stiffness: ForceNumber,
    /// Damping (N s/m).
    pub damping: ForceNumber,
}

/// Drag that is proportional to the velocity and the spin of a body.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Drag {
    /// Name of the body.
    pub body: String,
    /// Force divided by the velocity of the center of mass (N s/m).
    pub linear: ForceNumber,
    /// Torque divided by the spin (N m s/rad).
    pub angular: ForceNumber,
}

/// Constant force in the body frame, which turns with the body.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Thruster {
    /// Name of the body.
    pub body: String,
    /// Point of application (m), in the body frame.
    pub point: [f64; 3],
    /// Force (N), in the body frame.
    pub force: [f64; 3],
}

/// A spring shorter than this fraction of its rest length has no direction. The derivatives of the direction would exceed the derivatives
/// of the length by the inverse of this fraction.
const NO_LENGTH: f64 = 1e-9;

/// Rounding-error bound of the difference of two points, relative to their coordinates, with a margin of about 50.
const ROUNDING: f64 = 1e-14;

impl Force for Spring {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let [Some(a), Some(b)] = self.bodies.each_ref().map(|name| now.index_of(name)) else {
            return;
        };
        let [point_a, velocity_a] = now.point(a, &self.points[0].into());
        let [point_b, velocity_b] = now.point(b, &self.points[1].into());
        let line = point_b - point_a;
        let parting = velocity_b - velocity_a;
        let [rest_length, stiffness, damping] =
            [&self.rest_length, &self.stiffness, &self.damping].map(|number| number.value(now));
        let reach = real_vector(&point_a).amax() + real_vector(&point_b).amax();
        let least = (NO_LENGTH * real_part(rest_length)).max(ROUNDING * reach);
        let pull = if real_vector(&line).norm() <= least {
            line * stiffness + parting * damping
        } else {
            let length = line.dot(&line).sqrt();
            let direction = line / length;
            let tension = (length - rest_length) * stiffness + parting.dot(&direction) * damping;
            direction * tension
        };
        wrenches.apply_force_at_point(a, &pull, &point_a);
        wrenches.apply_force_at_point(b, &-pull, &point_b);
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        together(&self.bodies, bodies)
    }

    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        let [a, b] = &self.bodies;
        if a == b {
            return Err(WorldError::SameBody(a.clone()));
        }
        let moves = |name| Ok(bodies[require_index_of(name, bodies)?].inertia().is_some());
        if !(moves(a)? | moves(b)?) {
            return Err(WorldError::NeitherDynamic {
                bodies: self.bodies.clone(),
                quantity: "spring",
            });
        }
        self.rest_length
            .check("rest length of a spring", parameters)?;
        self.stiffness.check("stiffness of a spring", parameters)?;
        self.damping.check("damping of a spring", parameters)?;
        check_finite("point of a spring", self.points.as_flattened())
    }
}

impl Force for Drag {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        if let Some(body) = now.index_of(&self.body) {
            let twist = &now.states[body].twist;
            let torque = twist.angular * -self.angular.value(now);
            let force = twist.linear * -self.linear.value(now);
            wrenches.add(body, &Wrench { torque, force });
        }
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        together(slice::from_ref(&self.body), bodies)
    }

    fn check(&self, bodies: &[Body], parameters: &[(String, f64)]) -> Result<(), WorldError> {
        check_dynamic(&self.body, "drag", bodies)?;
        self.linear.check("drag on the velocity", parameters)?;
        self.angular.check("drag on the spin", parameters)
    }
}

impl Force for Thruster {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        if let Some(body) = now.index_of(&self.body) {
            let force = now.states[body].pose.rotated_constant(&self.force.into());
            let [point, _] = now.point(body, &self.point.into());
            wrenches.apply_force_at_point(body, &force, &point);
        }
    }

    fn coupling_groups(&self, bodies: &[Body]) -> Vec<Vec<usize>> {
        together(slice::from_ref(&self.body), bodies)
    }

    fn check(&self, bodies: &[Body], _: &[(String, f64)]) -> Result<(), WorldError> {
        check_dynamic(&self.body, "thruster", bodies)?;
        check_finite("point of a thruster", &self.point)?;
        check_finite("force of a thruster", &self.force)
    }
}

/// Indices of the bodies with these names, as one group.
fn together(names: &[String], bodies: &[Body]) -> Vec<Vec<usize>> {
    let indices = names.iter().filter_map(|name| index_of(name, bodies));
    vec![indices.collect()]
}

/// Checks that there is a dynamic body with this name.
fn check_dynamic(name: &str, quantity: &'static str, bodies: &[Body]) -> Result<(), WorldError> {
    match bodies[require_index_of(name, bodies)?].inertia() {
        Some(_) => Ok(()),
        None => Err(WorldError::NotDynamic {
            body: name.to_owned(),
            quantity,
        }),
    }
}
