//! The wrench of an elastic contact and its derivatives, from the planes and moments of polygons.

use super::integrate::{Integrand, Remainder};
use super::jacobian::RelativeJacobian;
use super::plane_polygon::PlanePolygon;
use super::polygon_fields::{PolygonFields, Six};
use super::polygon_source::PolygonSource;
use super::response::{PolygonResponse, Responses};
use super::sums::PartialSum;
use crate::geometry::set_bits;
use crate::lanes::space::{cross, scaled, sum};
use crate::lanes::{self, InLanes, Lanes, Linear, Numbers, ROW};
use crate::narrow_phase::{Cut, Octet, Weights};
use crate::scalar::{Scalar, lift};
use crate::search::GenericPairs;
use crate::spatial::Wrench;
use nalgebra::{Matrix6, Vector3, Vector6};
use std::marker::PhantomData;

/// Number of entries of a 6×6 matrix.
const MATRIX: usize = 36;

/// Number of entries of a [`RelativeJacobian`]: a matrix and three wrenches.
const JACOBIAN: usize = MATRIX + 3 * 6;

/// Number of octets that are integrated in one thread: about 20 µs of work.
const OCTETS: usize = 256;

/// `K` integrals that follow from the plane and the moments of a polygon.
trait Integrals<const K: usize> {
    /// Computes the integrals over the whole polygon, without its weights.
    fn of<N: Linear>(polygon: &PolygonFields<N>) -> [N; K];
}

/// The wrench on A about A's origin: torque, force.
struct OfWrench;

/// The numbers of a [`RelativeJacobian`]: `by_motion_of_b` column by column, `wrench`, `pressed_a`, `pressed_b`.
struct OfJacobian;

impl<N: Linear> PolygonFields<N> {
    /// Returns ∫ p dA and ∫ p x dA.
    #[inline(always)]
    fn pressure_integrals(&self) -> (N, [N; 3]) {
        let [p0, p1, p2] = self.pressure;
        let [area, y1, y2, y11, y12, y22] = self.moments;
        let total = p0 * area + p1 * y1 + p2 * y2;
        let by_y1 = p0 * y1 + p1 * y11 + p2 * y12;
        let by_y2 = p0 * y2 + p1 * y12 + p2 * y22;
        (total, self.first_moment(total, [by_y1, by_y2]))
    }

    /// Returns ∫ p x dA with x from A's origin, from ∫ p dA, ∫ p y₁ dA and ∫ p y₂ dA.
    #[inline(always)]
    fn first_moment(&self, total: N, [by_y1, by_y2]: [N; 2]) -> [N; 3] {
        let [e1, e2, _] = self.axes;
        let in_plane = sum(scaled(e1, by_y1), scaled(e2, by_y2));
        sum(scaled(self.origin, total), in_plane)
    }
}

impl Integrals<6> for OfWrench {
    #[inline(always)]
    fn of<N: Linear>(polygon: &PolygonFields<N>) -> [N; 6] {
        let (total, weighted) = polygon.pressure_integrals();
        wrench_of(total, weighted, polygon.axes[2])
    }
}

/// Returns the wrench of a load along a direction, from its total and first moment.
#[inline(always)]
fn wrench_of<N: Linear>(total: N, weighted: [N; 3], direction: [N; 3]) -> Six<N> {
    let [t1, t2, t3] = cross(weighted, direction);
    let [f1, f2, f3] = scaled(direction, total);
    [t1, t2, t3, f1, f2, f3]
}

impl Integrals<JACOBIAN> for OfJacobian {
    #[inline(always)]
    fn of<N: Linear>(polygon: &PolygonFields<N>) -> [N; JACOBIAN] {
        let (a, [slope_a, slope_b]) = (polygon.gradient_a, polygon.slopes);
        let (origin, [e1, e2, normal]) = (polygon.origin, polygon.axes);
        let [area, y1, y2, y11, y12, y22] = polygon.moments;
        let from_origin = sum(scaled(e1, y1), scaled(e2, y2));
        let first = sum(scaled(origin, area), from_origin);
        // ∫ x y₁ dA and ∫ x y₂ dA.
        let by_y1 = sum(scaled(origin, y1), sum(scaled(e1, y11), scaled(e2, y12)));
        let by_y2 = sum(scaled(origin, y2), sum(scaled(e1, y12), scaled(e2, y22)));
        let (arm_a, arm_b) = (cross(first, a), cross(first, slope_b));
        // ∫ (x × a)(x × b)ᵀ dA, where b is the slope of B. With x = origin + e₁y₁ + e₂y₂ in the second factor, it is the sum over 1, y₁ and
        // y₂ of ∫ (x × a) y dA times the corresponding part of x × b.
        let in_second = [
            cross(origin, slope_b),
            cross(e1, slope_b),
            cross(e2, slope_b),
        ];
        let by_second = [arm_a, cross(by_y1, a), cross(by_y2, a)];
        // All entries are overwritten below.
        let mut sums = [area; JACOBIAN];
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
        let (total, weighted) = polygon.pressure_integrals();
        let directions = [normal, slope_a, slope_b];
        for (number, direction) in directions.into_iter().enumerate() {
            let wrench = wrench_of(total, weighted, direction);
            for (row, entry) in wrench.into_iter().enumerate() {
                sums[MATRIX + 6 * number + row] = entry;
            }
        }
        sums
    }
}

/// Sums over octets. Each place in an octet has its own sum, so the number of lanes has no influence. Places without a polygon add 0.
struct OverOctets<'o, I, const K: usize> {
    octets: &'o [Octet],
    integrals: PhantomData<I>,
}

impl<I: Integrals<K>, const K: usize> InLanes for OverOctets<'_, I, K> {
    type Output = [f64; K];

    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) -> [f64; K] {
        let mut sums = [[0.0; ROW]; K];
        for octet in self.octets {
            for first in (0..octet.tets().len()).step_by(L::COUNT) {
                let integrals = I::of(&PolygonFields::loaded(lanes, octet, first));
                for (sum, integral) in sums.iter_mut().zip(&integrals) {
                    (lanes.load(sum, first) + *integral).store(sum, first);
                }
            }
        }
        lanes::totals(&sums)
    }
}

fn over_octets<I: Integrals<K>, const K: usize>(octets: &[Octet]) -> [f64; K] {
    lanes::run(OverOctets::<I, K> {
        octets,
        integrals: PhantomData,
    })
}

impl<T: Scalar> PolygonFields<T> {
    /// Returns the elastic wrench on A in A's axes about A's origin, multiplied by a weight.
    pub fn elastic_wrench(&self, weight: T) -> Wrench<T> {
        let wrench = OfWrench::of(self).map(|entry| entry * weight);
        Wrench::from_vector(&Vector6::from(wrench))
    }

    /// Returns the elastic wrench on A of a part of the plane in A's axes about A's origin, from ∫ p dA, ∫ p y₁ dA and ∫ p y₂ dA.
    pub fn wrench_of_load(&self, total: T, by_y: [T; 2]) -> Wrench<T> {
        let [e1, e2, normal] = self.axes.map(Vector3::from);
        let [by_y1, by_y2] = by_y;
        Wrench {
            // e₁ × n = −e₂ and e₂ × n = e₁.
            torque: Vector3::from(self.origin).cross(&normal) * total + e1 * by_y2 - e2 * by_y1,
            force: normal * total,
        }
    }
}

impl<T: Scalar> PlanePolygon<T> {
    /// Returns ∫ p dA (N), multiplied by the weight of the polygon in values (`Weights::still`).
    pub fn load(&self) -> T {
        let (total, _) = self.plane.pressure_integrals();
        total * self.weights.still.area()
    }

    /// Returns the elastic wrench on A in A's axes about A's origin, multiplied by the weight of the polygon in values.
    pub fn elastic_wrench(&self) -> Wrench<T> {
        self.plane.elastic_wrench(lift(self.weights.still.area()))
    }
}

/// The wrench of an elastic contact on A, in A's axes about A's origin.
pub(super) struct ElasticWrench;

impl<T: Scalar> Integrand<T> for ElasticWrench {
    type Sum = Wrench<T>;

    const IS_SPILLED: bool = true;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<T>, cut: &Cut, sum: &mut Wrench<T>) {
        if let Some(polygon) = source.counted_polygon(cut, Weights::has_still_area) {
            *sum += polygon.elastic_wrench();
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<T>,
        generic: GenericPairs,
        _: &mut Remainder,
        sum: &mut Wrench<T>,
    ) {
        let wrench = over_octets::<OfWrench, 6>(generic.octets).map(lift::<T>);
        *sum += Wrench::from_vector(&Vector6::from(wrench));
    }
}

/// The wrench of an elastic contact and its derivatives, and the responses of its polygons if `R` keeps them.
pub(super) struct ElasticJacobian<R>(PhantomData<fn() -> R>);

impl<R> ElasticJacobian<R> {
    pub fn new() -> Self {
        Self(PhantomData)
    }
}

impl<R: Responses> Integrand<f64> for ElasticJacobian<R> {
    type Sum = (RelativeJacobian, R);

    const IS_SPILLED: bool = true;

    const OCTETS: usize = OCTETS;

    fn add(&self, source: &PolygonSource<f64>, cut: &Cut, (sum, responses): &mut Self::Sum) {
        if let Some(polygon) = source.counted_polygon(cut, Weights::have_area) {
            sum.add(&polygon);
            responses.keep(|| PolygonResponse::of(cut.tets, &polygon));
        }
    }

    fn add_octets(
        &self,
        _: &PolygonSource<f64>,
        generic: GenericPairs,
        _: &mut Remainder,
        (sum, responses): &mut Self::Sum,
    ) {
        sum.add_octets(generic.octets);
        if R::ARE_KEPT {
            for octet in generic.octets {
                for index in set_bits(octet.polygons()) {
                    responses.keep(|| PolygonResponse::at(octet, index));
                }
            }
        }
    }
}

impl RelativeJacobian {
    /// Adds a polygon.
    pub fn add(&mut self, polygon: &PlanePolygon<f64>) {
        let Weights { still, moving } = polygon.weights;
        let mut sums = OfJacobian::of(&polygon.plane);
        let (by_motion, pressed) = sums.split_at_mut(MATRIX);
        for sum in by_motion {
            *sum *= moving.area();
        }
        for sum in pressed {
            *sum *= still.area();
        }
        self.merge(Self::from_numbers(&sums));
        self.kinks.are_flush |= polygon.is_flush();
    }

    /// Adds generic polygons, which have no kinks.
    pub fn add_octets(&mut self, octets: &[Octet]) {
        self.merge(Self::from_numbers(&over_octets::<OfJacobian, JACOBIAN>(
            octets,
        )));
    }

    fn from_numbers(numbers: &[f64; JACOBIAN]) -> Self {
        let (by_motion, pressed) = numbers.split_at(MATRIX);
        let [wrench, pressed_a, pressed_b] =
            [0, 6, 12].map(|first| Vector6::from_column_slice(&pressed[first..first + 6]));
        Self {
            wrench,
            by_motion_of_b: Matrix6::from_column_slice(by_motion),
            pressed_a,
            pressed_b,
            ..Self::empty()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{
        ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, SurfaceLaw,
    };
    use super::*;
    use crate::lanes::tests::at_width;
    use crate::mesh::{TriangleSurface, shapes};
    use crate::narrow_phase::ELASTIC_COINCIDENCE;
    use crate::parallel;
    use crate::spatial::{Pose, Twist};
    use nalgebra::{SVector, Vector3};

    /// Round-off of sums over thousands of polygons in another order.
    const ROUND_OFF: f64 = 1e-13;

    /// Returns all results that are computed in lanes, as bits.
    fn bits(pair: &ContactPair) -> Vec<u64> {
        let law = SurfaceLaw::new(0.5, 0.4, 1e-3).unwrap();
        let twist = Twist {
            angular: Vector3::new(1.0, -2.0, 0.7),
            linear: Vector3::new(0.3, 0.1, -0.2),
        };
        let moving = pair.moving(law, [twist, Twist::zero()]);
        let covector = SVector::from_fn(|row, _| (row as f64 + 0.5).sin());
        let linearized = [pair, &moving].map(ContactPair::linearized);
        let shapes = moving.shape_gradients(&covector);
        let vertices = shapes.iter().flat_map(|shape| &shape.by_vertices);
        let extents = shapes.iter().flat_map(|shape| &shape.by_extents);
        let [at_rest, in_motion] = linearized.each_ref().map(|contact| contact.wrench);
        let wrenches = [pair.wrench(), at_rest, moving.wrench(), in_motion];
        let wrenches = wrenches.map(|wrench| wrench.on_a.to_vector());
        let numbers = wrenches.iter().flat_map(|wrench| wrench.iter().copied());
        let frozen = moving.frozen().map(|frozen| {
            let (motion, twist) = (
                Vector6::repeat(1e-3),
                Vector6::new(0.9, -1.8, 0.6, 0.3, 0.2, 0.1),
            );
            let added = frozen.added(&motion, &twist);
            let matrices = added.by_motion.iter().chain(&added.by_twist);
            let wrench = added.wrench.iter();
            wrench.chain(matrices).copied().collect::<Vec<_>>()
        });
        numbers
            .chain(frozen.into_iter().flatten())
            .chain(
                linearized
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
            // There is one job, so no thread with another number of lanes takes part.
            let actual = parallel::map(&[()], |()| at_width(width, || bits(pair)));
            assert!(actual[0] == expected, "{name}, {width} lanes");
        }
    }

    /// Returns a generic pose at this distance (m) from the origin.
    fn pose(number: usize, distance: f64) -> Pose {
        let angle = |k: f64| (number as f64 * k + 0.3).sin();
        let turn = Vector3::new(angle(1.1), angle(2.3), angle(3.7)) * 2.0;
        let direction = Vector3::new(angle(0.7), angle(1.9), 1.5 + angle(2.9)).normalize();
        Pose::from_rotation_vector(&turn, direction * distance)
    }

    /// Calls `check` with two balls. Their contact has so many octets of polygons that memory is used again.
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
            let (source, search) = (pair.source(), pair.search());
            let (rest, spilled) = source.integrated_within(0, search, &ElasticWrench);
            let (all, spilled) = (pair.cut_surface(), spilled.unwrap());
            let [all, rest] = [all, rest].map(|surface| surface.integral(&ElasticWrench));
            let [all, rest, spilled] = [all, rest, spilled].map(|wrench| wrench.to_vector());
            assert!(rest.norm() > 0.0 && spilled.norm() > rest.norm());
            assert!((rest + spilled - all).norm() < ROUND_OFF * all.norm());
            let integrand = ElasticJacobian::<()>::new();
            let ((sum, ()), (rest, _)) =
                source.integral_for_derivatives(ELASTIC_COINCIDENCE, search, &integrand);
            let (all, _) = source.for_derivatives(ELASTIC_COINCIDENCE, search);
            let [all, rest] = [all, rest].map(|of| of.integral(&integrand).0.by_motion_of_b);
            let close = ROUND_OFF * all.norm();
            assert!((sum.by_motion_of_b - all).norm() < close && (rest - all).norm() > close);
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
