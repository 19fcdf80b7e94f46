//! Fractions of the steps of Newton's method \[Deuflhard 2011, §3.3, algorithm NLEQ-ERR\]. A step is measured by the next one with
//! the same matrix, and not by the residual, because the round-off of stiff contacts dominates the residual.

use nalgebra::DVector;

/// The shortest fraction that is tried.
const SHORTEST: f64 = 1e-3;

/// Smallest and largest factor of the fraction after a failed test.
const REDUCTIONS: [f64; 2] = [0.1, 0.5];

/// A step of Newton's method and the fraction of it that is tried.
pub(super) struct DampedStep {
    /// Change of the velocities.
    pub step: DVector<f64>,
    /// Its speed (m/s).
    pub size: f64,
    /// Between 0 and 1.
    pub fraction: f64,
}

/// The next step from where a fraction of a step led, with the matrix of that step.
pub(super) struct NextWithSameMatrix {
    pub step: DVector<f64>,
    /// Its speed (m/s).
    pub size: f64,
}

impl DampedStep {
    /// A step of which all is tried.
    pub fn full(step: DVector<f64>, size: f64) -> Self {
        Self {
            step,
            size,
            fraction: 1.0,
        }
    }

    /// The natural test: whether a fraction makes the next step smaller.
    pub fn is_accepted(&self, next: &NextWithSameMatrix) -> bool {
        next.size <= (1.0 - self.fraction / 4.0) * self.size
    }

    /// Takes a smaller fraction after a failed test: the one that solves best if the part of the next step that is not
    /// linear grows with the square of the fraction. False if that is too short to be tried.
    pub fn shorten(
        &mut self,
        next: &NextWithSameMatrix,
        speed: impl Fn(&DVector<f64>) -> f64,
    ) -> bool {
        let bend = speed(&(&next.step - &self.step * (1.0 - self.fraction)));
        let best = self.size * self.fraction / (2.0 * bend);
        let [least, most] = REDUCTIONS;
        // `max` and `min` ignore NaN.
        self.fraction *= best.max(least).min(most);
        self.fraction >= SHORTEST
    }

    /// The next step, with its own matrix. The change of the matrix tells how far it is valid.
    pub fn followed_by(
        self,
        next: &NextWithSameMatrix,
        step: DVector<f64>,
        speed: impl Fn(&DVector<f64>) -> f64,
    ) -> Self {
        let size = speed(&step);
        let change = speed(&(&next.step - &step));
        let valid = self.fraction * self.size * next.size / (change * size);
        let fraction = if valid < 1.0 {
            valid.max(2.0 * SHORTEST)
        } else {
            1.0
        };
        Self {
            step,
            size,
            fraction,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    /// Newton's method for atan(x) = 0, and the number of function values that it takes.
    fn root_of_atan(from: f64) -> (f64, usize) {
        let speed = |step: &DVector<f64>| step.norm();
        let newton = |x: f64| -x.atan() * (1.0 + x * x);
        let (mut x, mut count) = (from, 0);
        let first = dvector![newton(x)];
        let mut damped = DampedStep::full(first.clone(), speed(&first));
        for _ in 0..30 {
            let next = loop {
                let ahead = x + damped.step[0] * damped.fraction;
                let step = dvector![-ahead.atan() * (1.0 + x * x)];
                let size = speed(&step);
                count += 1;
                let next = NextWithSameMatrix { step, size };
                if damped.is_accepted(&next) {
                    x = ahead;
                    break next;
                }
                assert!(damped.shorten(&next, speed));
            };
            if next.size < 1e-14 {
                break;
            }
            damped = damped.followed_by(&next, dvector![newton(x)], speed);
        }
        (x, count)
    }

    #[test]
    fn a_damped_step_finds_the_root_from_where_newtons_method_diverges() {
        // Undamped, it diverges from 1.392 on.
        for (from, most) in [(1.0, 6), (3.0, 9), (10.0, 12), (100.0, 16)] {
            let (root, count) = root_of_atan(from);
            assert!(root.abs() < 1e-12, "{from}: {root:e}");
            assert!(count <= most, "{from}: {count}");
        }
    }
}
