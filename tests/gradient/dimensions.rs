//! Derivatives of rollouts with respect to the dimensions of built-in shapes, and with respect to the mesh of a distance field, through
//! contact and through mass.

use crate::support::differences::compare_slope;
use crate::support::moved_meshes::moved_mesh;
use crate::support::worlds::{falling, rubbing};
use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::gradient::{Experiment, HoldFixed, Integrand, RolloutGradient, TimeIntegral};
use hydroelastic::mesh::{PressureField, ShapeRates, TetMesh, shapes};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Error of [`compare_slope`]: rounding of values of 0.03 divided by the steps, and polygons that change within the steps.
const DIFFERENCES: f64 = 1e-8;

/// A scalar of a body's motion: its position, rotation and angular velocity.
struct Motion;

impl Integrand for Motion {
    fn at<T: Scalar>(&self, state: &State<T>) -> T {
        let body = &state.bodies[0];
        let (at, spin) = (body.position(), body.twist.angular);
        at.z + at.x * 0.3 + body.pose.rotation()[(2, 0)] * 0.2 + spin.dot(&spin) * 0.01
    }
}

fn plan() -> Plan {
    Plan::new(5e-4, 300).unwrap()
}

/// Returns the body above a rigid floor, rotated and moving.
fn world(shape: PressureField, mass: Mass, turn: Vector3<f64>, height: f64) -> World {
    let skin = rubbing(1e5, 0.2, 0.3);
    let body = Body::dynamic("body", Shape::new(shape), skin, mass).unwrap();
    let body = body.with_pose(Pose::from_rotation_vector(&turn, vector![0.0, 0.0, height]));
    let floor = Body::fixed(
        "floor",
        HalfSpace::rigid(),
        Material::rigid().with_friction(0.3),
    );
    let world = falling(vec![body, floor.unwrap()]);
    world.with_slip_tolerance(0.05).unwrap()
}

fn gradient(world: &World) -> RolloutGradient {
    let experiment = Experiment::new(world, &plan());
    experiment.full_gradient(&TimeIntegral(Motion)).unwrap()
}

fn value(world: &World) -> f64 {
    let experiment = Experiment::new(world, &plan());
    experiment.value(&TimeIntegral(Motion)).unwrap()[0]
}

fn compare(slope: f64, value: impl Fn(f64) -> f64, label: &str) {
    compare_slope((slope, DIFFERENCES), value, label);
}

/// Returns all variants of `HoldFixed`, each with a mass: that of the given shape.
fn masses(field: &PressureField) -> [(HoldFixed, Mass); 3] {
    let properties = field.mesh().mass_properties(250.0).unwrap();
    [
        (HoldFixed::Density, Mass::Density(250.0)),
        (HoldFixed::Mass, Mass::Total(properties.mass)),
        (HoldFixed::MassProperties, Mass::Properties(properties)),
    ]
}

#[test]
fn a_ball_that_bounces_by_its_radius() {
    let ball = |radius: f64| shapes::icosphere(radius, 2).unwrap();
    let rates = shapes::icosphere_rates(0.1, 2).unwrap();
    for (keeping, mass) in masses(&ball(0.1)) {
        let of = |radius: f64| world(ball(radius), mass, vector![0.3, 0.2, 0.1], 0.12);
        let by_shape = gradient(&of(0.1)).by_shape("body", keeping).unwrap();
        let slope = by_shape.along(&rates).unwrap();
        compare(
            slope,
            |change| value(&of(0.1 + change)),
            &format!("{keeping:?}"),
        );
    }
}

/// A box as a function of its edges, with its rates.
type Maker = fn([f64; 3]) -> (PressureField, [ShapeRates; 3]);

/// The box is at rest, flush on the floor and slightly pressed in, or falls on a corner.
#[test]
fn a_box_by_its_edges() {
    let edges = [0.2, 0.3, 0.15];
    let makers: [(&str, Maker); 2] = [
        ("box", |edges| {
            let rates = shapes::cuboid_rates(edges).unwrap();
            (shapes::cuboid(edges).unwrap(), rates)
        }),
        ("distance box", |edges| {
            let rates = shapes::distance_cuboid_rates(edges).unwrap();
            (shapes::distance_cuboid(edges).unwrap(), rates)
        }),
    ];
    for (name, maker) in makers {
        let (field, rates) = maker(edges);
        for (turn, height) in [(Vector3::zeros(), 0.0749), (vector![0.5, 0.4, 0.3], 0.19)] {
            for (keeping, mass) in masses(&field) {
                let of = |edges: [f64; 3]| world(maker(edges).0, mass, turn, height);
                let by_shape = gradient(&of(edges)).by_shape("body", keeping).unwrap();
                for (axis, rates) in rates.iter().enumerate() {
                    let value = |change: f64| {
                        let mut edges = edges;
                        edges[axis] += change;
                        value(&of(edges))
                    };
                    let slope = by_shape.along(rates).unwrap();
                    compare(slope, value, &format!("{name} {axis} {keeping:?} {height}"));
                }
            }
        }
    }
}

#[test]
fn a_body_by_the_mesh_below_its_field_of_distances() {
    let number = |i: usize| (1.0 + 7.3 * i as f64).sin() * 0.1;
    let velocities = |from: usize| -> Vec<Vector3<f64>> {
        let velocity = |v: usize| Vector3::from_fn(|axis, _| number(from + 3 * v + axis));
        (0..43).map(velocity).collect()
    };
    let potato = shapes::ellipsoid([0.1, 0.12, 0.08], 1).unwrap();
    // A mesh without symmetries.
    let mesh = moved_mesh(potato.mesh(), &velocities(500), 0.03);
    let velocities = velocities(0);
    for depth in [None, Some(0.02)] {
        let made = |mesh: &TetMesh| match depth {
            None => PressureField::linearized_from_distance(mesh).unwrap(),
            Some(depth) => PressureField::linearized_from_distance_up_to(mesh, depth).unwrap(),
        };
        let (field, distances) = made(&mesh);
        assert!(distances.ambiguous().is_empty());
        let of = |field| world(field, Mass::Density(250.0), vector![0.3, 0.2, 0.1], 0.12);
        let by_shape = gradient(&of(field))
            .by_shape("body", HoldFixed::Density)
            .unwrap();
        let by_mesh = distances.pullback(&by_shape.by_vertices, &by_shape.by_extents);
        let by_mesh = by_mesh.unwrap().by_vertices;
        let pairs = by_mesh.iter().zip(&velocities);
        let slope = pairs.map(|(by, velocity)| by.dot(velocity)).sum();
        let value = |time: f64| value(&of(made(&moved_mesh(&mesh, &velocities, time)).0));
        compare(slope, value, &format!("{depth:?}"));
    }
}
