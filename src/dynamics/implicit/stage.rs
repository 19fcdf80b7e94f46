//! Equation of one implicit stage. The unknowns are the generalized velocities u of an island at the end of the stage:
//!
//! (S − τṠ)ᵀH + A·u = p̃ + τ(SᵀF + Q), at the positions q̃ ⊕ τu.
//!
//! Here q̃ and p̃ are the positions and the generalized momenta at the start, and τ is the duration. F are all wrenches, and Q are the
//! forces of the joints. [`multibody`](crate::dynamics::multibody) defines the other symbols. The equation needs no Coriolis terms, because
//! it is an equation between momenta. For the same reason, the momenta of a free tree are conserved.
//!
//! Loops add the multipliers λ to the unknowns, the wrenches of the multipliers to F, and the equations G·u + K·g₀/T + ε·λ = 0 to the system.

use super::island_step::{IslandStep, StepError};
use super::scheme::Stage;
use crate::dynamics::BodyState;
use crate::dynamics::joint::JointPosition;
use crate::dynamics::multibody::{Coordinates, Kinematics, Multibody};
use crate::scalar::{Scalar, lift, real_part};
use nalgebra::{DVector, Vector6};

/// Start of a stage.
#[derive(Clone)]
pub(in crate::dynamics) struct StageStart<T = f64> {
    /// Displacement of the joints since the start of the substep, one number for each column.
    pub displacement: DVector<T>,
    /// q̃: positions of the joints.
    pub positions: Vec<JointPosition<T>>,
    /// p̃: generalized momenta.
    pub momenta: DVector<T>,
    /// K·g₀/T: rates at which the loops close, one number for each constraint.
    pub closing_rates: DVector<T>,
    /// τ (s).
    pub duration: f64,
    /// Time (s) at which the wrenches of the stage act.
    pub time: f64,
}

/// Equations of a stage of an island, in the scalar type of a pass. The module documentation has the equations.
pub(super) struct StageEquations<'a, T = f64> {
    pub step: &'a IslandStep<'a>,
    pub multibody: &'a Multibody<T>,
    /// Weight and control of each body of the world.
    pub applied: &'a [Vector6<T>],
    pub start: StageStart<T>,
    /// States of the neighbors at the time of the stage.
    pub neighbors: Vec<BodyState<T>>,
}

/// Stages of a substep, in the scalar type of a pass. The start of each stage follows from the rates of the earlier stages.
///
/// The real pass, the derivative pass and the reverse sweep take positions, momenta and times from this type. A different order of
/// summation would change the last bit. The last bit can decide whether a switched force acts.
pub(super) struct Stages<'a, T = f64> {
    pub step: &'a IslandStep<'a>,
    multibody: &'a Multibody<T>,
    offset: f64,
    /// Positions at the start of the substep.
    from: Vec<JointPosition<T>>,
    momenta: DVector<T>,
    closing_rates: DVector<T>,
    rates: Vec<StageRates<T>>,
}

/// Generalized velocities in a stage, and rates of the generalized momenta.
pub(super) struct StageRates<T = f64> {
    pub velocities: DVector<T>,
    pub momenta: DVector<T>,
}

impl<T: Scalar> StageEquations<'_, T> {
    /// Kinematics at the end of the stage, from the velocities and the multipliers of loops.
    pub fn end(&self, unknowns: DVector<T>) -> Kinematics<T> {
        let (width, count) = (self.multibody.width(), self.multibody.constraint_count());
        let multipliers = unknowns.rows(width, count).into_owned();
        let velocities = if count == 0 {
            unknowns
        } else {
            unknowns.remove_rows(width, count)
        };
        let displacement = velocities.map(|velocity| velocity * self.start.duration);
        let positions = self
            .multibody
            .displaced(&self.start.positions, &displacement);
        let coordinates = Coordinates {
            positions,
            velocities,
            multipliers,
        };
        self.multibody.kinematics(coordinates, &self.neighbors)
    }

    /// Residual of the equation at the end of the stage, from the wrenches of contacts and forces on the dynamic bodies.
    pub fn residual(&self, end: &Kinematics<T>, wrenches: &[Vector6<T>]) -> DVector<T> {
        let duration = self.start.duration;
        let wrenches = self.total_wrenches(end, wrenches);
        let mut forces = self.multibody.generalized_forces(end, wrenches);
        self.multibody
            .add_joint_forces(&end.coordinates, self.start.time, &mut forces);
        let mut residual = self.multibody.projected_momenta(end, duration) - &self.start.momenta;
        for (number, force) in residual.iter_mut().zip(&forces) {
            *number -= *force * duration;
        }
        self.with_loop_residuals(residual, end)
    }

    /// Appends the residuals of loops to the residual of the equation of motion.
    fn with_loop_residuals(&self, residual: DVector<T>, end: &Kinematics<T>) -> DVector<T> {
        let (width, count) = (self.multibody.width(), self.multibody.constraint_count());
        if count == 0 {
            return residual;
        }
        let mut full = residual.resize_vertically(width + count, lift(0.0));
        let multipliers = &end.coordinates.multipliers;
        let compliant = self
            .step
            .loop_product(|loops| &loops.compliance, multipliers);
        let rates = self.multibody.loop_rates(end) + &self.start.closing_rates;
        for (k, (rate, compliant_rate)) in rates.iter().zip(&compliant).enumerate() {
            full[width + k] = *rate + *compliant_rate * self.start.duration;
        }
        full
    }

    /// Wrenches on the dynamic bodies, including gravity, controls and loops.
    pub fn total_wrenches(&self, end: &Kinematics<T>, wrenches: &[Vector6<T>]) -> Vec<Vector6<T>> {
        let wrenches = wrenches.iter().enumerate();
        let mut total: Vec<_> = wrenches
            .map(|(index, wrench)| self.applied_wrench(index) + wrench)
            .collect();
        let multipliers = &end.coordinates.multipliers;
        for (participant, wrench) in self.multibody.loop_wrenches(end, multipliers) {
            if let Some(sum) = total.get_mut(participant) {
                *sum += wrench;
            }
        }
        total
    }

    /// Gravity and controls on a dynamic body.
    pub fn applied_wrench(&self, index: usize) -> Vector6<T> {
        self.applied[self.step.island.dynamic[index]]
    }

    /// The equations without derivatives.
    pub fn real(&self) -> StageEquations<'_> {
        let StageStart {
            displacement,
            positions,
            momenta,
            closing_rates,
            duration,
            time,
        } = &self.start;
        StageEquations {
            step: self.step,
            multibody: &self.step.multibody,
            applied: &self.step.context.applied,
            start: StageStart {
                displacement: displacement.map(real_part),
                positions: positions.iter().map(JointPosition::real).collect(),
                momenta: momenta.map(real_part),
                closing_rates: closing_rates.map(real_part),
                duration: *duration,
                time: *time,
            },
            neighbors: self.neighbors.iter().map(BodyState::real).collect(),
        }
    }
}

impl<'a> StageEquations<'a> {
    /// Equations in `f64`.
    pub fn new(step: &'a IslandStep<'a>, start: StageStart) -> Self {
        Self {
            step,
            multibody: &step.multibody,
            applied: &step.context.applied,
            neighbors: step.context.neighbors_at(step.island, start.time),
            start,
        }
    }
}

impl IslandStep<'_> {
    /// Equations of a stage in `f64`.
    ///
    /// # Errors
    /// If the path of a neighbor is not finite.
    pub(super) fn equations(&self, start: StageStart) -> Result<StageEquations<'_>, StepError> {
        let equations = StageEquations::new(self, start);
        let lost = equations
            .neighbors
            .iter()
            .position(|state| !state.is_finite());
        match lost {
            Some(index) => Err(StepError::Path {
                body: self.island.neighbors[index],
                time: equations.start.time,
            }),
            None => Ok(equations),
        }
    }
}

impl<'a, T: Scalar> Stages<'a, T> {
    /// Stages of a substep that begins at an offset (s) from the start of the step.
    pub fn new(
        step: &'a IslandStep<'a>,
        multibody: &'a Multibody<T>,
        offset: f64,
        from: &Kinematics<T>,
    ) -> Self {
        Self {
            step,
            multibody,
            offset,
            from: from.coordinates.positions.clone(),
            momenta: multibody.generalized_momenta(from),
            closing_rates: step
                .loop_product(|loops| &loops.closing, &multibody.constraint_values(from)),
            rates: Vec::new(),
        }
    }

    /// Start of the next stage.
    pub fn start(&self, stage: &Stage) -> StageStart<T> {
        let width = self.multibody.width();
        let displacement =
            stage.accumulated(width, self.rates.iter().map(|rates| &rates.velocities));
        let impulse = stage.accumulated(width, self.rates.iter().map(|rates| &rates.momenta));
        StageStart {
            positions: self.multibody.displaced(&self.from, &displacement),
            momenta: &self.momenta + impulse,
            closing_rates: self.closing_rates.clone(),
            displacement,
            duration: stage.duration,
            time: self.step.start + (self.offset + stage.offset),
        }
    }

    /// Adds the rates of a stage, from its start and its end.
    pub fn push(&mut self, start: &StageStart<T>, end: &Kinematics<T>) -> &StageRates<T> {
        let per_duration = start.duration.recip();
        let impulse = self.multibody.generalized_momenta(end) - &start.momenta;
        self.rates.push(StageRates {
            velocities: end.velocities().clone(),
            momenta: impulse.map(|number| number * per_duration),
        });
        &self.rates[self.rates.len() - 1]
    }

    /// Rates of the stages so far.
    pub fn rates(&self) -> &[StageRates<T>] {
        &self.rates
    }
}
