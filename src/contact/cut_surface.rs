//! Properties of a contact surface.

use super::integrate::CutSurface;
use super::outline::at;
use crate::narrow_phase::{Cut, ELASTIC_COINCIDENCE, Weights};
use crate::scalar::{Scalar, real_part, real_vector};
use nalgebra::Vector3;

impl<T: Scalar> CutSurface<'_, T> {
    /// Returns whether a whole polygon lies so near to a face of B that they count as coincident.
    pub fn has_polygons_on_faces(&self) -> bool {
        self.search_result
            .coplanarity()
            .is_within(ELASTIC_COINCIDENCE)
    }

    /// Returns whether the contact surface has no polygons.
    pub fn is_empty(&self) -> bool {
        let is_pressed = |cut: &Cut| self.source.is_pressed(cut);
        !self.search_result.cuts().iter().any(is_pressed)
            && !self.search_result.generic().have_polygons()
    }

    /// Returns whether the surfaces touch face to face over some area, without pressure.
    pub fn touches(&self) -> bool {
        let mut touches = self
            .search_result
            .cuts()
            .iter()
            .filter(|cut| cut.is_touch());
        touches.any(|cut| {
            let polygon = self.source.polygon(cut);
            polygon.is_some_and(|polygon| polygon.has_area())
        })
    }

    /// Returns the number of contact polygons, including those on the surfaces of both bodies.
    pub fn polygon_count(&self) -> usize {
        self.sum_of_cuts(|count: &mut usize, cut| {
            let polygon = self.source.counted_polygon(cut, Weights::has_still_area);
            *count += usize::from(polygon.is_some());
        })
    }

    /// Returns ∫ p dA (N).
    pub fn load(&self) -> f64 {
        self.sum_of_cuts(|load: &mut f64, cut| {
            let polygon = self.source.counted_polygon(cut, Weights::has_still_area);
            *load += polygon.map_or(0.0, |polygon| real_part(polygon.load()));
        })
    }

    /// Returns the part of the load (N) on polygons that would count as having zero pressure with this number of octaves. If p_A − p_B
    /// counts as zero, so does the height of the plane above a face. This height is larger if the fields are more alike.
    pub fn load_at_zero(&self, octaves: i32) -> f64 {
        let pair = self.source.pair.with_near_coincidences(octaves);
        self.sum_of_cuts(|sum: &mut f64, cut| {
            let Some(polygon) = self.source.pressed_polygon(cut) else {
                return;
            };
            let slopes = polygon
                .plane
                .slopes
                .map(|slope| real_vector(&Vector3::from(slope)).norm());
            let by_excess = slopes[0].min(slopes[1]).max(1.0);
            let zero = pair.margin() * self.source.sensitivity(cut) * by_excess;
            let is_zero = |corner| real_part(at(&polygon.plane.pressure, corner)) <= zero;
            if polygon.outline.corners().iter().all(is_zero) {
                *sum += real_part(polygon.load());
            }
        })
    }
}
