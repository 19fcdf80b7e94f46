//! The contact wrench in `f64` and with 6-, 8- and 14-wide dense dual numbers, and its closed-form Jacobian. The scene is two icospheres of
//! radius 1 at center distances 1.0 (deep) and 1.7 (light).
//!
//! Helps to decide whether differentiating through the generic pipeline is affordable, and how much the closed form saves. Run
//! `RAYON_NUM_THREADS=1 cargo bench --bench contact` for one thread, and compare times within one run only.
//!
//! `potential energy` measures the potential energy of the pairs at 1.0, to compare with their wrenches. `in motion` measures the wrench of
//! a ball on a box with friction and dissipation, without and with its linearization.
//!
//! The dual numbers carry derivatives with respect to the pose of A (6), the pose of A and both moduli (8), or both poses and both moduli
//! (14).

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, criterion_group, criterion_main};
use hydroelastic::contact::{ContactBody, ContactPair, Shape, SurfaceLaw};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{DenseDual, Scalar, lift};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, Vector6};
use std::hint::black_box;
use std::time::Duration;

const ORDERS: [usize; 4] = [1, 2, 3, 4];
const DISTANCES: [f64; 2] = [1.0, 1.7];

/// Returns a generic pose of A near the x axis.
fn pose_a(distance: f64) -> Pose {
    let position = Vector3::new(0.98, 0.12, 0.16).normalize() * distance;
    Pose::from_rotation_vector(&Vector3::new(0.3, -0.5, 0.2), position)
}

fn pair<T: Scalar>(shape: &Shape, poses: [Pose<T>; 2], moduli: [T; 2]) -> ContactPair<'_, T> {
    let body = |k: usize| ContactBody::new(shape, poses[k], moduli[k]).unwrap();
    ContactPair::new(body(0), body(1))
}

/// Returns the wrench on A with derivatives with respect to the first N of these: pose of A, moduli, pose of B.
fn dual_wrench<const N: usize>(shape: &Shape, distance: f64) -> Vector6<DenseDual<N>> {
    let seed = |value: f64, index: usize| {
        if index < N {
            DenseDual::<N>::variable(value, index)
        } else {
            lift(value)
        }
    };
    let twist =
        |first: usize| Twist::from_vector(&Vector6::from_fn(|row, _| seed(0.0, first + row)));
    let pose_a = Pose::lifted(&pose_a(distance)).moved_by(&twist(0));
    let pose_b = Pose::identity().moved_by(&twist(8));
    let moduli = [seed(1.0, 6), seed(1.0, 7)];
    let pair = pair(shape, [pose_a, pose_b], moduli);
    pair.pipeline().wrench().on_a.to_vector()
}

/// Creates a benchmark group in which each measurement takes little more than a second.
fn short_group<'c>(criterion: &'c mut Criterion, name: &str) -> BenchmarkGroup<'c, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1));
    group
}

fn contact(criterion: &mut Criterion) {
    for distance in DISTANCES {
        let mut group = short_group(criterion, &format!("distance {distance}"));
        for order in ORDERS {
            let shape = Shape::new(shapes::icosphere(1.0, order).unwrap());
            let poses = [pose_a(distance), Pose::identity()];
            let real = pair(&shape, poses, [1.0, 1.0]);
            let id = |name: &str| BenchmarkId::new(name, order);
            group.bench_function(id("f64"), |b| b.iter(|| black_box(&real).wrench()));
            group.bench_function(id("closed-form Jacobian"), |b| {
                b.iter(|| black_box(&real).linearized());
            });
            group.bench_function(id("dual 6"), |b| {
                b.iter(|| dual_wrench::<6>(&shape, distance));
            });
            group.bench_function(id("dual 8"), |b| {
                b.iter(|| dual_wrench::<8>(&shape, distance));
            });
            group.bench_function(id("dual 14"), |b| {
                b.iter(|| dual_wrench::<14>(&shape, distance));
            });
        }
        group.finish();
    }
}

/// Measures the potential energy, whose integral visits all overlapping tetrahedra.
fn energy(criterion: &mut Criterion) {
    let mut group = short_group(criterion, "potential energy");
    for order in ORDERS {
        let shape = Shape::new(shapes::icosphere(1.0, order).unwrap());
        let poses = [pose_a(DISTANCES[0]), Pose::identity()];
        let real = pair(&shape, poses, [1.0, 1.0]);
        group.bench_function(BenchmarkId::new("f64", order), |b| {
            b.iter(|| black_box(&real).potential_energy());
        });
    }
    group.finish();
}

/// Measures the wrench of a ball that slides and spins on a box with dissipation and friction, without and with all derivatives.
fn motion(criterion: &mut Criterion) {
    let slab = Shape::new(shapes::cuboid([0.4, 0.4, 0.2]).unwrap());
    let pose = Pose::from_rotation_vector(
        &Vector3::new(0.3, 0.2, 0.1),
        Vector3::new(0.01, 0.02, -0.195),
    );
    let law = SurfaceLaw::new(0.3, 0.4, 1e-2).unwrap();
    let sliding = Twist {
        angular: Vector3::new(0.5, 0.4, 1.0),
        linear: Vector3::new(0.3, 0.2, -0.05),
    };
    let mut group = short_group(criterion, "in motion");
    for order in [2, 3] {
        let ball = Shape::new(shapes::icosphere(0.1, order).unwrap());
        let pair = ContactPair::new(
            ContactBody::new(&ball, Pose::identity(), 1e5).unwrap(),
            ContactBody::new(&slab, pose, 2e5).unwrap(),
        );
        let twists = [sliding, Twist::zero()];
        let id = |name: &str| BenchmarkId::new(name, order);
        group.bench_function(id("f64"), |b| {
            b.iter(|| black_box(&pair).moving(law, twists).wrench());
        });
        group.bench_function(id("linearized"), |b| {
            b.iter(|| black_box(&pair).moving(law, twists).linearized());
        });
    }
    group.finish();
}

criterion_group!(benches, contact, energy, motion);
criterion_main!(benches);
