use super::Location;
use crate::dynamics::WorldError;
use crate::io::FileError;
use crate::mesh::{MeshError, SurfaceError};
use std::error::Error;
use std::path::PathBuf;

/// Reason why a robot or a shape of its links cannot be read.
///
/// Every message begins with the file, the line and the element.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The file cannot be read from the disk.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not UTF-8 or not well-formed XML.
    #[error("{at} is not XML in UTF-8, or is damaged: {source}")]
    Xml {
        /// Place of the error.
        at: Location,
        /// Error of the parser.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The root element is not a robot.
    #[error("{at} must be <robot>")]
    NotARobot {
        /// The root element.
        at: Location,
    },
    /// The text has macros of xacro. The program xacro expands them.
    #[error("{at} is a macro: expand the file with the program xacro first")]
    Macro {
        /// The macro.
        at: Location,
    },
    /// A required attribute is missing.
    #[error("{at} has no attribute {attribute:?}, but must have one")]
    MissingAttribute {
        /// The element.
        at: Location,
        /// Name of the attribute.
        attribute: &'static str,
    },
    /// A required element is missing.
    #[error("{at} contains no {expected}, but must contain one")]
    MissingElement {
        /// The parent of the missing element.
        at: Location,
        /// The missing element.
        expected: &'static str,
    },
    /// An element that may occur once occurs twice.
    #[error("{at} is repeated, but may occur only once")]
    RepeatedElement {
        /// The second element.
        at: Location,
    },
    /// An attribute is not a number, or has the wrong count of numbers.
    #[error("{at} has {attribute}={found:?}, but needs {expected}")]
    NotANumber {
        /// The element.
        at: Location,
        /// Name of the attribute.
        attribute: &'static str,
        /// First characters of the attribute.
        found: String,
        /// Count and kind of the numbers.
        expected: &'static str,
    },
    /// A number is outside its range.
    #[error("{at} has {attribute}={found}, but needs {expected}")]
    OutOfRange {
        /// The element.
        at: Location,
        /// Name of the attribute.
        attribute: &'static str,
        /// The number.
        found: f64,
        /// The range.
        expected: &'static str,
    },
    /// The lower limit of a joint is above the upper limit.
    #[error("{at} has the lower limit {lower} above the upper limit {upper}")]
    ReversedLimits {
        /// The limits.
        at: Location,
        /// Lower limit (rad or m).
        lower: f64,
        /// Upper limit (rad or m).
        upper: f64,
    },
    /// An axis or a quaternion is zero.
    #[error("{at} has only zeros in {attribute:?}, but needs a direction")]
    ZeroDirection {
        /// The element.
        at: Location,
        /// Name of the attribute.
        attribute: &'static str,
    },
    /// An origin has two rotations: one by roll, pitch and yaw, and one by a quaternion.
    #[error("{at} has both \"rpy\" and \"quat_xyzw\", but may have only one rotation")]
    TwoRotations {
        /// The origin.
        at: Location,
    },
    /// The type of a joint is unknown.
    #[error(
        "{at} has the type {found:?}, but must be revolute, continuous, prismatic, fixed, floating or planar"
    )]
    UnknownJointType {
        /// The joint.
        at: Location,
        /// First characters of the type.
        found: String,
    },
    /// A name is empty.
    #[error("{at} has an empty {attribute:?}, but needs a name")]
    EmptyName {
        /// The element.
        at: Location,
        /// Name of the attribute.
        attribute: &'static str,
    },
    /// Two links or two joints have the same name.
    #[error("{at} has the name of another in line {first_line}, but names must be unique")]
    DuplicateName {
        /// The second link or joint.
        at: Location,
        /// Line of the first link or joint.
        first_line: usize,
    },
    /// The robot has no links.
    #[error("{at} has no links")]
    NoLinks {
        /// The robot.
        at: Location,
    },
    /// The parent or child of a joint does not exist.
    #[error("{at} refers to the {role} link {name:?}, but the robot has no such link")]
    UnknownLink {
        /// The joint.
        at: Location,
        /// Role of the link: `parent` or `child`.
        role: &'static str,
        /// Name of the link.
        name: String,
    },
    /// A link is the child of two joints.
    #[error(
        "{at} moves the link {child:?}, which the joint {other:?} also moves: a link may have only one parent"
    )]
    TwoParents {
        /// The second joint.
        at: Location,
        /// Location of the link in the file.
        child: String,
        /// The first joint.
        other: String,
    },
    /// Several links have no parent.
    #[error(
        "{at} has {count} links without a parent, such as {first:?} and {second:?}, but must have only one"
    )]
    SeveralRoots {
        /// The robot.
        at: Location,
        /// Number of links without a parent.
        count: usize,
        /// The first of these links.
        first: String,
        /// The second of these links.
        second: String,
    },
    /// Joints form a cycle.
    #[error("{at} is in a cycle of {length} joints, but a robot must be a tree")]
    Cycle {
        /// A joint of the cycle.
        at: Location,
        /// Number of joints in the cycle.
        length: usize,
    },
    /// A joint mimics itself, directly or through other joints.
    #[error("{at} mimics itself, directly or through other joints")]
    MimicCycle {
        /// A joint of the cycle.
        at: Location,
    },
    /// The folder of a package is not known.
    #[error("{at} refers to the package {package:?}, but only the folders of {known:?} were given")]
    UnknownPackage {
        /// The mesh.
        at: Location,
        /// Name of the package.
        package: String,
        /// The packages that were given.
        known: Vec<String>,
    },
    /// The scheme of a file name is not supported.
    #[error("{at} refers to {found:?}, but only package://, file:// and paths can be read")]
    UnknownScheme {
        /// The mesh.
        at: Location,
        /// The file name.
        found: String,
    },
    /// The file of a mesh cannot be read.
    #[error("{at}: {source}")]
    MeshFile {
        /// The mesh.
        at: Location,
        /// Cause.
        source: Box<FileError>,
    },
    /// A scaled mesh is not a valid surface, or a capsule is too thin for its length.
    #[error("{at} is not a usable surface: {source}")]
    Surface {
        /// The geometry.
        at: Location,
        /// Cause.
        source: SurfaceError,
    },
    /// A geometry cannot become a pressure field.
    #[error("{at} cannot become a pressure field: {source}")]
    Field {
        /// The geometry.
        at: Location,
        /// Cause.
        source: MeshError,
    },
    /// A link cannot become a body.
    #[error("{at} cannot become a body: {source}")]
    Body {
        /// Location of the link in the file.
        at: Location,
        /// Cause.
        source: Box<WorldError>,
    },
    /// The dynamics have no joint of this type.
    #[error(
        "{at} is a {found} joint, but only revolute, continuous, prismatic and fixed joints can be converted"
    )]
    UnsupportedJoint {
        /// The joint.
        at: Location,
        /// Type of the joint.
        found: &'static str,
    },
}
