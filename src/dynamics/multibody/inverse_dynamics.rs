//! Inverse dynamics, with derivatives in closed form.
//!
//! The spatial acceleration of a link is a = a_parent + S·u̇ + Ṡ·u. Its momentum is h = I·v, and the wrench that moves it is f = I·a + v ×* h.
//! The generalized forces are τ = SᵀF + A·u̇. F is the sum of the wrenches on a link and its descendants, and A has the armatures. The base
//! accelerates by −g, which replaces the weights of the links \[Featherstone 2008, Rigid Body Dynamics Algorithms, section 5.3\].
//!
//! The derivatives with respect to the position and the velocity of a column k follow from the motions of [`super::slopes`]. Let v and a be
//! the velocity and the acceleration of the frame that the column moves. Let ψ = v × S_k and η = a × S_k. The wrench on each moved link
//! changes by
//!
//! - position: δf = S_k ×* f + I·(η + v × ψ) + B·ψ,
//! - velocity: δf = I·(Ṡ_k + ψ) + B·S_k.
//!
//! The matrix B of a link with the velocity w is B·m = −I·(w × m) + w ×* (I·m) + m ×* h. Sums over descendants replace I, B and f by their
//! composites. If k is above j, a position also changes the axis S_j by S_k × S_j, and this change cancels S_jᵀ(S_k ×* F).

use super::screw::{SpatialInertia, cross_force, cross_motion, dot};
use super::slopes::is_above;
use super::{Column, Kinematics, Multibody};
use crate::dynamics::rigid_motion::six;
use crate::scalar::{Scalar, lift_vector};
use nalgebra::{DMatrix, DVector, Matrix6, Vector3, Vector6};
use std::array;

/// Spatial accelerations for generalized accelerations. They include −g.
pub(in crate::dynamics) struct Accelerations<T = f64> {
    /// Generalized accelerations.
    generalized: DVector<T>,
    /// Acceleration of each link.
    pub(super) links: Vec<Vector6<T>>,
    /// Acceleration of the frame that each column moves.
    frames: Vec<Vector6<T>>,
}

impl<T: Scalar> Multibody<T> {
    /// Spatial accelerations for generalized accelerations and gravity. The spatial acceleration of the neighbors is −g.
    pub fn accelerations(
        &self,
        kinematics: &Kinematics<T>,
        generalized: DVector<T>,
        gravity: &Vector3<T>,
    ) -> Accelerations<T> {
        let base = six(&lift_vector(&Vector3::zeros()), &-gravity);
        let columns = &kinematics.columns;
        let mut links: Vec<Vector6<T>> = Vec::with_capacity(self.links.len());
        let mut frames = vec![base; columns.len()];
        for (index, link) in self.links.iter().enumerate() {
            let mut acceleration = self.parent_link(index).map_or(base, |parent| links[parent]);
            for is_outer in [true, false] {
                let elementary = link.columns.clone();
                let elementary = elementary.filter(|&column| columns[column].is_outer == is_outer);
                for column in elementary.clone() {
                    let velocity = kinematics.velocities()[column];
                    acceleration += columns[column].axis * generalized[column]
                        + columns[column].axis_rate * velocity;
                }
                for column in elementary {
                    frames[column] = acceleration;
                }
            }
            links.push(acceleration);
        }
        Accelerations {
            generalized,
            links,
            frames,
        }
    }

    /// Generalized forces that cause accelerations.
    pub fn inverse_dynamics(
        &self,
        kinematics: &Kinematics<T>,
        accelerations: &Accelerations<T>,
    ) -> DVector<T> {
        let forces = self.moving_wrenches(kinematics, accelerations);
        let columns = kinematics.columns.iter().zip(&accelerations.generalized);
        let forces = columns.map(|(column, acceleration)| {
            let armature = self.links[column.link].law.armature;
            dot(&column.axis, &forces[column.link]) + armature * *acceleration
        });
        DVector::from_vec(forces.collect())
    }

    /// Wrench that moves each link and its descendants.
    fn moving_wrenches(
        &self,
        kinematics: &Kinematics<T>,
        accelerations: &Accelerations<T>,
    ) -> Vec<Vector6<T>> {
        let frames = kinematics.frames.iter().zip(&accelerations.links);
        let inertias = self.inertias(kinematics).into_iter().zip(frames);
        let wrenches = inertias.map(|(inertia, (frame, acceleration))| {
            let momentum = inertia.times(&frame.velocity);
            inertia.times(acceleration) + cross_force(&frame.velocity, &momentum)
        });
        self.summed_over_subtrees(wrenches.collect(), |sum, wrench| sum + wrench)
    }
}

impl Multibody {
    /// Derivatives of the inverse dynamics with respect to the positions and the velocities of all columns.
    pub fn inverse_dynamics_slopes(
        &self,
        kinematics: &Kinematics,
        accelerations: &Accelerations,
    ) -> [DMatrix<f64>; 2] {
        let mut slopes = array::from_fn(|_| DMatrix::zeros(self.width(), self.width()));
        let composites = self.composite_inertias(kinematics);
        let coriolis = self.composite_coriolis_matrices(kinematics);
        let forces = self.moving_wrenches(kinematics, accelerations);
        let columns = &kinematics.columns;
        for (index, link) in self.links.iter().enumerate() {
            for &k in &link.moving_columns {
                let column = &columns[k];
                let acceleration = &accelerations.frames[k];
                let changes =
                    force_changes(&composites[index], &coriolis[index], column, acceleration);
                let carried = cross_force(&column.axis, &forces[index]);
                for &j in &link.moving_columns {
                    let [by_position, by_velocity] =
                        changes.map(|change| columns[j].axis.dot(&change));
                    if is_above(columns, k, j) {
                        if columns[j].link == index {
                            slopes[0][(j, k)] = by_position;
                            slopes[1][(j, k)] = by_velocity;
                        }
                    } else if column.link == index {
                        slopes[0][(j, k)] = by_position + columns[j].axis.dot(&carried);
                        slopes[1][(j, k)] = by_velocity;
                    }
                }
            }
        }
        slopes
    }

    /// Matrix B of each link and its descendants.
    fn composite_coriolis_matrices(&self, kinematics: &Kinematics) -> Vec<Matrix6<f64>> {
        let frames = self
            .inertias(kinematics)
            .into_iter()
            .zip(&kinematics.frames);
        let matrices = frames.map(|(inertia, frame)| coriolis_matrix(&inertia, &frame.velocity));
        self.summed_over_subtrees(matrices.collect(), |sum, matrix| sum + matrix)
    }
}

/// I·(η + v × ψ) + B·ψ and I·(Ṡ + ψ) + B·S for a column and the acceleration of the frame that the column moves.
fn force_changes(
    inertia: &SpatialInertia,
    coriolis: &Matrix6<f64>,
    column: &Column,
    acceleration: &Vector6<f64>,
) -> [Vector6<f64>; 2] {
    let transport = cross_motion(&column.velocity, &column.axis);
    let by_position =
        cross_motion(acceleration, &column.axis) + cross_motion(&column.velocity, &transport);
    [
        inertia.times(&by_position) + coriolis * transport,
        inertia.times(&(column.axis_rate + transport)) + coriolis * column.axis,
    ]
}

/// Matrix B of a link: B·m = −I·(v × m) + v ×* (I·m) + m ×* (I·v) for all motions m.
fn coriolis_matrix(inertia: &SpatialInertia, velocity: &Vector6<f64>) -> Matrix6<f64> {
    let momentum = inertia.times(velocity);
    let column = |k: usize| {
        let motion = Vector6::ith(k, 1.0);
        cross_force(velocity, &inertia.times(&motion)) + cross_force(&motion, &momentum)
            - inertia.times(&cross_motion(velocity, &motion))
    };
    Matrix6::from_columns(&array::from_fn::<_, 6, _>(column))
}
