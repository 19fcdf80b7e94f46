//! Compares a linearized contact with differences of the wrenches, and explains deviations by kinks.

use super::differences::{BLOCKS, Scaled, Sides, Wrenches};
use super::special::{are_faces_touching, is_parted};
use super::{COLUMNS, Jacobian, Scene};
use crate::support::hostile::kinks::{Kink, kink_of};
use nalgebra::Vector3;
use std::collections::BTreeSet;

/// Largest error of a derivative, relative to the largest entry of its block.
pub const DIFFERENCES: f64 = 1e-5;

/// Rounding error of derivatives that cancel, relative to the largest derivative with respect to a motion.
const CANCELLED: f64 = 1e-13;

/// The first step of central differences, relative to size and speed.
const STEP: f64 = 1e-6;

/// Steps that are tried if the derivative disagrees with the difference over [`STEP`].
const OTHER_STEPS: [f64; 8] = [1e-7, 1e-5, 1e-8, 1e-4, 1e-9, 1e-3, 1e-10, 1e-2];

/// Additional step if the position is missed by [`COINCIDENT`] to [`NEAR`]. It resolves kinks that are slightly farther away than the
/// library's tolerance for coincidence. At other positions, most differences over this step are noise.
const SHORTEST_STEP: f64 = 1e-11;

/// Steps that resolve kinks if the position is missed by less than [`COINCIDENT`]. If a step is shorter than the distance to all kinks, the
/// difference over it is the derivative itself.
const LOCAL_STEPS: [f64; 2] = [1e-11, 1e-12];

/// Positions that are missed by more than this need no [`SHORTEST_STEP`].
pub const NEAR: f64 = 1e-7;

/// Steps at which the slopes on both sides of a kink are computed. The slopes are also computed at a tenth of the step.
const KINK_STEPS: [f64; 5] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4];

/// Least scale of errors in derivatives with respect to motions or moduli, as a fraction of pressure times size squared.
const LEAST: f64 = 1e-2;

/// Largest elastic force of bodies that only touch, as a fraction of pressure times size squared.
const TOUCHING: f64 = 1e-9;

/// A position counts as special if it is missed by at most this. This is well below the library's tolerance for coincidence, 2.5e-10.
const COINCIDENT: f64 = 3e-11;

/// Tolerance for slopes at a kink, relative to the jump. It applies to the slopes of one side at two steps, and to a derivative that is
/// compared with the slope of a side or with the mean. If only some corners of a near face are snapped to zero, a plane may be rotated by
/// one part in 16 (`LEAST_GAP` in `src/geometry/tolerance.rs`).
const STEADY: f64 = 0.1;

/// Least jump of a wrench, relative to the wrench.
const JUMP: f64 = 1e-7;

/// Factor by which one-sided differences over three points multiply errors.
const THREE_POINTS: f64 = 8.0;

/// Copy of `PERTURBATION` in `src/narrow_phase/weights.rs`, in A's axes.
const PERTURBATION: Vector3<f64> = Vector3::new(0.613, 0.427, -0.665);

/// Weight of a column's motion that is added to [`PERTURBATION`] (see [`Check::is_mean_about_nudge`]).
const ABOUT: f64 = 0.05;

/// The explanation of a column of a linearized contact that differs from differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// The mean of both sides of a kink.
    Mean,
    /// The derivative on one side of a kink.
    OneSide,
    /// A value between both sides. Several kinks may have this result.
    Between,
    /// The derivative between kinks that are nearer than the tolerance for coincidence. It agrees with a difference over a shorter step.
    Local,
    /// Several kinks meet, so no linear function is the mean of both sides in all directions. The derivative is the mean in all directions
    /// near [`PERTURBATION`].
    Corner,
    /// The wrench itself jumps as the column's number changes. Or it jumps as a modulus changes, and its value at the position differs from
    /// its limit on a side.
    Jump,
    /// Faces of both bodies touch from outside, without pressure. The bodies are free on one side of this position.
    Touching,
    /// Surfaces separate at exactly the speed at which the pressure on a whole polygon is zero.
    Clamp,
    /// The elastic model itself has a kink.
    Elastic(Kink),
    /// The position is special, and the derivative is not the mean of both sides. The number is the error relative to the jump.
    NotMean(f64),
    /// No explanation. The number is the error relative to the largest entry of the block.
    Wrong(f64),
}

impl Finding {
    /// Returns the name of the finding, without numbers.
    pub fn name(self) -> String {
        match self {
            Self::NotMean(_) => "NotMean".into(),
            Self::Wrong(_) => "Wrong".into(),
            Self::Elastic(kink) => format!("{kink:?}"),
            unnamed => format!("{unnamed:?}"),
        }
    }

    /// Returns the error of the derivative if the finding is a failure.
    pub fn failure(self) -> Option<f64> {
        match self {
            Self::NotMean(error) | Self::Wrong(error) => Some(error),
            _ => None,
        }
    }
}

/// The finding for a column.
#[derive(Debug, Clone, Copy)]
pub struct Checked {
    pub column: usize,
    pub finding: Finding,
}

/// Returns the names of all findings.
pub fn names(all: &[Checked]) -> BTreeSet<String> {
    all.iter().map(|checked| checked.finding.name()).collect()
}

/// A column of a scene, and the scales of its errors.
struct Check<'s, 'a> {
    scaled: &'s Scaled<'s, 'a>,
    /// Largest entry of the column's block.
    largest: f64,
    /// Largest entry of the wrenches.
    force: f64,
    /// Largest derivative of the wrenches with respect to a motion.
    stiffness: f64,
    /// The column that is checked.
    column: usize,
    /// The whole linearized contact.
    jacobian: &'s Jacobian,
}

/// Returns the findings for all columns that disagree with every central difference.
pub fn checked(scene: &Scene) -> Vec<Checked> {
    let scaled = Scaled::of(scene);
    let jacobian = scaled.relative(&scene.linearized());
    let mut differences = Jacobian::zeros();
    for column in 0..COLUMNS {
        differences.set_column(column, &scaled.central(column, STEP));
    }
    // If the law cancels the elastic wrench or its derivatives, their rounding errors remain.
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
                jacobian: &jacobian,
            };
            let column_slope: Wrenches = jacobian.column(column).into_owned();
            if error(&column_slope, &differences.column(column).into_owned()) <= check.allowed(STEP)
            {
                continue;
            }
            let is_at_rest = elastic <= TOUCHING * scaled.force;
            if let Some(finding) = check.finding(&column_slope, is_at_rest) {
                all.push(Checked { column, finding });
            }
        }
    }
    all
}

/// Returns the largest error of an entry, or infinity if an error is NaN.
fn error(actual: &Wrenches, expected: &Wrenches) -> f64 {
    let each = (actual - expected).abs();
    each.iter().fold(0.0, |most: f64, &entry| {
        if entry.is_nan() {
            f64::INFINITY
        } else {
            most.max(entry)
        }
    })
}

impl Check<'_, '_> {
    /// Returns the largest error that a derivative may have, compared with a difference over this step.
    fn allowed(&self, step: f64) -> f64 {
        let noise = self
            .scaled
            .noise(self.column, step, [self.force, self.stiffness]);
        DIFFERENCES * self.largest + CANCELLED * self.stiffness + noise
    }

    /// Compares a column with differences over other steps, and with the slopes on both sides. Returns `None` if one of the differences
    /// agrees.
    fn finding(&self, column_slope: &Wrenches, is_at_rest: bool) -> Option<Finding> {
        let mut best = f64::INFINITY;
        let scene = self.scaled.scene;
        let is_near = (COINCIDENT..NEAR).contains(&scene.missed);
        for step in OTHER_STEPS
            .into_iter()
            .chain(is_near.then_some(SHORTEST_STEP))
        {
            let error = error(column_slope, &self.scaled.central(self.column, step));
            if error <= self.allowed(step) {
                return None;
            }
            best = best.min(error);
        }
        if KINK_STEPS
            .into_iter()
            .any(|step| self.is_mean(column_slope, step))
        {
            return Some(Finding::Mean);
        }
        let kink = KINK_STEPS
            .into_iter()
            .find_map(|step| self.kink(column_slope, step));
        Some(match kink {
            Some(Finding::Jump) => kink_of(&scene.pair).map_or(Finding::Jump, Finding::Elastic),
            Some(finding) if finding.failure().is_none() => finding,
            _ if is_at_rest || are_faces_touching(&scene.pair) => Finding::Touching,
            _ if is_parted(scene) => Finding::Clamp,
            Some(Finding::NotMean(_)) if self.is_local(column_slope) => Finding::Local,
            Some(finding) => finding,
            // At a corner, a column may have equal slopes on both sides along its own axis. Only other directions show the corner then.
            None if KINK_STEPS.into_iter().any(|step| self.is_corner(step)) => Finding::Corner,
            None => {
                kink_of(&scene.pair).map_or(Finding::Wrong(best / self.largest), Finding::Elastic)
            }
        })
    }

    /// Returns whether the column is the mean of the slopes on both sides. A small jump of the wrench does not change this mean, but
    /// changes a central difference.
    fn is_mean(&self, column_slope: &Wrenches, step: f64) -> bool {
        let parabolic = self
            .scaled
            .sides(self.column, step)
            .map(|sides| (sides.slopes[0] + sides.slopes[1]) * 0.5);
        let cubic = self.scaled.cubic_mean(self.column, step);
        let mut means = parabolic.into_iter().chain(cubic);
        means.any(|mean| error(column_slope, &mean) <= self.allowed(step))
    }

    /// Looks for a kink or a jump, and compares the column with both sides. At a kink, the slopes of the two sides differ by more than the
    /// tolerance. At a tenth of the step, their difference is more than half as large, and the slope of each side is almost the same. The
    /// derivative must lie between the slopes. If the position is missed by at most [`COINCIDENT`], the derivative must be their mean,
    /// except at a corner or between kinks.
    fn kink(&self, column_slope: &Wrenches, step: f64) -> Option<Finding> {
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
        let from_mean = error(column_slope, &(wide.slopes[0] + jump * 0.5));
        if from_mean <= room {
            return Some(Finding::Mean);
        }
        if self.scaled.scene.missed <= COINCIDENT {
            if self.is_corner(step) {
                return Some(Finding::Corner);
            }
            return self
                .is_alone(&wide, step)
                .then(|| Finding::NotMean(from_mean / jump.amax()));
        }
        let is_side = wide
            .slopes
            .iter()
            .any(|slope| error(column_slope, slope) <= room);
        if is_side {
            Some(Finding::OneSide)
        } else {
            is_between(column_slope, &wide, room).then_some(Finding::Between)
        }
    }

    /// Returns whether the derivative is the difference over one of the [`LOCAL_STEPS`] that is shorter than the miss.
    fn is_local(&self, column_slope: &Wrenches) -> bool {
        let Some(sides) = self.scaled.sides(self.column, KINK_STEPS[0]) else {
            return false;
        };
        let jump = (sides.slopes[1] - sides.slopes[0]).amax();
        LOCAL_STEPS.into_iter().any(|step| {
            step < self.scaled.scene.missed
                && error(column_slope, &self.scaled.central(self.column, step)) <= STEADY * jump
        })
    }

    /// Returns whether the position is a corner, and the derivative is the mean of both sides in directions near [`PERTURBATION`]. At a
    /// corner, no linear function is the mean in all directions. The position must be missed by at most [`COINCIDENT`].
    fn is_corner(&self, step: f64) -> bool {
        self.scaled.scene.missed <= COINCIDENT
            && self.column < 12
            && !self.has_linear_mean(step)
            && self.is_mean_about_nudge(step)
    }

    /// Returns whether the slopes are the same at all shorter steps, so that no other kink is nearer.
    fn is_alone(&self, wide: &Sides, step: f64) -> bool {
        let jump = error(&wide.slopes[0], &wide.slopes[1]);
        let mut shorter = KINK_STEPS.into_iter().filter(|shorter| *shorter < step);
        shorter.all(|step| {
            let noise = THREE_POINTS * self.allowed(step);
            self.scaled.sides(self.column, step).is_some_and(|near| {
                let change = |side: usize| error(&wide.slopes[side], &near.slopes[side]);
                change(0).max(change(1)) <= STEADY * jump + noise
            })
        })
    }

    /// Returns whether the wrench jumps as the modulus of A changes.
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

    /// Returns whether the derivative is the mean of both sides as B moves by [`PERTURBATION`] plus or minus [`ABOUT`] times the column's
    /// motion.
    fn is_mean_about_nudge(&self, step: f64) -> bool {
        let nudge = self.scaled.scene.pair.a().pose().rotation() * PERTURBATION;
        [ABOUT, -ABOUT].into_iter().all(|about| {
            let mut direction: Vec<_> = (0..3).map(|axis| (9 + axis, nudge[axis])).collect();
            direction.push((self.column, about));
            let slope_along = direction
                .iter()
                .map(|&(column, weight)| self.jacobian.column(column) * weight);
            let slope_along: Wrenches = slope_along.sum();
            let along = self.scaled.mean_slope(&direction, step);
            error(&slope_along, &along) <= THREE_POINTS * self.allowed(step)
        })
    }

    /// Returns whether the mean of both sides is linear: along a fixed weighted sum of all motions, it must be the weighted sum of the
    /// means.
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

/// Returns whether each entry lies between the slopes of both sides.
fn is_between(column_slope: &Wrenches, sides: &Sides, room: f64) -> bool {
    let [first, second] = &sides.slopes;
    (0..12).all(|row| {
        let (low, high) = (first[row].min(second[row]), first[row].max(second[row]));
        (low - room..=high + room).contains(&column_slope[row])
    })
}
