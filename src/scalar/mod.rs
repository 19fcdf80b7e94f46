//! The number type that every quantity is generic over: `f64`, or a dual number over `f64`.
//!
//! Shapes are `f64`. Poses, moduli and everything computed from them are `T: Scalar`. There are two
//! conversions only. [`lift`] converts a constant to `T`. [`real_part`] returns the value of a `T`,
//! on which a decision may depend. Decisions (culling, signs, the corners that a clip keeps) use
//! real parts only, so they never touch a derivative.
//!
//! ```
//! use hydroelastic::scalar::{Scalar, lift, real_part};
//!
//! fn spring_energy<T: Scalar>(stretch: T) -> T {
//!     stretch * stretch * lift::<T>(0.5)
//! }
//! let (energy, force) = num_dual::first_derivative(spring_energy, 3.0);
//! assert_eq!((energy, force), (4.5, 3.0));
//! assert_eq!(real_part(spring_energy(3.0)), 4.5);
//! ```

mod dense_dual;
mod elementary;
mod number_traits;
pub(crate) mod portable;
mod split_mix;

pub use dense_dual::DenseDual;
pub(crate) use split_mix::SplitMix64;

use nalgebra::{Matrix3, Vector3};
use num_dual::DualNum;
use std::marker::PhantomData;

/// A real number, or a dual number over `f64` of any kind and order.
///
/// Implemented for `f64`, for [`DenseDual`], and for num-dual's `Dual64`, `DualSVec64<N>`,
/// `Dual2_64`, `Dual2SVec64<N>`, `Dual3_64`, hyper-dual and nested dual types.
pub trait Scalar: DualNum<Primitive = f64> + Copy + Send + Sync {}

impl<T: DualNum<Primitive = f64> + Copy + Send + Sync> Scalar for T {}

/// Returns a constant: the value, with all derivatives zero.
#[inline]
#[must_use]
pub fn lift<T: Scalar>(value: f64) -> T {
    T::from(value)
}

/// Returns the value without its derivatives.
#[inline]
#[must_use]
pub fn real_part<T: Scalar>(value: T) -> f64 {
    value.re()
}

/// Returns a constant vector: [`lift`] for each component.
#[inline]
#[must_use]
pub fn lift_vector<T: Scalar>(vector: &Vector3<f64>) -> Vector3<T> {
    vector.map(lift)
}

/// Returns the vector without its derivatives: [`real_part`] for each component.
#[inline]
#[must_use]
pub fn real_vector<T: Scalar>(vector: &Vector3<T>) -> Vector3<f64> {
    vector.map(real_part)
}

/// Returns the length of a vector. At zero the derivative does not exist, and the computed
/// derivatives are not finite.
///
/// nalgebra's `norm` requires `ComplexField`, which dual numbers do not implement.
///
/// ```
/// use hydroelastic::scalar::norm;
/// use nalgebra::vector;
///
/// assert_eq!(norm(&vector![3.0, 0.0, 4.0]), 5.0);
/// ```
#[inline]
#[must_use]
pub fn norm<T: Scalar>(vector: &Vector3<T>) -> T {
    vector.dot(vector).sqrt()
}

/// Returns whether `T` carries derivatives. False for `f64` only.
#[inline]
#[must_use]
pub(crate) const fn carries_derivatives<T: Scalar>() -> bool {
    T::NDERIV > 0
}

/// Computes the scalar product with a constant vector, with three products `T * f64` instead of `T
/// * T`.
#[inline]
#[must_use]
pub(crate) fn dot_constant<T: Scalar>(vector: &Vector3<T>, constant: &Vector3<f64>) -> T {
    vector.x * constant.x + vector.y * constant.y + vector.z * constant.z
}

/// Computes the cross product with a constant vector, with six products `T * f64`.
#[inline]
#[must_use]
pub(crate) fn cross_constant<T: Scalar>(
    vector: &Vector3<T>,
    constant: &Vector3<f64>,
) -> Vector3<T> {
    Vector3::new(
        vector.y * constant.z - vector.z * constant.y,
        vector.z * constant.x - vector.x * constant.z,
        vector.x * constant.y - vector.y * constant.x,
    )
}

/// Multiplies a vector by a constant matrix, with nine products `T * f64`.
#[inline]
#[must_use]
pub(crate) fn constant_times<T: Scalar>(
    constant: &Matrix3<f64>,
    vector: &Vector3<T>,
) -> Vector3<T> {
    let row = |i: usize| dot_constant(vector, &constant.row(i).transpose());
    Vector3::new(row(0), row(1), row(2))
}

/// Multiplies a vector by a matrix. nalgebra's product copies its operands, which is slow for dual
/// numbers with many derivatives.
#[inline]
#[must_use]
pub(crate) fn times<T: Scalar>(matrix: &Matrix3<T>, vector: &Vector3<T>) -> Vector3<T> {
    let row = |i: usize| {
        matrix[(i, 0)] * vector.x + matrix[(i, 1)] * vector.y + matrix[(i, 2)] * vector.z
    };
    Vector3::new(row(0), row(1), row(2))
}

/// Returns the difference of a number from its real part: the same derivatives, and a value of
/// zero.
#[inline]
#[must_use]
pub(crate) fn change<T: Scalar>(value: T) -> T {
    value - real_part(value)
}

/// Properties of a scalar type that are known at compile time.
///
/// If a branch depends on such a constant, the branch not taken is not compiled. For example, the
/// contact computation is not compiled for the wide dual numbers of rollouts.
pub(crate) struct Order<T>(PhantomData<T>);

impl<T: Scalar> Order<T> {
    /// Whether `T` has first derivatives and no others. The chain rule is then linear in the
    /// derivatives.
    pub(crate) const IS_FIRST: bool = T::NDERIV == 1;
}
