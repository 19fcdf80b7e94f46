//! Conversion between states of the world and generalized coordinates.

use super::coordinates::{three_at, zeros};
use super::{Coordinates, Kinematics, Multibody};
use crate::dynamics::joint::{JointKind, JointPosition, JointState};
use crate::dynamics::{BodyState, State};
use crate::scalar::{Scalar, lift};

impl<T: Scalar> Multibody<T> {
    /// Coordinates in a state of the world.
    pub fn coordinates(&self, state: &State<T>) -> Coordinates<T> {
        let mut velocities = zeros(self.width());
        let mut positions: Vec<_> = self
            .links
            .iter()
            .map(|link| {
                let first = link.columns.start;
                match link.kind {
                    JointKind::Free => {
                        let BodyState { pose, twist } = &state.bodies[link.body];
                        velocities
                            .fixed_rows_mut::<6>(first)
                            .copy_from(&twist.to_vector());
                        return JointPosition::Pose(*pose);
                    }
                    JointKind::Fixed => return JointPosition::Fixed,
                    JointKind::Ball | JointKind::Revolute(_) | JointKind::Prismatic(_) => {}
                }
                let Some(index) = link.state_index else {
                    return JointPosition::Scalar(lift(0.0));
                };
                match &state.joints[index] {
                    JointState::Scalar { position, velocity } => {
                        velocities[first] = *velocity;
                        JointPosition::Scalar(*position)
                    }
                    JointState::Ball {
                        rotation,
                        angular_velocity,
                    } => {
                        velocities
                            .fixed_rows_mut::<3>(first)
                            .copy_from(angular_velocity);
                        JointPosition::Rotation(*rotation)
                    }
                }
            })
            .collect();
        for (index, link) in self.links.iter().enumerate() {
            let Some(mimic) = link.mimic else { continue };
            if let JointPosition::Scalar(leader) = positions[mimic.leader] {
                positions[index] = JointPosition::Scalar(leader * mimic.multiplier + mimic.offset);
                let leader = velocities[self.links[mimic.leader].columns.start];
                velocities[link.columns.start] = leader * mimic.multiplier;
            }
        }
        Coordinates {
            positions,
            velocities,
            multipliers: zeros(self.constraint_count()),
        }
    }

    /// Sets the states of the bodies and of their joints.
    pub fn store(&self, kinematics: &Kinematics<T>, state: &mut State<T>) {
        let Coordinates {
            positions,
            velocities,
            ..
        } = &kinematics.coordinates;
        let links = self.links.iter().zip(positions).zip(&kinematics.states);
        for ((link, position), body) in links {
            state.bodies[link.body] = *body;
            let Some(state_index) = link.state_index else {
                continue;
            };
            let first = link.columns.start;
            match position {
                JointPosition::Scalar(position) => {
                    state.joints[state_index] = JointState::Scalar {
                        position: *position,
                        velocity: velocities[first],
                    };
                }
                JointPosition::Rotation(rotation) => {
                    state.joints[state_index] = JointState::Ball {
                        rotation: *rotation,
                        angular_velocity: three_at(velocities, first),
                    };
                }
                JointPosition::Pose(_) | JointPosition::Fixed => {}
            }
        }
    }
}
