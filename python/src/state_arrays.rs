//! Numbers of states as arrays: of bodies, of joints with one degree of freedom, and of ball joints.

use crate::poses::{ENTRIES, entries, pose_of, twist_of};
use hydroelastic::dynamics::{self, BodyState, JointState};
use hydroelastic::nalgebra::{Matrix3, Vector3};
use hydroelastic::scalar::Scalar;
use pyo3::prelude::*;

/// Number of arrays.
pub const ARRAYS: usize = 6;

/// Names of the arrays, which are those of the attributes in Python.
pub const NAMES: [&str; ARRAYS] = [
    "poses",
    "twists",
    "joint_positions",
    "joint_velocities",
    "ball_joint_rotations",
    "ball_joint_velocities",
];

/// Shapes of the arrays of one state.
pub fn shapes_of(state: &dynamics::State) -> [Vec<usize>; ARRAYS] {
    let (bodies, joints) = (state.bodies.len(), &state.joints);
    let with_one_degree = joints.iter().filter(|joint| joint.position().is_some());
    let scalars = with_one_degree.count();
    let balls = joints.len() - scalars;
    [
        vec![bodies, 4, 4],
        vec![bodies, 6],
        vec![scalars],
        vec![scalars],
        vec![balls, 3, 3],
        vec![balls, 3],
    ]
}

/// Numbers of one state in each array.
pub fn sizes_of(state: &dynamics::State) -> [usize; ARRAYS] {
    shapes_of(state).map(|shape| shape.iter().product())
}

/// Numbers of each array of states, one state after another.
pub fn numbers_of<'s, T: Scalar>(
    states: impl IntoIterator<Item = &'s dynamics::State<T>>,
) -> [Vec<T>; ARRAYS] {
    let mut arrays = std::array::from_fn(|_| Vec::new());
    let [
        poses,
        twists,
        positions,
        velocities,
        rotations,
        angular_velocities,
    ] = &mut arrays;
    for state in states {
        for body in &state.bodies {
            poses.extend(entries(&body.pose));
            twists.extend(body.twist.to_vector().iter().copied());
        }
        for joint in &state.joints {
            match joint {
                JointState::Scalar { position, velocity } => {
                    positions.push(*position);
                    velocities.push(*velocity);
                }
                JointState::Ball {
                    rotation,
                    angular_velocity,
                } => {
                    rotations.extend(rotation.transpose().iter().copied());
                    angular_velocities.extend(angular_velocity.iter().copied());
                }
                _ => {}
            }
        }
    }
    arrays
}

/// Restores a state from the numbers of its arrays, bit for bit. The joints have the kinds of the joints of `like`.
pub fn state_of(
    time: f64,
    arrays: [&[f64]; ARRAYS],
    like: &dynamics::State,
) -> PyResult<dynamics::State> {
    let [
        poses,
        twists,
        positions,
        velocities,
        rotations,
        angular_velocities,
    ] = arrays;
    let bodies = poses.chunks(ENTRIES).zip(twists.chunks(6));
    let body = |(pose, twist): (&[f64], &[f64])| {
        Ok(BodyState {
            pose: pose_of(&std::array::from_fn(|index| pose[index]))?,
            twist: twist_of(&std::array::from_fn(|index| twist[index])),
        })
    };
    let mut scalars = positions.iter().zip(velocities);
    let mut balls = rotations.chunks(9).zip(angular_velocities.chunks(3));
    let joint = |joint: &JointState| {
        if joint.position().is_some() {
            let (&position, &velocity) = scalars.next()?;
            return Some(JointState::Scalar { position, velocity });
        }
        let (rotation, angular_velocity) = balls.next()?;
        Some(JointState::Ball {
            rotation: Matrix3::from_row_slice(rotation),
            angular_velocity: Vector3::from_column_slice(angular_velocity),
        })
    };
    Ok(dynamics::State {
        time,
        bodies: bodies.map(body).collect::<PyResult<_>>()?,
        joints: like.joints.iter().filter_map(joint).collect(),
    })
}
