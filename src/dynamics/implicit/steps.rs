//! An island through one time step, in as many parts as its forces ask for.

use super::Scene;
use super::attempt::{Attempt, Tried};
use super::island::Island;
use super::problem::{Problem, joined_all};
use super::report::{EnergyBalance, Work};
use super::scheme::{Scheme, Stage};
use crate::dynamics::system::System;
use crate::dynamics::{BodyState, Inertia, RolloutError};
use crate::geometry::Aabb;
use crate::scalar::Scalar;
use crate::spatial::Pose;
use nalgebra::{DVector, Vector6};

/// A step is halved where the wrench on a body changes from one stage to the next so much that over the part of the step that
/// was tried it could give it more energy than this part of its kinetic energy, and twice that of a fall for the step.
const LARGEST_GAIN: f64 = 0.04;

/// How often a step is halved because its forces change much in it: to 1/128.
const MOST_HALVINGS: u32 = 7;

/// And because a stage was not solved: to 1/4096.
const MOST_RETRIES: u32 = 12;

/// A part of a time step with the velocities of its stages.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// When it begins, from the start of the time step (s).
    pub offset: f64,
    pub duration: f64,
    pub stages: Vec<DVector<f64>>,
}

impl Part {
    /// The time (s) at which the wrenches of a stage act, in a time step from `start` on. The real pass, the derivative pass and
    /// the reverse sweep all ask here: two orders of these sums differ by an ulp, which decides at a switched force.
    pub fn time(start: f64, offset: f64, stage: &Stage) -> f64 {
        start + (offset + stage.offset)
    }
}

/// An island's way through a time step.
#[derive(Debug)]
pub(super) struct Way {
    pub parts: Vec<Part>,
    pub bodies: Vec<Moving>,
    pub work: Work,
    pub energy: EnergyBalance,
    /// Where each participant has been.
    pub swept: Vec<Aabb>,
}

/// A dynamic body between two parts of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub state: BodyState,
    /// The wrench of all but gravity and controls in the last stage, where one is known.
    pub acting: Option<Vector6<f64>>,
}

/// Why a step was not taken.
#[derive(Debug)]
pub(in crate::dynamics) enum Stuck {
    /// The place of a body whose path is not finite at a time (s).
    Path { body: usize, time: f64 },
    /// The place of the body farthest from a solution, and the shortest duration (s) that was tried.
    Unsolved { body: usize, duration: f64 },
    /// The step should end.
    Stopped,
}

impl Stuck {
    /// In the step of this count from a time (s) on.
    pub fn into_error<T: Scalar>(
        self,
        system: &System<T>,
        (step, start): (usize, f64),
    ) -> RolloutError {
        let name = |body: usize| system.bodies[body].name().to_owned();
        match self {
            Self::Stopped => RolloutError::Stopped,
            Self::Path { body, time } => RolloutError::PathNotFinite {
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

/// An island in a time step.
pub(super) struct Stepper<'a> {
    pub scene: &'a Scene<'a>,
    pub island: &'a Island,
    pub inertias: Vec<&'a Inertia>,
    pub scheme: &'a Scheme,
    pub tolerance: f64,
    /// Time at the start of the step (s).
    pub start: f64,
    /// By how much forces may change the speed (m/s) of each body between two stages.
    pub largest_changes: Vec<f64>,
    pub way: Way,
}

impl<'a> Stepper<'a> {
    pub fn new(
        scene: &'a Scene<'a>,
        island: &'a Island,
        (scheme, tolerance): (&'a Scheme, f64),
        start: f64,
        bodies: Vec<Moving>,
    ) -> Self {
        Self {
            scene,
            island,
            inertias: scene.inertias(island),
            scheme,
            tolerance,
            start,
            largest_changes: Vec::new(),
            way: Way {
                parts: Vec::new(),
                bodies,
                work: Work::default(),
                energy: EnergyBalance::default(),
                swept: Vec::new(),
            },
        }
    }

    /// Takes the step.
    pub fn through(mut self, duration: f64) -> Result<Way, Stuck> {
        self.limit_changes(duration);
        if self.scheme.is_adaptive {
            self.evaluate_start()?;
        }
        self.advance(0.0, duration, 0)?;
        Ok(self.way)
    }

    /// The speed δ that brings a body of speed v the energy vδ + δ²/2 (m²/s², by its mass), which is that of halving. It is the
    /// same in all parts of the step: what does no harm to the whole is not worth more parts.
    fn limit_changes(&mut self, duration: f64) {
        let fall = self.scene.system.gravity.norm() * duration;
        let of_body = |(inertia, body): (&&Inertia, &Moving)| {
            let speed = inertia.speed(&body.state.twist.to_vector());
            let doubled_energy = LARGEST_GAIN * speed * speed + 2.0 * fall * fall;
            (speed * speed + doubled_energy).sqrt() - speed
        };
        let bodies = self.inertias.iter().zip(&self.way.bodies);
        self.largest_changes = bodies.map(of_body).collect();
    }

    /// Where no step went before, finds what acts at the start.
    fn evaluate_start(&mut self) -> Result<(), Stuck> {
        if self.way.bodies.iter().all(|body| body.acting.is_some()) {
            return Ok(());
        }
        let poses = self.way.bodies.iter().map(|body| body.state.pose);
        let problem = self.problem(poses.collect(), Vec::new(), [self.start, 0.0])?;
        let evaluation = problem.evaluation(velocities_of(&self.way.bodies), false);
        let acting = (0..self.way.bodies.len()).map(|place| evaluation.acting(place));
        let acting: Vec<_> = acting.collect();
        self.way.work.evaluations += usize::from(!evaluation.contacts.is_empty());
        for (body, acting) in self.way.bodies.iter_mut().zip(acting) {
            body.acting.get_or_insert(acting);
        }
        Ok(())
    }

    /// Takes a part of the step, in halves if need be.
    fn advance(&mut self, offset: f64, duration: f64, depth: u32) -> Result<(), Stuck> {
        let (tried, work) = Attempt::new(self, offset, duration).finished();
        self.way.work += work;
        match tried {
            Ok(tried) if tried.change > 1.0 && depth < MOST_HALVINGS => {
                self.way.work.halvings += 1;
            }
            Ok(tried) => {
                self.accept(tried, offset, duration);
                return Ok(());
            }
            Err(Stuck::Unsolved { .. }) if depth < MOST_RETRIES => self.way.work.failures += 1,
            Err(stuck) => return Err(stuck),
        }
        let half = duration / 2.0;
        self.advance(offset, half, depth + 1)?;
        self.advance(offset + half, half, depth + 1)
    }

    fn accept(&mut self, tried: Tried, offset: f64, duration: f64) {
        self.way.parts.push(Part {
            offset,
            duration,
            stages: tried.stages,
        });
        self.way.bodies = tried.bodies;
        self.way.energy += tried.energy;
        if self.way.swept.is_empty() {
            self.way.swept = tried.swept;
        } else {
            for (all, own) in self.way.swept.iter_mut().zip(&tried.swept) {
                *all = all.union(own);
            }
        }
    }

    pub fn kinetic(&self, bodies: &[Moving]) -> f64 {
        let of_body = |(inertia, body): (&&Inertia, &Moving)| {
            let twist = body.state.twist.to_vector();
            inertia.momentum(&body.state).dot(&twist) / 2.0
        };
        self.inertias.iter().zip(bodies).map(of_body).sum()
    }

    /// A stage from poses with momenta, that ends at a time (s) and has a duration (s).
    pub fn problem(
        &self,
        poses: Vec<Pose>,
        momenta: Vec<Vector6<f64>>,
        [time, duration]: [f64; 2],
    ) -> Result<Problem<'_>, Stuck> {
        let neighbors = self.scene.neighbors_at(self.island, time);
        if let Some(lost) = neighbors.iter().position(|state| !state.is_finite()) {
            let body = self.island.neighbors[lost];
            return Err(Stuck::Path { body, time });
        }
        Ok(Problem {
            scene: self.scene,
            island: self.island,
            inertias: &self.inertias,
            poses,
            momenta,
            duration,
            neighbors,
            time,
        })
    }
}

/// The velocities of bodies.
pub(super) fn velocities_of(bodies: &[Moving]) -> DVector<f64> {
    joined_all(bodies.iter().map(|body| body.state.twist.to_vector()))
}
