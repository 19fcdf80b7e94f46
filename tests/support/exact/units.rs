//! Powers of two of which all numbers of a pair are integer multiples.

use hydroelastic::contact::ContactPair;
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use num_bigint::BigInt;
use num_traits::Float;

/// Binary exponents of the units of a pair's numbers.
pub struct Units {
    /// Unit of given coordinates (m).
    coordinate: i32,
    /// Unit of the entries of rotations.
    pub rotation: i32,
    /// Unit of coordinates in A's frame (m), which contain a product of two rotations.
    pub length: i32,
    modulus: i32,
    extent: i32,
    /// Unit of pressures (Pa).
    pub pressure: i32,
}

impl Units {
    pub fn of(pair: &ContactPair) -> Self {
        let bodies = [pair.a(), &pair.b().body().unwrap()];
        let poses = bodies.map(|body| *body.pose());
        let fields = bodies.map(|body| body.shape().field());
        let vertices = fields.iter().flat_map(|field| field.mesh().vertices());
        let translations = poses.iter().map(Pose::translation);
        let coordinate = finest(vertices.chain(translations).flatten().copied());
        let rotation = finest(poses.iter().flat_map(Pose::rotation).copied());
        let modulus = finest([pair.a().modulus(), pair.b().modulus().unwrap()]);
        let extent = finest(
            fields
                .iter()
                .flat_map(|field| field.extents().iter())
                .copied(),
        );
        Self {
            coordinate,
            rotation,
            length: coordinate + 2 * rotation,
            modulus,
            extent,
            pressure: modulus + extent,
        }
    }

    pub fn rotation(&self, pose: &Pose) -> Matrix3<BigInt> {
        pose.rotation().map(|entry| whole(entry, self.rotation))
    }

    /// Converts a point that is given in A's frame.
    pub fn point_of_a(&self, point: &Vector3<f64>) -> Vector3<BigInt> {
        point.map(|x| whole(x, self.length))
    }

    /// Converts a point of B to A's frame: R_Aᵀ·(R_B·x + t_B − t_A).
    pub fn point_of_b(&self, pair: &ContactPair, point: &Vector3<f64>) -> Vector3<BigInt> {
        let [pose_a, pose_b] = [pair.a().pose(), pair.b().pose()];
        let turned = self.rotation(pose_b) * point.map(|x| whole(x, self.coordinate));
        let [from, to] = [pose_a, pose_b].map(|pose| {
            let once = self.coordinate + self.rotation;
            pose.translation().map(|x| whole(x, once))
        });
        self.rotation(pose_a).transpose() * (turned + to - from)
    }

    /// Returns modulus times extent.
    pub fn pressure_of(&self, modulus: f64, extent: f64) -> BigInt {
        whole(modulus, self.modulus) * whole(extent, self.extent)
    }
}

/// Returns the exponent of the largest power of two of which all the numbers, and 1, are integer multiples.
fn finest(numbers: impl IntoIterator<Item = f64>) -> i32 {
    let exponent = |number: f64| {
        let (mantissa, exponent, _) = number.integer_decode();
        match mantissa {
            0 => 0,
            _ => i32::from(exponent) + i32::try_from(mantissa.trailing_zeros()).unwrap(),
        }
    };
    numbers.into_iter().map(exponent).fold(0, i32::min)
}

/// Returns the number in units of 2^exponent. The number must be an integer multiple of the unit.
fn whole(number: f64, exponent: i32) -> BigInt {
    let (mantissa, power, sign) = number.integer_decode();
    if mantissa == 0 {
        return BigInt::ZERO;
    }
    let zeros = i32::try_from(mantissa.trailing_zeros()).unwrap();
    let shift = usize::try_from(i32::from(power) + zeros - exponent).unwrap();
    BigInt::from(i128::from(mantissa >> zeros) * i128::from(sign)) << shift
}

/// Returns the number times 2^exponent as the nearest `f64` or one of its neighbors.
pub fn rounded(number: &BigInt, exponent: i32) -> f64 {
    // More digits than an f64 has, but few enough to be in its range.
    let surplus = number.bits().saturating_sub(100);
    let digits = i128::try_from(number >> surplus).unwrap();
    let exponent = exponent + i32::try_from(surplus).unwrap();
    // The power is applied in two halves, because a single power may be out of range.
    let half = exponent / 2;
    digits as f64 * 2.0_f64.powi(half) * 2.0_f64.powi(exponent - half)
}
