//! Whether a linearised contact is that of differences, or a kink explains why it is not.

use super::differences::{BLOCKS, Scaled, Sides, Wrenches};
use super::{COLUMNS, Jacobian, Scene};
use crate::support::hostile::kinks::{Kink, kink_of};
use nalgebra::Vector3;
use std::ops::Range;

/// Derivatives are those of differences if they differ by no more, relative to the largest entry of their block.
pub const DIFFERENCES: f64 = 1e-5;

/// Round-off of derivatives that cancel, relative to the largest of those by a motion.
const CANCELLED: f64 = 1e-13;

/// The first step, relative to size and speed, and those that are tried where it does not do.
pub const STEP: f64 = 1e-6;
const OTHER_STEPS: [f64; 7] = [1e-7, 1e-5, 1e-8, 1e-4, 1e-9, 1e-3, 1e-10];

/// Steps at which the two sides of a kink are looked at.
const KINK_STEPS: [f64; 5] = [1e-8, 1e-7, 1e-6, 1e-5, 1e-4];

/// The largest entry of a block by motion or moduli counts as no less than this part of pressure times size squared.
const LEAST: f64 = 1e-2;

/// Bodies touch with a force of no more than this part of pressure times size squared.
const TOUCHING: f64 = 1e-9;

/// There is no pressure where 1 − d·v_n is no more than this.
const PARTED: f64 = 1e-9;

/// A kink is coincident if it lies within this of where it is looked at, relative to the size: a third of what the kernel
/// takes for coincident.
const COINCIDENT: f64 = 1e-10;

/// The slopes of a side at two steps are the same if they differ by no more, relative to the jump.
const STEADY: f64 = 0.1;

/// What a column of a linearised contact came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Finding {
    /// That of differences.
    Right,
    /// The mean of both sides of a kink.
    Mean,
    /// That of one side of a kink.
    OneSide,
    /// Something between both sides, as several kinks leave it.
    Between,
    /// The wrench itself jumps.
    Jump,
    /// Bodies only just touch, or are only just apart.
    Touching,
    /// Surfaces part just so fast that there is no pressure over a whole polygon.
    Clamp,
    /// A kink that is nearer than what counts as coincidence, and the derivative is not the mean: by so much of the jump.
    NotMean(f64),
    /// The elastic model itself has a kink.
    Elastic(Kink),
    /// Wrong, by so much relative to the largest entry of the block.
    Wrong(f64),
}

/// What is wrong with a column.
#[derive(Debug, Clone)]
pub struct Checked {
    pub column: usize,
    pub finding: Finding,
}

/// Scales of a block of columns.
struct Block {
    columns: Range<usize>,
    largest: f64,
}

/// All columns that differences at the first step do not explain.
pub fn checked(scene: &Scene) -> Vec<Checked> {
    let scaled = Scaled::of(scene);
    let found = scaled.relative(&scene.linearised());
    let mut differences = Jacobian::zeros();
    for column in 0..COLUMNS {
        differences.set_column(column, &scaled.central(column, STEP));
    }
    let mut all = Vec::new();
    // What the law takes away from the elastic wrench and its derivatives leaves their round-off.
    let (elastic, stiffness) = scaled.elastic();
    let force = scaled.at(0, 0.0).amax().max(elastic);
    let stiffness = differences.columns(0, 12).amax().max(stiffness);
    for columns in BLOCKS {
        let largest = differences.columns(columns.start, columns.len()).amax();
        let floor = if matches!(columns.start, 0 | 24) { LEAST * scaled.force } else { 0.0 };
        let block = Block { columns, largest: largest.max(floor) };
        for column in block.columns.clone() {
            let own = found.column(column).into_owned();
            let allowed =
                |step: f64| DIFFERENCES * block.largest + CANCELLED * stiffness + scaled.noise(column, step, [force, stiffness]);
            let first = error(&own, &differences.column(column).into_owned());
            if first <= allowed(STEP) {
                continue;
            }
            let finding = looked_at(&scaled, column, &own, allowed);
            let finding = match finding {
                Finding::Wrong(_) | Finding::NotMean(_) if elastic <= TOUCHING * scaled.force => Finding::Touching,
                Finding::Wrong(_) | Finding::NotMean(_) if is_parted(scene) => Finding::Clamp,
                Finding::Wrong(error) => kink_of(&scene.pair).map_or(Finding::Wrong(error / block.largest), Finding::Elastic),
                other => other,
            };
            if finding != Finding::Right {
                all.push(Checked { column, finding });
            }
        }
    }
    all
}

/// NaN is an infinite error.
fn error(found: &Wrenches, expected: &Wrenches) -> f64 {
    let error = (found - expected).abs().iter().fold(0.0, |a: f64, &b| if b.is_nan() { f64::INFINITY } else { a.max(b) });
    error
}

/// With other steps, and from both sides.
fn looked_at(
    scaled: &Scaled,
    column: usize,
    found: &Wrenches,
    allowed: impl Fn(f64) -> f64,
) -> Finding {
    let mut best = f64::INFINITY;
    for step in OTHER_STEPS {
        let error = error(found, &scaled.central(column, step));
        if error <= allowed(step) {
            return Finding::Right;
        }
        best = best.min(error);
    }
    for step in KINK_STEPS {
        let pair = [step, 0.1 * step].map(|step| scaled.sides(column, step));
        let [Some(wide), Some(near)] = pair else {
            break;
        };
        if let Some(finding) = kink(found, [&wide, &near], &allowed, step) {
            return finding;
        }
    }
    Finding::Wrong(best)
}

/// Whether a polygon has no pressure all over, just so.
fn is_parted(scene: &Scene) -> bool {
    let [a, b] = [scene.pair.a(), scene.pair.b()];
    let velocity = |of: usize, at: &Vector3<f64>| {
        let twist = &scene.twists[of];
        twist.linear + twist.angular.cross(&(at - [a, b][of].pose().translation()))
    };
    scene.pair.surface().polygons.iter().any(|polygon| {
        polygon.outline.corners().iter().all(|corner| {
            let parting = (velocity(0, corner) - velocity(1, corner)).dot(&polygon.normal);
            (1.0 - scene.dissipation * parting).abs() <= PARTED
        })
    })
}

/// A kink is where slopes on either side differ by more than what is allowed, and do so no less at a tenth of the step,
/// while those of each side are steady. The derivative has to lie between them.
fn kink(found: &Wrenches, [wide, near]: [&Sides; 2], allowed: &impl Fn(f64) -> f64, step: f64) -> Option<Finding> {
    let [gap, gap_near] = [wide, near].map(|sides| sides.values[1] - sides.values[0]);
    if gap.amax() > 1e-3 * allowed(step).max(1e-6 * found.amax()) && (gap - gap_near).amax() <= STEADY * gap.amax() && gap.amax() > 1e-7 * wide.values[0].amax() {
        return Some(Finding::Jump);
    }
    let [jump, jump_near] = [wide, near].map(|sides| sides.slopes[1] - sides.slopes[0]);
    let tolerance = 8.0 * allowed(step);
    let is_jump = jump.amax() > tolerance && jump_near.amax() > 0.5 * jump.amax();
    let change = (0..2).map(|side| error(&wide.slopes[side], &near.slopes[side])).fold(0.0, f64::max);
    if !is_jump || change > STEADY * jump.amax() + 8.0 * allowed(0.1 * step) {
        return None;
    }
    let place = -gap.dot(&jump) / jump.norm_squared();
    let from = found - wide.slopes[0];
    let share = from.dot(&jump) / jump.norm_squared();
    let beside = (from - jump * share).amax();
    if step <= 1e-8 && place.abs() <= COINCIDENT && (beside > tolerance + STEADY * jump.amax() || (share - 0.5).abs() > STEADY) {
        return Some(Finding::NotMean((from - jump * 0.5).amax() / jump.amax()));
    }
    if beside > tolerance + STEADY * jump.amax() {
        return None;
    }
    if (share - 0.5).abs() <= STEADY {
        Some(Finding::Mean)
    } else if share.abs() <= STEADY || (share - 1.0).abs() <= STEADY {
        Some(Finding::OneSide)
    } else if (0.0..1.0).contains(&share) {
        Some(Finding::Between)
    } else {
        None
    }
}
