//! Derivatives of rollouts with respect to the shapes of bodies, through contact and through their mass.

use crate::support::differences::compare_slope;
use crate::support::moved_meshes::moved_mesh;
use crate::support::reference::{read, scaled_shape, shape};
use crate::support::worlds::{IMPLICIT, at, falling, fixed, icosphere, plan_of};
use hydroelastic::contact::{HalfSpace, Shape, ShapeGradient};
use hydroelastic::dynamics::{
    Body, BodyShape, BodyState, Force, Integrator, Mass, Material, Plan, Thruster, Trajectory,
    World,
};
use hydroelastic::gradient::{Experiment, GradientError, HoldFixed, Mode, Outcome, Parameter};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Vector3, vector};
use serde::Deserialize;
use std::sync::Arc;

/// Error of [`compare_slope`].
const DIFFERENCES: f64 = 1e-7;

/// Error of [`compare_slope`] with implicit steps, whose stages are solved to 1e-13 only.
pub const IMPLICIT_DIFFERENCES: f64 = 1e-6;

/// Rounding error of hundreds of steps. The independent program used complex steps, which have no other error.
const SAME: f64 = 1e-11;

#[derive(Deserialize)]
struct File {
    trajectory: Vec<Case>,
}

/// A ball thrown on a fixed cube: final position, rows of the rotation matrix, angular velocity and velocity.
#[derive(Deserialize)]
struct Case {
    density: f64,
    end: Vec<f64>,
    by_scale: Vec<f64>,
    #[serde(rename = "by_E_ball")]
    by_modulus: Vec<f64>,
    by_start_z: Vec<f64>,
}

/// A component of the first body's final state, in the order of the file.
struct Number(usize);

impl Outcome for Number {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let body = &trajectory.last().bodies[0];
        let rows = body.pose.rotation().transpose();
        let pose = body.pose.translation().iter().chain(rows.iter());
        let twist = body.twist.angular.iter().chain(&body.twist.linear);
        let numbers: Vec<T> = pose.chain(twist).copied().collect();
        vec![numbers[self.0]]
    }
}

#[test]
fn a_ball_by_its_size_equals_an_independent_program() {
    let File { trajectory } = read("partners.json");
    let [case] = &trajectory[..] else {
        panic!("expected one case");
    };
    let (ball, cube) = (scaled_shape("ico1", 0.1), shape("cube"));
    let elastic = Material::elastic;
    let ball = Body::dynamic("ball", ball, elastic(1e5), Mass::Density(case.density)).unwrap();
    let ball = ball
        .with_pose(at(0.46, -0.013, 0.115))
        .with_angular_velocity(vector![3.0, -5.0, 2.0])
        .with_velocity(vector![0.3, 0.2, -0.4]);
    let cube = fixed("cube", cube, elastic(4e5));
    let cube = cube.with_pose(at(0.0, 0.0, -0.5));
    let vertices = match ball.shape() {
        BodyShape::Compliant(shape) => shape.field().mesh().vertices().to_vec(),
        _ => unreachable!("a ball is compliant"),
    };
    let world = falling(vec![ball, cube]);
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 200).unwrap().recording_every(200));
    let largest = |numbers: &[f64]| numbers.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for number in 0..18 {
        let full_gradient = experiment.full_gradient(&Number(number)).unwrap();
        let by_vertices = full_gradient
            .by_shape("ball", HoldFixed::Density)
            .unwrap()
            .by_vertices;
        let by_scale = along(&by_vertices, &vertices);
        let by_modulus = full_gradient.by(&Parameter::modulus("ball")).unwrap()[0];
        let by_height = full_gradient
            .by(&Parameter::initial_position("ball"))
            .unwrap()[2];
        for (actual, expected) in [
            (full_gradient.value, &case.end),
            (by_scale, &case.by_scale),
            (by_modulus, &case.by_modulus),
            (by_height, &case.by_start_z),
        ] {
            let error = (actual - expected[number]).abs() / largest(expected);
            assert!(error <= SAME, "{number}: {actual} for {}", expected[number]);
        }
    }
}

/// Weighted sum of squares of the components of all final states.
pub struct Squares;

impl Outcome for Squares {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let mut sum = lift::<T>(0.0);
        for body in &trajectory.last().bodies {
            let pose = body.pose.translation().iter().chain(body.pose.rotation());
            let twist = body.twist.linear.iter().chain(&body.twist.angular);
            for (factor, number) in (1..).zip(pose.chain(twist)) {
                sum += *number * *number * f64::from(factor).sin();
            }
        }
        vec![sum]
    }
}

/// Returns a field whose vertices move while each keeps its extent.
pub fn moved(field: &PressureField, velocities: &[Vector3<f64>], time: f64) -> Shape {
    let mesh = moved_mesh(field.mesh(), velocities, time);
    Shape::new(PressureField::new(mesh, field.extents().to_vec()).unwrap())
}

/// Returns the body thrown on a block on a floor.
fn thrown(shape: Shape, block: Shape, mass: Mass, law: [f64; 2]) -> World {
    let skin = |modulus| {
        let material = Material::elastic(modulus).with_dissipation(law[0]);
        material.with_friction(law[1])
    };
    let body = Body::dynamic("body", shape, skin(1e5), mass).unwrap();
    let turn = vector![0.3, 0.2, 0.5];
    let body = body
        .with_pose(Pose::from_rotation_vector(&turn, vector![0.02, 0.01, 0.24]))
        .with_velocity(vector![0.3, 0.4, -1.0])
        .with_angular_velocity(vector![3.0, -2.0, 1.0]);
    let block = Body::dynamic("block", block, skin(4e5), Mass::Density(400.0)).unwrap();
    let block = block.with_pose(at(0.0, 0.0, 0.098));
    let floor = fixed("floor", HalfSpace::layer(0.05).unwrap(), skin(2e5));
    let world = falling(vec![body, block, floor]);
    world.with_slip_tolerance(0.05).unwrap()
}

pub fn loss(world: &World, plan: &Plan) -> f64 {
    Experiment::new(world, plan).value(&Squares).unwrap()[0]
}

/// Returns pseudorandom velocities of the vertices, of the size of the body per second.
pub fn velocities(field: &PressureField) -> Vec<Vector3<f64>> {
    let number = |i: usize| (1.0 + 7.3 * i as f64).sin() * 0.1;
    let count = field.mesh().vertex_count();
    let velocity = |vertex: usize| Vector3::from_fn(|axis, _| number(3 * vertex + axis));
    (0..count).map(velocity).collect()
}

fn compare(slope: f64, value: impl Fn(f64) -> f64, label: &str) {
    compare_slope((slope, DIFFERENCES), value, label);
}

/// Returns the directional derivative along velocities of the vertices.
pub fn along(by_vertices: &[Vector3<f64>], velocities: &[Vector3<f64>]) -> f64 {
    let pairs = by_vertices.iter().zip(velocities);
    pairs.map(|(by, velocity)| by.dot(velocity)).sum()
}

#[test]
fn vertices_of_bodies_through_contact_and_mass_equal_differences() {
    let plan = Plan::new(5e-4, 240).unwrap().recording_every(240);
    let block = shapes::cuboid([0.3, 0.26, 0.2]).unwrap();
    let bodies = [
        ("potato", shapes::ellipsoid([0.1, 0.12, 0.08], 1).unwrap()),
        ("ball", shapes::icosphere(0.1, 1).unwrap()),
        ("prism", shapes::cylinder(0.1, 0.17, 5).unwrap()),
        ("coin", shapes::cylinder(0.1, 0.06, 6).unwrap()),
    ];
    for (name, field) in bodies {
        for law in [[0.0; 2], [0.4, 0.3]] {
            let velocities = velocities(&field);
            let shape = |time| moved(&field, &velocities, time);
            let original = Arc::new(shape(0.0));
            let density = 300.0;
            let mass = original.field().mesh().mass_properties(density).unwrap();
            let of = |time: f64, mass: Mass| {
                let block = moved(&block, &vec![Vector3::zeros(); 9], 0.0);
                loss(&thrown(shape(time), block, mass, law), &plan)
            };
            for (keeping, mass) in [
                (HoldFixed::Density, Mass::Density(density)),
                (HoldFixed::Mass, Mass::Total(mass.mass)),
                (HoldFixed::MassProperties, Mass::Properties(mass)),
            ] {
                let block = moved(&block, &vec![Vector3::zeros(); 9], 0.0);
                let world = thrown(shape(0.0), block, mass, law);
                let gradient = Experiment::new(&world, &plan)
                    .full_gradient(&Squares)
                    .unwrap();
                let by_vertices = gradient.by_shape("body", keeping).unwrap().by_vertices;
                let rate = along(&by_vertices, &velocities);
                compare(
                    rate,
                    |time| of(time, mass),
                    &format!("{name} {keeping:?} {law:?}"),
                );
            }
        }
    }
}

#[test]
fn vertices_through_implicit_steps_equal_differences() {
    let block = shapes::cuboid([0.3, 0.26, 0.2]).unwrap();
    let still = vec![Vector3::zeros(); 9];
    for integrator in IMPLICIT {
        let plan = plan_of(integrator, 4e-3, 30);
        let plan = plan
            .recording_every(30)
            .with_solver_tolerance(1e-13)
            .unwrap();
        for (name, field) in [
            ("potato", shapes::ellipsoid([0.1, 0.12, 0.08], 1).unwrap()),
            ("ball", shapes::icosphere(0.1, 1).unwrap()),
        ] {
            for law in [[0.0; 2], [0.4, 0.3]] {
                let velocities = velocities(&field);
                let world = |time: f64| {
                    let shape = moved(&field, &velocities, time);
                    thrown(shape, moved(&block, &still, 0.0), Mass::Density(300.0), law)
                };
                let gradient = Experiment::new(world(0.0), &plan)
                    .full_gradient(&Squares)
                    .unwrap();
                let by_vertices = gradient
                    .by_shape("body", HoldFixed::Density)
                    .unwrap()
                    .by_vertices;
                let rate = along(&by_vertices, &velocities);
                let value = |time: f64| loss(&world(time), &plan);
                let label = format!("{name} {integrator:?} {law:?}");
                compare_slope((rate, IMPLICIT_DIFFERENCES), value, &label);
            }
        }
    }
}

#[test]
fn both_bodies_of_a_contact_and_their_extents_equal_differences() {
    let plan = Plan::new(5e-4, 240).unwrap().recording_every(240);
    let field = shapes::ellipsoid([0.1, 0.12, 0.08], 1).unwrap();
    let block = shapes::cuboid([0.3, 0.26, 0.2]).unwrap();
    let (still, rates) = (vec![Vector3::zeros(); 43], velocities(&block));
    let world = |time: f64| {
        let (body, block) = (moved(&field, &still, 0.0), moved(&block, &rates, time));
        thrown(body, block, Mass::Density(300.0), [0.4, 0.3])
    };
    let gradient = Experiment::new(world(0.0), &plan)
        .full_gradient(&Squares)
        .unwrap();
    let by_vertices = gradient
        .by_shape("block", HoldFixed::Density)
        .unwrap()
        .by_vertices;
    let rate = along(&by_vertices, &rates);
    compare(rate, |time| loss(&world(time), &plan), "block");
    let grown = |time: f64| {
        let extents = field
            .extents()
            .iter()
            .map(|extent| extent * (1.0 + time))
            .collect();
        let field = PressureField::new(field.mesh().clone(), extents).unwrap();
        thrown(
            Shape::new(field),
            moved(&block, &rates, 0.0),
            Mass::Density(300.0),
            [0.4, 0.3],
        )
    };
    let by_extents = gradient
        .by_shape("body", HoldFixed::Density)
        .unwrap()
        .by_extents;
    let rate = by_extents
        .iter()
        .zip(field.extents())
        .map(|(by, extent)| by * extent)
        .sum();
    compare(rate, |time| loss(&grown(time), &plan), "extents");
}

#[test]
fn a_mass_that_is_not_spread_over_the_shape_is_told() {
    let ball = || icosphere(0.1, 1);
    let mass = Mass::Properties(MassProperties::solid_ball(1.0, 0.1));
    let world = thrown(ball(), ball(), mass, [0.0; 2]);
    let experiment = Experiment::new(&world, &Plan::new(5e-4, 3).unwrap());
    let gradient = experiment.full_gradient(&Squares).unwrap();
    gradient
        .by_shape("body", HoldFixed::MassProperties)
        .unwrap();
    let refused = gradient.by_shape("body", HoldFixed::Density);
    assert_eq!(
        refused.unwrap_err(),
        GradientError::NotUniform("body".into())
    );
    gradient.by_shape("block", HoldFixed::Density).unwrap();
}

#[test]
fn forces_that_may_depend_on_a_center_of_mass_are_told() {
    fn by_mass<F: Force>(world: &World<f64, F>) -> Result<ShapeGradient, GradientError> {
        let plan = Plan::new(5e-4, 3).unwrap();
        let gradient = Experiment::new(world, &plan)
            .full_gradient(&Squares)
            .unwrap();
        gradient
            .by_shape("body", HoldFixed::MassProperties)
            .unwrap();
        gradient.by_shape("body", HoldFixed::Density)
    }
    let ball = || icosphere(0.1, 1);
    let world = thrown(ball(), ball(), Mass::Total(1.0), [0.0; 2]);
    by_mass(&world).unwrap();
    let thruster = Thruster {
        body: "body".into(),
        point: [0.0, 0.0, 0.1],
        force: [0.4, 0.2, 0.5],
    };
    let pushed = by_mass(&world.with_forces(thruster).unwrap());
    assert_eq!(
        pushed.unwrap_err(),
        GradientError::ForcesByCenter("body".into())
    );
}

/// Shape derivatives in reverse mode and all other derivatives in forward mode equal a change of the unit of length. Lengths, velocities
/// and gravity grow by λ, pressures at equal extents by 1/λ, and masses and times do not change. Then final positions and velocities grow
/// by λ. The test uses no differences.
#[test]
fn sizes_backwards_and_all_else_forwards_are_a_change_of_the_unit_of_length() {
    let field = shapes::ellipsoid([0.1, 0.12, 0.08], 2).unwrap();
    let block = shapes::cuboid([0.3, 0.26, 0.2]).unwrap();
    let shape = |field: &PressureField| Shape::new(field.clone());
    let bodies = [("body", &field), ("block", &block)];
    for (integrator, time_step, steps) in [
        (Integrator::Leapfrog, 5e-4, 240),
        (Integrator::SymplecticEuler, 5e-4, 240),
        (Integrator::Sdirk3, 5e-3, 24),
        (Integrator::ImplicitEuler, 5e-3, 24),
    ] {
        for dissipation in [0.0, 0.4] {
            let world = thrown(
                shape(&field),
                shape(&block),
                Mass::Total(2.0),
                [dissipation, 0.0],
            );
            let plan = Plan::new(time_step, steps).unwrap().recording_every(steps);
            let plan = plan
                .with_solver_tolerance(1e-13)
                .unwrap()
                .with_integrator(integrator);
            let experiment = Experiment::new(&world, &plan);
            let backwards = experiment.full_gradient(&Squares).unwrap();
            let by_vertices = |(name, field): (&str, &PressureField)| -> f64 {
                let by = backwards
                    .by_shape(name, HoldFixed::Mass)
                    .unwrap()
                    .by_vertices;
                along(&by, field.mesh().vertices())
            };
            let by_sizes = bodies.map(by_vertices);
            let (by, rates) = all_but_sizes(&world, dissipation);
            let (_, forwards) = experiment
                .gradient_with_mode(Mode::Forward, &by, &Squares)
                .unwrap();
            let terms = forwards.iter().zip(&rates).map(|(by, rate)| by * rate);
            let terms: Vec<f64> = terms.chain(by_sizes).collect();
            let expected = growth(&experiment.trajectory().unwrap());
            let largest = terms
                .iter()
                .fold(expected.abs(), |most, term| most.max(term.abs()));
            let error = (terms.iter().sum::<f64>() - expected).abs() / largest;
            println!(
                "{integrator:?}, dissipation {dissipation}: sizes {by_sizes:.3?}, off by {error:.1e}"
            );
            assert!(by_sizes.iter().all(|by| by.abs() > 1e-3 * largest));
            assert!(error <= SAME, "{integrator:?}: off by {error:e}");
        }
    }
}

/// Returns all parameters except sizes, and the derivative of each component with respect to λ at 1.
fn all_but_sizes(world: &World, dissipation: f64) -> (Vec<Parameter>, Vec<f64>) {
    let (mut by, mut rates) = (
        vec![Parameter::Gravity],
        world.gravity().iter().copied().collect::<Vec<_>>(),
    );
    for (body, state) in world.bodies().iter().zip(&world.initial_state().bodies) {
        let name: Arc<str> = body.name().into();
        let modulus = body.material().modulus.unwrap();
        // The thickness of the floor's layer does not change, so its pressure changes by twice as much.
        let is_layer = body.shape().compliant().is_none();
        by.push(Parameter::Modulus(Arc::clone(&name)));
        rates.push(if is_layer { -2.0 * modulus } else { -modulus });
        if dissipation > 0.0 {
            by.push(Parameter::Dissipation(Arc::clone(&name)));
            rates.push(-dissipation);
        }
        if !is_layer {
            by.push(Parameter::InitialPosition(Arc::clone(&name)));
            rates.extend(state.position().iter());
            by.push(Parameter::InitialVelocity(name));
            rates.extend(state.velocity().iter());
        }
    }
    (by, rates)
}

/// Returns the derivative of the outcome with respect to λ through positions and velocities.
fn growth(trajectory: &Trajectory) -> f64 {
    let of_body = |body: &BodyState| {
        let pose = body.pose.translation().iter().chain(body.pose.rotation());
        let twist = body.twist.linear.iter().chain(&body.twist.angular);
        let numbers = (1..).zip(pose.chain(twist));
        let grow = numbers.filter(|(factor, _)| [1, 2, 3, 13, 14, 15].contains(factor));
        grow.map(|(factor, number)| 2.0 * number * number * f64::from(factor).sin())
            .sum::<f64>()
    };
    trajectory.last().bodies.iter().map(of_body).sum()
}
