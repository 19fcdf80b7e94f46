//! Derivatives of rollouts with respect to the shapes of jointed bodies, through contact and through their mass.

use crate::shapes::{IMPLICIT_DIFFERENCES, Squares, along, loss, moved, velocities};
use crate::support::differences::compare_slope;
use crate::support::moved_meshes::moved_mesh;
use crate::support::worlds::{IMPLICIT, at, falling, plan_of, rigid_floor, rubbing, turned};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Accuracy, Body, Integrator, Joint, Mass, Plan, Trajectory, World};
use hydroelastic::gradient::{Experiment, HoldFixed, Outcome};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::MassProperties;
use nalgebra::{Matrix3, Vector3, vector};

/// Relative rounding error of one step.
const ROUND_OFF: f64 = 1e-12;

/// Density (kg/m³).
const DENSITY: f64 = 300.0;

/// Names and semiaxes (m) of the ellipsoids.
const BODIES: [(&str, [f64; 3]); 7] = [
    ("trunk", [0.1, 0.12, 0.08]),
    ("leg", [0.04, 0.05, 0.09]),
    ("foot", [0.06, 0.05, 0.04]),
    ("tail", [0.03, 0.06, 0.04]),
    ("wheel", [0.05, 0.04, 0.06]),
    ("upper", [0.05, 0.06, 0.1]),
    ("lower", [0.06, 0.05, 0.08]),
];

/// Ellipsoid whose center is not the origin of the body.
fn field(index: usize) -> PressureField {
    let field = shapes::ellipsoid(BODIES[index].1, 1).unwrap();
    let offset = vec![vector![0.01, -0.02, 0.015]; field.mesh().vertex_count()];
    let mesh = moved_mesh(field.mesh(), &offset, 1.0);
    PressureField::new(mesh, field.extents().to_vec()).unwrap()
}

/// A walker with a free trunk, and an arm on a ball joint. The foot and the end of the arm rub on the floor.
fn world(shapes: [Shape; 7], mass: impl Fn(usize) -> Mass) -> World {
    let origin = |x: f64, y: f64, z: f64| turned([0.2, -0.1, 0.3], [x, y, z]);
    let joints = [
        None,
        Some(
            Joint::revolute("hip", Vector3::x_axis())
                .with_parent("trunk")
                .with_origin(origin(0.03, 0.02, -0.15))
                .with_velocity(2.0)
                .with_servo(5.0, 0.3),
        ),
        Some(
            Joint::prismatic("ankle", Vector3::z_axis())
                .with_parent("leg")
                .with_origin(origin(0.02, 0.0, -0.13))
                .with_servo(4e3, 20.0),
        ),
        Some(
            Joint::fixed("weld")
                .with_parent("trunk")
                .with_origin(origin(-0.02, 0.15, 0.03)),
        ),
        Some(
            Joint::revolute("axle", Vector3::y_axis())
                .with_parent("trunk")
                .with_origin(origin(-0.14, 0.0, 0.05))
                .with_mimic("hip", -1.5, 0.2),
        ),
        Some(Joint::ball("shoulder").with_origin(at(1.0, 0.0, 0.22))),
        Some(
            Joint::revolute("elbow", Vector3::y_axis())
                .with_parent("upper")
                .with_origin(origin(0.02, -0.01, -0.17))
                .with_velocity(-3.0)
                .with_damping(0.1),
        ),
    ];
    let parts = shapes.into_iter().zip(BODIES).zip(joints).enumerate();
    let bodies = parts.map(|(index, ((shape, (name, _)), joint))| {
        let body = Body::dynamic(name, shape, rubbing(1e5, 0.4, 0.3), mass(index)).unwrap();
        match joint {
            Some(joint) => body.with_joint(joint).unwrap(),
            None => body
                .with_pose(turned([0.1, 0.2, 0.5], [0.0, 0.0, 0.31]))
                .with_velocity(vector![0.3, 0.2, -0.5])
                .with_angular_velocity(vector![2.0, -1.0, 1.5]),
        }
    });
    let world = falling(std::iter::once(rigid_floor(0.6)).chain(bodies).collect());
    world.with_slip_tolerance(0.05).unwrap()
}

/// The world after the vertices of one body have moved for a time. `held` selects the mass properties that stay the same.
fn changed(body: usize, time: f64, held: HoldFixed) -> World {
    let still = vec![Vector3::zeros(); field(body).mesh().vertex_count()];
    let rates = velocities(&field(body));
    let shape = |index: usize| {
        let velocities = if index == body { &rates } else { &still };
        moved(&field(index), velocities, time)
    };
    world(std::array::from_fn(shape), |index| {
        let mass = moved(&field(index), &still, 0.0)
            .field()
            .mesh()
            .mass_properties(DENSITY);
        match held {
            HoldFixed::MassProperties => Mass::Properties(mass.unwrap()),
            HoldFixed::Mass => Mass::Total(mass.unwrap().mass),
            _ => Mass::Density(DENSITY),
        }
    })
}

/// Velocity of the first joint at the end.
struct Velocity;

impl Outcome for Velocity {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        trajectory.last().joints[0].velocity().into_iter().collect()
    }
}

#[test]
fn a_wheel_on_a_motor_has_the_closed_form_by_its_mass_properties() {
    let (mass, offset, moment, torque, step) = (2.0, 0.3, 0.05, 4.0, 1e-2);
    let motor = Joint::revolute("motor", Vector3::z_axis()).with_torque(torque);
    let properties = MassProperties {
        mass,
        center_of_mass: vector![offset, 0.0, 0.0],
        inertia: Matrix3::identity() * moment,
    };
    let wheel = moved(&field(0), &velocities(&field(0)), 0.0);
    let wheel = Body::dynamic(
        "wheel",
        wheel,
        rubbing(1e5, 0.0, 0.0),
        Mass::Properties(properties),
    );
    let world = World::new(vec![wheel.unwrap().with_joint(motor).unwrap()]).unwrap();
    let plan = plan_of(Integrator::ImplicitEuler, step, 1);
    let gradient = Experiment::new(world, &plan)
        .full_gradient(&Velocity)
        .unwrap();
    let by = gradient.by_mass_properties("wheel").unwrap();
    // The velocity is h·τ/(I + m·c²).
    let total = moment + mass * offset * offset;
    let by_total = -step * torque / (total * total);
    let expected = [offset * offset, 1.0, 2.0 * mass * offset].map(|slope| by_total * slope);
    let found = [by.by_mass, by.by_inertia[(2, 2)], by.by_center_of_mass.x];
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < ROUND_OFF * expected.abs());
    }
}

#[test]
fn shapes_of_jointed_bodies_equal_differences() {
    for integrator in IMPLICIT {
        let plan: Plan = plan_of(integrator, 2e-3, 30).recording_every(30);
        let plan = plan.with_solver_tolerance(1e-13).unwrap();
        let plan = plan.with_accuracy(Accuracy::new(1e9, 1e9).unwrap());
        for held in [
            HoldFixed::MassProperties,
            HoldFixed::Mass,
            HoldFixed::Density,
        ] {
            let gradient = Experiment::new(changed(0, 0.0, held), &plan)
                .full_gradient(&Squares)
                .unwrap();
            for (body, (name, _)) in BODIES.into_iter().enumerate() {
                let by_vertices = gradient.by_shape(name, held).unwrap().by_vertices;
                let rate = along(&by_vertices, &velocities(&field(body)));
                let value = |time: f64| loss(&changed(body, time, held), &plan);
                let label = format!("{name} {integrator:?} {held:?}");
                compare_slope((rate, IMPLICIT_DIFFERENCES), value, &label);
            }
        }
    }
}
