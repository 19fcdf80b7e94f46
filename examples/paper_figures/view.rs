//! A camera without perspective.

use nalgebra::Vector3;

/// A place on the picture, in pixels from its upper left corner.
pub type Pixel = (i32, i32);

/// How the world comes to lie on the picture.
pub struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector from what is seen to the viewer.
    toward: Vector3<f64>,
    /// The point (m) that is seen at the pixel `center`.
    pub target: Vector3<f64>,
    pub center: Pixel,
    /// Pixels per meter.
    pub scale: f64,
}

impl View {
    /// Seen from a direction, z upwards.
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

    /// Where a point (m) is seen.
    pub fn pixel(&self, point: &Vector3<f64>) -> Pixel {
        let offset = (point - self.target) * self.scale;
        let (across, upwards) = (self.right.dot(&offset), self.up.dot(&offset));
        (
            self.center.0 + whole(across),
            self.center.1 - whole(upwards),
        )
    }

    /// How near to the viewer a point is (m), beside others.
    pub fn nearness(&self, point: &Vector3<f64>) -> f64 {
        self.toward.dot(point)
    }
}

/// The nearest whole number of pixels.
#[expect(
    clippy::cast_possible_truncation,
    reason = "pictures have a few thousand pixels"
)]
pub fn whole(pixels: f64) -> i32 {
    pixels.round() as i32
}
