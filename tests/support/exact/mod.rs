//! The contact wrench in exact arithmetic. All decisions use integers.
//!
//! Coordinates, extents, moduli and the entries of poses are `f64`, so each is an integer multiple of a power of two. Planes, sections and
//! corners are polynomials in them, and no sign is ever rounded. A corner is rounded only at the end, to [`FINE`] bits below the unit of
//! the coordinates.
//!
//! The implementation follows the definitions:
//!
//! - B's vertices in A's frame are R_Aᵀ·(R_B·x + t_B − t_A), with the unchanged numbers of both poses.
//! - In each pair of tetrahedra, the contact polygon is the intersection of both and of the plane p_A = p_B. If the gradients are equal,
//!   there is no polygon.
//! - The weight of a polygon is the mean of the sections just above and just below the plane. The weight is a half if the tetrahedra have
//!   only one side of the plane in common, so a polygon in a shared face counts once. The weight is zero if they have neither side in
//!   common.
//! - The wrench on A is the sum of ∫ p n dA and ∫ x × p n dA, with n along ∇(p_A − p_B).

mod polygon;
mod projective;
mod tet;
mod units;

use hydroelastic::contact::ContactPair;
use nalgebra::{Vector3, Vector6};
use num_bigint::BigInt;
use polygon::ContactPolygon;
use tet::exact_tets;
use units::{Units, rounded};

/// Number of bits below the unit of length to which a corner of a polygon is rounded. All coordinates are integer multiples of that unit,
/// so the error is below 2⁻¹²⁸ of the smallest nonzero coordinate.
const FINE: u32 = 128;

/// Result of the exact twin.
pub struct ExactContact {
    /// Torque about A's origin and force on A, in world axes.
    pub wrench: Vector6<f64>,
    /// Number of contact polygons.
    pub polygons: usize,
}

/// Computes the contact of a pair.
pub fn contact(pair: &ContactPair) -> ExactContact {
    let units = Units::of(pair);
    let [tets_a, tets_b] = [0, 1].map(|body| exact_tets(pair, body, &units));
    let mut sum = Sum::default();
    for a in &tets_a {
        for b in tets_b.iter().filter(|b| a.bounds.overlap(&b.bounds)) {
            if let Some(polygon) = ContactPolygon::between(a, b) {
                sum.add(&polygon);
            }
        }
    }
    sum.in_world(pair, &units)
}

/// 48 times ∫ p n dA and ∫ x × p n dA over the contact polygons, in A's frame.
#[derive(Default)]
struct Sum {
    force: [BigInt; 3],
    torque: [BigInt; 3],
    polygons: usize,
}

impl Sum {
    fn add(&mut self, polygon: &ContactPolygon) {
        let [force, torque] = polygon.pressed();
        for k in 0..3 {
            self.force[k] += &force[k] * polygon.twice_weight;
            self.torque[k] += &torque[k] * polygon.twice_weight;
        }
        self.polygons += 1;
    }

    /// Rotates the sums into the world's axes and rounds them.
    fn in_world(self, pair: &ContactPair, units: &Units) -> ExactContact {
        let rotation = units.rotation(pair.a().pose());
        let bits = i32::try_from(FINE).unwrap();
        let fine = units.length - bits;
        let force_unit = units.rotation + units.pressure - bits + 2 * fine;
        let turned = |vector: [BigInt; 3], unit: i32| {
            let vector = &rotation * Vector3::from(vector);
            vector.map(|number| rounded(&number, unit) / 48.0)
        };
        let torque = turned(self.torque, force_unit + fine);
        let force = turned(self.force, force_unit);
        ExactContact {
            wrench: Vector6::from_iterator(torque.iter().chain(&force).copied()),
            polygons: self.polygons,
        }
    }
}
