use crate::geometry::{Aabb, AffineField};
use crate::mesh::{FieldTet, PressureField};
use nalgebra::Vector3;

/// Tetrahedra to a leaf, at most.
const LEAF: usize = 4;

/// A binary tree of boxes around tetrahedra, each with bounds of the field in them: which values it may have, and which way it
/// may slope.
#[derive(Debug, Clone)]
pub(crate) struct FieldTree {
    nodes: Vec<FieldNode>,
    /// The tetrahedra, those of each leaf one after the other.
    tets: Vec<u32>,
}

/// A node of a [`FieldTree`].
#[derive(Debug, Clone)]
pub(crate) struct FieldNode {
    /// Bounds of the field in its tetrahedra.
    pub bounds: FieldBounds,
    /// Half the diagonal of the box (m).
    pub size: f64,
    /// Of a leaf, the place of its first tetrahedron; else that of the first of its two children, which are neighbors.
    first: u32,
    /// Number of tetrahedra of a leaf; 0 of a node with children.
    count: u32,
}

/// Bounds of a field in some tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FieldBounds {
    /// Center of the box around them (m).
    pub center: Vector3<f64>,
    /// Half its edges (m).
    pub half: Vector3<f64>,
    /// An affine function near the extent: its gradient is in the middle of all, and its offset errs least with that.
    pub mean: AffineField,
    /// How far the extent is above `mean` or below, at most.
    pub error: f64,
    /// How far the components of the extent's gradient are from those of `mean`, at most (1/m).
    pub spread: Vector3<f64>,
    /// Center of the box around the gradients in all tetrahedra that share a vertex with these (1/m).
    pub gradient_around: Vector3<f64>,
    /// Half the edges of that box (1/m).
    pub spread_around: Vector3<f64>,
    /// Largest sensitivity (1/m).
    pub sensitivity: f64,
}

/// What is below a node.
pub(crate) enum Below<'t> {
    Children([&'t FieldNode; 2]),
    Tets(&'t [u32]),
}

impl FieldTree {
    /// Divides the tetrahedra in halves, across the longest edge of the box around their centers: O(n log n).
    pub fn new(field: &PressureField) -> Self {
        let around = gradients_around(field);
        let centers = centers(field);
        let mut tets: Vec<u32> = (0_u32..).zip(field.tets()).map(|(tet, _)| tet).collect();
        let node_of = |part: &[u32]| FieldNode::of(field, &around, part);
        let mut nodes = vec![node_of(&tets)];
        let mut undivided = vec![(0, 0..tets.len())];
        while let Some((index, range)) = undivided.pop() {
            if range.len() <= LEAF {
                nodes[index].first = range.start as u32;
                nodes[index].count = range.len() as u32;
                continue;
            }
            let middle = range.start + halved(&mut tets[range.clone()], &centers);
            let first = nodes.len();
            nodes[index].first = first as u32;
            for (child, part) in (first..).zip([range.start..middle, middle..range.end]) {
                nodes.push(node_of(&tets[part.clone()]));
                undivided.push((child, part));
            }
        }
        Self { nodes, tets }
    }

    /// The node around all tetrahedra.
    pub fn root(&self) -> &FieldNode {
        &self.nodes[0]
    }

    /// What is below a node of this tree.
    #[inline]
    pub fn below(&self, node: &FieldNode) -> Below<'_> {
        let (first, count) = (node.first as usize, node.count as usize);
        if count > 0 {
            Below::Tets(&self.tets[first..first + count])
        } else {
            Below::Children([&self.nodes[first], &self.nodes[first + 1]])
        }
    }
}

/// Brings to the front the half of the tetrahedra whose centers are lower along the longest edge of the box around the centers,
/// and returns how many they are.
fn halved(part: &mut [u32], centers: &[Vector3<f64>]) -> usize {
    let center = |tet: &u32| &centers[*tet as usize];
    let axis = Aabb::around(part.iter().map(center)).half_extents().imax();
    let middle = part.len() / 2;
    part.select_nth_unstable_by(middle, |a, b| center(a)[axis].total_cmp(&center(b)[axis]));
    middle
}

fn centers(field: &PressureField) -> Vec<Vector3<f64>> {
    let tets = field.tets().iter();
    tets.map(|tet| tet.tetrahedron.aabb().center()).collect()
}

/// For each vertex the box around the gradients in the tetrahedra that have it.
fn gradients_around(field: &PressureField) -> Vec<Aabb> {
    let mut boxes = vec![Aabb::around([]); field.mesh().vertex_count()];
    for (tet, vertices) in field.tets().iter().zip(field.mesh().tets()) {
        for &vertex in vertices {
            boxes[vertex] = boxes[vertex].union(&Aabb::around([&tet.extent.gradient]));
        }
    }
    boxes
}

impl FieldNode {
    /// Around these tetrahedra. Where its children or tetrahedra are is for the caller to say.
    fn of(field: &PressureField, around: &[Aabb], part: &[u32]) -> Self {
        let bounds = FieldBounds::of(field, around, part);
        Self {
            size: bounds.half.norm(),
            bounds,
            first: 0,
            count: 0,
        }
    }
}

impl FieldBounds {
    /// In these tetrahedra of a field, given the box around the gradients at each vertex.
    fn of(field: &PressureField, around: &[Aabb], part: &[u32]) -> Self {
        let tets = || part.iter().map(|&tet| &field.tets()[tet as usize]);
        let place = Aabb::around(tets().flat_map(|tet| &tet.tetrahedron.corners));
        let gradients = Aabb::around(tets().map(|tet| &tet.extent.gradient));
        let gradient = gradients.center();
        let rests = tets().flat_map(|tet| {
            let corners = tet.tetrahedron.corners.iter().zip(tet.extents);
            corners.map(|(corner, extent)| extent - gradient.dot(corner))
        });
        let (low, high) = rests.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rest| {
            (low.min(rest), high.max(rest))
        });
        let vertices = part
            .iter()
            .flat_map(|&tet| field.mesh().tets()[tet as usize]);
        let around = vertices.fold(gradients, |all, vertex| all.union(&around[vertex]));
        Self {
            center: place.center(),
            half: place.half_extents(),
            mean: AffineField {
                gradient,
                offset: 0.5 * (low + high),
            },
            error: 0.5 * (high - low),
            spread: gradients.half_extents(),
            gradient_around: around.center(),
            spread_around: around.half_extents(),
            sensitivity: tets().map(|tet| tet.sensitivity).fold(0.0, f64::max),
        }
    }

    /// The bounds in one of these tetrahedra, but for the gradients around, which stay those of all.
    #[inline]
    pub fn narrowed_to(&self, tet: &FieldTet) -> Self {
        let place = tet.tetrahedron.aabb();
        Self {
            center: place.center(),
            half: place.half_extents(),
            mean: tet.extent,
            error: 0.0,
            spread: Vector3::zeros(),
            sensitivity: tet.sensitivity,
            ..*self
        }
    }
}
