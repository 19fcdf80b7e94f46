use super::TetMesh;
use crate::geometry::{Aabb, Foot, Triangle};
use nalgebra::Vector3;

/// Triangles in a leaf at most.
const LEAF: usize = 4;

/// Rounding of a distance, relative to the size of the surface, with room.
const ROUNDING: f64 = 1e-14;

/// The triangles of a surface in a binary tree of boxes, for the distance to the nearest. Each node divides its triangles at
/// the middle one along its longest edge.
pub(super) struct SurfaceTree {
    /// Each before its first half's, and these before its second half's.
    nodes: Vec<Node>,
    /// Those of each node follow one another.
    triangles: Vec<Facet>,
    /// What two ways to round a distance (m) may differ by.
    rounding: f64,
}

/// A triangle of the surface.
pub(super) struct Facet {
    triangle: Triangle,
    /// Its corners in the mesh.
    pub vertices: [usize; 3],
}

struct Node {
    bounds: Aabb,
    content: Content,
}

enum Content {
    /// Triangles, from the first to before the last.
    Leaf(usize, usize),
    /// The node of the second half; that of the first half follows its parent.
    Halves(usize),
}

/// The search for the triangle nearest to a point.
struct Nearest<'p> {
    point: &'p Vector3<f64>,
    /// Distance (m) of the nearest so far.
    distance: f64,
    rounding: f64,
    /// Square (m²) of the distance from which on nothing is nearer, however it is rounded.
    limit: f64,
}

impl SurfaceTree {
    /// Over the surface of a mesh: O(n log n).
    pub fn of(mesh: &TetMesh) -> Self {
        let facet = |&vertices: &[usize; 3]| Facet {
            triangle: Triangle::new(vertices.map(|vertex| mesh.vertices()[vertex])),
            vertices,
        };
        let mut triangles: Vec<Facet> = mesh.surface_triangles().iter().map(facet).collect();
        let (mut nodes, count) = (Vec::new(), triangles.len());
        divide(&mut triangles, (0, count), &mut nodes);
        let size = nodes[0].bounds.half_extents().norm();
        Self {
            nodes,
            triangles,
            rounding: ROUNDING * size,
        }
    }

    /// Distance (m) from a point to the nearest triangle: the least of those to all triangles.
    pub fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        let mut nearest = Nearest {
            point,
            distance: f64::INFINITY,
            rounding: self.rounding,
            limit: f64::INFINITY,
        };
        self.approach(0, &mut nearest);
        nearest.distance
    }

    /// Diagonal (m) of the box around the surface.
    pub fn size(&self) -> f64 {
        2.0 * self.nodes[0].bounds.half_extents().norm()
    }

    /// The triangles within a distance (m) from a point: the distance to each, the triangle, and its nearest point.
    pub fn feet(&self, point: &Vector3<f64>, distance: f64) -> Vec<(f64, &Facet, Foot)> {
        let mut feet = Vec::new();
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            let Node { bounds, content } = &self.nodes[node];
            if bounds.squared_distance_to(point) > (distance + self.rounding).powi(2) {
                continue;
            }
            match *content {
                Content::Leaf(first, end) => {
                    let facets = self.triangles[first..end].iter();
                    let found = facets.map(|it| (it.triangle.distance_to(point), it));
                    let near = found.filter(|(found, _)| *found <= distance);
                    feet.extend(near.map(|(found, it)| (found, it, it.triangle.foot_of(point))));
                }
                Content::Halves(second) => open.extend([second, node + 1]),
            }
        }
        feet
    }

    /// Looks at the triangles of a node, where one may be nearer: in the nearer half first.
    fn approach(&self, node: usize, nearest: &mut Nearest) {
        match self.nodes[node].content {
            Content::Leaf(first, end) => {
                for facet in &self.triangles[first..end] {
                    nearest.look_at(&facet.triangle);
                }
            }
            Content::Halves(second) => {
                let mut halves = [node + 1, second].map(|half| {
                    let bounds = &self.nodes[half].bounds;
                    (bounds.squared_distance_to(nearest.point), half)
                });
                if halves[1].0 < halves[0].0 {
                    halves.swap(0, 1);
                }
                for (squared_distance, half) in halves {
                    if squared_distance <= nearest.limit {
                        self.approach(half, nearest);
                    }
                }
            }
        }
    }
}

impl Nearest<'_> {
    fn look_at(&mut self, triangle: &Triangle) {
        // A flat triangle has no plane (NaN), and is looked at.
        if triangle.distance_to_plane(self.point) > self.distance + self.rounding {
            return;
        }
        let distance = triangle.distance_to(self.point);
        if distance < self.distance {
            self.distance = distance;
            self.limit = (distance + self.rounding).powi(2);
        }
    }
}

/// Orders triangles, which begin and end at these places of all, and appends their nodes.
fn divide(triangles: &mut [Facet], (first, end): (usize, usize), nodes: &mut Vec<Node>) {
    let own = &mut triangles[first..end];
    let bounds = Aabb::around(own.iter().flat_map(|facet| facet.triangle.corners()));
    let place = nodes.len();
    nodes.push(Node {
        bounds,
        content: Content::Leaf(first, end),
    });
    if own.len() > LEAF {
        let (axis, middle) = (bounds.half_extents().imax(), own.len() / 2);
        let along = |facet: &Facet| {
            let corners = facet.triangle.corners().iter();
            corners.map(|c| c[axis]).sum::<f64>()
        };
        own.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        divide(triangles, (first, first + middle), nodes);
        nodes[place].content = Content::Halves(nodes.len());
        divide(triangles, (first + middle, end), nodes);
    }
}

#[cfg(test)]
mod tests {
    use super::SurfaceTree;
    use crate::geometry::Triangle;
    use crate::mesh::{TetMesh, shapes};
    use nalgebra::Vector3;

    /// Points in and about the unit cube that lie nowhere in particular.
    fn scattered(count: u32) -> impl Iterator<Item = Vector3<f64>> {
        let steps = Vector3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
        (1..=count).map(move |k| steps.map(|step| (f64::from(k) * step).fract() * 3.0 - 1.5))
    }

    fn assert_least(mesh: &TetMesh, points: impl Iterator<Item = Vector3<f64>>) {
        let tree = SurfaceTree::of(mesh);
        let corners = |triangle: &[usize; 3]| triangle.map(|vertex| mesh.vertices()[vertex]);
        let triangles = mesh.surface_triangles().iter();
        let triangles: Vec<_> = triangles.map(|t| Triangle::new(corners(t))).collect();
        for point in points {
            let all = triangles.iter().map(|t| t.distance_to(&point));
            let least = all.fold(f64::INFINITY, f64::min);
            let found = tree.distance_to(&point);
            assert_eq!(found.to_bits(), least.to_bits(), "{found} {least} {point}");
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
            // On corners, edges and faces of triangles too, and where all of them are equally near.
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
