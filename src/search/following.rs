use super::Culling;
use super::scratch::{Exits, Scratch};
use crate::geometry::faces_in;
use crate::narrow_phase::{Cut, Encounter, PosedTet, RelativePair};
use crate::threads;

/// Pairs of tetrahedra that are looked at together, in one thread: some 20 µs of work.
const PIECE: usize = 64;

/// A walk over the contact surface.
pub(super) struct Walk<'w, 'a> {
    pub pair: &'w RelativePair<'a>,
    pub scratch: &'w mut Scratch,
}

impl RelativePair<'_> {
    /// Finds the cuts: from those where a component of the contact surface must show, to their neighbors across the
    /// faces that a polygon reaches, one frontier after the other. Returns the number of pairs looked at.
    ///
    /// A polygon's edge lies on a face of A or of B, and behind that face the neighbor has the same
    /// edge. In a special position, where the plane only touches a pair, or an edge lies on faces of
    /// both, what is next may be behind several faces; so a pair that is only touched is a step on the
    /// way too.
    pub(super) fn follow(&self, scratch: &mut Scratch) -> usize {
        let mut walk = Walk {
            pair: self,
            scratch,
        };
        if !walk.enter_at_seeds() {
            return self.cull(Culling::default(), &mut walk.scratch.cuts);
        }
        if walk.is_incomplete() {
            walk.enter_everywhere();
            walk.is_incomplete();
        }
        walk.scratch.visited.len()
    }

    /// Over which faces the surface may go on from a pair of tetrahedra; takes note of its cut.
    #[inline]
    fn exits(&self, tet_a: usize, tet_b: &PosedTet, cuts: &mut Vec<Cut>) -> Exits {
        let tet_a = self.tet_a(tet_a);
        let decisions = match self.encounter(tet_a, tet_b, true) {
            Encounter::Apart => return Exits::default(),
            Encounter::EqualFields => return Exits::UNKNOWN,
            Encounter::Met(decisions) => decisions,
        };
        let cut = self.cut(tet_a, tet_b, decisions);
        // The way to others may lead through tetrahedra without pressure.
        if cut.is_noted() && !tet_a.is_inert() {
            cuts.push(cut);
        }
        Exits {
            faces: cut.exits(),
            is_uncertain: cut.is_ill_conditioned(),
        }
    }
}

impl Walk<'_, '_> {
    /// Puts a pair of tetrahedra into the next frontier, unless it was in one.
    #[inline]
    pub fn enter(&mut self, tet_a: u32, tet_b: u32) {
        let key = u64::from(tet_a) << 32 | u64::from(tet_b);
        if self.scratch.visited.insert(key) {
            self.scratch.next_frontier.push([tet_a, tet_b]);
        }
    }

    /// Follows the surface from the pairs that were entered. Returns whether it met a place where it may
    /// go on unseen: where the fields are equal over a volume, or round-off decided.
    fn is_incomplete(&mut self) -> bool {
        let mut is_incomplete = false;
        while !self.scratch.next_frontier.is_empty() {
            let scratch = &mut *self.scratch;
            std::mem::swap(&mut scratch.frontier, &mut scratch.next_frontier);
            scratch.next_frontier.clear();
            for [_, tet_b] in &scratch.frontier {
                scratch.posed_tets.add(self.pair, *tet_b);
            }
            self.look_around();
            for index in 0..self.scratch.frontier.len() {
                is_incomplete |= self.scratch.exits[index].is_uncertain;
                self.expand(index);
            }
        }
        is_incomplete
    }

    /// Looks at all pairs of the frontier: takes note of their cuts and exits.
    fn look_around(&mut self) {
        let Scratch {
            posed_tets,
            frontier,
            exits,
            cuts,
            ..
        } = &mut *self.scratch;
        exits.clear();
        exits.resize(frontier.len(), Exits::default());
        let look = |pairs: &[[u32; 2]], exits: &mut [Exits], cuts: &mut Vec<Cut>| {
            for ([tet_a, tet_b], exits) in pairs.iter().zip(exits) {
                *exits = self
                    .pair
                    .exits(*tet_a as usize, posed_tets.get(*tet_b), cuts);
            }
        };
        threads::collect_pieces((frontier, exits), PIECE, look, cuts);
    }

    /// Enters the pairs over the faces that a pair of the frontier reaches.
    #[inline]
    fn expand(&mut self, index: usize) {
        let ([tet_a, tet_b], exits) = (self.scratch.frontier[index], self.scratch.exits[index]);
        let (mesh_a, shape_b) = (self.pair.shape_a.field().mesh(), self.pair.shape_b);
        for face in faces_in(exits.faces) {
            if face < 4 {
                if let Some(next) = mesh_a.neighbour(tet_a as usize, face) {
                    self.enter(next as u32, tet_b);
                }
            } else if let Some(next) = shape_b.neighbour(tet_b as usize, face - 4) {
                self.enter(tet_a, next as u32);
            }
        }
    }
}
