use crate::geometry::{ALL_FACES, AffineField, Tetrahedron};
use crate::mesh::FieldTet;
use nalgebra::Vector3;

/// A half-space: the points with z ≤ 0 of its own frame. The outward normal is along z.
///
/// It is unbounded and has no mesh. On a rigid half-space, the contact surface is the part of its plane inside the
/// other body. A compliant half-space is a soft layer of finite thickness on a rigid base. Its pressure is the modulus
/// times depth over thickness, even at depths beyond the thickness.
///
/// ```
/// use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, Shape};
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let cube = Shape::new(shapes::cuboid([0.2; 3])?);
/// let pressed_in: Pose = Pose::from_translation(vector![0.0, 0.0, 0.09]);
/// let cube = ContactBody::new(&cube, pressed_in, 1e6)?;
/// let on_rigid = ContactPair::new(cube, Partner::rigid_half_space(Pose::identity())?);
/// assert!((on_rigid.wrench().on_a.force.z - 3613.333).abs() < 1e-3);
/// let layer = HalfSpace::layer(0.05)?; // m
/// let on_layer = ContactPair::new(cube, Partner::half_space(&layer, Pose::identity(), 3e5)?);
/// assert!((on_layer.wrench().on_a.force.z - 1444.453).abs() < 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct HalfSpace {
    thickness: Option<f64>,
    /// A tetrahedron below the surface that represents the half-space. None of its faces clips a contact polygon.
    cell: [FieldTet; 1],
}

/// The error that the thickness (m) of a soft layer is not positive and finite, or that its inverse overflows.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the layer of a half-space must have a positive and finite thickness, but has {0:?} m")]
pub struct ThicknessError(pub f64);

impl HalfSpace {
    /// Creates a rigid half-space.
    #[must_use]
    pub fn rigid() -> Self {
        Self::with_thickness(None)
    }

    /// Creates a half-space with a soft layer of this thickness (m).
    ///
    /// # Errors
    /// Returns an error if the thickness is not positive and finite, or if its inverse overflows.
    pub fn layer(thickness: f64) -> Result<Self, ThicknessError> {
        // The slope of the extent is the inverse of the thickness, so it must be finite too.
        if thickness > 0.0 && thickness.is_finite() && thickness.recip().is_finite() {
            Ok(Self::with_thickness(Some(thickness)))
        } else {
            Err(ThicknessError(thickness))
        }
    }

    /// Returns the thickness (m) of the soft layer, or `None` for a rigid half-space.
    #[must_use]
    pub fn thickness(&self) -> Option<f64> {
        self.thickness
    }

    /// Returns the tetrahedron that represents the half-space. Its extent is depth over thickness, or the depth (m) if
    /// it is rigid.
    pub(crate) fn cell(&self) -> &[FieldTet] {
        &self.cell
    }

    fn with_thickness(thickness: Option<f64>) -> Self {
        let steepness = thickness.map_or(1.0, f64::recip);
        let corners = [Vector3::zeros(), Vector3::y(), Vector3::x(), -Vector3::z()];
        let cell = FieldTet {
            extent: AffineField {
                gradient: Vector3::new(0.0, 0.0, -steepness),
                offset: 0.0,
            },
            steepness,
            sensitivity: steepness,
            zero_faces: ALL_FACES,
            ..FieldTet::new(0, Tetrahedron { corners }, [0.0, 0.0, 0.0, steepness])
        };
        Self {
            thickness,
            cell: [cell],
        }
    }
}
