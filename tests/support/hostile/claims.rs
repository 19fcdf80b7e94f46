//! What must hold of every pair.

use super::kinks::{EQUAL_FIELDS, Kink, first_kink};
use super::measures::{Evaluation, FASTEST, Measures, Motion, ROOM, SAME, SPECK};
use crate::support::scenes::Random;
use hydroelastic::contact::{
    ContactBody, ContactPair, ContactPolygon, ContactWrench, Culling, LinearizedContact, Search,
};
use hydroelastic::spatial::{Pose, Twist};
use nalgebra::{Vector3, Vector6};

/// Rounding of a sum of pressures times areas.
const BOUND: f64 = 1.0 + 1e-9;

/// Third law, relative to force and torque.
const BALANCE: f64 = 1e-13;

/// How far a body is moved, relative to its size.
const STEP: f64 = 1e-9;

/// How many parts a step is looked at in if the Jacobians of its ends do not explain it: surfaces that lie within
/// the step of each other come to touch and cease to within it.
const PARTS: usize = 16;

/// How far a body is moved for a difference of energies: half of the 16 digits.
const ENERGY_STEP: f64 = 1e-5;

/// A contact surface is no larger than so many discs around the smaller body.
const DISCS: f64 = 16.0;

/// What the claims came to at one pair.
#[derive(Default)]
pub struct Verdict {
    pub touches: bool,
    pub kink: Option<Kink>,
    /// Claims that failed, and how many times what is allowed they came to.
    pub failures: Vec<(&'static str, f64)>,
}

/// Checks all claims at a pair; those by energies only if asked to, for they take long.
pub fn verdict(pair: &ContactPair, with_energy: bool, random: &mut Random) -> Verdict {
    let mut verdict = Verdict::default();
    let measures = Measures::of(pair);
    let contact = pair.linearized();
    let wrench = contact.wrench;
    verdict.touches = wrench.on_a.force != Vector3::zeros();
    verdict.kink = first_kink(pair, &measures);
    verdict.claim("finite", if is_finite(&contact) { 0.0 } else { 2.0 });
    verdict.claim("third law", third_law(pair, &wrench));
    let own = measures.evaluation(pair);
    if verdict.kink != Some(Kink::Blurred) {
        verdict.claim_bounds(pair, &measures, &wrench);
        verdict.claim("searches agree", search_error(pair, &measures));
        let is_kink = verdict.kink.is_some();
        let error = closed_form_error(pair, &measures, &own, is_kink);
        verdict.claim("closed form", error);
    }
    if verdict.kink.is_none() {
        verdict.claim("another frame", frame_error(pair, &measures, &own, random));
        if let Some(b) = pair.b().body() {
            verdict.claim_exchange(&ContactPair::new(b, *pair.a()), &measures, &wrench, &own);
        }
        verdict.claim_continuity(pair, &measures, &own, random);
        if with_energy {
            verdict.claim(
                "minus the slope of energy",
                energy_error(pair, &measures, &own, random),
            );
        }
    }
    verdict
}

impl Verdict {
    /// Notes a claim that holds if the number is at most 1.
    fn claim(&mut self, name: &'static str, ratio: f64) {
        // NaN must fail.
        if ratio.is_nan() || ratio > 1.0 {
            self.failures.push((name, ratio));
        }
    }

    /// Claims that A and B with their names changed have the same wrench. Faces in which the contact surface lies, up to an angle,
    /// are sliced if they are of A, and clip if they are of B: the surface may graze a face in one order and lie in it in
    /// the other.
    fn claim_exchange(
        &mut self,
        swapped: &ContactPair,
        measures: &Measures,
        wrench: &ContactWrench,
        own: &Evaluation,
    ) {
        let ratio = exchange_error(swapped, measures, wrench, own);
        if ratio > 1.0 {
            self.kink = first_kink(swapped, &Measures::of(swapped));
        }
        if self.kink.is_none() {
            self.claim("exchanged", ratio);
        }
    }

    /// Claims that a small step changes the wrench as the Jacobian says, unless it leads to a kink.
    fn claim_continuity(
        &mut self,
        pair: &ContactPair,
        measures: &Measures,
        own: &Evaluation,
        random: &mut Random,
    ) {
        let body = random.below(2);
        let motion = random_motion(body, measures, STEP, random);
        let mut ratio = step_error(pair, measures, own, &motion, 1);
        if ratio > 1.0 {
            let there = moved(pair, &motion);
            self.kink = first_kink(&there, &Measures::of(&there));
            ratio = step_error(pair, measures, own, &motion, PARTS);
        }
        if self.kink.is_none() {
            self.claim("continuous", ratio);
        }
    }

    fn claim_bounds(&mut self, pair: &ContactPair, measures: &Measures, wrench: &ContactWrench) {
        let surface = pair.surface();
        let disc = std::f64::consts::PI * measures.size.powi(2);
        // What flush polygons, on which there is no pressure, come to by round-off.
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

/// Forces opposite, and torques about the same point.
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

/// Following and culling find the same wrench, up to polygons that are there or not by round-off: these are
/// no wider than the lines in which planes meet are off. Each polygon may be off by its own force times the roundings of its
/// corners; where forces cancel, of bodies that are nearly the same, that is more than their sum tells.
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

/// The roundings of a corner that two ways to compute it may differ by.
const ROUNDINGS: f64 = 16.0;

/// Faces that meet at a smaller angle are so near to each other that they are special, or do not meet in the bodies.
const PARALLEL: f64 = 1e-8;

/// The sine of the least angle at which planes of a contact polygon meet: its own, and those of the faces of its tetrahedra.
/// Following computes generic polygons in other coordinates than culling does, and the corner in which two planes meet
/// is placed by both to round-off over this.
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
            .map(|other| other.cross(plane).norm());
        least = sines.filter(|&sine| sine > PARALLEL).fold(least, f64::min);
    }
    least
}

/// The closed form's wrench is a difference of two that grow as the fields become alike; it loses as many
/// digits as the plane's normal has lost already.
fn closed_form_error(pair: &ContactPair, measures: &Measures, own: &Evaluation, kink: bool) -> f64 {
    let error = (measures.scaled(&pair.wrench().on_a) - own.wrench).norm();
    let alike = if kink { EQUAL_FIELDS } else { FASTEST.recip() };
    let rounding = ROOM * f64::EPSILON / alike;
    error / (rounding * (measures.force() + own.wrench.norm()))
}

/// Both bodies moved by the same random motion.
fn frame_error(
    pair: &ContactPair,
    measures: &Measures,
    own: &Evaluation,
    random: &mut Random,
) -> f64 {
    let away = pair.a().pose().translation().norm() + measures.size;
    let motion = Pose::from_rotation_vector(&random.rotation_vector(), random.vector() * away);
    let moved = placed(pair, [motion * *pair.a().pose(), motion * *pair.b().pose()]);
    let there = measures.evaluation(&moved);
    let turned = moved.wrench().on_a.rotated(&motion.rotation().transpose());
    let error = measures.error.max(Measures::of(&moved).error);
    let difference = (measures.scaled(&turned) - own.wrench).norm();
    difference / measures.allowed(error, own, &there)
}

/// A and B have changed their names.
fn exchange_error(
    swapped: &ContactPair,
    measures: &Measures,
    wrench: &ContactWrench,
    own: &Evaluation,
) -> f64 {
    let there = swapped.wrench();
    let difference = (measures.scaled(&there.on_b) - measures.scaled(&wrench.on_a)).norm();
    difference / measures.allowed(measures.error, own, own)
}

/// One body moved a little, in so many equal parts.
fn step_error(
    pair: &ContactPair,
    measures: &Measures,
    own: &Evaluation,
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
    let (mut by_last, mut last) = (by_small(own), None);
    for number in 1..=parts {
        let there = moved(pair, &part(number as f64 / parts as f64));
        let there = measures.evaluation(&there);
        let by_next = by_small(&there);
        // J somewhere between those of both ends: off by no more than half of their difference, each.
        predicted += 0.5 * (by_last + by_next);
        jumps += (by_next - by_last).norm();
        (by_last, last) = (by_next, Some(there));
    }
    let there = last.expect("at least one part");
    let error = (there.wrench - own.wrench - predicted).norm();
    let step = STEP * measures.reach[motion.0];
    let curvature = measures.force() * (FASTEST.sqrt() * step / measures.thinnest).powi(2).min(1.0);
    error / (jumps + curvature + measures.allowed(measures.error, own, &there))
}

/// The force along a direction is the energy's slope.
fn energy_error(
    pair: &ContactPair,
    measures: &Measures,
    own: &Evaluation,
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
    let force = own.wrench.fixed_rows::<3>(3).dot(&direction);
    // The mean force of the way is between those of its ends.
    let spread = (forces[0] - force).abs().max((forces[1] - force).abs());
    let noise =
        measures.noise(measures.error) + measures.force() * (ROOM * measures.error / step).min(1.0);
    let curvature = measures.force() * (FASTEST.sqrt() * step / measures.thinnest).powi(2).min(1.0);
    (slope - force).abs() / (spread + noise + curvature)
}

/// A motion of a body by a part of its size.
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
