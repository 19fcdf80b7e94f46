use super::model::Model;
use super::sweep::Sweep;
use super::{Force, State, World, WorldError};
use crate::contact::{GridBody, TactileImage, TaxelGrid};
use crate::parallel::mapped_into;
use crate::scalar::Scalar;

impl<T: Scalar, F: Force> World<T, F> {
    /// Returns the forces on the taxels of a grid that is fixed to a body, in a state. `body` is the index of this body. `partner` is the
    /// index of the only other body whose contact is included. If it is `None`, the contacts with all bodies are added. Ignored pairs and
    /// pairs without a dynamic body are omitted.
    ///
    /// # Errors
    /// Returns an error in these cases:
    /// - the state does not fit the world;
    /// - `body` or `partner` is not an index of a body;
    /// - `body` and `partner` are equal.
    pub fn tactile_image<'g>(
        &self,
        state: &State<T>,
        (body, partner): (usize, Option<usize>),
        grid: &'g TaxelGrid,
    ) -> Result<TactileImage<'g, T>, WorldError> {
        state.check_fits(self.bodies())?;
        let bodies = self.bodies().len();
        for index in [Some(body), partner].into_iter().flatten() {
            if index >= bodies {
                return Err(WorldError::BodyIndex { index, bodies });
            }
        }
        if partner == Some(body) {
            return Err(WorldError::SameBody(self.bodies()[body].name().to_owned()));
        }
        Ok(self.model.tactile_image(state, (body, partner), grid))
    }
}

impl<T: Scalar> Model<T> {
    fn tactile_image<'g>(
        &self,
        state: &State<T>,
        (body, partner): (usize, Option<usize>),
        grid: &'g TaxelGrid,
    ) -> TactileImage<'g, T> {
        let (mut sweep, mut images) = (Sweep::default(), Vec::new());
        let pairs = self.close_pairs(&state.bodies, &mut sweep);
        mapped_into(&mut images, pairs, |&(i, j)| {
            let (other, side) = match (i == body, j == body) {
                (true, _) => (j, GridBody::A),
                (_, true) => (i, GridBody::B),
                _ => return None,
            };
            if partner.is_some_and(|partner| partner != other) {
                return None;
            }
            let pair = self.pair_of([i, j], [&state.bodies[i], &state.bodies[j]])?;
            Some(pair.tactile_image(side, grid))
        });
        let mut sum = TactileImage::empty(grid);
        for image in images.into_iter().flatten() {
            sum.merge(image);
        }
        sum
    }
}
