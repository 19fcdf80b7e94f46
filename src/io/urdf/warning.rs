use super::Location;
use crate::mesh::{SurfaceError, SurfaceWarning};

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
    /// Components of the surface of a mesh were turned inwards and are reversed.
    #[error(
        "{at} has a surface with {component_count} components turned inwards, which are reversed"
    )]
    Reversed {
        /// The geometry.
        at: Location,
        /// Number of components that were reversed.
        component_count: usize,
    },
    /// The surface of a mesh is replaced by its convex hull, or by the convex hulls of its components.
    #[error("{at} has a surface that is replaced by {}: {source}", hulls(*hull_count))]
    Hull {
        /// The geometry.
        at: Location,
        /// Number of convex hulls.
        hull_count: usize,
        /// Reason why the triangles do not make a surface.
        source: SurfaceError,
    },
    /// Property of the surface of a mesh that may be a mistake.
    #[error("{at}: {warning}")]
    Surface {
        /// The geometry.
        at: Location,
        /// Property of the surface.
        warning: SurfaceWarning,
    },
}

fn hulls(count: usize) -> String {
    match count {
        1 => "its convex hull".into(),
        _ => format!("the convex hulls of its {count} components"),
    }
}
