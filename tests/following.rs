//! Following the contact surface finds all of it.

mod support;

use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::f64::consts::FRAC_PI_4;
use support::scenes::{Random, grid, mixed_shapes, pair, random_pair};

fn touching(pair: &ContactPair, search: Search) -> Vec<[usize; 2]> {
    let mut tets = pair.with_search(search).touching_tets();
    tets.sort_unstable();
    tets
}

#[derive(Default, Debug)]
struct Tally {
    poses: usize,
    touching: usize,
    polygons: usize,
    differing: usize,
}

fn compare(pair: &ContactPair, tally: &mut Tally) {
    let expected = touching(pair, Search::Culling(Culling::default()));
    let found = touching(pair, Search::Following);
    tally.poses += 1;
    tally.touching += usize::from(!expected.is_empty());
    tally.polygons += expected.len();
    if found != expected {
        tally.differing += 1;
        if tally.differing < 20 {
            let missing: Vec<_> = expected.iter().filter(|p| !found.contains(p)).collect();
            let extra: Vec<_> = found.iter().filter(|p| !expected.contains(p)).collect();
            let surface = pair
                .with_search(Search::Culling(Culling::default()))
                .surface();
            let areas: Vec<_> = surface
                .polygons
                .iter()
                .filter(|p| missing.contains(&&p.tets))
                .map(|p| p.area)
                .collect();
            println!(
                "{} of {}: missing {missing:?} {areas:?} extra {extra:?} {:?} {:?}",
                tally.poses,
                expected.len(),
                pair.a(),
                pair.b()
            );
        }
    }
}

#[test]
fn generic_poses() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(61));
    let mut tally = Tally::default();
    for _ in 0..20_000 {
        compare(&random_pair(&shapes, &mut random), &mut tally);
    }
    println!("{tally:?}");
    assert_eq!(tally.differing, 0);
}

#[test]
fn symmetric_poses() {
    let (mut shapes, mut random) = (mixed_shapes(), Random::new(62));
    shapes.push(Shape::new(shapes::cuboid([1.0, 1.0, 1.0]).unwrap()));
    shapes.push(Shape::new(grid(&[4, 4, 4], 0.25, |_| true).unwrap()));
    shapes.push(Shape::new(
        grid(&[3, 3, 1], 0.4, |[i, j, _]| i != 1 || j != 1).unwrap(),
    ));
    let mut tally = Tally::default();
    for _ in 0..20_000 {
        let [a, b] = [0, 1].map(|_| random.below(shapes.len()));
        let b = if random.below(2) == 0 { a } else { b };
        let step = [0.05, 0.1, 0.125, 0.25, 0.5][random.below(5)];
        let n = (1.5 / step) as usize;
        let offset = Vector3::from_fn(|_, _| (random.below(2 * n + 1) as f64 - n as f64) * step);
        let offset = match random.below(4) {
            0 => vector![offset.x, 0.0, 0.0],
            1 => vector![0.0, 0.0, offset.z],
            2 => vector![offset.x, offset.x, 0.0],
            _ => offset,
        };
        let turn = Vector3::ith(random.below(3), FRAC_PI_4 * random.below(8) as f64);
        let turn = if random.below(2) == 0 {
            Vector3::zeros()
        } else {
            turn
        };
        let modulus = [1.0, 1.0, 2.0, 10.0][random.below(4)];
        compare(
            &pair(
                (
                    &shapes[a],
                    Pose::from_rotation_vector(&turn, offset),
                    modulus,
                ),
                (&shapes[b], Pose::identity(), 1.0),
            ),
            &mut tally,
        );
    }
    println!("{tally:?}");
    assert_eq!(tally.differing, 0);
}
