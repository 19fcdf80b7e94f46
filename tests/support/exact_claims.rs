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

/// Where a polygon nearly lies in a face, faces within so many margins of each other count as coincident: the wrench is
/// that of coordinates which are off by this.
const COINCIDENT: f64 = 64.0;

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
    /// the largest of 11,000 pairs is 0.76 (`cargo test --test contact exact_twin:: -- --ignored --nocapture`).
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
    let mut ratio = error / (explained + blur);
    if ratio > 1.0 && has_nearly_coincident_faces(pair, measures.error) {
        ratio = error / (COINCIDENT * explained + blur);
    }
    Comparison {
        standing: match first_kink(pair, &measures) {
            Some(Kink::EqualFields | Kink::Unresolved) => Standing::EqualFields,
            Some(Kink::Blurred) => Standing::Blurred,
            // Sheets of the surface that lie near to each other, or to a face, are no matter here.
            Some(Kink::Ridges | Kink::Grazing) | None => Standing::Determined,
        },
        polygons: contact.polygons,
        ratio,
        jump: error / (JUMP * measures.force()),
    }
}

/// Whether a face of A's tetrahedra lies in the plane of one of B's, missed by more than rounding and no more than what
/// counts as coincident.
fn has_nearly_coincident_faces(pair: &ContactPair, error: f64) -> bool {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let [tets_a, tets_b] =
        [pair.a(), &pair.b().body().unwrap()].map(|body| body.shape().field().tets());
    tets_b.iter().any(|b| {
        let planes = b.barycentric.each_ref().map(|face| face.posed(&pose_ab));
        let mut planes = planes.iter().zip(&b.barycentric_steepness);
        planes.any(|(plane, steepness)| {
            tets_a.iter().any(|a| {
                let away = a
                    .tetrahedron
                    .corners
                    .map(|corner| plane.at(&corner).abs() / steepness);
                (0..4).any(|apex| {
                    let face = (0..4).filter(|&corner| corner != apex);
                    let farthest = face.map(|corner| away[corner]).fold(0.0, f64::max);
                    farthest > error && farthest <= COINCIDENT * error
                })
            })
        })
    })
}
