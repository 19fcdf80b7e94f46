//! The path of the fingers.

use hydroelastic::dynamics::BodyState;
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::vector;

/// A scalar that changes from one value to another between two times (s), with continuous velocity and acceleration.
pub struct Move {
    pub from: f64,
    pub to: f64,
    pub times: [f64; 2],
}

/// Height (m) of both fingers, and tilt (rad) about the axis along y through their centers.
pub const HEIGHT: Move = Move {
    from: 0.045,
    to: 0.145,
    times: [0.1, 0.6],
};
pub const TILT: Move = Move {
    from: 0.0,
    to: std::f64::consts::FRAC_PI_6,
    times: [0.5, 1.0],
};

impl Move {
    /// Returns value and rate at a time (s). After the fraction s of the duration, the fraction 10s³ − 15s⁴ + 6s⁵ of the change is done.
    pub fn at(&self, time: f64) -> [f64; 2] {
        let [start, end] = self.times;
        let (way, duration) = (self.to - self.from, end - start);
        let s = ((time - start) / duration).clamp(0.0, 1.0);
        let share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let rate = 30.0 * (s * (1.0 - s)).powi(2);
        [self.from + way * share, way * rate / duration]
    }
}

/// Returns the state at a time (s) of a body that lifts and tilts with the fingers, with its center at y (m) and speed (m/s) along y.
pub fn carried([y, speed]: [f64; 2], time: f64) -> BodyState {
    let ([height, climb], [tilt, turn]) = (HEIGHT.at(time), TILT.at(time));
    let place = vector![0.0, y, height];
    BodyState {
        pose: Pose::from_rotation_vector(&vector![0.0, tilt, 0.0], place),
        twist: Twist {
            angular: vector![0.0, turn, 0.0],
            linear: vector![0.0, speed, climb],
        },
    }
}
