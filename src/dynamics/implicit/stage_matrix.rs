//! Matrix of a stage: derivatives of the residual with respect to the unknowns.

use super::about_centers::block;
use super::evaluation::ForceJacobian;
use super::frozen_contact_model::PairWrenches;
use super::matrix::BlockMatrix;
use super::stage::StageEquations;
use crate::dynamics::multibody::{BodyColumn, Directions, Kinematics, Loop, Multibody};
use nalgebra::{Matrix6, Vector6};

/// Matrix of a stage during its assembly.
struct MatrixAssembly<'a> {
    matrix: BlockMatrix,
    multibody: &'a Multibody,
    end: &'a Kinematics,
    directions: Directions,
    /// Columns of each link on which wrenches depend. Empty for other links.
    columns: Vec<Vec<BodyColumn>>,
    /// Duration of the stage (s).
    duration: f64,
}

impl StageEquations<'_> {
    /// Derivatives of the residual with respect to the unknowns, from the wrenches of contacts and forces on the dynamic bodies.
    pub fn matrix(
        &self,
        end: &Kinematics,
        wrenches: &[Vector6<f64>],
        contacts: &[PairWrenches],
        forces: &[ForceJacobian],
    ) -> BlockMatrix {
        let (multibody, duration) = (self.multibody, self.start.duration);
        let mut assembly = MatrixAssembly {
            matrix: BlockMatrix::zeros(multibody),
            multibody,
            end,
            directions: multibody.stage_directions(end, duration),
            columns: Vec::new(),
            duration,
        };
        assembly
            .columns
            .resize_with(multibody.links.len(), Vec::new);
        let by_velocity = self.slopes_along(&assembly.directions, (end, wrenches), [duration, 1.0]);
        for (tree, slopes) in by_velocity.iter().enumerate() {
            let mut block = assembly.matrix.block(tree, tree);
            block += slopes;
        }
        for slopes in forces {
            assembly.add_bodies([slopes.row, slopes.column]);
            let by_motion = [&slopes.by_displacement, &slopes.by_velocities];
            assembly.add_wrench_slopes(slopes.row, slopes.column, by_motion);
        }
        for contact in contacts {
            assembly.add_contact(contact);
        }
        for (index, joint) in multibody.loops.iter().enumerate() {
            assembly.add_loop(index, joint);
        }
        let trees = multibody.trees.len();
        for (index, matrices) in self.step.loop_regularizations().iter().enumerate() {
            let mut block = assembly.matrix.block(trees + index, trees + index);
            block += &matrices.compliance * duration;
        }
        assembly.matrix
    }
}

impl MatrixAssembly<'_> {
    /// Computes the columns of the links among these participants, unless they are already computed.
    fn add_bodies(&mut self, participants: [usize; 2]) {
        for participant in participants {
            if let Some(columns) = self.columns.get_mut(participant)
                && columns.is_empty()
            {
                *columns = self
                    .multibody
                    .body_columns(self.end, &self.directions, participant);
            }
        }
    }

    /// Adds the derivatives of the wrench on one link with respect to the displacement and the velocities of another link.
    fn add_wrench_slopes(
        &mut self,
        row: usize,
        column: usize,
        [by_displacement, by_velocities]: [&Matrix6<f64>; 2],
    ) {
        let [row_tree, column_tree] = [row, column].map(|link| self.multibody.links[link].tree);
        let [first_row, first_column] =
            [row_tree, column_tree].map(|tree| self.multibody.trees[tree].start);
        let mut block = self.matrix.block(row_tree, column_tree);
        for moved in &self.columns[column] {
            let change = by_displacement * moved.displacement + by_velocities * moved.velocity;
            for pushed in &self.columns[row] {
                block[(pushed.column - first_row, moved.column - first_column)] -=
                    pushed.axis.dot(&change) * self.duration;
            }
        }
    }

    /// Adds the derivatives of the wrenches of a contact.
    fn add_contact(&mut self, contact: &PairWrenches) {
        self.add_bodies(contact.bodies);
        let count = self.columns.len();
        for (row, &body) in contact.bodies.iter().enumerate() {
            for (column, &other_body) in contact.bodies.iter().enumerate() {
                if body < count && other_body < count {
                    let slopes = [&contact.by_displacements, &contact.by_velocities];
                    let [by_displacement, by_velocities] =
                        slopes.map(|slopes| block(slopes, row, column));
                    let by_motion = [&by_displacement, &by_velocities];
                    self.add_wrench_slopes(body, other_body, by_motion);
                }
            }
        }
    }

    /// Adds the derivatives of the wrenches of a loop, and the block rows and block columns of its multipliers.
    fn add_loop(&mut self, index: usize, joint: &Loop) {
        self.add_bodies(joint.participants);
        let (multibody, end) = (self.multibody, self.end);
        let block_index = multibody.trees.len() + index;
        for (side, &participant) in joint.participants.iter().enumerate() {
            let Some(link) = multibody.links.get(participant) else {
                continue;
            };
            let slopes = multibody.loop_slopes(end, (joint, side));
            for (&body, by_displacement) in joint.participants.iter().zip(&slopes.wrenches) {
                if body < self.columns.len() {
                    let by_motion = [by_displacement, &Matrix6::zeros()];
                    self.add_wrench_slopes(body, participant, by_motion);
                }
            }
            let first = multibody.trees[link.tree].start;
            let mut rates = self.matrix.block(block_index, link.tree);
            for moved in &self.columns[participant] {
                let change = slopes.by_displacement.tr_mul(&moved.displacement)
                    + slopes.by_velocity.tr_mul(&moved.velocity);
                let mut column = rates.column_mut(moved.column - first);
                column += change;
            }
            // The derivatives of ġ with respect to the twist are the unit wrenches.
            let mut impulses = self.matrix.block(link.tree, block_index);
            for pushed in &self.columns[participant] {
                let forces = slopes.by_velocity.tr_mul(&pushed.axis) * self.duration;
                let mut row = impulses.row_mut(pushed.column - first);
                row -= forces.transpose();
            }
        }
    }
}
