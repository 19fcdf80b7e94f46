//! A step of many bodies on one thread and on all threads. The bodies are icospheres of 80 tetrahedra in a cubic lattice, each pressed
//! slightly into its neighbors.
//!
//! Helps to decide at how many close pairs a step should use several threads, and whether the search for close pairs is cheap enough. In
//! `close`, the bodies touch. In `apart`, only their bounding boxes overlap, so the times contain little more than the search and the
//! threading overhead. Run `cargo bench --bench crowd`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;
use std::time::{Duration, Instant};

const RADIUS: f64 = 0.1;
/// Numbers of bodies along the edges of the lattice.
const LATTICES: [[usize; 3]; 4] = [[4, 1, 1], [3, 3, 1], [4, 4, 4], [8, 8, 8]];
/// Time step (s), so short that the lattice hardly moves.
const TIME_STEP: f64 = 1e-7;
/// Distances between neighbors, in radii. At the first distance the bodies touch; at the second only their bounding boxes overlap.
const SPACINGS: [(&str, f64); 2] = [("close", 1.9), ("apart", 2.05)];

fn lattice([nx, ny, nz]: [usize; 3], spacing: f64) -> World {
    let ball = Arc::new(Shape::new(shapes::icosphere(RADIUS, 1).unwrap()));
    let position = |index: usize| {
        let cell = [index % nx, index / nx % ny, index / nx / ny];
        Vector3::from(cell.map(|i| i as f64 * spacing * RADIUS))
    };
    let body = |index| {
        let (name, skin) = (index, Material::elastic(1e4));
        let body = Body::dynamic(
            &format!("{name}"),
            Arc::clone(&ball),
            skin,
            Mass::Total(1.0),
        );
        // With this rotation, the bounding boxes of the bodies are wider than the bodies.
        let turn = Vector3::z() * FRAC_PI_4;
        body.unwrap()
            .with_pose(Pose::from_rotation_vector(&turn, position(index)))
    };
    World::new((0..nx * ny * nz).map(body).collect()).unwrap()
}

fn crowd(criterion: &mut Criterion) {
    for (name, spacing) in SPACINGS {
        let mut group = criterion.benchmark_group(name);
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_secs(1));
        for counts in LATTICES {
            let world = lattice(counts, spacing);
            let count: usize = counts.iter().product();
            group.throughput(Throughput::Elements(count as u64));
            let mut rollout = world.rollout(&Plan::new(TIME_STEP, 0).unwrap());
            let mut time_of = |steps| {
                let start = Instant::now();
                (0..steps).for_each(|_| assert!(rollout.advance().is_ok()));
                start.elapsed()
            };
            group.bench_function(BenchmarkId::new("all threads", count), |b| {
                b.iter_custom(&mut time_of);
            });
            let single = rayon::ThreadPoolBuilder::new().num_threads(1);
            let single = single.build().unwrap();
            group.bench_function(BenchmarkId::new("one thread", count), |b| {
                b.iter_custom(|steps| single.install(|| time_of(steps)));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, crowd);
criterion_main!(benches);
