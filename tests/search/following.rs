//! Tracing the contact surface finds the same pairs of tetrahedra as a global search.

use crate::support::scenes::{Random, dented_ball, grid, mixed_shapes, pair, random_pair};
use crate::support::worlds::cuboid;
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::FRAC_PI_4;

/// Counts of the poses of a test, which ensure that the test has contacts.
#[derive(Default)]
pub struct Tally {
    poses: usize,
    touching: usize,
    polygons: usize,
    /// Numbers of pairs of tetrahedra examined by tracing and by culling, at every twentieth pose.
    looked_at: [usize; 2],
}

/// Area (m²) of a polygon that only one search may find, for bodies of size one: a sliver whose existence depends on round-off.
const SLIVER: f64 = 1e-12;

/// Returns the tetrahedra of all contact polygons.
fn touching(pair: &ContactPair) -> Vec<[usize; 2]> {
    let mut touching = pair.touching_tets();
    touching.sort_unstable();
    let repeats = touching.windows(2).any(|pair| pair[0] == pair[1]);
    assert!(!repeats, "a polygon was counted twice");
    touching
}

/// Returns the largest area (m²) of a polygon of `pair` that is not in `known_tets`.
fn largest_lonely(pair: &ContactPair, known_tets: &[[usize; 2]]) -> f64 {
    let polygons = pair.surface().polygons.into_iter();
    let lonely = polygons.filter(|polygon| known_tets.binary_search(&polygon.tets).is_err());
    lonely.map(|polygon| polygon.area).fold(0.0, f64::max)
}

impl Tally {
    pub fn compare(&mut self, pair: &ContactPair) {
        let everywhere = pair.with_search(Search::Culling(Culling::default()));
        let (actual, expected) = (touching(pair), touching(&everywhere));
        if actual != expected {
            let lonely = largest_lonely(pair, &expected).max(largest_lonely(&everywhere, &actual));
            assert!(
                lonely <= SLIVER,
                "{lonely:e}: {:?} {:?}",
                pair.a(),
                pair.b()
            );
        }
        if self.poses.is_multiple_of(20) {
            let counts = [pair, &everywhere].map(|pair| pair.work_count().candidate_pairs);
            self.looked_at[0] += counts[0];
            self.looked_at[1] += counts[1];
        }
        self.poses += 1;
        self.touching += usize::from(!expected.is_empty());
        self.polygons += expected.len();
    }

    /// Asserts that at least this percentage of the poses touch.
    pub fn assert_told_something(&self, name: &str, touching_percent: usize) {
        let Self {
            poses,
            touching,
            polygons,
            looked_at: [followed, culled],
        } = self;
        println!(
            "{name}: {touching} of {poses} poses touch, {polygons} polygons; {followed} pairs examined by tracing, {culled} by culling"
        );
        assert!(touching * 100 >= poses * touching_percent);
        // If tracing were impossible, both searches would examine the same pairs.
        assert!(followed < culled);
    }
}

fn at_origin(shape: &Shape, modulus: f64) -> (&Shape, Pose, f64) {
    (shape, Pose::identity(), modulus)
}

#[test]
fn at_generic_poses() {
    generic_poses(4_000);
}

#[test]
fn at_symmetric_poses() {
    symmetric_poses(6_000);
}

#[test]
fn at_nearly_symmetric_poses() {
    nearly_symmetric_poses(6_000);
}

#[test]
fn of_nested_and_dented_bodies() {
    nested_and_dented_bodies(4_000);
}

#[test]
#[ignore = "minutes: five times as many poses of each kind"]
fn at_many_poses() {
    generic_poses(20_000);
    symmetric_poses(30_000);
    nearly_symmetric_poses(30_000);
    nested_and_dented_bodies(20_000);
}

fn generic_poses(poses: usize) {
    let (shapes, mut random) = (mixed_shapes(), Random::new(61));
    let mut tally = Tally::default();
    for _ in 0..poses {
        tally.compare(&random_pair(&shapes, &mut random));
    }
    tally.assert_told_something("generic", 90);
}

#[test]
fn a_body_without_pressure_has_no_contact_surface() {
    let corners = [
        [-1.0, -1.0, -1.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let mesh = TetMesh::new(corners.map(Vector3::from).into(), vec![[0, 1, 2, 3]]).unwrap();
    let inert = Shape::new(PressureField::with_inert_tets(mesh, vec![0.0; 4]).unwrap());
    let cube = cuboid([1.0; 3]);
    for pair in [[&inert, &cube], [&cube, &inert]] {
        let pair = crate::support::scenes::pair(at_origin(pair[0], 1.0), at_origin(pair[1], 1.0));
        for search in [Search::Following, Search::Culling(Culling::default())] {
            assert!(pair.with_search(search).touching_tets().is_empty());
        }
    }
}

/// The poses have offsets on a lattice and rotations by eighths of a turn: planes through vertices, edges and faces, edges on edges, and
/// equal fields.
fn symmetric_poses(poses: usize) {
    let mut shapes = mixed_shapes();
    shapes.push(cuboid([1.0; 3]));
    shapes.push(Shape::new(grid(&[4, 4, 4], 0.25, |_| true).unwrap()));
    let ring = |[i, j, _]: [usize; 3]| i != 1 || j != 1;
    shapes.push(Shape::new(grid(&[3, 3, 1], 0.4, ring).unwrap()));
    let (mut random, mut tally) = (Random::new(62), Tally::default());
    for _ in 0..poses {
        let [a, distinct] = [0, 1].map(|_| random.below(shapes.len()));
        let b = [a, distinct][random.below(2)];
        let pose = symmetric_pose(&mut random);
        let modulus = [1.0, 1.0, 2.0, 10.0][random.below(4)];
        tally.compare(&pair(
            (&shapes[a], pose, modulus),
            at_origin(&shapes[b], 1.0),
        ));
    }
    tally.assert_told_something("symmetric", 50);
}

fn symmetric_pose(random: &mut Random) -> Pose {
    let step = [0.05, 0.1, 0.125, 0.25, 0.5][random.below(5)];
    let mut on_lattice = || (random.between(-1.5, 1.5) / step).round() * step;
    let offset = Vector3::from_fn(|_, _| on_lattice());
    let offset = match random.below(4) {
        0 => vector![offset.x, 0.0, 0.0],
        1 => vector![0.0, 0.0, offset.z],
        2 => vector![offset.x, offset.x, 0.0],
        _ => offset,
    };
    let turns = [0, random.below(8)][random.below(2)];
    let turn = Vector3::ith(random.below(3), FRAC_PI_4 * turns as f64);
    Pose::from_rotation_vector(&turn, offset)
}

/// The poses are symmetric up to an error larger than round-off and smaller than any other length.
fn nearly_symmetric_poses(poses: usize) {
    let (shapes, mut random) = (mixed_shapes(), Random::new(63));
    let mut tally = Tally::default();
    for _ in 0..poses {
        let [a, b] = [0, 1].map(|_| random.below(shapes.len()));
        let size = 10_f64.powf(random.between(-16.0, -4.0));
        let nudge = Pose::from_rotation_vector(&(random.vector() * size), random.vector() * size);
        let pose = nudge * symmetric_pose(&mut random);
        tally.compare(&pair((&shapes[a], pose, 1.0), at_origin(&shapes[b], 1.0)));
    }
    tally.assert_told_something("nearly symmetric", 50);
}

/// One body is inside the other, or fields have a dent inside. Contact surfaces have no boundary, or there are several.
fn nested_and_dented_bodies(poses: usize) {
    let mut shapes: Vec<Shape> = [[0.05, 1.0], [0.5, 1.0], [0.9, 1.0], [1.0, 0.3]]
        .iter()
        .map(|extents| Shape::new(dented_ball(1.0, 1, *extents)))
        .collect();
    for small in [shapes::icosphere(0.3, 1), shapes::cuboid([0.4, 0.5, 0.3])] {
        shapes.push(Shape::new(small.unwrap()));
    }
    shapes.push(Shape::new(dented_ball(0.4, 0, [0.2, 1.0])));
    shapes.push(cuboid([2.2, 2.4, 2.0]));
    shapes.push(Shape::new(grid(&[3, 3, 3], 0.6, |_| true).unwrap()));
    let (mut random, mut tally) = (Random::new(64), Tally::default());
    let mut without_rim = 0;
    for case in 0..poses {
        let [a, b] = [0, 1].map(|_| random.below(shapes.len()));
        let offset = random.vector() * [0.0, 0.2, 0.6][case % 3];
        let pose = Pose::from_rotation_vector(&random.rotation_vector(), offset);
        let modulus = 10_f64.powf(random.between(-1.0, 1.0));
        let pair = pair((&shapes[a], pose, modulus), at_origin(&shapes[b], 1.0));
        without_rim += usize::from(is_all_inside(&pair));
        tally.compare(&pair);
    }
    tally.assert_told_something("nested", 80);
    assert!(without_rim > poses / 20, "{without_rim}");
}

/// Returns whether the contact surface exists and lies inside both bodies' surfaces. It lies inside if its tetrahedra do or, because all
/// tetrahedra of a small mesh reach the surface, if all corners of its polygons have pressure.
pub fn is_all_inside(pair: &ContactPair) -> bool {
    let surface = pair.surface();
    let least = |polygon: &hydroelastic::contact::ContactPolygon| {
        let corners = polygon.outline.corners().iter();
        corners
            .map(|corner| polygon.pressure_at(corner))
            .fold(f64::INFINITY, f64::min)
    };
    !surface.is_empty() && surface.polygons.iter().all(|polygon| least(polygon) > 1e-9)
}
