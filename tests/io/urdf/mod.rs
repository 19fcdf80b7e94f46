//! Robots in URDF.

mod conversions;
mod damage;
mod dynamics;
mod elements;
mod mechanism;
mod meshes;
mod published;
mod trees;

use hydroelastic::io::urdf::{Robot, UrdfError};

/// Robot with these elements after the first line.
fn robot(elements: &str) -> Result<Robot, UrdfError> {
    format!("<robot name=\"arm\">\n{elements}\n</robot>").parse()
}

/// Message of the error for these elements, from the second line on.
fn message(elements: &str) -> String {
    robot(elements).unwrap_err().to_string()
}

/// Robot with the links `base` and `tip`, and this joint between them.
fn jointed(kind: &str, elements: &str) -> String {
    format!(
        r#"<link name="base"/><link name="tip"/>
<joint name="elbow" type="{kind}"><parent link="base"/><child link="tip"/>{elements}</joint>"#
    )
}
