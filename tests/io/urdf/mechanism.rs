//! Conversion of robots to bodies and joints.

use super::published::{PACKAGE, folder, references, urdf_files};
use super::robot;
use approx::assert_relative_eq;
use hydroelastic::dynamics::{
    Body, Integrator, Joint, Material, Mechanism, Plan, RolloutError, World, WorldBuilder,
    WorldError,
};
use hydroelastic::io::urdf::{Base, MeshShape, Robot, RobotOptions, ShapeOptions, UrdfError};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::collections::BTreeMap;

/// Rounding error of chains of ten poses.
const ROUND_OFF: f64 = 1e-13;

const RUBBER: Material = Material {
    modulus: Some(1e6),
    dissipation: 0.5,
    friction: Some(0.8),
};

/// Options that ignore mesh files.
fn options() -> RobotOptions {
    RobotOptions {
        shapes: ShapeOptions {
            meshes: MeshShape::None,
            ..ShapeOptions::default()
        },
        ..RobotOptions::new(RUBBER)
    }
}

fn implicit(time_step: f64, steps: usize) -> Plan {
    let plan = Plan::new(time_step, steps).unwrap();
    plan.with_integrator(Integrator::Sdirk3)
}

/// Arm of two links. The hand has two collision geometries, and a massless link is welded to the hand.
const ARM: &str = r#"
<link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
<link name="arm"><inertial><origin xyz="0 0 0.2"/><mass value="2"/>
  <inertia ixx="0.03" iyy="0.03" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="hand"><inertial><mass value="0.5"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.1"/><geometry><sphere radius="0.05"/></geometry></collision>
  <collision><origin xyz="0 0.1 0"/><geometry><box size="0.02 0.02 0.1"/></geometry></collision></link>
<link name="tool"/>
<joint name="shoulder" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.1"/><axis xyz="0 1 0"/></joint>
<joint name="wrist" type="revolute"><parent link="arm"/><child link="hand"/><origin xyz="0 0 0.4"/><axis xyz="1 0 0"/>
  <limit lower="-1" upper="1" effort="10" velocity="3"/></joint>
<joint name="mount" type="fixed"><parent link="hand"/><child link="tool"/><origin xyz="0 0 0.2"/></joint>"#;

fn names(mechanism: &Mechanism) -> Vec<&str> {
    mechanism.bodies().iter().map(Body::name).collect()
}

#[test]
fn links_become_bodies_with_their_names_frames_and_shapes() {
    let arm = robot(ARM).unwrap().mechanism(&options()).unwrap();
    assert_eq!(names(&arm), ["base", "arm", "hand", "hand/2", "tool"]);
    let joints: Vec<_> = arm.joints().map(Joint::name).collect();
    assert_eq!(joints, ["shoulder", "wrist", "hand/2", "mount"]);
    let [base, limb, hand, second, tool] = arm.bodies() else {
        panic!()
    };
    assert!(base.inertia().is_none() && base.shape().compliant().is_some());
    assert!(limb.shape().bounds().is_none() && tool.shape().bounds().is_none());
    // The origins of the geometries are in the frame of the link.
    assert_relative_eq!(hand.shape().bounds().unwrap().center().z, 0.1);
    assert_relative_eq!(second.shape().bounds().unwrap().center().y, 0.1);
    assert_eq!(second.joint().unwrap().parent(), Some("hand"));
    assert_relative_eq!(limb.inertia().unwrap().center_of_mass.z, 0.2);
    let world = World::builder().mechanism(arm).build().unwrap();
    let state = world.initial_state();
    let height = |body: &str| state.bodies[world.index_of(body).unwrap()].position().z;
    assert_relative_eq!(height("tool"), 0.7, epsilon = ROUND_OFF);
}

#[test]
fn robots_with_different_prefixes_share_a_world() {
    let arm = robot(ARM).unwrap();
    let side = |prefix: &str, x: f64| {
        let options = RobotOptions {
            prefix: prefix.to_owned(),
            base: Base::Fixed(Pose::from_translation(vector![x, 0.0, 0.0])),
            ..options()
        };
        arm.mechanism(&options).unwrap()
    };
    let builder = || World::builder().mechanism(side("left ", -1.0));
    let world = builder().mechanism(side("right ", 1.0)).build().unwrap();
    let state = world.initial_state();
    let x = |body: &str| state.bodies[world.index_of(body).unwrap()].position().x;
    assert_relative_eq!(x("left tool"), -1.0, epsilon = ROUND_OFF);
    assert_relative_eq!(x("right tool"), 1.0, epsilon = ROUND_OFF);
    let twice = builder().mechanism(side("left ", 1.0)).build();
    assert!(matches!(twice, Err(WorldError::DuplicateName(_))));
}

#[test]
fn the_links_of_a_robot_touch_each_other_only_on_request() {
    let arm = robot(ARM).unwrap();
    let pairs = |self_contact| {
        let options = RobotOptions {
            self_contact,
            ..options()
        };
        arm.mechanism(&options).unwrap().ignored().len()
    };
    // Three bodies have shapes.
    assert_eq!([pairs(false), pairs(true)], [3, 0]);
}

#[test]
fn a_robot_stands_on_a_free_base_or_on_another_body() {
    let start = Pose::from_translation(vector![0.0, 0.0, 5.0]);
    let heavy = ARM.replace(
        r#"<link name="base">"#,
        r#"<link name="base"><inertial><mass value="3"/>
           <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>"#,
    );
    let on = |robot: &Robot, base: Base| robot.mechanism(&RobotOptions { base, ..options() });
    let build = |mechanism: Mechanism| {
        let builder = World::builder().mechanism(mechanism);
        builder.gravity(vector![0.0, 0.0, -10.0]).build().unwrap()
    };
    let world = build(on(&robot(&heavy).unwrap(), Base::Free(start)).unwrap());
    let end = world.rollout(&implicit(0.01, 10)).run().unwrap();
    // All links fall together.
    let last = end.last();
    for body in ["base", "hand", "tool"] {
        let index = world.index_of(body).unwrap();
        let fallen =
            world.initial_state().bodies[index].position().z - last.bodies[index].position().z;
        assert_relative_eq!(fallen, 0.05, epsilon = 1e-9);
    }
    let rail = Joint::prismatic("rail", Vector3::x_axis()).with_velocity(0.5);
    let world = build(on(&robot(&heavy).unwrap(), Base::Joint(Box::new(rail))).unwrap());
    assert_eq!(world.initial_state().joints.len(), 3);
}

#[test]
fn a_joint_of_a_mechanism_is_changed_by_name() {
    let arm = robot(ARM).unwrap().mechanism(&options()).unwrap();
    let arm = arm
        .with_joint("wrist", |joint| joint.with_position(0.3))
        .unwrap()
        .with_joints(|joint| joint.with_damping(0.7));
    let joints: Vec<_> = arm.joints().collect();
    assert_eq!(joints[1].initial_state().unwrap().position(), Some(0.3));
    let damping = joints.iter().map(|joint| joint.law().damping);
    // The last two joints are fixed.
    assert_eq!(damping.collect::<Vec<_>>(), [0.7, 0.7, 0.0, 0.0]);
    let error = arm.with_joint("elbow", |joint| joint).unwrap_err();
    let known = ["shoulder", "wrist", "hand/2", "mount"]
        .map(str::to_owned)
        .to_vec();
    let name = "elbow".to_owned();
    let kind = "joint";
    assert_eq!(error, WorldError::UnknownJoint { kind, name, known });
}

#[test]
fn inertia_of_a_massless_link_moves_to_the_link_to_which_it_is_welded() {
    let foot = |kind: &str| {
        let text = format!(
            r#"<link name="base"/><link name="leg"><inertial><mass value="1"/>
               <inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
               <link name="foot"><inertial><mass value="0"/>
               <inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
               <joint name="knee" type="continuous"><parent link="base"/><child link="leg"/></joint>
               <joint name="ankle" type="{kind}"><parent link="leg"/><child link="foot"/>
               <origin rpy="0 0 1.5707963267948966"/></joint>"#
        );
        robot(&text).unwrap().mechanism(&options())
    };
    let welded = foot("fixed").unwrap();
    let inertia = welded.bodies()[1].inertia().unwrap();
    let momentum = inertia.angular_momentum(&nalgebra::Matrix3::identity(), &Vector3::repeat(1.0));
    assert_relative_eq!(momentum, vector![0.12, 0.21, 0.32], epsilon = ROUND_OFF);
    let UrdfError::Body { source, .. } = foot("continuous").unwrap_err() else {
        panic!()
    };
    assert_eq!(*source, WorldError::MasslessInertia("foot".into()));
}

/// World of a robot with gravity.
fn world(robot: &Robot, base: Base) -> Result<World, String> {
    let options = RobotOptions { base, ..options() };
    let mechanism = robot
        .mechanism(&options)
        .map_err(|error| error.to_string())?;
    let builder: WorldBuilder = World::builder().mechanism(mechanism);
    let world = builder.gravity(vector![0.0, 0.0, -9.81]).build();
    world.map_err(|error| error.to_string())
}

#[test]
fn links_of_published_robots_start_at_the_poses_of_pinocchio() {
    for (file, expected) in references(&folder().join("links.json")) {
        let robot = Robot::read(folder().join(file)).unwrap();
        let world = world(&robot, Base::Fixed(Pose::identity())).unwrap();
        let state = world.initial_state();
        for (link, reference) in expected {
            let pose = &state.bodies[world.index_of(&link).unwrap()].pose;
            let position = Vector3::from(reference.translation);
            assert_relative_eq!(*pose.translation(), position, epsilon = ROUND_OFF);
        }
    }
}

/// Rolls out the robot in steps of 5 ms, on a fixed base and on a free base.
fn steps(robot: &Robot) -> Result<(), String> {
    for base in [Base::Fixed(Pose::identity()), Base::Free(Pose::identity())] {
        let world = world(robot, base)?;
        let plan = implicit(5e-3, 4);
        let result: Result<_, RolloutError> =
            world.rollout(&plan).run().map_err(|failure| failure.error);
        result.map_err(|error| error.to_string())?;
    }
    Ok(())
}

#[test]
#[ignore = "needs a folder of robots: see tests/data/robots/README.md"]
fn all_published_robots_move() {
    let Ok(folder) = std::env::var("ROBOTS").map(std::path::PathBuf::from) else {
        eprintln!("skipped: the variable ROBOTS is not set");
        return;
    };
    let (mut moved, mut refused) = (0, BTreeMap::new());
    for path in urdf_files(&folder) {
        assert!(path.ancestors().any(|parent| parent.ends_with(PACKAGE)));
        let Ok(robot) = Robot::read(&path) else {
            continue;
        };
        match steps(&robot) {
            Ok(()) => moved += 1,
            Err(error) => {
                println!("{}: {error}", path.display());
                *refused.entry(error).or_insert(0) += 1;
            }
        }
    }
    println!("{moved} robots moved, {} were refused", refused.len());
    assert!(moved > 0);
}

#[test]
fn everything_that_is_welded_to_a_fixed_base_is_fixed() {
    let pedestal = ARM.replace(
        r#"</collision></link>
<link name="arm">"#,
        r#"</collision><collision><geometry><box size="0.1 0.1 0.3"/></geometry></collision></link>
<link name="arm">"#,
    );
    let sensor = r#"<link name="sensor"/><joint name="plate" type="fixed"><parent link="base"/><child link="sensor"/><origin xyz="0.1 0 0"/></joint>"#;
    let options = RobotOptions {
        base: Base::Fixed(Pose::from_translation(vector![0.0, 2.0, 0.0])),
        ..options()
    };
    let arm = robot(&format!("{pedestal}{sensor}"))
        .unwrap()
        .mechanism(&options)
        .unwrap();
    let fixed = arm.bodies().iter().filter(|body| body.inertia().is_none());
    let fixed: Vec<_> = fixed.map(Body::name).collect();
    assert_eq!(fixed, ["base", "base/2", "sensor"]);
    let world = World::builder().mechanism(arm).build().unwrap();
    let sensor = world.index_of("sensor").unwrap();
    let position = *world.initial_state().bodies[sensor].position();
    assert_relative_eq!(position, vector![0.1, 2.0, 0.0], epsilon = ROUND_OFF);
}

#[test]
fn a_material_of_a_link_that_does_not_exist_is_refused() {
    let options = RobotOptions {
        materials: BTreeMap::from([("hnad".to_owned(), RUBBER)]),
        ..options()
    };
    let error = robot(ARM).unwrap().mechanism(&options).unwrap_err();
    let expected =
        "the options have a material of the link \"hnad\", but the links are [\"base\", ";
    assert!(error.to_string().starts_with(expected), "{error}");
}

#[test]
fn a_leader_that_does_not_exist_is_ignored_after_its_warning() {
    let text = ARM.replace(
        r#"<axis xyz="1 0 0"/>"#,
        r#"<axis xyz="1 0 0"/><mimic joint="elbow"/>"#,
    );
    let arm = robot(&text).unwrap();
    assert_eq!(arm.warnings().len(), 1);
    let arm = arm.mechanism(&options()).unwrap();
    assert!(arm.joints().all(|joint| joint.mimic().is_none()));
}
