/// Reasons why the wrenches of a contact have no derivative at a pose, or why the pose cannot be distinguished from such a pose. The
/// derivatives are then the mean of both sides, or the derivatives about one generic direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct Kinks {
    /// Faces coincide or touch within 2.5e-10 of the bodies' size with friction or dissipation, and within 2e-12 of it in elastic contact.
    pub are_flush: bool,
    /// Surfaces separate so fast somewhere that the pressure is clamped at 0. The clamped part has zero derivatives.
    pub are_clamped: bool,
    /// The pressures of both bodies are equal over a volume somewhere. The volume contains no surface of equal pressure, and the wrench is
    /// different on either side of the pose.
    pub are_equal: bool,
}

impl Kinks {
    /// Returns whether there is any kink.
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
