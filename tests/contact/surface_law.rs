//! The law of moving surfaces on two octahedra: dissipation and friction against integrals over their common square.

use crate::support::octahedra::{HEIGHT, OVERLAP, force, octahedron, poses, stacked, stage};
use crate::support::scenes::{Random, pair};
use crate::support::worlds::{cuboid, icosphere};
use hydroelastic::contact::{
    BodyError, ContactBody, ContactPair, ContactWrench, Shape, SurfaceLaw,
};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Matrix3, SVector, Vector3, Vector6, vector};
use num_dual::{Derivative, DualSVec64};

/// Modulus (Pa) of both bodies. The contact surface is the square |x| + |y| ≤ L at z = 0.
const MODULUS: f64 = 1e5;

/// Rounding error, relative to the largest number of the same kind.
const EXACT: f64 = 1e-12;

/// Slip tolerance (m/s) so large that friction is proportional to the slip, up to round-off. With an equally large coefficient, friction is
/// as strong as the pressure.
const VISCOUS: f64 = 1e8;

/// Dissipation (s/m), friction, slip tolerance (m/s).
const LAW: [f64; 3] = [0.4, 0.3, 0.05];

/// Error of Coulomb's torque with a slip tolerance of 1e-9 m/s and a slip of about 0.5 m/s.
const COULOMB: f64 = 1e-11;

/// A common motion of both bodies, which has no effect.
const COMMON: [f64; 6] = [0.7, -0.2, 0.5, 1.3, 0.4, -0.9];

fn law([dissipation, friction, slip_tolerance]: [f64; 3]) -> SurfaceLaw {
    SurfaceLaw::new(dissipation, friction, slip_tolerance).unwrap()
}

/// Returns F (N).
fn normal_force() -> f64 {
    force([MODULUS; 2])
}

/// Returns the twists, in world axes at the bodies' origins, for a relative spin and velocity of A at the middle of the contact, given on
/// the stage.
fn twists(spin: Vector3<f64>, velocity: Vector3<f64>) -> [Twist; 2] {
    let common = Twist::from_vector(&Vector6::from(COMMON));
    let turn = stage();
    let (spin, velocity) = (turn.rotation() * spin, turn.rotation() * velocity);
    let [a, b] = poses().map(|pose| {
        let from_middle = pose.translation() - turn.translation();
        (from_middle, common.angular.cross(pose.translation()))
    });
    [
        Twist {
            angular: common.angular + spin,
            linear: common.linear + a.1 + velocity + spin.cross(&a.0),
        },
        Twist {
            angular: common.angular,
            linear: common.linear + b.1,
        },
    ]
}

/// Returns the wrench on A about the middle of the contact, on the stage.
fn on_stage(wrench: &ContactWrench) -> Wrench {
    let to_middle = stage().translation() - poses()[0].translation();
    let about_middle = wrench.on_a.about(&to_middle);
    about_middle.rotated(&stage().rotation().transpose())
}

fn wrench(pair: &ContactPair, law: &SurfaceLaw, twists: [Twist; 2]) -> Wrench {
    let wrench = pair.moving(*law, twists).wrench();
    // Newton's third law, about one point.
    let [a, b] = poses().map(|pose| *pose.translation());
    let reaction = wrench.on_b.about(&(a - b));
    let sum = (wrench.on_a.to_vector() + reaction.to_vector()).amax();
    assert!(sum <= EXACT * normal_force(), "{sum:e}");
    on_stage(&wrench)
}

fn assert_near(actual: &Vector3<f64>, expected: &Vector3<f64>, scale: f64) {
    let error = (actual - expected).amax();
    assert!(error <= EXACT * scale, "{actual:?} {expected:?} {error:e}");
}

/// Velocities (m/s) of A relative to B: along and against the normal, tangential, and combined.
const VELOCITIES: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.6],
    [0.0, 0.0, -0.6],
    [0.02, -0.03, 0.0],
    [2.0, 1.0, 0.0],
    [0.04, 0.1, 1.2],
    [-0.7, 0.2, -0.8],
];

/// Returns the force of bodies that slide without rotation: F·(1 − d·v_n)·(n − μ·v_t/√(v_t² + v_s²)).
fn sliding_force([dissipation, friction, tolerance]: [f64; 3], v: Vector3<f64>) -> Vector3<f64> {
    let pressed = normal_force() * (1.0 - dissipation * v.z);
    let slip = vector![v.x, v.y, 0.0];
    let speed = (v.x * v.x + v.y * v.y + tolerance * tolerance).sqrt();
    (Vector3::z() - slip * friction / speed) * pressed
}

#[test]
fn bodies_that_slide_have_the_force_of_the_law_at_one_velocity() {
    let shape = octahedron(0);
    let pair = stacked(&shape, [MODULUS; 2]);
    for velocity in VELOCITIES.map(Vector3::from) {
        let wrench = wrench(&pair, &law(LAW), twists(Vector3::zeros(), velocity));
        assert_near(&wrench.force, &sliding_force(LAW, velocity), normal_force());
        assert_near(&wrench.torque, &Vector3::zeros(), normal_force());
    }
}

#[test]
fn skin_that_is_let_go_faster_than_it_recovers_does_not_pull() {
    let shape = octahedron(0);
    let pair = stacked(&shape, [MODULUS; 2]);
    for speed in [1.0 / LAW[0], 1.01 / LAW[0], 100.0] {
        let wrench = wrench(
            &pair,
            &law(LAW),
            twists(Vector3::zeros(), vector![0.3, 0.1, speed]),
        );
        assert_near(&wrench.force, &Vector3::zeros(), normal_force());
    }
}

/// Slow friction is proportional to the slip, so only the pressure-weighted mean of the slip matters: the slip at the center of pressure.
#[test]
fn slow_friction_of_a_spin_about_an_axis_beside_has_the_slip_of_the_middle() {
    let shape = octahedron(0);
    let pair = stacked(&shape, [MODULUS; 2]);
    let (friction, spin) = (0.3 * VISCOUS, 2.0);
    for axis in [[0.1, 0.0], [-0.05, 0.2], [1.0, -3.0]] {
        // Velocity of the middle if A rotates about a vertical axis through this point.
        let velocity = vector![spin * axis[1], -spin * axis[0], 0.0];
        let moved = twists(vector![0.0, 0.0, spin], velocity);
        let wrench = wrench(&pair, &law([0.0, friction, VISCOUS]), moved);
        let scale = friction * normal_force() / VISCOUS;
        let across = vector![wrench.force.x, wrench.force.y, 0.0];
        assert_near(&across, &(velocity * -scale), scale);
        assert!((wrench.force.z / normal_force() - 1.0).abs() <= EXACT);
    }
}

#[test]
fn spinning_and_rolling_friction_are_their_integrals() {
    let (dissipation, friction, spin) = (0.4, 0.3 * VISCOUS, 1.5);
    // ∫ p x² dA = E·4·∫∫ (L − x − y) x² dx dy over a quarter = E L⁵/15. The integral with y² is equal.
    let integral = MODULUS * OVERLAP.powi(5) / 15.0;
    let rolling = -dissipation * spin * integral;
    let spinning = -friction * spin * 2.0 * integral / VISCOUS;
    for times in 0..3_usize {
        let shape = octahedron(times);
        let pair = stacked(&shape, [MODULUS; 2]);
        let roll = twists(vector![spin, 0.0, 0.0], Vector3::zeros());
        let rolled = wrench(&pair, &law([dissipation, 0.0, 1.0]), roll);
        assert_near(
            &rolled.force,
            &(Vector3::z() * normal_force()),
            normal_force(),
        );
        let turn = twists(vector![0.0, 0.0, spin], Vector3::zeros());
        let turned = wrench(&pair, &law([0.0, friction, VISCOUS]), turn);
        for (actual, expected) in [(rolled.torque.x, rolling), (turned.torque.z, spinning)] {
            let error = (actual / expected - 1.0).abs();
            assert!(error <= EXACT, "{times}: {error:e}");
        }
    }
}

/// Coulomb friction of a spin on the spot, by integration along the radius. The torque is μ ∫ p r dA with p = E (L − |x| − |y|). One
/// quarter is E ∫ r² (L − r c) dr over 0 < r < L/c with c = |cos| + |sin|, which is E L⁴/(12 c³).
#[test]
fn a_spin_on_the_spot_has_coulombs_torque() {
    let shape = octahedron(0);
    let pair = stacked(&shape, [MODULUS; 2]);
    // ∫ (cos + sin)⁻³ over a quarter turn = ½·(1 + ln(1 + √2)/√2).
    let root = 2.0_f64.sqrt();
    let angles = 0.5 * (1.0 + (1.0 + root).ln() / root);
    let expected = -0.3 * 4.0 * MODULUS * OVERLAP.powi(4) / 12.0 * angles;
    let turn = twists(vector![0.0, 0.0, 5.0], Vector3::zeros());
    let actual = wrench(&pair, &law([0.0, 0.3, 1e-9]), turn).torque.z;
    let error = (actual / expected - 1.0).abs();
    assert!(error <= COULOMB, "{error:e}");
}

/// Derivatives with respect to the relative velocity (3 components), dissipation and friction.
type Dual = DualSVec64<5>;

fn variable(value: f64, direction: SVector<f64, 5>) -> Dual {
    Dual::new(value, Derivative::some(direction))
}

fn derivatives(number: Dual) -> SVector<f64, 5> {
    number
        .eps
        .unwrap_generic(nalgebra::Const::<5>, nalgebra::Const::<1>)
}

/// Returns the derivatives of [`sliding_force`] in closed form.
fn sliding_slopes(
    [dissipation, friction, tolerance]: [f64; 3],
    v: Vector3<f64>,
) -> [Vector3<f64>; 5] {
    let damping = 1.0 - dissipation * v.z;
    let slip = vector![v.x, v.y, 0.0];
    let speed = (slip.norm_squared() + tolerance * tolerance).sqrt();
    let pull = Vector3::z() - slip * friction / speed;
    let by_slip = |axis: usize| {
        let bend = slip * (slip[axis] / speed.powi(3));
        (bend - Vector3::ith(axis, 1.0 / speed)) * (friction * damping)
    };
    let slopes = [
        by_slip(0),
        by_slip(1),
        pull * -dissipation,
        pull * -v.z,
        slip * (-damping / speed),
    ];
    slopes.map(|slope| slope * normal_force())
}

/// Returns the wrench with derivatives, from the linearized contact or through the whole pipeline.
fn differentiated(velocity: Vector3<f64>, is_linearized: bool) -> ContactWrench<Dual> {
    let shape = octahedron(0);
    let [a, b] = poses().map(|pose| {
        let modulus = Dual::from_re(MODULUS);
        ContactBody::new(&shape, Pose::lifted(&pose), modulus).unwrap()
    });
    let pair = ContactPair::new(a, b);
    let number = |k| variable(LAW[k - 3], SVector::ith(k, 1.0));
    let law = SurfaceLaw::new(number(3), number(4), LAW[2]).unwrap();
    let directions: Matrix3<f64> = *stage().rotation();
    let twists = twists(Vector3::zeros(), velocity);
    let mut dual = twists.map(|twist| Twist {
        angular: twist.angular.map(Dual::from_re),
        linear: twist.linear.map(Dual::from_re),
    });
    dual[0].linear = Vector3::from_fn(|i, _| {
        let direction = SVector::from_fn(|k, _| if k < 3 { directions[(i, k)] } else { 0.0 });
        variable(twists[0].linear[i], direction)
    });
    if is_linearized {
        pair.moving(law, dual).wrench()
    } else {
        pair.moving(law, dual).pipeline().wrench()
    }
}

#[test]
fn derivatives_by_velocity_and_law_are_the_closed_ones() {
    for velocity in VELOCITIES.map(Vector3::from) {
        let slopes = sliding_slopes(LAW, velocity);
        for is_linearized in [false, true] {
            let wrench = differentiated(velocity, is_linearized);
            for (number, slope) in slopes.iter().enumerate() {
                let part = |vector: &Vector3<Dual>| vector.map(|x| derivatives(x)[number]);
                let to_stage = stage().rotation().transpose();
                // Slow slips are divided by the slip tolerance.
                let scale = normal_force() / LAW[2];
                let force = to_stage * part(&wrench.on_a.force);
                assert_near(&force, slope, scale);
                // The force acts at the middle of the contact, which is as far below A's origin as above B's. The force on B is opposite,
                // so both torques are equal.
                let arm = Vector3::z() * -HEIGHT;
                for torque in [&wrench.on_a.torque, &wrench.on_b.torque] {
                    assert_near(&(to_stage * part(torque)), &arm.cross(slope), scale);
                }
            }
        }
    }
}

#[test]
fn parting_faster_than_the_skin_recovers_has_no_derivatives() {
    for is_linearized in [false, true] {
        let wrench = differentiated(vector![0.3, 0.1, 3.0], is_linearized);
        for number in wrench.on_a.force.iter().chain(&wrench.on_a.torque) {
            assert!(derivatives(*number).amax() <= 0.0);
        }
    }
}

#[test]
fn a_law_tells_the_numbers_that_it_was_made_of() {
    let law = law(LAW);
    let numbers = [law.dissipation(), law.friction(), law.slip_tolerance()];
    assert_eq!(numbers.map(f64::to_bits), LAW.map(f64::to_bits));
}

#[test]
fn numbers_out_of_range_make_no_law() {
    let quantity = |numbers: [f64; 3]| match SurfaceLaw::new(numbers[0], numbers[1], numbers[2]) {
        Err(BodyError::SurfaceLaw { quantity, .. }) => quantity,
        part => panic!("{part:?}"),
    };
    for bad in [-1e-300, f64::NAN, f64::INFINITY] {
        assert_eq!(quantity([bad, 0.3, 0.1]), "dissipation");
        assert_eq!(quantity([0.4, bad, 0.1]), "friction");
        assert_eq!(quantity([0.4, 0.3, bad]), "slip tolerance");
    }
    for bad in [0.0, 0.9e-100, 1.1e100] {
        assert_eq!(quantity([0.4, 0.3, bad]), "slip tolerance");
    }
    assert_eq!(
        SurfaceLaw::new(-1.0, 0.3, 0.1).unwrap_err().to_string(),
        "the dissipation of a surface law is -1, but dissipation and friction must be finite and not negative, and the slip \
         tolerance must be from 1e-100 to 1e100 m/s"
    );
}

#[test]
fn friction_depends_on_slip_over_slip_tolerance_alone_however_small_or_large() {
    let ball = icosphere(0.1, 2);
    let block = cuboid([0.4, 0.4, 0.2]);
    let at = Pose::from_translation(vector![0.01, 0.02, 0.195]);
    let a = ContactBody::new(&ball, at, 1e5).unwrap();
    let b = ContactBody::new(&block, Pose::identity(), 1e6).unwrap();
    let pair = ContactPair::new(a, b);
    let sliding = |slip_tolerance: f64, ratio: f64| {
        let law = SurfaceLaw::new(0.0, 0.5, slip_tolerance).unwrap();
        let mut twist = Twist::zero();
        twist.linear.x = ratio * slip_tolerance;
        let linearized = pair.moving(law, [twist, Twist::zero()]).linearized();
        assert!(linearized.jacobian().iter().all(|entry| entry.is_finite()));
        pair.moving(law, [twist, Twist::zero()]).wrench().on_a
    };
    for ratio in [0.0, 1e-20, 0.7, 1e20] {
        let expected = sliding(1.0, ratio).to_vector();
        for slip_tolerance in [1e-100, 1e-50, 1e50, 1e100] {
            let actual = sliding(slip_tolerance, ratio).to_vector();
            assert!((actual - expected).amax() <= EXACT * expected.amax());
        }
    }
}

/// Agreement of two methods for the same sums.
const SAME: f64 = 1e-10;

/// The exchanged pair has the same polygons with other first corners, in units of meters or of half millimeters.
#[test]
fn friction_does_not_depend_on_where_a_polygon_begins() {
    let law = SurfaceLaw::new(0.1, 0.4, 0.05).unwrap();
    for size in [1.0, 5e-4] {
        let mut random = Random::new(83);
        let shapes = [
            shapes::icosphere(size, 1),
            shapes::cuboid([size, 1.5 * size, size]),
        ]
        .map(|field| Shape::new(field.unwrap()));
        for number in 0..60 {
            let turn = random.rotation_vector();
            let apart = random.direction() * size * random.between(0.3, 1.0);
            let pair = pair(
                (
                    &shapes[number % 2],
                    Pose::from_rotation_vector(&turn, apart),
                    1.0,
                ),
                (&shapes[number / 2 % 2], Pose::identity(), 3.0),
            );
            let exchanged = ContactPair::new(pair.b().body().unwrap(), *pair.a());
            let twists = [1.0, -0.7].map(|sign| Twist {
                angular: vector![0.3, -0.2, 0.5] * sign / size,
                linear: vector![0.02, 0.1, -0.05] * sign,
            });
            let force = pair.moving(law, twists).wrench().on_a.force;
            let exchanged_wrench = exchanged.moving(law, [twists[1], twists[0]]).wrench();
            let error = (force - exchanged_wrench.on_b.force).norm();
            assert!(force.norm() > 0.0);
            assert!(error <= SAME * force.norm(), "{error:e} {:e}", force.norm());
        }
    }
}
