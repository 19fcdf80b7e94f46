//! Following the contact surface finds all of it.

mod support;

use hydroelastic::contact::{ContactPair, Culling, Search};
use support::scenes::{Random, mixed_shapes, random_pair};

fn touching(pair: &ContactPair, search: Search) -> Vec<[usize; 2]> {
    let mut tets = pair.with_search(search).touching_tets();
    tets.sort_unstable();
    tets
}

#[test]
fn generic_poses() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(61));
    let mut polygons = 0;
    for case in 0..2_000 {
        let pair = random_pair(&shapes, &mut random);
        let expected = touching(&pair, Search::Culling(Culling::default()));
        let found = touching(&pair, Search::Following);
        polygons += expected.len();
        assert_eq!(found, expected, "case {case}");
    }
    println!("{polygons} polygons");
}
