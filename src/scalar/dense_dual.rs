use std::array;
use std::fmt;
use std::ops::{
    Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign,
};

/// A value and its first derivatives with respect to `N` variables, in a plain array.
///
/// It represents the same numbers as num-dual's `DualSVec64<N>`, and works in every function that
/// takes a [`Scalar`](super::Scalar). A constant stores `N` zeros instead of a flag that it has no
/// derivatives. Therefore no operation branches, and all operations are inlined in any build
/// profile. The real parts of operators have the same bits as in `f64`. Comparisons use real parts
/// only.
///
/// ```
/// use hydroelastic::scalar::{DenseDual, Scalar};
///
/// fn area<T: Scalar>(width: T, height: T) -> T {
///     width * height
/// }
/// let width = DenseDual::<2>::variable(3.0, 0);
/// let height = DenseDual::<2>::variable(5.0, 1);
/// let area = area(width, height);
/// assert_eq!((area.re, area.eps), (15.0, [5.0, 3.0]));
/// ```
#[derive(Debug, Clone, Copy)]
pub struct DenseDual<const N: usize> {
    /// The value.
    pub re: f64,
    /// Derivatives of the value with respect to each variable.
    pub eps: [f64; N],
}

impl<const N: usize> DenseDual<N> {
    /// Creates a number from a value and its derivatives.
    #[inline]
    #[must_use]
    pub const fn new(re: f64, eps: [f64; N]) -> Self {
        Self { re, eps }
    }

    /// Creates the variable with the given index. Its derivative with respect to itself is 1. If
    /// `index` is at least `N`, the result is a constant.
    #[inline]
    #[must_use]
    pub fn variable(value: f64, index: usize) -> Self {
        Self::new(value, array::from_fn(|i| f64::from(u8::from(i == index))))
    }

    /// Creates a number whose derivatives are zero.
    #[inline]
    pub(super) const fn constant(value: f64) -> Self {
        Self::new(value, [0.0; N])
    }

    /// Applies the chain rule to f(x), where x is this number. `value` is f(re), and `slope` is
    /// f′(re).
    #[inline]
    pub(super) fn chained(&self, value: f64, slope: f64) -> Self {
        Self::new(value, self.eps.map(|eps| eps * slope))
    }

    /// Applies the chain rule to f(x, y), where x is this number and y is `other`. `slopes` are the
    /// partial derivatives with respect to x and y.
    #[inline]
    fn chained_with(&self, other: &Self, value: f64, slopes: [f64; 2]) -> Self {
        let eps = |i: usize| self.eps[i] * slopes[0] + other.eps[i] * slopes[1];
        Self::new(value, array::from_fn(eps))
    }

    #[inline]
    fn sum(&self, other: &Self) -> Self {
        let eps = array::from_fn(|i| self.eps[i] + other.eps[i]);
        Self::new(self.re + other.re, eps)
    }

    #[inline]
    fn difference(&self, other: &Self) -> Self {
        let eps = array::from_fn(|i| self.eps[i] - other.eps[i]);
        Self::new(self.re - other.re, eps)
    }

    #[inline]
    fn product(&self, other: &Self) -> Self {
        self.chained_with(other, self.re * other.re, [other.re, self.re])
    }

    #[inline]
    fn quotient(&self, other: &Self) -> Self {
        let (quotient, inverse) = (self.re / other.re, other.re.recip());
        self.chained_with(other, quotient, [inverse, -quotient * inverse])
    }

    /// Returns x − y·trunc(x/y). The truncated quotient has derivative zero.
    #[inline]
    fn remainder(&self, other: &Self) -> Self {
        let rounded = (self.re / other.re).trunc();
        self.chained_with(other, self.re % other.re, [1.0, -rounded])
    }
}

/// Implements a binary operator, with the right operand by value and by reference.
macro_rules! operator {
    ($Trait:ident::$method:ident, $function:ident) => {
        impl<const N: usize> $Trait for DenseDual<N> {
            type Output = Self;
            #[inline]
            fn $method(self, other: Self) -> Self {
                self.$function(&other)
            }
        }

        impl<const N: usize> $Trait<&Self> for DenseDual<N> {
            type Output = Self;
            #[inline]
            fn $method(self, other: &Self) -> Self {
                self.$function(other)
            }
        }
    };
}

operator!(Add::add, sum);
operator!(Sub::sub, difference);
operator!(Mul::mul, product);
operator!(Div::div, quotient);
operator!(Rem::rem, remainder);

/// Implements an assignment operator by the binary operator.
macro_rules! assignment {
    ($Assign:ident::$assign:ident, $function:ident) => {
        impl<const N: usize> $Assign for DenseDual<N> {
            #[inline]
            fn $assign(&mut self, other: Self) {
                *self = self.$function(&other);
            }
        }
    };
}

assignment!(MulAssign::mul_assign, product);
assignment!(DivAssign::div_assign, quotient);
assignment!(RemAssign::rem_assign, remainder);

impl<const N: usize> AddAssign for DenseDual<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.re += other.re;
        for (sum, eps) in self.eps.iter_mut().zip(&other.eps) {
            *sum += eps;
        }
    }
}

impl<const N: usize> SubAssign for DenseDual<N> {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        self.re -= other.re;
        for (difference, eps) in self.eps.iter_mut().zip(&other.eps) {
            *difference -= eps;
        }
    }
}

/// Implements an operator with a constant on the right, and its assignment form.
macro_rules! constant_operator {
    ($Trait:ident::$method:ident, $Assign:ident::$assign:ident, $function:expr) => {
        impl<const N: usize> $Trait<f64> for DenseDual<N> {
            type Output = Self;
            #[inline]
            fn $method(self, constant: f64) -> Self {
                let function: fn(&Self, f64) -> Self = $function;
                function(&self, constant)
            }
        }

        impl<const N: usize> $Assign<f64> for DenseDual<N> {
            #[inline]
            fn $assign(&mut self, constant: f64) {
                *self = $Trait::$method(*self, constant);
            }
        }
    };
}

constant_operator!(Add::add, AddAssign::add_assign, |x, c| Self::new(
    x.re + c,
    x.eps
));
constant_operator!(Sub::sub, SubAssign::sub_assign, |x, c| Self::new(
    x.re - c,
    x.eps
));
constant_operator!(Mul::mul, MulAssign::mul_assign, |x, c| x
    .chained(x.re * c, c));
constant_operator!(Div::div, DivAssign::div_assign, |x, c| x
    .chained(x.re / c, c.recip()));
constant_operator!(Rem::rem, RemAssign::rem_assign, |x, c| Self::new(
    x.re % c,
    x.eps
));

impl<const N: usize> Neg for DenseDual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self::new(-self.re, self.eps.map(Neg::neg))
    }
}

impl<const N: usize> fmt::Display for DenseDual<N> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} + {:?}ε", self.re, self.eps)
    }
}
