//! The surface law over the generic contact polygons, several triangles of them at a time.

use super::SurfaceLaw;
use super::friction::value_rule;
use super::loaded_triangles::{Triangles, integrals};
use super::loads::{LoadedOctet, OctetsInMotion, TakesOctets};
use super::motion::RelativeMotion;
use super::polygon::{CutPolygon, CutSurface};
use crate::geometry::set_bits;
use crate::lanes::space::{cross, scaled, sum};
use crate::lanes::{self, InLanes, Lanes, Numbers, ROW, Row};
use crate::narrow_phase::{Octet, SLOTS, Weights};
use crate::scalar::{Scalar, carries_derivatives, lift_vector};
use crate::spatial::Wrench;
use crate::threads;
use nalgebra::Vector3;

/// Octets that are integrated by themselves, in one thread: some 30 µs of work.
const PIECE: usize = 32;

/// Adds up the wrenches on A of the polygons of octets, as [`CutPolygon::wrench_in_motion`] has them. Polygons on which the
/// pressure is clamped somewhere, or of which the slip turns quickly, are left to be taken one by one.
struct InMotion<'o>(OctetsInMotion<'o>);

/// For each octet of a piece the places that are left, as bits.
type Left = [u8; PIECE];

/// The sum so far, and triangles that are not yet in it.
struct Sum<'o> {
    of: OctetsInMotion<'o>,
    numbers: [Row; 6],
    triangles: Triangles,
}

impl InLanes for InMotion<'_> {
    type Output = (Wrench<f64>, Left);

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> Self::Output {
        let mut left = [0; PIECE];
        let mut sum = Sum {
            of: self.0,
            numbers: [[0.0; ROW]; 6],
            triangles: Triangles::NONE,
        };
        self.0.visit(lanes, &mut left, &mut sum);
        if sum.triangles.len > 0 {
            sum.triangles.fill_up();
            sum.add(lanes);
        }
        let total = |row: &Row| row.iter().sum::<f64>();
        let [t1, t2, t3, f1, f2, f3] = sum.numbers.each_ref().map(total);
        let wrench = Wrench {
            torque: Vector3::new(t1, t2, t3),
            force: Vector3::new(f1, f2, f3),
        };
        (wrench, left)
    }
}

impl<L: Lanes> TakesOctets<L> for Sum<'_> {
    #[inline(always)]
    fn take(&mut self, lanes: L, loaded: &LoadedOctet) {
        // Of all polygons in one loop: how many triangles one of them has, a processor cannot guess.
        let mut edges = [0; ROW];
        for (place, edges) in edges.iter_mut().enumerate() {
            let is_taken = loaded.by_rules >> place & 1;
            *edges = loaded.octet.opposite_edges(place) * is_taken;
        }
        let mut edges = u64::from_le_bytes(edges);
        while edges != 0 {
            let number = edges.trailing_zeros() as usize;
            edges &= edges - 1;
            self.triangles.push(loaded, number / SLOTS, number % SLOTS);
            if self.triangles.len == ROW {
                self.add(lanes);
            }
        }
    }
}

impl Sum<'_> {
    /// Adds the wrenches on A about A's origin in A's axes, and empties the list.
    #[inline(always)]
    fn add<L: Lanes>(&mut self, lanes: L) {
        let Self {
            of: OctetsInMotion { octets, law, .. },
            numbers,
            triangles,
        } = self;
        let rule = value_rule(triangles.rung);
        for first in (0..triangles.len).step_by(L::COUNT) {
            let integrals = integrals(lanes, triangles, first, rule, law);
            let vector = |rows: fn(&Octet) -> &[Row; 3]| -> [L::Numbers; 3] {
                let number = |axis: usize| {
                    lanes.gathered(|lane| {
                        let [octet, place] = triangles.places[first + lane];
                        rows(&octets[octet])[axis][place]
                    })
                };
                [number(0), number(1), number(2)]
            };
            let origin = vector(|octet| &octet.origin);
            let axes = [
                vector(|octet| &octet.axes[0]),
                vector(|octet| &octet.axes[1]),
                vector(|octet| &octet.axes[2]),
            ];
            let friction = lanes.splat(-law.friction);
            let wrench = wrench(origin, axes, integrals, friction);
            for (sum, part) in numbers.iter_mut().zip(wrench) {
                (lanes.load(sum, first) + part).store(sum, first);
            }
        }
        (triangles.len, triangles.rung) = (0, 0);
    }
}

/// The wrench of tractions, from their [`integrals`] in a plane.
#[inline(always)]
fn wrench<N: Numbers>(
    origin: [N; 3],
    [e1, e2, normal]: [[N; 3]; 3],
    [pressed, by_y1, by_y2, along1, along2, about]: [N; 6],
    friction: N,
) -> [N; 6] {
    let in_plane = sum(scaled(e1, along1 * friction), scaled(e2, along2 * friction));
    let force = sum(in_plane, scaled(normal, pressed));
    let tilt = sum(scaled(e1, by_y2), scaled(e2, -by_y1));
    let about_origin = sum(tilt, scaled(normal, about * friction));
    let [t1, t2, t3] = sum(about_origin, cross(origin, force));
    let [f1, f2, f3] = force;
    [t1, t2, t3, f1, f2, f3]
}

impl<T: Scalar> CutSurface<'_, T> {
    /// The wrench on A of moving bodies, in A's axes about A's origin.
    pub fn wrench_in_motion(&self, law: &SurfaceLaw<T>, motion: &RelativeMotion<T>) -> Wrench<T> {
        let add = |sum: &mut Wrench<T>, polygon: &CutPolygon<T>| {
            *sum += polygon.wrench_in_motion(law, motion);
        };
        if carries_derivatives::<T>() {
            return self.sum(add);
        }
        let mut sum = self.sum_of_special_cuts(&|sum: &mut Wrench<T>, cut| {
            self.add_where(Weights::has_still_area, add, sum, cut);
        });
        let (law, motion) = (&law.real(), &motion.real());
        let piece = |octets: &[Octet]| {
            lanes::run(InMotion(OctetsInMotion {
                octets,
                law,
                motion,
            }))
        };
        let mut pieces = self.found.octets().chunks(PIECE);
        threads::for_pieces(self.found.octets(), PIECE, piece, |(wrench, left)| {
            sum += Wrench {
                torque: lift_vector(&wrench.torque),
                force: lift_vector(&wrench.force),
            };
            let octets = pieces.next().unwrap_or_default();
            for (octet, left) in octets.iter().zip(left) {
                for place in set_bits(left) {
                    let cut = self.found.cut_of(octet, place, &self.source.pair);
                    self.add_where(Weights::has_still_area, add, &mut sum, &cut);
                }
            }
        });
        sum
    }
}
