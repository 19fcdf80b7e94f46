//! Smallest squeeze for which the slip during a lift is within a limit.

use super::path::HEIGHT;
use super::scene::{FRICTION, GRAVITY, LEADING, MUG, SQUEEZE, STEPPING, plan};
use hydroelastic::dynamics::{Force, Plan, State, Trajectory, World, WorldError};
use hydroelastic::gradient::{Experiment, Outcome, Parameter};
use hydroelastic::scalar::{Scalar, lift, lift_vector, norm};
use nalgebra::{Vector3, vector};
use std::error::Error;
use std::f64::consts::SQRT_2;

/// Duration of the evaluated lift in tenths of a second. The lift accelerates throughout and is fastest at the end.
pub const LIFTING: usize = 2;
/// Largest slip (m) of the mug: the distance at the slip tolerance.
pub const MAY_SLIP: f64 = STEPPING.2 * LIFTING as f64 / 10.0;
/// Index of the force along y in the components of a control.
const ALONG: usize = 4;
/// Step of the difference, relative to the squeeze.
const DIFFERENCE: f64 = 1e-3;
/// Relative tolerance of the slip at which Newton's method ends.
const FOUND: f64 = 1e-6;
const ITERATIONS: usize = 10;

/// Slip (m) of the mug along the face of the leading finger between the first state and the last.
struct Slip;

impl Outcome for Slip {
    fn of<T: Scalar>(&self, trajectory: &Trajectory<T>) -> Vec<T> {
        let slip = on_face(trajectory.last()) - on_face(&trajectory.states()[0]);
        vec![norm(&slip)]
    }
}

/// Returns the point (m) of the mug that was initially between the fingers.
pub fn held<T: Scalar>(state: &State<T>) -> Vector3<T> {
    let between = lift_vector(&vector![0.0, 0.0, HEIGHT.from]);
    state.bodies[MUG].pose.transformed_point(&between)
}

/// Returns the point `held` (m) in the frame of the leading finger, projected to its face.
pub fn on_face<T: Scalar>(state: &State<T>) -> Vector3<T> {
    let finger = &state.bodies[LEADING].pose;
    let place = finger.rotation().transpose() * (held(state) - finger.translation());
    Vector3::new(place.x, lift(0.0), place.z)
}

/// A squeeze (N), its slip (m), and the derivative of the slip (m/N).
pub struct Iteration {
    pub squeeze: f64,
    pub slip: f64,
    pub slope: f64,
}

/// A lift from a state in which the fingers have closed.
pub struct Lift<F> {
    world: World<f64, F>,
    plan: Plan,
}

impl<F: Force> Lift<F> {
    pub fn new(world: &World<f64, F>, closed: &State) -> Result<Self, WorldError> {
        let plan = plan(LIFTING)?;
        let plan = plan.recording_every(plan.steps());
        let world = world.clone().with_initial_state(closed)?;
        Ok(Self { world, plan })
    }

    /// Finds the squeeze by Newton's method. Let r be the load divided by friction times squeeze. The slip speed is the slip tolerance
    /// times r/√(1 − r²), so 1/slip² is a quadratic function of the squeeze.
    pub fn least_squeeze(&self) -> Result<Vec<Iteration>, Box<dyn Error>> {
        let mut iterations = vec![self.slipped(SQUEEZE)?];
        loop {
            let &Iteration {
                squeeze,
                slip,
                slope,
            } = &iterations[iterations.len() - 1];
            if (slip / MAY_SLIP - 1.0).abs() < FOUND {
                return Ok(iterations);
            }
            assert!(iterations.len() <= ITERATIONS, "{slip} m with {squeeze} N");
            let missing = MAY_SLIP.powi(-2) - slip.powi(-2);
            let rate = -2.0 * slope * slip.powi(-3);
            iterations.push(self.slipped(squeeze + missing / rate)?);
        }
    }

    /// Returns the slip at a squeeze, and its derivative.
    fn slipped(&self, squeeze: f64) -> Result<Iteration, Box<dyn Error>> {
        let change = change_to(squeeze);
        let lift = Experiment::new(self.world.perturbed(&[by_squeeze()], &change)?, &self.plan);
        let (slip, gradient) = lift.gradient(&[by_squeeze()], &Slip)?;
        let slope = gradient[ALONG];
        Ok(Iteration {
            squeeze,
            slip,
            slope,
        })
    }

    /// Returns the derivative of the slip (m/N) by differences.
    pub fn difference(&self, squeeze: f64) -> Result<f64, Box<dyn Error>> {
        let lift = Experiment::new(&self.world, &self.plan);
        let slip = |squeeze| lift.value_perturbed(&[by_squeeze()], &change_to(squeeze), &Slip);
        let step = DIFFERENCE * squeeze;
        let [below, above] = [slip(squeeze - step)?[0], slip(squeeze + step)?[0]];
        Ok((above - below) / (2.0 * step))
    }
}

/// Returns the change of the control that results in a squeeze (N).
fn change_to(squeeze: f64) -> [f64; 6] {
    let mut change = [0.0; 6];
    change[ALONG] = squeeze - SQUEEZE;
    change
}

/// Returns an estimate of the smallest squeeze (N). At the slip tolerance, friction has 1/√2 of its full value. Two faces support the
/// weight and the inertial force of the lift.
pub fn by_hand<F: Force>(world: &World<f64, F>) -> f64 {
    let mass = world.bodies()[MUG].inertia().map_or(0.0, |it| it.mass);
    let duration = LIFTING as f64 / 10.0;
    let [_, speed] = HEIGHT.at(HEIGHT.times[0] + duration);
    let load = mass * (GRAVITY + speed / duration);
    load * SQRT_2 / (2.0 * FRICTION)
}

fn by_squeeze() -> Parameter {
    Parameter::control("pressed", 0)
}
