//! Whether a linearised contact is that of differences, or a kink explains why it is not.

use super::differences::{BLOCKS, Scaled, Sides, Wrenches};
use super::special::{are_faces_touching, is_parted};
use super::{COLUMNS, Jacobian, Scene};
use crate::support::hostile::kinks::{Kink, kink_of};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Derivatives are those of differences if they differ by no more, relative to the largest entry of their block.
pub const DIFFERENCES: f64 = 1e-5;

/// Round-off of derivatives that cancel, relative to the largest of those by a motion.
const CANCELLED: f64 = 1e-13;

/// The first step, relative to size and speed, and those that are tried where it does not do.
const STEP: f64 = 1e-6;
const OTHER_STEPS: [f64; 8] = [1e-7, 1e-5, 1e-8, 1e-4, 1e-9, 1e-3, 1e-10, 1e-2];

/// The step that resolves kinks that are slightly farther than what counts as coincident. Most other differences over this step are noise.
const SHORTEST_STEP: f64 = 1e-11;

/// Steps for kinks that are nearer than that. A difference over a step that is shorter than the distance to all kinks is the derivative itself.
const LOCAL_STEPS: [f64; 2] = [1e-11, 1e-12];

/// Largest miss for which the shortest step is needed.
pub const NEAR: f64 = 1e-7;

/// Steps at which the two sides of a kink are looked at; each with a tenth of it.
const KINK_STEPS: [f64; 5] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4];

/// The largest entry of a block by motion or moduli counts as no less than this part of pressure times size squared.
const LEAST: f64 = 1e-2;

/// Bodies touch with a force of no more than this part of pressure times size squared.
const TOUCHING: f64 = 1e-9;

/// A kink is coincident if the position is missed by less: well below what the kernel takes for coincident, 2.5e-10.
const COINCIDENT: f64 = 3e-11;

/// The slopes of a side at two steps are the same if they differ by no more, relative to the jump; and as near to it
/// are one side, and the mean. Where some of the near faces are taken for coincident and some are not, a plane may be
/// turned by one part in 64.
const STEADY: f64 = 0.1;

/// A wrench that jumps does so by more than this part of itself.
const JUMP: f64 = 1e-7;

/// Differences of second order over three points multiply errors by so many.
const THREE_POINTS: f64 = 8.0;

/// The kernel's direction (`PERTURBATION` in `narrow_phase/weights.rs`), in A's axes: both must be the same.
const PERTURBATION: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);

/// Directions about it have this much of another one in them.
const ABOUT: f64 = 0.05;

/// What a column of a linearised contact came to, if not that of differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// The mean of both sides of a kink.
    Mean,
    /// That of one side of a kink.
    OneSide,
    /// Something between both sides, as several kinks leave it.
    Between,
    /// The derivative between kinks that are nearer than what counts as coincident: that of differences over a shorter step.
    Local,
    /// Several kinks in one place: no linear function is the mean of both sides in all directions. It is that of all
    /// directions about [`PERTURBATION`].
    Corner,
    /// The wrench itself jumps, by this number, or by another one so that what it is here is not what it is on both sides.
    Jump,
    /// Faces of both bodies touch from outside, with no pressure: the free side, without the other.
    Touching,
    /// Surfaces part just so fast that there is no pressure over a whole polygon.
    Clamp,
    /// The elastic model itself has a kink.
    Elastic(Kink),
    /// A kink that is coincident, and the derivative is not the mean: by so much of the jump.
    NotMean(f64),
    /// Wrong, by so much relative to the largest entry of the block.
    Wrong(f64),
}

impl Finding {
    /// A name without numbers.
    pub fn name(self) -> String {
        match self {
            Self::NotMean(_) => "NotMean".into(),
            Self::Wrong(_) => "Wrong".into(),
            Self::Elastic(kink) => format!("{kink:?}"),
            other => format!("{other:?}"),
        }
    }

    /// How wrong it is, if it is.
    pub fn failure(self) -> Option<f64> {
        match self {
            Self::NotMean(error) | Self::Wrong(error) => Some(error),
            _ => None,
        }
    }
}

/// What is to be said of a column.
#[derive(Debug, Clone, Copy)]
pub struct Checked {
    pub column: usize,
    pub finding: Finding,
}

/// The names of what there is.
pub fn names(all: &[Checked]) -> BTreeSet<String> {
    all.iter().map(|checked| checked.finding.name()).collect()
}

/// A scene, and what errors are relative to.
struct Check<'s, 'a> {
    scaled: &'s Scaled<'s, 'a>,
    /// Largest entry of the column's block.
    largest: f64,
    /// Largest numbers of the wrenches, and of their derivatives by a motion.
    force: f64,
    stiffness: f64,
    column: usize,
    /// The whole linearised contact.
    found: &'s Jacobian,
}

/// All columns that differences do not explain.
pub fn checked(scene: &Scene) -> Vec<Checked> {
    let scaled = Scaled::of(scene);
    let found = scaled.relative(&scene.linearised());
    let mut differences = Jacobian::zeros();
    for column in 0..COLUMNS {
        differences.set_column(column, &scaled.central(column, STEP));
    }
    // What the law takes away from the elastic wrench and its derivatives leaves their round-off.
    let (elastic, stiffness) = scaled.elastic();
    let force = scaled.at(0, 0.0).amax().max(elastic);
    let stiffness = differences.columns(0, 12).amax().max(stiffness);
    let mut all = Vec::new();
    for columns in BLOCKS {
        let floor = if matches!(columns.start, 0 | 24) {
            LEAST * scaled.force
        } else {
            0.0
        };
        let largest = differences
            .columns(columns.start, columns.len())
            .amax()
            .max(floor);
        for column in columns {
            let check = Check {
                scaled: &scaled,
                largest,
                force,
                stiffness,
                column,
                found: &found,
            };
            let own: Wrenches = found.column(column).into_owned();
            if error(&own, &differences.column(column).into_owned()) <= check.allowed(STEP) {
                continue;
            }
            let is_at_rest = elastic <= TOUCHING * scaled.force;
            if let Some(finding) = check.finding(&own, is_at_rest) {
                all.push(Checked { column, finding });
            }
        }
    }
    all
}

/// NaN is an infinite error.
fn error(found: &Wrenches, expected: &Wrenches) -> f64 {
    let each = (found - expected).abs();
    each.iter().fold(0.0, |most: f64, &one| {
        if one.is_nan() {
            f64::INFINITY
        } else {
            most.max(one)
        }
    })
}

impl Check<'_, '_> {
    fn allowed(&self, step: f64) -> f64 {
        let noise = self
            .scaled
            .noise(self.column, step, [self.force, self.stiffness]);
        DIFFERENCES * self.largest + CANCELLED * self.stiffness + noise
    }

    /// With other steps, and from both sides.
    fn finding(&self, found: &Wrenches, is_at_rest: bool) -> Option<Finding> {
        let mut best = f64::INFINITY;
        let scene = self.scaled.scene;
        let is_near = (COINCIDENT..NEAR).contains(&scene.missed);
        for step in OTHER_STEPS
            .into_iter()
            .chain(is_near.then_some(SHORTEST_STEP))
        {
            let error = error(found, &self.scaled.central(self.column, step));
            if error <= self.allowed(step) {
                return None;
            }
            best = best.min(error);
        }
        if KINK_STEPS.into_iter().any(|step| self.is_mean(found, step)) {
            return Some(Finding::Mean);
        }
        let kink = KINK_STEPS
            .into_iter()
            .find_map(|step| self.kink(found, step));
        Some(match kink {
            Some(Finding::Jump) => kink_of(&scene.pair).map_or(Finding::Jump, Finding::Elastic),
            Some(finding) if finding.failure().is_none() => finding,
            _ if is_at_rest || are_faces_touching(&scene.pair) => Finding::Touching,
            _ if is_parted(scene) => Finding::Clamp,
            Some(finding) => finding,
            // Along its own axis a column may have one slope at a corner that other columns show.
            None if KINK_STEPS.into_iter().any(|step| self.is_corner(step)) => Finding::Corner,
            None => {
                kink_of(&scene.pair).map_or(Finding::Wrong(best / self.largest), Finding::Elastic)
            }
        })
    }

    /// Whether it is the mean of the slopes on both sides, which a jump of the wrench, however small, does not spoil as it
    /// does a central difference.
    fn is_mean(&self, found: &Wrenches, step: f64) -> bool {
        let parabolic = self
            .scaled
            .sides(self.column, step)
            .map(|sides| (sides.slopes[0] + sides.slopes[1]) * 0.5);
        let cubic = self.scaled.cubic_mean(self.column, step);
        let mut means = parabolic.into_iter().chain(cubic);
        means.any(|mean| error(found, &mean) <= self.allowed(step))
    }

    /// A kink is where slopes on either side differ by more than what is allowed, and do so no less at a tenth of the step,
    /// while those of each side are steady. The derivative has to lie between them, and if the position is special to
    /// within [`COINCIDENT`], to be their mean.
    fn kink(&self, found: &Wrenches, step: f64) -> Option<Finding> {
        let sides = |step| self.scaled.sides(self.column, step);
        let (wide, near) = (sides(step)?, sides(0.1 * step)?);
        let [gap, gap_near] = [&wide, &near].map(|sides| sides.values[1] - sides.values[0]);
        let is_steady = (gap - gap_near).amax() <= STEADY * gap.amax();
        let whole = wide.values[0].amax() + LEAST * self.scaled.force;
        if is_steady && gap.amax() > JUMP * whole {
            return Some(Finding::Jump);
        }
        let here = self.scaled.at(self.column, 0.0);
        let is_away = |sides: &Sides| error(&sides.values[0], &here) > JUMP * whole;
        if is_away(&wide) && is_away(&near) && self.jumps_by_a_modulus(step) {
            return Some(Finding::Jump);
        }
        let [jump, jump_near] = [&wide, &near].map(|sides| sides.slopes[1] - sides.slopes[0]);
        let tolerance = THREE_POINTS * self.allowed(step);
        let is_jump = jump.amax() > tolerance && jump_near.amax() > 0.5 * jump.amax();
        let change = [0, 1].map(|side| error(&wide.slopes[side], &near.slopes[side]));
        let noise = THREE_POINTS * self.allowed(0.1 * step);
        if !is_jump || change[0].max(change[1]) > STEADY * jump.amax() + noise {
            return None;
        }
        let room = tolerance + STEADY * jump.amax();
        let from_mean = error(found, &(wide.slopes[0] + jump * 0.5));
        if from_mean <= room {
            return Some(Finding::Mean);
        }
        if self.scaled.scene.missed <= COINCIDENT {
            if self.is_corner(step) {
                return Some(Finding::Corner);
            }
            return self.is_alone(&wide, step).then(|| {
                if self.is_local(found, jump.amax()) {
                    Finding::Local
                } else {
                    Finding::NotMean(from_mean / jump.amax())
                }
            });
        }
        let is_side = wide.slopes.iter().any(|slope| error(found, slope) <= room);
        if is_side {
            Some(Finding::OneSide)
        } else {
            is_between(found, &wide, room).then_some(Finding::Between)
        }
    }

    /// Whether the position is missed by more than a local step, and the derivative is that of differences over it.
    fn is_local(&self, found: &Wrenches, jump: f64) -> bool {
        LOCAL_STEPS.into_iter().any(|step| {
            step < self.scaled.scene.missed
                && error(found, &self.scaled.central(self.column, step)) <= STEADY * jump
        })
    }

    /// Whether no linear function is the mean of both sides in all directions, and the derivative is the mean in directions about
    /// [`PERTURBATION`]. The position must be special to within [`COINCIDENT`].
    fn is_corner(&self, step: f64) -> bool {
        self.scaled.scene.missed <= COINCIDENT
            && self.column < 12
            && !self.has_linear_mean(step)
            && self.is_mean_about_nudge(step)
    }

    /// Whether nothing else shows at shorter steps.
    fn is_alone(&self, wide: &Sides, step: f64) -> bool {
        let jump = error(&wide.slopes[0], &wide.slopes[1]);
        let mut shorter = KINK_STEPS.into_iter().filter(|other| *other < step);
        shorter.all(|step| {
            let noise = THREE_POINTS * self.allowed(step);
            self.scaled.sides(self.column, step).is_some_and(|near| {
                let change = |side: usize| error(&wide.slopes[side], &near.slopes[side]);
                change(0).max(change(1)) <= STEADY * jump + noise
            })
        })
    }

    /// Whether the wrench jumps as a modulus changes.
    fn jumps_by_a_modulus(&self, step: f64) -> bool {
        let gap = |step| {
            let sides = self.scaled.sides(24, step)?;
            Some(sides.values[1] - sides.values[0])
        };
        gap(step).zip(gap(0.1 * step)).is_some_and(|(wide, near)| {
            let is_steady = (wide - near).amax() <= STEADY * wide.amax();
            let whole = self.scaled.at(24, 0.0).amax() + LEAST * self.scaled.force;
            is_steady && wide.amax() > JUMP * whole
        })
    }

    /// Whether it is the mean of both sides as B moves by [`PERTURBATION`], and by a little of the column's motion besides.
    fn is_mean_about_nudge(&self, step: f64) -> bool {
        let nudge = self.scaled.scene.pair.a().pose().rotation() * PERTURBATION;
        [ABOUT, -ABOUT].into_iter().all(|about| {
            let mut direction: Vec<_> = (0..3).map(|axis| (9 + axis, nudge[axis])).collect();
            direction.push((self.column, about));
            let own = direction
                .iter()
                .map(|&(column, weight)| self.found.column(column) * weight);
            let own: Wrenches = own.sum();
            let along = self.scaled.mean_slope(&direction, step);
            error(&own, &along) <= THREE_POINTS * self.allowed(step)
        })
    }

    /// Whether the mean of both sides is, along a random sum of motions, the sum of the means.
    fn has_linear_mean(&self, step: f64) -> bool {
        let weights: [f64; 12] = std::array::from_fn(|k| (1.0 + k as f64).sin());
        let sum: Wrenches = (0..12)
            .map(|column| self.scaled.mean_slope(&[(column, weights[column])], step))
            .sum();
        let all: Vec<_> = weights.into_iter().enumerate().collect();
        let along = self.scaled.mean_slope(&all, step);
        (along - sum).amax() <= THREE_POINTS * self.allowed(step)
    }
}

/// Whether each number lies between those of both sides.
fn is_between(found: &Wrenches, sides: &Sides, room: f64) -> bool {
    let [one, other] = &sides.slopes;
    (0..12).all(|row| {
        let (low, high) = (one[row].min(other[row]), one[row].max(other[row]));
        (low - room..=high + room).contains(&found[row])
    })
}
