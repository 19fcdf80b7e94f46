//! Points and affine functions in integers. A point between lattice points is a lattice vector with a weight as its divisor.

use nalgebra::Vector3;
use num_bigint::{BigInt, Sign};

/// The point position/weight.
#[derive(Clone)]
pub struct Point {
    position: Vector3<BigInt>,
    /// Positive divisor.
    weight: BigInt,
}

/// The function gradient·x + offset.
pub struct Affine {
    pub gradient: Vector3<BigInt>,
    pub offset: BigInt,
}

impl Point {
    pub fn of(position: Vector3<BigInt>) -> Self {
        let weight = BigInt::from(1);
        Self { position, weight }
    }

    /// Returns the point position/weight for a weight of any sign, or `None` at infinity.
    fn of_weight(position: Vector3<BigInt>, weight: BigInt) -> Option<Self> {
        match weight.sign() {
            Sign::Plus => Some(Self { position, weight }),
            Sign::Minus => Some(Self {
                position: -position,
                weight: -weight,
            }),
            Sign::NoSign => None,
        }
    }

    /// Returns the zero, on the line through two points, of a function with these values at the points.
    pub fn crossing(ends: [&Vector3<BigInt>; 2], values: [&BigInt; 2]) -> Option<Self> {
        let position = ends[0] * values[1].clone() - ends[1] * values[0].clone();
        Self::of_weight(position, values[1] - values[0])
    }

    /// Returns the common zero of three functions, if it is unique.
    pub fn common_zero([a, b, c]: [&Affine; 3]) -> Option<Self> {
        let (bc, ca, ab) = (
            b.gradient.cross(&c.gradient),
            c.gradient.cross(&a.gradient),
            a.gradient.cross(&b.gradient),
        );
        let weight = a.gradient.dot(&bc);
        let position = bc * a.offset.clone() + ca * b.offset.clone() + ab * c.offset.clone();
        Self::of_weight(-position, weight)
    }

    /// Rounds the point to a number of bits below the lattice.
    pub fn fine(&self, bits: u32) -> Vector3<BigInt> {
        self.position.map(|x| (x << bits) / &self.weight)
    }
}

impl Affine {
    /// Returns a function that is zero on the plane through three points.
    pub fn vanishing_at([a, b, c]: [&Vector3<BigInt>; 3]) -> Self {
        let gradient = (b - a).cross(&(c - a));
        let offset = -gradient.dot(a);
        Self { gradient, offset }
    }

    /// Returns the value at a lattice point.
    pub fn at(&self, point: &Vector3<BigInt>) -> BigInt {
        self.gradient.dot(point) + &self.offset
    }

    /// Returns the sign of the value.
    pub fn sign_at(&self, point: &Point) -> Sign {
        (self.gradient.dot(&point.position) + &self.offset * &point.weight).sign()
    }

    pub fn times(&self, factor: &BigInt) -> Self {
        Self {
            gradient: &self.gradient * factor.clone(),
            offset: &self.offset * factor,
        }
    }

    pub fn plus(&self, other: &Self) -> Self {
        Self {
            gradient: &self.gradient + &other.gradient,
            offset: &self.offset + &other.offset,
        }
    }

    /// Returns the function for coordinates in units smaller by a number of bits. Values grow by the same number of bits.
    pub fn refined(&self, bits: u32) -> Self {
        Self {
            gradient: self.gradient.clone(),
            offset: &self.offset << bits,
        }
    }
}
