use super::division::Division;
use super::rates::PolygonIntegrand;
use super::{GridBody, TaxelGrid};
use crate::contact::affine_form::AffineForm;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::response::{OfCell, PolygonResponse};
use crate::contact::{BodyError, ContactPair, ShapeGradient};
use crate::narrow_phase::{ELASTIC_COINCIDENCE, Weight};
use nalgebra::Vector3;

/// The contributions of a polygon to the derivatives with respect to the corners of two cells.
type OfCells = ([usize; 2], [OfCell; 2]);

impl ContactPair<'_> {
    /// Returns the derivatives of a loss with respect to the shapes of A and of B, from its derivatives with respect to the forces on the
    /// taxels of a grid that is fixed to a body. `by_force` returns the derivatives for a row and a column, along the
    /// [axes of the taxel](TaxelGrid::axes).
    ///
    /// This is the transposed Jacobian of the image times a vector, for all vertices together. The grid does not move with the vertices.
    /// [`Self::shape_gradients`] returns the corresponding derivatives of wrenches.
    ///
    /// # Errors
    /// Returns an error for a pair in motion.
    pub fn tactile_shape_gradients(
        &self,
        body: GridBody,
        grid: &TaxelGrid,
        by_force: impl Fn(usize, usize) -> Vector3<f64> + Sync,
    ) -> Result<[ShapeGradient; 2], BodyError> {
        if self.motion().is_some() {
            return Err(BodyError::InMotion);
        }
        let (surface, _) = self
            .source()
            .for_derivatives(ELASTIC_COINCIDENCE, self.search());
        let source = &surface.source;
        let division = Division::of((body, grid), &source.pose_ab, None);
        let to_a = body.force_from_a(&source.pose_ab).transpose();
        let covector =
            |[row, column]: [usize; 2]| to_a * (grid.axes(row, column) * by_force(row, column));
        let add = |tets, polygon: &PlanePolygon<f64>, cells: &mut Vec<OfCells>| {
            let forms = division.forms(polygon, covector);
            let response = PolygonResponse::of(tets, polygon);
            let [in_a, in_b] = &source.barycentric(tets);
            cells.push((
                tets,
                response.of_fields(forms, source.moduli(), [in_a, in_b]),
            ));
        };
        let shapes = self.shapes();
        let mut gradients = shapes.map(ShapeGradient::zero);
        let rotation_ba = source.pose_ab.rotation().transpose();
        for (tets, cells) in surface.integral(&PolygonIntegrand::new(add)) {
            let vertices = [0, 1].map(|body| shapes[body].corner_vertices(tets[body]));
            ShapeGradient::add_polygon(gradients.each_mut(), vertices, &cells, &rotation_ba);
        }
        Ok(gradients)
    }
}

impl Division<f64> {
    /// Returns the derivatives of a loss with respect to the fields p_A and p_B, first for motions of the bodies and then for changes of the
    /// extents. `covector` has the derivatives of the loss with respect to the force on A in a taxel, in A's axes.
    fn forms(
        &self,
        polygon: &PlanePolygon<f64>,
        covector: impl Fn([usize; 2]) -> Vector3<f64>,
    ) -> [[AffineForm; 2]; 2] {
        let mut sums = [[0.0; 3]; 2];
        self.visit_terms(polygon, |term| {
            let covector = covector(term.taxel);
            for (sum, vector) in sums.iter_mut().zip(&term.vectors) {
                let factor = covector.dot(vector);
                for (number, moment) in sum.iter_mut().zip(term.moments) {
                    *number += factor * moment;
                }
            }
        });
        let plane = &polygon.plane;
        let [e1, e2, _] = plane.axes.map(Vector3::from);
        let [by_b, by_a] =
            sums.map(|[f0, f1, f2]| AffineForm::about(&plane.origin.into(), f0, e1 * f1 + e2 * f2));
        let weights = [polygon.weights.moving, polygon.weights.still];
        weights
            .map(Weight::area)
            .map(|weight| [by_a * -weight, by_b * weight])
    }
}
