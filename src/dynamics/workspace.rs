use super::sweep::Sweep;
use crate::contact::ContactWrench;
use crate::spatial::{Twist, Wrench};

/// Scratch memory of an explicit step.
///
/// A rollout reuses one workspace, so that its steps allocate nothing once the buffers are large enough. Every step overwrites the
/// workspace, so no state depends on old contents.
#[derive(Debug, Clone)]
pub(super) struct Workspace<T> {
    /// Search for close pairs.
    pub sweep: Sweep,
    /// Contact wrenches on the two bodies of each close pair, in the order of the pairs.
    pub pair_wrenches: Vec<ContactWrench<T>>,
    /// Net contact wrench on each body.
    pub contact: Vec<Wrench<T>>,
    /// Wrench of contact, controls and other forces on each body, without gravity.
    pub all: Vec<Wrench<T>>,
    /// Twists of all bodies before the kick, for the stability check.
    pub before_kick: Vec<Twist>,
}

impl<T> Default for Workspace<T> {
    fn default() -> Self {
        Self {
            sweep: Sweep::default(),
            pair_wrenches: Vec::new(),
            contact: Vec::new(),
            all: Vec::new(),
            before_kick: Vec::new(),
        }
    }
}
