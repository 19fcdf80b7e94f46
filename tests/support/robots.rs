//! Robots: pads on slides, a hand of five fingers, an arm with a ball at its tip, and a quadruped.

use super::worlds::{
    at, cuboid, dynamic, falling, fixed, icosphere, rigid_floor, rubbing, sliding_at,
};
use hydroelastic::contact::HalfSpace;
use hydroelastic::dynamics::{Body, BodyShape, BodyState, Joint, Mass, Material, World};
use hydroelastic::spatial::{MassProperties, Pose};
use nalgebra::{Matrix3, Unit, Vector3, vector};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Friction of all contacts.
pub const FRICTION: f64 = 0.7;

const X: Unit<Vector3<f64>> = Unit::new_unchecked(Vector3::new(1.0, 0.0, 0.0));
const Y: Unit<Vector3<f64>> = Unit::new_unchecked(Vector3::new(0.0, 1.0, 0.0));
const Z: Unit<Vector3<f64>> = Unit::new_unchecked(Vector3::new(0.0, 0.0, 1.0));

fn skin(modulus: f64) -> Material {
    rubbing(modulus, 0.5, FRICTION)
}

/// Returns a link without a shape: a rod of a mass (kg) from the origin of its frame to a point.
fn rod(name: &str, mass: f64, end: Vector3<f64>, joint: Joint) -> Body {
    let across = Matrix3::identity() * end.norm_squared() - end * end.transpose();
    let properties = MassProperties {
        mass,
        center_of_mass: end / 2.0,
        inertia: (across / 12.0 + Matrix3::identity() * 1e-4) * mass,
    };
    let body = Body::dynamic(
        name,
        BodyShape::None,
        Material::rigid(),
        Mass::Properties(properties),
    );
    body.unwrap().with_joint(joint).unwrap()
}

/// Returns a soft ball that is welded to a link.
fn tip(name: &str, radius: f64, modulus: f64, link: &str, place: [f64; 3]) -> Body {
    let weld = Joint::fixed(name)
        .with_parent(link)
        .with_origin(Pose::from_translation(place.into()));
    let ball = dynamic(name, icosphere(radius, 2), skin(modulus), 0.01);
    ball.with_joint(weld).unwrap()
}

/// Returns two pads on slides that press a free box of a mass (kg) with a force (N) each. Nothing supports the box.
pub fn pads(force: f64, mass: f64) -> World {
    let pad = |name: &str, axis: Unit<Vector3<f64>>| {
        let center = axis.scale(-0.0301) + vector![0.0, 0.001, 0.0];
        let slide = Joint::prismatic(name, axis)
            .with_origin(Pose::from_translation(center))
            .with_damping(20.0)
            .with_torque(force);
        let pad = dynamic(name, cuboid([0.04, 0.06, 0.04]), skin(1e6), 0.2);
        pad.with_joint(slide).unwrap()
    };
    let body = dynamic("box", cuboid([0.02, 0.03, 0.02]), skin(1e6), mass);
    falling(vec![body, pad("left", X), pad("right", -X)])
}

/// Displacement (m) of the palm of the [`hand`] along x and z.
pub const CARRIED: f64 = 0.1;

/// Names of the joints of the [`hand`] that close it.
pub fn closing_joints() -> Vec<String> {
    let joints = (0..5).flat_map(|finger| (1..4).map(move |joint| (finger, joint)));
    joints
        .map(|(finger, joint)| finger_joint(finger, joint))
        .collect()
}

fn finger_joint(finger: usize, joint: usize) -> String {
    format!("finger {finger} joint {joint}")
}

/// Returns a hand above a free ball of 1,280 facets. Five fingers of four joints close within 0.1 s. The last three joints of each finger
/// have the target `squeeze` (rad). Then the palm lifts the ball and carries it aside, until 0.6 s.
pub fn hand(squeeze: f64) -> World {
    let palm = Body::kinematic("palm", BodyShape::None, Material::rigid(), Arc::new(palm));
    let ball = dynamic("ball", icosphere(0.05, 3), skin(1e6), 0.1);
    let mut bodies = vec![
        ball.with_pose(at(0.0, 0.0, 0.05)),
        rigid_floor(FRICTION),
        palm.unwrap(),
    ];
    let segment = vector![0.0, 0.0, -0.045];
    for finger in 0..5 {
        let turn = Vector3::z() * (TAU * (finger as f64 + 0.3) / 5.0);
        let knuckle = Pose::from_rotation_vector(&turn, Vector3::zeros()) * at(0.07, 0.0, 0.0);
        let mut parent = "palm".to_owned();
        for joint in 0..4 {
            let (axis, target, origin) = match joint {
                0 => (Z, 0.0, knuckle),
                1 => (Y, squeeze, Pose::identity()),
                _ => (Y, squeeze, Pose::from_translation(segment)),
            };
            let name = finger_joint(finger, joint);
            let hinge = Joint::revolute(&name, axis)
                .with_parent(&parent)
                .with_origin(origin)
                .with_armature(1e-4)
                .with_servo(4.0, 0.1)
                .with_targets(0.1, vec![0.0, target]);
            bodies.push(rod(&name, 0.03, segment, hinge));
            parent = name;
        }
        bodies.push(tip(
            &format!("tip {finger}"),
            0.012,
            1e6,
            &parent,
            [0.0, 0.0, -0.03],
        ));
    }
    falling(bodies)
}

/// State of the palm at a time (s).
fn palm(time: f64) -> BodyState {
    let [x, x_rate] = smooth((time - 0.3) / 0.3);
    let [z, z_rate] = smooth((time - 0.15) / 0.3);
    BodyState {
        pose: at(CARRIED * x, 0.0, 0.15 + CARRIED * z),
        twist: sliding_at(vector![x_rate, 0.0, z_rate] * (CARRIED / 0.3)),
    }
}

/// Returns value and derivative of a transition from 0 at 0 to 1 at 1, with zero derivatives at both ends.
fn smooth(part: f64) -> [f64; 2] {
    let part = part.clamp(0.0, 1.0);
    [
        (1.0 - (PI * part).cos()) / 2.0,
        PI / 2.0 * (PI * part).sin(),
    ]
}

/// Axis, origin (m), mass (kg), end (m) and initial angle (rad) of a link of the [`arm`].
type ArmLink = (Unit<Vector3<f64>>, [f64; 3], f64, [f64; 3], f64);

const ARM: [ArmLink; 7] = [
    (Z, [0.0, 0.0, 0.33], 4.0, [0.0, 0.0, -0.12], 0.1),
    (Y, [0.0, 0.0, 0.0], 4.0, [0.0, 0.0, 0.32], -0.5),
    (Z, [0.0, 0.0, 0.32], 3.0, [0.08, 0.0, 0.0], 0.1),
    (Y, [0.08, 0.0, 0.0], 3.0, [-0.08, 0.0, 0.38], 2.1),
    (Z, [-0.08, 0.0, 0.38], 2.5, [0.0, 0.0, -0.2], 0.05),
    (Y, [0.0, 0.0, 0.0], 1.5, [0.09, 0.0, 0.0], -1.62),
    (Z, [0.09, 0.0, 0.0], 0.8, [0.0, 0.0, -0.12], 0.3),
];

/// Returns an arm of seven joints without actuators, with a soft ball at its tip, 5 cm above a rigid table.
pub fn arm(modulus: f64) -> World {
    let mut bodies = Vec::new();
    for (number, (axis, origin, mass, end, angle)) in (1..).zip(ARM) {
        let name = format!("joint {number}");
        let mut hinge = Joint::revolute(&name, axis)
            .with_origin(Pose::from_translation(origin.into()))
            .with_armature(0.1)
            .with_damping(0.5)
            .with_position(angle);
        if number > 1 {
            hinge = hinge.with_parent(&format!("joint {}", number - 1));
        }
        bodies.push(rod(&name, mass, end.into(), hinge));
    }
    let radius = 0.03;
    bodies.push(tip("tip", radius, modulus, "joint 7", [0.0, 0.0, -0.15]));
    let height = falling(bodies.clone()).initial_state().bodies[7]
        .position()
        .z;
    let table = fixed(
        "table",
        HalfSpace::rigid(),
        Material::rigid().with_friction(FRICTION),
    );
    bodies.push(table.with_pose(at(0.0, 0.0, height - radius - 0.05)));
    falling(bodies)
}

/// Returns a quadruped with a free trunk, twelve joints with servos and soft feet, 5 cm above a rigid floor.
pub fn quadruped(modulus: f64) -> World {
    let (bent, segment, foot) = (0.65_f64, 0.2, 0.02);
    let trunk = MassProperties {
        mass: 9.0,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal(&vector![0.07, 0.2, 0.25]),
    };
    let trunk = Body::dynamic(
        "trunk",
        BodyShape::None,
        Material::rigid(),
        Mass::Properties(trunk),
    );
    let height = 2.0 * segment * bent.cos() + foot + 0.05;
    let mut bodies = vec![
        trunk.unwrap().with_pose(at(0.0, 0.0, height)),
        rigid_floor(FRICTION),
    ];
    for (leg, [x, y]) in [[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]]
        .into_iter()
        .enumerate()
    {
        let side = vector![0.0, 0.6 * y, 0.0];
        let down = vector![0.0, 0.0, -segment];
        // The knees of front and hind legs bend towards each other.
        let bend = -bent * f64::signum(x);
        let mut parent = "trunk".to_owned();
        for (part, axis, origin, mass, end, angle) in [
            ("hip", X, vector![x, y, 0.0], 0.6, side, 0.0),
            ("thigh", Y, side, 0.9, down, bend),
            ("shank", Y, down, 0.2, down, -2.0 * bend),
        ] {
            let name = format!("{part} {leg}");
            let hinge = Joint::revolute(&name, axis)
                .with_parent(&parent)
                .with_origin(Pose::from_translation(origin))
                .with_armature(0.01)
                .with_position(angle)
                .with_servo(300.0, 8.0)
                .with_target(angle, 0.0);
            bodies.push(rod(&name, mass, end, hinge));
            parent = name;
        }
        bodies.push(tip(
            &format!("foot {leg}"),
            foot,
            modulus,
            &parent,
            down.into(),
        ));
    }
    falling(bodies)
}
