use super::sweep::Sweep;
use crate::contact::ContactWrench;
use crate::spatial::{Twist, Wrench};

/// Scratch memory of one step.
///
/// A rollout has one, so that its steps allocate nothing once all room is there. Every step fills it
/// anew: no state depends on what was in it.
#[derive(Debug, Clone)]
pub(super) struct Workspace<T> {
    /// The search for close pairs.
    pub sweep: Sweep,
    /// Contact wrenches on the two bodies of each close pair, in the order of the pairs.
    pub pair_wrenches: Vec<ContactWrench<T>>,
    /// Net contact wrench on each body.
    pub contact: Vec<Wrench<T>>,
    /// The wrench of all forces on each body.
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
