use super::area::{AreaMoments, Rates};
use super::traction::Traction;
use super::wrenches::{by_affine, plus, times};
use crate::contact::polygon_fields::{PolygonFields, Six};
use crate::contact::relative_linearisation::RelativeLinearisation;
use crate::lanes::space::components;
use crate::narrow_phase::Weights;
use nalgebra::{Matrix6, Matrix6x2, Vector6};

/// The derivatives of one polygon's wrench, with what its edges and weights make of them.
#[derive(Default)]
pub(super) struct PolygonRates {
    /// About the origin of the polygon's plane; those by the pressure with all of the polygon counted.
    pub rates: Rates<f64>,
    /// What to add to [`Rates::by_speed`] as the modulus of B grows: zero unless the polygon or an edge has another weight then
    /// (see [`Weights`]).
    pub modulus_correction: [Six<f64>; 3],
}

impl PolygonRates {
    /// Sets the integrals over the area: velocities, law, and K without the edges.
    pub fn set_area(&mut self, traction: &Traction) {
        let polygon = traction.polygon;
        let along_normal = polygon.plane.slope_along_normal();
        self.rates = Rates::of_area(&AreaMoments::on(traction), &traction.law, along_normal);
        if !polygon.weights.are_whole() {
            self.scale(polygon.weights);
        }
    }

    /// As far as the polygon counts.
    fn scale(&mut self, Weights { still, moving }: Weights) {
        let (still, moving) = (still.area(), moving.area());
        let rates = &mut self.rates;
        self.modulus_correction = rates.by_speed.map(|k| times(&k, still - moving));
        rates.by_speed = rates.by_speed.map(|k| times(&k, moving));
        rates.by_twist = rates.by_twist.map(|column| times(&column, still));
        for own in [
            &mut rates.wrench,
            &mut rates.by_dissipation,
            &mut rates.by_friction,
        ] {
            *own = times(own, still);
        }
    }

    /// Adds the rates to those in A's axes about A's origin.
    pub fn add_to(mut self, plane: &PolygonFields<f64>, sum: &mut RelativeLinearisation) {
        // h = −s_B·ξ/|g| for a motion ξ of B, and p/|g| for δE_B/E_B.
        let rates = &mut self.rates;
        rates.add_motion_of_plane(components(&plane.axes, plane.slopes[1]));
        let more = &self.modulus_correction;
        let by_growth = [0, 1, 2].map(|k| plus(&rates.by_speed[k], &more[k]));
        let by_modulus_b = by_affine(
            &by_growth,
            plane.pressure.map(|p| p * plane.inverse_gradient_norm),
        );
        let in_a = |wrench: &Six<f64>| Vector6::from(plane.in_a(wrench));
        sum.by_motion += Matrix6::from(plane.matrix_in_a(&rates.by_motion));
        sum.by_twist += Matrix6::from(plane.matrix_in_a(&rates.by_twist));
        sum.wrench += in_a(&rates.wrench);
        sum.by_moduli += Matrix6x2::from_columns(&[Vector6::zeros(), in_a(&by_modulus_b)]);
        let by_law = [&rates.by_dissipation, &rates.by_friction].map(in_a);
        sum.by_law += Matrix6x2::from_columns(&by_law);
    }
}
