//! A block on a floor, its goal, and the costs of pushes and of missing the goal.

use hydroelastic::contact::Shape;
use hydroelastic::dynamics::{Body, Control, Mass, Material, Plan, State, World};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Vector3, Vector6, vector};
use std::error::Error;

const GRAVITY: f64 = 9.81;
/// Edges (m), mass (kg) and friction of the block.
const SIZE: [f64; 3] = [0.2, 0.2, 0.1];
const MASS: f64 = 1.0;
const FRICTION: f64 = 0.3;
/// Slip tolerance (m/s), below which friction is less than full.
const SLIP_TOLERANCE: f64 = 1e-2;

/// Time step (s).
pub const TIME_STEP: f64 = 1e-3;
/// Number of steps until the block has settled.
const SETTLING: usize = 500;
/// Number of steps with pushes.
pub const STEPS: usize = 1_000;

/// Goal of the block at rest: position (m) and angle (rad).
const GOAL: [f64; 2] = [0.3, 0.2];
const ANGLE: f64 = 0.8;

/// Tolerances of the goal: position (m), angle (rad), speed (m/s).
pub const NEAR: [f64; 3] = [1e-3, 1e-2, 1e-2];

/// Components of a wrench that a push may have: torque about the vertical, and force along x and y.
pub const PUSHES: [usize; 3] = [2, 3, 4];
/// Cost of pushes per second: of a torque (1/((N m)² s)) and of forces (1/(N² s)).
const EFFORTS: [f64; 3] = [0.2, 2e-3, 2e-3];
/// Costs of the final distance from the goal: angle (1/rad²), position (1/m²), angular velocity (s²/rad²), velocity (s²/m²).
pub const BY_ANGLE: f64 = 2e3;
pub const BY_PLACE: f64 = 2e4;
pub const BY_SPIN: f64 = 50.0;
pub const BY_VELOCITY: f64 = 2e3;

/// Result of this example, with any error.
pub type Found<T> = Result<T, Box<dyn Error>>;

/// The block at rest on the floor without pushes, and at rest at the goal.
pub struct Scene {
    pub world: World,
    pub goal: State,
}

/// The pushes found, as a world with a control, and the cost of each iteration.
pub struct Pushed {
    pub world: World,
    pub costs: Vec<f64>,
}

impl Scene {
    /// Creates the block and lets it settle.
    pub fn new() -> Found<Self> {
        let skin = Material::elastic(1e6)
            .with_dissipation(1.0)
            .with_friction(FRICTION);
        let block = Shape::new(shapes::cuboid(SIZE)?);
        let floor = Shape::new(shapes::cuboid([3.0, 3.0, 0.2])?);
        let world = World::new(vec![
            Body::dynamic("block", block, skin, Mass::Total(MASS))?
                .with_pose(Pose::from_translation(vector![0.0, 0.0, 0.15])),
            Body::fixed("floor", floor, skin)?,
        ])?
        .with_gravity(vector![0.0, 0.0, -GRAVITY])?
        .with_slip_tolerance(SLIP_TOLERANCE)?;
        let rest = world.rollout(&Plan::new(TIME_STEP, SETTLING)?.recording_every(SETTLING));
        let mut start = rest.run()?.last().clone();
        start.time = 0.0;
        let goal = goal(&start);
        let world = world.with_initial_state(&start)?;
        Ok(Self { world, goal })
    }

    /// Returns the world with a control of `intervals` intervals in total and zero pushes.
    pub fn with_intervals(&self, intervals: usize) -> Found<World> {
        let none = vec![Wrench::zero(); intervals];
        let duration = TIME_STEP * (STEPS / intervals) as f64;
        let control = Control::new("block", duration, none)?;
        Ok(self.world.clone().with_control(control)?)
    }

    /// Returns the distance of a state from the goal along the floor: position (m), angle (rad), speed (m/s). Vertical and tilting
    /// vibrations on the floor are ignored, because pushes do not control them.
    pub fn missed(&self, end: &State) -> Found<[f64; 3]> {
        let away = self.world.difference(&self.goal, end)?;
        let along_floor = |first: usize| away.rows(first, 2).norm();
        Ok([along_floor(3), away[2].abs(), along_floor(9)])
    }
}

/// Returns the block at rest at the goal, pressed into the floor as in the initial state.
fn goal(start: &State) -> State {
    let mut goal = start.clone();
    let height = start.bodies[0].position().z;
    let place = vector![GOAL[0], GOAL[1], height];
    goal.bodies[0].pose = Pose::from_rotation_vector(&vector![0.0, 0.0, ANGLE], place);
    goal.bodies[0].twist = Twist::zero();
    goal
}

/// Returns the costs of pushes in an interval of this duration (s), as multiples of half their squares.
pub fn efforts(duration: f64) -> Vector3<f64> {
    Vector3::from(EFFORTS) * duration
}

/// Returns the components of the wrench of a push.
pub fn wrench_numbers(push: &Vector3<f64>) -> Vector6<f64> {
    let mut numbers = Vector6::zeros();
    for (place, number) in PUSHES.into_iter().zip(push) {
        numbers[place] = *number;
    }
    numbers
}
