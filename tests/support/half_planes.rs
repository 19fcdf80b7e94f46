//! An independent twin of the contact kernel, slow and simple. It visits all pairs of tetrahedra. Pressures come from the inverse of the
//! 4×4 vertex matrix (the paper, §III-B). The contact polygon is an intersection of eight half-planes (§III-E), and integrals use the
//! edge-midpoint rule.

use hydroelastic::contact::{ContactBody, ContactPair};
use nalgebra::{Matrix4, RowVector4, Vector2, Vector3, Vector4, Vector6};

/// Distance outside a half-plane, in heights of its tetrahedron, at which a point counts as inside.
const SLACK: f64 = 1e-12;

/// Force and torque on A about A's origin, in the world, and the contact area.
pub struct Twin {
    pub wrench: Vector6<f64>,
    pub area: f64,
}

/// A tetrahedron in the world. The rows of barycentric coordinates and pressure apply to (x, 1).
struct WorldTet {
    barycentric: Matrix4<f64>,
    pressure: RowVector4<f64>,
    corners: Matrix4<f64>,
}

fn world_tets(body: &ContactBody) -> Vec<WorldTet> {
    let field = body.shape().field();
    let mesh = field.mesh();
    let world_tet = |tet: &[usize; 4]| {
        let corner = |&vertex: &usize| {
            let position = body.pose().transformed_point(&mesh.vertices()[vertex]);
            position.push(1.0)
        };
        let corners = Matrix4::from_columns(&tet.each_ref().map(corner));
        let barycentric = corners.try_inverse().unwrap();
        let pressures = tet.map(|vertex| body.modulus() * field.extents()[vertex]);
        WorldTet {
            pressure: RowVector4::from(pressures) * barycentric,
            barycentric,
            corners,
        }
    };
    mesh.tets().iter().map(world_tet).collect()
}

/// Computes the wrench by brute force, for generic poses only, because there is no rule for planes in shared faces.
pub fn wrench(pair: &ContactPair) -> Twin {
    let (tets_a, tets_b) = (world_tets(pair.a()), world_tets(&pair.b().body().unwrap()));
    let origin = pair.a().pose().translation();
    let mut twin = Twin {
        wrench: Vector6::zeros(),
        area: 0.0,
    };
    for a in &tets_a {
        for b in &tets_b {
            if let Some((normal, polygon)) = contact_polygon(a, b) {
                twin.add(&normal, &polygon, &a.pressure, origin);
            }
        }
    }
    twin
}

/// Returns the normal and the corners of the equal-pressure polygon, in cyclic order.
fn contact_polygon(a: &WorldTet, b: &WorldTet) -> Option<(Vector3<f64>, Vec<Vector3<f64>>)> {
    let excess = a.pressure - b.pressure;
    let misses = |tet: &WorldTet| {
        let values = excess * tet.corners;
        values.iter().all(|&v| v > 0.0) || values.iter().all(|&v| v < 0.0)
    };
    if misses(a) || misses(b) {
        return None;
    }
    let gradient = excess.fixed_columns::<3>(0).transpose();
    let normal = gradient.normalize();
    let base = gradient * (-excess[3] / gradient.norm_squared());
    let seed = Vector3::ith(normal.iamin(), 1.0);
    let axis_u = normal.cross(&seed).normalize();
    let axis_v = normal.cross(&axis_u);
    let half_planes: Vec<(Vector2<f64>, f64)> = [a, b]
        .iter()
        .flat_map(|tet| tet.barycentric.row_iter())
        .map(|row| {
            let slope = row.fixed_columns::<3>(0).transpose();
            let offset = slope.dot(&base) + row[3];
            (Vector2::new(slope.dot(&axis_u), slope.dot(&axis_v)), offset)
        })
        .collect();
    let corners = ordered(intersection(&half_planes));
    let lifted = corners.iter().map(|c| base + axis_u * c.x + axis_v * c.y);
    (corners.len() >= 3).then(|| (normal, lifted.collect()))
}

/// Returns the crossings of any two borders that lie in all half-planes `slope·x + offset ≥ 0`.
fn intersection(half_planes: &[(Vector2<f64>, f64)]) -> Vec<Vector2<f64>> {
    let mut corners = Vec::new();
    for (i, (slope_i, offset_i)) in half_planes.iter().enumerate() {
        for (slope_j, offset_j) in &half_planes[i + 1..] {
            let determinant = slope_i.perp(slope_j);
            if determinant.abs() <= 1e-13 * slope_i.norm() * slope_j.norm() {
                continue;
            }
            let crossing = Vector2::new(
                slope_i.y * offset_j - slope_j.y * offset_i,
                slope_j.x * offset_i - slope_i.x * offset_j,
            ) / determinant;
            let inside =
                |(slope, offset): &(Vector2<f64>, f64)| slope.dot(&crossing) + offset >= -SLACK;
            if half_planes.iter().all(inside) {
                corners.push(crossing);
            }
        }
    }
    corners
}

/// Returns the points of a convex outline in the order of their angle about their mean.
fn ordered(mut corners: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    let mean = corners.iter().sum::<Vector2<f64>>() / corners.len().max(1) as f64;
    let angle = |corner: &Vector2<f64>| (corner.y - mean.y).atan2(corner.x - mean.x);
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    corners
}

impl Twin {
    fn add(
        &mut self,
        normal: &Vector3<f64>,
        corners: &[Vector3<f64>],
        pressure: &RowVector4<f64>,
        origin: &Vector3<f64>,
    ) {
        for pair in corners[1..].windows(2) {
            let triangle = [corners[0], pair[0], pair[1]];
            let cross = (triangle[1] - triangle[0]).cross(&(triangle[2] - triangle[0]));
            let area = cross.norm() / 2.0;
            self.area += area;
            for (p, q) in [(0, 1), (1, 2), (2, 0)] {
                let midpoint = (triangle[p] + triangle[q]) / 2.0;
                let homogeneous: Vector4<f64> = midpoint.push(1.0);
                let force = normal * ((pressure * homogeneous)[0] * area / 3.0);
                let torque = (midpoint - origin).cross(&force);
                self.wrench += Vector6::from_iterator(torque.iter().chain(force.iter()).copied());
            }
        }
    }
}
