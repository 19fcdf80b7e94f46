//! Tetrahedra and their pressure fields in integers, in A's frame.

use super::projective::{Affine, Point};
use super::units::Units;
use hydroelastic::contact::ContactPair;
use nalgebra::Vector3;
use num_bigint::{BigInt, Sign};

/// A tetrahedron with a pressure field.
pub struct ExactTet {
    pub corners: [Vector3<BigInt>; 4],
    /// For each corner, a function that is zero on the opposite face and `volumes` at the corner.
    pub faces: [Affine; 4],
    /// Six times the volume.
    pub volumes: BigInt,
    /// The pressure times `volumes`.
    pub pressure: Affine,
    pub bounds: Bounds,
}

/// A closed axis-aligned box.
pub struct Bounds {
    lower: Vector3<BigInt>,
    upper: Vector3<BigInt>,
}

/// Returns the tetrahedra of a body of the pair: 0 for A, 1 for B.
pub fn exact_tets(pair: &ContactPair, body: usize, units: &Units) -> Vec<ExactTet> {
    let contact_body = [*pair.a(), pair.b().body().unwrap()][body];
    let field = contact_body.shape().field();
    let points: Vec<Vector3<BigInt>> = field
        .mesh()
        .vertices()
        .iter()
        .map(|vertex| match body {
            0 => units.point_of_a(vertex),
            _ => units.point_of_b(pair, vertex),
        })
        .collect();
    let pressures: Vec<BigInt> = field
        .extents()
        .iter()
        .map(|&extent| units.pressure_of(contact_body.modulus(), extent))
        .collect();
    let tets = field.mesh().tets().iter();
    tets.map(|tet| {
        ExactTet::new(
            tet.map(|v| points[v].clone()),
            &tet.map(|v| pressures[v].clone()),
        )
    })
    .collect()
}

impl ExactTet {
    fn new(corners: [Vector3<BigInt>; 4], pressures: &[BigInt; 4]) -> Self {
        let faces = [0, 1, 2, 3].map(|k| inner_face(&corners, k));
        let volumes = faces[0].at(&corners[0]);
        assert_eq!(volumes.sign(), Sign::Plus, "a tetrahedron is flat");
        let pressure = faces
            .iter()
            .zip(pressures)
            .map(|(face, pressure)| face.times(pressure))
            .reduce(|sum, next| sum.plus(&next))
            .unwrap();
        Self {
            bounds: Bounds::around(&corners),
            corners,
            faces,
            volumes,
            pressure,
        }
    }

    /// Returns whether the point lies in the closed tetrahedron.
    pub fn contains(&self, point: &Point) -> bool {
        let mut faces = self.faces.iter();
        faces.all(|face| face.sign_at(point) != Sign::Minus)
    }

    /// Returns the corners, in no order, of the intersection of the tetrahedron with the zero plane of a function that has these values at
    /// the corners.
    pub fn section(&self, values: &[BigInt; 4]) -> Vec<Point> {
        let mut points = Vec::new();
        for i in 0..4 {
            if values[i].sign() == Sign::NoSign {
                points.push(Point::of(self.corners[i].clone()));
            }
            for j in 0..i {
                if (&values[i] * &values[j]).sign() == Sign::Minus {
                    let ends = [&self.corners[i], &self.corners[j]];
                    points.extend(Point::crossing(ends, [&values[i], &values[j]]));
                }
            }
        }
        points
    }

    /// Returns whether all the points are strictly outside one of the faces.
    pub fn has_beyond(&self, points: &[Point]) -> bool {
        let beyond = |face: &Affine| points.iter().all(|p| face.sign_at(p) == Sign::Minus);
        self.faces.iter().any(beyond)
    }
}

/// Returns a function that is zero on the face opposite to a corner and positive at the corner.
fn inner_face(corners: &[Vector3<BigInt>; 4], corner: usize) -> Affine {
    let [a, b, c] = [1, 2, 3].map(|k| &corners[(corner + k) % 4]);
    let face = Affine::vanishing_at([a, b, c]);
    match face.at(&corners[corner]).sign() {
        Sign::Minus => Affine::vanishing_at([a, c, b]),
        _ => face,
    }
}

impl Bounds {
    fn around(corners: &[Vector3<BigInt>; 4]) -> Self {
        let along = |k: usize| corners.iter().map(move |corner| &corner[k]);
        Self {
            lower: Vector3::from_fn(|k, _| along(k).min().unwrap().clone()),
            upper: Vector3::from_fn(|k, _| along(k).max().unwrap().clone()),
        }
    }

    pub fn overlap(&self, other: &Self) -> bool {
        (0..3).all(|k| self.lower[k] <= other.upper[k] && other.lower[k] <= self.upper[k])
    }
}
