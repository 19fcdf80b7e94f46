//! Claims that hold for every pair.

use super::kinks::{EQUAL_FIELDS, Kink, first_kink};
use super::measures::{Evaluation, FASTEST, Measures, Motion, ROOM, SAME, SPECK};
use crate::support::scenes::Random;
use hydroelastic::contact::{
    ContactBody, ContactPair, ContactPolygon, ContactWrench, Culling, LinearizedContact, Search,
};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, Vector6};

/// Bound of a force relative to pressures times areas, with the rounding error of their sum.
const BOUND: f64 = 1.0 + 1e-9;

/// Tolerance of Newton's third law, relative to force and torque.
const BALANCE: f64 = 1e-13;

/// Displacement of a body, relative to its size.
const STEP: f64 = 1e-9;

/// Number of parts into which a step is divided if the Jacobians at its ends do not explain the change. Surfaces closer to each other than
/// the step may start and stop touching within the step.
const PARTS: usize = 16;

/// Displacement of a body for a difference of energies: half of the 16 digits.
const ENERGY_STEP: f64 = 1e-5;

/// Largest area of a contact surface, in discs around the smaller body.
const DISCS: f64 = 16.0;

/// Results of the claims for one pair.
#[derive(Default)]
pub struct Verdict {
    pub touches: bool,
    pub kink: Option<Kink>,
    /// Failed claims, each with its error divided by its tolerance.
    pub failures: Vec<(&'static str, f64)>,
}

/// Checks all claims for a pair. Claims about energies take long and are checked only if requested.
pub fn verdict(pair: &ContactPair, with_energy: bool, random: &mut Random) -> Verdict {
    let mut verdict = Verdict::default();
    let measures = Measures::of(pair);
    let contact = pair.linearized();
    let wrench = contact.wrench;
    verdict.touches = wrench.on_a.force != Vector3::zeros();
    verdict.kink = first_kink(pair, &measures);
    verdict.claim("finite", if is_finite(&contact) { 0.0 } else { 2.0 });
    verdict.claim("third law", third_law(pair, &wrench));
    let evaluation = measures.evaluation(pair);
    if verdict.kink != Some(Kink::Blurred) {
        verdict.claim_bounds(pair, &measures, &wrench);
        verdict.claim("searches agree", search_error(pair, &measures));
        let is_kink = verdict.kink.is_some();
        let error = closed_form_error(pair, &measures, &evaluation, is_kink);
        verdict.claim("closed form", error);
    }
    if verdict.kink.is_none() {
        verdict.claim(
            "another frame",
            frame_error(pair, &measures, &evaluation, random),
        );
        if let Some(b) = pair.b().body() {
            verdict.claim_exchange(
                &ContactPair::new(b, *pair.a()),
                &measures,
                &wrench,
                &evaluation,
            );
        }
        verdict.claim_continuity(pair, &measures, &evaluation, random);
        if with_energy {
            verdict.claim(
                "minus the slope of energy",
                energy_error(pair, &measures, &evaluation, random),
            );
        }
    }
    verdict
}

impl Verdict {
    /// Records a claim that holds if the ratio is at most 1.
    fn claim(&mut self, name: &'static str, ratio: f64) {
        // NaN must fail.
        if ratio.is_nan() || ratio > 1.0 {
            self.failures.push((name, ratio));
        }
    }

    /// Claims that the pair with exchanged names A and B has the same wrench. If the contact surface lies in a face up to an angle, a face
    /// of A is sliced, and a face of B clips. The surface may therefore graze a face in one order and lie in it in the other.
    fn claim_exchange(
        &mut self,
        swapped: &ContactPair,
        measures: &Measures,
        wrench: &ContactWrench,
        evaluation: &Evaluation,
    ) {
        let ratio = exchange_error(swapped, measures, wrench, evaluation);
        if ratio > 1.0 {
            self.kink = first_kink(swapped, &Measures::of(swapped));
        }
        if self.kink.is_none() {
            self.claim("exchanged", ratio);
        }
    }

    /// Claims that a small step changes the wrench according to the Jacobian, unless the step leads to a kink.
    fn claim_continuity(
        &mut self,
        pair: &ContactPair,
        measures: &Measures,
        evaluation: &Evaluation,
        random: &mut Random,
    ) {
        let body = random.below(2);
        let motion = random_motion(body, measures, STEP, random);
        let mut ratio = step_error(pair, measures, evaluation, &motion, 1);
        if ratio > 1.0 {
            let there = moved(pair, &motion);
            self.kink = first_kink(&there, &Measures::of(&there));
            ratio = step_error(pair, measures, evaluation, &motion, PARTS);
        }
        if self.kink.is_none() {
            self.claim("continuous", ratio);
        }
    }

    fn claim_bounds(&mut self, pair: &ContactPair, measures: &Measures, wrench: &ContactWrench) {
        let surface = pair.surface();
        let disc = std::f64::consts::PI * measures.size.powi(2);
        // Contribution of flush polygons without pressure, which is due to round-off.
        let noise = measures.noise(measures.error);
        let most = measures.pressure * surface.area() * BOUND + noise;
        self.claim(
            "at most pressure times area",
            wrench.on_a.force.norm() / most,
        );
        let largest = surface.polygons.iter().map(|p| p.area).fold(0.0, f64::max);
        self.claim("polygons in a disc", largest / disc / BOUND);
        self.claim("area", surface.area() / (DISCS * disc));
    }
}

fn is_finite(contact: &LinearizedContact) -> bool {
    let ContactWrench { on_a, on_b } = contact.wrench;
    let wrenches = [on_a, on_b].map(|wrench| wrench.to_vector());
    let jacobian = contact.jacobian();
    let mut numbers = wrenches.iter().flatten().chain(&jacobian);
    numbers.all(|number| number.is_finite())
}

/// Checks that forces are opposite, and torques about the same point too.
fn third_law(pair: &ContactPair, wrench: &ContactWrench) -> f64 {
    let lever = pair.b().pose().translation() - pair.a().pose().translation();
    let (on_a, on_b) = (wrench.on_a, wrench.on_b);
    let force = (on_a.force + on_b.force).norm();
    let torque = (on_a.torque + on_b.torque + lever.cross(&on_b.force)).norm();
    let size = on_a.torque.norm() + lever.norm() * on_a.force.norm();
    let ratio = |error: f64, size: f64| {
        if error == 0.0 {
            0.0
        } else {
            error / (BALANCE * size)
        }
    };
    ratio(force, on_a.force.norm()).max(ratio(torque, size))
}

/// Returns the difference between the wrenches by tracing and by culling. Polygons may exist in one search only because of round-off; these
/// are at most as wide as the error of the lines in which planes meet. The error of each polygon may be its own force times the rounding
/// errors of its corners. If the forces of nearly equal bodies cancel, this exceeds the error estimated from their sum.
fn search_error(pair: &ContactPair, measures: &Measures) -> f64 {
    let everywhere = pair.with_search(Search::Culling(Culling::default()));
    let [followed, culled] = [pair, &everywhere].map(|pair| measures.scaled(&pair.wrench().on_a));
    let speck = measures.force() * (SPECK + measures.blur(measures.error));
    let polygons = &everywhere.surface().polygons;
    let rounding = |polygon: &ContactPolygon| {
        SAME.max(ROUNDINGS * f64::EPSILON / least_angle(pair, polygon)) * polygon.force().norm()
    };
    (followed - culled).norm() / (polygons.iter().map(rounding).sum::<f64>() + speck)
}

/// Number of rounding errors by which two methods to compute a corner may differ.
const ROUNDINGS: f64 = 16.0;

/// Sine of the angle below which faces are so close to each other that they are special or do not meet in the bodies.
const PARALLEL: f64 = 1e-8;

/// Returns the sine of the smallest angle between the planes of a contact polygon: its own plane and those of the faces of its tetrahedra.
/// Tracing computes generic polygons in other coordinates than culling. Both compute the corner in which two planes meet to round-off
/// divided by this sine.
fn least_angle(pair: &ContactPair, polygon: &ContactPolygon) -> f64 {
    let Some(b) = pair.b().body() else {
        return 1.0;
    };
    let normals = |body: &ContactBody, tet: usize| {
        let faces = &body.shape().field().tets()[tet].barycentric;
        let rotation = *body.pose().rotation();
        faces
            .each_ref()
            .map(|face| rotation * face.gradient.normalize())
    };
    let [a, b] = [
        normals(pair.a(), polygon.tets[0]),
        normals(&b, polygon.tets[1]),
    ];
    let planes: Vec<_> = a.into_iter().chain(b).chain([polygon.normal]).collect();
    let mut least = 1.0_f64;
    for (count, plane) in planes.iter().enumerate() {
        let sines = planes[..count]
            .iter()
            .map(|other_normal| other_normal.cross(plane).norm());
        least = sines.filter(|&sine| sine > PARALLEL).fold(least, f64::min);
    }
    least
}

/// Returns the error of the closed form's wrench. The wrench is a difference of two terms that grow as the fields become equal. It loses as
/// many digits as the plane's normal has already lost.
fn closed_form_error(
    pair: &ContactPair,
    measures: &Measures,
    evaluation: &Evaluation,
    kink: bool,
) -> f64 {
    let error = (measures.scaled(&pair.wrench().on_a) - evaluation.wrench).norm();
    let alike = if kink { EQUAL_FIELDS } else { FASTEST.recip() };
    let rounding = ROOM * f64::EPSILON / alike;
    error / (rounding * (measures.force() + evaluation.wrench.norm()))
}

/// Returns the error if both bodies move by the same random motion.
fn frame_error(
    pair: &ContactPair,
    measures: &Measures,
    evaluation: &Evaluation,
    random: &mut Random,
) -> f64 {
    let away = pair.a().pose().translation().norm() + measures.size;
    let motion = Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * away);
    let moved = placed(pair, [motion * *pair.a().pose(), motion * *pair.b().pose()]);
    let there = measures.evaluation(&moved);
    let turned = moved.wrench().on_a.rotated(&motion.rotation().transpose());
    let error = measures.error.max(Measures::of(&moved).error);
    let difference = (measures.scaled(&turned) - evaluation.wrench).norm();
    difference / measures.allowed(error, evaluation, &there)
}

/// Returns the error if A and B exchange their names.
fn exchange_error(
    swapped: &ContactPair,
    measures: &Measures,
    wrench: &ContactWrench,
    evaluation: &Evaluation,
) -> f64 {
    let there = swapped.wrench();
    let difference = (measures.scaled(&there.on_b) - measures.scaled(&wrench.on_a)).norm();
    difference / measures.allowed(measures.error, evaluation, evaluation)
}

/// Returns the error if one body moves slightly, in a number of equal parts.
fn step_error(
    pair: &ContactPair,
    measures: &Measures,
    evaluation: &Evaluation,
    motion: &Motion,
    parts: usize,
) -> f64 {
    let part = |fraction: f64| {
        let Twist { angular, linear } = motion.1;
        let (angular, linear) = (angular * fraction, linear * fraction);
        (motion.0, Twist { angular, linear })
    };
    let small = part((parts as f64).recip());
    let by_small = |end: &Evaluation| measures.predicted(end, &small);
    let (mut predicted, mut jumps) = (Vector6::zeros(), 0.0);
    let (mut by_last, mut last) = (by_small(evaluation), None);
    for number in 1..=parts {
        let there = moved(pair, &part(number as f64 / parts as f64));
        let there = measures.evaluation(&there);
        let by_next = by_small(&there);
        // The Jacobian of a part is between those of both ends, so the error is at most half of their difference per part.
        predicted += 0.5 * (by_last + by_next);
        jumps += (by_next - by_last).norm();
        (by_last, last) = (by_next, Some(there));
    }
    let there = last.expect("at least one part");
    let error = (there.wrench - evaluation.wrench - predicted).norm();
    let step = STEP * measures.reach[motion.0];
    let curvature = measures.force() * (FASTEST.sqrt() * step / measures.thinnest).powi(2).min(1.0);
    error / (jumps + curvature + measures.allowed(measures.error, evaluation, &there))
}

/// Returns the difference between the force along a direction and the derivative of the energy.
fn energy_error(
    pair: &ContactPair,
    measures: &Measures,
    evaluation: &Evaluation,
    random: &mut Random,
) -> f64 {
    let direction = random.direction();
    let step = ENERGY_STEP * measures.size;
    let ends = [step, -step].map(|step| {
        let twist = Twist {
            angular: Vector3::zeros(),
            linear: direction * step,
        };
        moved(pair, &(0, twist))
    });
    let energies = [&ends[0], &ends[1]].map(ContactPair::potential_energy);
    let slope = (energies[1] - energies[0]) / (2.0 * step);
    let forces = ends.map(|end| {
        measures
            .evaluation(&end)
            .wrench
            .fixed_rows::<3>(3)
            .dot(&direction)
    });
    let force = evaluation.wrench.fixed_rows::<3>(3).dot(&direction);
    // The mean force over the displacement is between those at its ends.
    let spread = (forces[0] - force).abs().max((forces[1] - force).abs());
    let noise =
        measures.noise(measures.error) + measures.force() * (ROOM * measures.error / step).min(1.0);
    let curvature = measures.force() * (FASTEST.sqrt() * step / measures.thinnest).powi(2).min(1.0);
    (slope - force).abs() / (spread + noise + curvature)
}

/// Returns a motion of a body by a fraction of its size.
fn random_motion(body: usize, measures: &Measures, part: f64, random: &mut Random) -> Motion {
    let linear = random.direction() * (part * measures.reach[body]);
    let angular = random.vector() * part;
    (body, Twist { angular, linear })
}

fn moved<'a>(pair: &ContactPair<'a>, (body, twist): &Motion) -> ContactPair<'a> {
    let mut poses = [*pair.a().pose(), *pair.b().pose()];
    poses[*body] = poses[*body].moved_by(twist);
    placed(pair, poses)
}

fn placed<'a>(pair: &ContactPair<'a>, [pose_a, pose_b]: [Pose; 2]) -> ContactPair<'a> {
    let (a, b) = (pair.a(), pair.b());
    let modulus_b = b.modulus().unwrap_or(1.0);
    ContactPair::new(
        ContactBody::new(a.shape(), pose_a, a.modulus()).unwrap(),
        b.at(pose_b, modulus_b).unwrap(),
    )
}
