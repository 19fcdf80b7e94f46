//! A step of many bodies, by one thread and by all: icospheres (80 tetrahedra each) in a cubic
//! lattice, each pressed a little into its neighbors.
//!
//! Serves two decisions: from how many close pairs on a step is spread over threads, and whether
//! finding them costs as little as it should. `close` bodies touch, `apart` only their boxes do, so
//! that hardly more than the search and the threads is measured. Run `cargo bench --bench crowd`.

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
/// Bodies along the edges of the lattice.
const LATTICES: [[usize; 3]; 4] = [[4, 1, 1], [3, 3, 1], [4, 4, 4], [8, 8, 8]];
/// Time step (s): so short that the lattice stays as it is.
const TIME_STEP: f64 = 1e-7;
/// Distances of neighbors, in radii: they touch; they do not, but their boxes do.
const SPACINGS: [(&str, f64); 2] = [("close", 1.9), ("apart", 2.05)];

fn lattice([nx, ny, nz]: [usize; 3], spacing: f64) -> World {
    let ball = Arc::new(Shape::new(shapes::icosphere(RADIUS, 1).unwrap()));
    let place = |index: usize| {
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
        // Their boxes are wider than they are.
        let turn = Vector3::z() * FRAC_PI_4;
        body.unwrap()
            .with_pose(Pose::from_rotation_vector(&turn, place(index)))
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
