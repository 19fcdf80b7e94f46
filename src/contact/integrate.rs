//! Integration over a contact surface: the division of the work between threads, and the order in which partial sums are added.

use super::polygon_source::PolygonSource;
use super::sums::PartialSum;
use crate::geometry::set_bits;
use crate::lanes::ROW;
use crate::narrow_phase::Cut;
use crate::parallel;
use crate::scalar::{Scalar, carries_derivatives};
use crate::search::{GenericPairs, SearchResult};
use std::marker::PhantomData;

/// Number of polygons in a piece of work if they are integrated one by one, which takes about 20 µs in `f64`.
const SINGLE: usize = 32;

/// Largest number of octets in a piece of work.
const MOST_OCTETS: usize = 256;

/// The polygons of octets that are left to be added one by one. Each octet has a bit for each index.
pub(super) type Remainder = [u8];

/// The result of a search, and the source that computes the polygons with the same tolerance for coincidences.
pub(super) struct CutSurface<'a, T> {
    pub source: PolygonSource<'a, T>,
    pub search_result: SearchResult,
}

/// A quantity that is summed over the polygons of a contact surface.
pub(super) trait Integrand<T>: Sync {
    type Sum: PartialSum;

    /// Whether octets of large contacts are integrated as soon as they are found. They are integrated again if faces are later found to
    /// coincide, so the integral should be cheap.
    const IS_SPILLED: bool = false;

    /// Number of octets in a piece of work for a thread, at most [`MOST_OCTETS`].
    const OCTETS: usize;

    /// Adds the polygon of a cut.
    fn add(&self, source: &PolygonSource<T>, cut: &Cut, sum: &mut Self::Sum);

    /// Adds the polygons of cuts.
    fn add_cuts(&self, source: &PolygonSource<T>, cuts: &[Cut], sum: &mut Self::Sum) {
        for cut in cuts {
            self.add(source, cut, sum);
        }
    }

    /// Adds the polygons of octets, several at a time, for scalars without derivatives. May skip polygons and set their bits in
    /// `remainder`, which is zero at first. The caller then adds them one by one.
    fn add_octets(
        &self,
        source: &PolygonSource<T>,
        generic: GenericPairs,
        remainder: &mut Remainder,
        sum: &mut Self::Sum,
    );
}

impl<T: Scalar> PolygonSource<'_, T> {
    /// Adds the integral over generic polygons to `sum`.
    pub fn add_generic<I: Integrand<T>>(
        &self,
        generic: GenericPairs,
        integrand: &I,
        sum: &mut I::Sum,
    ) {
        const { assert!(I::OCTETS <= MOST_OCTETS) };
        let are_single = carries_derivatives::<T>();
        let piece = |generic: GenericPairs| {
            let (mut sum, mut remainder) = (I::Sum::empty(), [0; MOST_OCTETS]);
            let remainder = &mut remainder[..generic.octets.len()];
            if are_single {
                mark_all(generic, remainder);
            } else {
                integrand.add_octets(self, generic, remainder, &mut sum);
            }
            for (octet, remainder) in generic.octets.iter().zip(remainder) {
                for index in set_bits(*remainder) {
                    let cut = generic.cut(octet, index, &self.pair);
                    integrand.add(self, &cut, &mut sum);
                }
            }
            sum
        };
        let length = if are_single { SINGLE / ROW } else { I::OCTETS };
        let piece = |octets: &[_]| piece(generic.part(octets));
        parallel::for_pieces(generic.octets, length, piece, |piece| sum.merge(piece));
    }
}

impl<T: Scalar> CutSurface<'_, T> {
    /// Integrates over the surface.
    pub fn integral<I: Integrand<T>>(&self, integrand: &I) -> I::Sum {
        self.integral_after(I::Sum::empty(), integrand)
    }

    /// Returns the integral over the surface plus `sum`, the integral over octets that were spilled.
    pub fn integral_after<I: Integrand<T>>(&self, mut sum: I::Sum, integrand: &I) -> I::Sum {
        let piece = |cuts: &[Cut]| {
            let mut sum = I::Sum::empty();
            integrand.add_cuts(&self.source, cuts, &mut sum);
            sum
        };
        parallel::for_pieces(self.search_result.cuts(), SINGLE, piece, |piece| {
            sum.merge(piece);
        });
        self.source
            .add_generic(self.search_result.generic(), integrand, &mut sum);
        sum
    }

    /// Adds up the contributions of all polygons as cuts, one by one.
    pub fn sum_of_cuts<S: PartialSum>(&self, add: impl Fn(&mut S, &Cut) + Sync) -> S {
        self.integral(&OneByOne {
            add,
            sum: PhantomData,
        })
    }
}

/// A sum over cuts, to which a closure adds each cut.
struct OneByOne<F, S> {
    add: F,
    sum: PhantomData<fn() -> S>,
}

impl<T: Scalar, S: PartialSum, F: Fn(&mut S, &Cut) + Sync> Integrand<T> for OneByOne<F, S> {
    type Sum = S;

    const OCTETS: usize = SINGLE / ROW;

    fn add(&self, _: &PolygonSource<T>, cut: &Cut, sum: &mut S) {
        (self.add)(sum, cut);
    }

    fn add_octets(
        &self,
        _: &PolygonSource<T>,
        generic: GenericPairs,
        remainder: &mut Remainder,
        _: &mut S,
    ) {
        mark_all(generic, remainder);
    }
}

/// Marks all polygons to be added one by one.
fn mark_all(generic: GenericPairs, remainder: &mut Remainder) {
    for (octet, remainder) in generic.octets.iter().zip(remainder) {
        *remainder = octet.polygons();
    }
}
