use super::FileError;
use crate::mesh::TriangleSoup;
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::path::Path;

/// Map from the coordinates of a file to positions (m) in the body frame: position = pose · (unit · scale ∘ coordinates).
///
/// ```
/// use hydroelastic::io::Placement;
/// use nalgebra::vector;
///
/// // Millimeters, mirrored at the plane x = 0.
/// let placement = Placement { unit: 0.001, scale: vector![-1.0, 1.0, 1.0], ..Placement::default() };
/// assert!((placement.position(&vector![20.0, 0.0, 5.0]) - vector![-0.02, 0.0, 0.005]).norm() < 1e-15);
/// ```
#[derive(Debug, Clone)]
pub struct Placement {
    /// Length of a coordinate of 1 (m). It is 0.001 for the millimeters of most CAD programs.
    pub unit: f64,
    /// Factor for each axis of the file. A negative factor mirrors the body. Triangles and tetrahedra are then reoriented.
    pub scale: Vector3<f64>,
    /// Pose of the axes of the file in the body frame.
    pub pose: Pose,
}

impl Default for Placement {
    /// The coordinates of the file are meters in the body frame.
    fn default() -> Self {
        Self {
            unit: 1.0,
            scale: Vector3::repeat(1.0),
            pose: Pose::identity(),
        }
    }
}

impl Placement {
    /// Creates a placement with this unit (m), the scale 1 and the identity pose.
    #[must_use]
    pub fn from_unit(unit: f64) -> Self {
        Self {
            unit,
            ..Self::default()
        }
    }

    /// Returns the position (m) in the body frame of a point with these coordinates in the file.
    #[must_use]
    pub fn position(&self, coordinates: &Vector3<f64>) -> Vector3<f64> {
        self.pose
            .transformed_point(&(coordinates.component_mul(&self.scale) * self.unit))
    }

    /// Checks the unit and the scale for the reader of a file.
    pub(super) fn check(&self, path: &Path) -> Result<(), FileError> {
        let error = |name: &str, found, expected| FileError::Option {
            path: path.into(),
            name: name.into(),
            found,
            expected,
        };
        if !(self.unit > 0.0 && self.unit.is_finite()) {
            return Err(error("unit", self.unit, "positive and finite"));
        }
        let is_wrong = |factor: &&f64| **factor == 0.0 || !factor.is_finite();
        match self.scale.iter().find(is_wrong) {
            Some(&factor) => Err(error("scale", factor, "finite and not zero")),
            None => Ok(()),
        }
    }

    /// Returns true if the body is a mirror image of the file: an odd number of factors is negative.
    #[must_use]
    pub fn is_mirrored(&self) -> bool {
        self.scale.iter().filter(|factor| **factor < 0.0).count() % 2 == 1
    }

    /// Converts triangles from the coordinates of a file to the body frame (m).
    #[must_use]
    pub fn placed(&self, mut soup: TriangleSoup) -> TriangleSoup {
        for vertex in &mut soup.vertices {
            *vertex = self.position(vertex);
        }
        if self.is_mirrored() {
            soup.flipped()
        } else {
            soup
        }
    }
}
