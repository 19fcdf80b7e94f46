//! Portable SIMD: kernels are written once and run at the vector width of the CPU.
//!
//! Every kernel runs at one of three widths:
//!
//! - two lanes on every x86-64 CPU, or with NEON;
//! - four lanes with AVX2;
//! - eight lanes with AVX-512, if the feature `avx512` is enabled.
//!
//! Tests run all three widths on any CPU.
//!
//! Lanes support sums, differences, products, quotients, square roots and comparisons. Each
//! operation is rounded as IEEE 754 prescribes, and no operations are contracted to fused ones. So
//! a lane has the same bits at every width and on every CPU. If the order of a sum matters, each of
//! the [`ROW`] entries of a [`Row`] has its own accumulator, whatever the width.

mod pair;
pub(crate) mod space;
mod traits;
mod vector;

use pair::Pairs;
use std::sync::LazyLock;
use vector::Vectors;

pub(crate) use traits::{InLanes, Lanes, Linear, Mask, Numbers, Quad, ROW, Row};

/// Instruction sets of this CPU, detected at run time.
static PROCESSOR: LazyLock<pulp::Arch> = LazyLock::new(pulp::Arch::new);

/// Runs a kernel at the vector width of the CPU.
#[inline]
pub(crate) fn run<J: InLanes>(job: J) -> J::Output {
    #[cfg(test)]
    if let Some(width) = tests::forced_width() {
        return run_at(width, job);
    }
    PROCESSOR.dispatch(Job(job))
}

/// Sums the eight entries of each row in a fixed order.
pub(crate) fn totals<const N: usize>(rows: &[Row; N]) -> [f64; N] {
    let mut totals = [0.0; N];
    for (total, [a, b, c, d, e, f, g, h]) in totals.iter_mut().zip(rows) {
        *total = ((a + b) + (c + d)) + ((e + f) + (g + h));
    }
    totals
}

struct Job<J>(J);

impl<J: InLanes> pulp::WithSimd for Job<J> {
    type Output = J::Output;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) -> J::Output {
        // pulp found no vector instructions. `Pairs` needs only the two-lane instructions that
        // every x86-64 CPU has.
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

    /// Runs `work` at the given number of lanes. Affects the current thread only.
    pub fn at_width<O>(width: usize, work: impl FnOnce() -> O) -> O {
        WIDTH.set(Some(width));
        let output = work();
        WIDTH.set(None);
        output
    }
}
