/// A value for each item, in their order, into room that is used again.
pub(super) fn mapped_into<I, O>(values: &mut Vec<O>, items: &[I], value: impl Fn(&I) -> O) {
    values.clear();
    values.extend(items.iter().map(value));
}
