//! Several numbers to an instruction: code that is written once and runs at as many lanes as the processor has.
//!
//! Two by what every processor has or by NEON, four by AVX2; eight by AVX-512, with the feature `avx512`. Tests run all three
//! widths on any processor.
//!
//! Lanes know sums, differences, products, quotients, square roots and comparisons, each rounded as IEEE 754 says, and nothing
//! is contracted to fused operations. So a lane has the same bits at every width and on every processor. Where the order of
//! a sum matters, each of the [`ROW`] places of a [`Row`] has a sum of its own, whatever the width.

mod pair;
pub(crate) mod space;
mod traits;
mod vector;

use pair::Pairs;
use std::sync::LazyLock;
use vector::Vectors;

pub(crate) use traits::{InLanes, Lanes, Linear, Mask, Numbers, Quad, ROW, Row};

/// Which instructions this processor has.
static PROCESSOR: LazyLock<pulp::Arch> = LazyLock::new(pulp::Arch::new);

/// Runs with as many lanes as the processor has.
#[inline]
pub(crate) fn run<J: InLanes>(job: J) -> J::Output {
    #[cfg(test)]
    if let Some(width) = tests::forced_width() {
        return run_at(width, job);
    }
    PROCESSOR.dispatch(Job(job))
}

struct Job<J>(J);

impl<J: InLanes> pulp::WithSimd for Job<J> {
    type Output = J::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> J::Output {
        // pulp found no vector instructions; but on x86-64 there always are those of two lanes.
        if S::IS_SCALAR {
            self.0.run(Pairs)
        } else {
            self.0.run(Vectors(simd))
        }
    }
}

#[cfg(test)]
fn run_at<J: InLanes>(width: usize, job: J) -> J::Output {
    match width {
        2 => job.run(Pairs),
        4 => job.run(Vectors(pulp::Scalar256b)),
        _ => job.run(Vectors(pulp::Scalar512b)),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::cell::Cell;

    thread_local! {
        static WIDTH: Cell<Option<usize>> = const { Cell::new(None) };
    }

    pub fn forced_width() -> Option<usize> {
        WIDTH.get()
    }

    /// Runs something at so many lanes: what it does in this thread, not what it leaves to others.
    pub fn at_width<O>(width: usize, work: impl FnOnce() -> O) -> O {
        WIDTH.set(Some(width));
        let output = work();
        WIDTH.set(None);
        output
    }
}
