//! Cost of a contact partner: steps of a ball at rest on a compliant box, a rigid box and half-spaces, and the wrench of a ball on rigid
//! surfaces of increasing triangle count.
//!
//! Helps to decide which kind of body to use for a floor or a tool. Compare a step on a half-space with a step on a box. The time on a scan
//! of a million triangles should depend only on the triangles in contact. Run `cargo bench --bench partners`, and compare times within one
//! run only.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape};
use hydroelastic::dynamics::{Body, Mass, Material, Plan, World};
use hydroelastic::mesh::{TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::hint::black_box;
use std::time::Duration;

const STEPS: usize = 100;
const TIME_STEP: f64 = 2e-4;
const SETTLING_STEPS: usize = 5_000;
const RADIUS: f64 = 0.1;

fn skin(rubs: bool) -> Material {
    let friction = if rubs { 0.4 } else { 0.0 };
    Material::elastic(1e5)
        .with_dissipation(1.0)
        .with_friction(friction)
}

/// Floors with the upper side z = 0.
fn floors(skin: Material) -> [(&'static str, Body); 4] {
    let hard = Material {
        modulus: None,
        ..skin
    };
    let cube = shapes::cuboid([1.0; 3]).unwrap();
    let surface = TriangleSurface::around(cube.mesh()).unwrap();
    let below = Pose::from_translation(Vector3::z() * -0.5);
    let soft_box = Body::fixed("floor", Shape::new(cube), skin).unwrap();
    let rigid_box = Body::fixed("floor", RigidShape::new(surface), hard).unwrap();
    let layer = HalfSpace::layer(0.1).unwrap();
    [
        ("compliant box", soft_box.with_pose(below)),
        ("rigid box", rigid_box.with_pose(below)),
        (
            "compliant half-space",
            Body::fixed("floor", layer, skin).unwrap(),
        ),
        (
            "rigid half-space",
            Body::fixed("floor", HalfSpace::rigid(), hard).unwrap(),
        ),
    ]
}

/// A ball that has come to rest.
fn at_rest(order: usize, floor: &Body, skin: Material) -> World {
    let ball = Shape::new(shapes::icosphere(RADIUS, order).unwrap());
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(1.0)).unwrap();
    let turned = Pose::from_rotation_vector(&vector![0.3, -0.5, 0.2], vector![0.02, 0.05, 0.096]);
    let world = World::new(vec![ball.with_pose(turned), floor.clone()]).unwrap();
    let world = world.with_gravity(Vector3::z() * -9.81).unwrap();
    let settling = Plan::new(TIME_STEP, SETTLING_STEPS).unwrap();
    let states = world.rollout(&settling.recording_every(SETTLING_STEPS));
    let rest = states.run().unwrap().last().clone();
    world.with_initial_state(&rest).unwrap()
}

fn steps(criterion: &mut Criterion) {
    for (material, rubs) in [("sliding", false), ("rubbing", true)] {
        let mut group = criterion.benchmark_group(format!("steps/{material}"));
        group.throughput(Throughput::Elements(STEPS as u64));
        group
            .sample_size(10)
            .measurement_time(Duration::from_secs(2));
        let plan = Plan::new(TIME_STEP, STEPS).unwrap().recording_every(STEPS);
        for order in [2, 3] {
            for (floor, body) in floors(skin(rubs)) {
                let world = at_rest(order, &body, skin(rubs));
                let id = BenchmarkId::new(floor, order);
                group.bench_function(id, |bencher| {
                    bencher.iter(|| black_box(&world).rollout(&plan).run().unwrap());
                });
            }
        }
        group.finish();
    }
}

/// Measures a ball of order 3 pressed into large rigid balls of ever more triangles, whose size stays about that of the first ball.
fn scans(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rigid scan");
    group.sample_size(20);
    let ball = Shape::new(shapes::icosphere(RADIUS, 3).unwrap());
    for order in [4, 6, 8] {
        // The radius grows with the number of triangles, so the contact keeps its size.
        let scale = 0.15 * f64::from(1_u32 << order);
        let field = shapes::icosphere(scale, order).unwrap();
        let scan = RigidShape::new(TriangleSurface::around(field.mesh()).unwrap());
        let triangles = scan.surface().triangles().len();
        let pose = Pose::from_translation(vector![0.01, 0.02, scale + RADIUS - 0.005]);
        let pair = ContactPair::new(
            ContactBody::new(&ball, pose, 1e5).unwrap(),
            Partner::rigid(&scan, Pose::identity()).unwrap(),
        );
        println!("{triangles} triangles: {:?}", pair.work_count());
        group.bench_function(BenchmarkId::new("wrench", triangles), |bencher| {
            bencher.iter(|| black_box(&pair).wrench());
        });
    }
    group.finish();
}

criterion_group!(benches, steps, scans);
criterion_main!(benches);
