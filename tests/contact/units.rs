//! Contact does not depend on units. In units of length, pressure and extent that differ by powers of two, which scale without rounding,
//! all results have the same bits. Therefore no tolerance is an absolute number.

use crate::support::aligned::{aligned_pose, bodies};
use crate::support::scenes::{Random, mixed_shapes, pair, random_pair};
use hydroelastic::contact::SurfaceLaw;
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Matrix6, Vector3, Vector6};

/// Exponents of two: units of length, pressure and extent.
#[derive(Debug, Clone, Copy)]
struct Units {
    length: i32,
    pressure: i32,
    extent: i32,
}

const UNITS: [Units; 3] = [units(20, 0, 0), units(-14, 33, -9), units(7, -21, 30)];

/// Original units of a scene.
const UNITS_OF_THE_SCENE: Units = units(0, 0, 0);

const fn units(length: i32, pressure: i32, extent: i32) -> Units {
    Units {
        length,
        pressure,
        extent,
    }
}

impl Units {
    fn shape(self, shape: &Shape) -> Shape {
        let field = shape.field();
        let vertices = field
            .mesh()
            .vertices()
            .iter()
            .map(|v| v * power(self.length));
        let mesh = TetMesh::new(vertices.collect(), field.mesh().tets().to_vec()).unwrap();
        let extents = field.extents().iter().map(|e| e * power(self.extent));
        Shape::new(PressureField::with_inert_tets(mesh, extents.collect()).unwrap())
    }

    fn pose(self, pose: &Pose) -> Pose {
        pose.with_translation(pose.translation() * power(self.length))
    }

    /// Converts a modulus, which is pressure per extent.
    fn modulus(self, modulus: f64) -> f64 {
        modulus * power(self.pressure - self.extent)
    }

    /// Returns the unit of pressure × lengthⁿ as an exponent.
    fn moment(self, n: i32) -> i32 {
        self.pressure + n * self.length
    }
}

fn power(exponent: i32) -> f64 {
    2.0_f64.powi(exponent)
}

/// Converts torques and forces, whose units differ by a length.
fn torque_and_force(numbers: &Vector6<f64>, units: Units, times: i32) -> Vec<f64> {
    let unit = |row| units.moment(if row < 3 { 3 } else { 2 }) + times;
    (0..6).map(|row| numbers[row] * power(-unit(row))).collect()
}

/// Converts derivatives with respect to angles and lengths.
fn by_pose(matrix: &Matrix6<f64>, units: Units) -> Vec<f64> {
    let columns = (0..6).flat_map(|column| {
        let by = if column < 3 { 0 } else { -units.length };
        torque_and_force(&matrix.column(column).into_owned(), units, by)
    });
    columns.collect()
}

fn point(point: &Vector3<f64>, units: Units) -> impl Iterator<Item = f64> {
    point
        .iter()
        .map(move |x| x * power(-units.length))
        .collect::<Vec<_>>()
        .into_iter()
}

/// Returns all results for a pair, in the original units of its copy.
fn everything(pair: &ContactPair, units: Units) -> Vec<f64> {
    let contact = pair.linearized();
    let wrench = contact.wrench;
    let mut numbers = torque_and_force(&pair.wrench().on_a.to_vector(), units, 0);
    for on in [wrench.on_a, wrench.on_b] {
        numbers.extend(torque_and_force(&on.to_vector(), units, 0));
    }
    for row in [0, 6] {
        let by_poses = [0, 6].map(|column| contact.by_poses.fixed_view::<6, 6>(row, column));
        let by_moduli = [0, 1].map(|column| contact.by_moduli.fixed_view::<6, 1>(row, column));
        for by in by_poses {
            numbers.extend(by_pose(&by.into_owned(), units));
        }
        let per_modulus = units.extent - units.pressure;
        for by in by_moduli {
            numbers.extend(torque_and_force(&by.into_owned(), units, per_modulus));
        }
    }
    numbers.extend(in_motion(pair, units));
    numbers.push(pair.potential_energy() * power(-units.moment(3)));
    for polygon in pair.surface().polygons {
        numbers.push(polygon.area * power(-2 * units.length));
        numbers.push(polygon.pressure * power(-units.pressure));
        numbers.extend(point(&polygon.center_of_pressure, units));
        numbers.extend(
            polygon
                .outline
                .corners()
                .iter()
                .flat_map(|c| point(c, units)),
        );
    }
    numbers
}

/// Returns the wrench and the Jacobian of a sliding pair. Speeds are the same numbers in any unit of length per second.
fn in_motion(pair: &ContactPair, units: Units) -> Vec<f64> {
    let twist = |numbers: [f64; 6]| {
        let mut twist = Twist::from_vector(&Vector6::from(numbers));
        twist.linear *= power(units.length);
        twist
    };
    let law = SurfaceLaw::new(0.3 * power(-units.length), 0.5, 0.1 * power(units.length)).unwrap();
    let twists = [
        [0.1, 0.3, -0.2, 0.5, -0.7, 0.2],
        [-0.4, 0.2, 0.1, 0.1, 0.1, 0.3],
    ]
    .map(twist);
    let wrench = pair.moving(law, twists).wrench().on_a.to_vector();
    let mut numbers = torque_and_force(&wrench, units, 0);
    let jacobian = pair.moving(law, twists).linearized().jacobian();
    for (number, column) in jacobian.column_iter().enumerate() {
        // Parameters are angles and lengths of poses and twists, moduli, dissipation (s/m) and friction.
        let by = match number {
            0..24 if number % 6 < 3 => 0,
            0..24 => -units.length,
            24 | 25 => units.extent - units.pressure,
            26 => units.length,
            _ => 0,
        };
        for body in [0, 6] {
            let on_body = column.fixed_rows::<6>(body).into_owned();
            numbers.extend(torque_and_force(&on_body, units, by));
        }
    }
    numbers
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    // Sums may have signed zeros, so −0 becomes 0.
    numbers
        .iter()
        .map(|number| (number + 0.0).to_bits())
        .collect()
}

fn assert_same_in_all_units(pair: &ContactPair) {
    with_other_units(pair, UNITS_OF_THE_SCENE, |again| {
        for units in UNITS {
            with_other_units(pair, units, |scaled| assert_same(again, scaled, units));
        }
    });
}

/// Recreates the pair in other units. This orthonormalizes its rotations again, so pairs for comparison must be recreated as well.
fn with_other_units(pair: &ContactPair, units: Units, read: impl Fn(&ContactPair)) {
    let bodies = [pair.a(), &pair.b().body().unwrap()];
    let [shape_a, shape_b] = bodies.map(|body| units.shape(body.shape()));
    let [a, b] = bodies.map(|body| (units.pose(body.pose()), units.modulus(body.modulus())));
    read(&crate::support::scenes::pair(
        (&shape_a, a.0, a.1),
        (&shape_b, b.0, b.1),
    ));
}

fn assert_same(pair: &ContactPair, scaled: &ContactPair, units: Units) {
    let searches = [
        Search::Following,
        Search::Culling(Culling::default()),
        Search::Culling(Culling::NONE),
    ];
    for search in searches {
        let (pair, scaled) = (pair.with_search(search), scaled.with_search(search));
        assert_eq!(pair.work_count(), scaled.work_count());
        let expected = everything(&pair, UNITS_OF_THE_SCENE);
        let actual = everything(&scaled, units);
        assert!(bits(&expected) == bits(&actual), "{units:?} {search:?}");
    }
}

#[test]
fn generic_pairs_have_the_same_bits_in_all_units() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(71));
    for _ in 0..12 {
        assert_same_in_all_units(&random_pair(&shapes, &mut random));
    }
}

#[test]
fn aligned_pairs_have_the_same_bits_in_all_units() {
    let shapes: Vec<Shape> = bodies().into_iter().map(Shape::new).collect();
    let mut random = Random::new(72);
    for _ in 0..30 {
        let [a, b] = [0, 1].map(|_| &shapes[random.below(shapes.len())]);
        let moduli = [0, 1].map(|_| [1.0, 1.0, 2.0, 3.7][random.below(4)]);
        let pose = aligned_pose(&mut random);
        // The start is far from the world's origin and rotated, so that coincidences are rounded.
        let start = Pose::from_rotation_vector(&random.rotation_vector(), random.vector());
        for first in [Pose::identity(), start] {
            assert_same_in_all_units(&pair((a, first * pose, moduli[0]), (b, first, moduli[1])));
        }
    }
}
