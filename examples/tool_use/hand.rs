//! A hand that guides the tool.

use hydroelastic::dynamics::{Body, BodyState, Force, ForceContext, WrenchAccumulator};
use hydroelastic::scalar::{Scalar, lift, lift_vector};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};

/// Time intervals (s) in which the tool moves down, along and up again.
pub const DOWN: [f64; 2] = [0.0, 0.1];
pub const ALONG: [f64; 2] = [0.12, 0.32];
const UP: [f64; 2] = [0.34, 0.42];
/// Initial and final position along x (m).
pub const WAY: [f64; 2] = [-0.012, 0.012];
/// Initial and final height above the lowest point of the path (m).
const CLEARANCE: f64 = 0.005;

/// A spring and a damper from the origin of the tool's frame to a path, and a rotational spring and damper that keep the tool upright. The
/// hand supports the tool's weight.
pub struct Hand {
    /// Index of the tool in the world.
    pub tool: usize,
    /// Lowest height (m) of the path.
    pub lowest: f64,
}

/// Stiffness and damping against displacements: N/m, N s/m.
const LINEAR: [f64; 2] = [2e4, 40.0];
/// Stiffness and damping against rotations: N m/rad, N m s/rad.
const ANGULAR: [f64; 2] = [20.0, 0.04];

impl Hand {
    /// Returns position (m) and velocity (m/s) on the path at a time (s).
    pub fn path_at(&self, time: f64) -> [Vector3<f64>; 2] {
        let [down, along, up] = [DOWN, ALONG, UP].map(|times| share_at(time, times));
        let (way, [from, to]) = (WAY[1] - WAY[0], [self.lowest + CLEARANCE, self.lowest]);
        let place = vector![
            WAY[0] + along[0] * way,
            0.0,
            from + (down[0] - up[0]) * (to - from)
        ];
        let velocity = vector![along[1] * way, 0.0, (down[1] - up[1]) * (to - from)];
        [place, velocity]
    }

    /// Returns the force (N) on the tool, without its weight, at a time (s).
    pub fn force_on<T: Scalar>(&self, tool: &BodyState<T>, time: f64) -> Vector3<T> {
        let [place, velocity] = self.path_at(time).map(|vector| lift_vector::<T>(&vector));
        let [spring, damper] = LINEAR.map(lift::<T>);
        (place - tool.position()) * spring + (velocity - tool.velocity()) * damper
    }
}

impl Force for Hand {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let tool = &now.states[self.tool];
        let [spring, damper] = ANGULAR.map(lift::<T>);
        let wrench = Wrench {
            torque: -turn(&tool.pose) * spring - tool.twist.angular * damper,
            force: self.force_on(tool, now.time),
        };
        wrenches.add(self.tool, &wrench);
        if let Some(inertia) = now.bodies[self.tool].inertia() {
            wrenches.apply_force_at_com(self.tool, &(now.gravity * -inertia.mass));
        }
    }

    /// The force depends on no other body.
    fn coupling_groups(&self, _: &[Body]) -> Vec<Vec<usize>> {
        vec![vec![self.tool]]
    }
}

/// Returns the completed fraction of a move at a time (s), and its rate (1/s). After the fraction s of the duration, the fraction 3s² − 2s³
/// is completed.
fn share_at(time: f64, [start, end]: [f64; 2]) -> [f64; 2] {
    let duration = end - start;
    let s = ((time - start) / duration).clamp(0.0, 1.0);
    [s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / duration]
}

/// Returns the small rotation (rad, world axes) from the upright pose: half of the skew-symmetric part of the rotation matrix.
fn turn<T: Scalar>(pose: &Pose<T>) -> Vector3<T> {
    let r = pose.rotation();
    let skew = [
        r[(2, 1)] - r[(1, 2)],
        r[(0, 2)] - r[(2, 0)],
        r[(1, 0)] - r[(0, 1)],
    ];
    Vector3::from(skew) * lift::<T>(0.5)
}
