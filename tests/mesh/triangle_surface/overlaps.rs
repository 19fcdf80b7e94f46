//! Components of a surface that overlap.

use super::sample_surfaces::{
    Triangulation, block, reversed, surface, together, torus, unit_block,
};
use hydroelastic::mesh::SurfaceWarning;
use nalgebra::{Vector3, vector};
use std::time::{Duration, Instant};

/// Error of volumes from rays, relative to the volume of the overlap.
const RAYS: f64 = 0.03;

/// Time limit for the check of a large surface, which took 0.13 s in the last measurement.
const TIME: Duration = Duration::from_secs(5);

/// Returns the number of pairs that overlap, and the estimate of the volume that counts twice.
fn overlap(parts: impl IntoIterator<Item = Triangulation>) -> Option<(usize, f64)> {
    let warnings = surface(together(parts)).warnings();
    match warnings[..] {
        [] => None,
        [
            SurfaceWarning::Overlap {
                pair_count,
                volume,
                near,
            },
        ] => {
            assert!(near.iter().all(|x| x.is_finite()));
            Some((pair_count, volume))
        }
        _ => panic!("{warnings:?}"),
    }
}

fn cube(x: f64, y: f64, z: f64) -> Triangulation {
    unit_block(vector![x, y, z])
}

#[test]
fn the_common_volume_of_overlapping_parts_is_reported() {
    let cases = [
        (cube(0.5, 0.0, 0.0), 0.5),
        (cube(0.8, 0.8, 0.8), 0.008),
        (block(Vector3::repeat(0.25), Vector3::repeat(0.5)), 0.125),
        (block(vector![0.4, 0.4, -1.0], vector![0.2, 0.2, 3.0]), 0.04),
        (cube(0.0, 0.0, 0.0), 1.0),
    ];
    for (other, expected) in cases {
        let (pair_count, volume) = overlap([cube(0.0, 0.0, 0.0), other]).unwrap();
        assert_eq!(pair_count, 1);
        assert!(
            (volume / expected - 1.0).abs() < RAYS,
            "{volume} {expected}"
        );
    }
    // A ring through a ring crosses it twice.
    let ring = torus(1.0, 0.3, [40, 20]);
    let quarter_turn = |v: &Vector3<f64>| vector![v.x + 1.0, -v.z, v.y];
    let other = (ring.0.iter().map(quarter_turn).collect(), ring.1.clone());
    assert_eq!(overlap([ring.clone(), other]), None);
    let moved = (
        ring.0.iter().map(|v| v + vector![0.2, 0.0, 0.0]).collect(),
        ring.1.clone(),
    );
    assert!(overlap([ring, moved]).is_some());
}

#[test]
fn parts_that_touch_and_parts_in_cavities_do_not_overlap() {
    let touching = [
        cube(0.0, 0.0, 0.0),
        cube(1.0, 0.0, 0.0),
        cube(1.0 - 1e-9, 1.0 - 1e-9, 0.0),
        cube(5.0, 0.0, 0.0),
    ];
    assert_eq!(overlap(touching), None);
    let outer = || block(Vector3::repeat(-2.0), Vector3::repeat(5.0));
    let cavity = || reversed(block(Vector3::repeat(-1.0), Vector3::repeat(3.0)));
    assert_eq!(overlap([outer(), cavity(), cube(0.0, 0.0, 0.0)]), None);
    let through_the_wall = overlap([outer(), cavity(), cube(1.5, 0.0, 0.0)]);
    let (_, volume) = through_the_wall.unwrap();
    assert!((volume / 0.5 - 1.0).abs() < RAYS, "{volume}");
}

#[test]
fn large_surfaces_are_checked_quickly() {
    let plates = (0..200).map(|k| cube(f64::from(k) * 0.2, 0.0, 0.0));
    let parts = surface(together(plates.chain([torus(1.0, 0.3, [300, 150])])));
    let start = Instant::now();
    let warnings = parts.warnings();
    let are_expected = matches!(
        warnings[..],
        [SurfaceWarning::Overlap { .. }, SurfaceWarning::Size { .. }]
    );
    assert!(are_expected, "{warnings:?}");
    let elapsed = start.elapsed();
    println!("{} triangles: {elapsed:.2?}", parts.triangles().len());
    assert!(elapsed < TIME, "{elapsed:?}");
}

#[test]
fn pairs_that_are_not_searched_are_reported() {
    // 92 blocks make 4,186 pairs.
    let nested = |count: usize| {
        let blocks = (0..count).map(|k| unit_block(Vector3::repeat(k as f64 * 0.01)));
        surface(together(blocks)).warnings()
    };
    let limit = SurfaceWarning::UnsearchedPairs { pair_count: 4096 };
    assert_eq!(nested(92).last(), Some(&limit));
    assert_eq!(nested(3).len(), 1);
}
