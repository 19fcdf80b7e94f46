use crate::geometry::{Aabb, AffineField, Tetrahedron};
use crate::lanes::space::{dot, splat};
use crate::lanes::{self, InLanes, Lanes, Mask, Numbers, Quad};
use nalgebra::Vector3;
use std::array::from_fn;

/// Children of a node.
pub(super) const WIDTH: usize = 4;

/// Room for the nodes that wait while a descent is elsewhere: three of each of the levels over as many tetrahedra as a `u32`
/// counts, and one.
const WAITING: usize = 3 * 16 + 1;

/// Tetrahedra in a tree of four children to a node, without pointers, each with a key that says which it is. All leaves are
/// equally deep, and all nodes full, but for the last of each level: so child k of node i is node 4i + k of the level below,
/// or tetrahedron 4i + k.
#[derive(Debug, Clone)]
pub(crate) struct FlatTree {
    /// The nodes of each level above the leaves, from the root down.
    levels: Vec<Vec<FourBoxes>>,
    leaves: Vec<FourTets>,
    keys: Vec<u32>,
}

/// The boxes around four children, side by side: along each axis, the smallest coordinates (m) and the largest; inside out
/// where there is no child.
pub(super) type FourBoxes = [[Quad; 2]; 3];

/// Boxes without children.
pub(super) const NO_BOXES: FourBoxes = [[[f64::INFINITY; WIDTH], [f64::NEG_INFINITY; WIDTH]]; 3];

/// The corners (m) of four tetrahedra, by corner and coordinate; the last of them again where there are fewer.
type FourTets = [[Quad; 3]; 4];

impl FlatTree {
    /// O(n log n).
    pub fn new(tets: impl Iterator<Item = (u32, Tetrahedron)>) -> Self {
        let mut tets: Vec<(u32, Tetrahedron)> = tets.collect();
        arrange(&mut tets, &|(_, tet)| tet.corners.iter().sum());
        let (keys, tets): (Vec<u32>, Vec<Tetrahedron>) = tets.into_iter().unzip();
        let around_four =
            |four: &[Tetrahedron]| Aabb::around(four.iter().flat_map(|tet| &tet.corners));
        let mut boxes: Vec<Aabb> = tets.chunks(WIDTH).map(around_four).collect();
        let mut levels = Vec::new();
        while boxes.len() > 1 {
            levels.push(boxes.chunks(WIDTH).map(four_boxes).collect());
            let around =
                |part: &[Aabb]| part.iter().fold(Aabb::around([]), |all, it| all.union(it));
            boxes = boxes.chunks(WIDTH).map(around).collect();
        }
        levels.reverse();
        Self {
            levels,
            leaves: tets
                .chunks(WIDTH)
                .map(|four| side_by_side(four, |tet| &tet.corners))
                .collect(),
            keys,
        }
    }

    /// Visits the keys of the tetrahedra in which an affine field has values from `least` to `most`, of which `least` is finite:
    /// places without a child have no finite value.
    pub fn visit_between(&self, field: &AffineField, between: [f64; 2], visit: impl FnMut(usize)) {
        lanes::run(Descent {
            tree: self,
            field,
            between,
            visit,
        });
    }
}

/// A descent to the tetrahedra in which a field has some values.
struct Descent<'t, V> {
    tree: &'t FlatTree,
    field: &'t AffineField,
    between: [f64; 2],
    visit: V,
}

impl<V: FnMut(usize)> InLanes for Descent<'_, V> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(mut self, lanes: L) {
        let FlatTree {
            levels,
            leaves,
            keys,
        } = self.tree;
        if keys.is_empty() {
            return;
        }
        let field = FieldInLanes::of(lanes, self.field, self.between);
        let mut waiting = [[0; 2]; WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let [level, index] = waiting[count];
            let first = WIDTH as u32 * index;
            if let Some(nodes) = levels.get(level as usize) {
                let mut near = field.reaches_boxes(lanes, &nodes[index as usize]);
                while near != 0 {
                    // The last child first, so that the first is the next.
                    let slot = near.ilog2();
                    near &= !(1 << slot);
                    waiting[count] = [level + 1, first + slot];
                    count += 1;
                }
            } else {
                let reached = field.reaches_tets(lanes, &leaves[index as usize]);
                let keys = &keys[first as usize..];
                for (slot, &key) in keys.iter().take(WIDTH).enumerate() {
                    if reached >> slot & 1 != 0 {
                        (self.visit)(key as usize);
                    }
                }
            }
        }
    }
}

/// An affine field, and a range of its values.
struct FieldInLanes<N> {
    gradient: [N; 3],
    offset: N,
    /// Along which axes it rises.
    rises: [bool; 3],
    least: N,
    most: N,
}

impl<N: Numbers> FieldInLanes<N> {
    #[inline(always)]
    fn of<L: Lanes<Numbers = N>>(lanes: L, field: &AffineField, [least, most]: [f64; 2]) -> Self {
        let [x, y, z] = field.gradient.into();
        Self {
            gradient: splat(lanes, &[x, y, z]),
            offset: lanes.splat(field.offset),
            rises: [x >= 0.0, y >= 0.0, z >= 0.0],
            least: lanes.splat(least),
            most: lanes.splat(most),
        }
    }

    /// Which of four boxes have points with these values, as bits.
    #[inline(always)]
    fn reaches_boxes<L: Lanes<Numbers = N>>(&self, lanes: L, boxes: &FourBoxes) -> u32 {
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let (mut lowest, mut highest) = (self.offset, self.offset);
            for (axis, sides) in boxes.iter().enumerate() {
                // The sides where the field is lowest and highest.
                let rises = usize::from(self.rises[axis]);
                let [falling, rising] = [&sides[1 - rises], &sides[rises]];
                lowest = lowest + self.gradient[axis] * lanes.load_four(falling, first);
                highest = highest + self.gradient[axis] * lanes.load_four(rising, first);
            }
            bits |= self.are_reached(lowest, highest) << first;
        }
        of_four(bits)
    }

    /// Which of four tetrahedra have, as bits. Of 0 and −0 either may be the least or the greatest: they compare alike.
    #[inline(always)]
    fn reaches_tets<L: Lanes<Numbers = N>>(&self, lanes: L, tets: &FourTets) -> u32 {
        let mut bits = 0;
        for first in (0..WIDTH).step_by(L::COUNT) {
            let load = |quad: &Quad| lanes.load_four(quad, first);
            let corner = |[x, y, z]: &[Quad; 3]| [load(x), load(y), load(z)];
            let value = |tet_corner: usize| dot(self.gradient, corner(&tets[tet_corner]));
            let [a, b, c, d] = [value(0), value(1), value(2), value(3)];
            let lowest = a.min(b).min(c.min(d)) + self.offset;
            let highest = a.max(b).max(c.max(d)) + self.offset;
            bits |= self.are_reached(lowest, highest) << first;
        }
        of_four(bits)
    }

    /// Which ranges of values, from the lowest to the highest in each lane, have some of these values, as bits.
    #[inline(always)]
    fn are_reached(&self, lowest: N, highest: N) -> u32 {
        (lowest.is_at_most(self.most) & self.least.is_at_most(highest)).bits()
    }
}

/// The bits of four items: eight lanes have each twice.
#[inline(always)]
fn of_four(bits: u32) -> u32 {
    bits & ((1 << WIDTH) - 1)
}

/// Up to four boxes side by side.
fn four_boxes(boxes: &[Aabb]) -> FourBoxes {
    let mut four = NO_BOXES;
    for (slot, aabb) in boxes.iter().enumerate() {
        set_box(&mut four, slot, aabb);
    }
    four
}

/// Puts a box at one of four places.
pub(super) fn set_box(boxes: &mut FourBoxes, slot: usize, aabb: &Aabb) {
    for (axis, [lower, upper]) in boxes.iter_mut().enumerate() {
        (lower[slot], upper[slot]) = (aabb.lower[axis], aabb.upper[axis]);
    }
}

/// The corners of up to four parts, by corner and coordinate; those of the last one again where there are fewer.
pub(super) fn side_by_side<P, const N: usize>(
    parts: &[P],
    corners: impl Fn(&P) -> &[Vector3<f64>; N],
) -> [[Quad; 3]; N] {
    let last = parts.len() - 1;
    let number =
        |slot: usize, corner: usize, axis: usize| corners(&parts[slot.min(last)])[corner][axis];
    from_fn(|corner| from_fn(|axis| from_fn(|slot| number(slot, corner, axis))))
}

/// Orders parts so that those of each node of a tree follow one another: divided across the longest edge of the box around
/// their positions, until they fill one node of the last level. Positions may be centers or any multiple of these.
pub(super) fn arrange<P>(parts: &mut [P], position: &impl Fn(&P) -> Vector3<f64>) {
    if parts.len() <= WIDTH {
        return;
    }
    // Parts to a child of the node around all, of which the first half of the children is to be full.
    let mut full = WIDTH;
    while full * WIDTH < parts.len() {
        full *= WIDTH;
    }
    let middle = parts.len().div_ceil(full).div_ceil(2) * full;
    let positions: Vec<_> = parts.iter().map(position).collect();
    let axis = Aabb::around(&positions).half_extents().imax();
    parts.select_nth_unstable_by(middle, |a, b| {
        position(a)[axis].total_cmp(&position(b)[axis])
    });
    let (first, second) = parts.split_at_mut(middle);
    arrange(first, position);
    arrange(second, position);
}
