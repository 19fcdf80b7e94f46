//! SIMD kernels of the search for crossing triangles. Each kernel reads a list of nodes or
//! triangles of A in shared memory, and appends another list.

use super::box_slab::{BoxSlab, RelativePose};
use super::four_triangles::FourTriangles;
use super::slabs::{BoxesAndSlabs, FourSlabs};
use super::triangle_bvh::TriangleBvh;
use crate::bvh::{FourBoxes, FourCorners, WIDTH};
use crate::lanes::{InLanes, Lanes};
use nalgebra::Vector3;
use std::ops::Range;

/// Entries to keep in a list of nodes: the children that are touched, or the nodes that have such
/// children.
#[derive(Clone, Copy)]
pub(super) enum Keeping {
    Children,
    Nodes,
}

/// Kernel that transforms a node of B to A's frame, and selects its children near A's surface (see
/// [`RelativePose::posed`]).
pub(super) struct TransformNode<'d> {
    pub frame: &'d RelativePose,
    pub node: BoxesAndSlabs<'d>,
}

impl InLanes for TransformNode<'_> {
    type Output = (FourBoxes, FourSlabs, u32);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        self.frame.posed(lanes, self.node)
    }
}

/// Kernel that selects the nodes of A that a part of B's surface may touch. It reads the nodes at
/// `entries` of the memory and appends the selection. It returns the end of the new list.
pub(super) struct FilterNodes<'d> {
    pub nodes: &'d [FourBoxes],
    pub box_slab: &'d BoxSlab,
    pub keeping: Keeping,
    pub memory: &'d mut [u32],
    pub entries: Range<usize>,
}

impl InLanes for FilterNodes<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> usize {
        let box_slab = self.box_slab.in_lanes(lanes);
        let mut end = self.entries.end;
        for entry in self.entries {
            let index = self.memory[entry];
            let touched = box_slab.touched(lanes, &self.nodes[index as usize]);
            match self.keeping {
                Keeping::Children => {
                    end += kept(&mut self.memory[end..], WIDTH as u32 * index, touched);
                }
                Keeping::Nodes => {
                    self.memory[end] = index;
                    end += usize::from(touched != 0);
                }
            }
        }
        end
    }
}

/// Kernel that selects pairs that may cross of listed triangles of A and four triangles of B. It
/// appends one entry for each pair to the memory. An entry is four times the index in A, plus the
/// index among the four triangles of B. The kernel returns the end of the new list.
pub(super) struct CrossFour<'d> {
    pub frame: &'d RelativePose,
    pub slabs: &'d FourSlabs,
    pub corners_b: &'d FourCorners<3>,
    pub a: &'d TriangleBvh,
    pub margin: f64,
    pub memory: &'d mut [u32],
    pub triangles: Range<usize>,
}

impl InLanes for CrossFour<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> usize {
        let in_a = self.frame.triangles(lanes, self.corners_b);
        let four = FourTriangles::of_b(self.slabs, &in_a);
        let (leaves, mut end) = (self.a.leaves(), self.triangles.end);
        for entry in self.triangles {
            let index = self.memory[entry];
            let (node, slot) = (index as usize / WIDTH, index as usize % WIDTH);
            let box_slab = BoxSlab::of_a(leaves.node(node), slot, self.margin);
            let crossed = four.crossed(lanes, &box_slab, &self.a.corners_of(index as usize));
            end += kept(&mut self.memory[end..], WIDTH as u32 * index, crossed);
        }
        end
    }
}

/// Kernel that selects the triangles of A that one triangle of B may cross. The triangles are below
/// the nodes at `nodes` of the memory. The kernel appends the selection and returns the end of the
/// new list.
pub(super) struct CrossOne<'d> {
    pub box_slab: BoxSlab,
    pub corners: [Vector3<f64>; 3],
    pub a: &'d TriangleBvh,
    pub margin: f64,
    pub memory: &'d mut [u32],
    pub nodes: Range<usize>,
}

impl InLanes for CrossOne<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> usize {
        let (leaves, mut end) = (self.a.leaves(), self.nodes.end);
        for entry in self.nodes {
            let index = self.memory[entry];
            let node = leaves.node(index as usize);
            let corners = &self.a.corners()[index as usize];
            let four = FourTriangles::of_a(node, corners, self.margin);
            let crossed = four.crossed(lanes, &self.box_slab, &self.corners);
            end += kept(&mut self.memory[end..], WIDTH as u32 * index, crossed);
        }
        end
    }
}

/// Writes `first + k` for each set bit k, and returns their count. All four numbers are written, so
/// `memory` must have room for four. The compaction has no branches, because the bits are
/// unpredictable.
#[inline(always)]
fn kept(memory: &mut [u32], first: u32, bits: u32) -> usize {
    let Some(room) = memory.first_chunk_mut::<WIDTH>() else {
        return 0;
    };
    let mut count = 0;
    for slot in 0..WIDTH as u32 {
        room[count % WIDTH] = first + slot;
        count += (bits >> slot & 1) as usize;
    }
    count
}
