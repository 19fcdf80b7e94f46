use super::TetMesh;
use crate::bvh::Bvh;
use crate::geometry::{Aabb, Foot, Triangle};
use nalgebra::Vector3;

/// Bound on the rounding error of a distance, relative to the size of the surface, with a safety factor.
const ROUNDING: f64 = 1e-14;

/// A spatial index that computes distances of points to the surface of a mesh.
pub(super) struct SurfaceDistance {
    triangles: Vec<SurfaceTriangle>,
    /// Bounding-volume hierarchy over the indices of the triangles.
    bvh: Bvh<usize>,
    /// Diagonal (m) of the bounding box of the surface.
    size: f64,
    /// Bound on the difference (m) between two roundings of the same distance.
    rounding: f64,
}

/// Returns the triangle closest to a point, of those in a hierarchy over their indices, and its distance (m).
pub(super) fn nearest<'t>(
    point: &Vector3<f64>,
    bvh: &Bvh<usize>,
    triangle: impl Fn(usize) -> &'t Triangle,
) -> (usize, f64) {
    let rounding = ROUNDING * bvh.bounds().half_extents().norm();
    let mut nearest = (0, f64::INFINITY);
    bvh.visit_outwards(point, |index| {
        let triangle = triangle(index);
        // The plane of a flat triangle is NaN, so a flat triangle is never skipped.
        let is_beyond = triangle.distance_to_plane(point) > nearest.1 + rounding;
        if !is_beyond {
            let distance = triangle.distance_to(point);
            if distance < nearest.1 {
                nearest = (index, distance);
            }
        }
        // A box farther away than this has no closer triangle, in spite of rounding.
        (nearest.1 + rounding).powi(2)
    });
    nearest
}

/// A triangle of the surface.
pub(super) struct SurfaceTriangle {
    triangle: Triangle,
    /// The mesh vertices at the corners.
    pub vertices: [usize; 3],
}

impl SurfaceDistance {
    /// Builds the bounding-volume hierarchy over the surface of a mesh in O(n log n) time.
    pub fn of(mesh: &TetMesh) -> Self {
        let triangle = |&vertices: &[usize; 3]| SurfaceTriangle {
            triangle: Triangle::new(vertices.map(|vertex| mesh.vertices()[vertex])),
            vertices,
        };
        let triangles: Vec<_> = mesh.surface_triangles().iter().map(triangle).collect();
        let corners = triangles.iter().map(|facet| *facet.triangle.corners());
        let bvh = Bvh::new(corners.enumerate());
        let radius = bvh.bounds().half_extents().norm();
        Self {
            triangles,
            bvh,
            size: 2.0 * radius,
            rounding: ROUNDING * radius,
        }
    }

    /// Returns the distance (m) from a point to the closest triangle.
    pub fn to(&self, point: &Vector3<f64>) -> f64 {
        nearest(point, &self.bvh, |index| &self.triangles[index].triangle).1
    }

    /// Returns the diagonal (m) of the bounding box of the surface.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Returns the triangles within a distance (m) of a point. Each comes with its distance (m) and its closest point.
    pub fn feet(&self, point: &Vector3<f64>, distance: f64) -> Vec<(f64, &SurfaceTriangle, Foot)> {
        let mut feet = Vec::new();
        let query = Aabb::around([point]).inflated(distance + self.rounding);
        self.bvh.visit_overlapping(&query, |index| {
            let facet = &self.triangles[index];
            let facet_distance = facet.triangle.distance_to(point);
            if facet_distance <= distance {
                feet.push((facet_distance, facet, facet.triangle.foot_of(point)));
            }
        });
        feet
    }
}

#[cfg(test)]
mod tests {
    use super::SurfaceDistance;
    use crate::geometry::Triangle;
    use crate::mesh::{TetMesh, shapes};
    use nalgebra::Vector3;

    /// Generates pseudo-random points in a cube around the shapes.
    fn scattered(count: u32) -> impl Iterator<Item = Vector3<f64>> {
        let steps = Vector3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
        (1..=count).map(move |k| steps.map(|step| (f64::from(k) * step).fract() * 3.0 - 1.5))
    }

    fn assert_least(mesh: &TetMesh, points: impl Iterator<Item = Vector3<f64>>) {
        let surface = SurfaceDistance::of(mesh);
        let corners = |triangle: &[usize; 3]| triangle.map(|vertex| mesh.vertices()[vertex]);
        let triangles = mesh.surface_triangles().iter();
        let triangles: Vec<_> = triangles.map(|t| Triangle::new(corners(t))).collect();
        for point in points {
            let all = triangles.iter().map(|t| t.distance_to(&point));
            let least = all.fold(f64::INFINITY, f64::min);
            let actual = surface.to(&point);
            assert_eq!(
                actual.to_bits(),
                least.to_bits(),
                "{actual} {least} {point}"
            );
        }
    }

    #[test]
    fn the_tree_finds_the_least_distance_of_all_triangles_to_the_bit() {
        let fields = [
            shapes::icosphere(1.0, 3),
            shapes::ellipsoid([0.02, 0.9, 1.3], 3),
            shapes::cylinder(0.7, 1.9, 40),
            shapes::cuboid([0.7, 1e-4, 2.0]),
        ];
        for field in fields {
            let mesh = field.unwrap().mesh().clone();
            // Includes points on corners and faces of triangles, and a point that is equally close to all of them.
            let middles = mesh.tets().iter().map(|tet| {
                let [a, b, c, _] = tet.map(|vertex| mesh.vertices()[vertex]);
                (a + b + c) / 3.0
            });
            let special = mesh.vertices().iter().copied().chain(middles);
            let origin = [Vector3::zeros()];
            assert_least(&mesh, scattered(300).chain(special.take(900)).chain(origin));
        }
    }
}
