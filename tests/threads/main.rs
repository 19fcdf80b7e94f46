//! The same bits, whatever the number of threads and in every run.

mod reproducible;
mod same_bits;
