use super::corners::Corners;
use super::quadrature::{Field, moments};
use super::{MATRIX, add_columns, law_on};
use crate::contact::SurfaceLaw;
use crate::contact::motion::RelativeMotion;
use crate::contact::outline::at;
use crate::contact::plane_motion::PlaneMotion;
use crate::contact::polygon_fields::{Columns, PolygonFields};
use crate::contact::traction_derivatives::area::AreaMoments;
use crate::contact::traction_derivatives::frozen::{AddedByLaw, FrozenPolygon};
use crate::contact::traction_derivatives::wrenches::{plus, times};
use crate::friction::{LEVELS, slope_rules};
use crate::lanes::space::loaded;
use crate::lanes::{InLanes, Lanes, ROW, Row};
use crate::narrow_phase::SLOTS;
use nalgebra::{Matrix6, Vector6};

/// By motions and twists, and the wrench.
const NUMBERS: usize = 2 * MATRIX + 6;

/// The wrench and derivatives that the law adds over frozen polygons after a motion of B, where the pressure is positive. Polygons are
/// left if they are not integrated by rules, if the damping is clamped, or if they have more than [`SLOTS`] corners.
pub(in crate::contact::traction_derivatives) struct FrozenInLanes<'p> {
    pub polygons: &'p [FrozenPolygon],
    pub law: &'p SurfaceLaw,
    pub motion: &'p Vector6<f64>,
    pub velocity: &'p RelativeMotion<f64>,
}

/// Up to eight polygons that are integrated by the same rule.
struct Batch {
    corners: Corners,
    /// The pressure after the motion: [`PolygonFields::pressure`].
    pressure: [Row; 3],
    /// Which polygon is in each lane.
    polygons: [usize; ROW],
}

impl InLanes for FrozenInLanes<'_> {
    /// What is added, and the polygons that are left.
    type Output = (AddedByLaw, Vec<usize>);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let mut sums = [[0.0; ROW]; NUMBERS];
        let mut left = Vec::new();
        let mut batches: [Option<Box<Batch>>; LEVELS] = [const { None }; LEVELS];
        for (number, polygon) in self.polygons.iter().enumerate() {
            let pressure = polygon.pressure_after(self.motion);
            let part = polygon.outline().cut(&pressure);
            let outline = part.as_ref().unwrap_or(polygon.outline());
            if outline.corners().len() < 3 {
                continue;
            }
            let Some(level) = self.level(polygon, outline.corners()) else {
                left.push(number);
                continue;
            };
            let batch = batches[level].get_or_insert_with(Batch::empty);
            batch.push(number, outline.corners(), &pressure);
            if batch.corners.len == ROW {
                self.add(lanes, &mut sums, batch, level);
            }
        }
        for (level, batch) in batches.iter_mut().enumerate() {
            if let Some(batch) = batch.as_mut().filter(|batch| batch.corners.len > 0) {
                batch.fill_up();
                self.add(lanes, &mut sums, batch, level);
            }
        }
        let totals = sums.map(|[a, b, c, d, e, f, g, h]| ((a + b) + (c + d)) + ((e + f) + (g + h)));
        let (by_motion, rest) = totals.split_at(MATRIX);
        let (by_twist, wrench) = rest.split_at(MATRIX);
        let added = AddedByLaw {
            wrench: Vector6::from_column_slice(wrench),
            by_motion: Matrix6::from_column_slice(by_motion),
            by_twist: Matrix6::from_column_slice(by_twist),
        };
        (added, left)
    }
}

impl FrozenInLanes<'_> {
    /// Returns the level of the ladder of rules that is good enough for the part of a polygon with these corners. Returns `None` if
    /// there is none, if the damping is not positive at every corner, or if there are more than [`SLOTS`] corners.
    fn level(&self, polygon: &FrozenPolygon, corners: &[[f64; 2]]) -> Option<usize> {
        let motion = PlaneMotion::of(self.velocity, polygon.plane());
        let damping = motion.damping(self.law.dissipation, 1.0);
        let is_damped = |y: &[f64; 2]| at(&damping, y) >= 0.0;
        let fits = corners.len() <= SLOTS && corners.iter().all(is_damped);
        fits.then(|| motion.slip_by(self.law).level(corners))?
    }

    /// Adds the polygons of a batch, and empties it.
    #[inline(always)]
    fn add<L: Lanes>(&self, lanes: L, sums: &mut [Row; NUMBERS], batch: &mut Batch, level: usize) {
        let (rule, _) = slope_rules(level);
        for first in (0..batch.corners.len).step_by(L::COUNT) {
            let polygon = |lane: usize| &self.polygons[batch.polygons[first + lane]];
            let mut planes = PolygonFields::side_by_side(lanes, |lane| polygon(lane).plane());
            planes.pressure = loaded(lanes, &batch.pressure, first);
            let law = law_on(lanes, &planes, (self.law, self.velocity));
            let field = Field::of(lanes, &law, self.law.slip_tolerance);
            let corners = (&batch.corners, first);
            let slip = field.over_area(lanes, corners, rule);
            let area = AreaMoments::of(&law, &slip, &moments(lanes, corners), None);
            let weight = lanes.gathered(|lane| polygon(lane).weight());
            let wrench = times(&planes.in_a(&area.wrench()), weight);
            let [c0, c1, c2] = area.by_pressure();
            let by_pressure = [
                times(&planes.in_a(&c0), weight),
                times(&planes.in_a(&c1), weight),
                times(&planes.in_a(&c2), weight),
            ];
            let mut by_twist = planes.matrix_in_a(&area.by_twist());
            let mut by_motion: Columns<L::Numbers> = [[law.zero; 6]; 6];
            for column in 0..6 {
                by_twist[column] = times(&by_twist[column], weight);
                for (k, by_pressure) in by_pressure.iter().enumerate() {
                    let by = lanes.gathered(|lane| polygon(lane).pressure_by_motion[k][column]);
                    by_motion[column] = plus(&by_motion[column], &times(by_pressure, by));
                }
            }
            let (by_motions, rest) = sums.split_at_mut(MATRIX);
            let (by_twists, wrenches) = rest.split_at_mut(MATRIX);
            add_columns(lanes, by_motions, first, &by_motion);
            add_columns(lanes, by_twists, first, &by_twist);
            add_columns(lanes, wrenches, first, &[wrench]);
        }
        batch.corners.len = 0;
    }
}

impl Batch {
    fn empty() -> Box<Self> {
        Box::new(Self {
            corners: Corners::NONE,
            pressure: [[0.0; ROW]; 3],
            polygons: [0; ROW],
        })
    }

    /// Makes polygons without an area of the lanes that are free.
    fn fill_up(&mut self) {
        self.corners.fill_up();
        let first = self.polygons[0];
        self.polygons[self.corners.len..].fill(first);
    }

    /// Adds the part of a polygon with these corners.
    fn push(&mut self, number: usize, corners: &[[f64; 2]], pressure: &[f64; 3]) {
        let lane = self.corners.len;
        for (place, corner) in corners.iter().enumerate() {
            self.corners.set(lane, place, *corner);
        }
        self.corners.close(lane, corners.len());
        for (row, coefficient) in self.pressure.iter_mut().zip(pressure) {
            row[lane] = *coefficient;
        }
        self.polygons[lane] = number;
        self.corners.len += 1;
    }
}
