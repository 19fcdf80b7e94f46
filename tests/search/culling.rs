//! The search changes the time a wrench takes, never the wrench.

use crate::support::scenes::{Random, mixed_shapes, pair, random_pair};
use hydroelastic::broad_phase::Projections;
use hydroelastic::contact::{ContactPair, Culling, Search, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Sums in another order round differently.
const SAME: f64 = 1e-12;

fn all_combinations() -> impl Iterator<Item = Culling> {
    (0..24).map(|bits| Culling {
        bounding_boxes: bits & 1 != 0,
        plane_check: bits & 2 != 0,
        tree: bits & 4 != 0,
        projections: [0, 5, Projections::COUNT][bits >> 3],
    })
}

fn assert_all_equal(pair: &ContactPair) {
    let wrench = |search| pair.with_search(search).wrench().on_a.to_vector();
    let expected = wrench(Search::Culling(Culling::NONE));
    let searches = all_combinations().map(Search::Culling);
    for search in searches.chain([Search::Following]) {
        let error = (wrench(search) - expected).amax();
        assert!(error <= SAME * expected.amax(), "{search:?}: {error:e}");
    }
}

#[test]
fn every_combination_gives_the_same_wrench_at_generic_poses() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(51));
    for _ in 0..40 {
        assert_all_equal(&random_pair(&shapes, &mut random));
    }
}

#[test]
fn every_combination_gives_the_same_wrench_at_aligned_poses() {
    let cube = Shape::new(shapes::cuboid([1.0; 3]).unwrap());
    for offset in [
        [0.0; 3],
        [0.5, 0.0, 0.0],
        [0.25, 0.5, 0.0],
        [1.0, 0.0, 0.0],
        [0.5; 3],
    ] {
        let moved = Pose::from_translation(offset.into());
        assert_all_equal(&pair((&cube, moved, 1.0), (&cube, Pose::identity(), 2.0)));
    }
}

#[test]
fn each_step_of_the_default_leaves_fewer_candidates() {
    let sphere = Shape::new(shapes::icosphere(1.0, 2).unwrap());
    let apart = Pose::from_translation(vector![0.1, 0.2, 1.5]);
    let pair = pair((&sphere, Pose::identity(), 1.0), (&sphere, apart, 1.0));
    let boxes = Culling {
        bounding_boxes: true,
        ..Culling::NONE
    };
    let projected = Culling {
        projections: Projections::COUNT,
        ..boxes
    };
    let count = |culling| pair.with_search(Search::Culling(culling)).work_count();
    let counts = [Culling::NONE, boxes, projected].map(count);
    assert_eq!(counts.map(|c| c.candidate_pairs), [102_400, 3_227, 683]);
    assert!(counts.iter().all(|c| c.polygons == counts[0].polygons));
    // The tree finds the pairs whose boxes overlap, and no others.
    assert_eq!(
        count(Culling {
            tree: true,
            ..boxes
        }),
        counts[1]
    );
    assert_eq!(count(Culling::default()), counts[2]);
}
