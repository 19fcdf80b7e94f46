//! What errors are relative to, and what round-off explains.

use hydroelastic::contact::{ContactBody, ContactPair, RigidShape, Shape};
use hydroelastic::spatial::{Twist, Wrench};
use nalgebra::{Matrix6, Vector6};

/// The kernel's own margin: what counts as zero, relative to the bodies' reach.
pub const MARGIN: f64 = 3e-14;

/// Roundings of a coordinate far from the world's origin, in units in the last place: a few products and
/// sums of poses.
const WORLD_ROUNDINGS: f64 = 16.0;

/// Forces of round-off, relative to pressure times size squared: surfaces that only touch leave so much.
pub const SPECK: f64 = 1e-12;

/// Sums in another order round differently.
pub const SAME: f64 = 1e-12;

/// How many times the error that one coordinate explains all of them together may come to.
pub const ROOM: f64 = 100.0;

/// A plane of equal pressure moves this much faster than the body: the fields are nearly equal.
pub const FASTEST: f64 = 1e3;

/// A body that moves: 0 for A, 1 for B, and how.
pub type Motion = (usize, Twist);

/// The measures of a pair that errors are relative to.
pub struct Measures {
    /// Reach of the smaller body (m).
    pub size: f64,
    /// Reach of both bodies (m).
    pub reach: [f64; 2],
    /// Error of a coordinate (m).
    pub error: f64,
    /// Smallest height of a tetrahedron (m).
    pub thinnest: f64,
    /// The pressure that both bodies reach (Pa).
    pub pressure: f64,
}

/// A wrench on A about A's origin with its torque divided by A's reach, and its derivatives by the motion
/// of one body.
pub struct Evaluation {
    pub wrench: Vector6<f64>,
    /// By the poses of A and of B.
    pub by_poses: [Matrix6<f64>; 2],
}

impl Measures {
    pub fn of(pair: &ContactPair) -> Self {
        let (a, b) = (pair.a(), pair.b());
        let reach_a = a.shape().field().reach();
        let apart = (b.pose().translation() - a.pose().translation()).norm();
        let reach_b = match (b.shape(), b.rigid_shape()) {
            (Some(shape), _) => shape.field().reach(),
            (_, Some(rigid)) => rigid.surface().reach(),
            // A half-space has no end: what counts is how far A is from the origin of its frame.
            _ => apart.max(reach_a),
        };
        let away = [a.pose(), b.pose()].map(|pose| pose.translation().norm());
        let pressure_b = b.body().map_or(f64::INFINITY, |body| highest(&body));
        let thinnest_b = match (b.shape(), b.rigid_shape()) {
            (Some(shape), _) => thinnest(shape),
            (_, Some(rigid)) => thinnest_triangle(rigid),
            _ => f64::INFINITY,
        };
        Self {
            size: reach_a.min(reach_b),
            reach: [reach_a, reach_b],
            error: MARGIN * (reach_a + reach_b)
                + WORLD_ROUNDINGS * f64::EPSILON * away[0].max(away[1]),
            thinnest: thinnest(a.shape()).min(thinnest_b),
            pressure: highest(a).min(pressure_b),
        }
    }

    /// Pressure times size squared (N): what forces are measured by.
    pub fn force(&self) -> f64 {
        self.pressure * self.size.powi(2)
    }

    /// What an error of a coordinate may come to (N), where the wrench itself does not tell: in the
    /// thinnest tetrahedra the pressure changes most and clips cut worst.
    pub fn noise(&self, error: f64) -> f64 {
        self.force() * (SPECK + (ROOM * FASTEST.sqrt() * self.blur(error)).min(1.0))
    }

    /// How far lines in which planes meet may be off, relative to the smaller body.
    pub fn blur(&self, error: f64) -> f64 {
        error * self.reach[0].max(self.reach[1]) / (self.thinnest * self.size)
    }

    pub fn evaluation(&self, pair: &ContactPair) -> Evaluation {
        let contact = pair.linearized();
        let by_pose = |column| contact.by_poses.fixed_view::<6, 6>(0, column).into_owned();
        Evaluation {
            wrench: self.scaled(&contact.wrench.on_a),
            by_poses: [0, 6].map(by_pose),
        }
    }

    /// Torque over reach, force (N).
    pub fn scaled(&self, wrench: &Wrench) -> Vector6<f64> {
        self.scaled_vector(&wrench.to_vector())
    }

    pub fn scaled_vector(&self, vector: &Vector6<f64>) -> Vector6<f64> {
        let mut scaled = *vector;
        scaled
            .fixed_rows_mut::<3>(0)
            .scale_mut(self.reach[0].recip());
        scaled
    }

    /// How far the wrench changes (N) as B's coordinates change by an error (m), by the Jacobian.
    pub fn explained(&self, evaluation: &Evaluation, error: f64) -> f64 {
        let by_pose = &evaluation.by_poses[1];
        let arm = self.reach[1];
        let columns = (0..6).map(|k| {
            let column: Vector6<f64> = by_pose.column(k).into_owned();
            self.scaled_vector(&column).norm() * if k < 3 { arm.recip() } else { 1.0 }
        });
        error * columns.sum::<f64>()
    }

    /// What an error of the coordinates (m) explains (N).
    pub fn allowed(&self, error: f64, here: &Evaluation, there: &Evaluation) -> f64 {
        let explained = [here, there].map(|end| ROOM * self.explained(end, error));
        explained[0] + explained[1] + self.noise(error) + SAME * ROOM * here.wrench.norm()
    }

    /// The change of the wrench (N) by a motion, by the Jacobian.
    pub fn predicted(&self, evaluation: &Evaluation, (body, twist): &Motion) -> Vector6<f64> {
        let by_pose = evaluation.by_poses[*body];
        let (w, v) = (&twist.angular, &twist.linear);
        self.scaled_vector(&(by_pose * Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)))
    }
}

/// The highest pressure of a body (Pa).
fn highest(body: &ContactBody) -> f64 {
    let extents = body.shape().field().extents().iter().copied();
    body.modulus() * extents.fold(0.0, f64::max)
}

/// The smallest height of a tetrahedron (m).
fn thinnest(shape: &Shape) -> f64 {
    let tets = shape.field().tets().iter();
    let steepness = tets.flat_map(|tet| tet.barycentric_steepness);
    steepness.fold(0.0, f64::max).recip()
}

/// The smallest height of a triangle (m).
fn thinnest_triangle(shape: &RigidShape) -> f64 {
    let surface = shape.surface();
    let heights = (0..surface.triangles().len()).map(|triangle| {
        let [a, b, c] = surface.corners(triangle);
        let edges = [b - a, c - b, a - c].map(|edge| edge.norm());
        (b - a).cross(&(c - a)).norm() / edges.into_iter().fold(0.0, f64::max)
    });
    heights.fold(f64::INFINITY, f64::min)
}
