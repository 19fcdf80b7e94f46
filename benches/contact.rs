//! The contact wrench in `f64` and with 6-, 8- and 14-wide dual numbers, and the closed-form
//! Jacobian, for two icospheres of radius 1 at centre distances 1.0 (deep) and 1.7 (light).
//!
//! Serves two decisions: whether differentiating through the generic pipeline is affordable, and
//! what the closed form saves. Run `cargo bench --bench contact`; compare within one run.
//!
//! The duals carry derivatives by: 6, the pose of A; 8, the pose of A and both moduli; 14, both
//! poses and both moduli.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::{Scalar, lift};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{SVector, Vector3, Vector6};
use num_dual::{DualSVec64, jacobian};
use std::hint::black_box;
use std::time::Duration;

const ORDERS: [usize; 4] = [1, 2, 3, 4];
const DISTANCES: [f64; 2] = [1.0, 1.7];

/// A generic pose of A near the x axis.
fn pose_a(distance: f64) -> Pose {
    let position = Vector3::new(0.98, 0.12, 0.16).normalize() * distance;
    Pose::from_rotation_vector(&Vector3::new(0.3, -0.5, 0.2), position)
}

fn pair<T: Scalar>(shape: &Shape, poses: [Pose<T>; 2], moduli: [T; 2]) -> ContactPair<'_, T> {
    let body = |k: usize| ContactBody::new(shape, poses[k], moduli[k]).unwrap();
    ContactPair::new(body(0), body(1))
}

/// The derivatives of the wrench on A by the first N of: pose A, moduli, pose B.
fn dual_wrench<const N: usize>(shape: &Shape, distance: f64) -> nalgebra::SMatrix<f64, 6, N> {
    let wrench = |x: SVector<DualSVec64<N>, N>| {
        let at = |i: usize| if i < N { x[i] } else { lift(0.0) };
        let twist = |first: usize| Twist::from_vector(&Vector6::from_fn(|i, _| at(first + i)));
        let pose_a = Pose::lifted(&pose_a(distance)).moved_by(&twist(0));
        let pose_b = Pose::identity().moved_by(&twist(8));
        let moduli = [
            at(6) + lift::<DualSVec64<N>>(1.0),
            at(7) + lift::<DualSVec64<N>>(1.0),
        ];
        let wrench = pair(shape, [pose_a, pose_b], moduli).wrench();
        wrench.on_a.to_vector()
    };
    jacobian(wrench, &SVector::zeros()).1
}

fn contact(criterion: &mut Criterion) {
    for distance in DISTANCES {
        let mut group = criterion.benchmark_group(format!("distance {distance}"));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(200))
            .measurement_time(Duration::from_secs(1));
        for order in ORDERS {
            let shape = Shape::new(shapes::icosphere(1.0, order).unwrap());
            let poses = [pose_a(distance), Pose::identity()];
            let real = pair(&shape, poses, [1.0, 1.0]);
            let id = |name: &str| BenchmarkId::new(name, order);
            group.bench_function(id("f64"), |b| b.iter(|| black_box(&real).wrench()));
            group.bench_function(id("closed-form Jacobian"), |b| {
                b.iter(|| black_box(&real).wrench_and_jacobian());
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

criterion_group!(benches, contact);
criterion_main!(benches);
