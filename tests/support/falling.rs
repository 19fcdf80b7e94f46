//! Random scenes of one to three bodies that fall on a floor and on each other.

use super::hulls::hull;
use super::scenes::Random;
use hydroelastic::contact::{HalfSpace, RigidShape, Shape};
use hydroelastic::dynamics::{Body, BodyState, KinematicPath, Mass, Material, World};
use hydroelastic::mesh::{PressureField, TriangleSurface, shapes};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, vector};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A world whose first bodies are dynamic and whose last body is the floor.
pub struct Scene {
    pub world: World,
    /// Shapes of all bodies, and moduli of compliant bodies.
    pub label: String,
    pub dynamic_count: usize,
}

/// Returns the scene with a number, which is the same in every run.
pub fn scene(number: u64) -> Scene {
    let mut random = Random::numbered(number);
    let dynamic_count = 1 + random.below(3);
    let (mut bodies, mut labels) = (Vec::new(), Vec::new());
    let mut top = 0.0;
    for index in 0..dynamic_count {
        let (body, label) = falling_body(&format!("body {index}"), &mut top, &mut random);
        bodies.push(body);
        labels.push(label);
    }
    let (floor, label) = floor(&mut random);
    bodies.push(floor);
    labels.push(label);
    let world = World::new(bodies).unwrap();
    Scene {
        world: world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap(),
        label: labels.join(", "),
        dynamic_count,
    }
}

/// Returns a body 5 to 20 cm above the height `top` (m), which increases to the top of the body.
fn falling_body(name: &str, top: &mut f64, random: &mut Random) -> (Body, String) {
    let (field, label) = shape(random);
    let vertices = field.mesh().vertices().iter();
    let radius = vertices.map(Vector3::norm).fold(0.0, f64::max);
    let height = *top + random.between(0.05, 0.2) + radius;
    *top = height + radius;

    let modulus = modulus(random);
    let skin = Material::elastic(modulus)
        .with_dissipation(random.between(0.05, 1.0))
        .with_friction(random.between(0.1, 0.8));
    let aside = random.vector() * 0.03;
    let position = vector![aside.x, aside.y, height];
    let velocity = vector![0.5, 0.5, 0.5].component_mul(&random.vector()) - vector![0.0, 0.0, 0.5];
    let mass = Mass::Total(random.between(0.2, 1.0));
    let body = Body::dynamic(name, Shape::new(field), skin, mass).unwrap();
    let body = body
        .with_pose(Pose::from_rotation_vector(
            &random.rotation_vector(),
            position,
        ))
        .with_velocity(velocity)
        .with_angular_velocity(random.vector() * 4.0);
    (body, format!("{label} {modulus:.0e}"))
}

/// Returns a shape of 4 to 10 cm from its center to its farthest vertex.
fn shape(random: &mut Random) -> (PressureField, &'static str) {
    let size = random.between(0.04, 0.1);
    let flattened = size * random.between(0.5, 1.0);
    match random.below(6) {
        0 => (shapes::icosphere(size, 1).unwrap(), "coarse ball"),
        1 => (shapes::icosphere(size, 2).unwrap(), "ball"),
        2 => {
            let edges = [1.4 * size, 1.1 * size, 0.9 * flattened];
            (shapes::cuboid(edges).unwrap(), "box")
        }
        3 => {
            let segments = 5 + random.below(8);
            let field = shapes::cylinder(0.7 * size, 1.4 * flattened, segments);
            (field.unwrap(), "cylinder")
        }
        4 => (hull(corners(4, size, random)), "tetrahedron"),
        _ => {
            let count = 8 + random.below(6);
            (hull(corners(count, size, random)), "hull")
        }
    }
}

/// Returns points on a sphere around the origin that are far enough apart for their hull to contain the center.
fn corners(count: usize, radius: f64, random: &mut Random) -> Vec<Vector3<f64>> {
    // The mean distance of neighbors is proportional to the inverse square root of their number.
    let apart = 2.4 / (count as f64).sqrt();
    loop {
        let mut directions: Vec<Vector3<f64>> = Vec::new();
        for _ in 0..20 * count {
            let direction = random.direction();
            let is_free =
                |taken_direction: &Vector3<f64>| (direction - taken_direction).norm() > apart;
            if directions.len() < count && directions.iter().all(is_free) {
                directions.push(direction);
            }
        }
        if directions.len() == count {
            return directions.iter().map(|point| point * radius).collect();
        }
    }
}

/// Returns a log-uniform modulus (Pa).
fn modulus(random: &mut Random) -> f64 {
    10_f64.powf(random.between(3e5_f64.log10(), 9.0))
}

/// Returns a floor with its top at height 0, at rest or on a path, rigid or compliant.
fn floor(random: &mut Random) -> (Body, String) {
    let friction = random.between(0.1, 0.8);
    let hard = Material::rigid().with_friction(friction);
    let block = shapes::cuboid([2.0, 2.0, 0.4]).unwrap();
    let below = Pose::from_translation(vector![0.0, 0.0, -0.2]);
    let modulus = modulus(random);
    let skin = Material::elastic(modulus)
        .with_dissipation(random.between(0.05, 1.0))
        .with_friction(friction);
    let path = path(random);
    match random.below(5) {
        0 => {
            let floor = Body::fixed("floor", HalfSpace::rigid(), hard).unwrap();
            (floor, "half-space".into())
        }
        1 => {
            let block = RigidShape::new(TriangleSurface::around(block.mesh()).unwrap());
            let floor = Body::fixed("floor", block, hard).unwrap();
            (floor.with_pose(below), "rigid block".into())
        }
        2 => {
            let floor = Body::fixed("floor", Shape::new(block), skin).unwrap();
            (floor.with_pose(below), format!("block {modulus:.0e}"))
        }
        3 => {
            let floor = Body::kinematic("floor", HalfSpace::rigid(), hard, path).unwrap();
            (floor, "moving half-space".into())
        }
        _ => {
            let paddle = Shape::new(shapes::cuboid([0.5, 0.4, 0.04]).unwrap());
            let paddle = Body::kinematic("paddle", paddle, skin, path).unwrap();
            (paddle, format!("paddle {modulus:.0e}"))
        }
    }
}

/// Returns a path that oscillates vertically, sideways and about y, at up to 0.6 m/s and 0.6 rad/s.
fn path(random: &mut Random) -> Arc<KinematicPath> {
    let [up, aside, tilt] = [0.03, 0.03, 0.03].map(|size| random.between(-size, size));
    let [rate, phase] = [
        random.between(1.0, 3.0) * TAU,
        random.between(0.0, 2.0 * PI),
    ];
    Arc::new(move |time: f64| {
        let (sine, cosine) = (rate * time + phase).sin_cos();
        let position = vector![aside * sine, 0.0, up * sine - 0.02];
        BodyState {
            pose: Pose::from_rotation_vector(&vector![0.0, tilt * sine, 0.0], position),
            twist: Twist {
                angular: vector![0.0, tilt * rate * cosine, 0.0],
                linear: vector![aside, 0.0, up] * (rate * cosine),
            },
        }
    })
}
