//! Links, joints and their attributes.

use super::{jointed, message, robot};
use approx::assert_relative_eq;
use hydroelastic::io::urdf::{Geometry, Joint, JointKind, Link, Robot, UrdfError, UrdfWarning};
use hydroelastic::spatial::rotation_from_vector;
use nalgebra::{Matrix3, Vector3, vector};
use std::f64::consts::FRAC_PI_2;

/// Rounding error of products of rotations.
const ROUND_OFF: f64 = 1e-15;

fn link(elements: &str) -> Link {
    let robot = robot(&format!("<link name=\"hand\">{elements}</link>")).unwrap();
    robot.links()[0].clone()
}

fn link_message(elements: &str) -> String {
    message(&format!("<link name=\"hand\">\n{elements}</link>"))
}

fn joint(kind: &str, elements: &str) -> Joint {
    robot(&jointed(kind, elements)).unwrap().joints()[0].clone()
}

fn joint_message(kind: &str, elements: &str) -> String {
    message(&jointed(kind, elements))
}

fn inertial(mass: &str, tensor: &str) -> String {
    format!("<inertial><mass value=\"{mass}\"/><inertia {tensor}/></inertial>")
}

const UNIT: &str = r#"ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0""#;

#[test]
fn an_inertial_frame_rotates_the_tensor_and_places_the_center_of_mass() {
    let hand = link(
        r#"<inertial><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><mass value="4"/>
           <inertia ixx="5" iyy="6" izz="7" ixy="0.1" ixz="0.2" iyz="0.3"/></inertial>"#,
    );
    let properties = hand.inertial.unwrap();
    assert_relative_eq!(properties.mass, 4.0);
    assert_relative_eq!(properties.center_of_mass, vector![1.0, 2.0, 3.0]);
    // A quarter turn about z takes x to y and y to -x.
    let expected = Matrix3::new(6.0, -0.1, -0.3, -0.1, 5.0, 0.2, -0.3, 0.2, 7.0);
    assert_relative_eq!(properties.inertia, expected, epsilon = 1e-14);
}

#[test]
fn roll_pitch_and_yaw_are_rotations_about_fixed_x_then_y_then_z() {
    let found = joint("fixed", r#"<origin xyz="1 2 3" rpy="0.3 -0.4 2.5"/>"#).origin;
    let about = |axis: Vector3<f64>, angle: f64| rotation_from_vector(&(axis * angle));
    let expected = about(Vector3::z(), 2.5) * about(Vector3::y(), -0.4) * about(Vector3::x(), 0.3);
    assert_relative_eq!(*found.rotation(), expected, epsilon = ROUND_OFF);
    assert_relative_eq!(*found.translation(), vector![1.0, 2.0, 3.0]);
}

#[test]
fn a_quaternion_of_any_length_is_a_rotation() {
    let found = joint("fixed", r#"<origin quat_xyzw="0 0 1e200 1e200"/>"#).origin;
    let expected = rotation_from_vector(&vector![0.0, 0.0, FRAC_PI_2]);
    assert_relative_eq!(*found.rotation(), expected, epsilon = ROUND_OFF);
    let zero = joint_message("fixed", r#"<origin quat_xyzw="0 0 0 0"/>"#);
    assert!(zero.contains("only zeros in \"quat_xyzw\""), "{zero}");
    let both = joint_message("fixed", r#"<origin rpy="0 0 0" quat_xyzw="0 0 0 1"/>"#);
    assert!(both.contains("both \"rpy\" and \"quat_xyzw\""), "{both}");
}

#[test]
fn a_missing_origin_is_the_identity() {
    for origin in ["", "<origin/>"] {
        let found = joint("fixed", origin).origin;
        assert_eq!(*found.rotation(), Matrix3::identity());
        assert_eq!(*found.translation(), Vector3::zeros());
    }
}

#[test]
fn links_without_mass_and_without_inertial_differ() {
    assert!(link("").inertial.is_none());
    let zero = UNIT.replace('1', "0");
    assert!(link(&inertial("0", &zero)).inertial.unwrap().mass == 0.0);
    let massless = link(&inertial("0", UNIT)).inertial.unwrap();
    assert_eq!(
        (massless.mass, massless.inertia),
        (0.0, Matrix3::identity())
    );
}

#[test]
fn a_negative_mass_is_an_error() {
    assert_eq!(
        link_message(&inertial("-1", UNIT)),
        "line 3: <mass> of link \"hand\" has value=-1, but needs at least zero"
    );
}

#[test]
fn an_impossible_inertia_is_reported_but_no_error() {
    for (tensor, moments) in [
        (UNIT.replace("ixx=\"1\"", "ixx=\"-1\""), [-1.0, 1.0, 1.0]),
        (UNIT.replace("izz=\"1\"", "izz=\"3\""), [1.0, 1.0, 3.0]),
        (UNIT.replace("ixy=\"0\"", "ixy=\"2\""), [-1.0, 1.0, 3.0]),
    ] {
        let elements = format!("<link name=\"hand\">\n{}</link>", inertial("1", &tensor));
        let robot = robot(&elements).unwrap();
        let [found] = robot.warnings() else {
            panic!("{tensor}: {:?}", robot.warnings());
        };
        let UrdfWarning::ImpossibleInertia {
            at,
            moments: found_moments,
            ..
        } = found
        else {
            panic!("{found}");
        };
        let sorted = Vector3::from(*found_moments);
        assert_relative_eq!(sorted, Vector3::from(moments), epsilon = 1e-14);
        assert_eq!(at.line, 3);
        let text = found.to_string();
        assert!(
            text.starts_with("line 3: <inertia> of link \"hand\" has"),
            "{text}"
        );
    }
}

#[test]
fn inertias_of_solids_plates_and_rounded_points_are_not_reported() {
    for tensor in [
        UNIT.to_owned(),
        UNIT.replace("izz=\"1\"", "izz=\"2\""),
        UNIT.replace("izz=\"1\"", "izz=\"2.0001\""),
        UNIT.replace('1', "0"),
        UNIT.replace('1', "1e-20")
            .replace("ixx=\"1e-20\"", "ixx=\"-1e-20\""),
    ] {
        let elements = format!("<link name=\"hand\">{}</link>", inertial("1", &tensor));
        let robot = robot(&elements).unwrap();
        assert!(robot.warnings().is_empty(), "{tensor}");
    }
}

#[test]
fn what_is_not_a_number_is_an_error_with_the_text() {
    let mass = link_message(&inertial("one", UNIT));
    assert_eq!(
        mass,
        "line 3: <mass> of link \"hand\" has value=\"one\", but needs one finite number"
    );
    for text in ["nan", "inf", "", "1 2", "1,5", "${mass}"] {
        let error = robot(&format!(
            "<link name=\"hand\">{}</link>",
            inertial(text, UNIT)
        ));
        let error = error.unwrap_err();
        assert!(
            matches!(error, UrdfError::NotANumber { found, .. } if found == text),
            "{text}"
        );
    }
    for (text, expected) in [("0 0", "three"), ("0 0 0 0", "three"), ("0 a 0", "three")] {
        let found = joint_message("fixed", &format!("<origin xyz=\"{text}\"/>"));
        assert!(
            found.starts_with("line 3: <origin> of joint \"elbow\" has xyz="),
            "{found}"
        );
        assert!(
            found.ends_with(&format!("{expected} finite numbers")),
            "{found}"
        );
    }
}

#[test]
fn missing_and_repeated_parts_are_errors() {
    for (elements, expected) in [
        (
            "<inertial/>",
            "line 3: <inertial> of link \"hand\" contains no <mass>, but must contain one",
        ),
        (
            "<inertial><mass value=\"1\"/></inertial>",
            "line 3: <inertial> of link \"hand\" contains no <inertia>, but must contain one",
        ),
        (
            "<inertial/><inertial/>",
            "line 3: <inertial> of link \"hand\" is repeated, but may occur only once",
        ),
        (
            "<inertial><mass/></inertial>",
            "line 3: <mass> of link \"hand\" has no attribute \"value\", but must have one",
        ),
        (
            "<collision/>",
            "line 3: <collision> of link \"hand\" contains no <geometry>, but must contain one",
        ),
        (
            "<collision><geometry/></collision>",
            "line 3: <geometry> of link \"hand\" contains no <box>, <sphere>, <cylinder>, <capsule> or <mesh>, but must contain one",
        ),
        (
            "<collision><geometry><box size='1 1 1'/><sphere radius='1'/></geometry></collision>",
            "line 3: <sphere> of link \"hand\" is repeated, but may occur only once",
        ),
    ] {
        assert_eq!(link_message(elements), expected);
    }
    let without_parent =
        r#"<link name="a"/><joint name="elbow" type="fixed"><child link="a"/></joint>"#;
    assert_eq!(
        message(without_parent),
        "line 2: joint \"elbow\" contains no <parent>, but must contain one"
    );
    assert_eq!(
        message("<link/>"),
        "line 2: <link> has no attribute \"name\", but must have one"
    );
    assert_eq!(
        message("<link name=''/>"),
        "line 2: link \"\" has an empty \"name\", but needs a name"
    );
}

#[test]
fn all_geometries_are_read() {
    let hand = link(
        r#"<collision><origin xyz="0 0 1"/><geometry><box size="1 2 3"/></geometry></collision>
           <collision><geometry><sphere radius="0.5"/></geometry></collision>
           <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
           <collision><geometry><capsule radius="0.5" length="2"/></geometry></collision>
           <collision><geometry><mesh filename="a.stl"/></geometry></collision>
           <collision><geometry><mesh filename="b.stl" scale="1 -2 1"/></geometry></collision>"#,
    );
    let found: Vec<Geometry> = hand
        .collisions
        .iter()
        .map(|one| one.geometry.clone())
        .collect();
    let debug = format!("{found:?}");
    assert_eq!(
        debug,
        "[Box { lengths: [1.0, 2.0, 3.0] }, Sphere { radius: 0.5 }, \
         Cylinder { radius: 0.5, length: 2.0 }, Capsule { radius: 0.5, length: 2.0 }, \
         Mesh { path: \"a.stl\", scale: [1.0, 1.0, 1.0] }, \
         Mesh { path: \"b.stl\", scale: [1.0, -2.0, 1.0] }]"
    );
    assert_relative_eq!(*hand.collisions[0].origin.translation(), Vector3::z());
}

#[test]
fn lengths_must_be_positive_and_scales_must_not_be_zero() {
    for geometry in [
        "<box size='1 0 1'/>",
        "<sphere radius='-1'/>",
        "<cylinder radius='1' length='0'/>",
        "<capsule radius='0' length='1'/>",
        "<mesh filename='a.stl' scale='1 0 1'/>",
    ] {
        let element = format!(
            "<link name='hand'><collision><geometry>{geometry}</geometry></collision></link>"
        );
        let error = robot(&element).unwrap_err();
        assert!(matches!(error, UrdfError::OutOfRange { .. }), "{error}");
    }
}

#[test]
fn visuals_are_ignored_even_if_they_are_broken() {
    let hand = link(
        r#"<visual><geometry><mesh/></geometry><material name="red"><texture/></material></visual>
           <visual><origin xyz="a"/></visual><visual/>"#,
    );
    assert!(hand.collisions.is_empty());
    assert!(robot("<material name='red'><texture/></material><link name='a'/>").is_ok());
}

#[test]
fn elements_of_simulators_are_ignored() {
    let elements = r#"<link name="a"><contact/><gravity/></link>
        <gazebo reference="a"><link name="a"/><joint name="b"/></gazebo>
        <transmission name="t"><joint name="b"/></transmission>"#;
    assert_eq!(robot(elements).unwrap().links().len(), 1);
}

#[test]
fn all_types_of_joints_are_read() {
    let y = Vector3::y_axis();
    for (name, expected) in [
        ("revolute", JointKind::Revolute(y)),
        ("continuous", JointKind::Continuous(y)),
        ("prismatic", JointKind::Prismatic(y)),
        ("fixed", JointKind::Fixed),
        ("floating", JointKind::Floating),
        ("planar", JointKind::Planar(y)),
    ] {
        let kind = joint(name, "<axis xyz=\"0 1 0\"/>").kind;
        assert_eq!(kind, expected);
        assert_eq!(kind.name(), name);
    }
    assert_eq!(
        joint_message("ball", ""),
        "line 3: joint \"elbow\" has the type \"ball\", but must be revolute, continuous, prismatic, fixed, floating or planar"
    );
}

#[test]
fn a_missing_axis_is_the_x_axis() {
    assert_eq!(joint("revolute", "").kind.axis(), Some(Vector3::x_axis()));
}

#[test]
fn axes_are_normalized() {
    for text in ["0 3 4", "0 3e300 4e300", "0 3e-320 4e-320"] {
        let axis = joint("continuous", &format!("<axis xyz=\"{text}\"/>"))
            .kind
            .axis();
        // The last vector is subnormal, with 3 digits.
        assert_relative_eq!(*axis.unwrap(), vector![0.0, 0.6, 0.8], epsilon = 1e-3);
        assert_relative_eq!(axis.unwrap().norm(), 1.0, epsilon = ROUND_OFF);
    }
}

#[test]
fn a_zero_axis_is_an_error_unless_the_joint_has_none() {
    let zero = "<axis xyz=\"0 0 0\"/>";
    for kind in ["revolute", "continuous", "prismatic", "planar"] {
        assert_eq!(
            joint_message(kind, zero),
            "line 3: <axis> of joint \"elbow\" has only zeros in \"xyz\", but needs a direction"
        );
    }
    for kind in ["fixed", "floating"] {
        assert_eq!(joint(kind, zero).kind.axis(), None);
    }
}

#[test]
fn limits_that_the_file_does_not_have_are_none() {
    let limit = |attributes| {
        joint("revolute", &format!("<limit {attributes}/>"))
            .limit
            .unwrap()
    };
    assert!(joint("revolute", "").limit.is_none());
    let all = limit(r#"lower="-1" upper="2" effort="3" velocity="4""#);
    assert_eq!(
        (all.range, all.effort, all.velocity),
        (Some([-1.0, 2.0]), Some(3.0), Some(4.0))
    );
    let none = limit("");
    assert_eq!((none.range, none.effort, none.velocity), (None, None, None));
    assert_eq!(limit("upper=\"1\"").range, Some([0.0, 1.0]));
    assert_eq!(
        limit("lower=\"-inf\"").range,
        Some([f64::NEG_INFINITY, 0.0])
    );
    assert_eq!(limit("effort=\"inf\"").effort, Some(f64::INFINITY));
}

#[test]
fn impossible_limits_are_errors() {
    assert_eq!(
        joint_message("revolute", "<limit lower=\"2\" upper=\"1\"/>"),
        "line 3: <limit> of joint \"elbow\" has the lower limit 2 above the upper limit 1"
    );
    assert_eq!(
        joint_message("revolute", "<limit effort=\"-1\"/>"),
        "line 3: <limit> of joint \"elbow\" has effort=-1, but needs at least zero"
    );
    let error = robot(&jointed("revolute", "<limit velocity=\"nan\"/>")).unwrap_err();
    assert!(matches!(error, UrdfError::NotANumber { .. }), "{error}");
}

#[test]
fn damping_and_friction_are_zero_or_positive() {
    let damped = joint("revolute", "<dynamics damping=\"0.5\"/>");
    assert_eq!((damped.damping, damped.friction), (0.5, 0.0));
    let rough = joint("revolute", "<dynamics friction=\"0.5\"/>");
    assert_eq!((rough.damping, rough.friction), (0.0, 0.5));
    let error = robot(&jointed("revolute", "<dynamics damping=\"-1\"/>")).unwrap_err();
    assert!(
        matches!(
            error,
            UrdfError::OutOfRange {
                attribute: "damping",
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn a_mimic_has_multiplier_one_and_offset_zero_by_default() {
    let mimic = |attributes: &str| {
        let elements = format!(
            r#"<link name="a"/><link name="b"/><link name="c"/>
            <joint name="ab" type="prismatic"><parent link="a"/><child link="b"/></joint>
            <joint name="ac" type="prismatic"><parent link="a"/><child link="c"/><mimic {attributes}/></joint>"#
        );
        robot(&elements).map(|robot| robot.joints()[1].mimic.clone().unwrap())
    };
    let plain = mimic("joint='ab'").unwrap();
    assert_eq!(
        (plain.joint.as_str(), plain.multiplier, plain.offset),
        ("ab", 1.0, 0.0)
    );
    let other = mimic("joint='ab' multiplier='-2' offset='0.1'").unwrap();
    assert_eq!((other.multiplier, other.offset), (-2.0, 0.1));
    let itself = mimic("joint='ac'").unwrap_err().to_string();
    assert_eq!(
        itself,
        "line 4: joint \"ac\" mimics itself, directly or through other joints"
    );
}

#[test]
fn a_mimic_of_an_unknown_joint_is_a_warning() {
    let robot = robot(&jointed("revolute", "<mimic joint='xy'/>")).unwrap();
    let [warning] = robot.warnings() else {
        panic!("{:?}", robot.warnings());
    };
    assert_eq!(
        warning.to_string(),
        "line 3: joint \"elbow\" mimics the joint \"xy\", but the robot has no such joint"
    );
    assert_eq!(robot.joints()[0].mimic.as_ref().unwrap().joint, "xy");
}

#[test]
fn other_roots_and_macros_are_errors() {
    let parse = |text: &str| text.parse::<Robot>().unwrap_err().to_string();
    assert_eq!(parse("<sdf/>"), "line 1: <sdf> must be <robot>");
    assert_eq!(
        parse("<robot/>"),
        "line 1: <robot> has no attribute \"name\", but must have one"
    );
    assert_eq!(
        parse(
            "<robot name='arm' xmlns:xacro='http://www.ros.org/wiki/xacro'>\n<xacro:include/></robot>"
        ),
        "line 2: <include> of robot \"arm\" is a macro: expand the file with the program xacro first"
    );
}
