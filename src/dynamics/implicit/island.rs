//! Islands: groups of bodies that a step must solve together.

/// Dynamic bodies that may interact within a step, and the other bodies that they may touch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::dynamics) struct Island {
    /// Indices of the dynamic bodies in the world, in increasing order.
    pub dynamic: Vec<usize>,
    /// Indices of the other bodies that the dynamic bodies may touch, or that a joint or a force couples to them, in increasing order.
    pub neighbors: Vec<usize>,
}

impl Island {
    /// Index in the world of a participant. Participants are the dynamic bodies, then the neighbors.
    pub fn body(&self, participant: usize) -> usize {
        let count = self.dynamic.len();
        if participant < count {
            self.dynamic[participant]
        } else {
            self.neighbors[participant - count]
        }
    }

    /// World indices of the dynamic bodies, then of the neighbors.
    pub fn participants(&self) -> [&[usize]; 2] {
        [&self.dynamic, &self.neighbors]
    }

    /// Indices in the world of all participants.
    pub fn bodies(&self) -> impl Iterator<Item = usize> {
        self.dynamic.iter().chain(&self.neighbors).copied()
    }
}
