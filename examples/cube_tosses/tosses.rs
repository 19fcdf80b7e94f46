//! Tosses of a cube onto a table, recorded or simulated.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, BodyState, Mass, Material, Plan, State, Trajectory, World};
use hydroelastic::identification::Measurement;
use hydroelastic::mesh::shapes;
use hydroelastic::spatial::{MassProperties, Pose, Twist};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, vector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

/// Edge (m), mass (kg) and moment of inertia (kg m²) of the cube.
pub const EDGE: f64 = 0.1048;
pub const MASS: f64 = 0.37;
pub const MOMENT: f64 = 8.1e-4;
/// Frames per second of the recordings.
pub const RATE: f64 = 148.0;
/// Standard deviations of simulated noise: position (m), rotation (rad), velocity (m/s) and angular velocity (rad/s).
pub const NOISE: [f64; 4] = [1e-3, 0.01, 0.03, 0.1];

/// Returns a world with a cube of this modulus (Pa), dissipation (s/m) and friction, on a table at this height (m).
pub fn world([modulus, dissipation, friction, height]: [f64; 4]) -> Result<World, Box<dyn Error>> {
    let skin = Material::elastic(modulus);
    let skin = skin.with_dissipation(dissipation).with_friction(friction);
    let properties = MassProperties {
        mass: MASS,
        center_of_mass: Vector3::zeros(),
        inertia: Matrix3::from_diagonal_element(MOMENT),
    };
    let at = |height| Pose::from_translation(vector![0.0, 0.0, height]);
    let shape = Shape::new(shapes::cuboid([EDGE; 3])?);
    let cube = Body::dynamic("cube", shape, skin, Mass::Properties(properties))?;
    let table = Body::fixed("table", HalfSpace::rigid(), Material::rigid())?;
    let bodies = vec![cube.with_pose(at(0.12)), table.with_pose(at(height))];
    Ok(World::new(bodies)?.with_gravity(vector![0.0, 0.0, -9.81])?)
}

/// Reads recordings from a table with a header and the columns toss, frame, quaternion (w, x, y, z), position (m), angular velocity in
/// body axes (rad/s), and velocity (m/s).
pub fn read(path: &Path, world: &World) -> Result<Vec<Measurement>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut tosses: BTreeMap<u32, Vec<State>> = BTreeMap::new();
    for line in text.lines().skip(1) {
        let numbers = line.split(',').map(|number| number.trim().parse::<f64>());
        let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
        let [_, frame, w, x, y, z, ..] = numbers[..] else {
            return Err(format!("too few columns: {line}").into());
        };
        let vector = |first: usize| Vector3::from_column_slice(&numbers[first..first + 3]);
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let mut state = world.initial_state();
        state.time = frame / RATE;
        state.bodies[0] = BodyState {
            pose: Pose::from_rotation_vector(&rotation.scaled_axis(), vector(6)),
            twist: Twist {
                angular: rotation * vector(9),
                linear: vector(12),
            },
        };
        let (toss, _) = line.split_once(',').unwrap_or_default();
        tosses.entry(toss.parse()?).or_default().push(state);
    }
    let tosses = tosses.into_iter();
    let measurement = |(toss, states)| {
        Ok(Measurement::new(
            format!("toss {toss}"),
            Trajectory::new(states)?,
        ))
    };
    tosses.map(measurement).collect()
}

/// Simulates random tosses of the cube of a world, and adds noise.
pub fn simulated(
    world: &World,
    plan: &Plan,
    count: usize,
) -> Result<Vec<Measurement>, Box<dyn Error>> {
    let mut random = StdRng::seed_from_u64(1);
    // Uniform numbers between −√3 and √3 have standard deviation 1.
    let mut uniform =
        |size: f64| Vector3::from_fn(|_, _| 3_f64.sqrt() * size * random.random_range(-1.0..1.0));
    let mut toss = |index: usize| {
        let mut start = world.initial_state();
        let cube = &mut start.bodies[0];
        cube.pose = Pose::from_rotation_vector(&uniform(0.5), *cube.position());
        cube.twist = Twist {
            angular: uniform(3.0),
            linear: uniform(0.2) + vector![0.8, 0.0, -0.5],
        };
        let clean = world
            .clone()
            .with_initial_state(&start)?
            .rollout(plan)
            .run()?;
        let mut states = clean.states().to_vec();
        for state in &mut states {
            let BodyState { pose, twist } = &mut state.bodies[0];
            let position = pose.translation() + uniform(NOISE[0]);
            let turn = Pose::from_rotation_vector(&uniform(NOISE[1]), Vector3::zeros());
            *pose = (turn * *pose).with_translation(position);
            twist.linear += uniform(NOISE[2]);
            twist.angular += uniform(NOISE[3]);
        }
        Ok(Measurement::new(
            format!("toss {index}"),
            Trajectory::new(states)?,
        ))
    };
    (0..count).map(&mut toss).collect()
}
