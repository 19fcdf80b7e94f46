//! Cubes and balls on half-spaces, against integrals in closed form.
//!
//! A cube of edge a with pressure E at its center has the pressure gradient κ = 2E/a. Pressed flat into a rigid plane by x, its force is F
//! = κ(a²x − 2ax² + 4x³/3). Pressed in by d on its edge, the force is κ(ad²/√2 − d³/3), and on its corner κd³/2.

use super::rigid;
use crate::support::worlds::{at, cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, Shape};
use hydroelastic::spatial::Pose;
use nalgebra::{Rotation3, UnitVector3, Vector3, Vector6, vector};

/// Rounding error of a sum of about twenty polygons.
const EXACT: f64 = 1e-12;

const EDGE: f64 = 0.2;
const MODULUS: f64 = 1e6;

/// Returns the upward force, its derivative with respect to depth, and its derivatives with respect to both moduli times the moduli.
fn force(a: &Shape, pose: Pose, b: Partner) -> [f64; 4] {
    let pair = ContactPair::new(ContactBody::new(a, pose, MODULUS).unwrap(), b);
    let contact = pair.linearized();
    [
        contact.wrench.on_a.force.z,
        -contact.by_poses[(5, 5)],
        contact.by_moduli[(5, 0)] * MODULUS,
        contact.by_moduli[(5, 1)] * b.modulus().unwrap_or(1.0),
    ]
}

fn assert_close(name: &str, actual: f64, expected: f64) {
    let error = (actual - expected).abs() / expected.abs();
    assert!(
        error <= EXACT,
        "{name}: {actual}, not {expected}: {error:e}"
    );
}

fn cube() -> Shape {
    cuboid([EDGE; 3])
}

/// Returns the pose at which the lowest of the given points of a rotated body is at this depth below z = 0.
fn at_depth(rotation: &Rotation3<f64>, lowest: Vector3<f64>, depth: f64) -> Pose {
    let height = -depth - (rotation * lowest).z;
    Pose::from_rotation_vector(&rotation.scaled_axis(), vector![0.03, -0.02, height])
}

fn turned_down(direction: Vector3<f64>) -> Rotation3<f64> {
    let direction = UnitVector3::new_normalize(direction);
    Rotation3::rotation_between(&direction, &-Vector3::z_axis()).unwrap()
}

/// Checks the plane z = 0 as a half-space and as the upper side of a rigid slab, whose triangles cut those of the cube.
fn for_rigid_planes(check: impl Fn(&str, Partner)) {
    check(
        "half-space",
        Partner::rigid_half_space(Pose::identity()).unwrap(),
    );
    let slab = rigid(&cuboid([1.0; 3]));
    let below = at(0.07, -0.11, -0.5);
    check("slab", Partner::rigid(&slab, below).unwrap());
}

#[test]
fn a_cube_lies_flat_on_a_rigid_plane() {
    let cube = cube();
    for_rigid_planes(|name, plane| {
        for (depth, force_up, stiffness) in [
            (0.01, 3_613.333_333_333_333, 324_000.0),
            (0.03, 8760.0, 196_000.0),
            (0.07, 12_973.333_333_333_33, 36_000.0),
        ] {
            let pose = at_depth(&Rotation3::identity(), Vector3::z() * (-EDGE / 2.0), depth);
            let [force, slope, by_modulus, by_nothing] = force(&cube, pose, plane);
            assert_close(name, force, force_up);
            assert_close(name, slope, stiffness);
            assert_close(name, by_modulus, force_up);
            assert!(by_nothing.abs() <= 0.0);
        }
    });
}

#[test]
fn a_cube_stands_on_its_edge() {
    let (cube, corner) = (cube(), vector![0.0, EDGE / 2.0, EDGE / 2.0]);
    let pose = at_depth(&turned_down(corner), corner, 0.02);
    for_rigid_planes(|name, plane| {
        let [force, slope, ..] = force(&cube, pose, plane);
        let kappa = 2.0 * MODULUS / EDGE;
        let expected = kappa * (EDGE * 0.02_f64.powi(2) / 2.0_f64.sqrt() - 0.02_f64.powi(3) / 3.0);
        assert_close(name, expected, 539.018_758_283);
        assert_close(name, force, expected);
        let expected = kappa * (2.0_f64.sqrt() * EDGE * 0.02 - 0.02_f64.powi(2));
        assert_close(name, slope, expected);
    });
}

#[test]
fn a_cube_stands_on_its_corner() {
    let (cube, corner) = (cube(), Vector3::repeat(EDGE / 2.0));
    let pose = at_depth(&turned_down(corner), corner, 0.02);
    for_rigid_planes(|name, plane| {
        let [force, slope, ..] = force(&cube, pose, plane);
        assert_close(name, force, 40.0);
        assert_close(name, slope, 6000.0);
    });
}

#[test]
fn a_cube_lies_flat_on_a_soft_layer() {
    let cube = cube();
    // The pressure gradient is 6e6 Pa/m.
    let layer = HalfSpace::layer(0.05).unwrap();
    let floor = Partner::half_space(&layer, Pose::identity(), 3e5).unwrap();
    for (depth, expected) in [
        (
            0.01,
            [
                1_444.453_125,
                138_960.937_5,
                575.947_265_625,
                868.505_859_375,
            ],
        ),
        (
            0.03,
            [
                4_012.734_375,
                118_148.437_5,
                1_797.451_171_875,
                2_215.283_203_125,
            ],
        ),
    ] {
        let pose = at_depth(&Rotation3::identity(), Vector3::z() * (-EDGE / 2.0), depth);
        let forces = force(&cube, pose, floor);
        for (actual, expected) in forces.into_iter().zip(expected) {
            assert_close("layer", actual, expected);
        }
    }
}

/// Rounding error of numbers with six digits.
const PRINTED: f64 = 1e-6;

/// Inscribed polyhedra are smaller than a ball, and the error is proportional to the square of the edges. The reference errors come from
/// sums over 1200² vertical lines through the polyhedra, on each of which p_A = p_B has a root in closed form.
#[test]
fn balls_push_as_their_integral_says() {
    // p = E(1 − r/R) with R = E = 1, pressed in by 0.1.
    let rigid = 0.029_321_531_433_5;
    let soft = 0.014_922_565_104_6;
    let layer = HalfSpace::layer(1.0).unwrap();
    let mut before = [f64::INFINITY; 2];
    for (order, known) in [
        (1, [-0.694_151, -0.699_517]),
        (2, [-0.213_903, -0.219_848]),
        (3, [-0.056_142, -0.058_074]),
    ] {
        let ball = icosphere(1.0, order);
        let pose = at(0.0, 0.0, 0.9);
        let body = ContactBody::new(&ball, pose, 1.0).unwrap();
        let on = |plane: Partner| ContactPair::new(body, plane).wrench().on_a.force.z;
        let errors = [
            on(Partner::rigid_half_space(Pose::identity()).unwrap()) / rigid - 1.0,
            on(Partner::half_space(&layer, Pose::identity(), 1.0).unwrap()) / soft - 1.0,
        ];
        println!("order {order}: {errors:?}, known {known:?}");
        for ((error, known), before) in errors.iter().zip(known).zip(&mut before) {
            assert!((error - known).abs() < PRINTED);
            assert!(error.abs() < *before / 3.0);
            *before = error.abs();
        }
    }
    assert!(before.iter().all(|&error| error < 0.06));
}

#[test]
fn the_energy_is_the_work_of_pressing_in() {
    // ∫ F dx of a cube pressed in flat: κ(a²x²/2 − 2ax³/3 + x⁴/3).
    let cube = cube();
    let kappa = 2.0 * MODULUS / EDGE;
    for_rigid_planes(|name, plane| {
        let x: f64 = 0.03;
        let pose = at_depth(&Rotation3::identity(), Vector3::z() * (-EDGE / 2.0), x);
        let pair = ContactPair::new(ContactBody::new(&cube, pose, MODULUS).unwrap(), plane);
        let work = EDGE * EDGE * x * x / 2.0 - 2.0 * EDGE * x.powi(3) / 3.0 + x.powi(4) / 3.0;
        assert_close(name, pair.potential_energy(), kappa * work);
    });
}

#[test]
fn a_body_that_has_sunk_through_is_pushed_by_nothing_and_holds_all_its_energy() {
    let cube = cube();
    for_rigid_planes(|name, plane| {
        let pose = Pose::from_rotation_vector(&vector![0.3, 0.5, -0.2], vector![0.1, 0.0, -0.4]);
        let pair = ContactPair::new(ContactBody::new(&cube, pose, MODULUS).unwrap(), plane);
        assert_eq!(pair.wrench().on_a.force, Vector3::zeros(), "{name}");
        // The mean height of a cone is a quarter of its height.
        let most = MODULUS * EDGE.powi(3) / 4.0;
        assert_close(name, pair.potential_energy(), most);
    });
}

/// The squares of these distances are infinite.
#[test]
fn however_far_above_a_half_space_a_body_does_not_touch_it() {
    let cube = cuboid([1.0; 3]);
    let layer = HalfSpace::layer(0.5).unwrap();
    let turned: Pose = Pose::from_rotation_vector(&vector![0.1, 0.2, 0.3], Vector3::zeros());
    for ground in [Pose::identity(), turned] {
        let partners = [
            Partner::rigid_half_space(ground).unwrap(),
            Partner::half_space(&layer, ground, 2e4).unwrap(),
        ];
        for (partner, exponent) in partners
            .into_iter()
            .flat_map(|partner| [3, 100, 154, 155, 200, 307].map(|exponent| (partner, exponent)))
        {
            let height = vector![0.3, 0.2, 2.0] * 10_f64.powi(exponent);
            let pose = ground * Pose::from_translation(height);
            let cube = ContactBody::new(&cube, pose, 1e4).unwrap();
            let pair = ContactPair::new(cube, partner);
            assert_eq!(
                pair.wrench().on_a.to_vector(),
                Vector6::zeros(),
                "1e{exponent}"
            );
            assert!(pair.potential_energy() <= 0.0, "1e{exponent}");
            assert!(!pair.has_sunk_through(), "1e{exponent}");
        }
    }
}
