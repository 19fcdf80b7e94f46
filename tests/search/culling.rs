//! The search affects the time of a wrench, but never the wrench.

use crate::support::scenes::{Random, grid, mixed_shapes, pair, random_pair};
use crate::support::worlds::{at, cuboid, icosphere};
use hydroelastic::broad_phase::Projections;
use hydroelastic::contact::{ContactBody, ContactPair, Culling, HalfSpace, Partner, Search, Shape};
use hydroelastic::spatial::Pose;
use nalgebra::vector;

/// Relative tolerance, because the order of summation changes rounding errors.
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
    let cube = cuboid([1.0; 3]);
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
    let sphere = icosphere(1.0, 2);
    let apart = at(0.1, 0.2, 1.5);
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
    // The tree finds exactly the pairs whose boxes overlap.
    assert_eq!(
        count(Culling {
            tree: true,
            ..boxes
        }),
        counts[1]
    );
    assert_eq!(count(Culling::default()), counts[2]);
}

/// Rounding error of heights (m) for shapes of size 1. A corner within this height is on the plane.
const ON_PLANE: f64 = 1e-13;

/// Asserts that candidates at a half-space are exactly the tetrahedra with a corner below or on its surface. If the half-space is rigid,
/// they must have another corner above or on the surface. Returns how many tetrahedra cross the surface, how many reach it, and how many
/// exist.
fn assert_reaching_are_candidates(shape: &Shape, pose: Pose, ground: Pose) -> [usize; 3] {
    let body = ContactBody::new(shape, pose, 1e5).unwrap();
    let to_ground = ground.inverse() * pose;
    let heights = shape.field().tets().iter().map(|tet| {
        let corners = tet.tetrahedron.corners.iter();
        corners.map(|corner| to_ground.transformed_point(corner).z)
    });
    let [mut reaching, mut crossing] = [0, 0];
    for heights in heights {
        let lowest = heights.clone().fold(f64::INFINITY, f64::min);
        let highest = heights.fold(f64::NEG_INFINITY, f64::max);
        reaching += usize::from(lowest <= ON_PLANE);
        crossing += usize::from(lowest <= ON_PLANE && highest >= -ON_PLANE);
    }
    let layer = HalfSpace::layer(0.3).unwrap();
    let partners = [
        (Partner::half_space(&layer, ground, 1e6).unwrap(), reaching),
        (Partner::rigid_half_space(ground).unwrap(), crossing),
    ];
    for (partner, expected) in partners {
        for search in [Search::Following, Search::Culling(Culling::default())] {
            let pair = ContactPair::new(body, partner).with_search(search);
            assert_eq!(pair.work_count().candidate_pairs, expected, "{search:?}");
        }
    }
    [crossing, reaching, shape.field().tets().len()]
}

#[test]
fn candidates_at_a_half_space_are_the_tetrahedra_that_reach_it() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(52));
    let mut tells_apart = 0;
    for shape in &shapes {
        for _ in 0..20 {
            let [body, ground] = [0.9, 0.3].map(|away| {
                Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * away)
            });
            let [crossing, reaching, all] = assert_reaching_are_candidates(shape, body, ground);
            tells_apart += usize::from(0 < crossing && crossing < reaching && reaching < all);
        }
    }
    assert!(tells_apart > shapes.len(), "{tells_apart}");
}

#[test]
fn tetrahedra_flush_with_a_half_space_are_candidates() {
    let block = cuboid([1.0; 3]);
    let cells = Shape::new(grid(&[4, 3, 2], 0.25, |_| true).unwrap());
    // The surface is on the plane from above and from below, and so is the center, which for the cells is a layer of inner faces.
    for (shape, half) in [(&block, 0.5), (&cells, 0.25)] {
        for height in [half, 0.0, -half] {
            for turn in [0.0, 0.4] {
                let turn = vector![0.0, 0.0, turn];
                let pose = Pose::from_rotation_vector(&turn, vector![0.2, 0.1, height]);
                assert_reaching_are_candidates(shape, pose, Pose::identity());
            }
        }
    }
}
