//! Reader of robots in the Unified Robot Description Format (URDF).
//!
//! [`Robot::read`] reads links with their inertias and collision geometries, and joints with their limits, friction and dependences.
//! Visual geometries, materials, transmissions and elements of simulators are ignored.
//!
//! ```
//! use hydroelastic::io::urdf::{JointKind, Robot};
//!
//! let robot: Robot = r#"
//!     <robot name="pendulum">
//!         <link name="rod">
//!             <inertial>
//!                 <origin xyz="0 0 -0.2"/>
//!                 <mass value="0.5"/>
//!                 <inertia ixx="0.01" iyy="0.01" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
//!             </inertial>
//!         </link>
//!         <link name="base"/>
//!         <joint name="pivot" type="continuous">
//!             <parent link="base"/>
//!             <child link="rod"/>
//!             <axis xyz="0 1 0"/>
//!             <dynamics damping="0.02"/>
//!         </joint>
//!     </robot>"#
//!     .parse()?;
//! let [base, rod] = robot.links() else { panic!() };
//! assert_eq!((base.name.as_str(), rod.name.as_str()), ("base", "rod"));
//! assert!(base.inertial.is_none());
//! assert!(matches!(robot.joints()[0].kind, JointKind::Continuous(_)));
//! # Ok::<(), hydroelastic::io::urdf::UrdfError>(())
//! ```
//!
//! [`Robot::mechanism`] converts the robot to bodies and joints for a [`World`](crate::dynamics::World). [`Joint::dynamics_joint`] and
//! [`Collision::shape`] convert single joints and geometries.
//!
//! # Rules
//!
//! - A robot is one tree: one link has no parent, and every other link is the child of one joint. Links and joints have unique names.
//! - A link without `<inertial>` and a mass of zero are accepted. An inertia that no solid can have is accepted too, because many published
//!   robots have one. [`Robot::warnings`] lists these inertias.
//! - A joint may mimic any joint except itself. [`Robot::warnings`] lists joints that mimic a joint that does not exist.
//! - A missing `<axis>` is the x axis. Axes are normalized. The axis of a fixed or floating joint is ignored.
//! - `<origin>` has `xyz` and `rpy`, or `xyz` and `quat_xyzw`.
//! - Lengths of geometries are positive. Damping, friction, largest efforts and largest velocities are at least zero. Limits may be
//!   infinite.
//! - The file of a mesh is opened only when the mesh is converted to a shape.

mod collision;
mod dynamics_joint;
mod element;
mod error;
mod inertial;
mod joint;
mod link;
mod location;
mod mechanism;
mod mesh_path;
mod origin;
mod robot;
mod shape;
mod tree;
mod warning;

pub use collision::{Collision, Geometry};
pub use dynamics_joint::{JointOptions, StopLaw};
pub use error::UrdfError;
pub use joint::{Joint, JointKind, Limit, Mimic};
pub use link::Link;
pub use location::Location;
pub use mechanism::{Base, RobotOptions};
pub use robot::Robot;
pub use shape::{MeshShape, ShapeOptions};
pub use warning::UrdfWarning;
