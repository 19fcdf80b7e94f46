//! Worlds of balls on a box.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Mass, Material, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::sync::Arc;

/// Time step (s).
pub const TIME_STEP: f64 = 2e-4;

/// Radius (m) of a ball, whose mass is 1 kg.
const RADIUS: f64 = 0.1;

/// Number of subdivisions of a ball's mesh.
const ORDER: usize = 2;

/// Distance (m) between the centers of neighbors, which are slightly pressed into each other.
const SPACING: f64 = 0.19;

/// Height (m) of the lowest centers above the floor, at which a single ball rests.
const LOWEST: f64 = 0.088;

/// Largest offset (m) of a ball from its lattice position along each axis.
const JITTER: f64 = 0.001;

/// Returns a lattice with the given numbers of balls along x, y and z. The balls are at rest, slightly pressed into each other and into a
/// fixed box below.
pub fn heap(counts: [usize; 3], skin: Material) -> World {
    let mut random = StdRng::seed_from_u64(2);
    let ball = Arc::new(Shape::new(shapes::icosphere(RADIUS, ORDER).unwrap()));
    let mut bodies = vec![floor(counts, skin)];
    for position in positions(counts) {
        let off = Vector3::from_fn(|_, _| random.random_range(-JITTER..JITTER));
        let turn = Vector3::from_fn(|_, _| random.random_range(-3.0..3.0));
        let name = format!("ball {}", bodies.len() - 1);
        let body = Body::dynamic(&name, Arc::clone(&ball), skin, Mass::Total(1.0)).unwrap();
        bodies.push(body.with_pose(Pose::from_rotation_vector(&turn, position + off)));
    }
    under_gravity(bodies)
}

/// Returns one ball at rest on the box, so that every step has the same contact.
pub fn resting_ball(skin: Material) -> World {
    let damped = heap([1; 3], skin.with_dissipation(20.0));
    let rest = final_state(&damped, 20_000);
    let world = heap([1; 3], skin);
    let bodies = world.bodies().iter().zip(&rest.bodies);
    let at_rest = bodies.map(|(body, state)| body.clone().with_pose(state.pose));
    under_gravity(at_rest.collect())
}

fn under_gravity(bodies: Vec<Body>) -> World {
    let world = World::new(bodies).unwrap();
    world.with_gravity(Vector3::new(0.0, 0.0, -9.81)).unwrap()
}

/// Returns the positions of a lattice whose corner is above the origin.
fn positions([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = Vector3<f64>> {
    (0..nx * ny * nz).map(move |index| {
        let cell = Vector3::new(index % nx, index / nx % ny, index / (nx * ny));
        cell.map(|n| n as f64) * SPACING + Vector3::z() * LOWEST
    })
}

/// Creates a box under the lattice, with a margin.
fn floor([nx, ny, _]: [usize; 3], skin: Material) -> Body {
    let [x, y] = [nx, ny].map(|n| (n - 1) as f64 * SPACING);
    let shape = Shape::new(shapes::cuboid([x + 1.0, y + 1.0, 0.5]).unwrap());
    let center = Vector3::new(x / 2.0, y / 2.0, -0.25);
    let body = Body::fixed("floor", shape, skin).unwrap();
    body.with_pose(Pose::from_translation(center))
}

/// Returns the state after `steps` steps. The stability check is off in all rollouts here: it linearizes contacts in steps above half of the
/// stable step, as those of heaps are, and would dominate the times.
pub fn final_state(world: &World, steps: usize) -> State {
    let plan = Plan::new(TIME_STEP, steps)
        .unwrap()
        .without_stability_check()
        .recording_every(steps);
    world.rollout(&plan).run().unwrap().last().clone()
}
