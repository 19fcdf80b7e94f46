//! Poses, velocities and joint axes of the links.

use super::coordinates::six_at;
use super::screw::{about_reference, cross_motion};
use super::{Coordinates, Link, Multibody, Parent};
use crate::dynamics::BodyState;
use crate::dynamics::joint::{JointKind, JointPosition};
use crate::dynamics::rigid_motion::{six, zero6};
use crate::scalar::{Scalar, lift_vector, real_vector};
use crate::spatial::{Pose, Twist, rotation_from_vector, times_constant};
use nalgebra::{DVector, Vector3, Vector6};

/// Kinematics of the links at given coordinates.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Kinematics<T = f64> {
    pub coordinates: Coordinates<T>,
    /// States of all participants: the links, then the neighbors.
    pub states: Vec<BodyState<T>>,
    pub frames: Vec<LinkFrame<T>>,
    pub columns: Vec<Column<T>>,
    /// Momentum of each link and its descendants, about the reference point of the tree.
    pub momenta: Vec<Vector6<T>>,
}

/// Frame of a link, relative to the reference point of its tree.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct LinkFrame<T = f64> {
    /// Reference point of the tree (m), in the world.
    pub reference: Vector3<f64>,
    /// Pose of the body frame.
    pub pose: Pose<T>,
    pub center_of_mass: Vector3<T>,
    /// Spatial velocity about the reference point.
    pub velocity: Vector6<T>,
}

/// Column of the matrix of joint axes.
#[derive(Debug, Clone, Copy)]
pub(in crate::dynamics) struct Column<T = f64> {
    pub link: usize,
    /// Whether the column moves the axes of the other columns of the joint. True for the translations of a free body, because they move its
    /// axes of rotation.
    pub is_outer: bool,
    /// Spatial velocity per unit of the generalized velocity.
    pub axis: Vector6<T>,
    /// Time derivative of the axis.
    pub axis_rate: Vector6<T>,
    /// Spatial velocity of the frame that the column moves.
    pub velocity: Vector6<T>,
}

/// Frame to which a joint is attached.
struct JointFrame<T> {
    reference: Vector3<f64>,
    /// Pose relative to the reference point.
    pose: Pose<T>,
    /// Spatial velocity of the parent about the reference point.
    velocity: Vector6<T>,
}

impl<T: Scalar> Multibody<T> {
    /// Kinematics at given coordinates and given states of the neighbors.
    pub fn kinematics(
        &self,
        coordinates: Coordinates<T>,
        neighbors: &[BodyState<T>],
    ) -> Kinematics<T> {
        let mut placed = PlacedLinks {
            states: Vec::with_capacity(self.links.len() + neighbors.len()),
            frames: Vec::with_capacity(self.links.len()),
            columns: Vec::with_capacity(self.width()),
            velocities: &coordinates.velocities,
            neighbors,
        };
        for (index, (link, position)) in self.links.iter().zip(&coordinates.positions).enumerate() {
            placed.add_link((index, link), position);
        }
        let PlacedLinks {
            mut states,
            frames,
            mut columns,
            ..
        } = placed;
        // Columns are in the order of trees, which need not be the order of links.
        let tree = |column: &Column<T>| self.links[column.link].tree;
        if !columns.is_sorted_by_key(tree) {
            columns.sort_by_key(tree);
        }
        let momenta = self.links.iter().zip(&frames).zip(&states);
        let momenta = momenta.map(|((link, frame), state)| {
            about_reference(&link.inertia.momentum(state), &frame.center_of_mass)
        });
        let momenta = self.summed_over_subtrees(momenta.collect(), |sum, momentum| sum + momentum);
        states.extend_from_slice(neighbors);
        Kinematics {
            coordinates,
            states,
            frames,
            columns,
            momenta,
        }
    }
}

impl<T> Kinematics<T> {
    /// Generalized velocities.
    pub fn velocities(&self) -> &DVector<T> {
        &self.coordinates.velocities
    }
}

/// Kinematics of the links that were added so far.
struct PlacedLinks<'a, T> {
    states: Vec<BodyState<T>>,
    frames: Vec<LinkFrame<T>>,
    columns: Vec<Column<T>>,
    velocities: &'a DVector<T>,
    neighbors: &'a [BodyState<T>],
}

impl<T: Scalar> PlacedLinks<'_, T> {
    fn add_link(&mut self, (index, link): (usize, &Link<T>), position: &JointPosition<T>) {
        let JointFrame {
            reference,
            pose: frame,
            velocity,
        } = match position {
            JointPosition::Pose(pose) => JointFrame::of_free(link, pose),
            _ => self.joint_frame(link),
        };
        let mut joint = ElementaryJoints {
            columns: &mut self.columns,
            link: index,
            velocities: self.velocities,
            velocity,
        };
        let pose = joint.pose_behind(link, position, (&frame, &reference));
        let velocity = joint.velocity;
        let center_of_mass = pose.transformed_constant(&link.inertia.center_of_mass);
        let Twist { angular, linear } = Twist::from_vector(&velocity);
        let state = if let JointPosition::Pose(pose) = position {
            BodyState {
                pose: *pose,
                twist: Twist::from_vector(&six_at(self.velocities, link.columns.start)),
            }
        } else {
            let linear = linear + angular.cross(&center_of_mass);
            BodyState {
                pose: pose.with_translation(pose.translation() + lift_vector(&reference)),
                twist: Twist { angular, linear },
            }
        };
        self.states.push(state);
        self.frames.push(LinkFrame {
            reference,
            pose,
            center_of_mass,
            velocity,
        });
    }

    /// Frame of the joint of a link that is not free.
    fn joint_frame(&self, link: &Link<T>) -> JointFrame<T> {
        let behind = |parent: &Pose<T>| {
            let rotation = times_constant(parent.rotation(), link.origin.rotation());
            Pose::from_parts(
                rotation,
                parent.transformed_constant(link.origin.translation()),
            )
        };
        match link.parent {
            Parent::World => JointFrame {
                reference: *link.origin.translation(),
                pose: Pose::lifted(&link.origin.with_translation(Vector3::zeros())),
                velocity: zero6(),
            },
            Parent::Link(parent) => {
                let LinkFrame {
                    reference,
                    pose,
                    velocity,
                    ..
                } = &self.frames[parent];
                JointFrame {
                    reference: *reference,
                    pose: behind(pose),
                    velocity: *velocity,
                }
            }
            Parent::Neighbor(index) => {
                let BodyState { pose, twist } = &self.neighbors[index];
                let frame = behind(pose);
                let reference = real_vector(frame.translation());
                let arm = lift_vector(&reference) - pose.translation();
                JointFrame {
                    reference,
                    pose: frame.with_translation(frame.translation() - lift_vector(&reference)),
                    velocity: six(&twist.angular, &(twist.linear + twist.angular.cross(&arm))),
                }
            }
        }
    }
}

impl<T: Scalar> JointFrame<T> {
    /// Frame at the center of mass of a free body, in world axes.
    fn of_free(link: &Link<T>, pose: &Pose<T>) -> Self {
        let center = pose.transformed_constant(&link.inertia.center_of_mass);
        let reference = real_vector(&center);
        Self {
            reference,
            pose: Pose::from_translation(center - lift_vector(&reference)),
            velocity: zero6(),
        }
    }
}

/// Adds the columns of a joint. A joint is a chain of elementary joints. The axes of an elementary joint are constant in the frame before
/// the elementary joint.
struct ElementaryJoints<'k, T> {
    columns: &'k mut Vec<Column<T>>,
    link: usize,
    velocities: &'k DVector<T>,
    /// Spatial velocity of the frame behind the last elementary joint.
    velocity: Vector6<T>,
}

impl<T: Scalar> ElementaryJoints<'_, T> {
    /// Adds the columns of the joint of a link. Returns the pose of the body frame relative to the reference point.
    fn pose_behind(
        &mut self,
        link: &Link<T>,
        position: &JointPosition<T>,
        (frame, reference): (&Pose<T>, &Vector3<f64>),
    ) -> Pose<T> {
        let first = link.columns.start;
        match (&link.kind, position) {
            (JointKind::Revolute(axis), JointPosition::Scalar(angle)) => {
                let direction = frame.rotated_constant(axis);
                self.add(first, &[rotation_axis(&direction, frame.translation())]);
                let turn = rotation_from_vector(&axis.map(|component| *angle * component));
                Pose::from_parts(frame.rotation() * turn, *frame.translation())
            }
            (JointKind::Prismatic(axis), JointPosition::Scalar(shift)) => {
                let direction = frame.rotated_constant(axis);
                self.add(first, &[translation_axis(&direction)]);
                let shift = direction.map(|component| component * *shift);
                frame.with_translation(frame.translation() + shift)
            }
            (JointKind::Ball, JointPosition::Rotation(turn)) => {
                self.add(first, &rotation_axes(frame));
                Pose::from_parts(frame.rotation() * turn, *frame.translation())
            }
            (_, JointPosition::Pose(pose)) => {
                let axis = |k: usize| translation_axis(&frame.rotation().column(k).into_owned());
                let (rotations, translations) = (rotation_axes(frame), [0, 1, 2].map(axis));
                let translation = self.velocity_behind(first + 3, &translations);
                self.add(first, &rotations);
                self.columns.extend(translations.map(|axis| Column {
                    link: self.link,
                    is_outer: true,
                    axis,
                    // The world is at rest.
                    axis_rate: zero6(),
                    velocity: translation,
                }));
                pose.with_translation(pose.translation() - lift_vector(reference))
            }
            _ => *frame,
        }
    }

    /// Adds the columns of an elementary joint. The index of the first column is `first`.
    fn add(&mut self, first: usize, axes: &[Vector6<T>]) {
        let before = self.velocity;
        let velocity = self.velocity_behind(first, axes);
        self.columns.extend(axes.iter().map(|axis| Column {
            link: self.link,
            is_outer: false,
            axis: *axis,
            axis_rate: cross_motion(&before, axis),
            velocity,
        }));
    }

    /// Adds the velocity of an elementary joint, and returns the spatial velocity of the frame behind the joint.
    fn velocity_behind(&mut self, first: usize, axes: &[Vector6<T>]) -> Vector6<T> {
        for (axis, velocity) in axes.iter().zip(&self.velocities.as_slice()[first..]) {
            self.velocity += axis.map(|component| component * *velocity);
        }
        self.velocity
    }
}

fn rotation_axis<T: Scalar>(direction: &Vector3<T>, point: &Vector3<T>) -> Vector6<T> {
    six(direction, &point.cross(direction))
}

/// Axes of rotation about the origin of a frame.
fn rotation_axes<T: Scalar>(frame: &Pose<T>) -> [Vector6<T>; 3] {
    let axis = |k: usize| frame.rotation().column(k).into_owned();
    [0, 1, 2].map(|k| rotation_axis(&axis(k), frame.translation()))
}

fn translation_axis<T: Scalar>(direction: &Vector3<T>) -> Vector6<T> {
    six(&lift_vector(&Vector3::zeros()), direction)
}
