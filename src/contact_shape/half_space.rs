use crate::geometry::{ALL_FACES, AffineField, Tetrahedron};
use crate::mesh::FieldTet;
use nalgebra::Vector3;

/// All that lies below a plane: in its own frame the points with z ≤ 0, the outward normal along z.
///
/// It has no mesh and no end. On a rigid one the contact surface is what of its plane is in the other body. A compliant one is
/// a soft layer of some thickness on something rigid: its pressure is the modulus times depth over thickness, also deeper
/// than the layer is thick.
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
    /// A tetrahedron below the surface that stands for all of the half-space: none of its faces bounds anything.
    cell: [FieldTet; 1],
}

/// The thickness (m) of a soft layer is not positive and finite, or its inverse is beyond double precision.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("the layer of a half-space must have a positive and finite thickness, but has {0:?} m")]
pub struct ThicknessError(pub f64);

impl HalfSpace {
    /// One that does not give way.
    #[must_use]
    pub fn rigid() -> Self {
        Self::with_thickness(None)
    }

    /// One with a soft layer of this thickness (m).
    ///
    /// # Errors
    /// If the thickness is not positive and finite.
    pub fn layer(thickness: f64) -> Result<Self, ThicknessError> {
        // The slope of the extent, the inverse, must be finite too.
        if thickness > 0.0 && thickness.is_finite() && thickness.recip().is_finite() {
            Ok(Self::with_thickness(Some(thickness)))
        } else {
            Err(ThicknessError(thickness))
        }
    }

    /// Thickness (m) of its soft layer, if it has one.
    #[must_use]
    pub fn thickness(&self) -> Option<f64> {
        self.thickness
    }

    /// The tetrahedron that stands for it. Its extent is depth over thickness, or the depth (m) if it is rigid.
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
