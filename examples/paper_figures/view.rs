//! An orthographic camera.

use nalgebra::Vector3;

/// A position in the picture, in pixels from its upper left corner.
pub type Pixel = (i32, i32);

/// Map from the world to the picture.
pub struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector from the target to the viewer.
    toward: Vector3<f64>,
    /// The point (m) at the pixel `center`.
    pub target: Vector3<f64>,
    pub center: Pixel,
    /// Pixels per meter.
    pub scale: f64,
}

impl View {
    /// Creates a view from a direction, with z upward.
    pub fn from(direction: Vector3<f64>, center: Pixel, scale: f64) -> Self {
        let toward = direction.normalize();
        let right = Vector3::z().cross(&toward).normalize();
        Self {
            right,
            up: toward.cross(&right),
            toward,
            target: Vector3::zeros(),
            center,
            scale,
        }
    }

    /// Returns the pixel of a point (m).
    pub fn pixel(&self, point: &Vector3<f64>) -> Pixel {
        let offset = (point - self.target) * self.scale;
        let (across, upwards) = (self.right.dot(&offset), self.up.dot(&offset));
        (
            self.center.0 + whole(across),
            self.center.1 - whole(upwards),
        )
    }

    /// Returns a value (m) that is larger for points nearer to the viewer.
    pub fn nearness(&self, point: &Vector3<f64>) -> f64 {
        self.toward.dot(point)
    }
}

/// Rounds to the nearest whole number of pixels.
#[expect(
    clippy::cast_possible_truncation,
    reason = "pictures have a few thousand pixels"
)]
pub fn whole(pixels: f64) -> i32 {
    pixels.round() as i32
}
