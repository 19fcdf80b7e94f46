use super::division::Division;
use super::rates::{PolygonIntegrand, Term};
use super::{GridBody, TactileImage, TaxelGrid};
use crate::contact::motion::RelativeMotion;
use crate::contact::plane_polygon::PlanePolygon;
use crate::contact::{ContactPair, SurfaceLaw};
use crate::narrow_phase::ELASTIC_COINCIDENCE;
use crate::scalar::{DenseDual, lift};
use crate::spatial::Twist;
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

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
/// For a pair at rest, the derivatives are in closed form, and nothing is differentiated through a clip. If an edge or a face of the contact
/// coincides with a taxel edge, each derivative is the mean of the two one-sided derivatives, as in
/// [`LinearizedContact`](crate::contact::LinearizedContact). The image then also has adjacent taxels whose forces are zero, but not their
/// derivatives.
///
/// For a pair in motion, the derivatives are computed in dual numbers, including the clipping by faces and taxels. If faces of the
/// bodies coincide, entries of this Jacobian may be wrong, even if the wrench has a derivative there.
#[derive(Debug, Clone)]
pub struct LinearizedTactileImage<'g> {
    image: TactileImage<'g>,
    /// Derivatives of the forces on `image.taxels()` with respect to the relative inputs.
    by_relative: Vec<SMatrix<f64, 3, IN_MOTION>>,
    /// Derivatives of the relative inputs with respect to the inputs.
    by_inputs: SMatrix<f64, IN_MOTION, 28>,
}

/// Derivatives of the force on a taxel with respect to the relative inputs of a pair at rest, in A's axes.
struct TaxelDerivatives {
    taxel: [usize; 2],
    by_relative: SMatrix<f64, 3, AT_REST>,
}

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
        let (image, by_relative) = match self.relative_motion() {
            None => self.image_at_rest(body, grid),
            Some(motion) => self.image_in_motion(body, grid, motion),
        };
        LinearizedTactileImage {
            image,
            by_relative,
            by_inputs: SMatrix::from_fn(|row, column| tangent[row].eps[column]),
        }
    }

    /// Returns the image of a pair at rest, and the derivatives of its forces with respect to the relative inputs.
    fn image_at_rest<'g>(
        &self,
        body: GridBody,
        grid: &'g TaxelGrid,
    ) -> (TactileImage<'g>, Vec<SMatrix<f64, 3, IN_MOTION>>) {
        let mut image = self.tactile_image(body, grid);
        let mut by_relative = vec![SMatrix::zeros(); image.taxels().len()];
        let source = self.source();
        let turn = body.force_from_a(&source.pose_ab);
        for rate in self.elastic_derivatives(body, grid) {
            let [row, column] = rate.taxel;
            let index = image.index_or_added(rate.taxel);
            by_relative.resize(image.taxels().len(), SMatrix::zeros());
            let turned = grid.axes(row, column).tr_mul(&turn) * rate.by_relative;
            let rates: &mut SMatrix<f64, 3, IN_MOTION> = &mut by_relative[index];
            let mut sum = rates.fixed_columns_mut::<AT_REST>(0);
            sum += turned;
        }
        (image, by_relative)
    }

    /// Returns the derivatives of the forces on taxels, with an entry for each part of a polygon.
    fn elastic_derivatives(&self, body: GridBody, grid: &TaxelGrid) -> Vec<TaxelDerivatives> {
        let (surface, _) = self
            .source()
            .for_derivatives(ELASTIC_COINCIDENCE, self.search());
        let division = Division::of((body, grid), &surface.source.pose_ab, None);
        let moduli = self.moduli();
        surface.integral(&PolygonIntegrand::new(
            |_, polygon, rates: &mut Vec<TaxelDerivatives>| {
                division.visit_terms(polygon, |term| {
                    let by_relative = by_relative(term, polygon, body, moduli);
                    match rates.last_mut() {
                        Some(last) if last.taxel == term.taxel => last.by_relative += by_relative,
                        _ => rates.push(TaxelDerivatives {
                            taxel: term.taxel,
                            by_relative,
                        }),
                    }
                });
            },
        ))
    }

    /// Returns the image of a pair in motion, and the derivatives of its forces with respect to the relative inputs.
    fn image_in_motion<'g>(
        &self,
        body: GridBody,
        grid: &'g TaxelGrid,
        (law, motion): (SurfaceLaw, RelativeMotion<f64>),
    ) -> (TactileImage<'g>, Vec<SMatrix<f64, 3, IN_MOTION>>) {
        let change = |input: usize| DenseDual::<IN_MOTION>::variable(0.0, input);
        let real = self.real();
        let mut twist = Twist::from_vector(&Vector6::from_fn(|row, _| change(row)));
        // A rotation about A's origin also moves the origin of B.
        let origin_b = real.b().pose().translation().map(lift);
        twist.linear += twist.angular.cross(&origin_b);
        let pair = ContactPair::new(
            real.a().perturbed(&Twist::zero(), change(6)),
            real.b().perturbed(&twist, change(7)),
        );
        let changes = std::array::from_fn(|input| change(AT_REST + input));
        let motion = perturbed_motion(&law, &motion, &changes);
        let surface = pair.with_search(self.search()).cut_surface();
        let image = TactileImage::of(&surface, Some(motion), (body, grid));
        let by_relative = image.taxels().iter().map(|taxel| {
            let force = taxel.force(grid);
            SMatrix::from_fn(|row, input| force[row].eps.get(input).copied().unwrap_or(0.0))
        });
        (image.real(), by_relative.collect())
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

/// Returns a law and a relative motion after changes of the angular velocity, the velocity at A's origin, dissipation and friction.
fn perturbed_motion<const N: usize>(
    law: &SurfaceLaw,
    motion: &RelativeMotion<f64>,
    changes: &[DenseDual<N>; 8],
) -> (SurfaceLaw<DenseDual<N>>, RelativeMotion<DenseDual<N>>) {
    let [w1, w2, w3, v1, v2, v3, dissipation, friction] = *changes;
    let law = SurfaceLaw {
        dissipation: dissipation + law.dissipation,
        friction: friction + law.friction,
        slip_tolerance: law.slip_tolerance,
    };
    let motion = RelativeMotion {
        angular: motion.angular.map(lift) + Vector3::new(w1, w2, w3),
        at_origin: motion.at_origin.map(lift) + Vector3::new(v1, v2, v3),
    };
    (law, motion)
}

impl<'g> LinearizedTactileImage<'g> {
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
