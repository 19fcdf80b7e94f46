//! Positions and velocities of the joints of an island.

use super::{Link, Multibody};
use crate::dynamics::joint::{JointKind, JointPosition};
use crate::dynamics::rigid_motion::displaced_back;
use crate::scalar::{Scalar, lift};
use crate::spatial::{Pose, left_jacobian, rotation_from_vector, turned_by};
use nalgebra::{DVector, Vector3, Vector6};

/// Positions and velocities of all joints, and the multipliers of loops.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Coordinates<T = f64> {
    /// Position of the joint of each link.
    pub positions: Vec<JointPosition<T>>,
    /// Generalized velocities, one for each column.
    pub velocities: DVector<T>,
    /// Multipliers of loops (N or N m): see [`loops`](super::loops).
    pub multipliers: DVector<T>,
}

impl<T: Scalar> Coordinates<T> {
    /// Unknowns of a stage: the generalized velocities, then the multipliers.
    pub fn unknowns(&self) -> DVector<T> {
        let (width, count) = (self.velocities.len(), self.multipliers.len());
        let mut unknowns = self.velocities.clone();
        if count > 0 {
            unknowns = unknowns.resize_vertically(width + count, lift(0.0));
            unknowns.rows_mut(width, count).copy_from(&self.multipliers);
        }
        unknowns
    }
}

impl<T: Scalar> Multibody<T> {
    /// Positions after a displacement, which has one number for each column.
    pub fn displaced(
        &self,
        positions: &[JointPosition<T>],
        displacement: &DVector<T>,
    ) -> Vec<JointPosition<T>> {
        let links = self.links.iter().zip(positions);
        links
            .map(|(link, position)| link.displaced(position, displacement))
            .collect()
    }
}

impl<T: Scalar> Link<T> {
    fn displaced(
        &self,
        position: &JointPosition<T>,
        displacement: &DVector<T>,
    ) -> JointPosition<T> {
        let first = self.columns.start;
        match position {
            JointPosition::Pose(pose) => {
                JointPosition::Pose(self.inertia.displaced(pose, &six_at(displacement, first)))
            }
            JointPosition::Rotation(rotation) => {
                let turned = turned_by(rotation, &three_at(displacement, first));
                JointPosition::Rotation(*Pose::from_drifted_rotation(&turned).rotation())
            }
            JointPosition::Scalar(number) => JointPosition::Scalar(*number + displacement[first]),
            JointPosition::Fixed => JointPosition::Fixed,
        }
    }
}

impl Multibody {
    /// Adjoint of [`Self::displaced`]. The argument `by_positions` is the gradient with respect to the positions after a displacement. The
    /// results are the gradients with respect to the positions before the displacement, and with respect to the displacement. A gradient
    /// with respect to positions has one number for a small displacement of each column.
    pub fn displaced_back(
        &self,
        displacement: &DVector<f64>,
        by_positions: &DVector<f64>,
    ) -> [DVector<f64>; 2] {
        let mut gradients = [by_positions.clone(), by_positions.clone()];
        for link in &self.links {
            let first = link.columns.start;
            match link.kind {
                JointKind::Free => {
                    let [by_pose, by_displacement] =
                        displaced_back(&six_at(displacement, first), &six_at(by_positions, first));
                    gradients[0].fixed_rows_mut::<6>(first).copy_from(&by_pose);
                    gradients[1]
                        .fixed_rows_mut::<6>(first)
                        .copy_from(&by_displacement);
                }
                JointKind::Ball => {
                    let turn = three_at(displacement, first);
                    let by_turn = three_at(by_positions, first);
                    for (gradient, map) in gradients
                        .iter_mut()
                        .zip([rotation_from_vector(&turn), left_jacobian(&turn)])
                    {
                        gradient
                            .fixed_rows_mut::<3>(first)
                            .copy_from(&map.tr_mul(&by_turn));
                    }
                }
                JointKind::Revolute(_) | JointKind::Prismatic(_) | JointKind::Fixed => {}
            }
        }
        gradients
    }
}

/// Six consecutive numbers, from the given index.
pub(super) fn six_at<T: Scalar>(vector: &DVector<T>, first: usize) -> Vector6<T> {
    vector.fixed_rows::<6>(first).into_owned()
}

/// Three consecutive numbers, from the given index.
pub(super) fn three_at<T: Scalar>(vector: &DVector<T>, first: usize) -> Vector3<T> {
    vector.fixed_rows::<3>(first).into_owned()
}

/// Vector of zeros.
pub(in crate::dynamics) fn zeros<T: Scalar>(width: usize) -> DVector<T> {
    DVector::from_element(width, lift(0.0))
}
