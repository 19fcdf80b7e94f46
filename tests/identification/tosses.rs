//! Tosses of a ball onto a table, with simulated recordings.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{
    Body, BodyState, Integrator, Mass, Material, Plan, State, Trajectory, World,
};
use hydroelastic::gradient::Parameter;
use hydroelastic::identification::{Measurement, Noise, Nuisance, Unknown};
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::f64::consts::TAU;

/// True modulus (Pa), dissipation (s/m) and friction of the ball.
pub const TRUTH: [f64; 3] = [1e5, 1.0, 0.2];
/// Radius (m) of the ball.
const RADIUS: f64 = 0.05;
/// Standard deviations of the noise of positions (m) and of rotations (rad) of the recordings.
pub const NOISE: [f64; 2] = [1e-3, 1e-2];
/// Standard deviations of the errors of the first velocity (m/s) and angular velocity (rad/s).
pub const VELOCITY_NOISE: [f64; 2] = [0.02, 0.2];

/// Returns a plan with a recorded state every 10 ms for 0.3 s.
pub fn plan() -> Plan {
    let plan = Plan::new(0.01, 30).unwrap();
    plan.with_integrator(Integrator::Sdirk3)
}

/// Returns the world of a ball with this modulus, dissipation and friction above a table.
pub fn world([modulus, dissipation, friction]: [f64; 3]) -> World {
    let skin = Material::elastic(modulus);
    let skin = skin.with_dissipation(dissipation).with_friction(friction);
    let ball = Shape::new(shapes::icosphere(RADIUS, 1).unwrap());
    let ball = Body::dynamic("ball", ball, skin, Mass::Total(0.2)).unwrap();
    let ball = ball.with_pose(Pose::from_translation(vector![0.0, 0.0, 0.1]));
    let table = Body::fixed("table", HalfSpace::rigid(), Material::rigid()).unwrap();
    let world = World::new(vec![ball, table]).unwrap();
    world.with_gravity(vector![0.0, 0.0, -9.81]).unwrap()
}

/// Returns the unknown modulus, dissipation and friction, with logarithms as coordinates.
pub fn unknowns() -> [Unknown; 3] {
    let parameters = [
        Parameter::modulus("ball"),
        Parameter::dissipation("ball"),
        Parameter::friction("ball"),
    ];
    parameters.map(|parameter| Unknown::new(parameter).logarithmic())
}

/// Returns the errors of the first state of a noisy recording.
pub fn nuisances() -> [Nuisance; 4] {
    [
        Nuisance::new(Parameter::initial_position("ball"), NOISE[0]),
        Nuisance::new(Parameter::initial_orientation("ball"), NOISE[1]),
        Nuisance::new(Parameter::initial_velocity("ball"), VELOCITY_NOISE[0]),
        Nuisance::new(
            Parameter::initial_angular_velocity("ball"),
            VELOCITY_NOISE[1],
        ),
    ]
}

pub fn noise() -> Noise {
    Noise::new(NOISE[0], NOISE[1]).unwrap()
}

/// Returns recordings of tosses without noise. Each toss has one bounce.
pub fn clean(count: u64) -> Vec<Measurement> {
    let toss = |seed| {
        let mut random = StdRng::seed_from_u64(seed);
        let world = world(TRUTH);
        let mut start = world.initial_state();
        let mut uniform =
            |scale: f64| Vector3::from_fn(|_, _| scale * random.random_range(-1.0..1.0));
        start.bodies[0].twist = Twist {
            angular: uniform(10.0),
            linear: uniform(0.3) + vector![0.8, 0.0, -0.8],
        };
        let world = world.with_initial_state(&start).unwrap();
        Measurement::new(
            format!("toss {seed}"),
            world.rollout(&plan()).run().unwrap(),
        )
    };
    (0..count).map(toss).collect()
}

/// Returns the recordings with noise in all poses, and in the velocities of the first state.
pub fn noisy(clean: &[Measurement], seed: u64) -> Vec<Measurement> {
    let mut random = StdRng::seed_from_u64(1_000 + seed);
    let mut normal =
        |deviation: f64| Vector3::from_fn(|_, _| deviation * standard_normal(&mut random));
    let mut disturbed = |state: &State| {
        let mut state = state.clone();
        let BodyState { pose, twist } = &mut state.bodies[0];
        let turn = Pose::from_rotation_vector(&normal(NOISE[1]), Vector3::zeros());
        let position = pose.translation() + normal(NOISE[0]);
        *pose = (turn * *pose).with_translation(position);
        twist.linear += normal(VELOCITY_NOISE[0]);
        twist.angular += normal(VELOCITY_NOISE[1]);
        state
    };
    let mut measured = |measurement: &Measurement| {
        let states = measurement.trajectory().states().iter().map(&mut disturbed);
        Measurement::new(
            measurement.name(),
            Trajectory::new(states.collect()).unwrap(),
        )
    };
    clean.iter().map(&mut measured).collect()
}

/// Returns a number with the standard normal distribution, by the method of Box and Muller.
fn standard_normal(random: &mut StdRng) -> f64 {
    let [uniform, angle]: [f64; 2] = [random.random_range(0.0..1.0), random.random_range(0.0..TAU)];
    (-2.0 * (1.0 - uniform).ln()).sqrt() * angle.cos()
}
