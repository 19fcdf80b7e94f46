use super::Location;

/// Defect of a robot that the reader accepts, because published files have it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfWarning {
    /// No solid has the inertia.
    #[error(
        "{at} has the principal moments {:.3e}, {:.3e} and {:.3e} kg m², but no moment may be negative or above the sum of the others",
        moments[0],
        moments[1],
        moments[2]
    )]
    ImpossibleInertia {
        /// The `<inertia>` element.
        at: Location,
        /// Principal moments (kg m²), in increasing order.
        moments: [f64; 3],
    },
    /// A joint mimics a joint that does not exist.
    #[error("{at} mimics the joint {name:?}, but the robot has no such joint")]
    UnknownMimic {
        /// The joint that mimics.
        at: Location,
        /// Name of the missing joint.
        name: String,
    },
}
