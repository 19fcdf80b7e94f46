use super::GenericPairs;
use super::neighbor_pairs::NeighborPairs;
use super::normals::Normals;
use super::scratch::{PosedTets, Scratch};
use crate::contact_shape::{PartnerShape, RigidShape, Shape};
use crate::lanes;
use crate::narrow_phase::{Cut, CutOctets, Octet, PairClass, PosedTet, ReachedFaces, RelativePair};
use crate::parallel;
use crate::seeds::Seeds;
use std::ops::Range;

/// Number of octets that a thread cuts together: about 20 µs of work.
const PIECE: usize = 32;

/// A search of all pairs is faster than searches around each ill-conditioned pair, if there are more of them than this number and more
/// than one in [`PAIRS_PER_ILL_CONDITIONED`] pairs.
const MAX_ILL_CONDITIONED: usize = 8;
const PAIRS_PER_ILL_CONDITIONED: usize = 512;

/// Fewer octets than this number are not spilled: it would save nothing, and near coincidences would need a second search.
const FEW: usize = 64;

/// Receives generic pairs before their memory is used again.
pub(crate) type Spill<'s> = dyn FnMut(GenericPairs) + 's;

/// Choice of seeds, such that every component of the contact surface contains one.
enum Route<'a> {
    /// At the boundaries of components, and for closed ones where the fields of both bodies require.
    BetweenFields {
        shape_b: &'a Shape,
        seeds: [&'a Seeds; 2],
    },
    /// At the boundaries of components. A closed component is a component of B's surface, inside A.
    OverRigid(&'a RigidShape),
}

/// A walk over the contact surface.
pub(super) struct Walk<'w, 'a> {
    pub pair: &'w RelativePair<'a>,
    pub scratch: &'w mut Scratch,
    spill: Option<&'w mut Spill<'w>>,
    /// Number of ill-conditioned pairs so far: rounding errors decide over which faces the surface continues.
    ill_conditioned_count: usize,
    /// Normals of the generic polygons found so far, including spilled polygons; `None` if they are not needed.
    pub normals: Option<Normals>,
}

impl RelativePair<'_> {
    /// Finds the cuts by a walk from the seeds to the neighbors across the faces that a polygon reaches, eight pairs at a time. Returns
    /// the number of pairs tested.
    ///
    /// An edge of a polygon lies on a face of A or of B, and the neighbor behind that face has the same edge. In a special
    /// position, where the plane only touches a pair or an edge lies on faces of both bodies, the next polygon may be behind several
    /// faces. The walk therefore also continues from pairs that are only touched.
    ///
    /// Octets that are finished go to `spill`, if there is one, and their memory is reused.
    pub(super) fn follow<'w>(
        &'w self,
        scratch: &'w mut Scratch,
        spill: Option<&'w mut Spill<'w>>,
    ) -> usize {
        let mut walk = Walk {
            pair: self,
            scratch,
            spill,
            ill_conditioned_count: 0,
            normals: None,
        };
        let Some(route) = self.route() else {
            walk.cut_all_overlapping();
            return walk.scratch.octets.pair_count();
        };
        if !walk.follow_route(&route) {
            walk.enter_everywhere();
            walk.follow_entered();
        }
        walk.scratch.octets.pair_count()
    }

    /// Returns the choice of seeds. Returns `None` if a walk could miss something, because a field is not positive inside, and for
    /// half-spaces, which have no mesh.
    fn route(&self) -> Option<Route<'_>> {
        match self.shape_b {
            PartnerShape::Compliant(shape_b) => Some(Route::BetweenFields {
                shape_b,
                seeds: [self.shape_a.seeds()?, shape_b.seeds()?],
            }),
            // A component of B's surface may begin in tetrahedra of A without pressure, which have no seeds.
            PartnerShape::Rigid(shape_b) => {
                let is_positive_inside = self.shape_a.followed().is_ok();
                is_positive_inside.then_some(Route::OverRigid(shape_b))
            }
            PartnerShape::HalfSpace(_) => None,
        }
    }

    /// Cuts the pairs of octets: generic ones several at a time, special ones one by one. Appends the cuts of special pairs.
    fn cut_octets(&self, posed_tets: &PosedTets, octets: &mut [Octet], cuts: &mut Vec<Cut>) {
        let posed = |tet_b: u32| posed_tets.get(tet_b);
        lanes::run(CutOctets {
            pair: self,
            posed,
            octets: &mut *octets,
        });
        for octet in octets {
            for index in 0..octet.tets().len() {
                let [tet_a, tet_b] = octet.tets()[index];
                let posed_b = posed(tet_b);
                octet.reached[index] = if octet.is_special(index) {
                    self.reached(tet_a as usize, posed_b, cuts)
                } else {
                    ReachedFaces {
                        faces: octet.reached_faces(index, posed_b),
                        ..ReachedFaces::default()
                    }
                };
            }
        }
    }

    /// Returns the faces over which the surface may continue from a pair of tetrahedra. Appends the cut of the pair, if it is noted.
    #[inline]
    fn reached(&self, tet_a: usize, tet_b: &PosedTet, cuts: &mut Vec<Cut>) -> ReachedFaces {
        let tet_a = self.tet_a(tet_a);
        let topology = match self.classify(tet_a, tet_b, true) {
            PairClass::Disjoint => return ReachedFaces::default(),
            PairClass::EqualFields => return ReachedFaces::EQUAL_FIELDS,
            PairClass::Intersecting(topology) => topology,
        };
        let cut = self.cut(tet_a, tet_b, topology);
        // The walk may pass through tetrahedra without pressure and, at widened tolerances, past the ends of thin ones. Neither
        // counts as contact.
        if cut.is_noted() && !tet_a.is_inert() && self.may_touch(tet_a.index, tet_b) {
            cuts.push(cut);
        }
        ReachedFaces {
            faces: cut.reached(),
            is_ill_conditioned: cut.is_ill_conditioned(),
            is_equal: false,
        }
    }
}

impl Walk<'_, '_> {
    /// Queues a pair of tetrahedra, unless it was queued before.
    #[inline]
    pub fn enter(&mut self, tet_a: u32, tet_b: u32) {
        self.enter_all(&[[tet_a, tet_b]]);
    }

    /// Queues the pairs that were not queued before.
    pub fn enter_all(&mut self, pairs: &[[u32; 2]]) {
        let Scratch {
            posed_tets,
            visited,
            octets,
            ..
        } = &mut *self.scratch;
        for &[_, tet_b] in visited.append(octets.pairs(), pairs) {
            posed_tets.add(self.pair, tet_b);
        }
    }

    /// Queues a pair without a test for duplicates.
    fn add(&mut self, tets: [u32; 2]) {
        self.scratch.posed_tets.add(self.pair, tets[1]);
        self.scratch.octets.pairs().push(tets);
    }

    /// Cuts all pairs of tetrahedra that may touch.
    fn cut_all_overlapping(&mut self) {
        let pair = self.pair;
        pair.visit_overlapping(|tet_a, tet_b| {
            self.add([tet_a as u32, tet_b.index as u32]);
        });
        self.cut_queued(|_, _| {});
    }

    /// Cuts the queued pairs, and those that `enqueue` adds for each octet.
    fn cut_queued(&mut self, enqueue: impl Fn(&mut Self, usize)) {
        while let Some(octets) = self.cut_next() {
            for index in octets {
                self.take_note(index);
                enqueue(self, index);
            }
            self.spill();
        }
    }

    /// Passes octets that were cut to the spill, if there are many, and reuses their memory.
    fn spill(&mut self) {
        let Scratch {
            octets, posed_tets, ..
        } = &mut *self.scratch;
        if let Some(spill) = &mut self.spill
            && octets.in_use().len() >= FEW
        {
            spill(GenericPairs::new(octets.in_use(), posed_tets));
            octets.forget();
        }
    }

    /// Follows the surface from its seeds. Returns whether all of it is found.
    fn follow_route(&mut self, route: &Route) -> bool {
        match *route {
            Route::OverRigid(shape_b) => {
                self.enter_at_boundary(shape_b.triangle_bvh());
                self.enter_at_components(shape_b);
                self.follow_on()
            }
            Route::BetweenFields { shape_b, seeds } => {
                self.enter_at_boundary(shape_b.triangle_bvh());
                if let [Some(paths_a), Some(paths_b)] = seeds.map(|seeds| seeds.peak_paths.as_ref())
                {
                    self.enter_at_peak_paths(shape_b, [paths_a, paths_b]);
                    return self.follow_on();
                }
                self.normals = Some(Normals::default());
                self.follow_on() && {
                    self.enter_at_extremal_pairs(shape_b, seeds);
                    self.follow_on()
                }
            }
        }
    }

    /// Follows the surface from the queued pairs, and from all pairs around ill-conditioned ones. Returns whether all of it is found: not if
    /// the fields are equal over a volume, nor if there are too many ill-conditioned pairs.
    fn follow_on(&mut self) -> bool {
        loop {
            let has_equal = !self.follow_entered();
            if has_equal
                || self.ill_conditioned_count
                    > MAX_ILL_CONDITIONED
                        .max(self.scratch.octets.pair_count() / PAIRS_PER_ILL_CONDITIONED)
            {
                return false;
            }
            let mut ill_conditioned = std::mem::take(&mut self.scratch.ill_conditioned);
            for [tet_a, tet_b] in ill_conditioned.drain(..) {
                self.enter_around(tet_a, tet_b);
            }
            self.scratch.ill_conditioned = ill_conditioned;
            if self.scratch.octets.are_all_done() {
                return true;
            }
        }
    }

    /// Follows the surface from the queued pairs and records the ill-conditioned ones. Returns whether there were no fields that are
    /// equal over a volume.
    fn follow_entered(&mut self) -> bool {
        let equal_before = self.scratch.equal.len();
        self.cut_queued(|walk, index| {
            let across = NeighborPairs::faces_of(walk.scratch.octets.at(index), walk.pair);
            walk.enter_all(across.pairs());
        });
        self.scratch.equal.len() == equal_before
    }

    /// Cuts the next pairs (see [`Octets::next`](super::scratch::Octets::next)). Returns the indices of their octets, or `None` if the
    /// queue is empty.
    fn cut_next(&mut self) -> Option<Range<usize>> {
        let Scratch {
            posed_tets,
            octets,
            cuts,
            ..
        } = &mut *self.scratch;
        let (range, octets) = octets.next()?;
        let cut = |octets: &mut [Octet], cuts: &mut Vec<Cut>| {
            self.pair.cut_octets(posed_tets, octets, cuts);
        };
        parallel::collect_pieces(octets, PIECE, cut, cuts);
        Some(range)
    }

    /// Records the normals of an octet, and its pairs with equal fields or ill-conditioned decisions.
    fn take_note(&mut self, index: usize) {
        let octet = self.scratch.octets.at(index);
        if let Some(normals) = &mut self.normals {
            normals.add_octet(octet);
        }
        for (reached, &tets) in octet.reached.iter().zip(octet.tets()) {
            if reached.is_equal {
                self.scratch.equal.push(tets.map(|tet| tet as usize));
            }
            if reached.is_ill_conditioned {
                self.ill_conditioned_count += 1;
                self.scratch.ill_conditioned.push(tets);
            }
        }
    }
}
