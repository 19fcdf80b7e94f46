//! Comparison of the wrench with the wrench in exact arithmetic, and its tolerances.

use super::exact;
use super::hostile::kinks::{Kink, first_kink};
use super::hostile::measures::Measures;
use hydroelastic::contact::ContactPair;
use std::f64::consts::PI;

/// Forces of round-off, relative to pressure times size squared, in surfaces that only touch.
const SPECK: f64 = 1e-12;

/// Largest difference between two wrenches if the model has no unique answer, relative to pressure times size squared. Each wrench is at
/// most the highest pressure over a disc around the smaller body.
const JUMP: f64 = 2.0 * PI;

/// Distance, in margins, within which faces count as coincident if a polygon nearly lies in a face. The error of the wrench is then the
/// effect of moving coordinates by this distance.
const COINCIDENT: f64 = 64.0;

/// Relation of a pair's wrench to the exact wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// The wrenches are equal up to the rounding of coordinates.
    Determined,
    /// Fields are equal or nearly equal over a volume, so the wrench may have any value between two limits.
    EqualFields,
    /// Tetrahedra are so thin that the intersections of planes depend on round-off.
    Blurred,
}

/// A wrench compared with the exact wrench.
pub struct Comparison {
    pub standing: Standing,
    /// Number of contact polygons in exact arithmetic.
    pub polygons: usize,
    /// Difference divided by the bound of round-off. It is at most 1 if the wrench is determined. The largest ratio over 11,000 pairs is
    /// 0.76 (`cargo test --test contact exact_twin:: -- --ignored --nocapture`).
    pub ratio: f64,
    /// Difference divided by the largest jump of the wrench. It is always at most 1.
    pub jump: f64,
}

/// Compares the wrench on A of a pair with the exact wrench.
pub fn compared(pair: &ContactPair) -> Comparison {
    let measures = Measures::of(pair);
    let evaluation = measures.evaluation(pair);
    let contact = exact::contact(pair);
    let error = (evaluation.wrench - measures.scaled_vector(&contact.wrench)).norm();
    // A coordinate error changes the wrench according to the Jacobian, and moves the lines in which planes meet.
    let explained = measures.explained(&evaluation, measures.error);
    let blur = measures.force() * (SPECK + measures.blur(measures.error));
    let mut ratio = error / (explained + blur);
    if ratio > 1.0 && has_nearly_coincident_faces(pair, measures.error) {
        ratio = error / (COINCIDENT * explained + blur);
    }
    Comparison {
        standing: match first_kink(pair, &measures) {
            Some(Kink::EqualFields | Kink::Unresolved) => Standing::EqualFields,
            Some(Kink::Blurred) => Standing::Blurred,
            // Sheets of the surface close to each other or to a face have no effect here.
            Some(Kink::Ridges | Kink::Grazing) | None => Standing::Determined,
        },
        polygons: contact.polygons,
        ratio,
        jump: error / (JUMP * measures.force()),
    }
}

/// Returns whether a face of A's tetrahedra lies in the plane of a face of B's, with a distance larger than round-off and at most the
/// coincidence margin.
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
