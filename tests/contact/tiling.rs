//! The contact polygons of a pair tile its contact surface. Area, energy, force and torque do not depend on the division or order of the
//! meshes, or on which body is called A.

use crate::support::aligned::{aligned_pose, bodies, polygons_in_faces};
use crate::support::hostile::kinks::kink_of;
use crate::support::scenes::{Random, pair};
use crate::support::subdivisions::{Division, divided, shuffled};
use crate::support::worlds::at;
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;

/// Required agreement of sums over the same surface in other pieces, relative to the sum. The largest observed difference is 1.2e-14.
const SAME: f64 = 1e-10;

/// Round-off of areas (m²), and of energies and forces at pressures of about 1 Pa, if bodies only touch.
const SPECK: f64 = 1e-15;

/// Rounding error of a closed form.
const EXACT: f64 = 1e-12;

/// Sums over the contact polygons of a pair, and its energy.
#[derive(Debug, Clone, Copy)]
struct Sums {
    area: f64,
    energy: f64,
    /// Torque about the first body's origin, and force on the first body.
    torque: Vector3<f64>,
    force: Vector3<f64>,
    /// Σ pressure times area (N), the scale of forces.
    load: f64,
    /// The first body's reach (m), which scales torques.
    reach: f64,
}

impl Sums {
    fn of(pair: &ContactPair) -> Self {
        let (surface, on_a) = (pair.surface(), pair.wrench().on_a);
        let polygons = surface.polygons.iter();
        Self {
            area: surface.area(),
            energy: pair.potential_energy(),
            torque: on_a.torque,
            force: on_a.force,
            load: polygons.map(|p| p.pressure * p.area).sum(),
            reach: pair.a().shape().field().reach(),
        }
    }

    /// Computes the sums with the bodies exchanged, with the wrench on the body that then is B.
    fn of_exchanged(pair: &ContactPair) -> Self {
        let exchanged = ContactPair::new(pair.b().body().unwrap(), *pair.a());
        let on_b = exchanged.wrench().on_b;
        Self {
            torque: on_b.torque,
            force: on_b.force,
            reach: pair.a().shape().field().reach(),
            ..Self::of(&exchanged)
        }
    }

    fn assert_same(&self, other: &Self, label: &str) {
        let arm = self.load * self.reach;
        let [area, force, torque] = [
            (self.area - other.area).abs(),
            (self.force - other.force).norm(),
            (self.torque - other.torque).norm(),
        ];
        assert_small(area, self.area, &format!("area of {label}"));
        assert_small(force, self.load, &format!("force of {label}"));
        assert_small(torque, arm, &format!("torque of {label}"));
        self.assert_same_energy(other, label);
    }

    fn assert_same_energy(&self, other: &Self, label: &str) {
        let error = (self.energy - other.energy).abs();
        assert_small(error, self.energy, &format!("energy of {label}"));
    }
}

fn assert_small(error: f64, scale: f64, label: &str) {
    assert!(
        error <= SAME * scale + SPECK,
        "{label}: {error:e} of {scale:e}"
    );
}

fn generic_pose(random: &mut Random) -> Pose {
    let position = random.direction() * random.between(0.1, 0.9);
    Pose::from_rotation_vector(&random.rotation_vector(), position)
}

/// Counts of the pairs of a test.
#[derive(Debug, Default)]
struct Seen {
    touching: usize,
    /// Number of contact polygons that lie in a face of a tetrahedron, over all meshes.
    in_faces: usize,
    /// Number of pairs compared with the exchanged bodies.
    exchanged: usize,
    /// Number of these pairs at kinks of the model. Most kinks are fields that are equal over a volume.
    kinks: usize,
}

/// Compares random pairs at these poses, with all divisions of both meshes, each in another order, and with the bodies exchanged.
fn for_pairs(count: u64, pose: impl Fn(&mut Random) -> Pose) -> Seen {
    let (fields, mut seen) = (bodies(), Seen::default());
    for number in 0..count {
        let random = &mut Random::numbered(number);
        let fields = [0, 1].map(|_| &fields[random.below(fields.len())]);
        let pose = pose(random);
        let modulus = [1.0, 2.0, random.between(0.5, 50.0)][random.below(3)];
        let whole = fields.map(|field| Shape::new(field.clone()));
        let here = posed(&whole, pose, modulus);
        let sums = Sums::of(&here);
        seen.touching += usize::from(sums.area > 0.0);
        check_exchange(&here, &sums, number, &mut seen);
        for division in Division::ALL {
            let shapes = [0, 1].map(|body| {
                // One of the meshes may remain undivided.
                let division = [division, division, Division::Whole][random.below(3)];
                let divided = divided(fields[body], division, random);
                Shape::new(shuffled(&divided, random))
            });
            let there = posed(&shapes, pose, modulus);
            let label = format!("pair {number}, {division:?}");
            sums.assert_same(&Sums::of(&there), &label);
            check_exchange(&there, &sums, number, &mut seen);
        }
    }
    seen
}

fn posed(shapes: &[Shape; 2], pose: Pose, modulus: f64) -> ContactPair<'_> {
    pair(
        (&shapes[0], Pose::identity(), 1.0),
        (&shapes[1], pose, modulus),
    )
}

/// Compares the sums with those of the exchanged bodies.
fn check_exchange(pair: &ContactPair, sums: &Sums, number: u64, seen: &mut Seen) {
    let exchanged = Sums::of_exchanged(pair);
    sums.assert_same(&exchanged, &format!("pair {number}, exchanged"));
    seen.exchanged += 1;
    seen.in_faces += polygons_in_faces(pair).len();
    seen.kinks += usize::from(kink_of(pair).is_some());
}

#[test]
fn generic_pairs_keep_their_sums() {
    let seen = for_pairs(60, generic_pose);
    assert!(seen.touching >= 50 && seen.exchanged >= 240, "{seen:?}");
}

/// Many of the polygons lie in shared faces of tetrahedra.
#[test]
fn aligned_pairs_keep_their_sums() {
    let seen = for_pairs(160, aligned_pose);
    assert!(
        seen.touching >= 100 && seen.exchanged >= 640 && seen.kinks >= 50,
        "{seen:?}"
    );
    assert!(seen.in_faces >= 1000, "{seen:?}");
}

/// A cube of side a is pressed into a large box by x. With k the pressure per depth of each body, the pressures are equal at
/// δ = k_B·x/(k_A + k_B) above the cube's lower face. They are equal on a square there, and on four trapezoids from the square's sides to the cube's
/// sides, where the cube's sides enter the box.
#[test]
fn cube_pressed_into_a_box_has_the_closed_form_however_they_are_divided() {
    let (side, depth, random) = (0.5, 0.25, &mut Random::new(81));
    let fields = [shapes::cuboid([side; 3]), shapes::cuboid([2.0, 2.0, 1.0])].map(Result::unwrap);
    let pose = at(0.0, 0.0, depth - 0.5 * side - 0.5);
    let mut in_faces = 0;
    // With moduli of 1 and 2, the square lies in faces of the cube in halves and of the box in quarters.
    for modulus in [2.0, 3.0, 20.0] {
        let (k_a, k_b) = (4.0, 2.0 * modulus);
        let expected = pressed_cube(side, depth, [k_a, k_b]);
        for number in 0..9 {
            let shapes = [(0, number % 3), (1, number / 3)].map(|(body, times)| {
                let mut field: PressureField = fields[body].clone();
                for _ in 0..times {
                    field = divided(&field, Division::Halves, random);
                }
                Shape::new(field)
            });
            let pair = posed(&shapes, pose, modulus);
            let sums = Sums::of(&pair);
            let sum_values = [sums.area, sums.force.z, sums.energy];
            for (actual, expected) in sum_values.iter().zip(expected) {
                let error = (actual - expected).abs();
                assert!(
                    error <= EXACT * expected,
                    "{modulus}, {number}: {actual} not {expected}"
                );
            }
            in_faces += polygons_in_faces(&pair).len();
        }
    }
    assert!(in_faces >= 50, "{in_faces}");
}

/// Returns area, force and energy.
fn pressed_cube(side: f64, depth: f64, [k_a, k_b]: [f64; 2]) -> [f64; 3] {
    let share = k_b / (k_a + k_b);
    let height = share * depth;
    let slant = height.hypot(depth - height);
    let area = (side - 2.0 * height).powi(2) + 4.0 * (side - height) * slant;
    let force =
        k_a * (side.powi(2) * height - 2.0 * side * height.powi(2) + 4.0 * height.powi(3) / 3.0);
    // The energy is the integral of the force over the depth.
    let energy = k_a
        * depth
        * (side.powi(2) * height / 2.0 - 2.0 * side * height.powi(2) / 3.0 + height.powi(3) / 3.0);
    [area, force, energy]
}
