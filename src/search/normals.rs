//! The mean directions of the contact polygons that were found so far.

use crate::lanes::space::vector_at;
use crate::narrow_phase::{Cut, Octet, RelativePair};
use nalgebra::{Matrix3, Vector3};

/// Slopes up to this fraction of the largest may be round-off.
const FLATNESS: f64 = 1e-10;

/// Sums over the unit normals of the contact polygons found so far.
#[derive(Default)]
pub(super) struct Normals {
    /// Σ n.
    sum: Vector3<f64>,
    /// Σ n·nᵀ.
    squares: Matrix3<f64>,
}

impl Normals {
    fn add(&mut self, normal: &Vector3<f64>) {
        self.sum += normal;
        self.squares += normal * normal.transpose();
    }

    /// Adds the generic polygons of an octet.
    pub fn add_octet(&mut self, octet: &Octet) {
        for index in (0..octet.tets().len()).filter(|&index| octet.has_polygon(index)) {
            self.add(&vector_at(&octet.axes[2], index));
        }
    }

    /// Adds the polygons of special pairs.
    pub fn add_cuts(&mut self, cuts: &[Cut], pair: &RelativePair) {
        for cut in cuts {
            let pressure_a = pair.tet_a(cut.tets[0]).extent.gradient * pair.scales[0];
            self.add(&(pressure_a - cut.field_b.gradient).normalize());
        }
    }

    /// Returns the directions u and d for the search for [extremal pairs](super::extremal_pairs), such that its conditions (1) and (2)
    /// exclude most of the known contact surface. u is the direction that is most nearly perpendicular to the normals of this surface. d is the
    /// direction perpendicular to u in which p_A − p_B rises most on the surface.
    pub fn directions(&self) -> [Vector3<f64>; 2] {
        let axes = self.squares.symmetric_eigen();
        let up: Vector3<f64> = axes.eigenvectors.column(axes.eigenvalues.imin()).into();
        let any = up.cross(&Vector3::ith(up.iamin(), 1.0));
        let rise = (self.sum - up * up.dot(&self.sum)).try_normalize(FLATNESS);
        [up, rise.unwrap_or_else(|| any.normalize())]
    }
}
