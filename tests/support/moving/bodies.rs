//! Boxes, prisms, cylinders and layered bodies with edges of equal length.

use crate::support::scenes::{Random, dented_ball, grid, layered};
use hydroelastic::contact::Shape;
use hydroelastic::mesh::{MeshError, PressureField, TriangleSurface, shapes};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Shapes of one size (m).
pub struct Bodies {
    pub size: f64,
    pub shapes: Vec<Shape>,
}

impl Bodies {
    /// Creates shapes with a number, of 0.1 to 1 m.
    pub fn new(number: u64) -> Self {
        let random = &mut Random::numbered(number);
        let size = 10_f64.powf(random.between(-1.0, 0.0));
        let [width, height, low] = [0, 1, 2].map(|_| size * random.between(0.3, 1.0));
        let corners = 3 + random.below(6);
        let extents = [[1.0, 0.5], [1.0, random.between(0.2, 0.9)]][random.below(2)];
        let about_cell = |keep: fn([usize; 3]) -> bool, counts| grid(counts, 0.5 * size, keep);
        let fields = [
            shapes::cuboid([size; 3]),
            shapes::cuboid([size, size, height]),
            shapes::cuboid([width, size, low]),
            shapes::cuboid([0.5 * size; 3]),
            shapes::distance_cuboid([size; 3]),
            shapes::distance_cuboid([size, size, height]),
            shapes::distance_cuboid([width, size, low]),
            shapes::cylinder(0.5 * size, height, 3 + random.below(6)),
            shapes::cylinder(0.5 * size, size, 4),
            prism(corners, size, height),
            prism(4, size, low),
            about_cell(|_| true, &[2, 2, 2]),
            about_cell(|[i, j, _]| i == 0 || j == 0, &[2, 2, 1]),
            shapes::icosphere(0.5 * size, random.below(2)),
            prism(4, size, size).map(|block| layered(&block, extents)),
            prism(corners, size, height).map(|block| layered(&block, extents)),
            Ok(dented_ball(0.5 * size, 0, extents)),
        ];
        Self {
            size,
            shapes: fields.map(|field| Shape::new(field.unwrap())).into(),
        }
    }

    pub fn any(&self, random: &mut Random) -> &Shape {
        &self.shapes[random.below(self.shapes.len())]
    }
}

/// Creates an upright prism over a regular polygon. `width` is the distance between two of its sides. With four corners, the prism is a
/// block.
fn prism(corners: usize, width: f64, height: f64) -> Result<PressureField, MeshError> {
    let radius = 0.5 * width / (TAU / 4.0 * (0.5_f64).min(2.0 / corners as f64)).cos();
    let ring = |z: f64| {
        (0..corners).map(move |k| {
            let angle = (k as f64 + 0.5) * TAU / corners as f64;
            let [x, y] = if corners == 4 {
                [angle.cos().signum(), angle.sin().signum()].map(|side| 0.5 * width * side)
            } else {
                [radius * angle.cos(), radius * angle.sin()]
            };
            Vector3::new(x, y, z)
        })
    };
    let vertices = ring(-0.5 * height).chain(ring(0.5 * height)).collect();
    let mut triangles = Vec::new();
    for k in 0..corners {
        let next = (k + 1) % corners;
        triangles.push([k, next, next + corners]);
        triangles.push([k, next + corners, k + corners]);
        if (1..corners - 1).contains(&k) {
            triangles.push([0, next, k]);
            triangles.push([corners, k + corners, next + corners]);
        }
    }
    let surface = TriangleSurface::new(vertices, triangles).unwrap();
    shapes::star_shaped_about(Vector3::zeros(), &surface)
}
