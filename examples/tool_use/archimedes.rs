//! Force of a liquid on a solid that floats in it.

use hydroelastic::mesh::TriangleSurface;
use hydroelastic::spatial::{Pose, Wrench};
use nalgebra::Vector3;

/// Returns the wrench of a liquid on a closed surface at a pose, about the origin of the pose. The liquid's surface is at a height (m), and
/// its pressure grows by a slope (Pa/m). The wrench is the integral of the pressure over the wet triangles.
pub fn buoyancy(surface: &TriangleSurface, pose: &Pose, height: f64, slope: f64) -> Wrench {
    let mut wrench = Wrench::zero();
    for triangle in 0..surface.triangles().len() {
        let corners = surface.corners(triangle);
        let wet = below(&corners.map(|p| pose.transformed_point(&p)), height);
        for i in 2..wet.len() {
            let [a, b, c] = [wet[0], wet[i - 1], wet[i]];
            let inward = (c - a).cross(&(b - a)) / 2.0;
            // Pressure times arm has degree two, so the edge-midpoint rule is exact.
            for middle in [a + b, b + c, c + a].map(|sum| sum / 2.0) {
                let force = inward * (slope * (height - middle.z) / 3.0);
                wrench.force += force;
                wrench.torque += (middle - pose.translation()).cross(&force);
            }
        }
    }
    wrench
}

/// Returns the part of a triangle below a height.
fn below(corners: &[Vector3<f64>; 3], height: f64) -> Vec<Vector3<f64>> {
    let mut part = Vec::new();
    for (i, p) in corners.iter().enumerate() {
        let q = &corners[(i + 1) % 3];
        let [depth_p, depth_q] = [p, q].map(|point| height - point.z);
        if depth_p >= 0.0 {
            part.push(*p);
        }
        if (depth_p < 0.0) != (depth_q < 0.0) {
            part.push(p + (q - p) * (depth_p / (depth_p - depth_q)));
        }
    }
    part
}
