//! What one polygon contributes to the derivatives of a number by the cells that it lies in.

use super::SurfaceLaw;
use super::polygon::{CutPolygon, CutSurface, PolygonSource};
use super::surface_law::RelativeMotion;
use crate::geometry::AffineField;
use crate::narrow_phase::Cut;
use nalgebra::{Matrix3, Vector3, Vector6};

/// What a polygon contributes by the corners of a cell (in A's axes) and their extents.
#[derive(Debug, Clone, Copy)]
pub(super) struct OfCell {
    pub by_corners: [Vector3<f64>; 4],
    pub by_extents: [f64; 4],
}

/// What a polygon contributes by the two cells that it lies in.
#[derive(Debug, Clone, Copy)]
pub(super) struct PolygonShare(pub [OfCell; 2]);

/// The barycentric coordinates of the two cells, in A's frame.
pub(super) type Barycentric = [[AffineField; 4]; 2];

impl CutSurface<'_, f64> {
    /// What each polygon contributes, with its cells.
    pub fn shape_shares<const N: usize>(
        &self,
        moving: Option<(&SurfaceLaw, &RelativeMotion<f64>)>,
        covectors: &[Vector6<f64>; N],
    ) -> Vec<([usize; 2], [PolygonShare; N])> {
        let source = &self.source;
        self.sum_of_cuts(|shares: &mut Vec<_>, cut| {
            let polygon = source.polygon(cut);
            let has_area = polygon.has_area() && polygon.weights.have_area();
            if !has_area && moving.is_none() {
                return;
            }
            let barycentric = source.barycentric(cut);
            let mut of_polygon = [PolygonShare::none(); N];
            if has_area {
                for (share, covector) in of_polygon.iter_mut().zip(covectors) {
                    share.add_elastic(&polygon, covector, source.moduli(), &barycentric);
                }
            }
            if let Some(moving) = moving {
                let cut = (cut, &polygon, &barycentric);
                source.add_traction_shares(cut, moving, covectors, &mut of_polygon);
            }
            shares.push((cut.tets, of_polygon));
        })
    }
}

impl PolygonSource<'_, f64> {
    fn barycentric(&self, cut: &Cut) -> Barycentric {
        let [a, b] = [self.pair.tet_a(cut.tets[0]), self.pair.tet_b(cut.tets[1])];
        let of_b = b
            .barycentric
            .each_ref()
            .map(|field| field.posed(&self.pose_ab));
        [a.barycentric, of_b]
    }
}

/// A linear function of functions f that are affine on a polygon's plane: `value`·f(`at`) + `slope`·∇f.
#[derive(Debug, Clone, Copy)]
pub(super) struct AffineForm {
    pub at: Vector3<f64>,
    pub value: f64,
    pub slope: Vector3<f64>,
}

impl AffineForm {
    fn of(&self, f: &AffineField) -> f64 {
        self.value * f.at(&self.at) + self.slope.dot(&f.gradient)
    }

    fn scaled(&self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            slope: self.slope * factor,
            ..*self
        }
    }
}

impl PolygonShare {
    fn none() -> Self {
        let none = OfCell {
            by_corners: [Vector3::zeros(); 4],
            by_extents: [0.0; 4],
        };
        Self([none; 2])
    }

    /// Adds the elastic part, for a number with this derivative by the wrench on A about A's origin: with the velocity u of the
    /// twist that the covector is, ∫ f ∇p_A·u dA as p_B grows by f|g|, and −∫ f ∇p_B·u dA as p_A does.
    fn add_elastic(
        &mut self,
        polygon: &CutPolygon<f64>,
        covector: &Vector6<f64>,
        moduli: [f64; 2],
        barycentric: &Barycentric,
    ) {
        let [slope_a, slope_b] = [&polygon.pressure_a.gradient, &polygon.plane.slopes[1]];
        let by_growth_b = polygon.flow(slope_a, covector);
        self.add_growth_of_b(polygon, moduli[1], [&by_growth_b; 2], &barycentric[1]);
        let by_growth_a = polygon.flow(slope_b, covector).scaled(-1.0);
        self.add_growth_of_a(polygon, moduli[0], [&by_growth_a; 2], &barycentric[0]);
    }

    /// Adds what follows from changes of p_B/|g|, by motions of the corners and by their extents.
    pub fn add_growth_of_b(
        &mut self,
        polygon: &CutPolygon<f64>,
        modulus: f64,
        by_growth: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        let plane = &polygon.plane;
        self.0[1].add(
            &plane.slopes[1],
            modulus * plane.yielding,
            by_growth,
            barycentric,
        );
    }

    /// Adds what follows from changes of p_A, by motions of the corners and by their extents.
    pub fn add_growth_of_a(
        &mut self,
        polygon: &CutPolygon<f64>,
        modulus: f64,
        by_growth: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        self.0[0].add(
            &polygon.pressure_a.gradient,
            modulus,
            by_growth,
            barycentric,
        );
    }

    /// Adds what follows from the motion of a face (0 to 3 of A, 4 to 7 of B) along its normal.
    pub fn add_motion_of_face(
        &mut self,
        face: usize,
        normal: &Vector3<f64>,
        by_speed: &AffineForm,
        barycentric: &Barycentric,
    ) {
        let (body, opposite) = (face / 4, face % 4);
        for corner in (0..4).filter(|&corner| corner != opposite) {
            let speed = by_speed.of(&barycentric[body][corner]);
            self.0[body].by_corners[corner] += normal * speed;
        }
    }
}

impl OfCell {
    /// In other axes.
    pub fn rotated(&self, rotation: &Matrix3<f64>) -> Self {
        Self {
            by_corners: self.by_corners.map(|by_corner| rotation * by_corner),
            ..*self
        }
    }

    /// A corner that moves by δ takes λ `gradient`·δ from the field, and its extent adds λ `modulus`.
    fn add(
        &mut self,
        gradient: &Vector3<f64>,
        modulus: f64,
        [by_motion, by_extent]: [&AffineForm; 2],
        barycentric: &[AffineField; 4],
    ) {
        for (corner, coordinate) in barycentric.iter().enumerate() {
            self.by_corners[corner] -= gradient * by_motion.of(coordinate);
            self.by_extents[corner] += modulus * by_extent.of(coordinate);
        }
    }
}

impl CutPolygon<f64> {
    /// f ↦ ∫ f a·u dA, where u is the velocity of a twist about the origin (its moment, then its force).
    fn flow(&self, a: &Vector3<f64>, twist: &Vector6<f64>) -> AffineForm {
        let (moment, force) = (twist.fixed_rows::<3>(0), twist.fixed_rows::<3>(3));
        let moments = &self.moments;
        let weight = self.weights.moving.area();
        let at_reference = a.dot(&(force + moment.cross(&moments.reference)));
        let gradient = a.cross(&moment);
        let value = at_reference * moments.area + gradient.dot(&moments.first);
        AffineForm {
            at: moments.reference,
            value: value * weight,
            slope: (moments.first * at_reference + moments.second * gradient) * weight,
        }
    }
}
