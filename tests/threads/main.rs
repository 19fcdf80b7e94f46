//! Results have the same bits with any number of threads, in every run and on every processor.

mod every_processor;
mod reproducible;
mod same_bits;
#[path = "../support/starts.rs"]
mod starts;
