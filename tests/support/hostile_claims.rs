//! What must hold of every pair, and how far round-off may take it.

use super::scenes::Random;
use hydroelastic::contact::{
    ContactBody, ContactJacobian, ContactPair, ContactPolygon, ContactWrench, Culling, Search,
    WrenchJacobian,
};
use hydroelastic::geometry::Aabb;
use hydroelastic::mesh::FieldTet;
use hydroelastic::spatial::{Pose, Twist, Wrench};
use nalgebra::{Vector3, Vector6};

/// The kernel's own margin: what counts as zero, relative to the bodies' reach.
const MARGIN: f64 = 3e-14;

/// Roundings of a coordinate far from the world's origin, in units in the last place: a few products and
/// sums of poses.
const WORLD_ROUNDINGS: f64 = 16.0;

/// Rounding of a sum of pressures times areas.
const BOUND: f64 = 1.0 + 1e-9;

/// Third law, relative to force and torque.
const BALANCE: f64 = 1e-13;

/// Forces of round-off, relative to pressure times size squared: surfaces that only touch leave so much.
const SPECK: f64 = 1e-12;

/// Sums in another order round differently.
const SAME: f64 = 1e-12;

/// How many times the error that one coordinate explains all of them together may come to.
const ROOM: f64 = 100.0;

/// How far a body is moved, relative to its size.
const STEP: f64 = 1e-9;

/// How far a body is moved for a difference of energies: half of the 16 digits.
const ENERGY_STEP: f64 = 1e-5;

/// A plane of equal pressure moves this much faster than the body: the fields are nearly equal.
const FASTEST: f64 = 1e3;

/// Gradients that differ by less, relative to the sensitivity of either field, count as equal.
const EQUAL_FIELDS: f64 = 1e-9;

/// Ridges are the same that differ by no more, relative to reach and pressure.
const RIDGE: f64 = 1e-8;

/// A polygon and a face graze if they are so nearly parallel,
const GRAZING_TILT: f64 = 1e-6;

/// and a corner is so near to the face, relative to the reach.
const GRAZING_DISTANCE: f64 = 1e-9;

/// A contact surface is no larger than so many discs around the smaller body.
const DISCS: f64 = 16.0;

/// Where the model has a kink, so that forces jump or change faster than a step resolves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kink {
    /// The fields of two tetrahedra that overlap are nearly equal.
    EqualFields,
    /// They are not, but their difference is below what the kernel resolves: one is a plateau, or nearly.
    Unresolved,
    /// The highest pressures of both bodies are the same at the same place: as one ridge passes the other, the
    /// contact surface between them turns over, and its force jumps to the opposite.
    Ridges,
    /// Tetrahedra are so thin, or the bodies so unlike in size, that the lines where planes meet are placed
    /// worse than one part in [`ROOM`] of the smaller body.
    Blurred,
    /// The contact surface nearly, but not quite, lies in a face, tilted by so little that the line where they meet is placed
    /// by round-off.
    Grazing,
}

/// What the claims came to at one pair.
#[derive(Default)]
pub struct Verdict {
    pub touches: bool,
    pub kink: Option<Kink>,
    /// Claims that failed, and how many times what is allowed they came to.
    pub failures: Vec<(&'static str, f64)>,
}

/// The measures of a pair that errors are relative to.
pub(super) struct Measures {
    /// Reach of the smaller body (m).
    size: f64,
    /// Reach of both bodies (m).
    reach: [f64; 2],
    /// Error of a coordinate (m).
    pub(super) error: f64,
    /// Smallest height of a tetrahedron (m).
    thinnest: f64,
    /// The pressure that both bodies reach (Pa).
    pressure: f64,
}

/// A wrench on A about A's origin with its torque divided by A's reach, and its derivatives by the motion
/// of one body.
pub(super) struct Evaluation {
    pub(super) wrench: Vector6<f64>,
    jacobian: ContactJacobian,
}

/// A body that moves: 0 for A, 1 for B, and how.
type Motion = (usize, Twist);

/// Checks all claims at a pair; those by energies only if asked to, for they take long.
pub fn verdict(pair: &ContactPair, with_energy: bool, random: &mut Random) -> Verdict {
    let mut verdict = Verdict::default();
    let measures = Measures::of(pair);
    let (wrench, jacobian) = pair.wrench_and_jacobian();
    verdict.touches = wrench.on_a.force != Vector3::zeros();
    verdict.kink = first_kink(pair, &measures);
    verdict.claim(
        "finite",
        if is_finite(&wrench, &jacobian) {
            0.0
        } else {
            2.0
        },
    );
    verdict.claim("third law", third_law(pair, &wrench));
    let own = measures.evaluation(pair);
    if verdict.kink != Some(Kink::Blurred) {
        verdict.claim_bounds(pair, &measures, &wrench);
        verdict.claim("searches agree", search_error(pair, &measures));
    }
    if verdict.kink != Some(Kink::Blurred) {
        let is_kink = verdict.kink.is_some();
        let error = closed_form_error(pair, &measures, &own, is_kink);
        verdict.claim("closed form", error);
    }
    if verdict.kink.is_none() {
        verdict.claim("another frame", frame_error(pair, &measures, &own, random));
        verdict.claim("exchanged", exchange_error(pair, &measures, &wrench, &own));
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
        let there = moved(pair, &motion);
        let ratio = step_error(&there, measures, own, &motion);
        if ratio > 1.0 {
            self.kink = first_kink(&there, &Measures::of(&there));
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

impl Measures {
    pub(super) fn of(pair: &ContactPair) -> Self {
        let bodies = [pair.a(), pair.b()];
        let reach = bodies.map(|body| body.shape().field().reach());
        let away = bodies.map(|body| body.pose().translation().norm());
        let steepest = |body: &ContactBody| {
            let tets = body.shape().field().tets().iter();
            tets.flat_map(|tet| tet.barycentric_steepness)
                .fold(0.0, f64::max)
        };
        let largest = |body: &ContactBody| {
            let extents = body.shape().field().extents().iter().copied();
            body.modulus() * extents.fold(0.0, f64::max)
        };
        let [steepest, largest] = [bodies.map(steepest), bodies.map(largest)];
        Self {
            size: reach[0].min(reach[1]),
            reach,
            error: MARGIN * (reach[0] + reach[1])
                + WORLD_ROUNDINGS * f64::EPSILON * away[0].max(away[1]),
            thinnest: steepest[0].max(steepest[1]).recip(),
            pressure: largest[0].min(largest[1]),
        }
    }

    /// Pressure times size squared (N): what forces are measured by.
    pub(super) fn force(&self) -> f64 {
        self.pressure * self.size.powi(2)
    }

    /// What an error of a coordinate may come to (N), where the wrench itself does not tell: in the
    /// thinnest tetrahedra the pressure changes most and clips cut worst.
    fn noise(&self, error: f64) -> f64 {
        self.force() * (SPECK + (ROOM * FASTEST.sqrt() * self.blur(error)).min(1.0))
    }

    /// How far lines in which planes meet may be off, relative to the smaller body.
    pub(super) fn blur(&self, error: f64) -> f64 {
        error * self.reach[0].max(self.reach[1]) / (self.thinnest * self.size)
    }

    pub(super) fn evaluation(&self, pair: &ContactPair) -> Evaluation {
        let (wrench, jacobian) = pair.wrench_and_jacobian();
        Evaluation {
            wrench: self.scaled(&wrench.on_a),
            jacobian,
        }
    }

    /// Torque over reach, force (N).
    fn scaled(&self, wrench: &Wrench) -> Vector6<f64> {
        self.scaled_vector(&wrench.to_vector())
    }

    pub(super) fn scaled_vector(&self, vector: &Vector6<f64>) -> Vector6<f64> {
        let mut scaled = *vector;
        scaled
            .fixed_rows_mut::<3>(0)
            .scale_mut(self.reach[0].recip());
        scaled
    }

    /// How far the wrench changes (N) as B's coordinates change by an error (m), by the Jacobian.
    pub(super) fn explained(&self, evaluation: &Evaluation, error: f64) -> f64 {
        let by_pose = &evaluation.jacobian.on_a.by_pose_b;
        let arm = self.reach[1];
        let columns = (0..6).map(|k| {
            let column: Vector6<f64> = by_pose.column(k).into_owned();
            self.scaled_vector(&column).norm() * if k < 3 { arm.recip() } else { 1.0 }
        });
        error * columns.sum::<f64>()
    }
}

fn is_finite(wrench: &ContactWrench, jacobian: &ContactJacobian) -> bool {
    let wrenches = [wrench.on_a, wrench.on_b].map(|wrench| wrench.to_vector());
    let jacobians = [&jacobian.on_a, &jacobian.on_b].map(WrenchJacobian::matrix);
    wrenches
        .iter()
        .all(|wrench| wrench.iter().all(|x| x.is_finite()))
        && jacobians
            .iter()
            .all(|matrix| matrix.iter().all(|x| x.is_finite()))
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

/// The kink a pair is at, if it is at one.
pub fn kink_of(pair: &ContactPair) -> Option<Kink> {
    first_kink(pair, &Measures::of(pair))
}

/// The first of its kinks.
pub(super) fn first_kink(pair: &ContactPair, measures: &Measures) -> Option<Kink> {
    [
        blurred(measures),
        kink(pair, measures),
        ridges(pair),
        grazing(pair),
    ]
    .into_iter()
    .flatten()
    .next()
}

/// Whether the pair is at a kink of the model. Two tetrahedra whose boxes overlap have gradients so much
/// alike that their plane moves [`FASTEST`] times as far as the bodies, or that the kernel takes them for
/// equal.
fn kink(pair: &ContactPair, measures: &Measures) -> Option<Kink> {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let bodies = [pair.a(), pair.b()];
    let [a, b] = bodies.map(|body| (body.shape().field().tets(), body.modulus()));
    let mut worst = None;
    for tet_b in b.0 {
        let gradient_b = pose_ab.rotation() * tet_b.extent.gradient * b.1;
        let box_b = posed_box(tet_b, &pose_ab).inflated(measures.error);
        for tet_a in a.0 {
            let gradient_a = tet_a.extent.gradient * a.1;
            let difference = (gradient_a - gradient_b).norm();
            let alike = difference * FASTEST <= gradient_a.norm().min(gradient_b.norm());
            let sensitivity = (tet_a.sensitivity * a.1).max(tet_b.sensitivity * b.1);
            // Twice: a pair at the limit may be on either side of it.
            let kink = if alike {
                Kink::EqualFields
            } else if difference <= 2.0 * EQUAL_FIELDS * sensitivity {
                Kink::Unresolved
            } else {
                continue;
            };
            if worst != Some(Kink::Unresolved) && tet_a.tetrahedron.aabb().overlaps(&box_b) {
                worst = Some(kink);
            }
        }
    }
    worst
}

/// Planes that meet at the flattest angle there is, the least height over the reach, meet in a line that is
/// off by the error of a coordinate over that angle.
fn blurred(measures: &Measures) -> Option<Kink> {
    let blur = measures.blur(measures.error);
    (ROOM * blur > 1.0).then_some(Kink::Blurred)
}

/// Whether the boxes around the highest vertices of both bodies meet, and the pressures there are the same.
fn ridges(pair: &ContactPair) -> Option<Kink> {
    let pose_ab = pair.a().pose().inverse() * *pair.b().pose();
    let ridge = |body: &ContactBody, pose: &Pose| {
        let field = body.shape().field();
        let highest = field.extents().iter().copied().fold(0.0, f64::max);
        let vertices = field.mesh().vertices().iter().zip(field.extents());
        let on_top: Vec<_> = vertices
            .filter(|(_, extent)| **extent >= highest)
            .map(|(vertex, _)| pose.transformed_point(vertex))
            .collect();
        (highest * body.modulus(), Aabb::around(&on_top))
    };
    let (pressure_a, box_a) = ridge(pair.a(), &Pose::identity());
    let (pressure_b, box_b) = ridge(pair.b(), &pose_ab);
    let reach = pair.a().shape().field().reach() + pair.b().shape().field().reach();
    let is_same = (pressure_a - pressure_b).abs() <= RIDGE * pressure_a.max(pressure_b);
    (is_same && box_a.overlaps(&box_b.inflated(RIDGE * reach))).then_some(Kink::Ridges)
}

/// Whether a polygon of the contact surface grazes a face of one of its tetrahedra.
fn grazing(pair: &ContactPair) -> Option<Kink> {
    let bodies = [pair.a(), pair.b()];
    let near =
        GRAZING_DISTANCE * (bodies[0].shape().field().reach() + bodies[1].shape().field().reach());
    let grazes = |polygon: &ContactPolygon| {
        bodies.iter().zip(polygon.tets).any(|(body, tet)| {
            let inverse = body.pose().inverse();
            let normal = inverse.rotation() * polygon.normal;
            let tet = &body.shape().field().tets()[tet];
            tet.barycentric
                .iter()
                .zip(tet.barycentric_steepness)
                .any(|(face, steepness)| {
                    let tilt = normal.cross(&face.gradient).norm() / steepness;
                    let is_near = |corner: &Vector3<f64>| {
                        let distance =
                            face.at(&inverse.transformed_point(corner)).abs() / steepness;
                        (MARGIN * near / GRAZING_DISTANCE..=near).contains(&distance)
                    };
                    tilt <= GRAZING_TILT && polygon.outline.corners().iter().any(is_near)
                })
        })
    };
    pair.surface()
        .polygons
        .iter()
        .any(grazes)
        .then_some(Kink::Grazing)
}

fn posed_box(tet: &FieldTet, pose: &Pose) -> Aabb {
    Aabb::around(
        &tet.tetrahedron
            .corners
            .map(|corner| pose.transformed_point(&corner)),
    )
}

/// Following and culling find the same wrench, up to polygons that are there or not by round-off: these are
/// no wider than the lines in which planes meet are off.
fn search_error(pair: &ContactPair, measures: &Measures) -> f64 {
    let everywhere = pair.with_search(Search::Culling(Culling::default()));
    let [followed, culled] = [pair, &everywhere].map(|pair| measures.scaled(&pair.wrench().on_a));
    let speck = measures.force() * (SPECK + measures.blur(measures.error));
    (followed - culled).norm() / (SAME * culled.norm() + speck)
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
    let [a, b] = [pair.a(), pair.b()].map(|body| posed(body, motion * *body.pose()));
    let moved = ContactPair::new(a, b);
    let there = measures.evaluation(&moved);
    let turned = moved.wrench().on_a.rotated(&motion.rotation().transpose());
    let error = measures.error.max(Measures::of(&moved).error);
    let difference = (measures.scaled(&turned) - own.wrench).norm();
    difference / measures.allowed(error, own, &there)
}

/// A and B change their names.
fn exchange_error(
    pair: &ContactPair,
    measures: &Measures,
    wrench: &ContactWrench,
    own: &Evaluation,
) -> f64 {
    let swapped = ContactPair::new(*pair.b(), *pair.a());
    let there = swapped.wrench();
    let difference = (measures.scaled(&there.on_b) - measures.scaled(&wrench.on_a)).norm();
    difference / measures.allowed(measures.error, own, own)
}

impl Measures {
    /// What an error of the coordinates (m) explains (N).
    fn allowed(&self, error: f64, here: &Evaluation, there: &Evaluation) -> f64 {
        let explained = [here, there].map(|end| ROOM * self.explained(end, error));
        explained[0] + explained[1] + self.noise(error) + SAME * ROOM * here.wrench.norm()
    }
}

/// One body moved a little, to where there is another pair.
fn step_error(there: &ContactPair, measures: &Measures, own: &Evaluation, motion: &Motion) -> f64 {
    let step = STEP * measures.reach[motion.0];
    let there = measures.evaluation(there);
    let [here_by, there_by] = [own, &there].map(|end| measures.predicted(end, motion));
    // J somewhere between those of both ends: off by no more than half of their difference, each.
    let error = (there.wrench - own.wrench - 0.5 * (here_by + there_by)).norm();
    let curvature = measures.force() * (FASTEST.sqrt() * step / measures.thinnest).powi(2).min(1.0);
    let jump = (there_by - here_by).norm();
    error / (jump + curvature + measures.allowed(measures.error, own, &there))
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

impl Measures {
    /// The change of the wrench (N) by a motion, by the Jacobian.
    fn predicted(&self, evaluation: &Evaluation, (body, twist): &Motion) -> Vector6<f64> {
        let on_a = &evaluation.jacobian.on_a;
        let by_pose = [&on_a.by_pose_a, &on_a.by_pose_b][*body];
        let (w, v) = (&twist.angular, &twist.linear);
        self.scaled_vector(&(by_pose * Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)))
    }
}

/// A motion of a body by a part of its size.
fn random_motion(body: usize, measures: &Measures, part: f64, random: &mut Random) -> Motion {
    let linear = random.direction() * (part * measures.reach[body]);
    let angular = random.vector() * part;
    (body, Twist { angular, linear })
}

fn moved<'a>(pair: &ContactPair<'a>, (body, twist): &Motion) -> ContactPair<'a> {
    let mut bodies = [*pair.a(), *pair.b()];
    bodies[*body] = posed(&bodies[*body], bodies[*body].pose().moved_by(twist));
    ContactPair::new(bodies[0], bodies[1])
}

fn posed<'a>(body: &ContactBody<'a>, pose: Pose) -> ContactBody<'a> {
    ContactBody::new(body.shape(), pose, body.modulus()).unwrap()
}
