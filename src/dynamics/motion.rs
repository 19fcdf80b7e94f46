//! How bodies come by their motion.

use super::{BodyState, Inertia};
use std::fmt;
use std::sync::Arc;

/// A path through time: pose and twist at a time (s).
pub type KinematicPath = dyn Fn(f64) -> BodyState + Send + Sync;

/// How a body comes by its motion.
#[derive(Clone)]
#[non_exhaustive]
pub enum Motion<T = f64> {
    /// By forces.
    Dynamic(Inertia<T>),
    /// Not at all.
    Fixed,
    /// Along a given path, whatever pushes it. The path carries no derivatives.
    Kinematic(Arc<KinematicPath>),
}

impl<T> Motion<T> {
    /// Whether the body follows a path.
    pub(crate) fn is_kinematic(&self) -> bool {
        match self {
            Self::Kinematic(_) => true,
            Self::Dynamic(_) | Self::Fixed => false,
        }
    }
}

/// The state a path gives at a time (s), its rotation orthonormal to round-off: the only place that
/// asks a path.
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
            Self::Dynamic(inertia) => formatter.debug_tuple("Dynamic").field(inertia).finish(),
            Self::Fixed => formatter.write_str("Fixed"),
            Self::Kinematic(_) => formatter.write_str("Kinematic"),
        }
    }
}
