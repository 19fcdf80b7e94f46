//! Scales of errors, and bounds of round-off.

use hydroelastic::contact::{ContactBody, ContactPair, RigidShape, Shape};
use hydroelastic::spatial::{Twist, Wrench};
use nalgebra::{Matrix6, Vector6};

/// The kernel's margin relative to the bodies' reach, within which lengths count as zero.
pub const MARGIN: f64 = 3e-14;

/// Rounding error of a coordinate far from the world's origin, in units in the last place: a few products and sums of poses.
const WORLD_ROUNDINGS: f64 = 16.0;

/// Forces of round-off, relative to pressure times size squared, in surfaces that only touch.
pub const SPECK: f64 = 1e-12;

/// Relative tolerance, because the order of summation changes rounding errors.
pub const SAME: f64 = 1e-12;

/// Largest total error, relative to the error due to one coordinate.
pub const ROOM: f64 = 100.0;

/// Ratio of the speeds of a plane of equal pressure and of the body, above which the fields are nearly equal.
pub const FASTEST: f64 = 1e3;

/// A moving body (0 for A, 1 for B) and its twist.
pub type Motion = (usize, Twist);

/// Scales of the errors of a pair.
pub struct Measures {
    /// Reach of the smaller body (m).
    pub size: f64,
    /// Reach of both bodies (m).
    pub reach: [f64; 2],
    /// Error of a coordinate (m).
    pub error: f64,
    /// Smallest height of a tetrahedron (m).
    pub thinnest: f64,
    /// Highest pressure that both bodies reach (Pa).
    pub pressure: f64,
}

/// A wrench on A about A's origin with its torque divided by A's reach, and its derivatives with respect to the motion of one body.
pub struct Evaluation {
    pub wrench: Vector6<f64>,
    /// Derivatives with respect to the poses of A and of B.
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
            // A half-space is infinite, so the distance of A from the origin of its frame matters.
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

    /// Returns pressure times size squared (N), the scale of forces.
    pub fn force(&self) -> f64 {
        self.pressure * self.size.powi(2)
    }

    /// Returns a bound of the effect of a coordinate error (N) that the Jacobian does not predict. The bound depends on the thinnest
    /// tetrahedra, in which pressure changes most and clips are least accurate.
    pub fn noise(&self, error: f64) -> f64 {
        self.force() * (SPECK + (ROOM * FASTEST.sqrt() * self.blur(error)).min(1.0))
    }

    /// Returns the error of lines in which planes meet, relative to the smaller body.
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

    /// Returns torque divided by reach, and force (N).
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

    /// Returns the change of the wrench (N) that the Jacobian predicts for an error of B's coordinates (m).
    pub fn explained(&self, evaluation: &Evaluation, error: f64) -> f64 {
        let by_pose = &evaluation.by_poses[1];
        let arm = self.reach[1];
        let columns = (0..6).map(|k| {
            let column: Vector6<f64> = by_pose.column(k).into_owned();
            self.scaled_vector(&column).norm() * if k < 3 { arm.recip() } else { 1.0 }
        });
        error * columns.sum::<f64>()
    }

    /// Returns the effect of an error of the coordinates (m) on the wrench (N).
    pub fn allowed(&self, error: f64, here: &Evaluation, there: &Evaluation) -> f64 {
        let explained = [here, there].map(|end| ROOM * self.explained(end, error));
        explained[0] + explained[1] + self.noise(error) + SAME * ROOM * here.wrench.norm()
    }

    /// Returns the change of the wrench (N) that the Jacobian predicts for a motion.
    pub fn predicted(&self, evaluation: &Evaluation, (body, twist): &Motion) -> Vector6<f64> {
        let by_pose = evaluation.by_poses[*body];
        let (w, v) = (&twist.angular, &twist.linear);
        self.scaled_vector(&(by_pose * Vector6::new(w.x, w.y, w.z, v.x, v.y, v.z)))
    }
}

/// Returns the highest pressure of a body (Pa).
fn highest(body: &ContactBody) -> f64 {
    let extents = body.shape().field().extents().iter().copied();
    body.modulus() * extents.fold(0.0, f64::max)
}

/// Returns the smallest height of a tetrahedron (m).
fn thinnest(shape: &Shape) -> f64 {
    let tets = shape.field().tets().iter();
    let steepness = tets.flat_map(|tet| tet.barycentric_steepness);
    steepness.fold(0.0, f64::max).recip()
}

/// Returns the smallest height of a triangle (m).
fn thinnest_triangle(shape: &RigidShape) -> f64 {
    let surface = shape.surface();
    let heights = (0..surface.triangles().len()).map(|triangle| {
        let [a, b, c] = surface.corners(triangle);
        let edges = [b - a, c - b, a - c].map(|edge| edge.norm());
        (b - a).cross(&(c - a)).norm() / edges.into_iter().fold(0.0, f64::max)
    });
    heights.fold(f64::INFINITY, f64::min)
}
