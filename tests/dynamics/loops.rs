//! Loop joints.

use crate::scenes::at;
use hydroelastic::dynamics::{
    Accuracy, Body, BodyShape, BodyState, Integrator, Joint, JointKind, LoopJoint, Mass, Material,
    Plan, RolloutError, State, World, WorldError,
};
use hydroelastic::spatial::{MassProperties, Pose, Twist};
use nalgebra::{DVector, Matrix3, Unit, Vector3, vector};
use std::sync::Arc;

/// Gravity (m/s²).
const GRAVITY: f64 = 9.81;

/// Link with a mass (kg), a center of mass (m) and an isotropic inertia about the center of mass (kg m²).
fn link(name: &str, mass: f64, center_of_mass: Vector3<f64>, inertia: f64) -> Body {
    let properties = MassProperties {
        mass,
        center_of_mass,
        inertia: Matrix3::identity() * inertia,
    };
    let mass = Mass::Properties(properties);
    Body::dynamic(name, BodyShape::None, Material::rigid(), mass).unwrap()
}

fn ground() -> Body {
    Body::fixed("ground", BodyShape::None, Material::rigid()).unwrap()
}

fn hinge() -> JointKind {
    JointKind::Revolute(Vector3::y_axis())
}

/// Errors of the dimensions of a linkage.
#[derive(Default)]
struct Misfit {
    /// Rotation vector of the base (rad). Gravity turns with the base.
    turn: Vector3<f64>,
    /// Angle between the axes of the rocker and of the crank (rad).
    tilt: f64,
    /// Distance between the ends of coupler and rocker, normal to the plane of the linkage (m).
    offset: f64,
}

fn four_bar(kind: JointKind) -> World {
    four_bar_with(kind, &Misfit::default(), Vec::new())
}

/// Crank, coupler and rocker in the xz plane of the base, and other bodies. The last joint closes the loop.
fn four_bar_with(kind: JointKind, misfit: &Misfit, others: Vec<Body>) -> World {
    let (crank, coupler, rocker, base) = (0.2, 0.5, 0.4, 0.5);
    // Angles from the x axis towards −z.
    let angle: f64 = -1.0;
    let pin = vector![crank * angle.cos(), 0.0, -crank * angle.sin()];
    let between = vector![base, 0.0, 0.0] - pin;
    let distance = between.norm();
    let direction = (-between.z).atan2(between.x);
    let cosine =
        (coupler * coupler + distance * distance - rocker * rocker) / (2.0 * coupler * distance);
    let coupler_angle = direction - cosine.acos();
    let end = pin
        + vector![
            coupler * coupler_angle.cos(),
            0.0,
            -coupler * coupler_angle.sin()
        ];
    let on_rocker = end - vector![base, 0.0, 0.0];
    let rocker_angle = (-on_rocker.z).atan2(on_rocker.x);
    let base_pose = Pose::from_rotation_vector(&misfit.turn, Vector3::zeros());
    let tilted =
        Pose::from_rotation_vector(&vector![misfit.tilt, 0.0, 0.0], vector![base, 0.0, 0.0]);
    let joint = |name: &str| Joint::revolute(name, Vector3::y_axis()).with_parent("ground");
    let bar = |name: &str, length: f64, joint: Joint| {
        let center = vector![length / 2.0, 0.0, 0.0];
        link(name, 2.0 * length, center, 0.01)
            .with_joint(joint)
            .unwrap()
    };
    World::builder()
        .body(ground().with_pose(base_pose))
        .body(bar("crank", crank, joint("drive").with_position(angle)))
        .body(bar(
            "coupler",
            coupler,
            joint("knee")
                .with_parent("crank")
                .with_origin(at(crank, 0.0, 0.0))
                .with_position(coupler_angle - angle),
        ))
        .body(bar(
            "rocker",
            rocker,
            joint("swing")
                .with_origin(tilted)
                .with_position(rocker_angle),
        ))
        .loop_joint(LoopJoint::new(
            "pin",
            kind,
            ("coupler", at(coupler, 0.0, 0.0)),
            ("rocker", at(rocker, misfit.offset, 0.0)),
        ))
        .bodies(others)
        .gravity(base_pose.rotation() * vector![0.0, 0.0, -GRAVITY])
        .build()
        .unwrap()
}

/// Distance (m) between the joint frames of the four-bar linkage.
fn gap(state: &State) -> f64 {
    let [coupler, rocker] = [(2, 0.5), (3, 0.4)].map(|(body, length)| {
        let pose = &state.bodies[body].pose;
        pose.transformed_point(&vector![length, 0.0, 0.0])
    });
    (coupler - rocker).norm()
}

fn sdirk3(time_step: f64, steps: usize, tolerance: f64) -> Plan {
    Plan::new(time_step, steps)
        .unwrap()
        .with_integrator(Integrator::Sdirk3)
        .with_accuracy(Accuracy::new(tolerance, tolerance).unwrap())
}

fn run(world: &World, plan: &Plan) -> Vec<State> {
    world.rollout(plan).run().unwrap().states().to_vec()
}

/// Largest difference of the positions of all bodies (m) at the end of two motions.
fn distance(one: &World, other: &World, plan: &Plan) -> f64 {
    let [one, other] = [one, other].map(|world| run(world, plan).pop().unwrap());
    let bodies = one.bodies.iter().zip(&other.bodies);
    let points = [vector![0.0, 0.0, 0.0], vector![0.3, 0.2, 0.1]];
    let differences = bodies.flat_map(|(one, other)| {
        points.map(|point| {
            let [one, other] = [one, other].map(|state| state.pose.transformed_point(&point));
            (one - other).norm()
        })
    });
    differences.fold(0.0, f64::max)
}

/// Error of the joint positions and velocities of a four-bar linkage after 0.4 s in steps of equal durations.
fn four_bar_errors(plan: impl Fn(f64, usize) -> Plan, counts: [usize; 3]) -> [f64; 3] {
    let world = four_bar(hinge());
    let numbers = |plan: &Plan| {
        let state = run(&world, plan).pop().unwrap();
        let joints = state.joints.into_iter();
        let numbers = joints.flat_map(|joint| [joint.position(), joint.velocity()]);
        numbers.flatten().collect::<Vec<_>>()
    };
    let exact = numbers(&sdirk3(5e-3, 80, 1e-9));
    counts.map(|count| {
        let found = numbers(&plan(0.4 / count as f64, count));
        let differences = found.iter().zip(&exact).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f64::max)
    })
}

#[test]
fn a_linkage_converges_with_the_order_of_the_method() {
    // A loose accuracy leaves the steps undivided.
    let errors = four_bar_errors(
        |duration, count| sdirk3(duration, count, 1e6),
        [80, 160, 320],
    );
    for pair in errors.windows(2) {
        assert!(pair[0] / pair[1] > 3.8, "{errors:?}");
    }
    let euler = |duration, count| {
        let plan = Plan::new(duration, count).unwrap();
        plan.with_integrator(Integrator::ImplicitEuler)
    };
    let errors = four_bar_errors(euler, [320, 640, 1280]);
    for pair in errors.windows(2) {
        assert!((1.8..2.2).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

#[test]
fn a_linkage_stays_closed() {
    let world = four_bar(hinge());
    let plan = Plan::new(5e-3, 400).unwrap();
    let states = run(&world, &plan.with_integrator(Integrator::Sdirk3));
    let gaps: Vec<f64> = states.iter().map(gap).collect();
    assert!(gaps.iter().all(|gap| *gap < 1e-5));
}

#[test]
fn redundant_constraints_change_nothing() {
    // In the plane, a hinge and a ball joint allow the same motions.
    let plan = sdirk3(5e-3, 80, 1e-4);
    let distance = distance(&four_bar(hinge()), &four_bar(JointKind::Ball), &plan);
    assert!(distance < 1e-9, "{distance:e}");
}

#[test]
fn loops_that_cannot_close_exactly_move_as_loops_that_can() {
    let turn = vector![0.3, 0.4, 0.5];
    let plan = sdirk3(5e-3, 40, 1e-4);
    let exact = run(&four_bar(hinge()), &plan);
    for (tilt, offset) in [(5e-4, 0.0), (1e-5, 0.0), (0.0, 1e-4), (3e-5, 5e-4)] {
        let misfit = Misfit { turn, tilt, offset };
        let found = run(&four_bar_with(hinge(), &misfit, Vec::new()), &plan);
        for (found, exact) in found.iter().zip(&exact) {
            for (found, exact) in found.joints.iter().zip(&exact.joints) {
                let [found, exact] = [found, exact].map(|joint| joint.position().unwrap());
                assert!(
                    (found - exact).abs() < 2e-3,
                    "{tilt} {offset}: {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn a_massless_dial_that_mimics_the_crank_does_not_open_the_loop() {
    let mass = Mass::Link(MassProperties::zero());
    let dial = Body::dynamic("dial", BodyShape::None, Material::rigid(), mass).unwrap();
    let joint = Joint::revolute("dial", Vector3::y_axis()).with_mimic("drive", -2.0, 0.0);
    let dial = dial.with_joint(joint).unwrap();
    let world = four_bar_with(JointKind::Ball, &Misfit::default(), vec![dial]);
    let states = run(&world, &sdirk3(5e-3, 80, 1e-4));
    let gaps: Vec<f64> = states.iter().map(gap).collect();
    assert!(gaps.iter().all(|gap| *gap < 1e-6), "{gaps:?}");
}

#[test]
fn a_body_follows_a_disc_that_begins_to_turn() {
    let path = |time: f64| {
        let turn = vector![0.0, 0.0, 2.0 * time * time];
        BodyState {
            pose: Pose::from_rotation_vector(&turn, Vector3::zeros()),
            twist: Twist {
                angular: vector![0.0, 0.0, 4.0 * time],
                linear: Vector3::zeros(),
            },
        }
    };
    let disc = Body::kinematic("disc", BodyShape::None, Material::rigid(), Arc::new(path)).unwrap();
    let world = World::builder()
        .body(disc)
        .body(link("body", 1.0, Vector3::zeros(), 0.01))
        .loop_joint(between(JointKind::Fixed, ["disc", "body"], 0.0))
        .build()
        .unwrap();
    let states = run(&world, &sdirk3(5e-3, 40, 1e-4));
    for state in &states {
        let [disc, body] = [0, 1].map(|index| state.bodies[index].pose);
        assert!((disc.rotation() - body.rotation()).amax() < 1e-6);
    }
}

/// Chain of links below the ground, on joints or on loop joints. The links of the second chain are free bodies.
fn chains(count: usize, kind: JointKind) -> [World; 2] {
    let length = 0.1;
    let name = |index: usize| format!("link {index}");
    let [hook, below] = [at(0.0, 0.0, 0.0), at(0.0, 0.0, -length)];
    let links = |joint: &dyn Fn(usize, Body) -> Body| {
        let link = |index: usize| {
            let center = vector![0.01, 0.02, -length / 2.0];
            joint(index, link(&name(index), 0.5, center, 1e-3))
        };
        (0..count).map(link).collect::<Vec<_>>()
    };
    let on_joints = links(&|index, body| {
        let joint = match kind {
            JointKind::Ball => Joint::ball(&name(index)),
            JointKind::Revolute(axis) => Joint::revolute(&name(index), axis).with_velocity(0.5),
            JointKind::Prismatic(axis) => Joint::prismatic(&name(index), axis).with_velocity(0.1),
            _ => Joint::fixed(&name(index)),
        };
        let joint = match index {
            0 => joint.with_parent("ground"),
            _ => joint.with_parent(&name(index - 1)).with_origin(below),
        };
        body.with_joint(joint).unwrap()
    });
    let builder = || {
        let gravity = vector![3.0, 1.0, -GRAVITY];
        World::builder().body(ground()).gravity(gravity)
    };
    let tree = builder().bodies(on_joints).build().unwrap();
    let start = tree.initial_state();
    let mut free = builder().bodies(links(&|index, body| {
        let state = &start.bodies[index + 1];
        let Twist { angular, linear } = state.twist;
        body.with_pose(state.pose)
            .with_angular_velocity(angular)
            .with_velocity(linear)
    }));
    for index in 0..count {
        let parent = match index {
            0 => ("ground".to_owned(), hook),
            _ => (name(index - 1), below),
        };
        let joint = LoopJoint::new(
            &format!("loop {index}"),
            kind,
            (&parent.0, parent.1),
            (&name(index), hook),
        );
        free = free.loop_joint(joint);
    }
    [tree, free.build().unwrap()]
}

#[test]
fn free_bodies_on_loop_joints_move_as_bodies_on_joints() {
    let axis = Vector3::y_axis();
    let kinds = [
        JointKind::Ball,
        JointKind::Revolute(axis),
        JointKind::Prismatic(axis),
        JointKind::Fixed,
    ];
    for kind in kinds {
        let [tree, free] = chains(3, kind);
        let distance = distance(&tree, &free, &sdirk3(5e-3, 40, 1e-8));
        assert!(distance < 1e-7, "{kind:?}: {distance:e}");
    }
}

#[test]
fn a_long_chain_of_loop_joints_moves_as_a_chain_of_joints() {
    let [tree, free] = chains(20, JointKind::Ball);
    let distance = distance(&tree, &free, &sdirk3(1e-3, 10, 1e-4));
    assert!(distance < 1e-5, "{distance:e}");
}

#[test]
fn loop_joints_conserve_momentum() {
    let world = World::builder()
        .body(
            link("one", 1.0, vector![0.1, 0.0, 0.0], 0.02)
                .with_angular_velocity(vector![0.3, -0.8, 2.0])
                .with_velocity(vector![0.1, 0.0, 0.0]),
        )
        .body(link("other", 0.5, vector![0.0, 0.2, 0.0], 0.01))
        .loop_joint(LoopJoint::new(
            "slide",
            JointKind::Prismatic(Vector3::x_axis()),
            ("one", Pose::identity()),
            ("other", Pose::identity()),
        ))
        .build()
        .unwrap();
    let states = run(&world, &sdirk3(5e-3, 100, 1e-2));
    let [first, last] = [0, 100].map(|index| world.diagnostics(&states[index]).unwrap().momentum);
    let change = (last.linear - first.linear).norm();
    let turned = (last.angular - first.angular).norm();
    // Angular momentum has the accuracy of the steps, because the bodies are separate trees.
    assert!(change < 1e-12 && turned < 1e-6, "{change:e} {turned:e}");
}

/// Builds a world of two free bodies and two fixed ones with a loop joint.
fn with_loop(joint: LoopJoint) -> Result<World, WorldError> {
    World::builder()
        .body(link("one", 1.0, Vector3::zeros(), 0.02))
        .body(link("other", 1.0, Vector3::zeros(), 0.02))
        .body(ground())
        .body(Body::fixed("wall", BodyShape::None, Material::rigid()).unwrap())
        .loop_joint(joint)
        .build()
}

fn between(kind: JointKind, bodies: [&str; 2], offset: f64) -> LoopJoint {
    let frames = [Pose::identity(), at(0.0, 0.0, offset)];
    LoopJoint::new("pin", kind, (bodies[0], frames[0]), (bodies[1], frames[1]))
}

#[test]
fn invalid_loop_joints_are_refused() {
    let both = ["one", "other"];
    let refused = |joint| with_loop(joint).unwrap_err();
    let ball = JointKind::Ball;
    let error = refused(between(JointKind::Free, both, 0.0));
    assert!(matches!(error, WorldError::FreeLoop(_)), "{error}");
    let long = JointKind::Revolute(Unit::new_unchecked(vector![0.0, 2.0, 0.0]));
    let error = refused(between(long, both, 0.0));
    assert!(matches!(error, WorldError::Joint { .. }), "{error}");
    let error = refused(between(ball, both, f64::NAN));
    assert!(matches!(error, WorldError::LoopFrame { .. }), "{error}");
    let error = refused(between(ball, ["one", "nothing"], 0.0));
    assert!(matches!(error, WorldError::UnknownBody { .. }), "{error}");
    for bodies in [["one", "one"], ["ground", "wall"]] {
        let error = refused(between(ball, bodies, 0.0));
        assert!(matches!(error, WorldError::LoopBodies { .. }), "{error}");
    }
    let error = refused(between(ball, both, 2e-3));
    assert_eq!(
        error.to_string(),
        "the frames of loop joint \"pin\" are 2.0e-3 m and 0.0e0 rad apart, but at most 1e-3 m and 1e-3 rad are allowed: change the positions of the joints, or the frames of the loop joint"
    );
    // A displacement along the axis of a prismatic joint does not open the loop.
    with_loop(between(JointKind::Prismatic(Vector3::z_axis()), both, 0.3)).unwrap();
}

#[test]
fn explicit_steps_and_forward_dynamics_are_refused() {
    let world = with_loop(between(JointKind::Ball, ["one", "ground"], 0.0)).unwrap();
    let explicit = Plan::new(1e-3, 1).unwrap();
    let failure = world.rollout(&explicit).run().unwrap_err();
    assert!(matches!(failure.error, RolloutError::Joints { .. }));
    let kinetics = world.kinetics(&world.initial_state()).unwrap();
    let error = kinetics.forward_dynamics(&DVector::zeros(12)).unwrap_err();
    assert!(matches!(error, WorldError::ForwardDynamicsOfLoops));
    let mut apart = world.initial_state();
    apart.bodies[0].pose = at(0.0, 0.1, 0.0);
    let error = world.with_initial_state(&apart).unwrap_err();
    assert!(matches!(error, WorldError::OpenLoop { .. }));
}
