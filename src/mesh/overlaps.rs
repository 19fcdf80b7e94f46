//! Search for components of a surface that overlap.
//!
//! Rays along x cross the boxes that two components share. The winding number of the surface is constant between the crossings of a ray
//! with triangles. A volume inside both components counts twice if the winding number there is at least 2.

use super::triangle_components::Components;
use super::{SurfaceWarning, triangle_solid};
use crate::bvh::Bvh;
use crate::geometry::Aabb;
use nalgebra::Vector3;
use robust::{Coord, orient2d};

/// Number of rays for all pairs together.
const RAY_COUNT: usize = 1 << 14;

/// Limit of the number of pairs that are searched.
const MAX_PAIR_COUNT: usize = 1 << 12;

/// Largest number of rays along each axis of a box.
const MAX_ROWS: usize = 32;

/// Overlap relative to the volume of the smaller component above which it is reported. Parts that touch overlap by rounding errors.
const TOLERANCE: f64 = 1e-3;

/// Positions of the rays between two rows, off the center, so that symmetric shapes have no edges on a ray.
const OFFSETS: [f64; 2] = [0.487_1, 0.512_9];

/// Corners of a triangle (m).
type Corners = [Vector3<f64>; 3];

struct Component {
    aabb: Aabb,
    volume: f64,
}

/// A triangle crossed by a ray.
struct Crossing {
    x: f64,
    component: usize,
    /// 1 if the ray enters the solid, and −1 if it leaves the solid.
    step: i32,
}

struct Search<'t> {
    triangles: &'t [Corners],
    components: Vec<Component>,
    /// Component of each triangle.
    component_of: Vec<usize>,
    bvh: Bvh<usize>,
}

/// Returns warnings if components overlap, or if there are too many pairs to search.
pub(super) fn warnings(triangles: &[Corners], members: &Components) -> Vec<SurfaceWarning> {
    let mut component_of = vec![0; triangles.len()];
    let mut components = Vec::new();
    for members in members.iter() {
        for &triangle in members {
            component_of[triangle] = components.len();
        }
        let corners = members.iter().map(|&triangle| triangles[triangle]);
        let all: Vec<Vector3<f64>> = corners.clone().flatten().collect();
        let aabb = Aabb::around(&all);
        let volume = triangle_solid::volume(aabb.center(), corners);
        components.push(Component { aabb, volume });
    }
    let mut pairs = pairs(&components);
    if pairs.is_empty() {
        return Vec::new();
    }
    let unsearched = (pairs.len() > MAX_PAIR_COUNT).then_some(SurfaceWarning::UnsearchedPairs {
        pair_count: MAX_PAIR_COUNT,
    });
    pairs.truncate(MAX_PAIR_COUNT);
    let search = Search {
        bvh: Bvh::new(triangles.iter().copied().enumerate()),
        triangles,
        components,
        component_of,
    };
    let overlap = search.warning(&pairs);
    overlap.into_iter().chain(unsearched).collect()
}

/// Returns the pairs of components whose boxes overlap, up to one pair above the limit. Cavities are skipped.
fn pairs(components: &[Component]) -> Vec<[usize; 2]> {
    let is_solid = |&index: &usize| components[index].volume > 0.0;
    let mut order: Vec<usize> = (0..components.len()).filter(is_solid).collect();
    let lower = |index: usize| components[index].aabb.lower.x;
    order.sort_by(|&a, &b| lower(a).total_cmp(&lower(b)));
    let mut pairs = Vec::new();
    for (position, &first) in order.iter().enumerate() {
        let aabb = components[first].aabb;
        let after = order[position + 1..].iter();
        for &second in after.take_while(|&&second| lower(second) < aabb.upper.x) {
            if aabb.overlaps(&components[second].aabb) {
                pairs.push([first, second]);
            }
            if pairs.len() > MAX_PAIR_COUNT {
                return pairs;
            }
        }
    }
    pairs
}

impl Search<'_> {
    fn warning(&self, pairs: &[[usize; 2]]) -> Option<SurfaceWarning> {
        let rows = ((RAY_COUNT / pairs.len()).isqrt()).clamp(2, MAX_ROWS);
        let (mut pair_count, mut volume, mut first) = (0, 0.0, None);
        for &pair in pairs {
            let Some((overlap, near)) = self.overlap(pair, rows) else {
                continue;
            };
            let [a, b] = pair.map(|index| self.components[index].volume);
            if overlap > TOLERANCE * a.min(b) {
                pair_count += 1;
                volume += overlap;
                first.get_or_insert(near);
            }
        }
        first.map(|near| SurfaceWarning::Overlap {
            pair_count,
            volume,
            near,
        })
    }

    /// Returns an estimate of the volume (m³) that counts twice, because it is inside both components, and a point in it.
    fn overlap(&self, pair: [usize; 2], rows: usize) -> Option<(f64, Vector3<f64>)> {
        let [a, b] = pair.map(|index| self.components[index].aabb);
        let common = a.common(&b)?;
        let step = (common.upper - common.lower) / rows as f64;
        let (mut length, mut near) = (0.0, None);
        for row in 0..rows * rows {
            let [y, z] = [(row % rows) as f64, (row / rows) as f64];
            let origin = common.lower
                + Vector3::new(0.0, (y + OFFSETS[0]) * step.y, (z + OFFSETS[1]) * step.z);
            for [from, to] in self.doubled(pair, origin, common.upper.x) {
                length += to - from;
                near.get_or_insert(Vector3::new(f64::midpoint(from, to), origin.y, origin.z));
            }
        }
        near.map(|near| (length * step.y * step.z, near))
    }

    /// Returns the intervals of x on a ray that count twice.
    fn doubled(&self, pair: [usize; 2], origin: Vector3<f64>, end: f64) -> Vec<[f64; 2]> {
        let (mut inside_pair, mut winding, mut x) = ([0, 0], 0, origin.x);
        let mut intervals = Vec::new();
        for crossing in self.crossings(origin) {
            let to = crossing.x.clamp(origin.x, end);
            if winding >= 2 && inside_pair.iter().all(|&inside| inside > 0) && to > x {
                intervals.push([x, to]);
            }
            x = to;
            winding += crossing.step;
            for (inside, index) in inside_pair.iter_mut().zip(pair) {
                *inside += if crossing.component == index {
                    crossing.step
                } else {
                    0
                };
            }
        }
        // A ray that does not end outside has hit an edge.
        if winding == 0 { intervals } else { Vec::new() }
    }

    /// Returns the triangles that the line along x through a point crosses, sorted by x.
    fn crossings(&self, point: Vector3<f64>) -> Vec<Crossing> {
        let bounds = self.bvh.bounds();
        let line = Aabb {
            lower: Vector3::new(bounds.lower.x, point.y, point.z),
            upper: Vector3::new(bounds.upper.x, point.y, point.z),
        };
        let mut crossings = Vec::new();
        self.bvh.visit_overlapping(&line, |triangle| {
            if let Some((x, step)) = crossing(self.triangles[triangle], &point) {
                let component = self.component_of[triangle];
                crossings.push(Crossing { x, component, step });
            }
        });
        crossings.sort_by(|a, b| a.x.total_cmp(&b.x));
        crossings
    }
}

/// Returns the position at which the line along x through a point crosses the interior of a triangle, and the step of the winding number.
fn crossing(corners: Corners, point: &Vector3<f64>) -> Option<(f64, i32)> {
    let flat = |v: &Vector3<f64>| Coord { x: v.y, y: v.z };
    let weight =
        |from: usize, to: usize| orient2d(flat(&corners[from]), flat(&corners[to]), flat(point));
    let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
    let step = if weights.iter().all(|weight| *weight > 0.0) {
        -1
    } else if weights.iter().all(|weight| *weight < 0.0) {
        1
    } else {
        return None;
    };
    let weighted = weights.iter().zip(&corners).map(|(w, corner)| w * corner.x);
    let x = weighted.sum::<f64>() / weights.iter().sum::<f64>();
    Some((x, step))
}
