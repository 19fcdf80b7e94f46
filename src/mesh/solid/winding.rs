use crate::bvh::{Bvh, Node, PerNode};
use crate::geometry::Triangle;
use crate::mesh::triangle_solid::half_solid_angle;
use crate::scalar::portable::atan2;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Distance to a cluster over its radius beyond which the cluster acts as a dipole.
const FAR: f64 = 2.5;

/// The generalized winding numbers of triangles [Jacobson, Kavan, Sorkine-Hornung 2013]: the solid angle that the triangles cover,
/// seen from a point, over 4π. It is 1 inside a closed surface and 0 outside. Small holes change it little.
///
/// Triangles far from the point act as a dipole [Barill, Dickson, Schmidt, Levin, Jacobson 2018].
#[derive(Debug)]
pub(super) struct WindingNumbers {
    clusters: PerNode<Cluster>,
}

/// The triangles below a node of a tree.
#[derive(Debug)]
struct Cluster {
    /// Mean position of the triangles, weighted by area (m).
    center: Vector3<f64>,
    /// Sum of the normals times the areas (m²).
    area: Vector3<f64>,
    /// Largest distance of a corner from the center (m).
    radius: f64,
}

/// A sum of angles: the angle of a product of complex numbers, and full turns. It needs one arctangent for all angles.
#[derive(Debug)]
struct AngleSum {
    product: [f64; 2],
    turns: f64,
}

impl AngleSum {
    const ZERO: Self = Self {
        product: [1.0, 0.0],
        turns: 0.0,
    };

    /// Adds the angle in (−π, π] of a complex number. Zero has the angle 0.
    fn add(&mut self, [re, im]: [f64; 2]) {
        let [own_re, own_im] = self.product;
        let product = [own_re * re - own_im * im, own_re * im + own_im * re];
        let size = product[0].abs() + product[1].abs();
        if size == 0.0 {
            return;
        }
        // The sum of two angles of one sign is beyond ±π if the sign changes.
        if (own_im < 0.0) == (im < 0.0) && (own_im < 0.0) != (product[1] < 0.0) {
            self.turns += 1.0_f64.copysign(-product[1]);
        }
        self.product = product.map(|part| part / size);
    }

    fn total(&self) -> f64 {
        atan2(self.product[1], self.product[0]) + 2.0 * PI * self.turns
    }
}

impl Cluster {
    fn of(items: &[usize], triangles: &[Triangle]) -> Self {
        let (mut sum, mut weights, mut area) = (Vector3::zeros(), 0.0, Vector3::zeros());
        for &item in items {
            let [a, b, c] = triangles[item].corners();
            let normal = (b - a).cross(&(c - a)) / 2.0;
            let weight = normal.norm() + f64::MIN_POSITIVE;
            sum += (a + b + c) * (weight / 3.0);
            weights += weight;
            area += normal;
        }
        let center = sum / weights;
        let corners = items.iter().flat_map(|&item| triangles[item].corners());
        let radius = corners
            .map(|corner| (corner - center).norm())
            .fold(0.0, f64::max);
        Self {
            center,
            area,
            radius,
        }
    }
}

impl WindingNumbers {
    /// Prepares the winding numbers of the triangles of a tree in O(n log n) time.
    pub fn of(bvh: &Bvh<usize>, triangles: &[Triangle]) -> Self {
        let clusters = PerNode::of(bvh, |items, _| Cluster::of(items, triangles));
        Self { clusters }
    }

    /// Returns the winding number around a point (m).
    pub fn at(&self, point: &Vector3<f64>, bvh: &Bvh<usize>, triangles: &[Triangle]) -> f64 {
        let (mut angle, mut halves) = (0.0, AngleSum::ZERO);
        let mut waiting = vec![Node::ROOT];
        while let Some(node) = waiting.pop() {
            let cluster = &self.clusters.level(node.level)[node.index];
            let away = cluster.center - point;
            let distance = away.norm();
            if distance > FAR * cluster.radius {
                angle += cluster.area.dot(&away) / distance.powi(3);
                continue;
            }
            waiting.extend(bvh.child_nodes(node));
            for &item in bvh.leaf_items(node) {
                halves.add(half_solid_angle(
                    triangles[item].corners().map(|corner| corner - point),
                ));
            }
        }
        (angle + 2.0 * halves.total()) / (4.0 * PI)
    }
}

#[cfg(test)]
mod tests {
    use super::AngleSum;

    #[test]
    fn sums_of_angles_count_turns_in_both_directions() {
        for step in [0.1_f64, 1.3, 2.9, -0.1, -1.3, -2.9] {
            let (mut sum, mut exact) = (AngleSum::ZERO, 0.0);
            for index in 0..100 {
                let angle = step * if index % 3 == 0 { -0.4 } else { 1.0 };
                sum.add([1e-9 * angle.cos(), 1e-9 * angle.sin()]);
                exact += angle;
                assert!((sum.total() - exact).abs() < 1e-12, "{index} {step}");
            }
        }
    }
}
