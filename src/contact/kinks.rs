/// Whether the wrenches of a contact have no derivative, or are so near to such a place that it makes no difference: what is given
/// then is the mean of both sides, or the derivative about one generic direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct Kinks {
    /// Faces coincide, or touch, to 2.5e-10 of the bodies' size with friction or dissipation, and to 2e-12 of it in elastic contact.
    pub are_flush: bool,
    /// Somewhere surfaces part so fast that the pressure is clamped at 0: beyond that place, derivatives are 0.
    pub are_clamped: bool,
    /// Somewhere the pressures of both bodies are equal over a volume: there is no surface of equal pressure in it, and the wrench
    /// differs from one side of such a pose to the other.
    pub are_equal: bool,
}

impl Kinks {
    /// Whether there is any.
    #[must_use]
    pub fn is_any(self) -> bool {
        self.are_flush || self.are_clamped || self.are_equal
    }

    pub(super) fn merge(&mut self, other: Self) {
        self.are_flush |= other.are_flush;
        self.are_clamped |= other.are_clamped;
        self.are_equal |= other.are_equal;
    }
}
