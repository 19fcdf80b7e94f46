//! Momenta, forces and energies in generalized coordinates.

use super::coordinates::zeros;
use super::screw::{about_reference, dot};
use super::{Coordinates, Kinematics, Multibody};
use crate::dynamics::joint::JointPosition;
use crate::scalar::Scalar;
use nalgebra::{DVector, Vector6};
use std::borrow::Borrow;

impl<T: Scalar> Kinematics<T> {
    /// ṠᵀH: the part of dp/dt that does no work.
    pub fn momentum_transport(&self) -> DVector<T> {
        let rates = self.columns.iter();
        let rates = rates.map(|column| dot(&column.axis_rate, &self.momenta[column.link]));
        DVector::from_vec(rates.collect())
    }
}

impl<T: Scalar> Multibody<T> {
    /// Generalized momenta p = SᵀH + A·u.
    pub fn generalized_momenta(&self, kinematics: &Kinematics<T>) -> DVector<T> {
        self.projected_momenta(kinematics, 0.0)
    }

    /// (S − τṠ)ᵀH + A·u, with a duration τ (s).
    pub fn projected_momenta(&self, kinematics: &Kinematics<T>, duration: f64) -> DVector<T> {
        let momenta = &kinematics.momenta;
        let columns = kinematics.columns.iter().zip(kinematics.velocities());
        let projected = columns.map(|(column, velocity)| {
            let axis = column.axis - column.axis_rate.map(|component| component * duration);
            dot(&axis, &momenta[column.link]) + self.links[column.link].law.armature * *velocity
        });
        DVector::from_vec(projected.collect())
    }

    /// Generalized forces SᵀF of wrenches on the links, about their centers of mass.
    pub fn generalized_forces(
        &self,
        kinematics: &Kinematics<T>,
        wrenches: impl IntoIterator<Item = impl Borrow<Vector6<T>>>,
    ) -> DVector<T> {
        let forces = self.subtree_wrenches(kinematics, wrenches);
        let columns = kinematics.columns.iter();
        DVector::from_vec(
            columns
                .map(|column| dot(&column.axis, &forces[column.link]))
                .collect(),
        )
    }

    /// Wrench on each link and its descendants, about the reference point, from wrenches about the centers of mass.
    pub(super) fn subtree_wrenches(
        &self,
        kinematics: &Kinematics<T>,
        wrenches: impl IntoIterator<Item = impl Borrow<Vector6<T>>>,
    ) -> Vec<Vector6<T>> {
        let links = kinematics.frames.iter().zip(wrenches);
        let about =
            links.map(|(frame, wrench)| about_reference(wrench.borrow(), &frame.center_of_mass));
        self.summed_over_subtrees(about.collect(), |sum, wrench| sum + wrench)
    }

    /// Forces Q of the joints at a time (s): springs, dampers, friction, stops and actuators.
    pub fn joint_forces(&self, coordinates: &Coordinates<T>, time: f64) -> DVector<T> {
        let mut forces = zeros(self.width());
        self.add_joint_forces(coordinates, time, &mut forces);
        forces
    }

    /// Adds the forces Q of the joints at a time (s) to generalized forces.
    pub fn add_joint_forces(
        &self,
        coordinates: &Coordinates<T>,
        time: f64,
        forces: &mut DVector<T>,
    ) {
        for (link, position) in self.links.iter().zip(&coordinates.positions) {
            if let JointPosition::Scalar(position) = position {
                let column = link.columns.start;
                let velocity = coordinates.velocities[column];
                forces[column] += link.law.force(*position, velocity, time);
            }
        }
    }
}
