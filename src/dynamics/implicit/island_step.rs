//! One time step of an island, shared by the real pass, the derivative pass and the reverse sweep.

use super::StepContext;
use super::island::Island;
use super::scheme::Scheme;
use crate::dynamics::RolloutError;
use crate::dynamics::model::Model;
use crate::dynamics::multibody::{
    BodyColumn, Kinematics, LoopRegularization, MassFactors, Multibody,
};
use crate::scalar::{Scalar, lift};
use nalgebra::{DMatrix, DVector, Vector6};
use std::sync::OnceLock;

/// Bodies, method and start time of the step of an island.
pub(in crate::dynamics) struct IslandStep<'a> {
    pub context: &'a StepContext<'a>,
    pub island: &'a Island,
    pub multibody: Multibody,
    pub scheme: &'a Scheme,
    /// Time at the start of the step (s).
    pub start: f64,
    loop_regularizations: OnceLock<Vec<LoopRegularization>>,
    /// Norm of velocities, computed on first use because the dual pass does not need it.
    norm: OnceLock<VelocityNorm>,
}

/// Data for norms of generalized velocities and impulses, at the start of a step.
struct VelocityNorm {
    /// Speed (m/s) that counts for each unit of a generalized velocity, because of the armature.
    rotors: Vec<f64>,
    /// Motions of the dynamic bodies per unit of the generalized velocities.
    axes: Vec<Vec<BodyColumn>>,
    masses: MassFactors,
}

/// Part of a time step, with the velocities that solve its stages.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Substep {
    /// Time from the start of the time step to the start of the substep (s).
    pub offset: f64,
    pub duration: f64,
    /// Generalized velocities and multipliers of loops, one vector for each stage.
    pub roots: Vec<DVector<f64>>,
    /// Indices in the island of the dynamic bodies whose errors exceed their tolerances.
    pub missed: Vec<usize>,
}

/// Record of an island and its accepted substeps in a time step.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct IslandRecord {
    pub island: Island,
    pub substeps: Vec<Substep>,
}

/// Reason why a step failed.
#[derive(Debug)]
pub(in crate::dynamics) enum StepError {
    /// The path of a body is not finite at a time (s).
    Path { body: usize, time: f64 },
    /// The force on a body is not finite at a time (s).
    Force { body: usize, time: f64 },
    /// No solution of a stage was found, down to the shortest duration (s) that was tried. The body is the farthest from a solution.
    Unsolved { body: usize, duration: f64 },
    /// The step was stopped.
    Stopped,
}

impl<'a> IslandStep<'a> {
    pub fn new(
        context: &'a StepContext<'a>,
        island: &'a Island,
        scheme: &'a Scheme,
        start: f64,
    ) -> Self {
        Self {
            context,
            island,
            multibody: context.model.multibody(island.participants(), context.span),
            scheme,
            start,
            loop_regularizations: OnceLock::new(),
            norm: OnceLock::new(),
        }
    }

    fn norm(&self) -> &VelocityNorm {
        self.norm.get_or_init(|| {
            let multibody = &self.multibody;
            let kinematics = self.kinematics_at_start();
            let directions = kinematics.velocity_directions();
            let links = 0..multibody.links.len();
            VelocityNorm {
                rotors: rotor_speeds(multibody),
                axes: links
                    .map(|link| multibody.body_columns(&kinematics, &directions, link))
                    .collect(),
                masses: multibody.mass_factors(&kinematics),
            }
        })
    }

    fn kinematics_at_start(&self) -> Kinematics {
        let (start, multibody) = (self.context.start, &self.multibody);
        let neighbors = self.island.neighbors.iter();
        let neighbors: Vec<_> = neighbors.map(|&body| start.bodies[body]).collect();
        multibody.kinematics(multibody.coordinates(start), &neighbors)
    }

    /// Regularization of each loop. It is constant in a step, and carries no derivatives.
    pub fn loop_regularizations(&self) -> &[LoopRegularization] {
        self.loop_regularizations.get_or_init(|| {
            if self.multibody.loops.is_empty() {
                return Vec::new();
            }
            let closing_time = self.context.span.duration();
            self.multibody
                .loop_regularizations(&self.kinematics_at_start(), closing_time)
        })
    }

    /// Product of a block-diagonal matrix and a vector. The matrix has one block for each loop.
    pub fn loop_product<T: Scalar>(
        &self,
        block: impl Fn(&LoopRegularization) -> &DMatrix<f64>,
        vector: &DVector<T>,
    ) -> DVector<T> {
        let loops = self.multibody.loops.iter();
        let products = loops
            .zip(self.loop_regularizations())
            .flat_map(|(joint, matrices)| {
                let values = &vector.as_slice()[joint.multipliers.clone()];
                let rows = block(matrices).row_iter().map(|row| {
                    let terms = row.into_iter().zip(values);
                    terms.fold(lift(0.0), |sum: T, (weight, value)| sum + *value * *weight)
                });
                rows.collect::<Vec<_>>()
            });
        DVector::from_vec(products.collect())
    }

    /// Speed (m/s) of each dynamic body, from generalized velocities.
    pub fn speeds(&self, velocities: &DVector<f64>) -> impl Iterator<Item = f64> {
        let VelocityNorm { axes, rotors, .. } = self.norm();
        let links = self.multibody.links.iter().zip(axes);
        links.map(|(link, columns)| {
            let columns = columns
                .iter()
                .map(|column| column.axis * velocities[column.column]);
            let rotors = link
                .columns
                .clone()
                .map(|i| rotors[i] * velocities[i].abs());
            rotors.fold(link.inertia.speed(&columns.sum()), f64::max)
        })
    }

    /// Largest speed (m/s) that generalized impulses give to a body.
    pub fn largest_speed_of(&self, impulses: DVector<f64>) -> f64 {
        if impulses.iter().all(|impulse| *impulse == 0.0) {
            return 0.0;
        }
        let velocities = self.norm().masses.velocities(impulses);
        self.speeds(&velocities).fold(0.0, f64::max)
    }
}

/// Speed (m/s) of the heaviest link with the kinetic energy that the armature of each column has at unit velocity. If all links are
/// massless, the mass is 1 kg.
fn rotor_speeds(multibody: &Multibody) -> Vec<f64> {
    let masses = multibody.links.iter().map(|link| link.inertia.mass);
    let largest = masses.fold(0.0, f64::max);
    let mass = if largest > 0.0 { largest } else { 1.0 };
    let mut speeds = vec![0.0; multibody.width()];
    for link in &multibody.links {
        speeds[link.columns.clone()].fill((link.law.armature / mass).sqrt());
    }
    speeds
}

impl IslandRecord {
    /// Bodies of the world whose errors exceed their tolerances in a substep. A body may be repeated.
    pub fn missed(&self) -> impl Iterator<Item = usize> {
        let indices = self.substeps.iter().flat_map(|substep| &substep.missed);
        indices.map(|&index| self.island.dynamic[index])
    }

    /// Memory of one body in a step without subdivision (bytes).
    pub fn min_size(scheme: &Scheme) -> usize {
        let stage = size_of::<DVector<f64>>() + size_of::<Vector6<f64>>();
        let stages = scheme.stages(1.0).count();
        size_of::<Self>() + size_of::<usize>() + size_of::<Substep>() + stages * stage
    }
}

impl StepError {
    /// Converts the failure into the error of a rollout, in a step that begins at a time (s).
    pub fn into_error<T: Scalar>(
        self,
        model: &Model<T>,
        (step, start): (usize, f64),
    ) -> RolloutError {
        let name = |body: usize| model.bodies[body].name().to_owned();
        match self {
            Self::Stopped => RolloutError::Stopped,
            Self::Path { body, time } => RolloutError::PathNotFinite {
                step,
                time,
                body: name(body),
            },
            Self::Force { body, time } => RolloutError::ForceNotFinite {
                step,
                time,
                body: name(body),
            },
            Self::Unsolved { body, duration } => RolloutError::NotSolved {
                step,
                time: start,
                body: name(body),
                shortest: duration,
            },
        }
    }
}
