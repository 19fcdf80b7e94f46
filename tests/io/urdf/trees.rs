//! Links and joints form one tree.

use super::{message, robot};
use hydroelastic::io::urdf::UrdfError;

/// Links, one per name, and a fixed joint for each pair of parent and child.
fn tree(links: &[&str], joints: &[[&str; 2]]) -> String {
    let links = links
        .iter()
        .map(|name| format!("<link name=\"{name}\"/>\n"));
    let joints = joints.iter().map(|[parent, child]| {
        format!(
            "<joint name=\"{parent}-{child}\" type=\"fixed\"><parent link=\"{parent}\"/><child link=\"{child}\"/></joint>\n"
        )
    });
    links.chain(joints).collect()
}

#[test]
fn links_are_sorted_depth_first_and_joints_like_their_children() {
    let elements = tree(
        &["f", "e", "d", "c", "b", "a"],
        &[["b", "c"], ["a", "b"], ["e", "f"], ["a", "e"], ["b", "d"]],
    );
    let robot = robot(&elements).unwrap();
    let links: Vec<_> = robot
        .links()
        .iter()
        .map(|link| link.name.as_str())
        .collect();
    assert_eq!(links, ["a", "b", "c", "d", "e", "f"]);
    for (joint, child) in robot.joints().iter().zip(&robot.links()[1..]) {
        assert_eq!(joint.child, child.name);
    }
    assert_eq!(robot.joints().len(), 5);
    assert_eq!(robot.name(), "arm");
}

#[test]
fn a_robot_without_links_is_an_error() {
    assert_eq!(message(""), "line 1: robot \"arm\" has no links");
}

#[test]
fn two_roots_are_an_error() {
    assert_eq!(
        message(&tree(&["a", "b", "c"], &[["a", "b"]])),
        "line 1: robot \"arm\" has 2 links without a parent, such as \"a\" and \"c\", but must have only one"
    );
}

#[test]
fn cycles_are_errors_with_and_without_a_root() {
    for (links, joints, line, length) in [
        (&["a", "b"][..], &[["a", "b"], ["b", "a"]][..], [4, 5], 2),
        (&["a"], &[["a", "a"]], [3, 3], 1),
        (
            &["r", "a", "b", "c"],
            &[["a", "b"], ["b", "c"], ["c", "a"]],
            [6, 8],
            3,
        ),
        // d hangs from the cycle.
        (
            &["r", "d", "b", "c"],
            &[["b", "d"], ["b", "c"], ["c", "b"]],
            [7, 8],
            2,
        ),
    ] {
        let error = robot(&tree(links, joints)).unwrap_err();
        let text = error.to_string();
        let UrdfError::Cycle { at, length: found } = error else {
            panic!("{text}");
        };
        assert_eq!(found, length, "{text}");
        assert!(line[0] <= at.line && at.line <= line[1], "{text}");
    }
    assert!(
        message(&tree(&["a"], &[["a", "a"]]))
            .ends_with("joint \"a-a\" is in a cycle of 1 joints, but a robot must be a tree")
    );
}

#[test]
fn a_link_with_two_parents_is_an_error() {
    assert_eq!(
        message(&tree(
            &["a", "b", "c"],
            &[["a", "b"], ["a", "c"], ["b", "c"]]
        )),
        "line 7: joint \"b-c\" moves the link \"c\", which the joint \"a-c\" also moves: a link may have only one parent"
    );
}

#[test]
fn unknown_parents_and_children_are_errors() {
    assert_eq!(
        message(&tree(&["a"], &[["b", "a"]])),
        "line 3: joint \"b-a\" refers to the parent link \"b\", but the robot has no such link"
    );
    assert_eq!(
        message(&tree(&["a"], &[["a", "b"]])),
        "line 3: joint \"a-b\" refers to the child link \"b\", but the robot has no such link"
    );
}

#[test]
fn duplicate_names_are_errors() {
    assert_eq!(
        message(&tree(&["a", "b", "a"], &[["a", "b"]])),
        "line 4: link \"a\" has the name of another in line 2, but names must be unique"
    );
    assert_eq!(
        message(&tree(&["a", "b"], &[["a", "b"], ["a", "b"]])),
        "line 5: joint \"a-b\" has the name of another in line 4, but names must be unique"
    );
}

#[test]
fn a_link_and_a_joint_may_have_the_same_name() {
    let elements = tree(&["a", "b"], &[["a", "b"]]).replace("a-b", "a");
    assert!(robot(&elements).is_ok());
}

#[test]
fn joints_that_mimic_each_other_are_an_error() {
    let joint = |child: &str, other: &str| {
        format!(
            r#"<joint name="j{child}" type="continuous"><parent link="a"/><child link="{child}"/><mimic joint="j{other}"/></joint>"#
        )
    };
    let links = tree(&["a", "b", "c", "d"], &[]);
    let cycle = links.clone() + &joint("b", "c") + &joint("c", "d") + &joint("d", "c");
    assert!(matches!(
        robot(&cycle).unwrap_err(),
        UrdfError::MimicCycle { .. }
    ));
    let chain = links
        + &joint("b", "c")
        + &joint("c", "d")
        + &joint("d", "c").replace("<mimic joint=\"jc\"/>", "");
    assert!(robot(&chain).is_ok());
}

#[test]
fn chains_of_many_links_need_no_stack() {
    let names: Vec<String> = (0..50_000).map(|index| index.to_string()).collect();
    let links: Vec<&str> = names.iter().map(String::as_str).collect();
    let joints: Vec<[&str; 2]> = links.windows(2).map(|pair| [pair[1], pair[0]]).collect();
    let sorted = robot(&tree(&links, &joints)).unwrap();
    assert_eq!(sorted.links()[0].name, "49999");
    assert_eq!(sorted.links().len(), names.len());
}
