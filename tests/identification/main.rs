//! Identification of worlds from simulated recordings.

mod errors;
mod evaluator;
mod intervals;
mod recovery;
mod residuals;
mod robustness;
mod tosses;
