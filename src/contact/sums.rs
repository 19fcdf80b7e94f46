//! Sums over a contact surface.

use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// A sum over a contact surface. Pieces of the surface are summed separately and merged in order.
pub(super) trait PartialSum: Send {
    /// Creates an empty sum.
    fn empty() -> Self;

    /// Adds the next piece.
    fn merge(&mut self, next: Self);
}

impl<U: Send> PartialSum for Vec<U> {
    fn empty() -> Self {
        Vec::new()
    }

    fn merge(&mut self, mut next: Self) {
        if self.is_empty() {
            *self = next;
        } else {
            self.append(&mut next);
        }
    }
}

impl PartialSum for f64 {
    fn empty() -> Self {
        0.0
    }

    fn merge(&mut self, next: Self) {
        *self += next;
    }
}

impl PartialSum for usize {
    fn empty() -> Self {
        0
    }

    fn merge(&mut self, next: Self) {
        *self += next;
    }
}

impl<T: Scalar> PartialSum for Wrench<T> {
    fn empty() -> Self {
        Self::zero()
    }

    fn merge(&mut self, next: Self) {
        *self += next;
    }
}

impl PartialSum for () {
    fn empty() -> Self {}

    fn merge(&mut self, (): Self) {}
}

impl<P: PartialSum, Q: PartialSum> PartialSum for (P, Q) {
    fn empty() -> Self {
        (P::empty(), Q::empty())
    }

    fn merge(&mut self, next: Self) {
        self.0.merge(next.0);
        self.1.merge(next.1);
    }
}
