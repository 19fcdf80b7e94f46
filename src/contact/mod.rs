//! Integrals over the contact polygons of a body pair: the contact surface, the wrench, the surface law, their first derivatives, and the
//! potential energy.
//!
//! Two bodies press on each other where their tetrahedra overlap. In a pair of tetrahedra the two pressures are equal on a plane. The part
//! of the plane inside both tetrahedra is a convex *contact polygon*, and the polygons of a body pair make up the *contact surface* (the
//! paper, §III). The wrench is the exact integral of pressure times normal over the contact surface.
//!
//! **Sign convention**, here and everywhere: the normal of a contact polygon points out of B into A, in the direction in which the pressure
//! pushes A.
//!
//! ```
//! use hydroelastic::contact::{ContactBody, ContactPair, Shape};
//! use hydroelastic::mesh::shapes;
//! use hydroelastic::spatial::Pose;
//! use nalgebra::Vector3;
//!
//! let ball = Shape::new(shapes::icosphere(0.1, 2)?);
//! let block = Shape::new(shapes::cuboid([0.4, 0.4, 0.2])?);
//! let on_top = Pose::from_translation(Vector3::new(0.0, 0.0, 0.195));
//! let pair = ContactPair::new(
//!     ContactBody::new(&ball, on_top, 1e5)?,
//!     ContactBody::new(&block, Pose::identity(), 1e6)?,
//! );
//! let contact = pair.linearized();
//! assert!(contact.wrench.on_a.force.z > 0.0);
//! // If the ball is lifted, the force decreases. Row and column 5 are the z force on A and the z translation of A.
//! assert!(contact.by_poses[(5, 5)] < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod affine_form;
mod clearance;
mod coincidence;
mod cut_surface;
mod elastic;
mod energy;
mod frozen;
mod integrate;
mod jacobian;
mod kinks;
mod linearized;
mod loaded_triangles;
mod motion;
mod moving_wrench;
mod outline;
mod pair;
mod plane_motion;
mod plane_polygon;
mod polygon_fields;
mod polygon_source;
mod reaction;
mod relative_linearization;
mod response;
mod shape_gradient;
mod slip_fields;
mod sums;
mod sunk;
mod surface;
mod surface_law;
mod tactile;
mod tangent;
mod traction_derivatives;
mod wrench;

pub use crate::contact_shape::{
    BodyError, ContactBody, HalfSpace, Partner, RigidShape, Shape, ThicknessError,
};
pub(crate) use crate::contact_shape::{PartnerShape, STEEPEST};
pub use crate::search::{Culling, Search};
pub use crate::seeds::NotFollowed;
pub use clearance::{Clearance, Feature, LinearizedClearance};
pub(crate) use frozen::FrozenContact;
pub use kinks::Kinks;
pub use linearized::LinearizedContact;
pub use pair::{ContactPair, Pipeline, WorkCount};
pub use shape_gradient::ShapeGradient;
pub(crate) use shape_gradient::ShapeResponse;
pub use surface::{ContactPolygon, ContactSurface};
pub(crate) use surface_law::SLIP_TOLERANCES;
pub use surface_law::SurfaceLaw;
pub use tactile::{
    GridBody, LinearizedTactileImage, TactileImage, TaxelContact, TaxelGrid, TaxelGridError,
};
pub(crate) use traction_derivatives::AddedByLaw;
pub use wrench::ContactWrench;
