//! First derivatives of what dissipation and friction add, over the generic contact polygons, several at a time.

mod corners;
mod edges;
mod frozen;
mod quadrature;
mod responses;
#[cfg(test)]
mod tests;

use crate::contact::SurfaceLaw;
use crate::contact::integrate::Remainder;
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_motion::PlaneMotion;
use crate::contact::polygon_fields::{PolygonFields, Six};
use crate::contact::relative_linearisation::RelativeLinearisation;
use crate::contact::response::{PolygonResponse, Responses};
use crate::contact::slip_fields::{LoadedOctet, MovingOctets, OctetVisitor};
use crate::contact::sums::PartialSum;
use crate::contact::traction_derivatives::area::{AreaMoments, LawOnPlane, Rates};
use crate::contact::traction_derivatives::wrenches::{by_affine, times, wrenches};
use crate::friction::{LEVELS, slope_rules};
use crate::geometry::set_bits;
use crate::lanes::space::components;
use crate::lanes::{self, InLanes, Lanes, Mask, Numbers, ROW, Row};
use crate::narrow_phase::{RelativePair, SLOTS};
use crate::search::GenericPairs;
use edges::Edges;
pub(super) use frozen::FrozenInLanes;
use nalgebra::{Matrix6, Matrix6x2, Vector6};
use quadrature::{Edge, Field, moments};
use responses::ResponseRows;

/// How many numbers a 6×6 matrix has.
const MATRIX: usize = 36;

/// By motions and twists, the wrench, and its derivatives by the modulus of B, dissipation and friction.
const NUMBERS: usize = 2 * MATRIX + 4 * 6;

/// The sum over the polygons of octets of what the law adds, in A's axes about A's origin; of the derivatives by the moduli, only
/// E_B ∂W/∂E_B, in the second column. Polygons on which the pressure is clamped somewhere, or of which the slip turns quickly,
/// are left to be taken one by one.
pub(super) struct AddedInLanes<'o> {
    pub moving: MovingOctets<'o>,
    pub generic: GenericPairs<'o>,
    pub pair: &'o RelativePair<'o>,
    /// Whether it is kept how each polygon answers to changes of shape.
    pub are_responses_kept: bool,
}

/// What is summed over polygons, those at one place of a list of eight by themselves, and what is kept of each.
struct Sums {
    numbers: [Row; NUMBERS],
    rows: Option<ResponseRows>,
    responses: Vec<PolygonResponse>,
}

/// The sums so far, and polygons that are not yet in them, by the level of the ladder of rules that is good enough.
struct Adding<'o> {
    to: &'o AddedInLanes<'o>,
    sums: Sums,
    groups: Vec<Edges>,
}

impl AddedInLanes<'_> {
    /// The sum, and how the polygons answer to changes of shape, if that is kept. Notes which of them are left.
    pub fn sum<R: Responses>(self, left: &mut Remainder) -> (RelativeLinearisation, R) {
        let (sums, responses) = lanes::run(Run { added: self, left });
        let (by_motion, rest) = sums.split_at(MATRIX);
        let (by_twist, rest) = rest.split_at(MATRIX);
        let six = |which: usize| Vector6::from_column_slice(&rest[6 * which..6 * which + 6]);
        let sum = RelativeLinearisation {
            by_motion: Matrix6::from_column_slice(by_motion),
            by_twist: Matrix6::from_column_slice(by_twist),
            wrench: six(0),
            by_moduli: Matrix6x2::from_columns(&[Vector6::zeros(), six(1)]),
            by_law: Matrix6x2::from_columns(&[six(2), six(3)]),
            // Generic polygons have no kinks.
            ..RelativeLinearisation::empty()
        };
        (sum, R::of(responses))
    }
}

/// A sum that is being taken, and where to note the places that are left.
struct Run<'o> {
    added: AddedInLanes<'o>,
    left: &'o mut Remainder,
}

impl InLanes for Run<'_> {
    type Output = ([f64; NUMBERS], Vec<PolygonResponse>);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let mut sums = Sums {
            numbers: [[0.0; ROW]; NUMBERS],
            rows: None,
            responses: Vec::new(),
        };
        let Self { added, left } = self;
        if added.are_responses_kept {
            sums.rows = Some(ResponseRows::NONE);
            sums.responses.reserve(ROW * added.moving.octets.len());
        }
        let mut adding = Adding {
            to: &added,
            sums,
            groups: (0..LEVELS).map(|_| Edges::NONE).collect(),
        };
        added.moving.visit(lanes, left, &mut adding);
        for level in 0..LEVELS {
            if adding.groups[level].corners.len > 0 {
                adding.add(lanes, level);
            }
        }
        let sums = adding.sums;
        let mut totals = [0.0; NUMBERS];
        for (total, [a, b, c, d, e, f, g, h]) in totals.iter_mut().zip(sums.numbers) {
            *total = ((a + b) + (c + d)) + ((e + f) + (g + h));
        }
        (totals, sums.responses)
    }
}

impl<L: Lanes> OctetVisitor<L> for Adding<'_> {
    #[inline(always)]
    fn take(&mut self, lanes: L, loaded: &LoadedOctet) {
        for place in set_bits(loaded.by_rules) {
            let level = loaded.loads.level(place);
            let edges = &mut self.groups[level];
            let [_, tet_b] = loaded.octet.tets()[place];
            let tet_b = self.to.generic.posed_tet(tet_b);
            edges.push(loaded, place, (self.to.pair, tet_b));
            if edges.corners.len == ROW {
                self.add(lanes, level);
            }
        }
    }
}

impl Adding<'_> {
    /// Adds the polygons of a level, and empties their list.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, lanes: L, level: usize) {
        let (edges, sums) = (&mut self.groups[level], &mut self.sums);
        edges.fill_up();
        for first in (0..edges.corners.len).step_by(L::COUNT) {
            self.to.add_part(lanes, sums, (edges, first), level);
        }
        if let Some(rows) = &sums.rows {
            for lane in 0..edges.corners.len {
                let response = rows.response(self.to.moving.octets, edges, lane);
                sums.responses.push(response);
            }
        }
        edges.corners.len = 0;
    }
}

impl AddedInLanes<'_> {
    /// Adds as many polygons as there are lanes.
    #[inline(always)]
    fn add_part<L: Lanes>(
        &self,
        lanes: L,
        sums: &mut Sums,
        (edges, first): (&Edges, usize),
        level: usize,
    ) {
        let planes = PolygonFields::gathered(lanes, self.moving.octets, &edges.places, first);
        let law = law_on(lanes, &planes, (self.moving.law, self.moving.motion));
        let mut rates = self.rates(
            lanes,
            (&law, &planes),
            (edges, first),
            (level, &mut sums.rows),
        );
        let [_, slope_b] = planes.slopes;
        rates.add_motion_of_plane(components(&planes.axes, slope_b));
        // As the modulus of B grows the plane moves by p/|g|.
        let speed = times(&planes.pressure, planes.inverse_gradient_norm);
        let by_modulus_b = by_affine(&rates.by_speed, speed);
        let by_motion = planes.matrix_in_a(&rates.by_motion);
        let by_twist = planes.matrix_in_a(&rates.by_twist);
        let (by_motions, rest) = sums.numbers.split_at_mut(MATRIX);
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

    /// The derivatives of the polygons' wrenches, with all that their edges contribute.
    #[inline(always)]
    fn rates<L: Lanes>(
        &self,
        lanes: L,
        (law, planes): (&LawOnPlane<L::Numbers>, &PolygonFields<L::Numbers>),
        (edges, first): (&Edges, usize),
        (level, rows): (usize, &mut Option<ResponseRows>),
    ) -> Rates<L::Numbers> {
        let (over_area, along_edges) = slope_rules(level);
        let field = Field::of(lanes, law, self.moving.law.slip_tolerance);
        let corners = &edges.corners;
        let slip = field.over_area(lanes, (corners, first), over_area);
        let area = AreaMoments::of(law, &slip, &moments(lanes, (corners, first)), None);
        let mut rates = Rates::of_area(&area, law, planes.slope_along_normal());
        let count = if self.moving.law.is_elastic() {
            0
        } else {
            corners.most::<L>(first).min(SLOTS)
        };
        for number in 0..count {
            let edge = Edge::of(lanes, corners, number, first);
            let [u1, u2] = field.along(lanes, &edge, along_edges);
            let pressed = field.pressed_along(lanes, &edge, &law.excess);
            let fluxes = wrenches(&[
                times(&u1, -law.friction),
                times(&u2, -law.friction),
                pressed,
            ]);
            let [x, y, z] = &edges.normals[number];
            let normal = [
                lanes.load(x, first),
                lanes.load(y, first),
                lanes.load(z, first),
            ];
            let of_b = lanes.load(&edges.of_b[number], first);
            let normal = components(&planes.axes, normal);
            let inverse_sine = inverse_sine(normal, law.zero, field.one);
            let fluxes = [
                times(&fluxes[0], inverse_sine),
                times(&fluxes[1], inverse_sine),
                times(&fluxes[2], inverse_sine),
            ];
            rates.add_flux(&fluxes, normal, of_b);
            if let Some(rows) = rows {
                rows.store_face(number, first, &fluxes);
            }
        }
        if let Some(rows) = rows {
            rows.store(first, &rates);
        }
        rates
    }
}

#[inline(always)]
fn law_on<L: Lanes>(
    lanes: L,
    planes: &PolygonFields<L::Numbers>,
    (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
) -> LawOnPlane<L::Numbers> {
    let motion = PlaneMotion::in_lanes(lanes, motion, &planes.axes, planes.origin);
    let numbers = [lanes.splat(law.friction), lanes.splat(law.dissipation)];
    let zero_and_one = [lanes.splat(0.0), lanes.splat(1.0)];
    LawOnPlane::of(numbers, planes.pressure, motion, zero_and_one)
}

/// 1 over the length of the part in the plane of a normal along its axes; 0, where that is 0.
#[inline(always)]
fn inverse_sine<N: Numbers>([m1, m2, _]: [N; 3], zero: N, one: N) -> N {
    let squared = m1 * m1 + m2 * m2;
    zero.is_less(squared).select(one / squared.sqrt(), zero)
}

/// Adds columns of six to rows.
#[inline(always)]
fn add_columns<L: Lanes>(lanes: L, rows: &mut [Row], first: usize, columns: &[Six<L::Numbers>]) {
    for (rows, column) in rows.chunks_exact_mut(6).zip(columns) {
        for (row, number) in rows.iter_mut().zip(column) {
            (lanes.load(row, first) + *number).store(row, first);
        }
    }
}
