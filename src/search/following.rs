use super::GenericPairs;
use super::neighbor_pairs::NeighborPairs;
use super::normals::Normals;
use super::scratch::{PosedTets, Scratch};
use crate::contact_shape::{PartnerShape, RigidShape, Shape};
use crate::lanes;
use crate::narrow_phase::{Cut, CutOctets, Octet, PairClass, PosedTet, ReachedFaces, RelativePair};
use crate::seeds::Seeds;
use crate::threads;
use std::ops::Range;

/// Octets that are looked at together, in one thread: some 20 µs of work.
const PIECE: usize = 32;

/// Where round-off decides at more pairs than this, and at more than one in [`PAIRS_PER_ILL_CONDITIONED`], looking around each would take
/// longer than looking everywhere.
const MAX_ILL_CONDITIONED: usize = 8;
const PAIRS_PER_ILL_CONDITIONED: usize = 512;

/// Fewer octets than this are kept: to sum them apart saves nothing, and near coincidences need no second search then.
const FEW: usize = 64;

/// Receives generic pairs before their memory is used again.
pub(crate) type Spill<'s> = dyn FnMut(GenericPairs) + 's;

/// Where every component of a contact surface shows.
enum Route<'a> {
    /// At its boundary, or where one without a boundary must show in the fields of both bodies.
    BetweenFields {
        shape_b: &'a Shape,
        seeds: [&'a Seeds; 2],
    },
    /// At its boundary; one without a boundary is a connected part of B's surface, all inside A.
    OverRigid(&'a RigidShape),
}

/// A walk over the contact surface.
pub(super) struct Walk<'w, 'a> {
    pub pair: &'w RelativePair<'a>,
    pub scratch: &'w mut Scratch,
    spill: Option<&'w mut Spill<'w>>,
    /// Number of pairs so far from which the surface may go on over other faces than it seems.
    ill_conditioned_count: usize,
    /// Normals of the generic polygons found so far, including spilled polygons; `None` if they are not needed.
    pub normals: Option<Normals>,
}

impl RelativePair<'_> {
    /// Finds the cuts: from those where a component of the contact surface must show, to their neighbors across the
    /// faces that a polygon reaches, eight pairs at a time. Returns the number of pairs looked at.
    ///
    /// A polygon's edge lies on a face of A or of B, and behind that face the neighbor has the same
    /// edge. In a special position, where the plane only touches a pair, or an edge lies on faces of
    /// both, what is next may be behind several faces; so a pair that is only touched is a step on the
    /// way too.
    ///
    /// Octets that were done with are handed to `spill`, if there is one, and forgotten.
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
            walk.look_everywhere();
            return walk.scratch.octets.pair_count();
        };
        if !walk.follow_route(&route) {
            walk.enter_everywhere();
            walk.follow_entered();
        }
        walk.scratch.octets.pair_count()
    }

    /// None where following would not find all: where a field is not positive inside. A half-space has no mesh to follow.
    fn route(&self) -> Option<Route<'_>> {
        match self.shape_b {
            PartnerShape::Compliant(shape_b) => Some(Route::BetweenFields {
                shape_b,
                seeds: [self.shape_a.seeds()?, shape_b.seeds()?],
            }),
            // A component of B's surface may begin in tetrahedra of A without pressure, in which nothing is entered.
            PartnerShape::Rigid(shape_b) => {
                let is_positive_inside = self.shape_a.followed().is_ok();
                is_positive_inside.then_some(Route::OverRigid(shape_b))
            }
            PartnerShape::HalfSpace(_) => None,
        }
    }

    /// Looks at the pairs of octets: at the generic ones several at a time, at the special ones one by one. Appends the cuts of
    /// the latter.
    fn cut_octets(&self, posed_tets: &PosedTets, octets: &mut [Octet], cuts: &mut Vec<Cut>) {
        let posed = |tet_b: u32| posed_tets.get(tet_b);
        lanes::run(CutOctets {
            pair: self,
            posed,
            octets: &mut *octets,
        });
        for octet in octets {
            for place in 0..octet.tets().len() {
                let [tet_a, tet_b] = octet.tets()[place];
                let posed_b = posed(tet_b);
                octet.reached[place] = if octet.is_special(place) {
                    self.reached(tet_a as usize, posed_b, cuts)
                } else {
                    ReachedFaces {
                        faces: octet.reached_faces(place, posed_b),
                        ..ReachedFaces::default()
                    }
                };
            }
        }
    }

    /// Over which faces the surface may go on from a pair of tetrahedra. Appends its cut, if it is to be noted.
    #[inline]
    fn reached(&self, tet_a: usize, tet_b: &PosedTet, cuts: &mut Vec<Cut>) -> ReachedFaces {
        let tet_a = self.tet_a(tet_a);
        let topology = match self.classify(tet_a, tet_b, true) {
            PairClass::Disjoint => return ReachedFaces::default(),
            PairClass::EqualFields => return ReachedFaces::EQUAL_FIELDS,
            PairClass::Intersecting(topology) => topology,
        };
        let cut = self.cut(tet_a, tet_b, topology);
        // The way to others may lead through tetrahedra without pressure, and, where more than rounding is taken for zero,
        // past the ends of thin ones.
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
    /// Puts a pair of tetrahedra among those to be looked at, unless it was there.
    #[inline]
    pub fn enter(&mut self, tet_a: u32, tet_b: u32) {
        self.enter_all(&[[tet_a, tet_b]]);
    }

    /// Puts those pairs among the ones to be looked at that were not there.
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

    /// Adds a pair to those to be looked at.
    fn add(&mut self, tets: [u32; 2]) {
        self.scratch.posed_tets.add(self.pair, tets[1]);
        self.scratch.octets.pairs().push(tets);
    }

    /// Looks at all pairs of tetrahedra that may touch.
    fn look_everywhere(&mut self) {
        let pair = self.pair;
        pair.visit_overlapping(|tet_a, tet_b| {
            self.add([tet_a as u32, tet_b.index as u32]);
        });
        self.look_at_all(|_, _| {});
    }

    /// Looks at the pairs that are waiting, and at those that `go_on` from an octet adds.
    fn look_at_all(&mut self, go_on: impl Fn(&mut Self, usize)) {
        while let Some(octets) = self.look_at_next() {
            for index in octets {
                self.take_note(index);
                go_on(self, index);
            }
            self.spill();
        }
    }

    /// Hands on the octets that were looked at, if they are many, and forgets them.
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

    /// Follows the surface from where its components must show. Returns whether all of it is found.
    fn follow_route(&mut self, route: &Route) -> bool {
        match *route {
            Route::OverRigid(shape_b) => {
                self.enter_at_boundary(shape_b.triangle_bvh());
                self.enter_at_components(shape_b);
                self.follow_on()
            }
            Route::BetweenFields { shape_b, seeds } => {
                self.enter_at_boundary(shape_b.triangle_bvh());
                if let [Some(paths_a), Some(paths_b)] = seeds.map(|own| own.peak_paths.as_ref()) {
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

    /// Follows the surface from the pairs that were entered; where round-off decided over which faces it goes on, from all
    /// pairs around too. Returns whether that is all of it: not where the fields are equal over a volume, nor if there was
    /// too much doubt.
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

    /// Follows the surface from the pairs that were entered. Takes note of those where round-off decided, and returns
    /// whether it met no fields that are equal over a volume.
    fn follow_entered(&mut self) -> bool {
        let equal_before = self.scratch.equal.len();
        self.look_at_all(|walk, index| {
            let across = NeighborPairs::faces_of(walk.scratch.octets.at(index), walk.pair);
            walk.enter_all(across.pairs());
        });
        self.scratch.equal.len() == equal_before
    }

    /// Looks at the pairs that are next (see [`Octets::next`](super::scratch::Octets::next)). Returns the places of their octets;
    /// none if no pairs wait.
    fn look_at_next(&mut self) -> Option<Range<usize>> {
        let Scratch {
            posed_tets,
            octets,
            cuts,
            ..
        } = &mut *self.scratch;
        let (range, octets) = octets.next()?;
        let look = |octets: &mut [Octet], cuts: &mut Vec<Cut>| {
            self.pair.cut_octets(posed_tets, octets, cuts);
        };
        threads::collect_pieces(octets, PIECE, look, cuts);
        Some(range)
    }

    /// Records the normals of an octet, and its pairs in which the fields are equal or a decision is within round-off.
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
