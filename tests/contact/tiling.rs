//! The contact polygons of a pair tile its contact surface: however the meshes are divided and ordered, and
//! whichever body is called A, area, energy, force and torque are the same.

use crate::support::aligned::{aligned_pose, bodies, polygons_in_faces};
use crate::support::hostile::kinks::kink_of;
use crate::support::scenes::{Random, pair};
use crate::support::subdivisions::{Division, divided, shuffled};
use hydroelastic::contact::{ContactPair, Shape};
use hydroelastic::mesh::{PressureField, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};

/// Sums over the same surface in other pieces, relative to it: the requirement. Seen: 1.2e-14.
const SAME: f64 = 1e-10;

/// Where bodies only touch, round-off leaves so much of areas (m²), and of energies and forces at these
/// pressures of about 1 Pa.
const SPECK: f64 = 1e-15;

/// Round-off of a closed form.
const EXACT: f64 = 1e-12;

/// What the contact polygons of a pair add up to, and its energy.
#[derive(Debug, Clone, Copy)]
struct Sums {
    area: f64,
    energy: f64,
    /// Torque about the first body's origin and force on it.
    torque: Vector3<f64>,
    force: Vector3<f64>,
    /// Σ pressure times area (N): what forces are measured by.
    load: f64,
    /// The first body's reach (m): what torques are measured by.
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

    /// The same with the bodies exchanged, and the wrench on what is B then.
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

    fn assert_same(&self, other: &Self, what: &str) {
        let arm = self.load * self.reach;
        let [area, force, torque] = [
            (self.area - other.area).abs(),
            (self.force - other.force).norm(),
            (self.torque - other.torque).norm(),
        ];
        assert_small(area, self.area, &format!("area of {what}"));
        assert_small(force, self.load, &format!("force of {what}"));
        assert_small(torque, arm, &format!("torque of {what}"));
        self.assert_same_energy(other, what);
    }

    fn assert_same_energy(&self, other: &Self, what: &str) {
        let error = (self.energy - other.energy).abs();
        assert_small(error, self.energy, &format!("energy of {what}"));
    }
}

fn assert_small(error: f64, scale: f64, what: &str) {
    assert!(
        error <= SAME * scale + SPECK,
        "{what}: {error:e} of {scale:e}"
    );
}

fn generic_pose(random: &mut Random) -> Pose {
    let position = random.direction() * random.between(0.1, 0.9);
    Pose::from_rotation_vector(&random.rotation_vector(), position)
}

/// What the pairs of a test were.
#[derive(Debug, Default)]
struct Seen {
    touching: usize,
    /// Contact polygons that lie in a face of a tetrahedron, of all meshes together.
    in_faces: usize,
    /// Pairs compared with the exchanged bodies.
    exchanged: usize,
    /// Of these, how many are at kinks of the model: most where fields are equal over a volume.
    kinks: usize,
}

/// Random pairs at such poses: all divisions of both meshes, each in another order, and the bodies exchanged.
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
            let other = [0, 1].map(|body| {
                // One of them may stay as it is.
                let division = [division, division, Division::Whole][random.below(3)];
                let divided = divided(fields[body], division, random);
                Shape::new(shuffled(&divided, random))
            });
            let there = posed(&other, pose, modulus);
            let what = format!("pair {number}, {division:?}");
            sums.assert_same(&Sums::of(&there), &what);
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

/// The sums with the bodies exchanged.
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

/// Many of their polygons lie in faces that tetrahedra share.
#[test]
fn aligned_pairs_keep_their_sums() {
    let seen = for_pairs(160, aligned_pose);
    assert!(
        seen.touching >= 100 && seen.exchanged >= 640 && seen.kinks >= 50,
        "{seen:?}"
    );
    assert!(seen.in_faces >= 1000, "{seen:?}");
}

/// A cube of side a is pressed x deep into a large box. With k the pressure per depth of either, their
/// pressures are equal δ = k_B·x/(k_A + k_B) above the cube's lower face: on a square there, and on four
/// trapezoids from its sides to the cube's, where these enter the box.
#[test]
fn cube_pressed_into_a_box_has_the_closed_form_however_they_are_divided() {
    let (side, depth, random) = (0.5, 0.25, &mut Random::new(81));
    let fields = [shapes::cuboid([side; 3]), shapes::cuboid([2.0, 2.0, 1.0])].map(Result::unwrap);
    let pose = Pose::from_translation(vector![0.0, 0.0, depth - 0.5 * side - 0.5]);
    let mut in_faces = 0;
    // With moduli of 1 and 2 the square lies in faces of the cube in halves and of the box in quarters.
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
            let found = [sums.area, sums.force.z, sums.energy];
            for (found, expected) in found.iter().zip(expected) {
                let error = (found - expected).abs();
                assert!(
                    error <= EXACT * expected,
                    "{modulus}, {number}: {found} not {expected}"
                );
            }
            in_faces += polygons_in_faces(&pair).len();
        }
    }
    assert!(in_faces >= 50, "{in_faces}");
}

/// Area, force and energy.
fn pressed_cube(side: f64, depth: f64, [k_a, k_b]: [f64; 2]) -> [f64; 3] {
    let share = k_b / (k_a + k_b);
    let height = share * depth;
    let slant = height.hypot(depth - height);
    let area = (side - 2.0 * height).powi(2) + 4.0 * (side - height) * slant;
    let force =
        k_a * (side.powi(2) * height - 2.0 * side * height.powi(2) + 4.0 * height.powi(3) / 3.0);
    // The force's integral over the depth.
    let energy = k_a
        * depth
        * (side.powi(2) * height / 2.0 - 2.0 * side * height.powi(2) / 3.0 + height.powi(3) / 3.0);
    [area, force, energy]
}
