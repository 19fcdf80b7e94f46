//! Poses, shapes, materials, bodies, worlds and plans, each in one call.

use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{Body, BodyShape, Integrator, Mass, Material, Plan, World};
use hydroelastic::gradient::Parameter;
use hydroelastic::mesh::{PressureField, TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Vector3, vector};

/// Acceleration of free fall (m/s²).
pub const GRAVITY: f64 = 9.81;

pub const EXPLICIT: [Integrator; 2] = [Integrator::Leapfrog, Integrator::SymplecticEuler];
pub const IMPLICIT: [Integrator; 2] = [Integrator::Sdirk3, Integrator::ImplicitEuler];

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_translation(vector![x, y, z])
}

/// Returns the pose with a rotation vector and a position.
pub fn turned(turn: [f64; 3], place: [f64; 3]) -> Pose {
    Pose::from_rotation_vector(&turn.into(), place.into())
}

pub fn cuboid(edges: [f64; 3]) -> Shape {
    Shape::new(shapes::cuboid(edges).unwrap())
}

pub fn icosphere(radius: f64, order: usize) -> Shape {
    Shape::new(shapes::icosphere(radius, order).unwrap())
}

/// Returns the surface of a field's mesh as a rigid shape.
pub fn rigid(field: &PressureField) -> RigidShape {
    RigidShape::new(TriangleSurface::around(field.mesh()).unwrap())
}

pub fn rubbing(modulus: f64, dissipation: f64, friction: f64) -> Material {
    Material::elastic(modulus)
        .with_dissipation(dissipation)
        .with_friction(friction)
}

/// Returns a dynamic body with a mass (kg).
pub fn dynamic(name: &str, shape: impl Into<BodyShape>, skin: Material, mass: f64) -> Body {
    Body::dynamic(name, shape, skin, Mass::Total(mass)).unwrap()
}

pub fn fixed(name: &str, shape: impl Into<BodyShape>, skin: Material) -> Body {
    Body::fixed(name, shape, skin).unwrap()
}

/// Returns the half-space below z = 0.
pub fn rigid_floor(friction: f64) -> Body {
    let skin = Material::rigid().with_friction(friction);
    fixed("floor", HalfSpace::rigid(), skin)
}

pub fn down() -> Vector3<f64> {
    vector![0.0, 0.0, -GRAVITY]
}

/// Returns a world with gravity along −z.
pub fn falling(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(down()).unwrap()
}

pub fn sliding_at(linear: Vector3<f64>) -> Twist {
    let angular = Vector3::zeros();
    Twist { angular, linear }
}

/// Returns the wrench of a force (N) through the origin.
pub fn push(force: [f64; 3]) -> Wrench {
    let (torque, force) = (Vector3::zeros(), force.into());
    Wrench { torque, force }
}

/// Returns a plan with an integrator.
pub fn plan_of(integrator: Integrator, time_step: f64, steps: usize) -> Plan {
    let plan = Plan::new(time_step, steps).unwrap();
    plan.with_integrator(integrator)
}

/// Returns the parameters of a body's initial state.
pub fn starts(name: &str) -> [Parameter; 4] {
    [
        Parameter::initial_position(name),
        Parameter::initial_orientation(name),
        Parameter::initial_velocity(name),
        Parameter::initial_angular_velocity(name),
    ]
}
