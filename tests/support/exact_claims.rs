//! How far the wrench may be from that of the exact twin.

use super::exact;
use super::hostile::kinks::{Kink, first_kink};
use super::hostile::measures::Measures;
use hydroelastic::contact::ContactPair;
use std::f64::consts::PI;

/// Forces of round-off, relative to pressure times size squared: surfaces that only touch leave so much.
const SPECK: f64 = 1e-12;

/// How far apart two wrenches may be where the model has no single answer, relative to pressure times size
/// squared: each is at most the highest pressure over a disc around the smaller body.
const JUMP: f64 = 2.0 * PI;

/// What the wrench of a pair has to do with the exact one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// It is that wrench, as far as coordinates are rounded.
    Determined,
    /// Fields are equal over a volume, or nearly: the wrench is anything between two.
    EqualFields,
    /// Tetrahedra are so thin that round-off decides where planes meet.
    Blurred,
}

/// A wrench compared with the exact one.
pub struct Comparison {
    pub standing: Standing,
    /// Contact polygons of the twin.
    pub polygons: usize,
    /// The difference, as so many times what round-off explains. At most 1 where the wrench is determined;
    /// the largest of 11,000 pairs is 0.42 (`cargo test --test exact_twin -- --ignored --nocapture`).
    pub ratio: f64,
    /// The difference, as so many times what the wrench may jump by. At most 1 everywhere.
    pub jump: f64,
}

/// Compares the wrench on A of a pair with that of the twin.
pub fn compared(pair: &ContactPair) -> Comparison {
    let measures = Measures::of(pair);
    let own = measures.evaluation(pair);
    let contact = exact::contact(pair);
    let error = (own.wrench - measures.scaled_vector(&contact.wrench)).norm();
    // A coordinate that is off moves the wrench as the Jacobian says, and the lines in which planes meet.
    let explained = measures.explained(&own, measures.error);
    let blur = measures.force() * (SPECK + measures.blur(measures.error));
    Comparison {
        standing: match first_kink(pair, &measures) {
            Some(Kink::EqualFields | Kink::Unresolved) => Standing::EqualFields,
            Some(Kink::Blurred) => Standing::Blurred,
            // Sheets of the surface that lie near to each other, or to a face, are no matter here.
            Some(Kink::Ridges | Kink::Grazing) | None => Standing::Determined,
        },
        polygons: contact.polygons,
        ratio: error / (explained + blur),
        jump: error / (JUMP * measures.force()),
    }
}
