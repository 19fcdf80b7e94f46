//! Derivatives of generalized momenta and forces in closed form.
//!
//! A *direction* changes the coordinates of one column k. It moves the link of the column and all its descendants by a screw Ξ, and gives
//! them the velocity W:
//!
//! | direction | Ξ | W |
//! |---|---|---|
//! | velocity at the end of a stage of duration τ, which also moves the positions | S·D | S |
//! | position at constant velocity | S | 0 |
//! | velocity at constant position | 0 | S |
//!
//! D is τ·J(τω) for the three rotations of a ball joint or a free body, and τ for all other columns. J is the left Jacobian of the
//! exponential map. Let v be the velocity of the frame that the column moves, and B = W + v × Ξ. The velocity and the momentum of each
//! moved link b change by
//!
//! - δv_b = W + Ξ × (v_b − v),
//! - δh_b = I_b·B + Ξ ×* h_b, because I_b·(Ξ × v_b) cancels.
//!
//! The derivative of the axis of a column j is δS = Ξ × S if k is above j, and zero otherwise. Let A = S − τṠ. Let I be the composite
//! inertia of the lower of the two links, and let H be the momentum of this link and its descendants. The derivatives of AᵀH are
//!
//! - k above j: Aᵀ·I·B − τ(B × S)ᵀH,
//! - k at j or below it: Aᵀ·I·B − (Ξ × A)ᵀH.
//!
//! All second derivatives of the kinetic energy cancel by the Jacobi identity.

use super::screw::{angular, at_point, cross_force, cross_motion, linear};
use super::{Column, Coordinates, Kinematics, Multibody};
use crate::dynamics::joint::{JointKind, JointPosition};
use crate::dynamics::rigid_motion::{six, zero6};
use crate::spatial::left_jacobian;
use nalgebra::{DMatrix, DVector, Vector3, Vector6};

/// Motions of the links in the directions of all columns.
pub(in crate::dynamics) struct Directions {
    /// Ξ of each column.
    displacements: Vec<Vector6<f64>>,
    /// Factor of S in W: 1, or 0 at constant velocities.
    velocity: f64,
    /// τ (s) in A = S − τṠ.
    duration: f64,
}

/// Motion of a link in the direction of a column, about the center of mass of the link.
pub(in crate::dynamics) struct BodyColumn {
    pub column: usize,
    /// Velocity per unit of the generalized velocity.
    pub axis: Vector6<f64>,
    pub displacement: Vector6<f64>,
    /// Change of the twist.
    pub velocity: Vector6<f64>,
}

impl Kinematics {
    /// Directions of positions at constant velocities. `duration` is the duration (s) of the stage, or zero.
    pub fn position_directions(&self, duration: f64) -> Directions {
        let axes = self.columns.iter().map(|column| column.axis);
        Directions {
            displacements: axes.collect(),
            velocity: 0.0,
            duration,
        }
    }

    /// Directions of velocities at constant positions.
    pub fn velocity_directions(&self) -> Directions {
        Directions {
            displacements: vec![zero6(); self.columns.len()],
            velocity: 1.0,
            duration: 0.0,
        }
    }
}

impl Multibody {
    /// Directions of the velocities at the end of a stage of a duration (s). The velocities also move the positions.
    pub fn stage_directions(&self, kinematics: &Kinematics, duration: f64) -> Directions {
        let columns = &kinematics.columns;
        let displacements = columns.iter().map(|column| column.axis * duration);
        let mut displacements: Vec<_> = displacements.collect();
        for link in &self.links {
            if matches!(link.kind, JointKind::Free | JointKind::Ball) {
                let first = link.columns.start;
                let spin = kinematics.velocities().fixed_rows::<3>(first);
                let turning = left_jacobian(&(spin * duration)) * duration;
                for (column, factors) in turning.column_iter().enumerate() {
                    displacements[first + column] = columns[first].axis * factors[0]
                        + columns[first + 1].axis * factors[1]
                        + columns[first + 2].axis * factors[2];
                }
            }
        }
        Directions {
            displacements,
            velocity: 1.0,
            duration,
        }
    }

    /// Derivatives of AᵀH + armature·u along directions: one matrix for each tree.
    pub fn momentum_slopes(
        &self,
        kinematics: &Kinematics,
        directions: &Directions,
    ) -> Vec<DMatrix<f64>> {
        let mut matrices = self.tree_matrices();
        let composites = self.composite_inertias(kinematics);
        let duration = directions.duration;
        let columns = &kinematics.columns;
        // A and B of each column.
        let vectors = columns.iter().zip(&directions.displacements);
        let vectors = vectors.map(|(column, displacement)| {
            let projected = column.axis - column.axis_rate * duration;
            let carried = cross_motion(&column.velocity, displacement);
            (projected, column.axis * directions.velocity + carried)
        });
        let vectors: Vec<_> = vectors.collect();
        for (index, link) in self.links.iter().enumerate() {
            let (matrix, first) = (&mut matrices[link.tree], self.trees[link.tree].start);
            let momentum = &kinematics.momenta[index];
            for &column in &link.moving_columns {
                let change = &vectors[column].1;
                let momentum_change = composites[index].times(change);
                let mut slopes = matrix.column_mut(column - first);
                let is_own = columns[column].link == index;
                if !is_own || columns[column].is_outer {
                    // Sᵀ(B ×* H) = −(B × S)ᵀH, so the product B ×* H is computed once for each column.
                    let transport = cross_force(change, momentum) * duration;
                    for row in link.columns.clone() {
                        if is_above(columns, column, row) {
                            slopes[row - first] += vectors[row].0.dot(&momentum_change)
                                + columns[row].axis.dot(&transport);
                        }
                    }
                }
                if !is_own {
                    continue;
                }
                let carried =
                    momentum_change + cross_force(&directions.displacements[column], momentum);
                for &row in &link.moving_columns {
                    if !is_above(columns, column, row) {
                        slopes[row - first] += vectors[row].0.dot(&carried);
                    }
                }
                slopes[column - first] += link.law.armature * directions.velocity;
            }
        }
        matrices
    }

    /// Adds the derivatives of the generalized forces SᵀF, times a factor, to one matrix for each tree. The wrenches on the links about
    /// their centers of mass are constant.
    pub fn add_force_slopes(
        &self,
        matrices: &mut [DMatrix<f64>],
        (kinematics, directions): (&Kinematics, &Directions),
        wrenches: &[Vector6<f64>],
        factor: f64,
    ) {
        let forces = self.subtree_wrenches(kinematics, wrenches);
        let columns = &kinematics.columns;
        for (index, link) in self.links.iter().enumerate() {
            let (matrix, first) = (&mut matrices[link.tree], self.trees[link.tree].start);
            let center = &kinematics.frames[index].center_of_mass;
            let force = linear(&wrenches[index]);
            for &column in &link.moving_columns {
                let displacement = &directions.displacements[column];
                let mut slopes = matrix.column_mut(column - first);
                if columns[column].link != index || columns[column].is_outer {
                    let moved = cross_force(displacement, &forces[index]) * factor;
                    for row in link.columns.clone() {
                        if is_above(columns, column, row) {
                            slopes[row - first] -= columns[row].axis.dot(&moved);
                        }
                    }
                }
                // The wrench moves with the center of mass.
                let shift = linear(displacement) + angular(displacement).cross(center);
                let torque = shift.cross(&force) * factor;
                for &row in &link.moving_columns {
                    slopes[row - first] += angular(&columns[row].axis).dot(&torque);
                }
            }
        }
    }

    /// Adds the derivatives of the joint forces at a time (s), times a factor, to one matrix for each tree. In the direction of its column,
    /// the position and the velocity of a revolute or prismatic joint change by `joint_changes`.
    pub fn add_joint_force_slopes(
        &self,
        matrices: &mut [DMatrix<f64>],
        (coordinates, time): (&Coordinates, f64),
        ([position_change, velocity_change], factor): ([f64; 2], f64),
    ) {
        for (link, position) in self.links.iter().zip(&coordinates.positions) {
            if let JointPosition::Scalar(position) = position {
                let column = link.columns.start;
                let velocity = coordinates.velocities[column];
                let [by_position, by_velocity] = link.law.slopes(*position, velocity, time);
                let i = column - self.trees[link.tree].start;
                matrices[link.tree][(i, i)] +=
                    (by_position * position_change + by_velocity * velocity_change) * factor;
            }
        }
    }

    /// Motions of a link in the directions of all columns that move it.
    pub fn body_columns(
        &self,
        kinematics: &Kinematics,
        directions: &Directions,
        link: usize,
    ) -> Vec<BodyColumn> {
        let frame = &kinematics.frames[link];
        let center = &frame.center_of_mass;
        let at_center = |motion: &Vector6<f64>| at_point(motion, center);
        let of_column = |column: usize| {
            let displacement = at_center(&directions.displacements[column]);
            let relative = frame.velocity - kinematics.columns[column].velocity;
            let change = kinematics.columns[column].axis * directions.velocity
                + cross_motion(&directions.displacements[column], &relative);
            let carried = angular(&frame.velocity).cross(&linear(&displacement));
            BodyColumn {
                column,
                axis: at_center(&kinematics.columns[column].axis),
                displacement,
                velocity: at_center(&change) + six(&Vector3::zeros(), &carried),
            }
        };
        self.links[link]
            .moving_columns
            .iter()
            .copied()
            .map(of_column)
            .collect()
    }

    /// Twists of the links about their centers of mass, from generalized velocities along the axes S − τṠ, with a duration τ (s).
    pub fn twists(
        &self,
        kinematics: &Kinematics,
        velocities: &DVector<f64>,
        duration: f64,
    ) -> Vec<Vector6<f64>> {
        let of_link = |link: usize| {
            let columns = self.links[link].moving_columns.iter().map(|&index| {
                let column = &kinematics.columns[index];
                (column.axis - column.axis_rate * duration) * velocities[index]
            });
            let twist: Vector6<f64> = columns.sum();
            at_point(&twist, &kinematics.frames[link].center_of_mass)
        };
        (0..self.links.len()).map(of_link).collect()
    }

    /// Product of the transposed block-diagonal matrix of the trees and a vector.
    pub fn transposed_product(
        &self,
        matrices: &[DMatrix<f64>],
        vector: &DVector<f64>,
    ) -> DVector<f64> {
        let mut product = vector.clone();
        for (columns, matrix) in self.trees.iter().zip(matrices) {
            let part = matrix.tr_mul(&vector.rows(columns.start, columns.len()));
            product
                .rows_mut(columns.start, columns.len())
                .copy_from(&part);
        }
        product
    }

    fn tree_matrices(&self) -> Vec<DMatrix<f64>> {
        let widths = self.trees.iter().map(ExactSizeIterator::len);
        widths.map(|width| DMatrix::zeros(width, width)).collect()
    }
}

/// Whether a column moves the axis of another column of the same chain.
pub(super) fn is_above(columns: &[Column], upper: usize, lower: usize) -> bool {
    let (upper, lower) = (&columns[upper], &columns[lower]);
    if upper.link == lower.link {
        upper.is_outer && !lower.is_outer
    } else {
        upper.link < lower.link
    }
}
