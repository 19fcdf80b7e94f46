use super::division::Division;
use super::motion::{CutsIntegrand, MovingGrid};
use super::rates::{PolygonIntegrand, Term};
use super::taxel_sums::{TaxelQuantity, TaxelSums};
use super::{GridBody, TactileImage, TaxelGrid};
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::sums::PartialSum;
use crate::contact::{ContactPair, SurfaceLaw};
use crate::narrow_phase::{COINCIDENCE, ELASTIC_COINCIDENCE};
use crate::scalar::DenseDual;
use crate::spatial::skew;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

/// Number of relative inputs of a pair at rest: the motion of B relative to A, and both moduli.
const AT_REST: usize = 8;

/// Number of relative inputs of a pair in motion (see `ContactPair::tangent`).
const IN_MOTION: usize = 16;

/// A tactile image and its first derivatives with respect to poses, twists, moduli and the surface law.
///
/// Inputs are the columns of [`LinearizedContact::jacobian`](crate::contact::LinearizedContact::jacobian): the motions of A and B, their
/// twists, their moduli, dissipation and friction. Forces are along the [axes of the taxels](TaxelGrid::axes), which are fixed in the body
/// of the grid. If both bodies move together, the image is therefore constant.
///
/// The derivatives are in closed form, and nothing is differentiated through a clip. If an edge or a face of the contact coincides with a
/// taxel edge, each derivative is the mean of the two one-sided derivatives, as in
/// [`LinearizedContact`](crate::contact::LinearizedContact). The image then also has adjacent taxels whose forces are zero, but not their
/// derivatives.
///
/// A pair in motion with a rigid body has no derivative if a side of that body lies on a taxel edge, because forces of taxels jump there.
#[derive(Debug, Clone)]
pub struct LinearizedTactileImage<'g> {
    image: TactileImage<'g>,
    /// Derivatives of the forces on `image.taxels()` with respect to the relative inputs.
    by_relative: Vec<SMatrix<f64, 3, IN_MOTION>>,
    /// Derivatives of the relative inputs with respect to the inputs.
    by_inputs: SMatrix<f64, IN_MOTION, 28>,
}

/// Derivatives of the force on A in a taxel with respect to the first N relative inputs, in A's axes.
struct TaxelDerivatives<const N: usize> {
    taxel: [usize; 2],
    by_relative: SMatrix<f64, 3, N>,
}

/// Derivatives of the forces on the taxels of a grid.
type Derivatives<const N: usize> = TaxelSums<TaxelDerivatives<N>>;

impl ContactPair<'_> {
    /// Returns the forces on the taxels of a grid that is fixed to a body of the pair, and their derivatives.
    #[must_use]
    pub fn linearized_tactile_image<'g>(
        &self,
        body: GridBody,
        grid: &'g TaxelGrid,
    ) -> LinearizedTactileImage<'g> {
        let changes = SVector::from_fn(|column, _| DenseDual::<28>::variable(0.0, column));
        let tangent = self.perturbed(&changes).tangent();
        let mut linearized = LinearizedTactileImage {
            image: self.tactile_image(body, grid),
            by_relative: Vec::new(),
            by_inputs: SMatrix::from_fn(|row, column| tangent[row].eps[column]),
        };
        let force_from_a = body.force_from_a(&self.source().pose_ab);
        match self.relative_motion() {
            None => {
                linearized.set_derivatives(&self.elastic_derivatives(body, grid), &force_from_a);
            }
            Some((law, motion)) => {
                linearized.set_derivatives(
                    &self.derivatives_in_motion(body, grid, (&law, &motion)),
                    &force_from_a,
                );
            }
        }
        linearized
    }

    /// Returns the derivatives of the elastic forces on taxels.
    fn elastic_derivatives(&self, body: GridBody, grid: &TaxelGrid) -> Derivatives<AT_REST> {
        let (surface, _) = self
            .source()
            .for_derivatives(ELASTIC_COINCIDENCE, self.search());
        let division = Division::of((body, grid), &surface.source.pose_ab, None);
        let moduli = self.moduli();
        surface.integral(&PolygonIntegrand::new(
            |_, polygon, rates: &mut Derivatives<AT_REST>| {
                division.visit_terms(polygon, |term| {
                    let elastic = by_relative(term, polygon, body, moduli);
                    rates.sum_mut(term.taxel, grid.shape()).by_relative += elastic;
                });
            },
        ))
    }

    /// Returns the derivatives of the forces on taxels of a pair in motion. Derivatives with respect to velocities and the law are computed
    /// from the surface for values. Derivatives with respect to poses and moduli are computed from the surface for derivatives.
    fn derivatives_in_motion(
        &self,
        body: GridBody,
        grid: &TaxelGrid,
        (law, motion): (&SurfaceLaw, &RelativeMotion<f64>),
    ) -> Derivatives<IN_MOTION> {
        let (surface, finer) = self.source().for_derivatives(COINCIDENCE, self.search());
        let division = Division::of((body, grid), &surface.source.pose_ab, None);
        let moving = MovingGrid {
            division: &division,
            body,
            law_and_motion: (law, motion),
        };
        let moduli = self.moduli();
        let integrand =
            CutsIntegrand::new(|source: &_, cuts: &_, rates: &mut Derivatives<IN_MOTION>| {
                let (parts, in_taxels) =
                    moving.law_on_parts(source, (cuts, false), |_, polygon| {
                        if polygon.has_counted_area() {
                            division.visit_terms(polygon, |term| {
                                let sum = rates.sum_mut(term.taxel, grid.shape());
                                let mut at_rest = sum.by_relative.fixed_columns_mut::<AT_REST>(0);
                                at_rest += by_relative(term, polygon, body, moduli);
                            });
                        }
                    });
                for part in &in_taxels {
                    let law = &parts[part.part_index];
                    let mut by = law.by_relative(moduli);
                    if body == GridBody::B {
                        // The axes of the forces turn with B.
                        let mut by_turn = by.fixed_columns_mut::<3>(0);
                        by_turn += skew(&law.force());
                    }
                    rates.sum_mut(part.taxel, grid.shape()).by_relative += by * part.share;
                }
            });
        let mut rates = surface.integral(&integrand);
        if let Some(finer) = finer {
            for rate in rates.iter_mut() {
                rate.by_relative.fixed_columns_mut::<8>(AT_REST).fill(0.0);
            }
            let mut finer_rates = finer.integral(&integrand);
            for rate in finer_rates.iter_mut() {
                rate.by_relative.fixed_columns_mut::<AT_REST>(0).fill(0.0);
            }
            rates.merge(finer_rates);
        }
        rates
    }
}

impl<const N: usize> TaxelQuantity for TaxelDerivatives<N> {
    fn zero(taxel: [usize; 2]) -> Self {
        Self {
            taxel,
            by_relative: SMatrix::zeros(),
        }
    }

    fn taxel(&self) -> [usize; 2] {
        self.taxel
    }

    fn add(&mut self, other: &Self) {
        self.by_relative += other.by_relative;
    }
}

/// Returns the change of the force on a taxel due to a term, with the relative inputs of a pair at rest. A motion of B changes p_B by −s_B in
/// the frame of A, or p_A by s_A in the frame of B. `RelativeJacobian` defines s_A and s_B.
fn by_relative(
    term: &Term,
    polygon: &PlanePolygon<f64>,
    body: GridBody,
    moduli: [f64; 2],
) -> SMatrix<f64, 3, AT_REST> {
    let plane = &polygon.plane;
    let [area, y1, y2] = term.moments;
    let [e1, e2, _] = plane.axes.map(Vector3::from);
    let first = Vector3::from(plane.origin) * area + e1 * y1 + e2 * y2;
    let (vector, gradient) = match body {
        GridBody::A => (term.vectors[0], plane.slopes[1]),
        GridBody::B => (term.vectors[1], plane.gradient_a),
    };
    let gradient = Vector3::from(gradient) * polygon.weights.moving.area();
    let (turn, shift) = (gradient.cross(&first), gradient * -area);
    let [p0, p1, p2] = plane.pressure;
    let pressed = (p0 * area + p1 * y1 + p2 * y2) * polygon.weights.still.area();
    let by_a = term.vectors[1] * (-pressed / moduli[0]);
    let by_b = term.vectors[0] * (pressed * plane.inverse_gradient_norm / moduli[1]);
    SMatrix::from_fn(|row, input| match input {
        0..3 => vector[row] * turn[input],
        3..6 => vector[row] * shift[input - 3],
        6 => by_a[row],
        _ => by_b[row],
    })
}

impl<'g> LinearizedTactileImage<'g> {
    /// Sets the derivatives of the image from those of forces on A, in A's axes. `force_from_a` maps these forces to forces on the body of the
    /// grid, in the axes of that body.
    fn set_derivatives<const N: usize>(
        &mut self,
        rates: &Derivatives<N>,
        force_from_a: &Matrix3<f64>,
    ) {
        let grid = self.image.grid();
        let rates = rates.as_slice();
        let indices = rates
            .iter()
            .map(|rate| self.image.index_or_added(rate.taxel));
        let indices: Vec<_> = indices.collect();
        self.by_relative = vec![SMatrix::zeros(); self.image.taxels().len()];
        for (index, rate) in indices.into_iter().zip(rates) {
            let [row, column] = rate.taxel;
            let turned = grid.axes(row, column).tr_mul(force_from_a) * rate.by_relative;
            self.by_relative[index]
                .fixed_columns_mut::<N>(0)
                .copy_from(&turned);
        }
    }

    /// Returns the image.
    #[must_use]
    pub fn image(&self) -> &TactileImage<'g> {
        &self.image
    }

    /// Returns the derivatives of the force on a taxel with respect to all inputs. They are zero for taxels without contact.
    #[must_use]
    pub fn jacobian(&self, row: usize, column: usize) -> SMatrix<f64, 3, 28> {
        self.image
            .index(row, column)
            .map_or_else(SMatrix::zeros, |index| {
                self.by_relative[index] * self.by_inputs
            })
    }

    /// Returns the changes of the forces on [`TactileImage::taxels`], in that order, for a change of the inputs.
    #[must_use]
    pub fn pushforward(&self, change: &SVector<f64, 28>) -> Vec<Vector3<f64>> {
        let relative = self.by_inputs * change;
        self.by_relative.iter().map(|by| by * relative).collect()
    }

    /// Returns the derivatives of a number with respect to the inputs, from its derivatives with respect to the forces on the taxels.
    /// `by_force` returns the derivatives for the row and the column of a taxel with contact.
    #[must_use]
    pub fn pullback(
        &self,
        mut by_force: impl FnMut(usize, usize) -> Vector3<f64>,
    ) -> SVector<f64, 28> {
        let taxels = self.image.taxels().iter().zip(&self.by_relative);
        let by_relative = taxels.fold(SVector::zeros(), |sum, (taxel, by)| {
            sum + by.tr_mul(&by_force(taxel.row, taxel.column))
        });
        self.by_inputs.tr_mul(&by_relative)
    }
}
