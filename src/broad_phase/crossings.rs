//! Search for the triangles of two surfaces that may cross.
//!
//! Each node of B's tree receives a list of the nodes of A's tree that it may touch, all of one
//! level. It narrows the list for its children. A node of A is dropped if its box does not overlap
//! the box of B's node, or is outside its slab. Around a patch of a smooth surface, the two planes
//! of a slab are much closer together than the sides of the box. Finally, four triangles of one
//! body are tested against one triangle of the other body.

use super::box_slab::{BoxSlab, RelativePose};
use super::slabs::{BoxesAndSlabs, FourSlabs};
use super::traversal_kernels::{CrossFour, CrossOne, FilterNodes, Keeping, TransformNode};
use super::triangle_bvh::{SurfaceFace, TriangleBvh};
use crate::bvh::{Node, WIDTH};
use crate::lanes;
use crate::spatial::Pose;
use std::ops::Range;

/// Visits the pairs of triangles of two surfaces, one in A and one in B, that may cross or touch.
/// The boxes of such a pair overlap, and neither triangle is entirely on one side of the plane of
/// the other, all to within `margin` (m). `memory` is scratch memory.
pub(crate) fn visit_crossing_triangles(
    [a, b]: [&TriangleBvh; 2],
    pose_ab: &Pose<f64>,
    margin: f64,
    memory: &mut Vec<u32>,
    visit: impl FnMut(SurfaceFace, SurfaceFace),
) {
    // The first list is the root of A.
    memory.resize(memory.len().max(1), 0);
    memory[0] = 0;
    let mut descent = Descent {
        a,
        b,
        pose_ab,
        margin,
        frame: RelativePose::new(a.bvh().bounds(), pose_ab, margin),
        memory,
        visit,
    };
    let root = Partners {
        level: 0,
        entries: 0..1,
    };
    descent.descend(Node::ROOT, &root);
}

/// A simultaneous descent into both trees. It follows the tree of B, with a list of the nodes of A
/// that each node of B may touch.
struct Descent<'s, 'm, V> {
    a: &'s TriangleBvh,
    b: &'s TriangleBvh,
    pose_ab: &'s Pose<f64>,
    margin: f64,
    frame: RelativePose,
    /// Lists of nodes or triangles, stored as a stack. The lists for a node of B follow those for
    /// its parent.
    memory: &'m mut Vec<u32>,
    visit: V,
}

/// A list of nodes of A on one level, or of triangles below the last level, as a range of the
/// memory.
struct Partners {
    level: usize,
    entries: Range<usize>,
}

impl<V: FnMut(SurfaceFace, SurfaceFace)> Descent<'_, '_, V> {
    /// Descends from a node of B, given the nodes of A that it may touch. Continues with the
    /// children of the node or, on the last level, with the triangles of both bodies.
    fn descend(&mut self, node: Node, partners: &Partners) {
        let (boxes, slabs, near) = lanes::run(TransformNode {
            frame: &self.frame,
            node: self.b.level(node.level).node(node.index),
        });
        let posed = BoxesAndSlabs {
            boxes: &boxes,
            slabs: &slabs,
        };
        let (b, depth_a) = (self.b, self.a.depth());
        let near_slots =
            |count: usize| (0..WIDTH.min(count)).filter(move |slot| near >> slot & 1 != 0);
        let (level, first) = (node.level + 1, WIDTH * node.index);
        if level < b.depth() {
            let (count, is_next_last) = (b.level(level).boxes.len(), level + 1 == b.depth());
            for slot in near_slots(count - first) {
                let box_slab = BoxSlab::of(posed, slot);
                let mut near = self.narrowed(&box_slab, partners, b.sizes()[level]);
                // If triangles are the next level of both trees, four triangles of B are tested at
                // once against the triangles of A. If A's tree is finer than B's, each triangle of
                // B narrows the list further.
                if is_next_last && near.level + 1 == depth_a {
                    near = self.divided(&box_slab, &near);
                }
                if !near.entries.is_empty() {
                    let index = first + slot;
                    self.descend(Node { level, index }, &near);
                }
            }
            return;
        }
        if partners.level == depth_a {
            self.meet_four(&slabs, first, partners.entries.clone());
            return;
        }
        for slot in near_slots(b.faces().len() - first) {
            let box_slab = BoxSlab::of(posed, slot);
            let near = self.narrowed(&box_slab, partners, 0.0);
            self.meet_one(box_slab, first + slot, near.entries);
        }
    }

    /// Returns the nodes of A that a part of B's surface may touch, subdivided until they are about
    /// as large as that part (`size`, m).
    fn narrowed(&mut self, box_slab: &BoxSlab, partners: &Partners, size: f64) -> Partners {
        let sizes = self.a.sizes();
        let is_larger = |level: usize| level + 1 < sizes.len() && sizes[level] > size;
        if !is_larger(partners.level) {
            return self.filtered(box_slab, partners);
        }
        let mut near = self.divided(box_slab, partners);
        while is_larger(near.level) {
            near = self.divided(box_slab, &near);
        }
        near
    }

    /// Returns the children of nodes of A that may touch a part of B's surface.
    fn divided(&mut self, box_slab: &BoxSlab, partners: &Partners) -> Partners {
        self.kept(box_slab, partners, Keeping::Children)
    }

    /// Returns the nodes of A with a child that may touch a part of B's surface.
    fn filtered(&mut self, box_slab: &BoxSlab, partners: &Partners) -> Partners {
        self.kept(box_slab, partners, Keeping::Nodes)
    }

    fn kept(&mut self, box_slab: &BoxSlab, partners: &Partners, keeping: Keeping) -> Partners {
        let Partners { level, ref entries } = *partners;
        self.make_room(entries.end + WIDTH * entries.len());
        let end = lanes::run(FilterNodes {
            nodes: self.a.level(level).boxes,
            box_slab,
            keeping,
            memory: &mut *self.memory,
            entries: entries.clone(),
        });
        Partners {
            level: match keeping {
                Keeping::Children => level + 1,
                Keeping::Nodes => level,
            },
            entries: entries.end..end,
        }
    }

    /// Visits the pairs that may cross of triangles of A and triangles of one node of B. `first` is
    /// the index of the node's first triangle.
    fn meet_four(&mut self, slabs: &FourSlabs, first: usize, triangles: Range<usize>) {
        self.make_room(triangles.end + WIDTH * triangles.len());
        let end = lanes::run(CrossFour {
            frame: &self.frame,
            slabs,
            corners_b: &self.b.corners()[first / WIDTH],
            a: self.a,
            margin: self.margin,
            memory: &mut *self.memory,
            triangles: triangles.clone(),
        });
        let (faces_a, faces_b) = (self.a.faces(), &self.b.faces()[first..]);
        // Each entry is four times the index of a triangle of A, plus a slot of B's node.
        for pair in &self.memory[triangles.end..end] {
            let (index, slot) = (*pair as usize / WIDTH, *pair as usize % WIDTH);
            // A node with fewer than four triangles repeats the last triangle.
            if let Some(face_b) = faces_b.get(slot) {
                (self.visit)(faces_a[index], *face_b);
            }
        }
    }

    /// Visits the pairs that may cross of triangles below nodes of A and one triangle of B, given
    /// the planes of that triangle.
    fn meet_one(&mut self, planes: BoxSlab, index_b: usize, nodes: Range<usize>) {
        let corners = self.b.corners_of(index_b);
        let corners = corners.map(|corner| self.pose_ab.transformed_point(&corner));
        self.make_room(nodes.end + WIDTH * nodes.len());
        let end = lanes::run(CrossOne {
            box_slab: planes.around(&corners, self.margin),
            corners,
            a: self.a,
            margin: self.margin,
            memory: &mut *self.memory,
            nodes: nodes.clone(),
        });
        let (faces_a, face_b) = (self.a.faces(), self.b.faces()[index_b]);
        for index in &self.memory[nodes.end..end] {
            (self.visit)(faces_a[*index as usize], face_b);
        }
    }

    #[inline]
    fn make_room(&mut self, count: usize) {
        if self.memory.len() < count {
            self.memory.resize(count, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::visit_crossing_triangles;
    use crate::broad_phase::triangle_bvh::{SurfaceFace, TriangleBvh};
    use crate::geometry::Aabb;
    use crate::mesh::{FieldTet, PressureField, shapes};
    use crate::spatial::Pose;
    use nalgebra::{Vector3, vector};
    use std::collections::BTreeSet;
    use std::f64::consts::FRAC_PI_2;

    const MARGIN: f64 = 1e-13;
    /// Rounding error of the coordinates of triangles that touch.
    const TOUCH: f64 = 1e-15;
    /// Length below which a cross product of edges is the rounding error of parallel edges.
    const PARALLEL: f64 = 1e-10;

    type Corners = [Vector3<f64>; 3];

    /// A surface with its tree, and its triangles in an order independent of the tree.
    struct Body {
        tree: TriangleBvh,
        tets: Vec<FieldTet>,
        faces: Vec<SurfaceFace>,
    }

    impl Body {
        fn of(field: &PressureField) -> Self {
            Self::with(TriangleBvh::of(field), field.tets())
        }

        /// Creates a body from cells, of which face 3 is on the surface.
        fn of_cells(cells: &[FieldTet]) -> Self {
            Self::with(TriangleBvh::of_cells(cells), cells)
        }

        fn with(tree: TriangleBvh, tets: &[FieldTet]) -> Self {
            let mut faces = tree.faces().to_vec();
            faces.sort_by_key(|face| (face.tet(), face.face()));
            Self {
                tree,
                tets: tets.to_vec(),
                faces,
            }
        }
    }

    fn normal([a, b, c]: &Corners) -> Vector3<f64> {
        (b - a).cross(&(c - a)).normalize()
    }

    /// Returns whether all points are on one side of a triangle's plane, farther away than the
    /// margin.
    fn is_beside(points: &Corners, triangle: &Corners) -> bool {
        let normal = normal(triangle);
        let heights = points.map(|point| normal.dot(&(point - triangle[0])));
        heights.iter().all(|&height| height > MARGIN)
            || heights.iter().all(|&height| height < -MARGIN)
    }

    fn may_cross(a: &Corners, b: &Corners) -> bool {
        let near = Aabb::around(a).overlaps(&Aabb::around(b).inflated(MARGIN));
        near && !is_beside(a, b) && !is_beside(b, a)
    }

    /// Returns whether no direction separates the triangles. Tests all directions of the
    /// separating-axis theorem.
    fn share_a_point(a: &Corners, b: &Corners) -> bool {
        let edges = |t: &Corners| [t[1] - t[0], t[2] - t[1], t[0] - t[2]];
        let (edges_a, edges_b) = (edges(a), edges(b));
        let mut directions = vec![normal(a), normal(b)];
        for edge in edges_a {
            directions.push(normal(a).cross(&edge));
            directions.extend(edges_b.map(|edge_b| edge.cross(&edge_b)));
        }
        directions.extend(edges_b.map(|edge| normal(b).cross(&edge)));
        let limits = |triangle: &Corners, direction: &Vector3<f64>| {
            let heights = triangle.map(|corner| direction.dot(&(corner - a[0])));
            (
                heights.iter().copied().fold(f64::INFINITY, f64::min),
                heights.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        directions
            .iter()
            .filter(|direction| direction.norm() > PARALLEL)
            .all(|direction| {
                let direction = direction.normalize();
                let ((low_a, high_a), (low_b, high_b)) =
                    (limits(a, &direction), limits(b, &direction));
                low_a - high_b <= TOUCH && low_b - high_a <= TOUCH
            })
    }

    type Pair = [(usize, usize); 2];

    fn by_trees(a: &Body, b: &Body, pose_ab: &Pose) -> Vec<Pair> {
        let (mut pairs, mut memory) = (Vec::new(), Vec::new());
        let surfaces = [&a.tree, &b.tree];
        visit_crossing_triangles(surfaces, pose_ab, MARGIN, &mut memory, |a, b| {
            pairs.push([a, b].map(|face| (face.tet(), face.face())));
        });
        pairs
    }

    /// Returns the pairs for which `is_asked` is true.
    fn by_all_pairs(
        [a, b]: [&Body; 2],
        pose_ab: &Pose,
        is_asked: fn(&Corners, &Corners) -> bool,
    ) -> BTreeSet<Pair> {
        let mut pairs = BTreeSet::new();
        for face_b in &b.faces {
            let corners_b = face_b.corners(&b.tets);
            let posed_b = corners_b.map(|corner| pose_ab.transformed_point(&corner));
            for face_a in &a.faces {
                if is_asked(&face_a.corners(&a.tets), &posed_b) {
                    pairs.insert([face_a, face_b].map(|face| (face.tet(), face.face())));
                }
            }
        }
        pairs
    }

    /// Asserts that the trees find all triangles that share a point, each once, and no pair that
    /// boxes or planes separate. Returns the number of pairs that share a point, from a test of all
    /// pairs.
    fn assert_all_found(a: &Body, b: &Body, pose_ab: &Pose) -> usize {
        let list = by_trees(a, b, pose_ab);
        let pairs: BTreeSet<Pair> = list.iter().copied().collect();
        assert_eq!(pairs.len(), list.len(), "some are found twice");
        let least = by_all_pairs([a, b], pose_ab, share_a_point);
        let most = by_all_pairs([a, b], pose_ab, may_cross);
        assert!(pairs.is_superset(&least), "{:?}", least.difference(&pairs));
        assert!(pairs.is_subset(&most), "{:?}", pairs.difference(&most));
        least.len()
    }

    /// Returns poses in general position, up to `reach` (m) from the origin along each axis.
    fn scattered(count: u32, reach: f64) -> impl Iterator<Item = Pose> {
        let steps = vector![0.819_172_5, 0.671_043_6, 0.549_700_5];
        (1..=count).map(move |k| {
            let at =
                |factor: f64| steps.map(|step| (f64::from(k) * factor * step).fract() * 2.0 - 1.0);
            Pose::from_rotation_vector(&(at(1.618) * 3.0), at(1.0) * reach)
        })
    }

    fn icosphere(radius: f64, order: usize) -> Body {
        Body::of(&shapes::icosphere(radius, order).unwrap())
    }

    fn cuboid(edges: [f64; 3]) -> Body {
        Body::of(&shapes::cuboid(edges).unwrap())
    }

    #[test]
    fn the_trees_find_all_pairs_that_share_a_point() {
        let bodies = [
            icosphere(1.0, 2),
            icosphere(1.0, 0),
            icosphere(0.1, 1),
            cuboid([1.5, 0.4, 1.0]),
            cuboid([2.0, 1e-3, 2.0]),
            Body::of(&shapes::ellipsoid([0.3, 1.2, 0.6], 1).unwrap()),
        ];
        let mut total = 0;
        for a in &bodies {
            for b in &bodies {
                let counts = scattered(20, 1.2).map(|pose_ab| assert_all_found(a, b, &pose_ab));
                total += counts.sum::<usize>();
            }
        }
        assert!(total > 10_000, "{total}");
    }

    #[test]
    fn few_triangles_and_a_fine_surface_cross_where_all_pairs_say() {
        let fine = icosphere(1.0, 3);
        let cells = shapes::icosphere(1.0, 0).unwrap().tets().to_vec();
        for count in [1, 2, 3, 4, 5, 16, 17, 20] {
            let few = Body::of_cells(&cells[..count]);
            let mut total = 0;
            for pose_ab in scattered(20, 0.8) {
                total += assert_all_found(&fine, &few, &pose_ab);
                total += assert_all_found(&few, &fine, &pose_ab.inverse());
                total += assert_all_found(&few, &few, &pose_ab);
            }
            assert!(total > 0);
        }
    }

    #[test]
    fn faces_that_are_flush_or_in_one_plane_are_found() {
        let (cube, slab) = (cuboid([1.0; 3]), cuboid([3.0, 3.0, 0.5]));
        let quarter_turn = Vector3::x() * FRAC_PI_2;
        let poses = [
            Pose::identity(),
            Pose::from_translation(vector![1.0, 0.0, 0.0]),
            Pose::from_translation(vector![1.0, 1.0, 0.0]),
            Pose::from_translation(vector![1.0, 1.0, 1.0]),
            Pose::from_translation(vector![0.25, 0.0, 0.75]),
            Pose::from_rotation_vector(&quarter_turn, vector![0.0, 0.5, 0.0]),
        ];
        for pose_ab in &poses {
            assert!(assert_all_found(&cube, &cube, pose_ab) > 0);
            assert_all_found(&cube, &slab, pose_ab);
            assert_all_found(&slab, &cube, &pose_ab.inverse());
        }
        assert!(assert_all_found(&cube, &slab, &poses[4]) > 0);
    }

    #[test]
    fn surfaces_apart_do_not_cross() {
        let ball = icosphere(1.0, 2);
        let apart = Pose::from_translation(vector![1.2, 1.2, 1.2]);
        assert_eq!(assert_all_found(&ball, &ball, &apart), 0);
        assert!(by_trees(&ball, &ball, &apart).is_empty());
    }

    #[test]
    fn memory_is_used_again_and_the_order_is_the_same() {
        let ball = icosphere(1.0, 2);
        let pose_ab = Pose::from_translation(vector![0.9, 0.7, 0.2]);
        let mut memory = Vec::new();
        let mut search = || {
            let (mut crossings, surfaces) = (Vec::new(), [&ball.tree; 2]);
            visit_crossing_triangles(surfaces, &pose_ab, MARGIN, &mut memory, |a, b| {
                crossings.push([a, b]);
            });
            (crossings, memory.capacity())
        };
        let first = search();
        assert!(first.0.len() > 20);
        assert_eq!(first, search());
    }
}
