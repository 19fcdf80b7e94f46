use super::four_boxes::{FourBoxes, FourCorners, WIDTH, side_by_side};
use crate::geometry::Aabb;
use crate::lanes::{self, InLanes, Lanes};
use nalgebra::Vector3;

/// Capacity of the traversal stack: three nodes for each of the 16 levels above 2³² items, and one.
const MAX_WAITING: usize = 3 * 16 + 1;

/// A bounding-volume hierarchy without pointers. All items have the same depth. All nodes are full
/// except the last node of each level. So child k of node i is node 4i + k of the next level. On
/// the last level, it is item 4i + k.
#[derive(Debug, Clone)]
pub(crate) struct Bvh<K> {
    /// Boxes of the children of each node, level by level from the root.
    levels: Vec<Vec<FourBoxes>>,
    /// Keys of the items, in the order of the tree.
    items: Vec<K>,
    bounds: Aabb,
}

/// A node of a [`Bvh`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Node {
    /// Depth of the node: 0 for the root.
    pub level: usize,
    /// Index of the node on its level.
    pub index: usize,
}

/// A test that decides which children of a node a traversal enters.
pub(crate) trait BoxTest {
    /// Returns the children to enter, one bit each. The bits of missing children must be zero.
    fn children<L: Lanes>(&self, lanes: L, boxes: &FourBoxes) -> u32;

    /// Returns the items to visit in a node of the last level, one bit each.
    #[inline(always)]
    fn items<L: Lanes>(&self, lanes: L, boxes: &FourBoxes, _leaf: usize) -> u32 {
        self.children(lanes, boxes)
    }
}

/// An item to be sorted into the tree.
struct Item<K> {
    key: K,
    /// Sum of the corners (m).
    position: Vector3<f64>,
    bounds: Aabb,
}

impl Node {
    /// The root.
    pub const ROOT: Self = Self { level: 0, index: 0 };
}

impl<K: Copy> Bvh<K> {
    /// Builds the tree of items, each with a key and corners (m), in O(n log n).
    pub fn new<const N: usize>(items: impl Iterator<Item = (K, [Vector3<f64>; N])>) -> Self {
        let item = |(key, corners): (K, [Vector3<f64>; N])| Item {
            key,
            position: corners.iter().sum(),
            bounds: Aabb::around(&corners),
        };
        let mut items: Vec<Item<K>> = items.map(item).collect();
        median_split(&mut items);
        let mut boxes: Vec<Aabb> = items.iter().map(|item| item.bounds).collect();
        let mut levels = Vec::new();
        while levels.is_empty() || boxes.len() > 1 {
            let level: Vec<_> = boxes.chunks(WIDTH).map(FourBoxes::of).collect();
            boxes = level.iter().map(FourBoxes::union).collect();
            levels.push(level);
        }
        levels.reverse();
        Self {
            levels,
            items: items.iter().map(|item| item.key).collect(),
            bounds: boxes.first().copied().unwrap_or(Aabb::around([])),
        }
    }

    /// Returns the boxes of the children of each node, level by level from the root.
    pub fn levels(&self) -> &[Vec<FourBoxes>] {
        &self.levels
    }

    /// Returns the keys of the items. The items of node i of the last level begin at index 4i.
    pub fn items(&self) -> &[K] {
        &self.items
    }

    /// Returns the box around all items.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Returns the corners of the items of each node of the last level. `corners` returns the
    /// corners of an item for its key.
    pub fn corners<const N: usize>(
        &self,
        corners: impl Fn(K) -> [Vector3<f64>; N],
    ) -> Vec<FourCorners<N>> {
        let of_items: Vec<_> = self.items.iter().map(|&key| corners(key)).collect();
        of_items.chunks(WIDTH).map(side_by_side).collect()
    }

    /// Returns the children of a node. There are no child nodes on the last level.
    #[inline]
    pub fn child_nodes(&self, Node { level, index }: Node) -> impl Iterator<Item = Node> {
        let next = level + 1;
        let count = self.levels.get(next).map_or(0, Vec::len);
        let children = WIDTH * index..(WIDTH * (index + 1)).min(count);
        children.map(move |index| Node { level: next, index })
    }

    /// Returns the keys of the items of a node of the last level. Nodes of other levels have no
    /// items.
    #[inline]
    pub fn leaf_items(&self, Node { level, index }: Node) -> &[K] {
        if level + 1 < self.levels.len() {
            return &[];
        }
        let first = WIDTH * index;
        &self.items[first..(first + WIDTH).min(self.items.len())]
    }

    /// Visits the keys of the items that pass a test, in the order of the tree.
    pub fn traverse(&self, test: impl BoxTest, visit: impl FnMut(K)) {
        lanes::run(Traversal {
            bvh: self,
            test,
            visit,
        });
    }

    /// Visits items near a point, beginning with the nearest nodes. `visit` returns a squared
    /// distance (m²). Items farther away than that distance need not be visited.
    pub fn visit_outwards(&self, point: &Vector3<f64>, visit: impl FnMut(K) -> f64) {
        self.visit_ascending(|aabb| aabb.squared_distance_to(point), visit);
    }

    /// Visits items approximately in ascending order of a lower bound, which `bound` computes for a
    /// box. `visit` returns a limit. Items with a larger bound need not be visited.
    pub fn visit_ascending(&self, bound: impl Fn(&Aabb) -> f64, mut visit: impl FnMut(K) -> f64) {
        self.ascend(Node::ROOT, &bound, f64::INFINITY, &mut visit);
    }

    /// Visits the children of a node in ascending order of their bounds. Returns the last limit.
    fn ascend(
        &self,
        Node { level, index }: Node,
        bound: &impl Fn(&Aabb) -> f64,
        mut limit: f64,
        visit: &mut impl FnMut(K) -> f64,
    ) -> f64 {
        let Some(boxes) = self.levels[level].get(index) else {
            return limit;
        };
        let mut children =
            [0, 1, 2, 3].map(|slot| (bound(&boxes.aabb(slot)), WIDTH * index + slot));
        children.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (lower_bound, index) in children {
            if lower_bound > limit {
                break;
            }
            let level = level + 1;
            if level < self.levels.len() {
                limit = self.ascend(Node { level, index }, bound, limit, visit);
            } else if let Some(&key) = self.items.get(index) {
                limit = visit(key);
            }
        }
        limit
    }
}

/// A traversal from the root, with a stack of nodes.
struct Traversal<'t, K, T, V> {
    bvh: &'t Bvh<K>,
    test: T,
    visit: V,
}

impl<K: Copy, T: BoxTest, V: FnMut(K)> InLanes for Traversal<'_, K, T, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let Bvh { levels, items, .. } = self.bvh;
        if items.is_empty() {
            return;
        }
        let last = levels.len() as u32 - 1;
        let mut waiting = [[0; 2]; MAX_WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let [level, index] = waiting[count];
            let first = WIDTH as u32 * index;
            let boxes = &levels[level as usize][index as usize];
            if level < last {
                let mut entered = self.test.children(lanes, boxes);
                while entered != 0 {
                    // Push the last child first, so that the first child is visited next.
                    let slot = entered.ilog2();
                    entered &= !(1 << slot);
                    waiting[count] = [level + 1, first + slot];
                    count += 1;
                }
            } else {
                let mut reached = self.test.items(lanes, boxes, index as usize);
                while reached != 0 {
                    let slot = reached.trailing_zeros();
                    reached &= reached - 1;
                    // A node with fewer than four items repeats the last item, so a bit may be set
                    // beyond the end.
                    if let Some(&key) = items.get((first + slot) as usize) {
                        (self.visit)(key);
                    }
                }
            }
        }
    }
}

/// Sorts items so that the items of each node are contiguous. Splits at the median along the
/// longest edge of the box around their positions, until the items fit into one node of the last
/// level.
fn median_split<K>(items: &mut [Item<K>]) {
    if items.len() <= WIDTH {
        return;
    }
    // Number of items in a full child of the smallest node that holds all items. The split fills
    // the children of its first half.
    let mut full = WIDTH;
    while full * WIDTH < items.len() {
        full *= WIDTH;
    }
    let middle = items.len().div_ceil(full).div_ceil(2) * full;
    let around = Aabb::around(items.iter().map(|item| &item.position));
    let axis = around.half_extents().imax();
    items.select_nth_unstable_by(middle, |a, b| a.position[axis].total_cmp(&b.position[axis]));
    let (first, second) = items.split_at_mut(middle);
    median_split(first);
    median_split(second);
}
