//! The work of the descent to the boundary that runs in lanes: each job goes through a list of parts of A's surface, in a memory that
//! is shared, and writes another list behind it.

use super::box_slab::{BoxSlab, RelativePose};
use super::four_triangles::FourTriangles;
use super::slabs::{BoxesAndSlabs, FourSlabs};
use super::triangle_bvh::TriangleBvh;
use crate::bvh::{FourBoxes, FourCorners, WIDTH};
use crate::lanes::{InLanes, Lanes};
use nalgebra::Vector3;
use std::ops::Range;

/// What stays of a list of nodes of which some have children that are touched.
#[derive(Clone, Copy)]
pub(super) enum Keeping {
    Children,
    Nodes,
}

/// A node of B in A's frame, and which of its children are near A's surface (see [`RelativePose::posed`]).
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

/// Lists what a part of B's surface may touch of the nodes of A at these places of the memory, behind them; gives where that list
/// ends.
pub(super) struct FilterNodes<'d> {
    pub nodes: &'d [FourBoxes],
    pub box_slab: &'d BoxSlab,
    pub keeping: Keeping,
    pub memory: &'d mut [u32],
    pub places: Range<usize>,
}

impl InLanes for FilterNodes<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> usize {
        let box_slab = self.box_slab.in_lanes(lanes);
        let mut end = self.places.end;
        for place in self.places {
            let index = self.memory[place];
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

/// Lists which of four triangles of B the triangles of A at these places of the memory may cross, behind them: four times the
/// number of the latter, and which of the four. Gives where that list ends.
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
        for place in self.triangles {
            let index = self.memory[place];
            let (node, slot) = (index as usize / WIDTH, index as usize % WIDTH);
            let box_slab = BoxSlab::of_a(leaves.node(node), slot, self.margin);
            let crossed = four.crossed(lanes, &box_slab, &self.a.corners_of(index as usize));
            end += kept(&mut self.memory[end..], WIDTH as u32 * index, crossed);
        }
        end
    }
}

/// Lists the triangles, below the nodes of A at these places of the memory, that one of B may cross, behind them; gives where
/// that list ends.
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
        for place in self.nodes {
            let index = self.memory[place];
            let node = leaves.node(index as usize);
            let corners = &self.a.corners()[index as usize];
            let four = FourTriangles::of_a(node, corners, self.margin);
            let crossed = four.crossed(lanes, &self.box_slab, &self.corners);
            end += kept(&mut self.memory[end..], WIDTH as u32 * index, crossed);
        }
        end
    }
}

/// Writes the numbers from `first` on whose bits are set, and returns how many they are. There must be room for all four: each
/// is written, and kept by going on to the next place, because a processor cannot guess which bits are set.
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
