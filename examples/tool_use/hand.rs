//! The hand that guides the tool.

use hydroelastic::dynamics::{Body, BodyState, Force, ForceContext, WrenchAccumulator};
use hydroelastic::scalar::{Scalar, lift, lift_vector};
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::{Vector3, vector};

/// Between which times (s) the tool goes down, along and up again.
pub const DOWN: [f64; 2] = [0.0, 0.1];
pub const ALONG: [f64; 2] = [0.12, 0.32];
const UP: [f64; 2] = [0.34, 0.42];
/// Where it begins and ends along x (m).
pub const WAY: [f64; 2] = [-0.012, 0.012];
/// Above the lowest point of the path (m), where it begins and ends.
const CLEARANCE: f64 = 0.005;

/// A spring and a damper from the origin of the tool's frame to a path, and others that keep it upright. They bear its weight.
pub struct Hand {
    /// Place of the tool in the world's list.
    pub tool: usize,
    /// Lowest height (m) of the path.
    pub lowest: f64,
}

/// Against shifts: N/m, N s/m.
const LINEAR: [f64; 2] = [2e4, 40.0];
/// Against turns: N m/rad, N m s/rad.
const ANGULAR: [f64; 2] = [20.0, 0.04];

impl Hand {
    /// Place (m) and velocity (m/s) on the path at a time (s).
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

    /// The force (N) on the tool, apart from its weight, at a time (s).
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

    /// It looks at no other body.
    fn coupling_groups(&self, _: &[Body]) -> Vec<Vec<usize>> {
        vec![vec![self.tool]]
    }
}

/// The share of a move that is done at a time (s), and its rate (1/s): 3s² − 2s³ after the share s of the time.
fn share_at(time: f64, [start, end]: [f64; 2]) -> [f64; 2] {
    let duration = end - start;
    let s = ((time - start) / duration).clamp(0.0, 1.0);
    [s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / duration]
}

/// The small rotation (rad, world axes) out of the upright pose: half of what the rotation matrix is skew by.
fn turn<T: Scalar>(pose: &Pose<T>) -> Vector3<T> {
    let r = pose.rotation();
    let skew = [
        r[(2, 1)] - r[(1, 2)],
        r[(0, 2)] - r[(2, 0)],
        r[(1, 0)] - r[(0, 1)],
    ];
    Vector3::from(skew) * lift::<T>(0.5)
}
