//! Visible parts of half-spaces in pictures.

use super::{Body, BodyShape, Force, Model, Motion, State, World, WorldError};
use crate::geometry::{Aabb, AffineField};
use nalgebra::{Vector3, vector};

/// Margin around the bodies, relative to the diagonal of their bounding box.
const MARGIN: f64 = 0.25;
/// Margin (m) around a bounding box that is a point.
const MARGIN_OF_A_POINT: f64 = 1.0;
/// Heights over a plane that count as zero, relative to the largest coordinate.
const ROUNDING: f64 = 1e-9;

impl<F: Force> World<f64, F> {
    /// Outlines of the half-spaces in a picture of one or several states. For each body, this method returns the corners (m) of a convex
    /// polygon in the plane z = 0 of the body frame, counter-clockwise seen from outside.
    ///
    /// The polygon is a rectangle around the moving bodies in all states, or around all bodies if none moves. The rectangle has a margin
    /// of a quarter of the diagonal of their bounding box. Its parts inside other half-spaces are cut off, so that a floor and four walls
    /// make a tray. A plane that moves relative to a half-space does not cut it.
    ///
    /// The list of corners is empty if the body is not a half-space, or if other half-spaces hide it.
    ///
    /// # Errors
    /// If a state has another number of bodies than the world, a pose that is not rigid, or a number that is not finite.
    pub fn half_space_outlines(
        &self,
        states: &[&State],
    ) -> Result<Vec<Vec<Vector3<f64>>>, WorldError> {
        for state in states {
            state.check_fits(self.bodies())?;
        }
        Ok(self.model.half_space_outlines(states))
    }
}

impl Model {
    /// Outlines of the half-spaces in states that fit the bodies.
    pub(crate) fn half_space_outlines(&self, states: &[&State]) -> Vec<Vec<Vector3<f64>>> {
        let indices = 0..self.bodies.len();
        let outlines = indices.map(|index| {
            if is_half_space(&self.bodies[index]) {
                outline(index, &self.bodies, states)
            } else {
                Vec::new()
            }
        });
        outlines.collect()
    }
}

fn is_half_space(body: &Body) -> bool {
    matches!(body.shape(), BodyShape::HalfSpace(_))
}

/// Outline of the half-space with this index, in its frame.
fn outline(index: usize, bodies: &[Body], states: &[&State]) -> Vec<Vector3<f64>> {
    let scene = scene_in_frame_of(index, bodies, states);
    let diagonal = 2.0 * scene.half_extents().norm();
    let scene = scene.inflated(if diagonal > 0.0 {
        MARGIN * diagonal
    } else {
        MARGIN_OF_A_POINT
    });
    let (lower, upper) = (scene.lower, scene.upper);
    let rectangle = [
        vector![lower.x, lower.y, 0.0],
        vector![upper.x, lower.y, 0.0],
        vector![upper.x, upper.y, 0.0],
        vector![lower.x, upper.y, 0.0],
    ];
    let zero = ROUNDING * lower.amax().max(upper.amax());
    let others = (0..bodies.len()).filter(|&other| other != index && is_half_space(&bodies[other]));
    let heights = others.filter_map(|other| {
        let mut heights = states.iter().map(|state| height(index, other, state));
        let first = heights.next()?;
        let is_first = |height: AffineField| {
            let change = |corner| (height.at(corner) - first.at(corner)).abs();
            rectangle.iter().all(|corner| change(corner) <= zero)
        };
        heights.all(is_first).then_some(first)
    });
    let visible = heights.fold(rectangle.to_vec(), |visible, height| {
        clipped(&visible, &height, zero)
    });
    if visible.len() < 3 {
        return Vec::new();
    }
    visible
}

/// Bounding box (m) of the moving bodies in all states, or of all bodies if none moves, in the frame of the half-space with this index.
/// Without bodies, the box is the origin.
fn scene_in_frame_of(half_space: usize, bodies: &[Body], states: &[&State]) -> Aabb {
    let around = |only_moving: bool| {
        let boxes = states.iter().flat_map(move |state| {
            let to_half_space = state.bodies[half_space].pose.inverse();
            let included = bodies.iter().zip(&state.bodies);
            let included = included.filter(move |(body, _)| {
                let is_fixed = matches!(body.motion, Motion::Fixed);
                !(is_half_space(body) || only_moving && is_fixed)
            });
            included.map(move |(body, state)| body.shape.bounds_at(&(to_half_space * state.pose)))
        });
        boxes.reduce(|a, b| a.union(&b))
    };
    let scene = around(true).or_else(|| around(false));
    scene.unwrap_or_else(|| Aabb::around([&Vector3::zeros()]))
}

/// Height (m) over the plane of another half-space, as a function of coordinates in the frame of a half-space.
fn height(half_space: usize, other: usize, state: &State) -> AffineField {
    let [pose_w, pose_wo] = [half_space, other].map(|body| state.bodies[body].pose);
    let height = AffineField {
        gradient: Vector3::z(),
        offset: 0.0,
    };
    height.posed(&(pose_w.inverse() * pose_wo))
}

/// Part of a convex polygon at heights of at least zero. Heights of at most `zero` count as zero.
fn clipped(polygon: &[Vector3<f64>], height: &AffineField, zero: f64) -> Vec<Vector3<f64>> {
    let next = polygon.iter().cycle().skip(1);
    let edges = polygon.iter().zip(next).flat_map(|(corner, next)| {
        let [from, to] = [corner, next].map(|corner| height.at(corner));
        let crosses = from.min(to) < -zero && from.max(to) > zero;
        let crossing = crosses.then(|| corner + (next - corner) * (from / (from - to)));
        let corner = (from >= -zero).then_some(*corner);
        corner.into_iter().chain(crossing)
    });
    edges.collect()
}
