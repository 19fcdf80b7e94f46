/// Mode of automatic differentiation of a rollout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mode {
    /// Forward mode: a rollout on dual numbers. The cost grows with the number of parameter components, up to 96 of which share one
    /// rollout. It does not depend on the length of the outcome.
    Forward,
    /// Reverse mode: a sweep from the outcome back to the initial state, over stored or recomputed steps. The outcome must be one
    /// number. The cost does not depend on the number of parameters.
    Reverse,
}
