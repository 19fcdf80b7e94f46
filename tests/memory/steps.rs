//! Steps of a rollout allocate nothing once their buffers are large enough.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Integrator, Mass, Material, Plan, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::vector;
use std::sync::Arc;

/// Time step (s).
const TIME_STEP: f64 = 5e-4;

/// Steps before and during the count of allocations. In the former, all bodies fall on the floor and on each other; in the latter, they
/// continue to bounce.
const WARM_UP: usize = 600;
const COUNTED: usize = 600;

/// Returns three balls and an egg that fall on a floor, close enough to touch each other.
fn scene(skin: Material) -> World {
    let ball = Arc::new(Shape::new(shapes::icosphere(0.1, 1).unwrap()));
    let egg = Arc::new(Shape::new(shapes::ellipsoid([0.1, 0.14, 0.12], 1).unwrap()));
    let floor = Shape::new(shapes::cuboid([2.0, 2.0, 0.2]).unwrap());
    let falling = |name, shape: &Arc<Shape>, x, z| {
        let body = Body::dynamic(name, Arc::clone(shape), skin, Mass::Total(1.0)).unwrap();
        body.with_pose(Pose::from_translation(vector![x, 0.0, z]))
            .with_angular_velocity(vector![1.0, 2.0, 0.5])
    };
    World::new(vec![
        Body::fixed("floor", floor, skin).unwrap(),
        falling("left", &ball, 0.0, 0.21),
        falling("middle", &ball, 0.195, 0.21),
        falling("right", &ball, 0.39, 0.21),
        falling("egg", &egg, 0.195, 0.5),
    ])
    .unwrap()
    .with_gravity(vector![0.0, 0.0, -9.81])
    .unwrap()
}

/// Returns a plan without the stability check, which allocates when it linearizes contacts.
fn plan(integrator: Integrator) -> Plan {
    let plan = Plan::new(TIME_STEP, WARM_UP + COUNTED).unwrap();
    let plan = plan.with_integrator(integrator);
    plan.without_stability_check()
}

/// Returns the number of counted steps in which bodies touch.
fn touching_steps(world: &World, integrator: Integrator) -> usize {
    let rollout = world.rollout(&plan(integrator));
    let counted = rollout.skip(WARM_UP).take(COUNTED);
    let touching = |state| usize::from(world.topology(&state).unwrap().polygon_count() > 0);
    counted.map(Result::unwrap).map(touching).sum()
}

/// Returns the number of blocks that the counted steps allocate.
fn allocated_blocks(world: &World, integrator: Integrator) -> u64 {
    let mut rollout = world.rollout(&plan(integrator));
    for _ in 0..WARM_UP {
        rollout.advance().unwrap();
    }
    let before = dhat::HeapStats::get().total_blocks;
    for _ in 0..COUNTED {
        rollout.advance().unwrap();
    }
    dhat::HeapStats::get().total_blocks - before
}

#[test]
fn steps_allocate_nothing_once_a_rollout_is_warm() {
    let _alone = crate::alone();
    let _profiler = dhat::Profiler::builder().testing().build();
    let elastic = Material::elastic(1e5);
    let rubbing = elastic.with_dissipation(0.5).with_friction(0.4);
    for skin in [elastic, rubbing] {
        for integrator in [Integrator::Leapfrog, Integrator::SymplecticEuler] {
            let world = scene(skin);
            assert!(touching_steps(&world, integrator) > COUNTED / 10);
            let blocks = allocated_blocks(&world, integrator);
            assert_eq!(blocks, 0, "{integrator:?} {skin:?}");
        }
    }
}
