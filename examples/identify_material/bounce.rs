//! A ball thrown along the floor, and its recorded track.

use hydroelastic::contact::{HalfSpace, Shape};
use hydroelastic::dynamics::{Body, Mass, Material, State, Trajectory, World};
use hydroelastic::gradient::Outcome;
use hydroelastic::mesh::shapes;
use hydroelastic::scalar::Scalar;
use hydroelastic::spatial::Pose;
use nalgebra::{Vector3, vector};
use std::error::Error;

/// Modulus (Pa), dissipation (s/m) and friction of the floor, and the thickness (m) of its soft layer. The friction of a pair is the
/// harmonic mean of both frictions.
const FLOOR: Vector3<f64> = Vector3::new(1e6, 0.1, 0.4);
const LAYER: f64 = 0.25;
/// Ranges of the ball's position along the floor and upward (m), and of its velocity (m/s).
const RANGE: [f64; 4] = [1.5, 0.1, 4.0, 1.0];

/// Positions and velocities in the plane of the flight, divided by their ranges.
pub struct Track;

impl Outcome for Track {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let numbers = |state: &State<T>| {
            let ball = &state.bodies[0];
            let (p, v) = (ball.position(), ball.velocity());
            let numbers = [p.x, p.z, v.x, v.z];
            [0, 1, 2, 3].map(|i| numbers[i] / RANGE[i])
        };
        trajectory.states().iter().flat_map(numbers).collect()
    }
}

/// Returns a world with a ball of the given modulus, dissipation and friction, thrown along the floor.
pub fn world(numbers: &Vector3<f64>) -> Result<World, Box<dyn Error>> {
    let skin = |of: &Vector3<f64>| {
        let elastic = Material::elastic(of.x);
        elastic.with_dissipation(of.y).with_friction(of.z)
    };
    let at_height = |z| Pose::from_translation(vector![0.0, 0.0, z]);
    let ball = Shape::new(shapes::icosphere(0.05, 2)?);
    let ball = Body::dynamic("ball", ball, skin(numbers), Mass::Total(0.2))?
        .with_pose(at_height(0.1))
        .with_velocity(vector![4.0, 0.0, 0.0]);
    let floor = Body::fixed("floor", HalfSpace::layer(LAYER)?, skin(&FLOOR))?;
    Ok(World::new(vec![ball, floor])?.with_gravity(vector![0.0, 0.0, -9.81])?)
}
