//! Sums over a contact surface: over the special cuts one by one, over the generic ones, which are in octets, one by one or
//! several at a time.

use super::polygon::{CutPolygon, CutSurface};
use super::sums::OverOctets;
use super::sums::PartialSum;
use crate::lanes::ROW;
use crate::narrow_phase::{Cut, ELASTIC_COINCIDENCE, Octet, Weights};
use crate::scalar::{Scalar, carries_derivatives, real_part};
use crate::threads;

/// Cuts that are integrated by themselves, in one thread: some 20 µs of work in `f64`.
const PIECE: usize = 32;

impl<T: Scalar> CutSurface<'_, T> {
    /// Adds up what cuts contribute, all of them one by one.
    pub fn sum_of_cuts<S: PartialSum>(&self, add: impl Fn(&mut S, &Cut) + Sync) -> S {
        let mut sum = self.sum_of_special_cuts(&add);
        let piece = |octets: &[Octet]| {
            let mut sum = S::empty();
            for octet in octets {
                let visit = |cut: &Cut| add(&mut sum, cut);
                self.found.visit_cuts_of(octet, &self.source.pair, visit);
            }
            sum
        };
        let octets_per_piece = PIECE / ROW;
        threads::for_pieces(self.found.octets(), octets_per_piece, piece, |piece| {
            sum.merge(piece);
        });
        sum
    }

    /// Adds up what those cuts contribute that are not in octets.
    pub fn sum_of_special_cuts<S: PartialSum>(&self, add: &(impl Fn(&mut S, &Cut) + Sync)) -> S {
        let piece = |cuts: &[Cut]| {
            let mut sum = S::empty();
            for cut in cuts {
                add(&mut sum, cut);
            }
            sum
        };
        let mut sum = S::empty();
        threads::for_pieces(self.found.cuts(), PIECE, piece, |piece| sum.merge(piece));
        sum
    }

    /// Whether some whole polygon lies so near to a face of B that they count as coincident.
    pub fn has_polygons_on_faces(&self) -> bool {
        self.found.flatness().is_within(ELASTIC_COINCIDENCE)
    }

    /// Whether nothing is pressed on.
    pub fn is_empty(&self) -> bool {
        let is_pressed = |cut: &Cut| self.source.pressed_polygon(cut).is_some();
        let has_special = self.found.cuts().iter().any(is_pressed);
        !has_special
            && self
                .found
                .octets()
                .iter()
                .all(|octet| octet.polygons() == 0)
    }

    /// Whether the surfaces touch face to face on some area, without pressure.
    pub fn touches(&self) -> bool {
        let mut touches = self.found.cuts().iter().filter(|cut| cut.is_touch());
        touches.any(|cut| self.source.polygon(cut).has_area())
    }

    /// Adds up the contact polygons; for scalars with derivatives also those of zero area, whose area may have a derivative.
    pub fn sum<S: PartialSum>(&self, add: impl Fn(&mut S, &CutPolygon<T>) + Sync) -> S {
        self.sum_of_cuts(|sum, cut| self.add_where(Weights::has_still_area, &add, sum, cut))
    }

    /// Adds up the polygons whose weights `counts` asks for: those in octets several at a time, unless they carry derivatives of
    /// their own. Weights of generic polygons are whole, so that `counts` is not asked about them.
    pub fn sum_of_moments<S: OverOctets>(
        &self,
        counts: impl Fn(Weights) -> bool + Sync,
        add: impl Fn(&mut S, &CutPolygon<T>) + Sync,
    ) -> S {
        let add = |sum: &mut S, cut: &Cut| self.add_where(&counts, &add, sum, cut);
        if carries_derivatives::<T>() {
            return self.sum_of_cuts(add);
        }
        let mut sum = self.sum_of_special_cuts(&add);
        sum.merge(S::over(self.found.octets()));
        sum
    }

    /// Adds the contact polygon of a cut if it counts.
    pub fn add_where<S>(
        &self,
        counts: impl Fn(Weights) -> bool,
        add: impl Fn(&mut S, &CutPolygon<T>),
        sum: &mut S,
        cut: &Cut,
    ) {
        if counts(cut.weights()) {
            let polygon = self.source.polygon(cut);
            if carries_derivatives::<T>() || polygon.has_area() {
                add(sum, &polygon);
            }
        }
    }

    /// ∫ p dA (N).
    pub fn load(&self) -> f64 {
        self.sum(|sum: &mut f64, polygon| *sum += real_part(polygon.pressure_integrals().0))
    }

    /// The part of it that is on polygons which with so many octaves would be taken to lie where the pressure is zero. Where
    /// p_A − p_B counts as zero, so does the height of the plane above a face, which is the greater the more alike the fields
    /// are.
    pub fn load_at_zero(&self, octaves: i32) -> f64 {
        let pair = self.source.pair.with_near_coincidences(octaves);
        self.sum_of_cuts(|sum: &mut f64, cut| {
            let Some(polygon) = self.source.pressed_polygon(cut) else {
                return;
            };
            let slopes = polygon
                .plane
                .slopes
                .map(|slope| slope.map(real_part).norm());
            let by_excess = slopes[0].min(slopes[1]).max(1.0);
            let zero = pair.margin() * self.source.sensitivity(cut) * by_excess;
            let is_zero = |corner| real_part(polygon.pressure.at(corner)) <= zero;
            if polygon.polygon.corners().iter().all(is_zero) {
                *sum += real_part(polygon.pressure_integrals().0);
            }
        })
    }
}
