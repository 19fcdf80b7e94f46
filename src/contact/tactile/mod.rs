//! Tactile images: the force of a contact on each taxel of a patch of a body's surface.
//!
//! A [`TaxelGrid`] is fixed to one body of a pair. Its planes divide space into columns and rows, and a taxel is the intersection of a
//! column and a row. The planes also divide each contact polygon into convex pieces (`division`), over which traction is integrated
//! exactly. The pieces outside of the patch contribute to a separate wrench. Therefore the sum over all taxels and this wrench is the
//! contact wrench, up to round-off. All derivatives are in closed form. `rates` has the derivatives of the elastic force, and
//! `motion` has the derivatives of the dissipation and friction forces.
//!
//! ```
//! use hydroelastic::contact::{ContactBody, ContactPair, GridBody, Partner, Shape, TaxelGrid};
//! use hydroelastic::mesh::shapes;
//! use hydroelastic::spatial::Pose;
//! use nalgebra::vector;
//!
//! let pad = Shape::new(shapes::cuboid([0.04, 0.04, 0.01])?);
//! let ball = Shape::new(shapes::icosphere(0.02, 2)?);
//! let pair = ContactPair::new(
//!     ContactBody::new(&pad, Pose::identity(), 1e5)?,
//!     ContactBody::new(&ball, Pose::from_translation(vector![0.003, 0.001, 0.024]), 1e6)?,
//! );
//! let top = Pose::from_translation(vector![0.0, 0.0, 0.005]);
//! let grid = TaxelGrid::flat(&top, [0.04, 0.04], [16, 12])?; // 16 columns along x, 12 rows along y
//! let image = pair.tactile_image(GridBody::A, &grid);
//! assert!(image.mean_pressure(6, 9) > 0.0);
//! let difference = image.total().force - pair.wrench().on_a.force;
//! assert!(difference.norm() < 1e-12 * pair.wrench().on_a.force.norm());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod cells;
mod division;
mod grid_body;
mod linearized_image;
mod motion;
mod rates;
mod shape_gradients;
mod tactile_image;
mod taxel_contact;
mod taxel_grid;
mod taxel_grid_error;
mod taxel_sums;

pub use grid_body::GridBody;
pub use linearized_image::LinearizedTactileImage;
pub use tactile_image::TactileImage;
pub use taxel_contact::TaxelContact;
pub use taxel_grid::TaxelGrid;
pub use taxel_grid_error::TaxelGridError;
