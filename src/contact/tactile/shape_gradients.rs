use super::division::Division;
use super::motion::{CutsIntegrand, MovingGrid};
use super::rates::PolygonIntegrand;
use super::{GridBody, TaxelGrid};
use crate::contact::affine_form::AffineForm;
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::polygon_source::PolygonSource;
use crate::contact::response::{OfCell, PolygonResponse};
use crate::contact::{ContactPair, ShapeGradient, SurfaceLaw};
use crate::narrow_phase::{COINCIDENCE, Cut, ELASTIC_COINCIDENCE, Weight};
use nalgebra::{Vector3, Vector6};

/// The contributions of a polygon to the derivatives with respect to the corners of two cells.
type OfCells = ([usize; 2], [OfCell; 2]);

impl ContactPair<'_> {
    /// Returns the derivatives of a loss with respect to the shapes of A and of B, from its derivatives with respect to the forces on the
    /// taxels of a grid that is fixed to a body. `by_force` returns the derivatives for a row and a column, along the
    /// [axes of the taxel](TaxelGrid::axes).
    ///
    /// This is the transposed Jacobian of the image times a vector, for all vertices together. The grid does not move with the vertices.
    /// [`Self::shape_gradients`] returns the corresponding derivatives of wrenches.
    #[must_use]
    pub fn tactile_shape_gradients(
        &self,
        body: GridBody,
        grid: &TaxelGrid,
        by_force: impl Fn(usize, usize) -> Vector3<f64> + Sync,
    ) -> [ShapeGradient; 2] {
        let to_a = body.force_from_a(&self.source().pose_ab).transpose();
        let covector =
            |[row, column]: [usize; 2]| to_a * (grid.axes(row, column) * by_force(row, column));
        let shapes = self.shapes();
        let mut gradients = shapes.map(ShapeGradient::zero);
        let rotation_ba = self.source().pose_ab.rotation().transpose();
        let cells = match self.relative_motion() {
            None => self.cells_at_rest((body, grid), covector),
            Some((law, motion)) => self.cells_in_motion((body, grid), (&law, &motion), covector),
        };
        for (tets, cells) in cells {
            let vertices = [0, 1].map(|body| shapes[body].corner_vertices(tets[body]));
            ShapeGradient::add_polygon(gradients.each_mut(), vertices, &cells, &rotation_ba);
        }
        gradients
    }

    /// Returns the contributions of all polygons. `covector` returns the derivative of the loss with respect to the force on A in a
    /// taxel, in A's axes.
    fn cells_at_rest(
        &self,
        grid: (GridBody, &TaxelGrid),
        covector: impl Fn([usize; 2]) -> Vector3<f64> + Sync,
    ) -> Vec<OfCells> {
        let (surface, _) = self
            .source()
            .for_derivatives(ELASTIC_COINCIDENCE, self.search());
        let source = &surface.source;
        let division = Division::of(grid, &source.pose_ab, None);
        let add = |tets, polygon: &PlanePolygon<f64>, cells: &mut Vec<OfCells>| {
            let forms = division.forms(polygon, &covector);
            let (moduli, coordinates) = (source.moduli(), source.barycentric(tets));
            let response = PolygonResponse::of(tets, polygon);
            cells.push((tets, response.with_law_on(&[], forms, moduli, &coordinates)));
        };
        surface.integral(&PolygonIntegrand::new(add))
    }

    /// Returns the contributions of all polygons of a pair in motion.
    fn cells_in_motion(
        &self,
        (body, grid): (GridBody, &TaxelGrid),
        law_and_motion: (&SurfaceLaw, &RelativeMotion<f64>),
        covector: impl Fn([usize; 2]) -> Vector3<f64> + Sync,
    ) -> Vec<OfCells> {
        let (surface, _) = self.source().for_derivatives(COINCIDENCE, self.search());
        let division = Division::of((body, grid), &surface.source.pose_ab, None);
        let moving = MovingGrid {
            division: &division,
            body,
            law_and_motion,
        };
        surface.integral(&CutsIntegrand::new(
            |source: &PolygonSource<f64>, cuts: &_, cells: &mut Vec<OfCells>| {
                let mut polygons = Vec::new();
                let add_polygon = |cut: &Cut, polygon: &PlanePolygon<f64>| {
                    let has_area = polygon.has_counted_area();
                    let forms = has_area.then(|| division.forms(polygon, &covector));
                    let response = PolygonResponse::of(cut.tets, polygon);
                    polygons.push((response, forms.unwrap_or_default()));
                };
                let (parts, in_taxels) = moving.law_on_parts(source, (cuts, true), add_polygon);
                let mut in_taxels = in_taxels.iter().peekable();
                for (index, (response, forms)) in polygons.into_iter().enumerate() {
                    let mut laws = Vec::new();
                    while let Some(part) = in_taxels.next_if(|part| part.polygon_index == index) {
                        let [x, y, z]: [f64; 3] = (covector(part.taxel) * part.share).into();
                        let by_wrench = Vector6::new(0.0, 0.0, 0.0, x, y, z);
                        let law = &parts[part.part_index].response;
                        laws.push((law, response.in_plane(&by_wrench)));
                    }
                    let (moduli, coordinates) =
                        (source.moduli(), source.barycentric(response.tets));
                    let of_cells = response.with_law_on(&laws, forms, moduli, &coordinates);
                    cells.push((response.tets, of_cells));
                }
            },
        ))
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
