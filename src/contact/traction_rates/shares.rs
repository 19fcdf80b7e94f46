//! What dissipation and friction add to the derivatives by the corners and extents of the cells of a polygon.

use super::edges::Edges;
use super::{Rates, Traction};
use crate::contact::SurfaceLaw;
use crate::contact::plane::PlanePolygon;
use crate::contact::polygon::{CutPolygon, PolygonSource};
use crate::contact::polygon_share::{AffineForm, Barycentric, PolygonShare};
use crate::contact::surface_law::RelativeMotion;
use crate::narrow_phase::{Cut, Weights};
use nalgebra::{Vector3, Vector6};

impl PolygonSource<'_, f64> {
    /// Adds what the law contributes to the derivatives of numbers that have these derivatives by the wrench on A, in A's
    /// axes about A's origin.
    ///
    /// As p_B changes by δ, the plane moves by h = δ/|g|. As p_A does, it moves by −δ/|g|, and the pressure at a fixed point
    /// changes too: where the one follows from K, the other does from −K and ∂t/∂p. Corners move the faces as well, and with them
    /// the edges.
    pub(in crate::contact) fn add_traction_shares<const N: usize>(
        &self,
        (cut, polygon, barycentric): (&Cut, &CutPolygon<f64>, &Barycentric),
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
        covectors: &[Vector6<f64>; N],
        shares: &mut [PolygonShare; N],
    ) {
        let Some(plane) = PlanePolygon::of(polygon, motion) else {
            return;
        };
        let forms = covectors.map(|covector| PlaneForms::of(&plane, &covector));
        let edges = Edges::of(self, (cut, polygon), &plane);
        let rates = Traction::on(&plane, law, |traction| {
            edges.visit_lines_in_motion(|edge, line, share| {
                let flux = traction.along_edge(edge);
                let normal = plane.axes * line.normal;
                for (forms, of_polygon) in forms.iter().zip(&mut *shares) {
                    let by_speed = forms.contracted(&flux, share * line.outwardness);
                    of_polygon.add_motion_of_face(line.face, &normal, &by_speed, barycentric);
                }
            });
            Rates::of(polygon, Some(&edges), traction)
        });
        for (forms, share) in forms.iter().zip(shares) {
            share.add_traction(polygon, (&rates, forms), self.moduli(), barycentric);
        }
    }
}

/// A number's derivative by a wrench about the center of a plane along its axes, and where functions of the plane are in space.
struct PlaneForms<'p> {
    plane: &'p PlanePolygon<f64>,
    covector: Vector6<f64>,
}

impl<'p> PlaneForms<'p> {
    /// From the derivative by the wrench about the origin.
    fn of(plane: &'p PlanePolygon<f64>, covector: &Vector6<f64>) -> Self {
        let moment: Vector3<f64> = covector.fixed_rows::<3>(0).into_owned();
        let force = covector.fixed_rows::<3>(3) + moment.cross(&plane.center);
        let [moment, force] = [moment, force].map(|vector| plane.axes.tr_mul(&vector));
        Self {
            plane,
            covector: Vector6::new(moment.x, moment.y, moment.z, force.x, force.y, force.z),
        }
    }

    /// From wrenches by 1, y₁ and y₂, times a factor.
    fn contracted(&self, wrenches: &[Vector6<f64>; 3], factor: f64) -> AffineForm {
        let [one, y1, y2] = wrenches
            .each_ref()
            .map(|wrench| self.covector.dot(wrench) * factor);
        let axes = &self.plane.axes;
        AffineForm {
            at: self.plane.center,
            value: one,
            slope: axes.column(0) * y1 + axes.column(1) * y2,
        }
    }
}

impl PolygonShare {
    fn add_traction(
        &mut self,
        polygon: &CutPolygon<f64>,
        (rates, forms): (&Rates, &PlaneForms),
        moduli: [f64; 2],
        barycentric: &Barycentric,
    ) {
        let form = |wrenches: &[Vector6<f64>; 3]| forms.contracted(wrenches, 1.0);
        let of_growth = [0, 1, 2].map(|k| rates.by_speed[k] + rates.more_by_growth[k]);
        let by_speed = [form(&rates.by_speed), form(&of_growth)];
        let [by_motion, by_extent] = by_speed.each_ref();
        self.add_growth_of_b(polygon, moduli[1], [by_motion, by_extent], &barycentric[1]);
        let yielding = polygon.plane.yielding;
        let Weights { still, moving } = polygon.weights;
        let by_pressure = |by_speed: &[Vector6<f64>; 3], weight: f64| {
            form(&[0, 1, 2].map(|k| rates.by_pressure[k] * weight - by_speed[k] * yielding))
        };
        let by_motion = by_pressure(&rates.by_speed, moving.area());
        let by_extent = by_pressure(&of_growth, still.area());
        self.add_growth_of_a(
            polygon,
            moduli[0],
            [&by_motion, &by_extent],
            &barycentric[0],
        );
    }
}
