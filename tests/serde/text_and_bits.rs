//! Values as text and back, reasons why text is rejected, and the bits of the loaded numbers.

use hydroelastic::dynamics::{BodyState, State, Trajectory};
use hydroelastic::spatial::{Pose, Twist};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Time step (s), a power of two, so that times are exact and a rollout can stop and continue between any two steps.
pub const TIME_STEP: f64 = 1.0 / 1024.0;

pub fn saved(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap()
}

pub fn reloaded<V: Serialize + DeserializeOwned>(value: &V) -> V {
    serde_json::from_str(&saved(value)).unwrap()
}

/// Returns the reason why the text is not a value of this type.
pub fn refusal<V: DeserializeOwned>(text: &str) -> String {
    match serde_json::from_str::<V>(text) {
        Ok(_) => panic!("{text} was accepted"),
        Err(error) => error.to_string(),
    }
}

pub fn pose_bits(pose: &Pose) -> Vec<u64> {
    let numbers = pose.rotation().iter().chain(pose.translation());
    numbers.map(|number| number.to_bits()).collect()
}

pub fn twist_bits(twist: &Twist) -> Vec<u64> {
    let numbers = twist.angular.iter().chain(&twist.linear);
    numbers.map(|number| number.to_bits()).collect()
}

pub fn state_bits(state: &State) -> Vec<u64> {
    let of_body = |body: &BodyState| [pose_bits(&body.pose), twist_bits(&body.twist)].concat();
    let bodies = state.bodies.iter().flat_map(of_body);
    std::iter::once(state.time.to_bits())
        .chain(bodies)
        .collect()
}

pub fn trajectory_bits(trajectory: &Trajectory) -> Vec<Vec<u64>> {
    trajectory.states().iter().map(state_bits).collect()
}
