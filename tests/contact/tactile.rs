//! Tactile images: sums over taxels against the wrench, derivatives against differences, and taxels against sampled contact surfaces.
#![allow(clippy::float_cmp, reason = "where nothing touches, zeros are exact")]

use crate::partners::Shapes;
use crate::shape_gradients::for_pairs;
use crate::shape_gradients::in_motion::{Change, STEPS};
use crate::support::moving::{COLUMNS, Scene};
use crate::support::scenes::Random;
use crate::support::worlds::{at, cuboid, icosphere, turned};
use hydroelastic::contact::{
    ContactBody, ContactPair, GridBody, Partner, SurfaceLaw, TactileImage, TaxelGrid,
    TaxelGridError,
};
use hydroelastic::geometry::{Aabb, AffineField};
use hydroelastic::scalar::{DenseDual, norm};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, vector};
use std::f64::consts::PI;

/// Rounding error of a sum over taxels, relative to the integral of the size of the traction.
const SAME_SUM: f64 = 1e-12;

/// Agreement of derivatives with central differences, relative to the largest derivative of the image.
const DIFFERENCES: f64 = 1e-6;

/// Step of differences, in m, rad, m/s, rad/s, and relative moduli.
const STEP: f64 = 1e-6;

/// Agreement of derivatives with central differences at kinks, whose error is of first order in the step.
const FLUSH_DIFFERENCES: f64 = 1e-4;

/// Rounding error of a sum of derivatives over taxels, relative to the largest derivative.
const SAME_JACOBIAN: f64 = 1e-10;

/// Error of the sampled integral, relative to the total force. A sample covers about 1e-4 of the contact.
const SAMPLED: f64 = 1e-3;

const BODIES: [GridBody; 2] = [GridBody::A, GridBody::B];

/// Returns a grid of each kind, at a random frame, on shapes of about radius 1.
fn grids(random: &mut Random) -> [TaxelGrid; 4] {
    let turn = Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * 0.2);
    [
        TaxelGrid::flat(&turn, [1.1, 0.9], [7, 5]).unwrap(),
        TaxelGrid::cylindrical(&turn, 2.5, 1.2, [6, 4]).unwrap(),
        TaxelGrid::dome(&turn, [2.0, 2.4], [5, 8]).unwrap(),
        tapered(),
    ]
}

/// Returns planes that cross far outside of the patch.
fn tapered() -> TaxelGrid {
    let column = |i: i32| AffineField {
        gradient: vector![2.0, 0.0, 0.1 * f64::from(i)],
        offset: -0.6 * f64::from(i),
    };
    let row = |i: i32| AffineField {
        gradient: vector![0.3, 1.0, 0.05 * f64::from(i)],
        offset: -0.4 * f64::from(i),
    };
    let patch = Aabb {
        lower: Vector3::repeat(-1.0),
        upper: Vector3::repeat(1.0),
    };
    let planes = [(-3..=3).map(column).collect(), (-2..=2).map(row).collect()];
    let [columns, rows]: [Vec<_>; 2] = planes;
    TaxelGrid::new(&columns, &rows, &patch).unwrap()
}

/// Returns the wrench on the body of a grid about its origin, in its axes.
fn wrench_on(pair: &ContactPair, body: GridBody) -> Wrench {
    let wrench = pair.wrench();
    let (wrench, pose) = match body {
        GridBody::A => (wrench.on_a, pair.a().pose()),
        GridBody::B => (wrench.on_b, pair.b().pose()),
    };
    wrench.rotated(&pose.rotation().transpose())
}

/// Checks that the taxels and the outside add up to the wrench. Returns the number of taxels with contact.
fn assert_sum_is_the_wrench(pair: &ContactPair, body: GridBody, grid: &TaxelGrid) -> usize {
    let image = pair.tactile_image(body, grid);
    let (sum, wrench) = (image.total(), wrench_on(pair, body));
    let load: f64 = pair
        .surface()
        .polygons
        .iter()
        .map(|p| p.pressure * p.area)
        .sum();
    let pose = [pair.a().pose(), pair.b().pose()][usize::from(body == GridBody::B)];
    let arm = |p: &Vector3<f64>| (p - pose.translation()).norm();
    let corners = pair.surface().polygons;
    let reach = corners.iter().map(|p| arm(&p.centroid)).fold(0.0, f64::max);
    let force = (sum.force - wrench.force).norm() / load;
    let torque = (sum.torque - wrench.torque).norm() / (load * reach.max(1e-3));
    assert!(
        force < SAME_SUM && torque < SAME_SUM,
        "{body:?}: {force:e}, {torque:e}"
    );
    image.taxels().len()
}

#[test]
fn the_sum_over_taxels_is_the_wrench_for_every_grid_partner_and_law() {
    let mut touched = 0;
    Shapes::mixed().for_pairs(120, 41, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let moving = pair.moving(scene.law(), scene.twists);
        for grid in &grids(random) {
            for body in BODIES {
                touched += assert_sum_is_the_wrench(pair, body, grid);
                touched += assert_sum_is_the_wrench(&moving, body, grid);
            }
        }
    });
    assert!(touched > 5_000, "{touched}");
}

#[test]
fn the_sum_over_taxels_is_the_wrench_if_taxel_edges_lie_on_edges_of_the_contact() {
    let (pad, block) = (cuboid([0.4, 0.4, 0.1]), cuboid([0.2, 0.2, 0.1]));
    let top = TaxelGrid::flat(&at(0.0, 0.0, 0.05), [0.4, 0.4], [8, 8]).unwrap();
    let law = SurfaceLaw::new(0.1, 0.5, 1e-2).unwrap();
    let sliding = Twist {
        linear: vector![0.1, 0.02, 0.0],
        ..Twist::zero()
    };
    for place in [
        at(0.0, 0.0, 0.098),
        at(0.1, 0.0, 0.098),
        at(0.05, 0.1, 0.098),
    ] {
        for modulus in [1e5, 3e5] {
            let a = ContactBody::new(&pad, Pose::identity(), 1e5).unwrap();
            let b = ContactBody::new(&block, place, modulus).unwrap();
            let pair = ContactPair::new(a, b);
            for pair in [pair, pair.moving(law, [Twist::zero(), sliding])] {
                assert!(assert_sum_is_the_wrench(&pair, GridBody::A, &top) >= 8);
            }
        }
    }
}

#[test]
fn a_block_presses_equally_on_the_taxels_under_it_and_not_on_others() {
    let (pad, block) = (cuboid([0.4, 0.4, 0.1]), cuboid([0.2, 0.2, 0.1]));
    let grid = TaxelGrid::flat(&at(0.0, 0.0, 0.05), [0.4, 0.4], [8, 8]).unwrap();
    let a = ContactBody::new(&pad, Pose::identity(), 1e5).unwrap();
    let rigid = crate::support::worlds::rigid(block.field());
    let pair = ContactPair::new(a, Partner::rigid(&rigid, at(0.0, 0.0, 0.098)).unwrap());
    let image = pair.tactile_image(GridBody::A, &grid);
    for row in 0..8 {
        for column in 0..8 {
            let is_under = (2..6).contains(&row) && (2..6).contains(&column);
            // The depth is 0.002 m in a field that rises over 0.05 m. A taxel has 0.0025 m². The sides of the block add shear only.
            let expected = if is_under {
                -1e5 * 0.002 / 0.05 * 0.0025
            } else {
                0.0
            };
            let force = image.force(row, column).z;
            assert!(
                (force - expected).abs() < SAME_SUM * 10.0,
                "{row} {column}: {force}"
            );
        }
    }
}

/// Returns a body on the half-space below z = 0 as a pair at rest, and as a pair in motion with velocities of zero.
fn at_rest_and_in_motion(a: ContactBody) -> [ContactPair; 2] {
    let floor = Partner::rigid_half_space(Pose::identity()).unwrap();
    let law = SurfaceLaw::new(0.0, 0.0, 1e-2).unwrap();
    let in_motion = ContactPair::new(a, floor).moving(law, [Twist::zero(); 2]);
    [ContactPair::new(a, floor), in_motion]
}

/// The planes of the columns cross at y = −0.208 m, outside of the box of the patch, but in the contact.
#[test]
fn taxels_in_the_box_are_correct_if_planes_cross_in_the_contact_outside_of_the_box() {
    let cube = cuboid([1.0; 3]);
    let line = |x: f64, y: f64, offset: f64| AffineField {
        gradient: vector![x, y, 0.0],
        offset,
    };
    let columns = [(0.0, 0.6), (1.0, -0.04), (-0.2, -0.29), (0.0, -0.6)];
    let columns = columns.map(|(y, offset)| line(1.0, y, offset));
    let rows = [0.6, 0.1, -0.1, -0.6].map(|offset| line(0.0, 1.0, offset));
    let patch = Aabb {
        lower: vector![-0.7, -0.1, -1.0],
        upper: vector![0.7, 0.1, 1.0],
    };
    let grid = TaxelGrid::new(&columns, &rows, &patch).unwrap();
    let a = ContactBody::new(&cube, at(0.0, 0.0, 0.45), 1e5).unwrap();
    for pair in at_rest_and_in_motion(a) {
        let image = pair.tactile_image(GridBody::A, &grid);
        // The taxel is 0.2 m long and 0.25 m wide on average. The pressure is 1e5 · 0.05/0.5 Pa.
        let force = image.taxel(1, 1).unwrap().wrench.force.z;
        assert!((force - 500.0).abs() < 1e-9, "{force}");
    }
}

/// A half-space cuts a ball through its center. The whole contact lies in the plane between two rows, up to round-off.
#[test]
fn a_contact_in_a_taxel_plane_is_in_the_higher_row() {
    let ball = icosphere(0.1, 1);
    let pose = turned([0.3, -0.5, 0.9], [0.0; 3]);
    let frame = Pose::from_rotation_vector(&vector![PI / 2.0, 0.0, 0.0], Vector3::zeros());
    let grid = TaxelGrid::flat(&(pose.inverse() * frame), [0.3, 0.2], [1, 2]).unwrap();
    let a = ContactBody::new(&ball, pose, 1e5).unwrap();
    for pair in at_rest_and_in_motion(a) {
        let image = pair.tactile_image(GridBody::A, &grid);
        assert_eq!(image.taxels().len(), 1);
        let difference = image.force(1, 0) - grid.axes(1, 0).tr_mul(&image.total().force);
        assert!(difference.norm() < 1e-9, "{difference}");
    }
}

#[test]
fn taxels_are_the_integral_of_traction_over_a_sampled_contact_surface() {
    let (pad, ball) = (cuboid([0.4, 0.4, 0.1]), icosphere(0.1, 2));
    let a = ContactBody::new(&pad, turned([0.1, 0.0, 0.2], [0.0; 3]), 1e5).unwrap();
    let b = ContactBody::new(&ball, turned([0.3, 0.2, 0.1], [0.03, 0.02, 0.13]), 3e5).unwrap();
    let pair = ContactPair::new(a, b);
    let on_pad = TaxelGrid::flat(&at(0.0, 0.0, 0.05), [0.2, 0.16], [10, 9]).unwrap();
    let turned_down = turned([3.0, 0.0, 0.0], [0.0; 3]);
    let on_ball = TaxelGrid::dome(&turned_down, [1.2, 1.4], [9, 7]).unwrap();
    for (body, grid) in [(GridBody::A, &on_pad), (GridBody::B, &on_ball)] {
        let image = pair.tactile_image(body, grid);
        let sampled = sampled_forces(&pair, body, grid);
        let total = pair.wrench().on_a.force.norm();
        let mut touched = 0;
        for (taxel, sampled) in sampled.iter().enumerate() {
            let (row, column) = (taxel / grid.column_count(), taxel % grid.column_count());
            let difference = (image.force(row, column) - sampled).norm() / total;
            assert!(
                difference < SAMPLED,
                "{body:?} {row} {column}: {difference:e}"
            );
            touched += usize::from(*sampled != Vector3::zeros());
        }
        assert!(touched > 15, "{touched}");
    }
}

/// Sums pressure times area over small triangles of the contact surface, each in the taxel that contains its middle.
fn sampled_forces(pair: &ContactPair, body: GridBody, grid: &TaxelGrid) -> Vec<Vector3<f64>> {
    let (pose, sign) = match body {
        GridBody::A => (pair.a().pose(), 1.0),
        GridBody::B => (pair.b().pose(), -1.0),
    };
    let inverse = pose.inverse();
    let columns = grid.column_count();
    let mut forces = vec![Vector3::zeros(); columns * grid.row_count()];
    for polygon in pair.surface().polygons {
        let corners = polygon.outline.corners();
        for pair in corners[1..].windows(2) {
            for (middle, area) in small_triangles([corners[0], pair[0], pair[1]]) {
                let force = polygon.normal * (polygon.pressure_at(&middle) * area * sign);
                let point = inverse.transformed_point(&middle);
                if let Some([row, column]) = grid.taxel_at(&point) {
                    let in_body = pose.rotation().transpose() * force;
                    forces[row * columns + column] += grid.axes(row, column).tr_mul(&in_body);
                }
            }
        }
    }
    forces
}

/// Divides a triangle into 64² equal ones: the middle and the area of each.
fn small_triangles(
    [origin, right, left]: [Vector3<f64>; 3],
) -> impl Iterator<Item = (Vector3<f64>, f64)> {
    const N: u32 = 64;
    let axes = [right, left].map(|end| (end - origin) / f64::from(N));
    let area = 0.5 * axes[0].cross(&axes[1]).norm();
    let middle = move |cell: [u32; 2], third: f64| {
        let [along, across] = cell.map(|index| f64::from(index) + third / 3.0);
        (origin + axes[0] * along + axes[1] * across, area)
    };
    (0..N).flat_map(move |row| {
        (0..N - row).flat_map(move |column| {
            let upper = (column + 1 < N - row).then(|| middle([row, column], 2.0));
            std::iter::once(middle([row, column], 1.0)).chain(upper)
        })
    })
}

/// Returns the forces on all taxels.
fn forces(image: &TactileImage) -> Vec<Vector3<f64>> {
    let (rows, columns) = (image.grid().row_count(), image.grid().column_count());
    (0..rows * columns)
        .map(|taxel| image.force(taxel / columns, taxel % columns))
        .collect()
}

/// A comparison of derivatives with central differences.
struct Comparison {
    step: f64,
    /// Smallest size of a column to which its errors are relative.
    least: f64,
    /// First component of the forces. It is 2 for normal forces only.
    first: usize,
}

const GENERIC: Comparison = Comparison {
    step: STEP,
    least: 1e-9,
    first: 0,
};

/// At kinks, the error of central differences is of first order in the step. Rounding errors are relative to derivatives of about 1e3 N/m.
const FLUSH: Comparison = Comparison {
    step: 1e-7,
    least: 1.0,
    first: 0,
};

/// Shear forces jump if the side of a rigid block passes from one taxel to another.
const FLUSH_RIGID: Comparison = Comparison { first: 2, ..FLUSH };

/// Returns the largest difference between derivatives and central differences, relative to the largest derivative of each column.
fn worst_derivative(
    scene: &Scene,
    is_moving: bool,
    (body, grid): (GridBody, &TaxelGrid),
    comparison: &Comparison,
) -> f64 {
    let Comparison { step, least, first } = *comparison;
    let still = scene.pair;
    let pair = if is_moving {
        still.moving(scene.law(), scene.twists)
    } else {
        still
    };
    let linearized = pair.linearized_tactile_image(body, grid);
    let mut worst = 0.0_f64;
    for input in 0..COLUMNS {
        let moduli = [still.a().modulus(), still.b().modulus().unwrap_or(1.0)];
        let unit = if (24..26).contains(&input) {
            moduli[input - 24]
        } else {
            1.0
        };
        let image = |step: f64| {
            let mut changes = SVector::<f64, COLUMNS>::zeros();
            changes[input] = step * unit;
            let (changed, law, twists) = scene.changed(&changes);
            let changed = if is_moving {
                changed.moving(law, twists)
            } else {
                changed
            };
            forces(&changed.tactile_image(body, grid))
        };
        let (ahead, behind) = (image(step), image(-step));
        let (mut largest, mut error) = (least, 0.0_f64);
        for (taxel, (ahead, behind)) in ahead.iter().zip(&behind).enumerate() {
            let (row, column) = (taxel / grid.column_count(), taxel % grid.column_count());
            let difference = (ahead - behind) / (2.0 * step);
            let exact = linearized.jacobian(row, column).column(input) * unit;
            largest = f64::max(largest, exact.norm());
            error = error.max((difference - exact).rows_range(first..).norm());
        }
        worst = worst.max(error / largest);
    }
    worst
}

#[test]
fn derivatives_of_taxels_equal_central_differences() {
    let mut compared = 0;
    let mut worst = 0.0_f64;
    Shapes::mixed().for_pairs(12, 43, |pair, random| {
        let scene = Scene::at_random(pair, random);
        for grid in &grids(random) {
            for body in BODIES {
                for is_moving in [false, true] {
                    worst = worst.max(worst_derivative(&scene, is_moving, (body, grid), &GENERIC));
                    compared += 1;
                }
            }
        }
    });
    println!("{compared} images, worst {worst:e}");
    assert!(worst < DIFFERENCES, "{worst:e}");
}

/// Dual numbers differentiate the image through all clips, without the closed form.
#[test]
fn derivatives_of_taxels_in_motion_equal_those_of_dual_numbers() {
    type Dual = DenseDual<COLUMNS>;
    let changes = SVector::<Dual, COLUMNS>::from_fn(|input, _| Dual::variable(0.0, input));
    let (mut worst, mut compared) = (0.0_f64, 0);
    Shapes::mixed().for_pairs(12, 45, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let moving = scene.pair.moving(scene.law(), scene.twists);
        let (changed, law, twists) = scene.changed(&changes);
        let changed = changed.moving(law, twists);
        for (grid, body) in grids(random)
            .iter()
            .flat_map(|grid| BODIES.map(|body| (grid, body)))
        {
            let expected = changed.tactile_image(body, grid);
            let linearized = moving.linearized_tactile_image(body, grid);
            let (mut largest, mut error) = (1e-9, SMatrix::<f64, 1, COLUMNS>::zeros());
            for taxel in expected.taxels() {
                let by = linearized.jacobian(taxel.row, taxel.column);
                let force = expected.force(taxel.row, taxel.column);
                let by_duals =
                    SMatrix::<f64, 3, COLUMNS>::from_fn(|row, input| force[row].eps[input]);
                largest = f64::max(largest, by_duals.amax());
                for (input, error) in error.iter_mut().enumerate() {
                    *error = error.max((by - by_duals).column(input).amax());
                }
                compared += 1;
            }
            worst = worst.max(error.amax() / largest);
        }
    });
    println!("{compared} taxels, worst {worst:e}");
    assert!(compared > 100 && worst < SAME_JACOBIAN, "{worst:e}");
}

/// Returns a grid that covers everything, with narrow taxels near the origin, along the axes of the body.
fn unbounded() -> TaxelGrid {
    let planes = |axis: usize| -> Vec<_> {
        let field = |offset: f64| AffineField {
            gradient: Vector3::ith(axis, 1.0),
            offset: -offset,
        };
        [-25.0, -0.5, -0.3, 0.0, 0.2, 0.4, 25.0].map(field).to_vec()
    };
    let patch = Aabb {
        lower: Vector3::repeat(-20.0),
        upper: Vector3::repeat(20.0),
    };
    TaxelGrid::new(&planes(0), &planes(1), &patch).unwrap()
}

/// Returns the Jacobian of the force on the body of a grid, in its axes.
fn force_jacobian(pair: &ContactPair, body: GridBody) -> SMatrix<f64, 3, COLUMNS> {
    let linearized = pair.linearized();
    let (first, column, pose, on_body) = match body {
        GridBody::A => (3, 0, pair.a().pose(), linearized.wrench.on_a),
        GridBody::B => (9, 6, pair.b().pose(), linearized.wrench.on_b),
    };
    let to_body = pose.rotation().transpose();
    let mut jacobian = to_body * linearized.jacobian().fixed_rows::<3>(first);
    // The axes turn with the body.
    let turned = to_body * hydroelastic::spatial::skew(&on_body.force);
    let mut by_turn = jacobian.fixed_view_mut::<3, 3>(0, column);
    by_turn += turned;
    jacobian
}

#[test]
fn derivatives_of_taxels_add_up_to_those_of_the_wrench() {
    let grid = unbounded();
    let mut worst = [0.0_f64; 2];
    Shapes::mixed().for_pairs(30, 44, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let moving = pair.moving(scene.law(), scene.twists);
        for (body, (number, pair)) in BODIES
            .into_iter()
            .flat_map(|body| [(body, (0, pair)), (body, (1, &moving))])
        {
            let image = pair.linearized_tactile_image(body, &grid);
            let (mut sum, expected) = (SMatrix::zeros(), force_jacobian(pair, body));
            for taxel in 0..36 {
                sum += image.jacobian(taxel / 6, taxel % 6);
            }
            worst[number] = worst[number].max((sum - expected).amax() / expected.amax());
        }
    });
    println!("at rest and in motion: {worst:?}");
    assert!(
        worst.iter().all(|&worst| worst < SAME_JACOBIAN),
        "{worst:?}"
    );
}

/// A face or an edge of a contact polygon on a plane of taxels is a kink. Central differences are then the mean of both sides.
#[test]
fn derivatives_are_the_mean_of_both_sides_if_edges_of_the_contact_lie_on_taxel_edges() {
    let (pad, block, ball) = (
        cuboid([0.4, 0.4, 0.1]),
        cuboid([0.2, 0.2, 0.1]),
        icosphere(0.1, 2),
    );
    let rigid = crate::support::worlds::rigid(block.field());
    let top = TaxelGrid::flat(&at(0.0, 0.0, 0.05), [0.4, 0.4], [8, 8]).unwrap();
    let below = TaxelGrid::flat(&turned([PI, 0.0, 0.0], [0.0, 0.0, -0.05]), [0.2; 2], [4, 4]);
    let a = ContactBody::new(&pad, Pose::identity(), 1e5).unwrap();
    let soft = |shape, z| ContactBody::new(shape, at(0.0, 0.0, z), 3e5).unwrap();
    let pairs = [
        ContactPair::new(a, Partner::rigid(&rigid, at(0.0, 0.0, 0.098)).unwrap()),
        ContactPair::new(a, Partner::rigid(&rigid, at(0.1, 0.05, 0.098)).unwrap()),
        ContactPair::new(a, soft(&ball, 0.14)),
        ContactPair::new(a, soft(&block, 0.098)),
    ];
    // The border of this patch is on edges of the centered ball.
    let half = TaxelGrid::flat(&at(0.1, 0.0, 0.05), [0.2, 0.4], [4, 8]).unwrap();
    let (below, mut largest) = (below.unwrap(), 0.0_f64);
    for (number, pair) in pairs.iter().enumerate() {
        let is_rigid = pair.b().rigid_shape().is_some();
        let comparison = if is_rigid { &FLUSH_RIGID } else { &FLUSH };
        let scene = Scene::at_random(pair, &mut Random::new(3));
        let mut grids = vec![(GridBody::A, &top), (GridBody::B, &below)];
        if number == 2 {
            grids.push((GridBody::A, &half));
        }
        for (body, grid) in grids {
            // Skips the pair in motion if a side of a rigid block lies on a taxel edge. Friction makes normal forces jump there, so they have
            // no derivative.
            let has_jump = is_rigid && body == GridBody::A;
            for is_moving in [false, true]
                .into_iter()
                .filter(|moving| !(*moving && has_jump))
            {
                let worst = worst_derivative(&scene, is_moving, (body, grid), comparison);
                println!("pair {number} {body:?} {is_moving}: {worst:e}");
                largest = largest.max(worst);
            }
        }
    }
    assert!(largest < FLUSH_DIFFERENCES, "{largest:e}");
}

/// Returns the sum of the derivatives of the forces on all taxels.
fn sum_of_derivatives(pair: &ContactPair, body: GridBody, grid: &TaxelGrid) -> SMatrix<f64, 3, 28> {
    let image = pair.linearized_tactile_image(body, grid);
    let (rows, columns) = (grid.row_count(), grid.column_count());
    let taxels = 0..rows * columns;
    taxels
        .map(|taxel| image.jacobian(taxel / columns, taxel % columns))
        .sum()
}

#[test]
fn a_face_on_the_border_of_the_patch_of_its_body_has_all_of_its_derivatives() {
    let (pad, block) = (cuboid([0.4, 0.4, 0.1]), cuboid([0.2; 3]));
    let rigid = crate::support::worlds::rigid(block.field());
    let below = turned([PI, 0.0, 0.0], [0.0, 0.0, -0.1]);
    let below = TaxelGrid::flat(&below, [0.2; 2], [3, 3]).unwrap();
    let soft = |shape, pose, modulus| ContactBody::new(shape, pose, modulus).unwrap();
    let pose = turned([0.02, 0.03, 0.4], [0.01, 0.02, 0.142]);
    let pair = ContactPair::new(
        soft(&pad, Pose::identity(), 1e5),
        Partner::rigid(&rigid, pose).unwrap(),
    );
    // If the other body is rigid, forces are proportional to the modulus.
    let image = pair.tactile_image(GridBody::B, &below);
    let force: Vector3<f64> = forces(&image).iter().sum();
    let by_modulus = sum_of_derivatives(&pair, GridBody::B, &below).column(24) * 1e5;
    assert!((by_modulus - force).norm() < SAME_JACOBIAN * force.norm());
    // Flush blocks: the patch is a side of A.
    let top = TaxelGrid::flat(&at(0.0, 0.0, 0.1), [0.2; 2], [4, 4]).unwrap();
    let pair = ContactPair::new(
        soft(&block, Pose::identity(), 1e5),
        soft(&block, at(0.0, 0.0, 0.19), 3e5),
    );
    let scene = Scene::at_random(&pair, &mut Random::new(5));
    for pair in [pair, pair.moving(scene.law(), scene.twists)] {
        let sum = sum_of_derivatives(&pair, GridBody::A, &top);
        let expected = force_jacobian(&pair, GridBody::A);
        assert!((sum - expected).amax() < SAME_JACOBIAN * expected.amax());
    }
}

/// Returns generic derivatives of a number with respect to the force on a taxel.
fn weight(row: usize, column: usize) -> Vector3<f64> {
    let (row, column) = (row as f64, column as f64);
    vector![
        (1.3 * row + column).sin(),
        (row - 0.7 * column).cos(),
        1.0 + (0.4 * row * column).sin()
    ]
}

#[test]
fn shape_gradients_of_taxels_equal_central_differences() {
    let mut worst = 0.0_f64;
    for_pairs(20, 77, |pair, random| {
        let change = Change::random(pair, random);
        let scene = Scene::at_random(pair, random);
        let is_moving = random.below(2) == 0;
        let (law, twists) = (scene.law(), scene.twists);
        let moving = pair.moving(law, twists);
        let pair = if is_moving { &moving } else { pair };
        // The contact may be outside of a patch.
        let everywhere = pair.tactile_shape_gradients(GridBody::A, &unbounded(), weight);
        let size: f64 = everywhere
            .iter()
            .flat_map(|of| &of.by_vertices)
            .map(Vector3::norm)
            .sum();
        for (grid, body) in grids(random)
            .iter()
            .zip([0, 1, 0, 1].map(|body| BODIES[body]))
        {
            let weighted = |pair: &ContactPair| -> f64 {
                let changed = if is_moving {
                    pair.moving(law, twists)
                } else {
                    *pair
                };
                let image = changed.tactile_image(body, grid);
                let forces = image.taxels().iter().map(|taxel| {
                    let (row, column) = (taxel.row, taxel.column);
                    weight(row, column).dot(&image.force(row, column))
                });
                forces.sum()
            };
            let gradients = pair.tactile_shape_gradients(body, grid, weight);
            let actual = change.along(&gradients);
            let errors = STEPS.map(|step| {
                let [ahead, behind] = [step, -step].map(|time| change.after(pair, time, weighted));
                ((ahead - behind) / (2.0 * step) - actual).abs() / size
            });
            worst = worst.max(errors.into_iter().fold(f64::MAX, f64::min));
        }
    });
    println!("{worst:e}");
    assert!(worst < DIFFERENCES, "{worst:e}");
}

#[test]
fn shape_gradients_of_one_taxel_are_those_of_the_force() {
    let grid = TaxelGrid::flat(&Pose::identity(), [50.0, 50.0], [1, 1]).unwrap();
    for_pairs(30, 78, |pair, random| {
        let scene = Scene::at_random(pair, random);
        let moving = pair.moving(scene.law(), scene.twists);
        let pair = if random.below(2) == 0 { pair } else { &moving };
        let force = vector![0.3, -0.5, 0.8];
        let by_wrenches = pair.a().pose().rotation() * force;
        let rows = SVector::from_fn(|row, _| {
            if (3..6).contains(&row) {
                by_wrenches[row - 3]
            } else {
                0.0
            }
        });
        let expected = pair.shape_gradients(&rows);
        let actual = pair.tactile_shape_gradients(GridBody::A, &grid, |_, _| force);
        for (expected, actual) in expected.iter().zip(&actual) {
            let largest = expected
                .by_vertices
                .iter()
                .map(Vector3::amax)
                .fold(1e-9, f64::max);
            for (expected, actual) in expected.by_vertices.iter().zip(&actual.by_vertices) {
                assert!((expected - actual).amax() < SAME_JACOBIAN * largest);
            }
            let largest = expected
                .by_extents
                .iter()
                .copied()
                .map(f64::abs)
                .fold(1e-9, f64::max);
            for (expected, actual) in expected.by_extents.iter().zip(&actual.by_extents) {
                assert!((expected - actual).abs() < SAME_JACOBIAN * largest);
            }
        }
    });
}

#[test]
fn a_pullback_is_the_transposed_pushforward() {
    let (pad, ball) = (cuboid([0.4, 0.4, 0.1]), icosphere(0.1, 2));
    let a = ContactBody::new(&pad, Pose::identity(), 1e5).unwrap();
    let b = ContactBody::new(&ball, turned([0.3, 0.2, 0.1], [0.03, 0.02, 0.14]), 3e5).unwrap();
    let grid = TaxelGrid::flat(&at(0.0, 0.0, 0.05), [0.4, 0.4], [20, 30]).unwrap();
    let linearized = ContactPair::new(a, b).linearized_tactile_image(GridBody::A, &grid);
    let mut random = Random::new(5);
    let change = SVector::<f64, COLUMNS>::from_fn(|_, _| random.between(-1.0, 1.0));
    let taxels = linearized.image().taxels().iter();
    let forward: f64 = taxels
        .zip(linearized.pushforward(&change))
        .map(|(taxel, change)| weight(taxel.row, taxel.column).dot(&change))
        .sum();
    let backward = linearized.pullback(weight).dot(&change);
    assert!(
        (forward - backward).abs() < 1e-10 * forward.abs(),
        "{forward} {backward}"
    );
}

#[test]
fn bodies_apart_have_an_image_of_zeros() {
    let ball = icosphere(0.1, 1);
    let body = |z| ContactBody::new(&ball, at(0.0, 0.0, z), 1e5).unwrap();
    let pair = ContactPair::new(body(0.0), body(1.0));
    let grid = TaxelGrid::dome(&Pose::identity(), [2.0; 2], [3, 4]).unwrap();
    let image = pair.linearized_tactile_image(GridBody::A, &grid);
    assert!(image.image().taxels().is_empty());
    assert_eq!(image.image().force(3, 2), Vector3::zeros());
    assert_eq!(image.image().mean_pressure(3, 2), 0.0);
    assert_eq!(image.image().force(9, 9), Vector3::zeros());
    assert_eq!(image.jacobian(3, 2).amax(), 0.0);
}

#[test]
fn axes_of_taxels_are_those_of_the_parametrization() {
    let frame = turned([0.4, -0.2, 0.9], [0.1, 0.2, 0.3]);
    let flat = TaxelGrid::flat(&frame, [0.2, 0.1], [4, 3]).unwrap();
    assert!((flat.axes(2, 1) - frame.rotation()).amax() < 1e-15);
    let dome = TaxelGrid::dome(&frame, [1.0, 2.0], [5, 4]).unwrap();
    let [a, b] = [0.4_f64, -0.75];
    let radial = frame.rotation() * vector![a.tan(), b.tan(), 1.0].normalize();
    let axes = dome.axes(0, 4);
    assert!((axes.column(2) - radial).amax() < 1e-15);
    assert!((axes.transpose() * axes - Matrix3::identity()).amax() < 1e-15);
    assert_eq!(
        dome.taxel_at(&frame.transformed_point(&vector![a.tan(), b.tan(), 1.0])),
        Some([0, 4])
    );
    assert_eq!(
        dome.taxel_at(&frame.transformed_point(&vector![0.0, 0.0, -1.0])),
        None
    );
    assert!((norm(&Vector3::from(axes.column(0))) - 1.0).abs() < 1e-15);
}

#[test]
fn bad_grids_are_refused() {
    let frame = Pose::identity();
    let zero_rows = TaxelGrid::flat(&frame, [1.0, 1.0], [3, 0]).unwrap_err();
    assert_eq!(
        zero_rows.to_string(),
        "a grid of taxels must have from 1 to 4096 rows, but has 0"
    );
    let nan = TaxelGrid::flat(&frame, [f64::NAN, 1.0], [3, 1]).unwrap_err();
    assert!(matches!(
        nan,
        TaxelGridError::Length {
            quantity: "width",
            ..
        }
    ));
    let nan = TaxelGrid::flat(&at(f64::NAN, 0.0, 0.0), [1.0, 1.0], [3, 1]).unwrap_err();
    assert!(matches!(nan, TaxelGridError::Pose(_)));
    let half = TaxelGrid::dome(&frame, [1.0, 3.2], [3, 1]).unwrap_err();
    assert!(matches!(
        half,
        TaxelGridError::Angle {
            quantity: "angle of the rows",
            ..
        }
    ));
    assert!(TaxelGrid::cylindrical(&frame, f64::NAN, 1.0, [3, 1]).is_err());
    assert!(TaxelGrid::cylindrical(&frame, 1.0, -1.0, [3, 1]).is_err());
    assert!(TaxelGrid::cylindrical(&frame, 1.0, 1.0, [3, 1 << 40]).is_err());
}

#[test]
fn planes_that_cross_in_the_patch_are_refused() {
    let field = |x: f64, y: f64, z: f64, offset: f64| AffineField {
        gradient: vector![x, y, z],
        offset,
    };
    let rows = [field(0.0, 1.0, 0.0, 1.0), field(0.0, 1.0, 0.0, -1.0)];
    let patch = |size: f64| Aabb {
        lower: Vector3::repeat(-size),
        upper: Vector3::repeat(size),
    };
    // The planes meet at x = 0.5, z = 1.
    let columns = [field(1.0, 0.0, -0.5, 0.0), field(1.0, 0.0, 0.0, -0.5)];
    assert!(TaxelGrid::new(&columns, &rows, &patch(0.9)).is_ok());
    let crossing = TaxelGrid::new(&columns, &rows, &patch(1.1)).unwrap_err();
    assert!(matches!(
        crossing,
        TaxelGridError::Crossing {
            family: "columns",
            plane: 0,
            ..
        }
    ));
    let swapped = [columns[1], columns[0]];
    assert!(matches!(
        TaxelGrid::new(&swapped, &rows, &patch(0.9)),
        Err(TaxelGridError::Crossing { .. })
    ));
    let inverted = TaxelGrid::new(&columns, &rows, &patch(-0.9));
    assert!(matches!(inverted, Err(TaxelGridError::Patch { .. })));
    let lost = [columns[0], field(f64::NAN, 0.0, 0.0, 1.0)];
    assert!(matches!(
        TaxelGrid::new(&lost, &rows, &patch(0.9)),
        Err(TaxelGridError::Plane { plane: 1, .. })
    ));
    assert!(matches!(
        TaxelGrid::new(&rows, &rows, &patch(0.9)),
        Err(TaxelGridError::Parallel { .. })
    ));
    assert!(matches!(
        TaxelGrid::new(&columns[..1], &rows, &patch(0.9)),
        Err(TaxelGridError::Count { count: 0, .. })
    ));
    let nowhere = patch(f64::NAN);
    assert!(TaxelGrid::new(&columns, &rows, &nowhere).is_err());
}
