use super::division::Division;
use super::taxel_sums::TaxelSums;
use super::{GridBody, TaxelContact, TaxelGrid};
use crate::contact::integrate::CutSurface;
use crate::contact::motion::RelativeMotion;
use crate::contact::sums::PartialSum;
use crate::contact::{ContactPair, SurfaceLaw};
use crate::scalar::{Scalar, lift, real_part};
use crate::spatial::{Pose, Wrench};
use nalgebra::Vector3;

/// The contact of a pair of bodies on the taxels of a grid, integrated exactly.
///
/// Forces are on the body of the grid. If the taxels' normals point out of the body, a pressed taxel has a negative normal force. Mean
/// pressures are positive. The values of taxels without contact are zero.
#[derive(Debug, Clone)]
pub struct TactileImage<'g, T = f64> {
    grid: &'g TaxelGrid,
    contacts: TaxelSums<TaxelContact<T>>,
    outside: Wrench<T>,
}

impl<T: Scalar> ContactPair<'_, T> {
    /// Returns the forces on the taxels of a grid that is fixed to a body of the pair. For a pair in motion, the forces include dissipation
    /// and friction.
    ///
    /// The image is generic over the scalar. With dual numbers, it has derivatives with respect to poses, twists, moduli and the law.
    /// Geometry, clipping and integration propagate these derivatives, as in [`Self::pipeline`].
    #[must_use]
    pub fn tactile_image<'g>(&self, body: GridBody, grid: &'g TaxelGrid) -> TactileImage<'g, T> {
        TactileImage::of(&self.cut_surface(), self.relative_motion(), (body, grid))
    }
}

impl<'g, T: Scalar> TactileImage<'g, T> {
    /// Integrates over a contact surface, with a law and a velocity for a pair in motion.
    pub(super) fn of(
        surface: &CutSurface<T>,
        motion: Option<(SurfaceLaw<T>, RelativeMotion<T>)>,
        (body, grid): (GridBody, &'g TaxelGrid),
    ) -> Self {
        let pose_ab = &surface.source.pose_ab;
        let division = Division::of((body, grid), pose_ab, motion);
        let forces = surface.integral(&division);
        let mut image = Self {
            grid,
            contacts: forces.in_taxels,
            outside: forces.outside,
        };
        if body == GridBody::B {
            image.exchange(pose_ab);
        }
        image
    }

    /// Creates the image of bodies that do not touch.
    pub(crate) fn empty(grid: &'g TaxelGrid) -> Self {
        Self {
            grid,
            contacts: TaxelSums::empty(),
            outside: Wrench::zero(),
        }
    }

    /// Returns the index of a taxel of the grid in [`Self::taxels`]. Adds the taxel, without force and area, if it has no contact.
    pub(super) fn index_or_added(&mut self, taxel: [usize; 2]) -> usize {
        self.contacts.sum_mut(taxel, self.grid.shape());
        self.contacts.index(taxel).unwrap_or_default()
    }

    /// Adds another image of the same grid.
    pub(crate) fn merge(&mut self, other: Self) {
        self.outside += other.outside;
        self.contacts.merge(other.contacts);
    }

    /// Replaces the wrenches on A, in A's axes about A's origin, by the wrenches on B, in B's axes about B's origin.
    fn exchange(&mut self, pose_ab: &Pose<T>) {
        let rotation_ba = pose_ab.rotation().transpose();
        let on_b = |on_a: &Wrench<T>| -on_a.about(pose_ab.translation()).rotated(&rotation_ba);
        self.outside = on_b(&self.outside);
        for taxel in self.contacts.iter_mut() {
            taxel.wrench = on_b(&taxel.wrench);
        }
    }

    /// Returns the grid.
    #[must_use]
    pub fn grid(&self) -> &'g TaxelGrid {
        self.grid
    }

    /// Returns the taxels with contact, in no particular order.
    #[must_use]
    pub fn taxels(&self) -> &[TaxelContact<T>] {
        self.contacts.as_slice()
    }

    /// Returns the contact in a taxel, or `None` if the taxel has no contact or does not exist.
    #[must_use]
    pub fn taxel(&self, row: usize, column: usize) -> Option<&TaxelContact<T>> {
        self.taxels().get(self.index(row, column)?)
    }

    /// Returns the index of a taxel with contact in [`Self::taxels`].
    pub(super) fn index(&self, row: usize, column: usize) -> Option<usize> {
        let [row_count, column_count] = self.grid.shape();
        let is_in_grid = row < row_count && column < column_count;
        is_in_grid.then(|| self.contacts.index([row, column]))?
    }

    /// Returns the image without its derivatives.
    #[must_use]
    pub fn real(&self) -> TactileImage<'g> {
        let real = |taxel: &TaxelContact<T>| TaxelContact {
            row: taxel.row,
            column: taxel.column,
            wrench: taxel.wrench.real(),
            area: real_part(taxel.area),
        };
        TactileImage {
            grid: self.grid,
            contacts: self.contacts.map(real),
            outside: self.outside.real(),
        }
    }

    /// Returns the force (N) on the body in a taxel, along the [axes of the taxel](TaxelGrid::axes): two components of shear, and the
    /// normal component, which is negative if the taxel is pressed.
    #[must_use]
    pub fn force(&self, row: usize, column: usize) -> Vector3<T> {
        let zero = Vector3::from_element(lift(0.0));
        self.taxel(row, column)
            .map_or(zero, |taxel| taxel.force(self.grid))
    }

    /// Returns the area (m²) of the contact surface in a taxel.
    #[must_use]
    pub fn area(&self, row: usize, column: usize) -> T {
        self.taxel(row, column)
            .map_or(lift(0.0), |taxel| taxel.area)
    }

    /// Returns the mean traction (Pa) on the body in a taxel: the force divided by the contact area, along the axes of the taxel. The first
    /// two components are the mean shear stress.
    #[must_use]
    pub fn mean_traction(&self, row: usize, column: usize) -> Vector3<T> {
        let (force, area) = (self.force(row, column), self.area(row, column));
        if real_part(area) > 0.0 {
            force / area
        } else {
            force * lift::<T>(0.0)
        }
    }

    /// Returns the mean pressure (Pa) in a taxel: minus the normal component of [`Self::mean_traction`].
    #[must_use]
    pub fn mean_pressure(&self, row: usize, column: usize) -> T {
        -self.mean_traction(row, column).z
    }

    /// Returns the wrench of the contact outside of the patch, on the body of the grid about its origin, in its axes.
    #[must_use]
    pub fn outside(&self) -> &Wrench<T> {
        &self.outside
    }

    /// Returns the sum over all taxels and [`Self::outside`]: the contact wrench on the body of the grid, about the body's origin, in the
    /// body's axes.
    #[must_use]
    pub fn total(&self) -> Wrench<T> {
        let taxels = self.taxels().iter();
        taxels.fold(self.outside, |sum, taxel| sum + taxel.wrench)
    }
}
