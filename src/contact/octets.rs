//! Integrals over the generic contact polygons, several at a time.

use super::jacobian::RelativeJacobian;
use super::sums::{OverOctets, PartialSum};
use crate::lanes::space::{cross, scaled, sum};
use crate::lanes::{self, InLanes, Lanes, Numbers, ROW, Row};
use crate::narrow_phase::Octet;
use crate::scalar::{Scalar, lift};
use crate::spatial::Wrench;
use crate::threads;
use nalgebra::{Matrix6, Vector3, Vector6};
use std::marker::PhantomData;

/// Octets that are integrated by themselves, in one thread: some 20 µs of work.
const PIECE: usize = 256;

/// How many numbers a 6×6 matrix has.
const MATRIX: usize = 36;

/// How many there are in a [`RelativeJacobian`]: a matrix and three wrenches.
const JACOBIAN: usize = MATRIX + 3 * 6;

/// `N` numbers that are integrals over each polygon.
trait Integrals<const N: usize> {
    fn of<L: Lanes>(lanes: L, polygons: &Polygons<L::Numbers>) -> [L::Numbers; N];
}

/// As many contact polygons as there are lanes: rows of octets of the same names, in A's frame.
pub(super) struct Polygons<N> {
    pub origin: [N; 3],
    pub e1: [N; 3],
    pub e2: [N; 3],
    pub normal: [N; 3],
    pub pressure: [N; 3],
    pub gradient_a: [N; 3],
    pub slopes: [[N; 3]; 2],
    pub yielding: N,
    pub moments: [N; 6],
}

impl<N: Numbers> Polygons<N> {
    /// Those of an octet from a place on.
    #[inline(always)]
    pub fn of<L: Lanes<Numbers = N>>(lanes: L, octet: &Octet, first: usize) -> Self {
        Self::from(|row| lanes.load(row(octet), first))
    }

    /// Those at places of octets, each given by octet and place, from the one with this number on.
    #[inline(always)]
    pub fn gathered<L: Lanes<Numbers = N>>(
        lanes: L,
        octets: &[Octet],
        places: &[[usize; 2]; ROW],
        first: usize,
    ) -> Self {
        Self::from(|row| {
            lanes.gathered(|lane| {
                let [octet, place] = places[first + lane];
                row(&octets[octet])[place]
            })
        })
    }

    #[inline(always)]
    fn from(load: impl Fn(fn(&Octet) -> &Row) -> N) -> Self {
        macro_rules! vector {
            ($($rows:tt)+) => {
                [
                    load(|octet| &octet.$($rows)+[0]),
                    load(|octet| &octet.$($rows)+[1]),
                    load(|octet| &octet.$($rows)+[2]),
                ]
            };
        }
        Self {
            origin: vector!(origin),
            e1: vector!(axes[0]),
            e2: vector!(axes[1]),
            normal: vector!(axes[2]),
            pressure: vector!(pressure),
            gradient_a: vector!(gradient_a),
            slopes: [vector!(slopes[0]), vector!(slopes[1])],
            yielding: load(|octet| &octet.yielding),
            moments: [
                load(|octet| &octet.moments[0]),
                load(|octet| &octet.moments[1]),
                load(|octet| &octet.moments[2]),
                load(|octet| &octet.moments[3]),
                load(|octet| &octet.moments[4]),
                load(|octet| &octet.moments[5]),
            ],
        }
    }

    /// ∫ p dA and ∫ p x dA.
    #[inline(always)]
    fn pressure_integrals(&self) -> (N, [N; 3]) {
        let [p0, p1, p2] = self.pressure;
        let [area, y1, y2, y11, y12, y22] = self.moments;
        let total = p0 * area + p1 * y1 + p2 * y2;
        let by_y1 = p0 * y1 + p1 * y11 + p2 * y12;
        let by_y2 = p0 * y2 + p1 * y12 + p2 * y22;
        let in_plane = sum(scaled(self.e1, by_y1), scaled(self.e2, by_y2));
        (total, sum(scaled(self.origin, total), in_plane))
    }
}

/// The wrench on A about A's origin: torque, force.
struct OfWrench;

impl Integrals<6> for OfWrench {
    #[inline(always)]
    fn of<L: Lanes>(_: L, polygons: &Polygons<L::Numbers>) -> [L::Numbers; 6] {
        let (total, weighted) = polygons.pressure_integrals();
        let [t1, t2, t3] = cross(weighted, polygons.normal);
        let [f1, f2, f3] = scaled(polygons.normal, total);
        [t1, t2, t3, f1, f2, f3]
    }
}

/// The sums of a [`RelativeJacobian`], as [`CutPolygon::add_to`](super::polygon::CutPolygon::add_to) has them: `by_motion_of_b`
/// column by column, `wrench`, `pressed_a`, `pressed_b`.
struct OfJacobian;

impl Integrals<JACOBIAN> for OfJacobian {
    #[inline(always)]
    fn of<L: Lanes>(lanes: L, polygons: &Polygons<L::Numbers>) -> [L::Numbers; JACOBIAN] {
        let (a, [slope_a, slope_b]) = (polygons.gradient_a, polygons.slopes);
        let (origin, e1, e2) = (polygons.origin, polygons.e1, polygons.e2);
        let [area, y1, y2, y11, y12, y22] = polygons.moments;
        let from_origin = sum(scaled(e1, y1), scaled(e2, y2));
        let first = sum(scaled(origin, area), from_origin);
        // ∫ x y₁ dA and ∫ x y₂ dA.
        let by_y1 = sum(scaled(origin, y1), sum(scaled(e1, y11), scaled(e2, y12)));
        let by_y2 = sum(scaled(origin, y2), sum(scaled(e1, y12), scaled(e2, y22)));
        let (arm_a, arm_b) = (cross(first, a), cross(first, slope_b));
        let mut sums = [lanes.splat(0.0); JACOBIAN];
        // ∫ (x × a)(x × b)ᵀ dA for b the slope of B: with x = origin + e₁y₁ + e₂y₂ in the second factor, it is the sum over 1, y₁
        // and y₂ of ∫ (x × a) y dA and its part of x × b.
        let in_second = [
            cross(origin, slope_b),
            cross(e1, slope_b),
            cross(e2, slope_b),
        ];
        let by_second = [arm_a, cross(by_y1, a), cross(by_y2, a)];
        for row in 0..3 {
            for column in 0..3 {
                let torque_torque = by_second[0][row] * in_second[0][column]
                    + by_second[1][row] * in_second[1][column]
                    + by_second[2][row] * in_second[2][column];
                sums[6 * column + row] = -torque_torque;
                sums[6 * (3 + column) + row] = -(arm_a[row] * slope_b[column]);
                sums[6 * column + 3 + row] = -(a[row] * arm_b[column]);
                sums[6 * (3 + column) + 3 + row] = -(a[row] * slope_b[column] * area);
            }
        }
        let (total, weighted) = polygons.pressure_integrals();
        let ways = [polygons.normal, slope_a, slope_b];
        for (number, way) in ways.into_iter().enumerate() {
            let place = MATRIX + 6 * number;
            let torque = cross(weighted, way);
            let force = scaled(way, total);
            for axis in 0..3 {
                sums[place + axis] = torque[axis];
                sums[place + 3 + axis] = force[axis];
            }
        }
        sums
    }
}

/// Sums over octets, each place of them by itself: so the number of lanes has no influence. Places without a polygon add 0.
struct Sum<'o, I, const N: usize> {
    octets: &'o [Octet],
    integrals: PhantomData<I>,
}

impl<I: Integrals<N>, const N: usize> InLanes for Sum<'_, I, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [f64; N] {
        let mut sums = [[0.0; ROW]; N];
        for octet in self.octets {
            for first in (0..octet.tets().len()).step_by(L::COUNT) {
                let polygons = Polygons::of(lanes, octet, first);
                let integrals = I::of(lanes, &polygons);
                for (sum, integral) in sums.iter_mut().zip(&integrals) {
                    (lanes.load(sum, first) + *integral).store(sum, first);
                }
            }
        }
        sums.map(|[a, b, c, d, e, f, g, h]| ((a + b) + (c + d)) + ((e + f) + (g + h)))
    }
}

/// Sums over the polygons of octets.
fn sum_of<I: Integrals<N>, const N: usize>(octets: &[Octet]) -> [f64; N] {
    let mut total = [0.0; N];
    let piece = |octets: &[Octet]| {
        lanes::run(Sum::<I, N> {
            octets,
            integrals: PhantomData,
        })
    };
    threads::for_pieces(octets, PIECE, piece, |piece| {
        for (total, part) in total.iter_mut().zip(piece) {
            *total += part;
        }
    });
    total
}

impl<T: Scalar> OverOctets for Wrench<T> {
    fn over(octets: &[Octet]) -> Self {
        let [t1, t2, t3, f1, f2, f3] = sum_of::<OfWrench, 6>(octets).map(lift);
        Self {
            torque: Vector3::new(t1, t2, t3),
            force: Vector3::new(f1, f2, f3),
        }
    }
}

impl OverOctets for RelativeJacobian {
    fn over(octets: &[Octet]) -> Self {
        let sums = sum_of::<OfJacobian, JACOBIAN>(octets);
        let (by_motion, pressed) = sums.split_at(MATRIX);
        let [wrench, pressed_a, pressed_b] =
            [0, 6, 12].map(|first| Vector6::from_column_slice(&pressed[first..first + 6]));
        Self {
            wrench,
            by_motion_of_b: Matrix6::from_column_slice(by_motion),
            pressed_a,
            pressed_b,
            // Generic polygons have no kinks.
            ..Self::empty()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::polygon::{CutPolygon, CutSurface};
    use super::super::{
        ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw,
    };
    use super::*;
    use crate::lanes::tests::at_width;
    use crate::mesh::{TriangleSurface, shapes};
    use crate::narrow_phase::{ELASTIC_COINCIDENCE, Weights};
    use crate::spatial::{Pose, Twist};
    use crate::threads::results_of;
    use nalgebra::SVector;

    /// Of sums over thousands of polygons, taken in another order.
    const ROUND_OFF: f64 = 1e-13;

    /// Everything that is computed in lanes, as bits.
    fn bits(pair: &ContactPair) -> Vec<u64> {
        let law = SurfaceLaw::new(0.5, 0.4, 1e-3).unwrap();
        let twist = Twist {
            angular: Vector3::new(1.0, -2.0, 0.7),
            linear: Vector3::new(0.3, 0.1, -0.2),
        };
        let moving = pair.moving(law, [twist, Twist::zero()]);
        let covector = SVector::from_fn(|row, _| (row as f64 + 0.5).sin());
        let linearised = [pair, &moving].map(ContactPair::linearised);
        let shapes = moving.shape_gradients(&covector);
        let vertices = shapes.iter().flat_map(|shape| &shape.by_vertices);
        let extents = shapes.iter().flat_map(|shape| &shape.by_extents);
        let [at_rest, in_motion] = linearised.each_ref().map(|contact| contact.wrench);
        let wrenches = [pair.wrench(), at_rest, moving.wrench(), in_motion];
        let wrenches = wrenches.map(|wrench| wrench.on_a.to_vector());
        let numbers = wrenches.iter().flat_map(|wrench| wrench.iter().copied());
        numbers
            .chain(
                linearised
                    .iter()
                    .flat_map(|contact| contact.jacobian().iter().copied().collect::<Vec<_>>()),
            )
            .chain(vertices.flat_map(|vertex| vertex.iter().copied()))
            .chain(extents.copied())
            .map(f64::to_bits)
            .collect()
    }

    fn assert_same_at_all_widths(pair: &ContactPair, name: &str) {
        let expected = bits(pair);
        for width in [2, 4, 8] {
            // One job, which is not shared out to threads of another width.
            let own = results_of(&[()], |()| at_width(width, || bits(pair)));
            assert!(own[0] == expected, "{name}, {width} lanes");
        }
    }

    /// A generic pose, this far (m) from the origin.
    fn pose(number: usize, distance: f64) -> Pose {
        let angle = |k: f64| (number as f64 * k + 0.3).sin();
        let turn = Vector3::new(angle(1.1), angle(2.3), angle(3.7)) * 2.0;
        let way = Vector3::new(angle(0.7), angle(1.9), 1.5 + angle(2.9)).normalize();
        Pose::from_rotation_vector(&turn, way * distance)
    }

    /// Two balls of so many octets of polygons that their memory is used again.
    fn with_large_contact<O>(check: impl FnOnce(&ContactPair) -> O) -> O {
        let ball = Shape::new(shapes::icosphere(1.0, 3).unwrap());
        let a = ContactBody::new(&ball, pose(1, 0.8), 2e4).unwrap();
        let b = ContactBody::new(&ball, Pose::identity(), 1e4).unwrap();
        let pair = ContactPair::new(a, b);
        assert!(pair.work_count().polygons > 1000);
        check(&pair)
    }

    #[test]
    fn large_contacts_are_summed_as_they_are_found() {
        with_large_contact(|pair| {
            let source = pair.source();
            let (surface, spilled) = source.for_sum_of_values::<Wrench>(pair.search());
            let (all, rest) = (pair.cut_surface().wrench(), surface.wrench());
            let [all, rest, spilled] = [all, rest, spilled].map(|wrench| wrench.to_vector());
            assert!(rest.norm() > 0.0 && spilled.norm() > rest.norm());
            assert!((rest + spilled - all).norm() < ROUND_OFF * all.norm());
            let jacobian = |of: &CutSurface<f64>| {
                let add = |sum: &mut RelativeJacobian, it: &CutPolygon<f64>| it.add_to(sum);
                of.sum_of_moments(Weights::have_area, add).by_motion_of_b
            };
            let octaves = ELASTIC_COINCIDENCE;
            let ((surface, _), spilled) =
                source.for_sum_of_derivatives::<RelativeJacobian>(octaves, pair.search());
            let (all, _) = source.for_derivatives(octaves, pair.search());
            let (all, rest) = (jacobian(&all), jacobian(&surface));
            let close = ROUND_OFF * all.norm();
            assert!((rest + spilled.by_motion_of_b - all).norm() < close && rest.norm() > close);
        });
    }

    #[test]
    fn bits_are_the_same_at_all_widths() {
        with_large_contact(|pair| assert_same_at_all_widths(pair, "large"));
        let ball = Shape::new(shapes::icosphere(1.0, 2).unwrap());
        let block = Shape::new(shapes::cuboid([1.0, 1.2, 0.8]).unwrap());
        let round = TriangleSurface::around(shapes::icosphere(0.9, 2).unwrap().mesh());
        let round = RigidShape::new(round.unwrap());
        let layer = HalfSpace::layer(0.1).unwrap();
        let mut compared = [0; 5];
        for number in 0..40 {
            let distance = 0.4 + 0.03 * number as f64;
            let a = ContactBody::new(&ball, pose(number, distance), 2e4).unwrap();
            let at_origin = |shape| ContactBody::new(shape, Pose::identity(), 1e4).unwrap();
            let partners = [
                ("ball", Partner::from(at_origin(&ball))),
                ("block", Partner::from(at_origin(&block))),
                ("rigid", Partner::rigid(&round, Pose::identity()).unwrap()),
                (
                    "half-space",
                    Partner::rigid_half_space(pose(number, 0.2)).unwrap(),
                ),
                (
                    "layer",
                    Partner::half_space(&layer, pose(number, 0.2), 1e4).unwrap(),
                ),
            ];
            for ((name, partner), compared) in partners.into_iter().zip(&mut compared) {
                let pair = ContactPair::new(a, partner);
                if pair.work_count().polygons > ROW {
                    assert_same_at_all_widths(&pair, name);
                    *compared += 1;
                }
            }
        }
        assert!(compared.iter().all(|&count| count > 10), "{compared:?}");
    }
}
