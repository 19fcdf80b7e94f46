//! Coulomb friction of flat bodies that slide and spin. The polygons are large, and the direction of slip varies within a polygon.

use crate::support::scenes::pair;
use crate::support::worlds::{cuboid, turned};
use hydroelastic::contact::{ContactPair, Shape, SurfaceLaw};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Vector3, vector};

/// Coefficient of friction.
const FRICTION: f64 = 0.5;

/// Rounding error of sums over large polygons, relative to μ times the normal force.
const ROUND_OFF: f64 = 1e-12;

/// Error of the subdivision below, relative to μ times the normal force.
const SUBDIVIDED: f64 = 1e-12;

/// Nodes and weights of Gauss–Legendre quadrature on [0, 1].
const GAUSS: [[f64; 2]; 5] = [
    [0.046_910_077_030_668, 0.118_463_442_528_094_54],
    [0.230_765_344_947_158_45, 0.239_314_335_249_683_23],
    [0.5, 0.284_444_444_444_444_44],
    [0.769_234_655_052_841_5, 0.239_314_335_249_683_23],
    [0.953_089_922_969_332, 0.118_463_442_528_094_54],
];

/// Agreement of a triangle with its halves, relative to the whole, and largest number of bisections: of triangles without a kink, and of
/// triangles with a kink.
const AGREEMENT: f64 = 1e-14;
const DEPTH: usize = 60;
const KINK_DEPTH: usize = 26;

/// Integral of a force density (N/m²) and of its moment over triangles, by bisection.
struct Subdivision<'a> {
    density: &'a dyn Fn(&Vector3<f64>) -> Vector3<f64>,
    /// An affine function. The density may have a kink at its zeros.
    kink: &'a dyn Fn(&Vector3<f64>) -> f64,
    scale: f64,
}

impl Subdivision<'_> {
    fn rule(&self, [first, second, third]: &[Vector3<f64>; 3]) -> Wrench {
        let (along, across) = (second - first, third - second);
        let twice_area = along.cross(&across).norm();
        let mut sum = Wrench::zero();
        for [s, weight_s] in GAUSS {
            for [t, weight_t] in GAUSS {
                let point = first + along * s + across * (s * t);
                let force = (self.density)(&point) * (twice_area * s * weight_s * weight_t);
                sum += Wrench {
                    torque: point.cross(&force),
                    force,
                };
            }
        }
        sum
    }

    fn integral(&self, triangle: &[Vector3<f64>; 3], whole: Wrench, depth: usize) -> Wrench {
        let [a, b, c] = *triangle;
        let longest = (0..3).max_by(|&i, &j| {
            let length = |k: usize| (triangle[(k + 1) % 3] - triangle[k]).norm();
            length(i).total_cmp(&length(j))
        });
        let [from, to, apex] = match longest {
            Some(0) => [a, b, c],
            Some(1) => [b, c, a],
            _ => [c, a, b],
        };
        let middle = (from + to) / 2.0;
        let halves = [[from, middle, apex], [middle, to, apex]];
        let parts = halves.map(|half| self.rule(&half));
        let mut sum = parts[0];
        sum += parts[1];
        let sides = triangle.map(|corner| (self.kink)(&corner) > 0.0);
        let is_smooth = sides[0] == sides[1] && sides[1] == sides[2];
        let is_exact = (sum.to_vector() - whole.to_vector()).amax() <= AGREEMENT * self.scale;
        let is_deep = depth >= if is_smooth { DEPTH } else { KINK_DEPTH };
        if is_deep || (is_smooth && is_exact) {
            return sum;
        }
        let mut sum = self.integral(&halves[0], parts[0], depth + 1);
        sum += self.integral(&halves[1], parts[1], depth + 1);
        sum
    }
}

/// Integrates the traction over a planar contact surface, and returns the wrench about the origin of the world.
fn integrated(pair: &ContactPair, law: [f64; 3], motion: &Twist) -> Wrench {
    let [dissipation, friction, slip_tolerance] = law;
    let surface = pair.surface();
    let scale = surface
        .polygons
        .iter()
        .map(|p| p.pressure * p.area)
        .sum::<f64>();
    let mut sum = Wrench::zero();
    for polygon in &surface.polygons {
        let kink = |x: &Vector3<f64>| {
            let velocity = motion.linear + motion.angular.cross(x);
            1.0 - dissipation * velocity.dot(&polygon.normal)
        };
        let density = |x: &Vector3<f64>| {
            let velocity = motion.linear + motion.angular.cross(x);
            let parting = velocity.dot(&polygon.normal);
            let slip = velocity - polygon.normal * parting;
            let pressure =
                polygon.pressure + polygon.pressure_gradient.dot(&(x - polygon.centroid));
            let pressed = pressure * kink(x).max(0.0);
            let sigma = (slip.norm_squared() + slip_tolerance * slip_tolerance).sqrt();
            (polygon.normal - slip * (friction / sigma)) * pressed
        };
        let subdivision = Subdivision {
            density: &density,
            kink: &kink,
            scale,
        };
        let corners = polygon.outline.corners();
        for ends in corners[1..].windows(2) {
            let triangle = [corners[0], ends[0], ends[1]];
            sum += subdivision.integral(&triangle, subdivision.rule(&triangle), 0);
        }
    }
    sum
}

const SIZE: [f64; 3] = [0.2, 0.2, 0.04];

/// Returns the pose of the brick, rotated and beside the floor's middle.
fn place() -> Pose {
    turned([0.0, 0.0, 0.3], [0.3, 0.2, 0.2198])
}

fn bricks() -> [PressureField; 2] {
    [shapes::cuboid(SIZE), shapes::distance_cuboid(SIZE)].map(Result::unwrap)
}

fn floor() -> Shape {
    cuboid([4.0, 4.0, 0.4])
}

#[test]
fn a_brick_that_spins_about_its_own_middle_is_not_pushed_sideways() {
    let floor = floor();
    for brick in bricks().map(Shape::new) {
        let pair = pair((&brick, place(), 5e4), (&floor, Pose::identity(), 1e7));
        let law = SurfaceLaw::new(0.0, FRICTION, 1e-3).unwrap();
        let spin = Twist {
            angular: vector![0.0, 0.0, 10.0],
            linear: Vector3::zeros(),
        };
        let force = pair.moving(law, [spin, Twist::zero()]).wrench().on_a.force;
        let sideways = force.xy().norm() / (FRICTION * force.z);
        println!("sideways {sideways:.1e}");
        assert!(sideways <= ROUND_OFF, "{sideways:e}");
    }
}

/// Returns the motion (about the world's origin) of a brick that spins (rad/s) about a vertical axis at this distance (m) from its middle.
fn spin_about(spin: f64, aside: f64, tilt: f64) -> Twist {
    let angular = vector![0.0, tilt, spin];
    let axis = place().translation() + vector![0.6 * aside, -0.8 * aside, 0.0];
    Twist {
        angular,
        linear: -angular.cross(&axis),
    }
}

/// Returns the error of the wrench of a brick on a floor, relative to μ (at least 1) times the normal force. Torques are divided by half
/// the brick's edge.
fn integral_error(brick: &Shape, law: [f64; 3], motion: &Twist) -> f64 {
    let floor = floor();
    let pair = pair((brick, place(), 5e4), (&floor, Pose::identity(), 1e7));
    let origin = *place().translation();
    let at_origin = Twist {
        linear: motion.linear + motion.angular.cross(&origin),
        ..*motion
    };
    let [dissipation, friction, slip_tolerance] = law;
    let surface_law = SurfaceLaw::new(dissipation, friction, slip_tolerance).unwrap();
    let found = pair
        .moving(surface_law, [at_origin, Twist::zero()])
        .wrench()
        .on_a;
    let expected = integrated(&pair, law, motion).about(&origin);
    let scale = pair.wrench().on_a.force.norm() * friction.max(1.0);
    let [force, torque] = [found.force - expected.force, found.torque - expected.torque];
    (force.norm() / scale).max(torque.norm() / (0.5 * SIZE[0] * scale))
}

#[test]
fn coulombs_friction_over_polygons_equals_their_fine_subdivision() {
    let mut worst = 0.0_f64;
    for brick in bricks().map(Shape::new) {
        for slip_tolerance in [1e-6, 1e-4, 1e-2, 1e-1] {
            // Motions from spinning on the spot to pure sliding at 1 m/s.
            for (spin, aside) in [
                (10.0, 0.0),
                (10.0, 0.03),
                (10.0, 0.12),
                (2.0, 0.5),
                (0.1, 10.0),
                (1e-4, 1e4),
            ] {
                let error = integral_error(
                    &brick,
                    [0.0, FRICTION, slip_tolerance],
                    &spin_about(spin, aside, 0.0),
                );
                worst = worst.max(error);
            }
        }
    }
    println!("worst {worst:.1e}");
    assert!(worst <= SUBDIVIDED, "{worst:e}");
}

/// Error from triangles of 2⁻¹³ of a polygon in which the integrand has a kink.
const CLAMPED: f64 = 2e-12;

/// d = 2, and the brick tips so fast that a part of it separates.
#[test]
fn the_clamp_of_dissipation_inside_a_polygon_is_exact() {
    let mut worst = 0.0_f64;
    for brick in bricks().map(Shape::new) {
        for slip_tolerance in [1e-3, 1e-1] {
            for aside in [0.0, 0.05] {
                let error = integral_error(
                    &brick,
                    [2.0, FRICTION, slip_tolerance],
                    &spin_about(3.0, aside, 10.0),
                );
                worst = worst.max(error);
            }
        }
    }
    println!("worst at a clamp {worst:.1e}");
    assert!(worst <= CLAMPED, "{worst:e}");
}
