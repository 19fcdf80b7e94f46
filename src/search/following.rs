use super::scratch::{Scratch, WayOn};
use super::{Culling, Found, PartialSum};
use crate::broad_phase::Shape;
use crate::narrow_phase::{Encounter, Meeting};
use crate::narrow_phase::{PosedTet, RelativePair};
use crate::threads;

/// Pairs of tetrahedra that are summed by themselves, in one thread: some 20 µs of work in `f64`.
const PIECE: usize = 64;

/// A walk over the contact surface.
pub(super) struct Walk<'w, 'a> {
    pub shadow: &'w RelativePair<'a>,
    pub scratch: &'w mut Scratch,
}

impl RelativePair<'_> {
    /// Adds up the contact polygons: from those where a component of the contact surface must show, to
    /// their neighbours across the faces that a polygon reaches, wave by wave.
    ///
    /// A polygon's edge lies on a face of A or of B, and behind that face the neighbour has the same
    /// edge. In a special position, where the plane only touches a pair, or an edge lies on faces of
    /// both, what is next may be behind several faces; so a pair that is only touched is a step on the
    /// way too.
    pub(super) fn follow<S: PartialSum>(&self, add: impl Fn(&mut S, &Meeting) + Sync) -> Found<S> {
        let [Some(seeds_a), Some(seeds_b)] = self.shapes.map(Shape::seeds) else {
            return self.cull(Culling::default(), add);
        };
        Scratch::lent(|scratch| {
            let mut walk = Walk {
                shadow: self,
                scratch,
            };
            let mut sum = S::empty();
            walk.enter_at_seeds(seeds_a, seeds_b);
            if walk.loses_track(&mut sum, &add) {
                walk.enter_everywhere();
                walk.loses_track(&mut sum, &add);
            }
            let candidates = walk.scratch.visited.len();
            Found { sum, candidates }
        })
    }

    /// Whether a pair of tetrahedra is part of the surface, and where it goes on.
    #[inline]
    fn way_on(&self, tet_a: usize, tet_b: &PosedTet, visit: impl FnOnce(&Meeting)) -> WayOn {
        let tet_a = self.tet_a(tet_a);
        let crossing = match self.encounter(tet_a, tet_b, true) {
            Encounter::Apart => return WayOn::default(),
            Encounter::EqualFields => return WayOn::UNKNOWN,
            Encounter::Crossing(crossing) => crossing,
        };
        let meeting = self.meeting(tet_a, tet_b, crossing);
        if meeting.is_polygon() {
            visit(&meeting);
        }
        WayOn {
            faces: meeting.reached_faces(),
            is_uncertain: meeting.is_doubtful(),
        }
    }
}

impl Walk<'_, '_> {
    /// Puts a pair of tetrahedra into the next wave, unless it was in one.
    #[inline]
    pub fn enter(&mut self, tet_a: u32, tet_b: u32) {
        let key = u64::from(tet_a) << 32 | u64::from(tet_b);
        if self.scratch.visited.insert(key) {
            self.scratch.next_wave.push([tet_a, tet_b]);
        }
    }

    /// Follows the surface from the pairs that were entered. Returns whether it met a place where it may
    /// go on unseen: where the fields are equal over a volume, or round-off decided.
    fn loses_track<S: PartialSum>(
        &mut self,
        sum: &mut S,
        add: &(impl Fn(&mut S, &Meeting) + Sync),
    ) -> bool {
        let mut loses_track = false;
        while !self.scratch.next_wave.is_empty() {
            let scratch = &mut *self.scratch;
            std::mem::swap(&mut scratch.wave, &mut scratch.next_wave);
            scratch.next_wave.clear();
            for [_, tet_b] in &scratch.wave {
                scratch.posed_tets.add(self.shadow, *tet_b);
            }
            self.look_around(sum, add);
            for index in 0..self.scratch.wave.len() {
                loses_track |= self.scratch.ways_on[index].is_uncertain;
                self.go_on(index);
            }
        }
        loses_track
    }

    /// Looks at all pairs of the wave: adds up the polygons and notes the ways on.
    fn look_around<S: PartialSum>(
        &mut self,
        sum: &mut S,
        add: &(impl Fn(&mut S, &Meeting) + Sync),
    ) {
        let Scratch {
            posed_tets,
            wave,
            ways_on,
            ..
        } = &mut *self.scratch;
        ways_on.clear();
        ways_on.resize(wave.len(), WayOn::default());
        let look = |(pairs, ways_on): (&[[u32; 2]], &mut [WayOn])| {
            let mut piece = S::empty();
            for ([tet_a, tet_b], way_on) in pairs.iter().zip(ways_on) {
                let visit = |meeting: &Meeting| add(&mut piece, meeting);
                *way_on = self
                    .shadow
                    .way_on(*tet_a as usize, posed_tets.get(*tet_b), visit);
            }
            piece
        };
        threads::for_pieces((wave, ways_on), PIECE, look, |piece| sum.merge(piece));
    }

    /// Enters the pairs over the faces that a pair of the wave reaches.
    #[inline]
    fn go_on(&mut self, index: usize) {
        let ([tet_a, tet_b], faces) = (self.scratch.wave[index], self.scratch.ways_on[index].faces);
        let [mesh_a, mesh_b] = self.shadow.shapes.map(|shape| shape.field().mesh());
        for face in faces_in(faces) {
            if face < 4 {
                if let Some(next) = mesh_a.neighbour(tet_a as usize, face) {
                    self.enter(next as u32, tet_b);
                }
            } else if let Some(next) = mesh_b.neighbour(tet_b as usize, face - 4) {
                self.enter(tet_a, next as u32);
            }
        }
    }
}

/// The places of the bits that are set.
fn faces_in(mut bits: u8) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            place
        })
    })
}
