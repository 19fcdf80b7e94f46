use super::{GridBody, TactileImage, TaxelGrid};
use crate::contact::motion::RelativeMotion;
use crate::contact::{ContactPair, SurfaceLaw};
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
/// The derivatives are computed in dual numbers, including the clipping by faces and taxels. If faces coincide, entries
/// of the Jacobian may be wrong, also if the wrench has a derivative there.
#[derive(Debug, Clone)]
pub struct LinearizedTactileImage<'g> {
    image: TactileImage<'g>,
    /// Derivatives of the forces on `image.taxels()` with respect to the relative inputs.
    by_relative: Vec<SMatrix<f64, 3, IN_MOTION>>,
    /// Derivatives of the relative inputs with respect to the inputs.
    by_inputs: SMatrix<f64, IN_MOTION, 28>,
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
            None => self.relative_image::<AT_REST>(body, grid, None),
            motion => self.relative_image::<IN_MOTION>(body, grid, motion),
        };
        LinearizedTactileImage {
            image,
            by_relative,
            by_inputs: SMatrix::from_fn(|row, column| tangent[row].eps[column]),
        }
    }

    /// Returns the image and the derivatives of its forces with respect to the first `N` relative inputs.
    fn relative_image<'g, const N: usize>(
        &self,
        body: GridBody,
        grid: &'g TaxelGrid,
        motion: Option<(SurfaceLaw, RelativeMotion<f64>)>,
    ) -> (TactileImage<'g>, Vec<SMatrix<f64, 3, IN_MOTION>>) {
        let change = |input: usize| DenseDual::<N>::variable(0.0, input);
        let real = self.real();
        let mut twist = Twist::from_vector(&Vector6::from_fn(|row, _| change(row)));
        // A rotation about A's origin also moves the origin of B.
        let origin_b = real.b().pose().translation().map(lift);
        twist.linear += twist.angular.cross(&origin_b);
        let pair = ContactPair::new(
            real.a().perturbed(&Twist::zero(), change(6)),
            real.b().perturbed(&twist, change(7)),
        );
        let motion = motion.map(|(law, motion)| {
            let changes = std::array::from_fn(|input| change(AT_REST + input));
            perturbed_motion(&law, &motion, &changes)
        });
        let surface = pair.with_search(self.search()).cut_surface();
        let image = TactileImage::of(&surface, motion, (body, grid));
        let by_relative = image.taxels().iter().map(|taxel| {
            let force = taxel.force(grid);
            SMatrix::from_fn(|row, input| force[row].eps.get(input).copied().unwrap_or(0.0))
        });
        (image.real(), by_relative.collect())
    }
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
