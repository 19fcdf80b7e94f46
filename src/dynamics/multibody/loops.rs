//! Loop joints: constraints between the links of an island, or between a link and a neighbor.
//!
//! A constraint is an equation g = 0 of the poses of two bodies. Its rate is ġ = Σ wᵀv over both bodies, with the twist v and the *unit
//! wrench* w of each body. The constraint force λ applies the wrench λ·w to each body. Therefore it does no work if ġ = 0. In generalized
//! coordinates, ġ = G·u and the generalized forces are Gᵀλ. The force λ is the *multiplier* of the constraint.
//!
//! An implicit stage solves G·u + K·g₀/T + ε·λ = 0 together with the equations of motion. Here g₀ is the value of g at the start of the
//! substep, and T is the duration of the time step. The term K·g₀/T lets the error of g decay, because the equation ġ = 0 alone would not
//! correct it \[Baumgarte 1972\]. The value of g in the stage itself would lower the order of the method, because the positions within a
//! substep are less accurate than those at its end. The compliance ε = τ·C is proportional to the duration τ of the stage.
//!
//! C and K distinguish two kinds of directions in the space of the constraints of a loop. In the directions that motions of the bodies can
//! violate, C is negligible and K is the identity. In redundant directions, C is large and K is zero: no motion can close the loop, so the
//! constraints have no effect. The *mobility* of a direction decides. It is the velocity along the direction that a unit impulse along the
//! direction causes.

use super::screw::{angular, linear};
use super::{Kinematics, MassFactors, Multibody};
use crate::dynamics::BodyState;
use crate::dynamics::loop_joint::Constraint;
use crate::dynamics::rigid_motion::{six, zero6};
use crate::scalar::{DenseDual, Scalar, lift, lift_vector};
use crate::spatial::{Pose, Twist, times_constant, turned_real};
use nalgebra::{DMatrix, DVector, Matrix6, Matrix6xX, SymmetricEigen, Vector3, Vector6};
use std::ops::Range;

/// Compliance of constraints, relative to the upper bound of their mobility. It is far below the tolerance of the solver, and far above
/// round-off.
const COMPLIANCE: f64 = 1e-10;

/// Mobility relative to its upper bound, below which a direction of constraints is redundant. It is the square of an angle of 1e-3 rad between
/// the direction and the nearest motion that it constrains.
const REDUNDANT: f64 = 1e-6;

/// Exponent of the transition at [`REDUNDANT`]. A large exponent keeps constraints stiff near the dead points of linkages.
const SHARPNESS: i32 = 8;

/// Constraints of a loop joint between two participants: links, or neighbors after them.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Loop {
    pub participants: [usize; 2],
    /// Pose of the joint frame in the frame of each participant.
    pub frames: [Pose; 2],
    pub constraints: Vec<Constraint>,
    /// Indices of the multipliers.
    pub multipliers: Range<usize>,
}

/// Constraint at given states of both participants.
struct ConstraintValue<T> {
    /// g (m), or g as the cosine of an angle.
    value: T,
    /// Unit wrenches on both participants, about their centers of mass.
    wrenches: [Vector6<T>; 2],
}

/// Matrices that keep the equations of a loop regular if its constraints are redundant.
pub(in crate::dynamics) struct LoopRegularization {
    /// C = ε/τ (1/kg, or 1/(kg m²)).
    pub compliance: DMatrix<f64>,
    /// K/T (1/s).
    pub closing: DMatrix<f64>,
}

/// Derivatives of the forces and the rates of a loop with respect to the state of one participant, about its center of mass.
pub(in crate::dynamics) struct LoopSlopes {
    /// Derivatives of the wrenches on both participants with respect to displacements.
    pub wrenches: [Matrix6<f64>; 2],
    /// Derivatives of ġ with respect to displacements: one column for each constraint.
    pub by_displacement: Matrix6xX<f64>,
    /// Derivatives of ġ with respect to the twist. They are the unit wrenches.
    pub by_velocity: Matrix6xX<f64>,
}

/// Numbers with derivatives with respect to the displacement and the twist of one body.
type MotionDual = DenseDual<12>;

impl Loop {
    /// States of both participants.
    fn states<'k, T>(&self, kinematics: &'k Kinematics<T>) -> [&'k BodyState<T>; 2] {
        self.participants.map(|index| &kinematics.states[index])
    }

    fn values<T: Scalar>(
        &self,
        states: [&BodyState<T>; 2],
        centers: &[Vector3<T>; 2],
    ) -> Vec<ConstraintValue<T>> {
        let frames = [0, 1].map(|side| {
            let (pose, frame) = (&states[side].pose, &self.frames[side]);
            let origin = pose.transformed_constant(frame.translation());
            (times_constant(pose.rotation(), frame.rotation()), origin)
        });
        let axis = |side: usize, axis: &Vector3<f64>| {
            let [x, y, z] = [0, 1, 2].map(|k| frames[side].0.column(k) * lift::<T>(axis[k]));
            x + y + z
        };
        let value = |constraint: &Constraint| match constraint {
            Constraint::Translation(direction) => {
                let (direction, point) = (axis(0, direction), frames[1].1);
                let force = |side: usize, force: Vector3<T>| {
                    six(&(point - centers[side]).cross(&force), &force)
                };
                ConstraintValue {
                    value: direction.dot(&(point - frames[0].1)),
                    wrenches: [force(0, -direction), force(1, direction)],
                }
            }
            Constraint::Rotation([first, second]) => {
                let (first, second) = (axis(0, first), axis(1, second));
                let torque = second.cross(&first);
                let zero = lift_vector(&Vector3::zeros());
                ConstraintValue {
                    value: first.dot(&second),
                    wrenches: [six(&-torque, &zero), six(&torque, &zero)],
                }
            }
        };
        self.constraints.iter().map(value).collect()
    }
}

impl<T: Scalar> ConstraintValue<T> {
    /// ġ.
    fn rate(&self, states: [&BodyState<T>; 2]) -> T {
        let [first, second] = states.map(|state| state.twist.to_vector());
        self.wrenches[0].dot(&first) + self.wrenches[1].dot(&second)
    }
}

impl LoopRegularization {
    /// Regularization of constraints with a mobility G·M⁻¹·Gᵀ, with upper bounds of its diagonal.
    fn new(mobility: DMatrix<f64>, bounds: &DVector<f64>, closing_time: f64) -> Self {
        let diagonal = |number: &dyn Fn(f64) -> f64| DMatrix::from_diagonal(&bounds.map(number));
        let inverse = |bound: f64| {
            if bound > 0.0 {
                bound.sqrt().recip()
            } else {
                0.0
            }
        };
        let [scale, unscale] = [diagonal(&inverse), diagonal(&|bound| bound.sqrt())];
        let SymmetricEigen {
            eigenvectors,
            eigenvalues,
        } = SymmetricEigen::new(&scale * mobility * &scale);
        // 1 for a redundant direction, and 0 for all others.
        let redundancy =
            eigenvalues.map(|value| (1.0 + (value / REDUNDANT).powi(SHARPNESS)).recip());
        let along = |weights: DVector<f64>| {
            &eigenvectors * DMatrix::from_diagonal(&weights) * eigenvectors.transpose()
        };
        let compliance = along(redundancy.add_scalar(COMPLIANCE));
        let closing = along(redundancy.map(|weight| (1.0 - weight) / closing_time));
        // The compliance is arbitrary if no velocity appears in the constraint.
        let unmoved = diagonal(&|bound| if bound > 0.0 { 0.0 } else { 1.0 });
        Self {
            compliance: &unscale * compliance * &unscale + unmoved,
            closing: unscale * closing * scale,
        }
    }
}

impl<T> Multibody<T> {
    /// Sets the loops, and numbers their multipliers.
    pub fn with_loops(mut self, loops: impl IntoIterator<Item = Loop>) -> Self {
        let mut next = 0;
        self.loops = loops.into_iter().collect();
        for joint in &mut self.loops {
            joint.multipliers = next..next + joint.constraints.len();
            next = joint.multipliers.end;
        }
        self
    }

    /// Number of constraints of all loops.
    pub fn constraint_count(&self) -> usize {
        self.loops.last().map_or(0, |joint| joint.multipliers.end)
    }
}

impl<T: Scalar> Multibody<T> {
    /// Center of mass of a participant, or the origin of a neighbor.
    fn center(&self, participant: usize, state: &BodyState<T>) -> Vector3<T> {
        match self.links.get(participant) {
            Some(link) => state
                .pose
                .transformed_constant(&link.inertia.center_of_mass),
            None => *state.pose.translation(),
        }
    }

    fn loop_values(&self, kinematics: &Kinematics<T>, joint: &Loop) -> Vec<ConstraintValue<T>> {
        let states = joint.states(kinematics);
        let centers = [0, 1].map(|side| self.center(joint.participants[side], states[side]));
        joint.values(states, &centers)
    }

    /// Participants of the loops, and the wrench of each loop on each participant about its center of mass, at given multipliers.
    pub fn loop_wrenches<'k>(
        &'k self,
        kinematics: &'k Kinematics<T>,
        multipliers: &'k DVector<T>,
    ) -> impl Iterator<Item = (usize, Vector6<T>)> + 'k {
        self.loops.iter().flat_map(move |joint| {
            let values = self.loop_values(kinematics, joint);
            [0, 1].map(|side| {
                let forces = values.iter().zip(joint.multipliers.clone());
                let wrench = forces.fold(zero6(), |sum: Vector6<T>, (value, k)| {
                    sum + value.wrenches[side] * multipliers[k]
                });
                (joint.participants[side], wrench)
            })
        })
    }

    /// g of each constraint.
    pub fn constraint_values(&self, kinematics: &Kinematics<T>) -> DVector<T> {
        self.map_constraints(kinematics, |constraint, _| constraint.value)
    }

    /// ġ = G·u of each constraint.
    pub fn loop_rates(&self, kinematics: &Kinematics<T>) -> DVector<T> {
        self.map_constraints(kinematics, ConstraintValue::rate)
    }

    /// Computes a number for each constraint, from its value and the states of its bodies.
    fn map_constraints(
        &self,
        kinematics: &Kinematics<T>,
        number: impl Fn(&ConstraintValue<T>, [&BodyState<T>; 2]) -> T,
    ) -> DVector<T> {
        let numbers = self.loops.iter().flat_map(|joint| {
            let values = self.loop_values(kinematics, joint);
            let states = joint.states(kinematics);
            let numbers = values.iter().map(|value| number(value, states));
            numbers.collect::<Vec<_>>()
        });
        DVector::from_vec(numbers.collect())
    }
}

impl Multibody {
    /// Gᵀ: generalized forces of unit multipliers, one column for each constraint.
    pub fn constraint_forces(&self, kinematics: &Kinematics) -> DMatrix<f64> {
        let mut forces = DMatrix::zeros(self.width(), self.constraint_count());
        let mut wrenches = vec![zero6(); self.links.len()];
        for joint in &self.loops {
            let values = self.loop_values(kinematics, joint);
            for (value, multiplier) in values.iter().zip(joint.multipliers.clone()) {
                for (&participant, unit) in joint.participants.iter().zip(&value.wrenches) {
                    if let Some(wrench) = wrenches.get_mut(participant) {
                        *wrench = *unit;
                    }
                }
                forces.set_column(multiplier, &self.generalized_forces(kinematics, &wrenches));
                wrenches.fill(zero6());
            }
        }
        forces
    }

    /// Regularization of each loop, for a time T (s) in which position errors decay.
    pub fn loop_regularizations(
        &self,
        kinematics: &Kinematics,
        closing_time: f64,
    ) -> Vec<LoopRegularization> {
        let bounds = self.mobility_bounds(kinematics);
        let forces = self.constraint_forces(kinematics);
        let velocities = self.mass_factors(kinematics).velocities_of(&forces);
        let loops = self.loops.iter().map(|joint| {
            let (first, count) = (joint.multipliers.start, joint.multipliers.len());
            let [forces, velocities] =
                [&forces, &velocities].map(|matrix| matrix.columns(first, count));
            let mobility = forces.tr_mul(&velocities);
            let bounds = bounds.rows(first, count).into_owned();
            LoopRegularization::new(mobility, &bounds, closing_time)
        });
        loops.collect()
    }

    /// Upper bounds of the mobilities of the constraints, which do not vanish if a constraint is redundant.
    fn mobility_bounds(&self, kinematics: &Kinematics) -> DVector<f64> {
        let mut forces = DMatrix::<f64>::zeros(self.width(), self.constraint_count());
        let directions = kinematics.velocity_directions();
        for joint in &self.loops {
            let values = self.loop_values(kinematics, joint);
            for (side, &participant) in joint.participants.iter().enumerate() {
                if participant >= self.links.len() {
                    continue;
                }
                for motion in self.body_columns(kinematics, &directions, participant) {
                    for (value, k) in values.iter().zip(joint.multipliers.clone()) {
                        let (unit, axis) = (&value.wrenches[side], &motion.axis);
                        forces[(motion.column, k)] += angular(unit).norm() * angular(axis).norm()
                            + linear(unit).norm() * linear(axis).norm();
                    }
                }
            }
        }
        let matrices = self.mass_matrices(kinematics).into_iter();
        let mut masses: Vec<f64> = matrices
            .flat_map(|matrix| matrix.diagonal().data.as_vec().clone())
            .collect();
        for coupling in self.couplings() {
            let multiplier = coupling.multiplier.abs();
            masses[coupling.leader] += multiplier * multiplier * masses[coupling.follower];
            for mut column in forces.column_iter_mut() {
                let force = column[coupling.follower];
                column[coupling.leader] += multiplier * force;
                column[coupling.follower] = 0.0;
            }
        }
        let bound = |k: usize| {
            let terms = forces.column(k).into_iter().zip(&masses);
            let terms = terms.filter(|(force, _)| **force > 0.0);
            terms.map(|(force, mass)| force * force / mass).sum()
        };
        DVector::from_fn(self.constraint_count(), |k, _| bound(k))
    }

    /// Adds the accelerations that the constraint forces cause. `drift` contains the second derivatives of g at zero accelerations, minus the
    /// required ones.
    pub fn add_loop_accelerations(
        &self,
        accelerations: &mut DVector<f64>,
        (kinematics, masses): (&Kinematics, &MassFactors),
        regularizations: &[LoopRegularization],
        drift: &DVector<f64>,
    ) {
        let forces = self.constraint_forces(kinematics);
        let velocities = masses.velocities_of(&forces);
        // G·M⁻¹·Gᵀ.
        let mut mobility = forces.tr_mul(&velocities);
        for (joint, regularization) in self.loops.iter().zip(regularizations) {
            let (first, count) = (joint.multipliers.start, joint.multipliers.len());
            let mut block = mobility.view_mut((first, first), (count, count));
            block += &regularization.compliance;
        }
        let violation = drift + forces.tr_mul(accelerations);
        if let Some(multipliers) = mobility.lu().solve(&violation) {
            *accelerations -= velocities * multipliers;
        }
    }

    /// Derivatives of a loop with respect to the state of one side.
    pub fn loop_slopes(
        &self,
        kinematics: &Kinematics,
        (joint, side): (&Loop, usize),
    ) -> LoopSlopes {
        let states = joint.states(kinematics);
        let centers = [0, 1].map(|side| self.center(joint.participants[side], states[side]));
        let seeds = |first: usize| {
            let six = Vector6::from_fn(|i, _| MotionDual::variable(0.0, first + i));
            Twist::from_vector(&six)
        };
        let mut moved = states.map(BodyState::lifted);
        let mut moved_centers = centers.map(|center| lift_vector(&center));
        let Twist { angular, linear } = seeds(0);
        moved_centers[side] += linear;
        let BodyState { pose, twist } = states[side];
        let arm = lift_vector(&(pose.translation() - centers[side]));
        let origin = moved_centers[side] + arm + angular.cross(&arm);
        moved[side] = BodyState {
            pose: Pose::from_parts(turned_real(pose.rotation(), &angular), origin),
            twist: Twist {
                angular: lift_vector(&twist.angular) + seeds(6).angular,
                linear: lift_vector(&twist.linear) + seeds(6).linear,
            },
        };
        let moved = [&moved[0], &moved[1]];
        let values = joint.values(moved, &moved_centers);
        let count = values.len();
        let mut slopes = LoopSlopes {
            wrenches: [Matrix6::zeros(); 2],
            by_displacement: Matrix6xX::zeros(count),
            by_velocity: Matrix6xX::zeros(count),
        };
        for (k, (value, multiplier)) in values.iter().zip(joint.multipliers.clone()).enumerate() {
            let force = kinematics.coordinates.multipliers[multiplier];
            for (sum, wrench) in slopes.wrenches.iter_mut().zip(&value.wrenches) {
                *sum += Matrix6::from_fn(|row, column| wrench[row].eps[column]) * force;
            }
            let rate = value.rate(moved);
            let column = |first: usize| Vector6::from_fn(|i, _| rate.eps[first + i]);
            slopes.by_displacement.set_column(k, &column(0));
            slopes.by_velocity.set_column(k, &column(6));
        }
        slopes
    }
}
