//! The contact polygon of two tetrahedra in integers.

use super::FINE;
use super::projective::{Affine, Point};
use super::tet::ExactTet;
use nalgebra::Vector3;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// A contact polygon, on the fine lattice.
pub struct ContactPolygon {
    /// Corners in cyclic order, counter-clockwise about the normal.
    corners: Vec<Vector3<BigInt>>,
    /// A's pressure times `volumes`, on the fine lattice.
    pressure: Affine,
    volumes: BigInt,
    /// Number of common sides of the tetrahedra at the plane: 1 or 2.
    pub twice_weight: u32,
}

impl ContactPolygon {
    /// Returns the polygon of a tetrahedron of A and a tetrahedron of B, if there is a polygon with nonzero weight.
    pub fn between(a: &ExactTet, b: &ExactTet) -> Option<Self> {
        // p_A − p_B, times both volumes.
        let minus = -&a.volumes;
        let excess = a.pressure.times(&b.volumes).plus(&b.pressure.times(&minus));
        let normal = &excess.gradient;
        if *normal == Vector3::zeros() {
            return None;
        }
        let values = [a, b].map(|tet| tet.corners.each_ref().map(|corner| excess.at(corner)));
        let twice_weight = common_sides(&values);
        if twice_weight == 0 {
            return None;
        }
        let corners = common_corners([a, b], &values, &excess);
        let corners = in_cyclic_order(&corners, normal);
        (corners.len() >= 3).then(|| Self {
            corners,
            pressure: a.pressure.refined(FINE),
            volumes: a.volumes.clone(),
            twice_weight,
        })
    }

    /// Returns 24 times ∫ p n dA and ∫ x × p n dA.
    ///
    /// The integral of a product of affine functions f and g over a triangle is its area times (Σfᵢ·Σgᵢ + Σfᵢgᵢ)/12. Half of the cross
    /// product of two edges is the triangle's area times n.
    pub fn pressed(&self) -> [Vector3<BigInt>; 2] {
        let (mut force, mut torque) = (Vector3::zeros(), Vector3::zeros());
        for pair in self.corners[1..].windows(2) {
            let corners = [&self.corners[0], &pair[0], &pair[1]];
            let [p, q, r] = corners;
            let double_area = (q - p).cross(&(r - p));
            let pressures = corners.map(|corner| self.pressure.at(corner));
            let total: BigInt = pressures.iter().sum();
            let mut weighted = (p + q + r) * total.clone();
            for (corner, pressure) in corners.iter().zip(pressures) {
                weighted += *corner * pressure;
            }
            force += &double_area * (total * 4);
            torque += weighted.cross(&double_area);
        }
        [force, torque].map(|vector| vector.map(|number| number / &self.volumes))
    }
}

/// Returns the number of sides of the plane that two tetrahedra at the plane have in common. A tetrahedron with a face in the plane lies on
/// one side, and any other on both sides.
fn common_sides(values: &[[BigInt; 4]; 2]) -> u32 {
    let lies = |side: Sign| {
        values
            .iter()
            .all(|values| values.iter().any(|v| v.sign() == side) || !has_face_in_plane(values))
    };
    u32::from(lies(Sign::Plus)) + u32::from(lies(Sign::Minus))
}

fn has_face_in_plane(values: &[BigInt; 4]) -> bool {
    let zeros = values.iter().filter(|v| v.sign() == Sign::NoSign);
    zeros.count() == 3
}

/// Returns the corners, in no order, of the intersection of the plane and both tetrahedra. These are the corners of either section inside
/// the other tetrahedron, and the points at which a face of one crosses a face of the other.
fn common_corners(tets: [&ExactTet; 2], values: &[[BigInt; 4]; 2], excess: &Affine) -> Vec<Point> {
    let [a, b] = tets;
    let [section_a, section_b] = [a.section(&values[0]), b.section(&values[1])];
    let is_apart = b.has_beyond(&section_a) || a.has_beyond(&section_b);
    if section_a.len() < 3 || section_b.len() < 3 || is_apart {
        return Vec::new();
    }
    let of_a = section_a.into_iter().filter(|point| b.contains(point));
    let of_b = section_b.into_iter().filter(|point| a.contains(point));
    let mut corners: Vec<Point> = of_a.chain(of_b).collect();
    for face_a in &a.faces {
        for face_b in &b.faces {
            let crossing = Point::common_zero([excess, face_a, face_b]);
            corners.extend(crossing.filter(|point| a.contains(point) && b.contains(point)));
        }
    }
    corners
}

/// Returns the corners of a convex polygon on the fine lattice, counter-clockwise about the normal, or no corners if they are collinear.
fn in_cyclic_order(corners: &[Point], normal: &Vector3<BigInt>) -> Vec<Vector3<BigInt>> {
    let mut corners: Vec<_> = corners.iter().map(|point| point.fine(FINE)).collect();
    corners.sort_by(|a, b| a.iter().cmp(b.iter()));
    corners.dedup();
    let count = BigInt::from(corners.len());
    let sum: Vector3<BigInt> = corners.iter().fold(Vector3::zeros(), |sum, c| sum + c);
    let from_mean = |corner: &Vector3<BigInt>| corner * count.clone() - &sum;
    let Some(start) = corners.first().map(from_mean) else {
        return corners;
    };
    let turn = |u: &Vector3<BigInt>, v: &Vector3<BigInt>| normal.dot(&u.cross(v));
    // The half-turn that contains a direction, counted from `start`.
    let half = |u: &Vector3<BigInt>| match turn(&start, u).sign() {
        Sign::Plus => 0,
        Sign::NoSign if start.dot(u).sign() == Sign::Plus => 0,
        _ => 1,
    };
    corners.sort_by(|a, b| {
        let (u, v) = (from_mean(a), from_mean(b));
        let by_turn = || match turn(&u, &v).sign() {
            Sign::Plus => Ordering::Less,
            Sign::Minus => Ordering::Greater,
            Sign::NoSign => Ordering::Equal,
        };
        half(&u).cmp(&half(&v)).then_with(by_turn)
    });
    corners
}
