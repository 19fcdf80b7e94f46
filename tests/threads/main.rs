//! The same bits, whatever the number of threads, in every run and on every processor.

mod every_processor;
mod reproducible;
mod same_bits;
#[path = "../support/starts.rs"]
mod starts;
