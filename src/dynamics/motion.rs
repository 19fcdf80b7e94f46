//! Kinds of motion: dynamic, fixed and kinematic.

use super::{BodyState, Inertia, Joint};
use std::fmt;
use std::sync::Arc;

/// Path of a kinematic body: pose and twist as a function of time (s).
pub type KinematicPath = dyn Fn(f64) -> BodyState + Send + Sync;

/// Kind of motion of a body.
#[derive(Clone)]
#[non_exhaustive]
pub enum Motion<T = f64> {
    /// Forces move the body.
    Dynamic {
        /// Mass and rotational inertia.
        inertia: Inertia<T>,
        /// Connection to the parent.
        joint: Box<Joint<T>>,
    },
    /// The body does not move.
    Fixed,
    /// The body moves along a path, whatever forces act on it. The path carries no derivatives.
    Kinematic(Arc<KinematicPath>),
}

impl<T> Motion<T> {
    /// Returns the mass and inertia of a dynamic body.
    pub(crate) fn inertia_mut(&mut self) -> Option<&mut Inertia<T>> {
        match self {
            Self::Dynamic { inertia, .. } => Some(inertia),
            Self::Fixed | Self::Kinematic(_) => None,
        }
    }

    /// Whether the body is kinematic.
    pub(crate) fn is_kinematic(&self) -> bool {
        match self {
            Self::Kinematic(_) => true,
            Self::Dynamic { .. } | Self::Fixed => false,
        }
    }
}

/// State on a path at a time (s). The rotation is orthonormalized to round-off. This is the only place that evaluates a path.
pub(super) fn state_on(path: &KinematicPath, time: f64) -> BodyState {
    let state = path(time);
    BodyState {
        pose: state.pose.orthonormalized(),
        ..state
    }
}

impl<T: fmt::Debug> fmt::Debug for Motion<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dynamic { inertia, joint } => {
                let mut parts = formatter.debug_struct("Dynamic");
                parts
                    .field("inertia", inertia)
                    .field("joint", joint)
                    .finish()
            }
            Self::Fixed => formatter.write_str("Fixed"),
            Self::Kinematic(_) => formatter.write_str("Kinematic"),
        }
    }
}
