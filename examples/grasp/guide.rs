//! Guide of the pressed finger.

use super::path;
use hydroelastic::dynamics::{Body, Force, ForceContext, WrenchAccumulator};
use hydroelastic::scalar::{Scalar, lift, lift_vector};
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::Vector3;

/// A slide along y that lifts and tilts along the path. A spring and a damper act toward the pose on the path, except along y, where only a
/// damper acts. The slide supports the weight of its body.
pub struct Guide {
    /// Index of the body in the world.
    pub body: usize,
    /// Stiffness and damping against displacements across y: N/m, N s/m.
    pub linear: [f64; 2],
    /// Stiffness and damping against rotations: N m/rad, N m s/rad.
    pub angular: [f64; 2],
    /// Damping of motion along y (N s/m).
    pub along: f64,
}

impl Force for Guide {
    fn add_to<T: Scalar>(&self, wrenches: &mut WrenchAccumulator<T>, now: &ForceContext<T>) {
        let (state, carried) = (&now.states[self.body], path::carried([0.0; 2], now.time));
        let pose: Pose<T> = Pose::lifted(&carried.pose);
        let Twist { angular, linear } = carried.twist;
        let [spring, damper] = self.angular.map(lift::<T>);
        let spin = state.twist.angular - lift_vector::<T>(&angular);
        let torque = -turn(&pose, &state.pose) * spring - spin * damper;

        let [spring, damper] = self.linear.map(lift::<T>);
        let shift = state.position() - pose.translation();
        let velocity = state.velocity() - lift_vector::<T>(&linear);
        let mut force = -shift * spring - velocity * damper;
        force.y = velocity.y * -self.along;
        wrenches.add(self.body, &Wrench { torque, force });
        if let Some(inertia) = now.bodies[self.body].inertia() {
            wrenches.apply_force_at_com(self.body, &(now.gravity * -inertia.mass));
        }
    }

    /// The force depends on no other body.
    fn coupling_groups(&self, _: &[Body]) -> Vec<Vec<usize>> {
        vec![vec![self.body]]
    }
}

/// Returns the small rotation (rad, world axes) from one pose to another: half the sum of the cross products of the axes.
fn turn<T: Scalar>(from: &Pose<T>, to: &Pose<T>) -> Vector3<T> {
    let axes = from
        .rotation()
        .column_iter()
        .zip(to.rotation().column_iter());
    let turns = axes.map(|(from, to)| from.cross(&to));
    turns.sum::<Vector3<T>>() * lift::<T>(0.5)
}
