//! Damping of Newton's method by Deuflhard's error-oriented estimates \[Deuflhard 2011, §3.3, algorithm NLEQ-ERR\]. A step is judged by
//! the simplified correction, and not by the residual, because the round-off of stiff contacts dominates the residual.

use nalgebra::DVector;

/// Shortest fraction that is tried.
const SHORTEST: f64 = 1e-3;

/// Smallest and largest factor by which a failed test reduces the fraction of the step.
const REDUCTIONS: [f64; 2] = [0.1, 0.5];

/// Step of Newton's method, and the fraction of it that is tried.
pub(super) struct DampedStep {
    /// Change of the velocities.
    pub step: DVector<f64>,
    /// Norm of the step (m/s).
    pub size: f64,
    /// Fraction of the step that is tried, between 0 and 1.
    pub fraction: f64,
}

/// Step of Newton's method from the trial velocities, with the matrix of the previous step.
pub(super) struct SimplifiedCorrection {
    pub step: DVector<f64>,
    /// Norm of the step (m/s).
    pub size: f64,
}

impl DampedStep {
    /// Step that is not damped yet.
    pub fn full(step: DVector<f64>, size: f64) -> Self {
        Self {
            step,
            size,
            fraction: 1.0,
        }
    }

    /// Natural monotonicity test: returns whether the size of the simplified correction is at most (1 − fraction/4) times the size of the
    /// step.
    pub fn is_accepted(&self, simplified: &SimplifiedCorrection) -> bool {
        simplified.size <= (1.0 - self.fraction / 4.0) * self.size
    }

    /// Reduces the fraction after a failed test. The nonlinear part of the correction is assumed to grow with the square of the fraction.
    /// The new fraction minimizes the predicted correction. Returns false if the fraction is too short to be tried.
    pub fn shorten(
        &mut self,
        simplified: &SimplifiedCorrection,
        norm: impl Fn(&DVector<f64>) -> f64,
    ) -> bool {
        let nonlinear = norm(&(&simplified.step - &self.step * (1.0 - self.fraction)));
        let best = self.size * self.fraction / (2.0 * nonlinear);
        let [least, most] = REDUCTIONS;
        // `max` and `min` ignore NaN.
        self.fraction *= best.max(least).min(most);
        self.fraction >= SHORTEST
    }

    /// Next step, after this step was accepted. Its fraction is predicted from the difference between the new step and the simplified
    /// correction.
    pub fn followed_by(
        self,
        simplified: &SimplifiedCorrection,
        step: DVector<f64>,
        norm: impl Fn(&DVector<f64>) -> f64,
    ) -> Self {
        let size = norm(&step);
        let difference = norm(&(&simplified.step - &step));
        let predicted = self.fraction * self.size * simplified.size / (difference * size);
        // The prediction may be NaN if the difference is zero.
        let fraction = if predicted < 1.0 {
            predicted.max(2.0 * SHORTEST)
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

    /// Root of atan(x) = 0 by Newton's method, and the number of function evaluations.
    fn root_of_atan(from: f64) -> (f64, usize) {
        let norm = |step: &DVector<f64>| step.norm();
        let newton = |x: f64| -x.atan() * (1.0 + x * x);
        let (mut x, mut count) = (from, 0);
        let first = dvector![newton(x)];
        let mut damped = DampedStep::full(first.clone(), norm(&first));
        for _ in 0..30 {
            let simplified = loop {
                let ahead = x + damped.step[0] * damped.fraction;
                let step = dvector![-ahead.atan() * (1.0 + x * x)];
                let size = norm(&step);
                count += 1;
                let simplified = SimplifiedCorrection { step, size };
                if damped.is_accepted(&simplified) {
                    x = ahead;
                    break simplified;
                }
                assert!(damped.shorten(&simplified, norm));
            };
            if simplified.size < 1e-14 {
                break;
            }
            damped = damped.followed_by(&simplified, dvector![newton(x)], norm);
        }
        (x, count)
    }

    #[test]
    fn a_damped_step_finds_the_root_from_where_newtons_method_diverges() {
        // Undamped, the method diverges from starts above 1.392.
        for (from, most) in [(1.0, 6), (3.0, 9), (10.0, 12), (100.0, 16)] {
            let (root, count) = root_of_atan(from);
            assert!(root.abs() < 1e-12, "{from}: {root:e}");
            assert!(count <= most, "{from}: {count}");
        }
    }
}
