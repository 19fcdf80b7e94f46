//! Terms of the equations of motion, compared with Pinocchio, dual numbers, differences and closed forms.

use crate::scenes::{SKIN, ball_shape, floor};
use hydroelastic::contact::{ContactWrench, Shape};
use hydroelastic::dynamics::{
    Body, BodyState, Integrator, Joint, JointState, Kinetics, Mass, Material, Plan, State, World,
    WorldError,
};
use hydroelastic::scalar::{DenseDual, Scalar, lift};
use hydroelastic::spatial::{MassProperties, Pose, Twist, Wrench, rotation_from_vector};
use nalgebra::{DMatrix, DVector, Matrix3, Unit, Vector3, dvector, vector};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// Round-off tolerance of sums over a tree, relative to the largest entry.
const ROUND_OFF: f64 = 1e-12;

/// Tolerance of linear solves. The condition number of the mass matrix amplifies the round-off.
const SOLUTION: f64 = 1e-11;

/// Largest number of columns of the trees.
const MOST_COLUMNS: usize = 24;

type Dual = DenseDual<MOST_COLUMNS>;

/// Tree with reference values of Pinocchio: see `tests/data/multibody/README.md`.
#[derive(Deserialize)]
struct Tree {
    gravity: [f64; 3],
    links: Vec<Link>,
    mass_matrix: Vec<Vec<f64>>,
    bias: Vec<f64>,
    inverse_dynamics: Vec<f64>,
    forward_dynamics: Vec<f64>,
    by_positions: Vec<Vec<f64>>,
    by_velocities: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Link {
    parent: isize,
    kind: String,
    axis: [f64; 3],
    origin_rotation: [f64; 3],
    origin: [f64; 3],
    mass: f64,
    center_of_mass: [f64; 3],
    inertia_rotation: [f64; 3],
    moments: [f64; 3],
    armature: f64,
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

fn three(numbers: &[f64]) -> Vector3<f64> {
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

impl Link {
    fn body(&self, index: usize, shape: &Arc<Shape>) -> Body {
        let axes = rotation_from_vector(&self.inertia_rotation.into());
        let mass = Mass::Properties(MassProperties {
            mass: self.mass,
            center_of_mass: self.center_of_mass.into(),
            inertia: axes * Matrix3::from_diagonal(&self.moments.into()) * axes.transpose(),
        });
        let body = Body::dynamic(&index.to_string(), Arc::clone(shape), SKIN, mass).unwrap();
        if let Some(joint) = self.joint(index) {
            return body.with_joint(joint).unwrap();
        }
        let (turn, origin) = (three(&self.position), three(&self.position[3..]));
        body.with_pose(Pose::from_rotation_vector(&turn, origin))
            .with_angular_velocity(three(&self.velocity))
            .with_velocity(three(&self.velocity[3..]))
    }

    fn joint(&self, index: usize) -> Option<Joint> {
        let name = format!("joint {index}");
        let axis = Unit::new_normalize(self.axis.into());
        let scalar = |joint: Joint| {
            joint
                .with_position(self.position[0])
                .with_velocity(self.velocity[0])
        };
        let joint = match self.kind.as_str() {
            "revolute" => scalar(Joint::revolute(&name, axis)),
            "prismatic" => scalar(Joint::prismatic(&name, axis)),
            "ball" => Joint::ball(&name).with_initial_state(JointState::Ball {
                rotation: rotation_from_vector(&three(&self.position)),
                angular_velocity: three(&self.velocity),
            }),
            _ => return None,
        };
        let origin = Pose::from_rotation_vector(&self.origin_rotation.into(), self.origin.into());
        let joint = joint.with_origin(origin).with_armature(self.armature);
        Some(match usize::try_from(self.parent) {
            Ok(parent) => joint.with_parent(&parent.to_string()),
            Err(_) => joint,
        })
    }
}

impl Tree {
    fn world(&self) -> World {
        let shape = ball_shape();
        let links = self.links.iter().enumerate();
        let bodies = links.map(|(index, link)| link.body(index, &shape));
        let world = World::new(bodies.collect()).unwrap();
        world.with_gravity(self.gravity.into()).unwrap()
    }

    fn accelerations(&self) -> DVector<f64> {
        let links = self.links.iter();
        DVector::from_vec(links.flat_map(|link| link.acceleration.clone()).collect())
    }
}

fn trees() -> Vec<Tree> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/multibody/trees.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn kinetics(world: &World) -> Kinetics {
    world.kinetics(&world.initial_state()).unwrap()
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i][j])
}

fn symmetric(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows.len(), |i, j| rows[i.max(j)][i.min(j)])
}

/// Largest difference relative to the largest entry, or to 1 if all entries are smaller.
fn error(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
    (found - expected).amax() / expected.amax().max(1.0)
}

fn vector_error(found: &DVector<f64>, expected: &[f64]) -> f64 {
    let expected = DVector::from_column_slice(expected);
    (found - &expected).amax() / expected.amax().max(1.0)
}

#[test]
fn random_trees_have_the_dynamics_of_pinocchio() {
    let mut largest = [0.0_f64; 6];
    let trees = trees();
    assert_eq!(trees.len(), 200);
    for tree in &trees {
        let kinetics = kinetics(&tree.world());
        let accelerations = tree.accelerations();
        let forces = kinetics.inverse_dynamics(&accelerations).unwrap();
        let derivatives = kinetics.inverse_dynamics_derivatives(&accelerations);
        let derivatives = derivatives.unwrap();
        let applied = &forces - kinetics.bias();
        let caused = kinetics.forward_dynamics(&applied).unwrap();
        let errors = [
            error(&kinetics.mass_matrix(), &symmetric(&tree.mass_matrix)),
            vector_error(&kinetics.bias(), &tree.bias),
            vector_error(&forces, &tree.inverse_dynamics),
            error(&derivatives.by_positions, &matrix(&tree.by_positions)),
            error(&derivatives.by_velocities, &matrix(&tree.by_velocities)),
            vector_error(&caused, &tree.forward_dynamics),
        ];
        for (largest, error) in largest.iter_mut().zip(errors) {
            *largest = largest.max(error);
        }
    }
    println!("largest errors: {largest:?}");
    assert!(
        largest[..5].iter().all(|&error| error < ROUND_OFF),
        "{largest:?}"
    );
    assert!(largest[5] < SOLUTION, "{largest:?}");
}

/// Initial state after a displacement and a change of the generalized velocities.
fn changed<T: Scalar>(
    world: &World,
    kinetics: &Kinetics,
    displacement: &DVector<T>,
    change: &DVector<T>,
) -> State<T> {
    let mut state = world.lifted::<T>().initial_state();
    let mut joints = state.joints.iter_mut();
    for (index, body) in state.bodies.iter_mut().enumerate() {
        let first = kinetics.columns(index).unwrap().start;
        let three = |vector: &DVector<T>, first: usize| {
            Vector3::new(vector[first], vector[first + 1], vector[first + 2])
        };
        if kinetics.columns(index).unwrap().len() == 6 {
            let center = world.bodies()[index].inertia().unwrap().center_of_mass;
            let center = center.map(lift::<T>);
            let before = body.pose.transformed_point(&center);
            let turn = rotation_from_vector(&three(displacement, first));
            let turned = turn * body.pose.rotation();
            let origin = before + three(displacement, first + 3) - turned * center;
            body.pose = Pose::new(turned, origin).unwrap();
            body.twist.angular += three(change, first);
            body.twist.linear += three(change, first + 3);
            continue;
        }
        match joints.next() {
            Some(JointState::Scalar { position, velocity }) => {
                *position += displacement[first];
                *velocity += change[first];
            }
            Some(JointState::Ball {
                rotation,
                angular_velocity,
            }) => {
                *rotation = rotation_from_vector(&three(displacement, first)) * *rotation;
                *angular_velocity += three(change, first);
            }
            _ => {}
        }
    }
    state
}

fn constant(values: &DVector<f64>) -> DVector<Dual> {
    values.map(lift)
}

fn derivatives(numbers: &DVector<Dual>) -> DMatrix<f64> {
    DMatrix::from_fn(numbers.len(), numbers.len(), |row, column| {
        numbers[row].eps[column]
    })
}

#[test]
fn derivatives_of_the_dynamics_agree_with_dual_numbers() {
    let (mut inverse_error, mut forward_error) = (0.0_f64, 0.0_f64);
    for tree in trees() {
        let world = tree.world();
        let dual_world = world.lifted::<Dual>();
        let kinetics = kinetics(&world);
        let accelerations = tree.accelerations();
        let forces = kinetics.inverse_dynamics(&accelerations).unwrap();
        let inverse = kinetics.inverse_dynamics_derivatives(&accelerations);
        let inverse = inverse.unwrap();
        let forward = kinetics.forward_dynamics_derivatives(&forces).unwrap();
        let zero = constant(&(&accelerations * 0.0));
        let seeds = DVector::from_fn(zero.len(), |k, _| Dual::variable(0.0, k));
        for (state, inverse, forward) in [
            (
                changed(&world, &kinetics, &seeds, &zero),
                inverse.by_positions,
                forward.by_positions,
            ),
            (
                changed(&world, &kinetics, &zero, &seeds),
                inverse.by_velocities,
                forward.by_velocities,
            ),
        ] {
            let dual = dual_world.kinetics(&state).unwrap();
            let expected = dual.inverse_dynamics(&constant(&accelerations)).unwrap();
            inverse_error = inverse_error.max(error(&inverse, &derivatives(&expected)));
            let expected = dual.forward_dynamics(&constant(&forces)).unwrap();
            forward_error = forward_error.max(error(&forward, &derivatives(&expected)));
        }
        let identity = &forward.by_forces * kinetics.mass_matrix();
        let size = kinetics.velocity_count();
        assert!(error(&identity, &DMatrix::identity(size, size)) < SOLUTION);
    }
    println!("inverse {inverse_error:.1e}, forward {forward_error:.1e}");
    assert!(inverse_error < ROUND_OFF, "{inverse_error:e}");
    assert!(forward_error < SOLUTION, "{forward_error:e}");
}

/// Point in the frame of a body (m).
const POINT: Vector3<f64> = vector![0.3, -0.2, 0.5];

#[test]
fn jacobians_give_the_velocities_and_the_accelerations_of_points() {
    type Time = DenseDual<1>;
    for tree in trees().iter().take(60) {
        let world = tree.world();
        let kinetics = kinetics(&world);
        let velocities = kinetics.velocities();
        // Motion to first order in time.
        let time = velocities.map(|velocity| Time::new(0.0, [velocity]));
        let moving = changed(&world, &kinetics, &time, &(&time * lift::<Time>(0.0)));
        let moving = world.lifted::<Time>().kinetics(&moving).unwrap();
        for (body, state) in world.initial_state().bodies.iter().enumerate() {
            let found = kinetics.center_of_mass_jacobian(body).unwrap() * velocities;
            let expected = state.twist.to_vector();
            assert!((found - expected).amax() < ROUND_OFF * expected.amax().max(1.0));
            let jacobian = moving.jacobian(body, &POINT.map(lift)).unwrap();
            let rate = (jacobian * velocities.map(lift::<Time>)).map(|number| number.eps[0]);
            let found = kinetics.bias_acceleration(body, &POINT).unwrap();
            let error = (found - rate).amax() / rate.amax().max(1.0);
            assert!(error < ROUND_OFF, "{error:e}");
        }
    }
}

#[test]
fn jacobians_agree_with_differences_of_points() {
    /// Displacement. The error of a central difference is about the square of the displacement.
    const STEP: f64 = 1e-5;
    const TOLERANCE: f64 = 1e-9;
    for tree in trees().iter().take(40) {
        let world = tree.world();
        let kinetics = kinetics(&world);
        let size = kinetics.velocity_count();
        let zero = DVector::zeros(size);
        for column in 0..size {
            let states = [STEP, -STEP].map(|step| {
                let mut displacement = zero.clone();
                displacement[column] = step;
                let state = changed(&world, &kinetics, &displacement, &zero);
                let world = world.clone().with_initial_state(&state).unwrap();
                world.initial_state()
            });
            for body in 0..world.bodies().len() {
                let points = states
                    .each_ref()
                    .map(|state| state.bodies[body].pose.transformed_point(&POINT));
                let expected = (points[0] - points[1]) / (2.0 * STEP);
                let jacobian = kinetics.jacobian(body, &POINT).unwrap();
                let found = jacobian.fixed_view::<3, 1>(3, column);
                let error = (found - expected).amax();
                assert!(error < TOLERANCE, "{error:e}");
            }
        }
    }
}

#[test]
fn generalized_forces_are_products_with_transposed_jacobians() {
    let wrench = Wrench {
        torque: vector![0.3, -0.5, 0.2],
        force: vector![1.0, 0.4, -0.7],
    };
    for tree in trees().iter().take(40) {
        let kinetics = kinetics(&tree.world());
        let mut expected = DVector::zeros(kinetics.velocity_count());
        let wrenches: Vec<_> = (0..tree.links.len()).map(|body| (body, wrench)).collect();
        for &(body, wrench) in &wrenches {
            let jacobian = kinetics.jacobian(body, &Vector3::zeros()).unwrap();
            expected += jacobian.tr_mul(&wrench.to_vector());
        }
        let found = kinetics.generalized_forces(&wrenches).unwrap();
        assert!(vector_error(&found, expected.as_slice()) < ROUND_OFF);
    }
}

#[test]
fn the_gravity_bias_is_the_bias_at_rest() {
    for tree in trees().iter().take(40) {
        let world = tree.world();
        let moving = kinetics(&world);
        let zero = DVector::zeros(moving.velocity_count());
        let at_rest = changed(&world, &moving, &zero, &-moving.velocities());
        let at_rest = world.kinetics(&at_rest).unwrap();
        let expected = at_rest.bias();
        assert!(vector_error(&moving.gravity_bias(), expected.as_slice()) < ROUND_OFF);
    }
}

#[test]
fn the_bias_of_a_slide_on_a_turntable_is_the_centrifugal_force() {
    let (spin, radius, mass) = (3.0, 0.4, 2.0);
    let path = move |time: f64| BodyState {
        pose: Pose::from_rotation_vector(&vector![0.0, 0.0, spin * time], Vector3::zeros()),
        twist: Twist {
            angular: vector![0.0, 0.0, spin],
            linear: Vector3::zeros(),
        },
    };
    let table = Body::kinematic("table", ball_shape(), SKIN, Arc::new(path)).unwrap();
    let slide = Joint::prismatic("slide", Vector3::x_axis())
        .with_parent("table")
        .with_position(radius);
    let block = Body::dynamic("block", ball_shape(), SKIN, Mass::Total(mass)).unwrap();
    let world = World::new(vec![table, block.with_joint(slide).unwrap()]).unwrap();
    let kinetics = kinetics(&world);
    assert_eq!(kinetics.velocity_count(), 1);
    assert!(kinetics.columns(0).unwrap().is_empty());
    let expected = -mass * spin * spin * radius;
    assert!((kinetics.bias()[0] - expected).abs() < ROUND_OFF * 10.0);
    let acceleration = kinetics.center_of_mass_bias_acceleration(1).unwrap();
    assert!((acceleration[3] - expected / mass).abs() < ROUND_OFF * 10.0);
    // Point of the turntable.
    let acceleration = kinetics
        .bias_acceleration(0, &vector![radius, 0.0, 0.0])
        .unwrap();
    assert!((acceleration[3] - expected / mass).abs() < ROUND_OFF * 10.0);
    let jacobian = kinetics.center_of_mass_jacobian(0).unwrap();
    assert!(jacobian.amax() < ROUND_OFF);
}

#[test]
fn forward_dynamics_of_all_forces_is_the_acceleration_of_a_rollout() {
    /// Error of the extrapolated difference of velocities over steps of 1e-5 s (m/s²).
    const TOLERANCE: f64 = 1e-4;
    let skin = Material::elastic(1e5)
        .with_friction(0.3)
        .with_dissipation(0.2);
    let hinge = Joint::revolute("hinge", Vector3::y_axis())
        .with_origin(Pose::from_translation(vector![-0.5, 0.0, 0.3]))
        .with_damping(0.5)
        .with_servo(20.0, 1.0)
        .with_target(0.3, 0.0)
        .with_velocity(-0.4);
    let arm = Mass::Properties(MassProperties {
        mass: 1.0,
        center_of_mass: vector![0.25, 0.0, 0.0],
        inertia: Matrix3::identity() * 0.02,
    });
    let arm = Body::dynamic("arm", ball_shape(), skin, arm).unwrap();
    let slide = Joint::prismatic("slide", Vector3::x_axis())
        .with_parent("arm")
        .with_origin(Pose::from_translation(vector![0.5, 0.0, -0.205]))
        .with_friction(0.3, 1e-2)
        .with_velocity(0.2);
    let tip = Body::dynamic("tip", ball_shape(), skin, Mass::Total(0.5)).unwrap();
    let bodies = vec![
        floor(skin),
        arm.with_joint(hinge).unwrap(),
        tip.with_joint(slide).unwrap(),
    ];
    let world = World::new(bodies).unwrap();
    let world = world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap();
    let state = world.initial_state();
    let kinetics = kinetics(&world);
    let contacts = world.contacts(&state).unwrap();
    assert!(!contacts.is_empty());
    let wrenches = contacts.iter().flat_map(|contact| {
        let ContactWrench { on_a, on_b } = contact.wrench;
        [(contact.bodies[0], on_a), (contact.bodies[1], on_b)]
    });
    let wrenches: Vec<_> = wrenches.collect();
    let forces = kinetics.joint_forces() + kinetics.generalized_forces(&wrenches).unwrap();
    let found = kinetics.forward_dynamics(&forces).unwrap();
    let difference = |step: f64| {
        let plan = Plan::new(step, 1).unwrap();
        let plan = plan.with_integrator(Integrator::ImplicitEuler);
        let end = world.rollout(&plan).run().unwrap().last().clone();
        let joints = end.joints.iter().zip(&state.joints);
        let changes =
            joints.map(|(end, start)| (end.velocity().unwrap() - start.velocity().unwrap()) / step);
        DVector::from_vec(changes.collect())
    };
    let expected = difference(1e-5) * 2.0 - difference(2e-5);
    let error = (&found - &expected).amax() / expected.amax();
    assert!(error < TOLERANCE, "{found} {expected}");
}

#[test]
fn a_free_body_has_the_equations_of_newton_and_euler() {
    let (mass, moment) = (2.0, vector![0.02, 0.03, 0.04]);
    let properties = Mass::Properties(MassProperties {
        mass,
        center_of_mass: vector![0.1, 0.2, -0.3],
        inertia: Matrix3::from_diagonal(&moment),
    });
    let spin = vector![1.0, 2.0, -3.0];
    let body = Body::dynamic("body", ball_shape(), SKIN, properties).unwrap();
    let body = body
        .with_angular_velocity(spin)
        .with_velocity(vector![4.0, 5.0, 6.0]);
    let world = World::new(vec![body]).unwrap();
    let kinetics = kinetics(&world);
    let angular_momentum = moment.component_mul(&spin);
    let expected = spin.cross(&angular_momentum);
    let bias = kinetics.bias();
    assert!((bias.fixed_rows::<3>(0) - expected).amax() < ROUND_OFF);
    assert!(bias.fixed_rows::<3>(3).amax() < ROUND_OFF);
    let diagonal = [moment.x, moment.y, moment.z, mass, mass, mass];
    let expected = DMatrix::from_diagonal(&DVector::from_row_slice(&diagonal));
    assert!(error(&kinetics.mass_matrix(), &expected) < ROUND_OFF);
}

#[test]
fn wrong_sizes_and_indices_are_refused() {
    let joint = Joint::revolute("joint", Vector3::x_axis());
    let body = Body::dynamic("body", ball_shape(), SKIN, Mass::Total(1.0)).unwrap();
    let world = World::new(vec![body.with_joint(joint).unwrap()]).unwrap();
    let kinetics = kinetics(&world);
    let expected = |quantity| WorldError::VelocityCount {
        quantity,
        found: 2,
        expected: 1,
    };
    let two = dvector![1.0, 2.0];
    assert_eq!(
        kinetics.inverse_dynamics(&two).unwrap_err(),
        expected("generalized accelerations")
    );
    assert_eq!(
        kinetics.forward_dynamics(&two).unwrap_err(),
        expected("generalized forces")
    );
    let expected = WorldError::BodyIndex {
        index: 1,
        bodies: 1,
    };
    assert_eq!(kinetics.columns(1).unwrap_err(), expected);
    assert_eq!(kinetics.jacobian(1, &POINT).unwrap_err(), expected);
    let wrenches = [(1, Wrench::zero())];
    assert_eq!(
        kinetics.generalized_forces(&wrenches).unwrap_err(),
        expected
    );
}

#[test]
fn results_beyond_the_range_of_floats_are_refused() {
    let link = |name: &str, joint: Joint| {
        let body = Body::dynamic(name, ball_shape(), SKIN, Mass::Total(1e5)).unwrap();
        body.with_joint(joint).unwrap()
    };
    let first = Joint::revolute("first", Vector3::x_axis());
    let second = Joint::revolute("second", Vector3::x_axis())
        .with_parent("upper")
        .with_origin(Pose::from_translation(vector![0.0, 1.0, 0.0]))
        .with_position(1.0);
    let third = Joint::revolute("third", Vector3::x_axis())
        .with_parent("lower")
        .with_origin(Pose::from_translation(vector![0.0, 1.0, 0.0]));
    let links = vec![
        link("upper", first),
        link("lower", second),
        link("hand", third),
    ];
    let kinetics = kinetics(&World::new(links).unwrap());
    let huge = dvector![1e307, 1e307, 1e307];
    assert!(matches!(
        kinetics.inverse_dynamics_derivatives(&huge),
        Err(WorldError::Setting {
            quantity: "derivative of the generalized force",
            ..
        })
    ));
    let mut wrench = Wrench::zero();
    wrench.torque.x = 1e308;
    assert!(matches!(
        kinetics.generalized_forces(&[(0, wrench), (1, wrench)]),
        Err(WorldError::Setting {
            quantity: "generalized force",
            ..
        })
    ));
}
