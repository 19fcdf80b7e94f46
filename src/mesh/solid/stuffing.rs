//! Isosurface stuffing [Labelle, Shewchuk 2007]: tetrahedra of a body-centered cubic lattice fill a region. Nodes close to the boundary
//! move onto it, and the tetrahedra that still cross it are cut. The smallest dihedral angle that random boundaries have shown is 9.3°,
//! and the paper proves 10.7°, so that its rule for the diagonals of cut faces must differ from the order of [`Corner`] in rare cases.

use super::grading::Cells;
use super::lattice::{Lattice, Node, Side};
use super::region::{Crossing, Region, SAME_PLANE};
use nalgebra::Vector3;
use rustc_hash::FxHashMap;

/// A node moves to a cut of a long edge that is nearer than this share of the edge [Labelle, Shewchuk 2007, table 1].
const NEAR_ALONG_LONG: f64 = 0.24999;

/// The same for short edges.
const NEAR_ALONG_SHORT: f64 = 0.41189;

/// Difference of two shares of an edge below which a small change of the boundary changes the tetrahedra.
const TIE: f64 = 1e-6;

/// Cells along the edge of the largest blocks whose nodes are classified at once.
const BLOCK: usize = 16;

/// The tetrahedra that fill a region.
#[derive(Default)]
pub(super) struct Stuffing {
    pub vertices: Vec<Vector3<f64>>,
    pub tets: Vec<[usize; 4]>,
    /// The cuts at which vertices lie.
    pub cuts: Vec<CutVertex>,
}

/// A vertex on the boundary, where an edge of the lattice crosses it.
pub(super) struct CutVertex {
    pub vertex: usize,
    /// The edge from its inner to its outer end (m).
    pub edge: Vector3<f64>,
    pub crossing: Crossing,
    /// Whether a small change of the boundary changes the tetrahedra at the vertex.
    pub is_at_tie: bool,
}

/// An edge of the lattice that crosses the boundary.
struct Cut {
    /// The inner node, then the outer one.
    nodes: [Node; 2],
    crossing: Crossing,
    is_at_tie: bool,
}

impl Cut {
    /// Returns the share of the edge between its cut and a node.
    fn share_from(&self, node: Node) -> f64 {
        let share = self.crossing.share;
        if node == self.nodes[0] {
            share
        } else {
            1.0 - share
        }
    }

    fn near(&self) -> f64 {
        if Lattice::is_long(self.nodes) {
            NEAR_ALONG_LONG
        } else {
            NEAR_ALONG_SHORT
        }
    }

    /// Returns the distance of the cut from a node, over the spacing.
    fn distance_from(&self, node: Node) -> f64 {
        let length = if Lattice::is_long(self.nodes) {
            1.0
        } else {
            0.75_f64.sqrt()
        };
        self.share_from(node) * length
    }
}

/// Fills the region with the tetrahedra of a lattice.
pub(super) fn stuffed(region: &impl Region, lattice: &Lattice) -> Stuffing {
    let mut sides = sides(region, lattice);
    if !sides.contains(&Side::Inside) {
        return Stuffing::default();
    }
    let mut cuts = cuts(region, lattice, &sides);
    warp(lattice, &mut sides, &mut cuts);
    let mut filling = Filling::new(lattice, &sides, &cuts);
    filling.fill();
    filling.stuffing
}

/// Returns the side of each node. Blocks of cells away from the boundary are on one side as a whole; the others are halved.
fn sides(region: &impl Region, lattice: &Lattice) -> Vec<Side> {
    let mut sides = vec![Side::Outside; lattice.node_count()];
    let [x, y, z] = lattice.counts;
    let starts = |count: usize| (0..count).step_by(BLOCK);
    let mut blocks: Vec<[usize; 3]> = starts(z)
        .flat_map(|k| starts(y).flat_map(move |j| starts(x).map(move |i| [i, j, k])))
        .collect();
    let mut size = BLOCK;
    while !blocks.is_empty() {
        let half = size as f64 / 2.0;
        let center = |block: &[usize; 3]| lattice.point(block.map(|start| start as f64 + half));
        let centers: Vec<_> = blocks.iter().map(center).collect();
        let reach = half * 3.0_f64.sqrt() * lattice.spacing;
        let mut mixed = Vec::new();
        for (block, is_inside) in { blocks }
            .into_iter()
            .zip(region.balls_inside(&centers, reach))
        {
            match is_inside {
                None => mixed.push(block),
                Some(false) => {}
                Some(true) => nodes_of(lattice, block, size)
                    .for_each(|node| sides[node as usize] = Side::Inside),
            }
        }
        let mixed = mixed.into_iter();
        if size == 1 {
            let nodes: Vec<_> = mixed.flat_map(|cell| lattice.nodes(cell)).collect();
            let positions: Vec<_> = nodes.iter().map(|&node| lattice.position(node)).collect();
            for (&node, is_inside) in nodes.iter().zip(region.contains(&positions)) {
                if is_inside {
                    sides[node as usize] = Side::Inside;
                }
            }
            break;
        }
        size /= 2;
        blocks = mixed
            .flat_map(|block| eighths(block, size, lattice.counts))
            .collect();
    }
    sides
}

/// Returns the parts of a block that begin in the lattice.
fn eighths(
    [i, j, k]: [usize; 3],
    size: usize,
    counts: [usize; 3],
) -> impl Iterator<Item = [usize; 3]> {
    let parts = (0..8).map(move |bits: usize| {
        [
            i + (bits & 1) * size,
            j + (bits >> 1 & 1) * size,
            k + (bits >> 2) * size,
        ]
    });
    parts.filter(move |part| part.iter().zip(counts).all(|(&start, count)| start < count))
}

/// Returns the nodes of a block of cells.
fn nodes_of(lattice: &Lattice, block: [usize; 3], size: usize) -> impl Iterator<Item = Node> {
    let [x, y, z] =
        [0, 1, 2].map(|axis| block[axis]..(block[axis] + size).min(lattice.counts[axis]));
    let cells = z.flat_map(move |k| {
        let x = x.clone();
        y.clone()
            .flat_map(move |j| x.clone().map(move |i| [i, j, k]))
    });
    cells.flat_map(|cell| lattice.nodes(cell))
}

/// Returns the edges that cross the boundary, in the order of their inner nodes.
fn cuts(region: &impl Region, lattice: &Lattice, sides: &[Side]) -> Vec<Cut> {
    let mut edges = Vec::new();
    for (node, _) in (0..).zip(sides).filter(|(_, side)| **side == Side::Inside) {
        let outer = lattice.neighbors(node).into_iter();
        let outer = outer.filter(|&neighbor| sides[neighbor as usize] == Side::Outside);
        edges.extend(outer.map(|neighbor| [node, neighbor]));
    }
    let segments: Vec<_> = edges
        .iter()
        .map(|edge| edge.map(|node| lattice.position(node)))
        .collect();
    let crossings = region.crossings(&segments);
    let cut = |(nodes, crossing): (_, Crossing)| Cut {
        nodes,
        is_at_tie: crossing.is_at_tie,
        crossing,
    };
    edges.into_iter().zip(crossings).map(cut).collect()
}

/// Moves the nodes that are close to a cut onto it, in order. A node that moves takes the other cuts of its edges away.
///
/// A node moves to the nearest cut. If the node is on the boundary, all of its cuts have the distance zero. The node then moves to the cut
/// whose edge is closest to the normal of the boundary, because that cut is the nearest after a small motion of the boundary.
fn warp(lattice: &Lattice, sides: &mut [Side], cuts: &mut [Cut]) {
    let slope = |cut: &Cut| {
        let [from, to] = cut.nodes.map(|node| lattice.position(node));
        (to - from).normalize().dot(&cut.crossing.normal).abs()
    };
    let mut ends: Vec<(Node, u32)> = Vec::with_capacity(2 * cuts.len());
    for (index, cut) in (0..).zip(cuts.iter()) {
        ends.extend(cut.nodes.map(|node| (node, index)));
    }
    ends.sort_unstable();
    for group in ends.chunk_by(|a, b| a.0 == b.0) {
        let node = group[0].0;
        let is_moved = |node: Node| matches!(sides[node as usize], Side::On(_));
        let is_left = |cut: &Cut| !cut.nodes.into_iter().any(is_moved);
        let left = group.iter().map(|&(_, cut)| cut);
        let left: Vec<u32> = left.filter(|&cut| is_left(&cuts[cut as usize])).collect();
        for &cut in &left {
            let cut = &mut cuts[cut as usize];
            cut.is_at_tie |= (cut.share_from(node) - cut.near()).abs() < TIE;
        }
        let distance = |cut: u32| cuts[cut as usize].distance_from(node);
        let is_near = |&cut: &u32| cuts[cut as usize].share_from(node) < cuts[cut as usize].near();
        let near: Vec<u32> = left.iter().copied().filter(is_near).collect();
        let least = near
            .iter()
            .map(|&cut| distance(cut))
            .fold(f64::INFINITY, f64::min);
        let mut tied = near;
        tied.retain(|&cut| distance(cut) - least < TIE);
        let by_slope =
            |a: &u32, b: &u32| slope(&cuts[*b as usize]).total_cmp(&slope(&cuts[*a as usize]));
        let Some(nearest) = tied.iter().copied().min_by(by_slope) else {
            continue;
        };
        let is_rival = |&cut: &u32| {
            let [cut, nearest] = [cut, nearest].map(|cut| &cuts[cut as usize]);
            let is_in_plane = cut.crossing.normal.dot(&nearest.crossing.normal) >= SAME_PLANE;
            let is_less_steep = slope(nearest) - slope(cut) >= TIE;
            least > TIE || cut.is_at_tie || !(is_in_plane && is_less_steep)
        };
        let is_tied = tied.iter().any(|cut| *cut != nearest && is_rival(cut));
        cuts[nearest as usize].is_at_tie |= is_tied;
        sides[node as usize] = Side::On(nearest);
    }
}

/// A corner of the tetrahedra that fill the region. The order decides how quadrilaterals are split: at the diagonal from their least
/// corner. Both sides of a face then agree, and cuts of long edges, which come first, give the best angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Corner {
    LongCut(u32),
    Node(Node),
    ShortCut(u32),
}

/// The work of [`stuffed`] after nodes have moved.
struct Filling<'a> {
    lattice: &'a Lattice,
    sides: &'a [Side],
    cuts: &'a [Cut],
    by_nodes: FxHashMap<[Node; 2], u32>,
    vertices: FxHashMap<Corner, usize>,
    stuffing: Stuffing,
}

impl<'a> Filling<'a> {
    fn new(lattice: &'a Lattice, sides: &'a [Side], cuts: &'a [Cut]) -> Self {
        let by_nodes = (0..).zip(cuts).map(|(index, cut)| (cut.nodes, index));
        Self {
            lattice,
            sides,
            cuts,
            by_nodes: by_nodes.collect(),
            vertices: FxHashMap::default(),
            stuffing: Stuffing::default(),
        }
    }

    fn fill(&mut self) {
        Cells::joined(self.lattice, self.sides).visit_tets(|tet| self.add(tet));
    }

    /// Adds the part of a tetrahedron of the lattice inside the region.
    fn add(&mut self, tet: [Node; 4]) {
        if !tet
            .iter()
            .any(|&node| self.sides[node as usize] == Side::Inside)
        {
            return;
        }
        let (mut inner, mut outer, mut rest) = (Vec::new(), Vec::new(), Vec::new());
        for node in tet {
            match self.sides[node as usize] {
                Side::Inside => inner.push(node),
                Side::Outside => outer.push(node),
                Side::On(_) => rest.push(Corner::Node(node)),
            }
        }
        let cut = |inner: Node, outer: Node| {
            let index = self.by_nodes[&[inner, outer]];
            if Lattice::is_long([inner, outer]) {
                Corner::LongCut(index)
            } else {
                Corner::ShortCut(index)
            }
        };
        let node = Corner::Node;
        match (&inner[..], &outer[..]) {
            ([], _) => {}
            (_, []) => self.push(tet.map(node)),
            (&[p], _) => {
                let corners = rest.into_iter().chain(outer.iter().map(|&q| cut(p, q)));
                let corners: Vec<_> = corners.chain([node(p)]).collect();
                self.push([corners[0], corners[1], corners[2], corners[3]]);
            }
            (&[p, q], &[o]) => {
                let base = [node(p), node(q), cut(q, o), cut(p, o)];
                self.push_pyramid(rest[0], base);
            }
            (&[p, q], &[o, r, ..]) => {
                let ends = [
                    [node(p), cut(p, o), cut(p, r)],
                    [node(q), cut(q, o), cut(q, r)],
                ];
                self.push_prism(ends);
            }
            (&[p, q, r, ..], &[o, ..]) => {
                let ends = [
                    [node(p), node(q), node(r)],
                    [cut(p, o), cut(q, o), cut(r, o)],
                ];
                self.push_prism(ends);
            }
        }
    }

    /// Adds a prism between two triangles with corresponding corners.
    fn push_prism(&mut self, [first, second]: [[Corner; 3]; 2]) {
        let (near, far) = if first.iter().min() < second.iter().min() {
            (first, second)
        } else {
            (second, first)
        };
        let apex = (0..3).min_by_key(|&corner| near[corner]).unwrap_or(0);
        let [next, last] = [(apex + 1) % 3, (apex + 2) % 3];
        self.push([near[apex], far[0], far[1], far[2]]);
        self.push_pyramid(near[apex], [near[next], near[last], far[last], far[next]]);
    }

    /// Adds a pyramid, split at the diagonal of its base from the least corner.
    fn push_pyramid(&mut self, apex: Corner, base: [Corner; 4]) {
        let least = (0..4).min_by_key(|&corner| base[corner]).unwrap_or(0);
        let [a, b, c, d] = [0, 1, 2, 3].map(|turn| base[(least + turn) % 4]);
        self.push([apex, a, b, c]);
        self.push([apex, a, c, d]);
    }

    fn push(&mut self, corners: [Corner; 4]) {
        let tet = corners.map(|corner| self.vertex(corner));
        self.stuffing.tets.push(tet);
    }

    /// Returns the vertex at a corner, which is new at the first call.
    fn vertex(&mut self, corner: Corner) -> usize {
        let vertex = self.stuffing.vertices.len();
        let known = *self.vertices.entry(corner).or_insert(vertex);
        if known < vertex {
            return known;
        }
        let cut = match corner {
            Corner::LongCut(cut) | Corner::ShortCut(cut) => Some(cut),
            Corner::Node(node) => match self.sides[node as usize] {
                Side::On(cut) => Some(cut),
                Side::Inside | Side::Outside => {
                    self.stuffing.vertices.push(self.lattice.position(node));
                    None
                }
            },
        };
        if let Some(cut) = cut {
            let cut = &self.cuts[cut as usize];
            let [from, to] = cut.nodes.map(|node| self.lattice.position(node));
            self.stuffing
                .vertices
                .push(from.lerp(&to, cut.crossing.share));
            self.stuffing.cuts.push(CutVertex {
                vertex,
                edge: to - from,
                crossing: cut.crossing,
                is_at_tie: cut.is_at_tie,
            });
        }
        vertex
    }
}

#[cfg(test)]
mod tests {
    use super::{NEAR_ALONG_LONG, NEAR_ALONG_SHORT, stuffed};
    use crate::geometry::{Aabb, FACES};
    use crate::mesh::TetMesh;
    use crate::mesh::solid::lattice::Lattice;
    use crate::mesh::solid::region::{Crossing, Region, Segment};
    use nalgebra::{Vector3, vector};

    /// Returns a number in [0, 1) that depends on a point as if at random.
    fn noise(point: &Vector3<f64>, seed: u64) -> f64 {
        let mix = |state: u64, value: &f64| {
            let mixed = (state ^ value.to_bits()).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            mixed ^ (mixed >> 29)
        };
        let state = point
            .iter()
            .fold(seed, mix)
            .wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A region of which each point is a part at random, and whose boundary crosses edges anywhere.
    struct Noise {
        seed: u64,
        share: f64,
    }

    impl Region for Noise {
        fn bounds(&self) -> Aabb {
            Aabb {
                lower: Vector3::zeros(),
                upper: vector![16.0, 16.0, 16.0],
            }
        }

        fn clearances(&self, points: &[Vector3<f64>]) -> Vec<f64> {
            vec![0.0; points.len()]
        }

        fn contains(&self, points: &[Vector3<f64>]) -> Vec<bool> {
            let is_inside = |point: &Vector3<f64>| {
                self.bounds().overlaps(&Aabb::around([point]))
                    && noise(point, self.seed) < self.share
            };
            points.iter().map(is_inside).collect()
        }

        fn crossings(&self, segments: &[Segment]) -> Vec<Crossing> {
            // Next to the shares up to which nodes move, where angles are the worst, and anywhere.
            let crossing = |[from, to]: &Segment| {
                let noise = |seed: u64| noise(&(from * 3.0 + to), self.seed + seed);
                let limit = match 3.0 * noise(1) {
                    ..1.0 => 0.0,
                    1.0..2.0 => NEAR_ALONG_LONG,
                    _ => NEAR_ALONG_SHORT,
                };
                let share = match 4.0 * noise(2) {
                    ..1.0 => limit - 1e-5,
                    1.0..2.0 => limit + 1e-5,
                    2.0..3.0 => noise(3) / 2.0,
                    _ => limit * noise(3),
                };
                let share = if noise(4) < 0.5 { share } else { 1.0 - share };
                Crossing {
                    share: share.clamp(0.0, 1.0),
                    triangle: None,
                    normal: Vector3::zeros(),
                    is_at_tie: false,
                }
            };
            segments.iter().map(crossing).collect()
        }
    }

    /// Returns the smallest and the largest dihedral angle (°).
    fn dihedral_angles(mesh: &TetMesh) -> [f64; 2] {
        let mut angles = [180.0_f64, 0.0];
        for tet in 0..mesh.tet_count() {
            let corners = mesh.tetrahedron(tet).corners;
            let normals = FACES.map(|[a, b, c]| {
                (corners[b] - corners[a])
                    .cross(&(corners[c] - corners[a]))
                    .normalize()
            });
            for (first, second) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                let angle = (-normals[first].dot(&normals[second]))
                    .clamp(-1.0, 1.0)
                    .acos()
                    .to_degrees();
                angles = [angles[0].min(angle), angles[1].max(angle)];
            }
        }
        angles
    }

    #[test]
    fn random_boundaries_leave_no_thin_tetrahedra() {
        let (mut least, mut most) = (180.0_f64, 0.0_f64);
        for seed in 1..=60 {
            let region = Noise {
                seed,
                share: 0.1 + 0.8 * (seed as f64 / 60.0),
            };
            let lattice = Lattice::around(&region.bounds(), 1.0).unwrap();
            let stuffing = stuffed(&region, &lattice);
            let mesh = TetMesh::new(stuffing.vertices, stuffing.tets).unwrap();
            let [smallest, largest] = dihedral_angles(&mesh);
            (least, most) = (least.min(smallest), most.max(largest));
        }
        println!("dihedral angles from {least:.2}° to {most:.2}°");
        // 4,000 such regions had 9.32° to 161.64°. One tetrahedron in millions is below the 10.78° of [Labelle, Shewchuk 2007].
        assert!(least > 9.3 && most < 162.0, "{least} {most}");
    }
}
