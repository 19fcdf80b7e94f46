//! An island's step that was taken, followed again in `f64`.

use super::island::Island;
use super::problem::{Problem, joined_all, own};
use super::scheme::{Scheme, Stage};
use super::steps::{Part, Way};
use super::{PairWrenches, Scene, Stuck};
use crate::contact::LinearisedContact;
use crate::dynamics::sweep::Sweep;
use crate::dynamics::{BodyState, Inertia};
use nalgebra::{DVector, Vector6};

/// As much of an island's [`Way`] as leads it through the step again.
#[derive(Debug, Clone)]
pub(in crate::dynamics) struct Trace {
    pub island: Island,
    parts: Vec<Part>,
}

impl Trace {
    pub(super) fn of(island: Island, way: Way) -> Self {
        let parts = way.parts;
        Self { island, parts }
    }

    /// Whether the step was taken in several parts.
    pub fn is_divided(&self) -> bool {
        self.parts.len() > 1
    }

    /// The size (bytes) of that of one body in a step that is not divided.
    pub fn least_size(scheme: &Scheme) -> usize {
        let stage = size_of::<DVector<f64>>() + size_of::<Vector6<f64>>();
        let stages = scheme.stages(1.0).count();
        size_of::<Self>() + size_of::<usize>() + size_of::<Part>() + stages * stage
    }
}

/// An island in a step that was taken.
pub(in crate::dynamics) struct Follower<'a> {
    scene: &'a Scene<'a>,
    trace: &'a Trace,
    scheme: &'a Scheme,
    /// Time at the start of the step (s).
    start: f64,
    /// Of the dynamic bodies.
    pub inertias: Vec<&'a Inertia>,
}

/// A part of a step that was taken.
pub(in crate::dynamics) struct PartTaken<'a> {
    /// The dynamic bodies at its start.
    pub from: Vec<BodyState>,
    pub stages: Vec<StageTaken<'a>>,
}

/// A stage that was solved.
pub(in crate::dynamics) struct StageTaken<'a> {
    pub stage: Stage,
    problem: Problem<'a>,
    root: &'a DVector<f64>,
    /// How far the dynamic bodies have come before it (turn and shift about the centre of mass), from the start of the part.
    pub displacements: Vec<Vector6<f64>>,
    /// Where all participants come to.
    pub states: Vec<BodyState>,
}

impl<'a> Follower<'a> {
    pub fn of(scene: &'a Scene<'a>, trace: &'a Trace, scheme: &'a Scheme, start: f64) -> Self {
        Self {
            scene,
            trace,
            scheme,
            start,
            inertias: scene.inertias(&trace.island),
        }
    }

    pub fn island(&self) -> &'a Island {
        &self.trace.island
    }

    /// The parts of the step.
    pub fn parts(&self) -> Vec<PartTaken<'_>> {
        let bodies = self.trace.island.dynamic.iter();
        let mut states: Vec<_> = bodies.map(|&body| self.scene.start[body]).collect();
        let mut taken = Vec::with_capacity(self.trace.parts.len());
        for part in &self.trace.parts {
            let part = self.part(part, states.clone());
            if let Some(last) = part.stages.last() {
                let end = &last.states[..states.len()];
                states = end.to_vec();
            }
            taken.push(part);
        }
        taken
    }

    fn part(&self, part: &'a Part, from: Vec<BodyState>) -> PartTaken<'_> {
        let stages = self.scheme.stages(part.duration).zip(&part.stages);
        let stages = stages.map(|(stage, root)| {
            let accumulated = |place: usize| {
                let before = part.stages.iter().map(|velocities| own(velocities, place));
                stage.accumulated(&before.collect::<Vec<_>>())
            };
            let displacements: Vec<_> = (0..from.len()).map(accumulated).collect();
            let starts = self.inertias.iter().zip(&from).zip(&displacements);
            let poses = starts
                .map(|((inertia, body), displacement)| inertia.displaced(&body.pose, displacement));
            let time = Part::time(self.start, part.offset, &stage);
            let problem = Problem {
                scene: self.scene,
                island: &self.trace.island,
                inertias: &self.inertias,
                poses: poses.collect(),
                momenta: Vec::new(),
                duration: stage.duration,
                neighbors: self.scene.neighbors_at(&self.trace.island, time),
                time,
            };
            StageTaken {
                stage,
                states: problem.states_with(root),
                problem,
                root,
                displacements,
            }
        });
        let stages = stages.collect();
        PartTaken { from, stages }
    }
}

impl StageTaken<'_> {
    /// The time (s) at which wrenches act.
    pub fn time(&self) -> f64 {
        self.problem.time
    }

    /// The velocities of a dynamic body.
    pub fn velocities(&self, place: usize) -> Vector6<f64> {
        own(self.root, place)
    }

    /// The pairs of participants that may touch, A first.
    pub fn close_pairs(&self) -> Vec<(usize, usize)> {
        let Problem { scene, island, .. } = &self.problem;
        let mut sweep = Sweep::default();
        scene.close_pairs(island, &self.states, &mut sweep).to_vec()
    }

    /// From the derivatives of a number by the velocities of each body to those by what its momenta lack, −r: J⁻ᵀ times the
    /// former. The contacts are all of two participants each.
    pub fn by_lack<'c>(
        &self,
        contacts: impl Iterator<Item = ([usize; 2], &'c LinearisedContact)>,
        by_velocities: &[Vector6<f64>],
    ) -> Result<Vec<Vector6<f64>>, Stuck> {
        if self.problem.scene.is_stopped() {
            return Err(Stuck::Stopped);
        }
        let pairs = contacts.map(|(bodies, contact)| {
            PairWrenches::of(
                &self.problem.geometry(bodies, &self.states),
                bodies,
                contact,
            )
        });
        let matrix = self
            .problem
            .exact_matrix(&self.states, &pairs.collect::<Vec<_>>());
        let factors = matrix.transposed().factorised(self.problem.scene.patterns);
        let right = joined_all(by_velocities.iter().copied());
        let solution = factors.solve(&right);
        let solution = solution.ok_or_else(|| self.problem.unsolved())?;
        let places = 0..by_velocities.len();
        Ok(places.map(|place| own(&solution, place)).collect())
    }
}
