//! One-sided and central differences of the wrenches of a moving pair, with respect to changes relative to its size and speed.

use super::{COLUMNS, Jacobian, Scene};
use crate::support::hostile::measures::{MARGIN, Measures};
use nalgebra::{SVector, Vector3};

/// Wrenches on A and B, with torques divided by the size.
pub type Wrenches = SVector<f64, 12>;

/// Columns of poses, twists, moduli, dissipation and friction.
pub const BLOCKS: [std::ops::Range<usize>; 5] = [0..12, 12..24, 24..26, 26..27, 27..28];

/// Rounding error of a wrench, relative to the force, and to the force per relative motion.
const ROUNDING: f64 = 1e-14;

/// A nondimensional scene: lengths are divided by the size of the smaller body, and speeds by the largest speed.
pub struct Scaled<'s, 'a> {
    pub scene: &'s Scene<'a>,
    size: f64,
    speed: f64,
    /// Pressure times size squared (N).
    pub force: f64,
    /// Reach of both bodies divided by the size.
    reach: f64,
}

/// Slopes of the wrenches on both sides of the current state, and values at the state extrapolated from each side beyond a step.
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

    /// Returns the unit of a column.
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

    /// Converts a Jacobian to relative changes.
    pub fn relative(&self, jacobian: &Jacobian) -> Jacobian {
        let mut relative = *jacobian;
        for column in 0..COLUMNS {
            let column_slope = self.without_units(jacobian.column(column) * self.unit(column));
            relative.set_column(column, &column_slope);
        }
        relative
    }

    /// Returns the largest entry of the elastic wrenches, and of their derivatives with respect to a motion.
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

    /// Returns the wrenches after a change of one variable.
    pub fn at(&self, column: usize, change: f64) -> Wrenches {
        self.along(&[(column, 1.0)], change)
    }

    /// Returns the wrenches after a change along a direction.
    fn along(&self, direction: &[(usize, f64)], change: f64) -> Wrenches {
        let mut changes = SVector::<f64, COLUMNS>::zeros();
        for &(column, weight) in direction {
            changes[column] += change * weight * self.unit(column);
        }
        self.without_units(self.scene.wrenches(&changes))
    }

    /// Returns the mean of the slopes on both sides along a direction.
    pub fn mean_slope(&self, direction: &[(usize, f64)], step: f64) -> Wrenches {
        let [single, double, triple] = [1.0, 2.0, 3.0]
            .map(|k| self.along(direction, k * step) - self.along(direction, -k * step));
        (double * 8.0 - single * 5.0 - triple * 3.0) / (4.0 * step)
    }

    /// Returns whether only one side is valid: dissipation and friction are not negative, so at 0 they have one side only.
    fn has_one_side(&self, column: usize, step: f64) -> bool {
        let least = 4.0 * step;
        (column == 26 && self.scene.dissipation < least)
            || (column == 27 && self.scene.friction < least)
    }

    /// Returns the central difference or, at the end of a range, the one-sided difference of the same order.
    pub fn central(&self, column: usize, step: f64) -> Wrenches {
        if self.has_one_side(column, step) {
            let [here, near, far] = [0.0, step, 2.0 * step].map(|change| self.at(column, change));
            return (near * 4.0 - here * 3.0 - far) / (2.0 * step);
        }
        (self.at(column, step) - self.at(column, -step)) / (2.0 * step)
    }

    /// Fits parabolas through one, two and three steps to either side.
    pub fn sides(&self, column: usize, step: f64) -> Option<Sides> {
        if self.has_one_side(column, step) {
            return None;
        }
        let of_side = |step: f64| {
            let [single, double, triple] = [1.0, 2.0, 3.0].map(|k| self.at(column, k * step));
            let slope = (double * 8.0 - single * 5.0 - triple * 3.0) / (2.0 * step);
            (slope, single * 3.0 - double * 3.0 + triple)
        };
        let [ahead, behind] = [step, -step].map(of_side);
        Some(Sides {
            slopes: [behind.0, ahead.0],
            values: [behind.1, ahead.1],
        })
    }

    /// Returns the mean of the slopes on both sides, by cubics through one to four steps. The error of a parabola is a third derivative
    /// times the squared step, and if faces nearly coincide, round-off limits how short the step can be.
    pub fn cubic_mean(&self, column: usize, step: f64) -> Option<Wrenches> {
        if self.has_one_side(column, step) {
            return None;
        }
        let [single, double, triple, quadruple] =
            [1.0, 2.0, 3.0, 4.0].map(|k| self.at(column, k * step) - self.at(column, -k * step));
        Some((double * 57.0 - single * 26.0 - triple * 42.0 + quadruple * 11.0) / (12.0 * step))
    }

    /// Returns the bound of a difference's rounding error. `force` are the wrenches, and `stiffness` is their largest derivative with
    /// respect to a motion. A position within the kernel's margin of a coincidence counts as coincident.
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
