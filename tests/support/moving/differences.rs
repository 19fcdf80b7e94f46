//! One-sided and central differences of the wrenches of a pair in motion, by numbers relative to its size and speed.

use super::{COLUMNS, Jacobian, Scene};
use crate::support::hostile::measures::{MARGIN, Measures};
use nalgebra::{SVector, Vector3};

/// Wrenches on A and B, torques over the size.
pub type Wrenches = SVector<f64, 12>;

/// Columns of poses, twists, moduli, dissipation and friction.
pub const BLOCKS: [std::ops::Range<usize>; 5] = [0..12, 12..24, 24..26, 26..27, 27..28];

/// Errors of a wrench by the rounding of its numbers and sums, relative to force and force by relative motion.
const ROUNDING: f64 = 1e-14;

/// A scene in numbers without units: lengths over the size of the smaller body, speeds over the greatest there are.
pub struct Scaled<'s, 'a> {
    pub scene: &'s Scene<'a>,
    size: f64,
    speed: f64,
    /// Pressure times size squared (N).
    pub force: f64,
    /// Reach of both bodies over the size.
    reach: f64,
}

/// The slopes of the wrenches on either side of where they are, and their values there, from where they are beyond a
/// step.
pub struct Sides {
    pub slopes: [Wrenches; 2],
    pub values: [Wrenches; 2],
}

impl<'s, 'a> Scaled<'s, 'a> {
    pub fn of(scene: &'s Scene<'a>) -> Self {
        let measures = Measures::of(&scene.pair);
        let [a, b] = scene.twists;
        let between = scene.pair.a().pose().translation() - scene.pair.b().pose().translation();
        let velocity: Vector3<f64> = a.linear - b.linear - b.angular.cross(&between);
        let spin = (a.angular - b.angular).norm();
        Self {
            scene,
            size: measures.size,
            force: measures.force(),
            speed: velocity.norm() + spin * measures.reach[0] + scene.slip_tolerance,
            reach: (measures.reach[0] + measures.reach[1]) / measures.size,
        }
    }

    /// What a column's number is relative to.
    fn unit(&self, column: usize) -> f64 {
        match column {
            0..12 if column % 6 < 3 => 1.0,
            0..12 => self.size,
            12..24 if column % 6 < 3 => self.speed / self.size,
            12..24 => self.speed,
            24 => self.scene.pair.a().modulus(),
            25 => self.scene.pair.b().modulus().unwrap_or(1.0),
            _ => 1.0,
        }
    }

    fn without_units(&self, mut wrenches: Wrenches) -> Wrenches {
        for row in [0, 1, 2, 6, 7, 8] {
            wrenches[row] /= self.size;
        }
        wrenches
    }

    /// A Jacobian by relative changes.
    pub fn relative(&self, jacobian: &Jacobian) -> Jacobian {
        let mut relative = *jacobian;
        for column in 0..COLUMNS {
            let own = self.without_units(jacobian.column(column) * self.unit(column));
            relative.set_column(column, &own);
        }
        relative
    }

    /// The largest number of the elastic wrenches, and of their derivatives by a motion.
    pub fn elastic(&self) -> (f64, f64) {
        let elastic = Scene {
            dissipation: 0.0,
            friction: 0.0,
            ..*self.scene
        };
        let wrenches = self.without_units(elastic.wrenches(&SVector::zeros()));
        let jacobian = self.relative(&elastic.linearized());
        (wrenches.amax(), jacobian.columns(0, 12).amax())
    }

    /// The wrenches after a change of one number.
    pub fn at(&self, column: usize, change: f64) -> Wrenches {
        self.along(&[(column, 1.0)], change)
    }

    /// The wrenches after a change along a direction.
    fn along(&self, direction: &[(usize, f64)], change: f64) -> Wrenches {
        let mut changes = SVector::<f64, COLUMNS>::zeros();
        for &(column, weight) in direction {
            changes[column] += change * weight * self.unit(column);
        }
        self.without_units(self.scene.wrenches(&changes))
    }

    /// The mean of the slopes on both sides along a direction.
    pub fn mean_slope(&self, direction: &[(usize, f64)], step: f64) -> Wrenches {
        let [one, two, three] = [1.0, 2.0, 3.0]
            .map(|k| self.along(direction, k * step) - self.along(direction, -k * step));
        (two * 8.0 - one * 5.0 - three * 3.0) / (4.0 * step)
    }

    /// Dissipation and friction are not negative: at 0 they have one side only.
    fn has_one_side(&self, column: usize, step: f64) -> bool {
        let least = 4.0 * step;
        (column == 26 && self.scene.dissipation < least)
            || (column == 27 && self.scene.friction < least)
    }

    /// The central difference; at the end of a range, the one-sided one of the same order.
    pub fn central(&self, column: usize, step: f64) -> Wrenches {
        if self.has_one_side(column, step) {
            let [here, near, far] = [0.0, step, 2.0 * step].map(|change| self.at(column, change));
            return (near * 4.0 - here * 3.0 - far) / (2.0 * step);
        }
        (self.at(column, step) - self.at(column, -step)) / (2.0 * step)
    }

    /// Parabolas through one, two and three steps to either side.
    pub fn sides(&self, column: usize, step: f64) -> Option<Sides> {
        if self.has_one_side(column, step) {
            return None;
        }
        let of_side = |step: f64| {
            let [one, two, three] = [1.0, 2.0, 3.0].map(|k| self.at(column, k * step));
            let slope = (two * 8.0 - one * 5.0 - three * 3.0) / (2.0 * step);
            (slope, one * 3.0 - two * 3.0 + three)
        };
        let [ahead, behind] = [step, -step].map(of_side);
        Some(Sides {
            slopes: [behind.0, ahead.0],
            values: [behind.1, ahead.1],
        })
    }

    /// The mean of the slopes on both sides, by cubics through one to four steps: a parabola is off by a third derivative
    /// times the square of a step, which where faces nearly coincide is no shorter than round-off allows.
    pub fn cubic_mean(&self, column: usize, step: f64) -> Option<Wrenches> {
        if self.has_one_side(column, step) {
            return None;
        }
        let [one, two, three, four] =
            [1.0, 2.0, 3.0, 4.0].map(|k| self.at(column, k * step) - self.at(column, -k * step));
        Some((two * 57.0 - one * 26.0 - three * 42.0 + four * 11.0) / (12.0 * step))
    }

    /// How far a difference may be off by round-off: `force` are the wrenches and `stiffness` their largest derivative by
    /// a motion. What is nearer to a coincidence than the kernel's margin is taken for one.
    pub fn noise(&self, column: usize, step: f64, [force, stiffness]: [f64; 2]) -> f64 {
        let is_geometry = matches!(column, 0..12 | 24 | 25);
        let margin = if is_geometry {
            MARGIN * self.reach
        } else {
            0.0
        };
        (ROUNDING * (force + stiffness) + margin * stiffness) / step
    }
}
