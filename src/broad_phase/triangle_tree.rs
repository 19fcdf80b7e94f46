use super::flat_tree::{WIDTH, arrange, set_box, side_by_side};
use super::nodes::{FourCorners, Node};
use crate::geometry::{Aabb, FACES};
use crate::mesh::{FieldTet, PressureField};
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::array::from_fn;

/// The triangles of a body's surface in a tree like a [`FlatTree`](super::flat_tree::FlatTree), in the body frame: child k of
/// node i is node 4i + k of the level below, or triangle 4i + k.
#[derive(Debug, Clone)]
pub(crate) struct TriangleTree {
    /// From the root down.
    levels: Vec<Level>,
    /// The triangles, those of each node one after the other.
    faces: Vec<SurfaceFace>,
    /// Their corners (m), of each node of the last level.
    corners: Vec<FourCorners>,
    /// The box around all of them: along each axis, the smallest coordinate (m) and the largest.
    bounds: [[f64; 2]; 3],
}

/// The nodes that are equally deep.
#[derive(Debug, Clone)]
pub(super) struct Level {
    pub nodes: Vec<Node>,
    /// Mean length (m) of the longest edges of the boxes around the nodes.
    pub size: f64,
}

/// A triangle of the surface, as a face of its tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SurfaceFace {
    tet: u32,
    face: u8,
}

/// A triangle that is about to find its place in the tree.
struct Facet {
    face: SurfaceFace,
    corners: [Vector3<f64>; 3],
}

impl SurfaceFace {
    /// The tetrahedron.
    pub fn tet(self) -> usize {
        self.tet as usize
    }

    /// The corner of the tetrahedron opposite to it.
    pub fn face(self) -> usize {
        self.face.into()
    }

    /// Its corners, given all tetrahedra of the body.
    #[inline]
    pub fn corners(self, tets: &[FieldTet]) -> [Vector3<f64>; 3] {
        let corners = &tets[self.tet()].tetrahedron.corners;
        FACES[self.face()].map(|corner| corners[corner])
    }
}

impl TriangleTree {
    /// Of a compliant body: the faces of its tetrahedra that have no neighbor.
    pub fn of(field: &PressureField) -> Self {
        let faces = (0_u32..).zip(field.tets()).flat_map(|(tet, _)| {
            let mesh = field.mesh();
            let is_surface = move |face: &u8| mesh.neighbor(tet as usize, (*face).into()).is_none();
            (0_u8..4)
                .filter(is_surface)
                .map(move |face| SurfaceFace { tet, face })
        });
        Self::new(faces, field.tets())
    }

    /// Of a rigid body, from the cells behind its triangles: each triangle is face 3 of its cell.
    pub fn of_cells(cells: &[FieldTet]) -> Self {
        let faces = (0_u32..).zip(cells);
        Self::new(faces.map(|(tet, _)| SurfaceFace { tet, face: 3 }), cells)
    }

    /// O(n log n).
    fn new(faces: impl Iterator<Item = SurfaceFace>, tets: &[FieldTet]) -> Self {
        let facet = |face: SurfaceFace| Facet {
            face,
            corners: face.corners(tets),
        };
        let mut facets: Vec<Facet> = faces.map(facet).collect();
        arrange(&mut facets, &|facet| facet.corners.iter().sum());
        let around = Aabb::around(facets.iter().flat_map(|facet| &facet.corners));
        Self {
            levels: levels_over(&facets),
            faces: facets.iter().map(|facet| facet.face).collect(),
            corners: facets
                .chunks(WIDTH)
                .map(|four| side_by_side(four, |facet| &facet.corners))
                .collect(),
            bounds: from_fn(|axis| [around.lower[axis], around.upper[axis]]),
        }
    }

    /// The box around the surface: along each axis, the smallest coordinate (m) and the largest.
    pub(super) fn bounds(&self) -> &[[f64; 2]; 3] {
        &self.bounds
    }

    /// From the root down.
    pub(super) fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// The nodes with triangles.
    pub(super) fn leaves(&self) -> &[Node] {
        self.levels.last().map_or(&[], |level| &level.nodes)
    }

    /// The triangles; those of node i of the last level from 4i on.
    pub(super) fn faces(&self) -> &[SurfaceFace] {
        &self.faces
    }

    /// The corners (m) of the triangles of each node of the last level; the last triangle again where there are fewer than
    /// four.
    pub(super) fn corners(&self) -> &[FourCorners] {
        &self.corners
    }

    /// The corners (m) of one triangle.
    #[inline]
    pub(super) fn corners_of(&self, triangle: usize) -> [Vector3<f64>; 3] {
        let (four, slot) = (&self.corners[triangle / WIDTH], triangle % WIDTH);
        four.each_ref()
            .map(|[x, y, z]| Vector3::new(x[slot], y[slot], z[slot]))
    }

    /// Visits the tetrahedra (of B; of a rigid body the cells, as its triangles are numbered) with a triangle of the surface
    /// whose box may overlap the box `region` in A: that no face of either separates by more than `margin` (m). One with
    /// several such triangles is visited for each.
    pub fn visit_near(
        &self,
        region: &Aabb,
        pose_ab: &Pose<f64>,
        margin: f64,
        mut visit: impl FnMut(usize),
    ) {
        let query = region.posed(&pose_ab.inverse()).inflated(margin);
        let is_near = |child: &Aabb| {
            child.overlaps(&query) && region.may_overlap_posed(child, pose_ab, margin)
        };
        self.visit_where(0, 0, &is_near, &mut visit);
    }

    fn visit_where(
        &self,
        level: usize,
        index: usize,
        is_near: &impl Fn(&Aabb) -> bool,
        visit: &mut impl FnMut(usize),
    ) {
        let Some(node) = self.levels.get(level).and_then(|it| it.nodes.get(index)) else {
            return;
        };
        for slot in (0..WIDTH).filter(|&slot| is_near(&node.aabb(slot))) {
            let child = WIDTH * index + slot;
            if level + 1 < self.levels.len() {
                self.visit_where(level + 1, child, is_near, visit);
            } else {
                visit(self.faces[child].tet());
            }
        }
    }
}

/// The node around these parts of a surface.
fn node_over<'f>(parts: impl Iterator<Item = &'f [Facet]>) -> Node {
    let mut node = Node::EMPTY;
    for (slot, part) in parts.enumerate() {
        let corners = || part.iter().flat_map(|facet| &facet.corners);
        let normal = mean_normal(part);
        let heights = corners().map(|corner| normal.dot(corner));
        let [lowest, highest] = node.between.each_mut().map(|it| &mut it[slot]);
        for height in heights {
            (*lowest, *highest) = (lowest.min(height), highest.max(height));
        }
        set_box(&mut node.bounds, slot, &Aabb::around(corners()));
        for axis in 0..3 {
            node.normal[axis][slot] = normal[axis];
        }
    }
    node
}

/// The direction of the sum of the triangles' area vectors; 0 where they cancel.
fn mean_normal(part: &[Facet]) -> Vector3<f64> {
    let vectors = part.iter().map(|facet| {
        let [a, b, c] = facet.corners;
        (b - a).cross(&(c - a))
    });
    let sum: Vector3<f64> = vectors.sum();
    sum.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
}

/// The levels of the tree over triangles in their order, from the root down.
fn levels_over(facets: &[Facet]) -> Vec<Level> {
    // Triangles to a child of a full node, from the last level up to the one with a single node.
    let mut full = 1;
    let mut levels = Vec::new();
    while full == 1 || full < facets.len() {
        let nodes = facets.chunks(WIDTH * full);
        levels.push(Level {
            nodes: nodes
                .clone()
                .map(|part| node_over(part.chunks(full)))
                .collect(),
            size: mean_size(nodes),
        });
        full *= WIDTH;
    }
    levels.reverse();
    levels
}

/// Mean length (m) of the longest edges of the boxes around these parts of a surface.
fn mean_size<'f>(nodes: impl ExactSizeIterator<Item = &'f [Facet]>) -> f64 {
    let count = nodes.len() as f64;
    let size = |part: &[Facet]| {
        let aabb = Aabb::around(part.iter().flat_map(|facet| &facet.corners));
        2.0 * aabb.half_extents().max()
    };
    nodes.map(size).sum::<f64>() / count
}
