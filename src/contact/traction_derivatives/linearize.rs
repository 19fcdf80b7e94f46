//! First derivatives of the contribution of dissipation and friction, over contact polygons of all kinds, several at a time.

use super::area::{LawOnPlane, Rates};
use super::edges::Edges;
use super::pieces::{EdgeFace, Piece, Pieces, PolygonToDivide, area_integrals, slip_along};
use super::responses::ResponseRows;
use super::wrenches::{add_columns, by_affine, minus, times, wrenches};
use crate::contact::SurfaceLaw;
use crate::contact::jacobian::RelativeJacobian;
use crate::contact::motion::RelativeMotion;
use crate::contact::polygon_fields::{PolygonFields, Six};
use crate::contact::polygon_source::PolygonSource;
use crate::contact::relative_linearization::RelativeLinearization;
use crate::contact::response::PolygonResponse;
use crate::contact::slip_fields::SlipFields;
use crate::contact::sums::PartialSum;
use crate::friction::{Edge, LEVELS, add_up_to_quadratic, at_in_lanes as at};
use crate::geometry::set_bits;
use crate::lanes::space::{components, gathered};
use crate::lanes::{self, InLanes, Lanes, Mask, Numbers, ROW, Row};
use crate::narrow_phase::{Cut, Octet, SLOTS};
use crate::search::GenericPairs;
use nalgebra::{Matrix6, Matrix6x2, Vector6};

/// Number of entries of a 6×6 matrix.
pub(super) const MATRIX: usize = 36;

/// Number of sums: the derivatives with respect to motions and twists, the wrench, and the derivatives with respect to the modulus of B,
/// dissipation and friction.
pub(super) const NUMBERS: usize = 2 * MATRIX + 4 * 6;

/// Gauss–Legendre points and weights for the mean over an edge, exact up to degree 5. A point is a fraction of the edge from its start.
pub(super) const THREE_POINTS: [(f64, f64); 3] = [
    (0.112_701_665_379_258_31, 5.0 / 18.0),
    (0.5, 4.0 / 9.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Contact polygons to be linearized.
#[derive(Clone, Copy)]
pub(super) enum Polygons<'o> {
    Generic(GenericPairs<'o>),
    Cuts(&'o [Cut]),
}

/// Linearizes the contribution of dissipation and friction, and the elastic contact of special
/// pairs (`Cut`). `RelativeJacobian::add_octets` linearizes the elastic contact of generic pairs.
pub(super) struct Linearize<'o> {
    pub source: &'o PolygonSource<'o, f64>,
    pub polygons: Polygons<'o>,
    pub law: &'o SurfaceLaw,
    pub motion: &'o RelativeMotion<f64>,
    /// Whether faces move the edges of polygons.
    pub are_edges_moved: bool,
    /// Whether the response of each polygon to changes of shape is kept.
    pub are_responses_kept: bool,
}

/// The results of [`Linearize`], in A's axes about A's origin.
pub(super) struct Linearized {
    /// The elastic contact of cuts.
    pub elastic: RelativeJacobian,
    /// The contribution of the law. The columns of `by_moduli` are zero and E_B ∂W/∂E_B.
    pub added: RelativeLinearization,
    pub responses: Vec<PolygonResponse>,
}

/// The sums so far, and the pieces that are not yet integrated.
struct Linearizer<'o> {
    of: Linearize<'o>,
    pieces: Pieces<'o>,
    /// Faces that move the edges of the current polygon, with the index of the edge.
    faces: Vec<(usize, EdgeFace)>,
    /// The number of polygons so far, which is the index of the next polygon.
    count: usize,
    sums: [Row; NUMBERS],
    rows: Option<Box<ResponseRows>>,
    linearized: Linearized,
}

impl InLanes for Linearize<'_> {
    type Output = Linearized;

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Linearized {
        let mut run = Linearizer {
            pieces: Pieces::new(self.law, self.motion),
            faces: Vec::new(),
            count: 0,
            sums: [[0.0; ROW]; NUMBERS],
            rows: self.are_responses_kept.then(ResponseRows::boxed),
            linearized: Linearized {
                elastic: RelativeJacobian::empty(),
                added: RelativeLinearization::empty(),
                responses: Vec::new(),
            },
            of: self,
        };
        let items = match run.of.polygons {
            Polygons::Generic(generic) => generic.octets.len(),
            Polygons::Cuts(cuts) => cuts.len(),
        };
        for item in 0..=items {
            // After the last polygon, incomplete batches are integrated too.
            let least = if item == items { 1 } else { ROW };
            if item < items {
                match run.of.polygons {
                    Polygons::Generic(generic) => run.divide_octet(lanes, generic, item),
                    Polygons::Cuts(cuts) => run.divide_cut(&cuts[item]),
                }
            }
            while let Some(method) = run.pieces.method_with(least) {
                run.add(lanes, method);
            }
        }
        run.linearized.added.merge(total(&run.sums));
        run.linearized
    }
}

impl<'o> Linearizer<'o> {
    #[inline(always)]
    fn divide_octet<L: Lanes>(&mut self, lanes: L, generic: GenericPairs<'o>, number: usize) {
        let octet = &generic.octets[number];
        let polygons = octet.polygons();
        if polygons == 0 {
            return;
        }
        let fields = SlipFields::of(lanes, octet, self.of.law, self.of.motion);
        for index in set_bits(polygons) {
            let level = fields.level(index);
            if level < LEVELS {
                self.add_generic(generic, octet, index, level);
            } else {
                self.divide_generic(generic, octet, index);
            }
        }
    }

    /// Adds a generic polygon as one piece.
    #[inline]
    fn add_generic(&mut self, generic: GenericPairs, octet: &Octet, index: usize, level: usize) {
        let plane = PolygonFields::at(octet, index);
        if self.of.are_responses_kept {
            let response = PolygonResponse::at(octet, index);
            self.linearized.responses.push(response.with_law());
        }
        let piece = self.pieces.batches[level].add_whole(self.count, &plane);
        self.count += 1;
        let are_edges_moved = self.of.are_edges_moved;
        let [tet_a, tet_b] = octet.tets()[index];
        let a = self.of.source.pair.tet_a(tet_a as usize);
        let b = generic.posed_tet(tet_b);
        octet.visit_edges(index, |slot, corner| {
            piece.push_corner(corner);
            // Edges on A's boundary contribute nothing, because the pressure is zero there.
            let is_boundary = slot < 4 && a.zero_faces & 1 << slot != 0;
            if !are_edges_moved || is_boundary {
                return;
            }
            let (body, face, inward, steepness) = match slot.checked_sub(4) {
                None => {
                    let inward = &a.barycentric[slot].gradient;
                    (0, slot, inward, a.barycentric_steepness[slot])
                }
                Some(bound) => {
                    let face = usize::from(b.bounds[bound]);
                    (1, face, &b.faces[face].gradient, b.face_steepness[face])
                }
            };
            let end = octet.ends[slot].map(|row| row[index]);
            let by = EdgeFace {
                body,
                opposite: Some(face),
                normal: inward * -steepness.recip(),
                shares: [1.0; 2],
            };
            piece.push_edge([corner, end], &by);
        });
        piece.close();
    }

    /// Divides a generic polygon on which the pressure is clamped at a corner, or the slip direction varies rapidly.
    #[inline(never)]
    fn divide_generic(&mut self, generic: GenericPairs, octet: &Octet, index: usize) {
        self.divide(&generic.cut(octet, index, &self.of.source.pair), false);
    }

    #[inline(never)]
    fn divide_cut(&mut self, cut: &Cut) {
        self.divide(cut, true);
    }

    /// Divides the polygon of a cut. Adds its elastic contact if `is_elastic_added`.
    fn divide(&mut self, cut: &Cut, is_elastic_added: bool) {
        let source = self.of.source;
        let Some(polygon) = source.polygon(cut) else {
            return;
        };
        let has_area = polygon.has_counted_area();
        if has_area && is_elastic_added {
            self.linearized.elastic.add(&polygon);
        }
        if self.of.are_responses_kept {
            let response = PolygonResponse::of(cut.tets, &polygon);
            self.linearized.responses.push(response.with_law());
        }
        self.faces.clear();
        if self.of.are_edges_moved {
            Edges::of(source, (cut, &polygon)).list(&mut self.faces);
        }
        let is_clamped = self.pieces.divide(PolygonToDivide {
            number: self.count,
            plane: &polygon.plane,
            outline: &polygon.outline,
            weights: polygon.weights,
            is_whole: !polygon.is_flush(),
            has_area,
            faces: &self.faces,
        });
        self.count += 1;
        self.linearized.added.kinks.are_clamped |= is_clamped;
    }

    /// Integrates up to eight pieces of a batch, and removes them from the batch.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, lanes: L, method: usize) {
        let batch = &mut self.pieces.batches[method];
        let are_whole = batch.are_whole;
        let (pieces, count) = batch.take();
        for first in (0..count).step_by(L::COUNT) {
            let group = LaneGroup {
                law_and_motion: (self.of.law, self.of.motion),
                pieces: &pieces[first..first + L::COUNT],
                first,
                are_whole,
                method,
            };
            group.add(lanes, &mut self.sums, &mut self.rows);
        }
        if let Some(rows) = &self.rows {
            for (lane, piece) in pieces[..count].iter().enumerate() {
                if let Some(law) = &mut self.linearized.responses[piece.polygon].law {
                    rows.add_to(law, piece, lane, are_whole);
                }
            }
        }
    }
}

/// Adds up the lanes of each sum.
fn total(sums: &[Row; NUMBERS]) -> RelativeLinearization {
    let totals = lanes::totals(sums);
    let (by_motion, rest) = totals.split_at(MATRIX);
    let (by_twist, rest) = rest.split_at(MATRIX);
    let six = |which: usize| Vector6::from_column_slice(&rest[6 * which..6 * which + 6]);
    RelativeLinearization {
        by_motion: Matrix6::from_column_slice(by_motion),
        by_twist: Matrix6::from_column_slice(by_twist),
        wrench: six(0),
        by_moduli: Matrix6x2::from_columns(&[Vector6::zeros(), six(1)]),
        by_law: Matrix6x2::from_columns(&[six(2), six(3)]),
        ..RelativeLinearization::empty()
    }
}

/// The flux of t through an edge whose face moves outwards at unit speed.
struct EdgeFlux<N> {
    /// The wrenches of t, y₁t and y₂t along the edge, times 1/|ν − (ν·n)n|.
    wrenches: [Six<N>; 3],
    /// The outward normal ν of the face, along the axes of the plane.
    normal: [N; 3],
    /// 1 for a face of B, 0 for a face of A.
    b_factor: N,
}

/// The pieces that are integrated at the same time, one in each lane.
pub(super) struct LaneGroup<'p> {
    pub law_and_motion: (&'p SurfaceLaw, &'p RelativeMotion<f64>),
    pub pieces: &'p [Piece],
    /// The index of the first piece in its batch.
    pub first: usize,
    pub are_whole: bool,
    pub method: usize,
}

impl LaneGroup<'_> {
    #[inline(always)]
    pub fn add<L: Lanes>(
        &self,
        lanes: L,
        sums: &mut [Row; NUMBERS],
        rows: &mut Option<Box<ResponseRows>>,
    ) {
        let first = self.first;
        let planes = PolygonFields::side_by_side(lanes, |lane| &self.pieces[lane].plane);
        let batch = (self.pieces, self.method);
        let (law, area) = area_integrals(lanes, batch, &planes, self.law_and_motion);
        let mut rates = Rates::of_area(&area, &law, planes.slope_along_normal());
        let by_growth = self.add_edges(lanes, (&law, &planes), &mut rates, rows);
        let [_, slope_b] = planes.slopes;
        rates.add_motion_of_plane(components(&planes.axes, slope_b));
        // If the modulus of B grows at the relative rate of 1/s, the plane moves at the speed p/|g|.
        let speed = times(&planes.pressure, planes.inverse_gradient_norm);
        let by_modulus_b = by_affine(&by_growth, speed);
        let by_motion = planes.matrix_in_a(&rates.by_motion);
        let by_twist = planes.matrix_in_a(&rates.by_twist);
        let (by_motions, rest) = sums.split_at_mut(MATRIX);
        let (by_twists, others) = rest.split_at_mut(MATRIX);
        add_columns(lanes, by_motions, first, &by_motion);
        add_columns(lanes, by_twists, first, &by_twist);
        let of_each = [
            planes.in_a(&rates.wrench),
            planes.in_a(&by_modulus_b),
            planes.in_a(&rates.by_dissipation),
            planes.in_a(&rates.by_friction),
        ];
        add_columns(lanes, others, first, &of_each);
    }

    /// Weights the derivatives of the pieces' wrenches, and adds what edges contribute. Returns K₀, K₁ and K₂ for growth of the modulus of
    /// B, too.
    #[inline(always)]
    fn add_edges<L: Lanes>(
        &self,
        lanes: L,
        (law, planes): (&LawOnPlane<L::Numbers>, &PolygonFields<L::Numbers>),
        rates: &mut Rates<L::Numbers>,
        rows: &mut Option<Box<ResponseRows>>,
    ) -> [Six<L::Numbers>; 3] {
        let (pieces, first) = (self.pieces, self.first);
        let mut by_growth = rates.by_speed;
        if !self.are_whole {
            let [still, moving] = [
                lanes.gathered(|lane| pieces[lane].weights[0]),
                lanes.gathered(|lane| pieces[lane].weights[1]),
            ];
            for by_growth in &mut by_growth {
                *by_growth = times(by_growth, still);
            }
            rates.weight(still, moving);
        }
        let mut count = 0;
        for piece in pieces {
            count = piece.edge_count.max(count);
        }
        for number in 0..count.min(SLOTS) {
            let mut flux = self.flux(lanes, law, planes, number);
            if !self.are_whole {
                let [moving, growing] = [
                    lanes.gathered(|lane| pieces[lane].shares[number][0]),
                    lanes.gathered(|lane| pieces[lane].shares[number][1]),
                ];
                for (by_growth, wrench) in by_growth.iter_mut().zip(&mut flux.wrenches) {
                    *by_growth = minus(by_growth, &times(wrench, flux.normal[2] * growing));
                    *wrench = times(wrench, moving);
                }
            }
            rates.add_flux(&flux.wrenches, flux.normal, flux.b_factor);
            if let Some(rows) = rows {
                rows.store_face(number, first, &flux.wrenches);
            }
        }
        if self.are_whole {
            by_growth = rates.by_speed;
        }
        if let Some(rows) = rows {
            rows.store(first, rates, &by_growth);
        }
        by_growth
    }

    /// Returns the flux through an edge of each piece.
    #[inline(always)]
    fn flux<L: Lanes>(
        &self,
        lanes: L,
        law: &LawOnPlane<L::Numbers>,
        planes: &PolygonFields<L::Numbers>,
        number: usize,
    ) -> EdgeFlux<L::Numbers> {
        let pieces = self.pieces;
        let from = [
            lanes.gathered(|lane| pieces[lane].edges[number].ends[0][0]),
            lanes.gathered(|lane| pieces[lane].edges[number].ends[0][1]),
        ];
        let to = [
            lanes.gathered(|lane| pieces[lane].edges[number].ends[1][0]),
            lanes.gathered(|lane| pieces[lane].edges[number].ends[1][1]),
        ];
        let edge = Edge::between(from, to);
        let [u1, u2] = slip_along(lanes, pieces, number, (&law.load, &edge), self.method);
        let pressed = pressed_along(lanes, &edge, &law.load.pressure, &law.excess);
        let [w0, w1, w2] = wrenches(&[
            times(&u1, -law.friction),
            times(&u2, -law.friction),
            pressed,
        ]);
        let normal = gathered(lanes, |lane| &pieces[lane].edges[number].normal);
        let normal = components(&planes.axes, normal);
        let b_factor = lanes.gathered(|lane| f64::from(pieces[lane].edges[number].body));
        let mut factor = inverse_sine(normal, law.zero, law.load.one);
        if self.are_whole {
            // Both shares are equal: 0 for a missing edge or a face in the plane, and otherwise ±1.
            factor = factor * lanes.gathered(|lane| pieces[lane].shares[number][0]);
        }
        EdgeFlux {
            wrenches: [times(&w0, factor), times(&w1, factor), times(&w2, factor)],
            normal,
            b_factor,
        }
    }
}

/// Returns 1/|ν − (ν·n)n|, given the components of ν along the axes. Returns 0 if ν is parallel to n.
#[inline(always)]
fn inverse_sine<N: Numbers>([m1, m2, _]: [N; 3], zero: N, one: N) -> N {
    let squared = m1 * m1 + m2 * m2;
    zero.is_less(squared).select(one / squared.sqrt(), zero)
}

/// Returns ∫ p f m dl along an edge for an affine f and the monomials m = 1, y₁, y₂, y₁², y₁y₂, y₂².
#[inline(always)]
fn pressed_along<L: Lanes>(
    lanes: L,
    edge: &Edge<L::Numbers>,
    pressure: &[L::Numbers; 3],
    f: &[L::Numbers; 3],
) -> [L::Numbers; 6] {
    let mut sums = [lanes.splat(0.0); 6];
    for (share, weight) in THREE_POINTS {
        let share = lanes.splat(share);
        let y = [
            edge.from[0] + edge.span[0] * share,
            edge.from[1] + edge.span[1] * share,
        ];
        let value = at(pressure, y) * at(f, y) * (edge.length * lanes.splat(weight));
        add_up_to_quadratic(&mut sums, value, y);
    }
    sums
}
