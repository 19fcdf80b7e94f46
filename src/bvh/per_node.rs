use super::four_boxes::WIDTH;
use super::tree::Bvh;

/// One value for each node of a [`Bvh`].
#[derive(Debug, Clone)]
pub(crate) struct PerNode<V>(Vec<Vec<V>>);

impl<V> PerNode<V> {
    /// Computes the values. The arguments of `value` are the items below a node, and the number of
    /// items below each of its children. The last child may have fewer items.
    pub fn of<K: Copy>(bvh: &Bvh<K>, value: impl Fn(&[K], usize) -> V) -> Self {
        let depth = bvh.levels().len() as u32;
        let level = |level: u32| {
            let below_child = WIDTH.pow(depth - 1 - level);
            let nodes = bvh.items().chunks(WIDTH * below_child);
            nodes.map(|items| value(items, below_child)).collect()
        };
        Self((0..depth).map(level).collect())
    }

    /// Returns the values of the nodes of a level. The root is level 0.
    #[inline]
    pub fn level(&self, level: usize) -> &[V] {
        &self.0[level]
    }
}
