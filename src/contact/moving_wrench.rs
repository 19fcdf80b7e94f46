//! The wrench of a contact with the surface law. Generic polygons are integrated in lanes, several triangles at a time. Special polygons
//! are integrated one by one, and so are generic polygons on which the pressure is clamped or the slip direction varies rapidly.

use super::SurfaceLaw;
use super::integrate::{Integrand, Remainder};
use super::loaded_triangles::{Triangles, integrals};
use super::motion::RelativeMotion;
use super::outline::quadratic_moments;
use super::plane_motion::PlaneMotion;
use super::plane_polygon::PlanePolygon;
use super::polygon_fields::PolygonFields;
use super::polygon_source::PolygonSource;
use super::slip_fields::SlipFields;
use crate::friction::{product, value_rule};
use crate::lanes::{self, InLanes, Lanes, Numbers, ROW, Row};
use crate::narrow_phase::{Cut, Octet, SLOTS, Weights};
use crate::scalar::{Scalar, carries_derivatives, lift, real_part};
use crate::search::GenericPairs;
use crate::spatial::Wrench;
use nalgebra::Vector6;

/// Number of octets in a piece of work for a thread, which takes about 30 µs.
const OCTETS: usize = 32;

/// The wrench on A of moving bodies with a surface law, in A's axes about A's origin.
pub(super) struct MovingWrench<T> {
    pub law: SurfaceLaw<T>,
    pub motion: RelativeMotion<T>,
}

/// Adds the wrenches on A of the polygons of octets, like [`PlanePolygon::wrench_in_motion`]. Skips polygons on which the pressure is
/// clamped somewhere, or the slip direction varies rapidly.
struct InLanesOver<'o> {
    octets: &'o [Octet],
    law: &'o SurfaceLaw,
    motion: &'o RelativeMotion<f64>,
    remainder: &'o mut Remainder,
}

/// The sum so far, and the triangles that are not yet integrated.
struct Sum<'o> {
    octets: &'o [Octet],
    law: &'o SurfaceLaw,
    numbers: [Row; 6],
    triangles: Triangles,
}

impl InLanes for InLanesOver<'_> {
    type Output = [f64; 6];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let mut sum = Sum {
            octets: self.octets,
            law: self.law,
            numbers: [[0.0; ROW]; 6],
            triangles: Triangles::NONE,
        };
        for number in 0..self.octets.len() {
            let octet = &self.octets[number];
            let polygons = octet.polygons();
            if polygons == 0 {
                continue;
            }
            let fields = SlipFields::of(lanes, octet, self.law, self.motion);
            let by_rules = fields.by_rules() & polygons;
            self.remainder[number] = polygons & !by_rules;
            // One loop over the triangles of all eight polygons avoids branch mispredictions, because the number of triangles of a polygon
            // is unpredictable.
            let mut edges = [0; ROW];
            for (index, edges) in edges.iter_mut().enumerate() {
                let uses_rules = by_rules >> index & 1;
                *edges = octet.opposite_edges(index) * uses_rules;
            }
            let mut edges = u64::from_le_bytes(edges);
            while edges != 0 {
                let edge = edges.trailing_zeros() as usize;
                edges &= edges - 1;
                let indices = [number, edge / SLOTS];
                sum.triangles.push((octet, &fields), indices, edge % SLOTS);
                if sum.triangles.len == ROW {
                    sum.add(lanes);
                }
            }
        }
        if sum.triangles.len > 0 {
            sum.triangles.fill_up();
            sum.add(lanes);
        }
        sum.numbers.map(|row| row.iter().sum())
    }
}

impl Sum<'_> {
    /// Adds the wrenches of the listed triangles on A, in A's axes about A's origin, and empties the list.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, lanes: L) {
        let Self {
            octets,
            law,
            numbers,
            triangles,
        } = self;
        let rule = value_rule(triangles.level);
        for first in (0..triangles.len).step_by(L::COUNT) {
            let [pressed, by_y1, by_y2, along1, along2, about] =
                integrals(lanes, triangles, first, rule, law);
            let plane = PolygonFields::gathered(lanes, octets, &triangles.indices, first);
            let friction = lanes.splat(-law.friction);
            let [along1, along2, about] = [along1 * friction, along2 * friction, about * friction];
            let wrench = plane.in_a(&[by_y2, -by_y1, about, along1, along2, pressed]);
            for (sum, part) in numbers.iter_mut().zip(wrench) {
                (lanes.load(sum, first) + part).store(sum, first);
            }
        }
        (triangles.len, triangles.level) = (0, 0);
    }
}

impl<T: Scalar> Integrand<T> for MovingWrench<T> {
    type Sum = Wrench<T>;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<T>, cut: &Cut, sum: &mut Wrench<T>) {
        if let Some(polygon) = source.counted_polygon(cut, Weights::has_still_area) {
            *sum += polygon.wrench_in_motion(&self.law, &self.motion);
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<T>,
        generic: GenericPairs,
        remainder: &mut Remainder,
        sum: &mut Wrench<T>,
    ) {
        let wrench = lanes::run(InLanesOver {
            octets: generic.octets,
            law: &self.law.real(),
            motion: &self.motion.real(),
            remainder,
        });
        *sum += Wrench::from_vector(&Vector6::from(wrench.map(lift)));
    }
}

impl<T: Scalar> PlanePolygon<T> {
    /// Returns the wrench on A, in A's axes about A's origin, of the traction
    ///
    /// t = pψ(−μu₁, −μu₂, 1) along e₁, e₂ and n, ψ = 1 − d v₃, u = (v₁, v₂)/√(v₁² + v₂² + v_s²),
    ///
    /// integrated over the part of the polygon where ψ is positive. The normal part is a polynomial. Friction is integrated by rules or in
    /// closed form (see [`Slip`](crate::friction::Slip)).
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, motion: &RelativeMotion<T>) -> Wrench<T> {
        let plane = &self.plane;
        let motion = PlaneMotion::of(motion, plane);
        let damping = motion.damping(law.dissipation, lift(1.0));
        // If surfaces separate so fast that ψ is negative, the pressure is clamped to zero, because surfaces do not pull.
        let part = self.outline.cut(&damping);
        let (outline, moments) = match &part {
            Some(part) => (part, part.moments()),
            None => (&self.outline, self.moments()),
        };
        let traction = product(&plane.pressure, &damping);
        let [normal, by_y1, by_y2] = quadratic_moments(&traction, &moments);
        let friction = if real_part(law.friction) == 0.0 && !carries_derivatives::<T>() {
            [lift(0.0); 3]
        } else {
            let slip = motion.slip_by(law);
            let along_slip = slip.resultant(outline.corners(), &plane.pressure, &damping);
            along_slip.map(|part| -(law.friction * part))
        };
        let [along_e1, along_e2, about_n] = friction;
        let weight = lift::<T>(self.weights.still.area());
        let wrench = [by_y2, -by_y1, about_n, along_e1, along_e2, normal];
        let wrench = plane.in_a(&wrench.map(|entry| entry * weight));
        Wrench::from_vector(&Vector6::from(wrench))
    }
}
