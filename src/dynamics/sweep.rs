use crate::geometry::Aabb;
use nalgebra::Vector3;

/// Sweep-and-prune search for overlapping boxes. The boxes are sorted along one axis, and each box is compared only with the boxes that
/// begin before it ends. The buffers are reused by later searches.
#[derive(Debug, Clone, Default)]
pub(super) struct Sweep {
    boxes: Vec<Aabb>,
    /// Indices of the boxes, sorted by their lower ends along the axis.
    order: Vec<usize>,
    pairs: Vec<(usize, usize)>,
}

impl Sweep {
    /// Pairs of the last search.
    pub fn pairs(&self) -> &[(usize, usize)] {
        &self.pairs
    }

    /// Results of `pair` for all overlapping boxes (i, j), i < j, sorted.
    pub fn overlapping(
        &mut self,
        boxes: impl Iterator<Item = Aabb>,
        pair: impl Fn(usize, usize) -> Option<(usize, usize)>,
    ) -> &[(usize, usize)] {
        self.boxes.clear();
        self.boxes.extend(boxes);
        let (boxes, axis) = (&self.boxes, widest_axis(&self.boxes));
        let begin = |index: usize| boxes[index].lower[axis];
        let end = |index: usize| boxes[index].upper[axis];
        self.order.clear();
        self.order.extend(0..boxes.len());
        self.order
            .sort_unstable_by(|&i, &j| begin(i).total_cmp(&begin(j)));
        self.pairs.clear();
        for (position, &i) in self.order.iter().enumerate() {
            let following = self.order[position + 1..].iter();
            let reached = following.take_while(|&&j| begin(j) <= end(i));
            let overlapping = reached.filter(|&&j| boxes[i].overlaps(&boxes[j]));
            self.pairs
                .extend(overlapping.filter_map(|&j| pair(i.min(j), i.max(j))));
        }
        self.pairs.sort_unstable();
        &self.pairs
    }
}

/// Axis along which the centers of the boxes have the largest variance.
fn widest_axis(boxes: &[Aabb]) -> usize {
    let count = boxes.len() as f64;
    let centers = || boxes.iter().map(Aabb::center);
    let mean = centers().sum::<Vector3<f64>>() / count;
    let squares = |center: Vector3<f64>| (center - mean).map(|x| x * x);
    centers().map(squares).sum::<Vector3<f64>>().imax()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Boxes on a coarse grid, so that many ends coincide.
    fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
        let number = |size| (0..size).prop_map(f64::from);
        let vector = move |size| [number(size), number(size), number(size)];
        let aabb = (vector(12), vector(4)).prop_map(|(lower, lengths)| {
            let lower = Vector3::from(lower);
            let upper = lower + Vector3::from(lengths);
            Aabb { lower, upper }
        });
        prop::collection::vec(aabb, 0..40)
    }

    proptest! {
        #[test]
        fn pairs_are_those_of_all_tests_of_two_boxes(first in boxes(), second in boxes()) {
            let may_touch = |i: usize, j: usize| i % 5 != j % 4;
            // The second search starts with the buffers that the first search has filled.
            let mut sweep = Sweep::default();
            for boxes in [first, second] {
                let all = (0..boxes.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
                let mut expected: Vec<_> = all
                    .filter(|&(i, j)| boxes[i].overlaps(&boxes[j]) && may_touch(i, j))
                    .collect();
                expected.sort_unstable();
                let pair = |i, j| may_touch(i, j).then_some((i, j));
                prop_assert_eq!(sweep.overlapping(boxes.into_iter(), pair), expected);
            }
        }
    }
}
