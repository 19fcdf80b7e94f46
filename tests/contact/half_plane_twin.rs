//! The contact kernel against its slow, independent twin.

use crate::support::half_planes;
use crate::support::scenes::{Random, mixed_shapes, random_pair};
use nalgebra::Vector6;

/// Relative error of the twin, which inverts a matrix per tetrahedron and accepts corners slightly outside its half-planes.
const TWIN: f64 = 1e-10;

#[test]
fn wrench_and_area_equal_those_of_intersected_half_planes() {
    let (shapes, mut random) = (mixed_shapes(), Random::new(31));
    let mut touching = 0;
    for _ in 0..150 {
        let pair = random_pair(&shapes, &mut random);
        let (twin, wrench) = (half_planes::wrench(&pair), pair.wrench());
        let wrench: Vector6<f64> = wrench.on_a.to_vector();
        let error = (wrench - twin.wrench).amax();
        assert!(error <= TWIN * twin.wrench.amax(), "{error:e}");
        assert!((pair.surface().area() - twin.area).abs() <= TWIN * twin.area);
        touching += usize::from(twin.area > 0.0);
    }
    assert!(touching > 140, "only {touching} of 150 pairs touch");
}
