//! Links of mechanisms: bodies without shapes and bodies without mass.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{
    Body, BodyShape, Integrator, Joint, Mass, Material, Plan, World, WorldError,
};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Vector3, vector};

/// Rounding error of 50 implicit steps.
const ROUND_OFF: f64 = 1e-11;

/// These steps have no error control, which depends on the frames of the bodies.
const EULER: Integrator = Integrator::ImplicitEuler;

fn link(name: &str, properties: MassProperties) -> Body {
    Body::dynamic(
        name,
        BodyShape::None,
        Material::rigid(),
        Mass::Link(properties),
    )
    .unwrap()
}

fn bob() -> MassProperties {
    MassProperties {
        mass: 0.7,
        center_of_mass: vector![0.05, 0.0, 0.0],
        inertia: Matrix3::from_diagonal(&vector![2e-3, 3e-3, 4e-3]),
    }
}

fn falling(bodies: Vec<Body>) -> Result<World, WorldError> {
    World::new(bodies)?.with_gravity(vector![0.0, 0.0, -9.81])
}

fn hinge(name: &str) -> Joint {
    Joint::revolute(name, Vector3::y_axis()).with_position(0.8)
}

fn weld(name: &str, parent: &str, z: f64) -> Joint {
    let origin = Pose::from_translation(vector![0.0, 0.0, z]);
    Joint::fixed(name).with_parent(parent).with_origin(origin)
}

/// Pose of the last body after 50 steps.
fn last_pose(world: &World, integrator: Integrator) -> Pose {
    let plan = Plan::new(0.01, 50).unwrap().with_integrator(integrator);
    let trajectory = world.rollout(&plan).run().unwrap();
    trajectory.last().bodies.last().unwrap().pose
}

#[test]
fn a_massless_rod_carries_the_bob_of_a_pendulum() {
    let rod = link("rod", MassProperties::zero())
        .with_joint(hinge("pivot"))
        .unwrap();
    let welded = link("bob", bob())
        .with_joint(weld("weld", "rod", -0.4))
        .unwrap();
    let two_links = last_pose(&falling(vec![rod, welded]).unwrap(), EULER);
    let mut shifted = bob();
    shifted.center_of_mass.z -= 0.4;
    let one_link = link("bob", shifted).with_joint(hinge("pivot")).unwrap();
    let one_link = last_pose(&falling(vec![one_link]).unwrap(), EULER)
        * Pose::from_translation(vector![0.0, 0.0, -0.4]);
    let off = two_links.translation() - one_link.translation();
    assert!(off.norm() < ROUND_OFF, "{off}");
}

#[test]
fn a_point_mass_swings_on_a_rod() {
    let point = MassProperties {
        mass: 2.0,
        center_of_mass: vector![0.0, 0.0, -0.5],
        inertia: Matrix3::zeros(),
    };
    let world = falling(vec![link("bob", point).with_joint(hinge("pivot")).unwrap()]).unwrap();
    let energies = [world.initial_state(), {
        let plan = Plan::new(0.01, 50)
            .unwrap()
            .with_integrator(Integrator::Sdirk3);
        world.rollout(&plan).run().unwrap().last().clone()
    }]
    .map(|state| world.diagnostics(&state).unwrap().total_energy());
    assert!((energies[0] - energies[1]).abs() < 1e-3, "{energies:?}");
}

#[test]
fn a_joint_that_moves_no_inertia_is_refused_by_name() {
    let free = World::new(vec![link("frame", MassProperties::zero())]);
    assert_eq!(free.unwrap_err(), WorldError::NoInertia("frame".into()));
    // A rod along the axis of its hinge has no inertia about this axis.
    let rod = MassProperties {
        mass: 1.0,
        center_of_mass: vector![0.0, 0.3, 0.0],
        inertia: Matrix3::from_diagonal(&vector![0.1, 0.0, 0.1]),
    };
    let arm = link("arm", bob()).with_joint(hinge("shoulder")).unwrap();
    let wrist = |joint: Joint| {
        let rod = link("rod", rod)
            .with_joint(joint.with_parent("arm"))
            .unwrap();
        falling(vec![arm.clone(), rod])
    };
    assert_eq!(
        wrist(hinge("wrist")).unwrap_err(),
        WorldError::NoInertia("rod".into())
    );
    assert!(wrist(hinge("wrist").with_armature(1e-4)).is_ok());
}

#[test]
fn coordinates_beyond_the_range_of_floats_are_refused_as_such() {
    let far = hinge("shoulder").with_position(1e308);
    let world = World::new(vec![link("arm", bob()).with_joint(far).unwrap()]);
    let error = world.unwrap_err().to_string();
    assert!(error.contains("the pose of body \"arm\""), "{error}");
}

#[test]
fn inertia_that_no_solid_has_is_accepted_for_links_only() {
    let impossible = MassProperties {
        mass: 1.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&vector![0.1, 0.1, 0.5]),
    };
    let of = |mass: Mass| Body::dynamic("link", BodyShape::None, Material::rigid(), mass);
    assert!(matches!(
        of(Mass::Properties(impossible)),
        Err(WorldError::ImpossibleInertia { .. })
    ));
    assert!(World::new(vec![of(Mass::Link(impossible)).unwrap()]).is_ok());
    let massless = MassProperties {
        mass: 0.0,
        ..impossible
    };
    assert_eq!(
        of(Mass::Link(massless)).unwrap_err(),
        WorldError::MasslessInertia("link".into())
    );
}

#[test]
fn a_body_without_a_shape_touches_nothing() {
    let block = Shape::new(shapes::cuboid([0.5; 3]).unwrap());
    let block = Body::fixed("block", block, Material::elastic(1e6)).unwrap();
    let world = falling(vec![block, link("ghost", bob())]).unwrap();
    let state = world.initial_state();
    assert!(world.contacts(&state).unwrap().is_empty());
    let contact = world.contact_between(&state, "block", "ghost");
    assert!(matches!(contact, Err(WorldError::NoContact(_))));
    let fallen = last_pose(&world, Integrator::Sdirk3).translation().z;
    assert!((fallen + 9.81 * 0.125).abs() < 1e-9, "{fallen}");
}

#[test]
fn a_mass_without_a_shape_needs_properties() {
    for mass in [Mass::Density(1e3), Mass::Total(1.0)] {
        let body = Body::dynamic("link", BodyShape::None, Material::rigid(), mass);
        assert_eq!(body.unwrap_err(), WorldError::NoVolume("link".into()));
    }
}

#[test]
fn a_rotor_without_a_body_stops_by_friction() {
    let rotor = hinge("rotor")
        .with_armature(1.0)
        .with_friction(1.0, 1e-3)
        .with_velocity(0.035);
    let frame = link("frame", MassProperties::zero());
    let world = World::new(vec![frame.with_joint(rotor).unwrap()]).unwrap();
    for integrator in [Integrator::ImplicitEuler, Integrator::Sdirk3] {
        let plan = Plan::new(0.01, 10).unwrap().with_integrator(integrator);
        let trajectory = world.rollout(&plan).run().unwrap();
        let velocity = trajectory.last().joints[0].velocity().unwrap();
        assert!(velocity.abs() < 1e-4, "{velocity:e}");
    }
}

#[test]
fn massless_frames_cost_no_substeps() {
    let arm = || link("arm", bob()).with_joint(hinge("shoulder")).unwrap();
    let frame = link("frame", MassProperties::zero())
        .with_joint(weld("mount", "arm", 0.5))
        .unwrap();
    let evaluations = |bodies: Vec<Body>| {
        let plan = Plan::new(0.01, 20)
            .unwrap()
            .with_integrator(Integrator::Sdirk3);
        let world = falling(bodies).unwrap();
        let mut rollout = world.rollout(&plan);
        let reports = (0..20).map(|_| {
            rollout.next().unwrap().unwrap();
            rollout.step_report().unwrap().work.substeps
        });
        reports.sum::<usize>()
    };
    assert_eq!(evaluations(vec![arm()]), evaluations(vec![arm(), frame]));
}
