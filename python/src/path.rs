//! Paths of kinematic bodies.

use crate::arrays::{
    Floats, Many, Numbers, array, check_finite, finite, finite_row, list, numbers, real,
    wrong_shape,
};
use crate::errors::value_error;
use crate::pickle::{Reduced, loaded, reduced};
use crate::poses::{finite_matrix, poses, single_pose, twist_of};
use hydroelastic::dynamics::{BodyState, KinematicPath};
use hydroelastic::nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use hydroelastic::spatial::{Pose, Twist, rotation_from_vector, skew};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Angle (rad) below which the quadratic term of the rate matrix is omitted, because the term is below round-off.
const SMALL: f64 = 1e-8;

/// Path of a kinematic body: its pose and twist as functions of time. This constructor interpolates between n poses.
///
/// Between two poses, the position is a cubic polynomial of time, and so is the rotation vector from the first pose to the second. Both
/// polynomials match the twists at the ends, so pose and twist are consistent. The body rests before the first time and after the last
/// time. At the last time itself, the body still has the last twist.
///
/// Parameters
/// ----------
/// times : (n,) array_like
///     Increasing times (s).
/// poses : (n, 4, 4) array_like
///     Poses of the body frame in the world.
/// twists : (n, 6) array_like, optional
///     Angular velocity (rad/s), then velocity (m/s) of the origin of the body frame, in world axes. Default: central differences of the
///     poses, and one-sided differences at the ends.
///
/// Raises
/// ------
/// HydroelasticError
///     If times do not increase, a pose is not rigid, a number is not finite, or an array has an unexpected shape.
#[pyclass(frozen, module = "hydroelastic")]
#[derive(Clone)]
pub struct Path(pub Arc<Kind>);

/// Data of a path.
#[derive(Serialize, Deserialize)]
pub enum Kind {
    Through(Vec<Knot>),
    Steady { pose: Pose, twist: Twist },
}

/// Time (s), with the pose and the twist at this time.
#[derive(Serialize, Deserialize)]
pub struct Knot {
    time: f64,
    pose: Pose,
    twist: Twist,
}

#[pymethods]
impl Path {
    #[new]
    #[pyo3(signature = (times, poses, twists=None))]
    fn new(
        times: &Bound<'_, PyAny>,
        poses: &Bound<'_, PyAny>,
        twists: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let times = list(times, "times")?;
        let poses = many_poses(poses, times.len())?;
        check_times(&times)?;
        let twists = match twists {
            Some(twists) => many_twists(twists, times.len())?,
            None => differences(&times, &poses),
        };
        let knots = times.into_iter().zip(poses).zip(twists);
        let knots = knots.map(|((time, pose), twist)| Knot { time, pose, twist });
        Ok(Self(Arc::new(Kind::Through(knots.collect()))))
    }

    /// Creates a path with a constant twist.
    ///
    /// The body turns about the origin of its frame with a constant angular velocity, and the origin moves with a constant velocity. The
    /// motion has no end.
    ///
    /// Parameters
    /// ----------
    /// pose : (4, 4) array_like
    ///     Pose of the body frame in the world at time 0.
    /// twist : (6,) array_like
    ///     Angular velocity (rad/s), then velocity (m/s) of the origin, in world axes.
    ///
    /// Returns
    /// -------
    /// Path
    ///     Path with this twist.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the pose is not rigid, or a number is not finite.
    #[staticmethod]
    fn steady(pose: &Bound<'_, PyAny>, twist: &Bound<'_, PyAny>) -> PyResult<Self> {
        let pose = single_pose(pose, "pose")?;
        let twist = twist_of(&finite_row(twist, "twist")?);
        Ok(Self(Arc::new(Kind::Steady { pose, twist })))
    }

    /// Evaluates the path at a time.
    ///
    /// Parameters
    /// ----------
    /// time : float
    ///     Time (s).
    ///
    /// Returns
    /// -------
    /// pose : (4, 4) ndarray of float64
    ///     Pose of the body frame in the world.
    /// twist : (6,) ndarray of float64
    ///     Angular velocity (rad/s), then velocity (m/s) of the origin, in world axes.
    ///
    /// Raises
    /// ------
    /// HydroelasticError
    ///     If the time, the pose or the twist is not finite.
    fn at<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = real)] time: f64,
    ) -> PyResult<(Floats<'py>, Floats<'py>)> {
        let BodyState { pose, twist } = self.state_at(finite(time, "time")?);
        let twist = twist.to_vector().as_slice().to_vec();
        check_finite(&twist, "the twist of the path")?;
        Ok((finite_matrix(py, &pose)?, array(py, twist, &[6])?))
    }

    fn __repr__(&self) -> String {
        match &*self.0 {
            Kind::Through(knots) => {
                let [first, last] = [&knots[0], &knots[knots.len() - 1]].map(|knot| knot.time);
                format!(
                    "Path(through {} poses from {first:?} s to {last:?} s)",
                    knots.len()
                )
            }
            Kind::Steady { twist, .. } => {
                format!("Path(steady, twist={:?})", twist.to_vector().as_slice())
            }
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "_load_path", &*self.0)
    }
}

/// Restores a path from a pickle.
#[pyfunction]
pub fn _load_path(saved: &[u8]) -> PyResult<Path> {
    loaded(saved).map(|kind| Path(Arc::new(kind)))
}

impl Path {
    /// Converts to a path of the library.
    pub fn function(&self) -> Arc<KinematicPath> {
        let path = self.clone();
        Arc::new(move |time| path.state_at(time))
    }

    fn state_at(&self, time: f64) -> BodyState {
        match &*self.0 {
            Kind::Steady { pose, twist } => {
                let [angular, linear] = [twist.angular, twist.linear].map(|rate| rate * time);
                let pose = pose.moved_by(&Twist { angular, linear });
                BodyState {
                    pose,
                    twist: *twist,
                }
            }
            Kind::Through(knots) => through(knots, time),
        }
    }
}

/// Interpolates between the knots around a time.
fn through(knots: &[Knot], time: f64) -> BodyState {
    let next = knots.partition_point(|knot| knot.time <= time);
    let rest = |knot: &Knot| BodyState {
        pose: knot.pose,
        twist: Twist::zero(),
    };
    match next {
        0 => rest(&knots[0]),
        next if next == knots.len() => {
            let last = &knots[next - 1];
            let arrives = next > 1 && time <= last.time;
            let twist = if arrives { last.twist } else { Twist::zero() };
            let pose = last.pose;
            BodyState { pose, twist }
        }
        next => between(&knots[next - 1], &knots[next], time),
    }
}

/// Interpolates between two knots, with cubics of the position and of the rotation vector in the axes of the first pose.
fn between(from: &Knot, to: &Knot, time: f64) -> BodyState {
    let duration = to.time - from.time;
    let fraction = (time - from.time) / duration;
    let axes = *from.pose.rotation();
    let turn = turn_between(&from.pose, &to.pose);
    let rate_at_end = rate_matrix(&turn)
        .try_inverse()
        .unwrap_or_else(Matrix3::identity);
    let rates = [
        axes.transpose() * from.twist.angular,
        rate_at_end * axes.transpose() * to.twist.angular,
    ];
    let (vector, rate) = cubic(fraction, duration, [Vector3::zeros(), turn], rates);
    let ends = [&from.pose, &to.pose].map(|pose| *pose.translation());
    let (position, velocity) = cubic(
        fraction,
        duration,
        ends,
        [from.twist.linear, to.twist.linear],
    );
    let rotation = axes * rotation_from_vector(&vector);
    // The product of two rotations is a rotation up to round-off, so `Pose::new` accepts it.
    let pose = Pose::new(rotation, position).unwrap_or(from.pose);
    let angular = axes * rate_matrix(&vector) * rate;
    BodyState {
        pose,
        twist: Twist {
            angular,
            linear: velocity,
        },
    }
}

/// Evaluates the cubic Hermite polynomial with given values and rates (1/s) at both ends of a duration (s). Returns its value and rate at
/// a fraction of the duration.
fn cubic(
    fraction: f64,
    duration: f64,
    [start, end]: [Vector3<f64>; 2],
    rates: [Vector3<f64>; 2],
) -> (Vector3<f64>, Vector3<f64>) {
    let [leaving, arriving] = rates.map(|rate| rate * duration);
    let (square, cube) = (fraction.powi(2), fraction.powi(3));
    let value = start
        + (end - start) * (3.0 * square - 2.0 * cube)
        + leaving * (fraction - 2.0 * square + cube)
        + arriving * (cube - square);
    let slope = (end - start) * (6.0 * (fraction - square))
        + leaving * (1.0 - 4.0 * fraction + 3.0 * square)
        + arriving * (3.0 * square - 2.0 * fraction);
    (value, slope / duration)
}

/// Matrix that maps the rate of a rotation vector θ to the angular velocity:
/// I + (1 − cos θ)/θ² [θ] + (θ − sin θ)/θ³ [θ]².
fn rate_matrix(vector: &Vector3<f64>) -> Matrix3<f64> {
    let angle = vector.norm();
    let cross = skew(vector);
    if angle < SMALL {
        return Matrix3::identity() + cross * 0.5;
    }
    let square = angle * angle;
    let half = (angle / 2.0).sin();
    Matrix3::identity()
        + cross * (2.0 * half * half / square)
        + cross * cross * ((angle - angle.sin()) / (square * angle))
}

/// Rotation vector (rad, at most half a turn) from one pose to another, in the axes of the first pose.
fn turn_between(from: &Pose, to: &Pose) -> Vector3<f64> {
    let turn = Rotation3::from_matrix_unchecked(from.rotation().transpose() * to.rotation());
    UnitQuaternion::from_rotation_matrix(&turn).scaled_axis()
}

/// Twists from central differences, and from one-sided differences at the ends.
fn differences(times: &[f64], poses: &[Pose]) -> Vec<Twist> {
    let last = times.len() - 1;
    let twist = |index: usize| {
        let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
        if before == after {
            return Twist::zero();
        }
        let duration = times[after] - times[before];
        let turn = poses[before].rotation() * turn_between(&poses[before], &poses[after]);
        let shift = poses[after].translation() - poses[before].translation();
        Twist {
            angular: turn / duration,
            linear: shift / duration,
        }
    };
    (0..times.len()).map(twist).collect()
}

fn check_times(times: &[f64]) -> PyResult<()> {
    if times.is_empty() || times.iter().any(|time| !time.is_finite()) {
        return Err(value_error(
            "a path needs at least one time, and all must be finite",
        ));
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        None => Ok(()),
        Some(index) => Err(value_error(format!(
            "the times of a path must increase, but times[{index}] is {} and times[{}] is {}",
            times[index],
            index + 1,
            times[index + 1]
        ))),
    }
}

fn many_poses(argument: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Pose>> {
    match poses(argument, "poses")? {
        Many::Each(poses) if poses.len() == count => Ok(poses),
        Many::Each(poses) => Err(wrong_shape(
            "poses",
            &format!("({count}, 4, 4)"),
            &[poses.len(), 4, 4],
        )),
        Many::One(_) => Err(wrong_shape("poses", &format!("({count}, 4, 4)"), &[4, 4])),
    }
}

/// Reads `count` twists. Returns an error if a number is not finite.
pub fn many_twists(argument: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Twist>> {
    let Numbers { values, shape } = numbers(argument, "twists")?;
    if shape != [count, 6] {
        return Err(wrong_shape("twists", &format!("({count}, 6)"), &shape));
    }
    if let Some(value) = values.iter().find(|value| !value.is_finite()) {
        return Err(value_error(format!(
            "twists must be finite, but have the component {value}"
        )));
    }
    let twist = |numbers: &[f64]| twist_of(&std::array::from_fn(|index| numbers[index]));
    Ok(values.chunks(6).map(twist).collect())
}
