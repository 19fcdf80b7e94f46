use super::slabs::{FourSlabs, Level};
use crate::bvh::{Bvh, FourBoxes, FourCorners, PerNode, WIDTH};
use crate::geometry::FACES;
use crate::mesh::{FieldTet, PressureField};
use nalgebra::Vector3;

/// The triangles of a body's surface in a bounding-volume hierarchy of boxes and slabs, in the body
/// frame.
#[derive(Debug, Clone)]
pub(crate) struct TriangleBvh {
    bvh: Bvh<SurfaceFace>,
    slabs: PerNode<FourSlabs>,
    /// Mean length (m) of the longest edges of the boxes around the nodes, for each level.
    sizes: Vec<f64>,
    /// Corners (m) of the triangles of each node of the last level.
    corners: Vec<FourCorners<3>>,
}

/// A triangle of the surface, as a face of its tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SurfaceFace {
    tet: u32,
    face: u8,
}

impl SurfaceFace {
    /// Returns the index of the tetrahedron.
    pub fn tet(self) -> usize {
        self.tet as usize
    }

    /// Returns the index of the face: the corner of the tetrahedron opposite to it.
    pub fn face(self) -> usize {
        self.face.into()
    }

    /// Returns the corners (m) of the triangle, given all tetrahedra of the body.
    #[inline]
    pub fn corners(self, tets: &[FieldTet]) -> [Vector3<f64>; 3] {
        let corners = &tets[self.tet()].tetrahedron.corners;
        FACES[self.face()].map(|corner| corners[corner])
    }
}

impl TriangleBvh {
    /// Builds the tree for a compliant body, from the faces of its tetrahedra that have no
    /// neighbor.
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

    /// Builds the tree for a rigid body, from the cells behind its triangles. Each triangle is face
    /// 3 of its cell.
    pub fn of_cells(cells: &[FieldTet]) -> Self {
        let faces = (0_u32..).zip(cells);
        Self::new(faces.map(|(tet, _)| SurfaceFace { tet, face: 3 }), cells)
    }

    /// Builds the tree in O(n log n).
    fn new(faces: impl Iterator<Item = SurfaceFace>, tets: &[FieldTet]) -> Self {
        let corners_of = |face: SurfaceFace| face.corners(tets);
        let bvh = Bvh::new(faces.map(|face| (face, corners_of(face))));
        let slabs = PerNode::of(&bvh, |items, below_child| {
            slabs_of(items.chunks(below_child), corners_of)
        });
        Self {
            slabs,
            sizes: bvh.levels().iter().map(|level| mean_size(level)).collect(),
            corners: bvh.corners(corners_of),
            bvh,
        }
    }

    /// Returns the tree of the triangles.
    pub fn bvh(&self) -> &Bvh<SurfaceFace> {
        &self.bvh
    }

    /// Returns the mean length (m) of the longest edges of the boxes around the nodes, for each
    /// level from the root.
    pub(super) fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// Returns the nodes of a level. The root is level 0.
    #[inline]
    pub(super) fn level(&self, level: usize) -> Level<'_> {
        Level {
            boxes: &self.bvh.levels()[level],
            slabs: self.slabs.level(level),
        }
    }

    /// Returns the nodes of the last level.
    #[inline]
    pub(super) fn leaves(&self) -> Level<'_> {
        self.level(self.depth() - 1)
    }

    /// Returns the number of levels.
    #[inline]
    pub(super) fn depth(&self) -> usize {
        self.sizes.len()
    }

    /// Returns the triangles. The triangles of node i of the last level begin at index 4i.
    pub(super) fn faces(&self) -> &[SurfaceFace] {
        self.bvh.items()
    }

    /// Returns the corners (m) of the triangles of each node of the last level.
    pub(super) fn corners(&self) -> &[FourCorners<3>] {
        &self.corners
    }

    /// Returns the corners (m) of one triangle.
    #[inline]
    pub(super) fn corners_of(&self, triangle: usize) -> [Vector3<f64>; 3] {
        let (four, slot) = (&self.corners[triangle / WIDTH], triangle % WIDTH);
        four.each_ref()
            .map(|[x, y, z]| Vector3::new(x[slot], y[slot], z[slot]))
    }
}

/// Computes the slabs that contain parts of a surface. Each part is given by its triangles.
fn slabs_of<'k>(
    parts: impl Iterator<Item = &'k [SurfaceFace]>,
    corners_of: impl Fn(SurfaceFace) -> [Vector3<f64>; 3],
) -> FourSlabs {
    let mut slabs = FourSlabs::EMPTY;
    for (slot, part) in parts.enumerate() {
        let triangles = || part.iter().map(|&face| corners_of(face));
        let normal = mean_normal(triangles());
        let [lowest, highest] = slabs.between.each_mut().map(|side| &mut side[slot]);
        for corner in triangles().flatten() {
            let height = normal.dot(&corner);
            (*lowest, *highest) = (lowest.min(height), highest.max(height));
        }
        for axis in 0..3 {
            slabs.normal[axis][slot] = normal[axis];
        }
    }
    slabs
}

/// Returns the normalized sum of the triangles' area vectors, or zero if they cancel.
fn mean_normal(triangles: impl Iterator<Item = [Vector3<f64>; 3]>) -> Vector3<f64> {
    let sum: Vector3<f64> = triangles.map(|[a, b, c]| (b - a).cross(&(c - a))).sum();
    sum.try_normalize(f64::MIN_POSITIVE).unwrap_or_default()
}

/// Returns the mean length (m) of the longest edges of the boxes around nodes.
fn mean_size(nodes: &[FourBoxes]) -> f64 {
    let size = |boxes: &FourBoxes| 2.0 * boxes.union().half_extents().max();
    nodes.iter().map(size).sum::<f64>() / nodes.len() as f64
}
