//! Forces, controls, single steps, and rollouts linearized with respect to them.

use crate::support::worlds::{
    IMPLICIT, at, cuboid, dynamic, falling, fixed, icosphere, plan_of, push,
};
use hydroelastic::dynamics::{
    Body, Control, Drag, Force, ForceContext, Integrator, Mass, Material, Plan, Spring, State,
    Thruster, Trajectory, World, WorldError, WrenchAccumulator,
};
use hydroelastic::gradient::{Experiment, FinalState, GradientError, Mode, Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{DMatrix, DVector, Vector3, vector};
use std::f64::consts::TAU;
use std::sync::Arc;

const INTEGRATORS: [Integrator; 2] = [Integrator::SymplecticEuler, Integrator::Leapfrog];

fn cube(name: &str, mass: f64, position: Vector3<f64>) -> Body {
    let shape = cuboid([0.1, 0.2, 0.3]);
    let skin = Material::elastic(1e5);
    let body = dynamic(name, shape, skin, mass);
    body.with_pose(Pose::from_translation(position))
}

/// Returns two bricks a meter apart.
fn two() -> World {
    let right =
        cube("right", 3.0, vector![1.0, 0.0, 0.0]).with_angular_velocity(vector![0.1, 0.2, -0.3]);
    World::new(vec![cube("left", 1.0, Vector3::zeros()), right]).unwrap()
}

fn spring(points: [[f64; 3]; 2]) -> Spring {
    Spring {
        bodies: ["left", "right"].map(str::to_owned),
        points,
        rest_length: 0.7.into(),
        stiffness: 50.0.into(),
        damping: 0.0.into(),
    }
}

/// Returns a brick that slides on a floor, with friction, a spring, a drag, a thruster and a control.
fn everything() -> World<f64, (Spring, Drag, Thruster)> {
    let skin = Material::elastic(1e5)
        .with_friction(0.3)
        .with_dissipation(0.3);
    let brick = Arc::new(cuboid([0.2, 0.2, 0.1]));
    let floor = cuboid([2.0, 2.0, 0.2]);
    let place = |x: f64| at(x, 0.02, 0.1495);
    let body = |name, x| {
        let body = Body::dynamic(name, Arc::clone(&brick), skin, Mass::Total(1.0));
        body.unwrap().with_pose(place(x))
    };
    let left = body("left", -0.3).with_velocity(vector![0.4, 0.1, 0.0]);
    let bodies = vec![left, body("right", 0.3), fixed("floor", floor, skin)];
    let pushes = [[3.0, 1.0], [-2.0, 0.5]].map(|[x, y]| Wrench {
        force: vector![x, y, 0.0],
        torque: vector![0.0, 0.0, 0.1],
    });
    let spring = spring([[0.05, 0.03, 0.01], [-0.05, 0.0, 0.0]]);
    let drag = Drag {
        body: "left".into(),
        linear: 0.5.into(),
        angular: 0.01.into(),
    };
    let thruster = Thruster {
        body: "right".into(),
        point: [0.02, 0.0, 0.0],
        force: [0.0, 1.0, 0.0],
    };
    falling(bodies)
        .with_slip_tolerance(1e-2)
        .and_then(|world| world.with_control(Control::new("right", 5e-3, pushes.into())?))
        .and_then(|world| world.with_forces((spring, drag, thruster)))
        .unwrap()
}

#[test]
fn bodies_on_a_spring_swing_with_the_frequency_of_their_reduced_mass() {
    let world = two().with_forces(spring([[0.0; 3]; 2])).unwrap();
    let period = TAU / (50.0_f64 / 0.75).sqrt();
    let plan = Plan::new(period / 1000.0, 1000).unwrap();
    let end = world.rollout(&plan).run().unwrap();
    // After a period of the leapfrog, the state returns to its initial value up to a relative error of (2π/1000)²/24.
    for (body, start) in end.last().bodies.iter().zip(world.initial_state().bodies) {
        assert!((body.position() - start.position()).norm() < 1e-5);
    }
    let middle = &end.states()[500];
    let gap = middle.bodies[1].position().x - middle.bodies[0].position().x;
    assert!((gap - 0.4).abs() < 1e-5, "{gap}");
}

#[test]
fn springs_with_dampers_keep_momentum_and_lose_energy() {
    let spring = Spring {
        damping: 2.0.into(),
        ..spring([[0.05, 0.1, 0.0], [0.0, -0.1, 0.15]])
    };
    let world = two().with_forces(spring).unwrap();
    for integrator in INTEGRATORS {
        let plan = plan_of(integrator, 1e-3, 3000);
        let end = world.rollout(&plan).run().unwrap();
        let [before, after] =
            [&end.states()[0], end.last()].map(|state| world.diagnostics(state).unwrap());
        let drift = after.momentum.linear - before.momentum.linear;
        assert!(drift.norm() < 1e-13);
        let turned = after.momentum.angular - before.momentum.angular;
        // The spring acts along a line, at poses that do not change during the kick.
        assert!(turned.norm() < 1e-13, "{turned}");
        // The elastic energy of the spring is dissipated, except for the rotation that the spring does not affect.
        let length = |state: &State| {
            let point = |body: usize, point: [f64; 3]| {
                state.bodies[body].pose.transformed_point(&point.into())
            };
            (point(1, [0.0, -0.1, 0.15]) - point(0, [0.05, 0.1, 0.0])).norm()
        };
        assert!((length(end.last()) - 0.7).abs() < 0.01);
    }
}

#[test]
fn drag_takes_the_same_part_of_the_velocity_in_each_step() {
    let drag = Drag {
        body: "left".into(),
        linear: 0.4.into(),
        angular: 0.0.into(),
    };
    let left = cube("left", 2.0, Vector3::zeros()).with_velocity(vector![3.0, 0.0, 0.0]);
    let world = World::new(vec![left]).unwrap().with_forces(drag).unwrap();
    let end = world.rollout(&Plan::new(1e-2, 100).unwrap()).run().unwrap();
    let expected = 3.0 * (1.0 - 1e-2 * 0.4 / 2.0_f64).powi(100);
    assert!((end.last().bodies[0].velocity().x - expected).abs() < 1e-13);
}

#[test]
fn thrusters_push_along_the_body_and_turn_it_about_its_center() {
    let thruster = |point| Thruster {
        body: "left".into(),
        point,
        force: [0.0, 2.0, 0.0],
    };
    let turned = Pose::from_rotation_vector(&vector![0.0, 0.0, TAU / 4.0], Vector3::zeros());
    let world = World::new(vec![cube("left", 2.0, Vector3::zeros()).with_pose(turned)]).unwrap();
    let pushed = world
        .clone()
        .with_forces(thruster([0.0, 0.1, 0.0]))
        .unwrap();
    let plan = Plan::new(1e-2, 100).unwrap();
    let end = pushed.rollout(&plan).run().unwrap();
    assert!((end.last().bodies[0].position() - vector![-0.5, 0.0, 0.0]).norm() < 1e-12);
    // The arm is 0.05 m, and the moment of inertia is 2 kg (0.1² + 0.2²)/12 m².
    let turning = world.with_forces(thruster([0.05, 0.0, 0.0])).unwrap();
    let first = turning.step(&turning.initial_state(), &plan).unwrap();
    let spin = 1e-2 * 0.05 * 2.0 / (2.0 * 0.05 / 12.0);
    assert!((first.bodies[0].twist.angular.z - spin).abs() < 1e-14);
}

/// A user-defined force that pulls a body down by the force with which contact pushes it up. As in the paper, it is a function of the
/// contact's accelerations.
struct Suction(f64);

impl Force for Suction {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        for (body, contact) in now.contact.iter().enumerate() {
            wrenches.apply_force_at_com(body, &(contact.force * lift::<T>(-self.0)));
        }
    }
}

#[test]
fn forces_may_depend_on_what_contact_does() {
    let skin = Material::elastic(1e5);
    let ball = icosphere(0.1, 1);
    let floor = cuboid([1.0, 1.0, 0.2]);
    let ball = dynamic("ball", ball, skin, 1.0);
    let ball = ball.with_pose(at(0.0, 0.0, 0.19));
    let world = World::new(vec![ball, fixed("floor", floor, skin)]).unwrap();
    let plan = Plan::new(1e-4, 1).unwrap();
    let state = world.initial_state();
    let speed = |state: State| state.bodies[0].velocity().z;
    let free = speed(world.step(&state, &plan).unwrap());
    let held = world.with_forces(Suction(0.75)).unwrap();
    assert!(free > 0.0);
    assert!((speed(held.step(&state, &plan).unwrap()) - free / 4.0).abs() < 1e-15);
}

#[test]
fn forces_in_any_list_add_up() {
    let drags = || {
        ["left", "right"].map(|body| Drag {
            body: body.into(),
            linear: 0.3.into(),
            angular: 0.02.into(),
        })
    };
    let [first, second] = drags();
    let plan = Plan::new(1e-2, 50).unwrap();
    let ends = [
        two()
            .with_forces((first, second))
            .unwrap()
            .rollout(&plan)
            .run(),
        two()
            .with_forces(Vec::from(drags()))
            .unwrap()
            .rollout(&plan)
            .run(),
    ];
    let twists = ends.map(|end| end.unwrap().last().bodies[1].twist.to_vector());
    assert!(twists[0] == twists[1]);
}

#[test]
fn controls_give_the_momentum_of_their_intervals() {
    let push = |x: f64| push([x, 0.0, 0.0]);
    // The intervals have 1 and 4 time steps. They are not multiples of the time step in binary floating point.
    for (interval, steps_each) in [(0.1, 1), (0.4, 4)] {
        let wrenches = vec![push(1.0), push(-3.0), push(7.0)];
        let control = Control::new("left", interval, wrenches).unwrap();
        let world = two().with_control(control).unwrap();
        for integrator in INTEGRATORS {
            let plan = plan_of(integrator, 0.1, 3 * steps_each + 2);
            let trajectory = world.rollout(&plan).run().unwrap();
            let mut expected = 0.0;
            for (step, pair) in trajectory.states().windows(2).enumerate() {
                expected += 0.1 * [1.0, -3.0, 7.0].get(step / steps_each).unwrap_or(&0.0);
                let found = pair[1].bodies[0].velocity().x;
                assert!(
                    (found - expected).abs() < 1e-14,
                    "{integrator:?}, step {step}"
                );
            }
        }
    }
}

/// Speed of the first body along x.
struct FirstSpeed;

impl Outcome for FirstSpeed {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        vec![trajectory.last().bodies[0].velocity().x]
    }
}

#[test]
fn controls_act_by_their_mean_where_steps_and_intervals_do_not_fit() {
    // In steps of 50 ms, whole intervals of 30 ms lie between the middles of two steps.
    const INTERVAL: f64 = 0.03;
    const STEP: f64 = 0.05;
    let forces = [1.0, -3.0, 7.0, 2.0, -1.0];
    let push = |x: &f64| push([*x, 0.0, 0.0]);
    let control = Control::new("left", INTERVAL, forces.iter().map(push).collect()).unwrap();
    let world = two().with_control(control).unwrap();
    let by: Vec<_> = (0..forces.len())
        .map(|interval| Parameter::control("left", interval))
        .collect();
    let implicit = IMPLICIT;
    for integrator in INTEGRATORS.into_iter().chain(implicit) {
        for steps in 1..5 {
            let plan = plan_of(integrator, STEP, steps);
            let experiment = Experiment::new(&world, &plan);
            let found = experiment.jacobian(&by, &FirstSpeed).unwrap();
            let mut momentum = 0.0;
            for (interval, force) in forces.iter().enumerate() {
                let until = STEP * steps as f64;
                let time = (until - INTERVAL * interval as f64).clamp(0.0, INTERVAL);
                momentum += force * time;
                let derivative = found.jacobian[(0, 6 * interval + 3)];
                let error = (derivative - time).abs();
                assert!(
                    error < 1e-12,
                    "{integrator:?} {steps} {interval}: {error:e}"
                );
            }
            let error = (found.value[0] - momentum).abs();
            assert!(error < 1e-12, "{integrator:?} {steps}: {error:e}");
            let (_, back) = experiment
                .gradient_with_mode(Mode::Reverse, &by, &FirstSpeed)
                .unwrap();
            let error = (back - found.jacobian.row(0).transpose()).amax();
            assert!(error < 1e-12, "{integrator:?} {steps}: {error:e}");
        }
    }
}

#[test]
fn derivatives_through_forces_and_controls_are_those_of_differences() {
    let world = everything();
    let names = ["left", "right"];
    let parameters: Vec<Parameter> = [
        Parameter::control("right", 0),
        Parameter::control("right", 1),
        Parameter::Gravity,
    ]
    .into_iter()
    .chain(names.map(Parameter::initial_velocity))
    .chain(names.map(Parameter::mass))
    .collect();
    let experiment = Experiment::new(&world, &Plan::new(5e-4, 20).unwrap());
    let outcome = FinalState::of_body(&world, "right").unwrap();
    let check = experiment.difference_check(&parameters, &outcome).unwrap();
    assert!(check.best() < 1e-6, "{check}");
}

/// Returns central differences of the final state with respect to the initial state and a control, in tangent-space coordinates.
fn differences<F: Force>(world: &World<f64, F>, plan: &Plan, control: &Parameter) -> DMatrix<f64> {
    // The step is in m, rad, m/s and rad/s, and in N and N m, of which a millionth moves bodies only by some rounding errors.
    const STEP: f64 = 1e-6;
    const STEP_OF_CONTROL: f64 = 1e-3;
    let start = world.initial_state();
    let end_of = |world: &World<f64, F>| world.rollout(plan).run().unwrap().last().clone();
    let end = end_of(world);
    let size = world.difference(&end, &end).unwrap().len();
    let displaced = |column: usize, step: f64| -> DVector<f64> {
        let changed = if column < size {
            let mut change = vec![0.0; size];
            change[column] = step;
            let moved = world.integrate(&start, &change).unwrap();
            world.clone().with_initial_state(&moved).unwrap()
        } else {
            let mut change = vec![0.0; 6];
            change[column - size] = step;
            world
                .perturbed(std::slice::from_ref(control), &change)
                .unwrap()
        };
        world.difference(&end, &end_of(&changed)).unwrap()
    };
    let columns: Vec<_> = (0..size + 6)
        .map(|column| {
            let central =
                |step: f64| (displaced(column, step) - displaced(column, -step)) / (2.0 * step);
            let step = if column < size { STEP } else { STEP_OF_CONTROL };
            // This extrapolation removes the second-order error.
            (central(step) * 4.0 - central(2.0 * step)) / 3.0
        })
        .collect();
    DMatrix::from_columns(&columns)
}

#[test]
fn linearized_rollouts_are_those_of_differences() {
    let world = everything();
    let control = Parameter::control("right", 0);
    for steps in [1, 8] {
        let plan = Plan::new(5e-4, steps).unwrap();
        let found = Experiment::new(&world, &plan)
            .linearize(std::slice::from_ref(&control))
            .unwrap();
        let rollout = world.rollout(&plan).run().unwrap();
        // A rollout in dual numbers has the same real parts, but for rounding.
        assert_eq!(found.end.time.to_bits(), rollout.last().time.to_bits());
        assert!(world.difference(&found.end, rollout.last()).unwrap().amax() < 1e-12);
        let expected = differences(&world, &plan, &control);
        let (size, count) = (found.by_state.nrows(), found.by_parameters.ncols());
        assert_eq!((size, count), (24, 6));
        let error = |own: &DMatrix<f64>, columns: std::ops::Range<usize>| {
            let expected = expected.columns_range(columns);
            (own - expected).amax() / expected.amax()
        };
        let errors = [
            error(&found.by_state, 0..size),
            error(&found.by_parameters, size..size + count),
        ];
        println!("{steps} steps: {errors:?}");
        assert!(errors.iter().all(|error| *error < 1e-9), "{errors:?}");
    }
}

#[test]
fn a_world_that_starts_from_a_state_goes_on_as_its_rollout_does() {
    let world = everything();
    let plan = Plan::new(5e-4, 12).unwrap();
    let whole = world.rollout(&plan).run().unwrap();
    let rest = world
        .clone()
        .with_initial_state(&whole.states()[7])
        .unwrap();
    let rest = rest.rollout(&plan.with_steps(5)).run().unwrap();
    let [expected, found] = [&whole, &rest].map(|trajectory| trajectory.last().bodies.clone());
    for (expected, found) in expected.iter().zip(&found) {
        assert_eq!(expected.pose.rotation(), found.pose.rotation());
        assert_eq!(expected.twist.to_vector(), found.twist.to_vector());
    }
    let next = world.step(&whole.states()[7], &plan).unwrap();
    assert_eq!(
        next.bodies[0].twist.to_vector(),
        whole.states()[8].bodies[0].twist.to_vector()
    );
}

#[test]
fn bodies_that_forces_do_not_move_are_where_they_belong_from_the_first_kick_on() {
    let world = everything();
    let start = world.initial_state();
    let mut astray = start.clone();
    let floor = &mut astray.bodies[2];
    floor.pose = at(0.0, 0.0, 0.05);
    floor.twist.linear.x = 3.0;
    for integrator in INTEGRATORS {
        let plan = plan_of(integrator, 5e-4, 1);
        let expected = world.step(&start, &plan).unwrap();
        let rollout = world.rollout(&plan).with_state(astray.clone()).unwrap();
        let moved = world.clone().with_initial_state(&astray).unwrap();
        let found = [
            world.step(&astray, &plan).unwrap(),
            rollout.run().unwrap().last().clone(),
            moved.rollout(&plan).run().unwrap().last().clone(),
        ];
        for state in found {
            for (expected, found) in expected.bodies.iter().zip(&state.bodies) {
                assert_eq!(expected.twist.to_vector(), found.twist.to_vector());
            }
        }
    }
}

#[test]
fn displacements_take_one_state_to_the_other() {
    let world = two();
    let start = world.initial_state();
    let change: Vec<f64> = (0..24)
        .map(|number| 0.3 * f64::sin(f64::from(number)))
        .collect();
    let moved = world.integrate(&start, &change).unwrap();
    let found = world.difference(&start, &moved).unwrap();
    assert!((found - DVector::from_vec(change)).amax() < 1e-15);
}

/// Returns a world with a floor and no dynamic body.
fn floor() -> World {
    let slab = cuboid([1.0; 3]);
    let slab = fixed("floor", slab, Material::elastic(1e5));
    World::new(vec![slab]).unwrap()
}

#[test]
fn what_cannot_act_is_refused() {
    let unknown = Drag {
        body: "middle".into(),
        linear: 1.0.into(),
        angular: 0.0.into(),
    };
    assert!(matches!(
        two().with_forces(unknown).unwrap_err(),
        WorldError::UnknownBody { name, .. } if name == "middle"
    ));
    let stiffness = Spring {
        stiffness: (-1.0).into(),
        ..spring([[0.0; 3]; 2])
    };
    assert!(matches!(
        two().with_forces(stiffness).unwrap_err(),
        WorldError::Setting { value, .. } if value.to_bits() == (-1.0_f64).to_bits()
    ));
    let drag = Drag {
        body: "floor".into(),
        linear: 1.0.into(),
        angular: 0.0.into(),
    };
    assert!(matches!(
        floor().with_forces(drag).unwrap_err(),
        WorldError::NotDynamic {
            quantity: "drag",
            ..
        }
    ));
    let own = Spring {
        bodies: ["left", "left"].map(str::to_owned),
        ..spring([[0.0; 3]; 2])
    };
    assert!(matches!(
        two().with_forces(own).unwrap_err(),
        WorldError::SameBody(_)
    ));
    assert!(matches!(
        two().with_ignored("left", "left").unwrap_err(),
        WorldError::SameBody(_)
    ));
    let nowhere = spring([[0.0, f64::NAN, 0.0], [0.0; 3]]);
    assert!(two().with_forces(vec![nowhere]).is_err());
}

#[test]
fn controls_and_states_that_cannot_be_are_refused() {
    let push = push([f64::INFINITY, 0.0, 0.0]);
    assert!(Control::new("left", 0.1, vec![push]).is_err());
    assert!(Control::new("left", 0.0, Vec::new()).is_err());
    let control = || Control::new("floor", 0.1, vec![Wrench::zero()]).unwrap();
    assert!(matches!(
        floor().with_control(control()).unwrap_err(),
        WorldError::NotDynamic {
            quantity: "control",
            ..
        }
    ));
    let state = two().initial_state();
    assert!(matches!(
        two().integrate(&state, &[0.0; 12]).unwrap_err(),
        WorldError::ChangeSize {
            found: 12,
            expected: 24
        }
    ));
    assert!(two().integrate(&state, &[f64::NAN; 24]).is_err());
    let mut short = state.clone();
    short.bodies.pop();
    let expected = WorldError::StateSize {
        found: 1,
        expected: 2,
    };
    assert_eq!(two().diagnostics(&short).unwrap_err(), expected);
    assert_eq!(two().topology(&short).unwrap_err(), expected);
    assert_eq!(two().contacts(&short).unwrap_err(), expected);
    assert_eq!(two().largest_stable_step(&short).unwrap_err(), expected);
    let mut timeless = state;
    timeless.time = f64::NAN;
    assert!(two().with_initial_state(&timeless).is_err());
    let world = two().with_control(Control::new("left", 0.1, vec![Wrench::zero()]).unwrap());
    let world = world.unwrap();
    let by = [Parameter::control("left", 0)];
    assert!(
        world
            .perturbed(&by, &[f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0])
            .is_err()
    );
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 1).unwrap());
    let beyond = experiment.linearize(&[Parameter::control("left", 1)]);
    assert!(matches!(
        beyond.unwrap_err(),
        GradientError::NoControl {
            interval: 1,
            intervals: 1,
            ..
        }
    ));
    assert!(
        experiment
            .linearize(&[Parameter::control("right", 0)])
            .is_err()
    );
}

#[test]
fn a_control_that_is_not_there_is_told_with_those_that_are() {
    let control = Control::new("left", 0.1, vec![Wrench::zero(); 2]).unwrap();
    let world = two().with_control(control).unwrap();
    let experiment = Experiment::new(&world, &Plan::new(1e-3, 1).unwrap());
    for (name, told) in [("left", "0 to 1"), ("right", "no control")] {
        let by = [Parameter::control(name, 2)];
        let error = experiment.linearize(&by).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
}
