//! Tetrahedra of a body-centered cubic lattice that grow with the distance from the boundary [Labelle, Shewchuk 2007].
//!
//! Cells deep inside are joined, eight at a time, to larger cells of a balanced octree. The corners and the center of each larger cell are
//! nodes of the lattice.

use super::lattice::{Lattice, Node, Side};

/// Largest number of times that cells are joined.
const MOST_LEVELS: u8 = 4;

/// The cells of a lattice, with the level of the larger cell that each is a part of. A cell of level l has the edge 2ˡ.
pub(super) struct Cells<'a> {
    lattice: &'a Lattice,
    levels: Vec<u8>,
    /// Position of the first cell. Larger cells begin at multiples of their edge, so that they stay in place if the lattice is extended.
    first: [usize; 3],
}

impl<'a> Cells<'a> {
    /// Joins the cells that are surrounded by cells inside.
    pub fn joined(lattice: &'a Lattice, sides: &[Side]) -> Self {
        let mut cells = Self {
            lattice,
            levels: vec![0; lattice.node_count() / 2],
            first: lattice.first_within(1 << MOST_LEVELS),
        };
        let is_inside: Vec<bool> = cells
            .all(1)
            .map(|cell| cells.is_inside(cell, sides))
            .collect();
        for level in 0..MOST_LEVELS {
            let larger: Vec<_> = cells
                .all(2 << level)
                .filter(|&cell| cells.can_join(cell, level, &is_inside))
                .collect();
            if larger.is_empty() {
                break;
            }
            for cell in larger {
                for part in cube(cell, 2 << level) {
                    let index = cells.index(part);
                    cells.levels[index] = level + 1;
                }
            }
        }
        cells
    }

    /// Returns the cells of this edge, as the positions of their first parts.
    fn all(&self, edge: usize) -> impl Iterator<Item = [usize; 3]> {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let start = (edge - self.first[axis] % edge) % edge;
            (start..self.lattice.counts[axis]).step_by(edge)
        });
        z.flat_map(move |k| {
            let x = x.clone();
            y.clone()
                .flat_map(move |j| x.clone().map(move |i| [i, j, k]))
        })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        let [x_count, y_count, _] = self.lattice.counts;
        (k * y_count + j) * x_count + i
    }

    fn level(&self, cell: [usize; 3]) -> u8 {
        self.levels[self.index(cell)]
    }

    fn is_in_lattice(&self, cell: [usize; 3]) -> bool {
        cell.iter()
            .zip(self.lattice.counts)
            .all(|(&index, count)| index < count)
    }

    /// Returns whether the nodes of a cell are inside.
    fn is_inside(&self, cell: [usize; 3], sides: &[Side]) -> bool {
        let is_node_inside = |node: Node| sides[node as usize] == Side::Inside;
        let [_, center] = self.lattice.nodes(cell);
        is_node_inside(center)
            && cube(cell, 2).all(|corner| {
                self.is_in_lattice(corner) && is_node_inside(self.lattice.nodes(corner)[0])
            })
    }

    /// Returns whether eight cells of a level can be joined: they and their neighbors are of this level, and inside.
    fn can_join(&self, cell: [usize; 3], level: u8, is_inside: &[bool]) -> bool {
        let edge = 1 << level;
        if cell.iter().any(|&index| index < edge) {
            return false;
        }
        cube([0; 3], 4).all(|offset| {
            let part = [0, 1, 2].map(|axis| cell[axis] + offset[axis] * edge - edge);
            self.is_in_lattice(part) && self.level(part) >= level && is_inside[self.index(part)]
        })
    }

    /// Returns the first part of the cell that a part belongs to.
    fn start(&self, part: [usize; 3]) -> [usize; 3] {
        let edge = 1 << self.level(part);
        [0, 1, 2].map(|axis| part[axis] - (self.first[axis] + part[axis]) % edge)
    }

    /// Returns the node at the center of a cell.
    fn center(&self, start: [usize; 3]) -> Node {
        match self.level(start) {
            0 => self.lattice.nodes(start)[1],
            level => self.corner(start.map(|index| index + (1 << (level - 1)))),
        }
    }

    fn corner(&self, position: [usize; 3]) -> Node {
        self.lattice.nodes(position)[0]
    }

    /// Calls a function with each tetrahedron. The cells at the border of the lattice have none.
    pub fn visit_tets(&self, mut visit: impl FnMut([Node; 4])) {
        let counts = self.lattice.counts;
        let is_within = |cell: &[usize; 3]| {
            cell.iter()
                .zip(counts)
                .all(|(&index, count)| index > 0 && index + 1 < count)
        };
        for cell in self.all(1).filter(is_within) {
            if self.start(cell) != cell {
                continue;
            }
            for axis in 0..3 {
                self.visit_face(cell, axis, false, &mut visit);
                self.visit_face(cell, axis, true, &mut visit);
            }
        }
    }

    /// Visits the tetrahedra across a face of a cell, unless they are visited from the other side: from the smaller cell, or from the
    /// first of two equal cells.
    fn visit_face(
        &self,
        cell: [usize; 3],
        axis: usize,
        is_far: bool,
        visit: &mut impl FnMut([Node; 4]),
    ) {
        let level = self.level(cell);
        let edge = 1 << level;
        let (mut beside, mut face) = (cell, cell);
        if is_far {
            face[axis] += edge;
            beside[axis] += edge;
        } else {
            beside[axis] -= 1;
        }
        let other_level = self.level(beside);
        if other_level < level || (other_level == level && !is_far) {
            return;
        }
        let centers = [self.center(cell), self.center(self.start(beside))];
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let square = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[along_u, along_v]| {
            let mut corner = face;
            corner[u] += along_u * edge;
            corner[v] += along_v * edge;
            corner
        });
        if other_level > level {
            // Both pyramids are halved at the diagonal from the middle of the larger face.
            let is_between = |corner: &[usize; 3], axis: usize| {
                !(self.first[axis] + corner[axis]).is_multiple_of(2 * edge)
            };
            let is_middle = |corner: &[usize; 3]| is_between(corner, u) && is_between(corner, v);
            let middle = square.iter().position(is_middle).unwrap_or(0);
            let corners = [0, 1, 2, 3].map(|turn| self.corner(square[(middle + turn) % 4]));
            for center in centers {
                visit([center, corners[0], corners[1], corners[2]]);
                visit([center, corners[0], corners[2], corners[3]]);
            }
            return;
        }
        // Axis and direction out of the square at each of its edges.
        for (index, (out, is_up)) in [(v, false), (u, true), (v, true), (u, false)]
            .into_iter()
            .enumerate()
        {
            let [from, to] = [square[index], square[(index + 1) % 4]];
            let is_smaller = |mut part: [usize; 3]| {
                part[out] = if is_up {
                    part[out] + edge
                } else {
                    part[out] - 1
                };
                self.level(part) < level
            };
            let [first, second] = centers;
            let ends = [from, to].map(|corner| self.corner(corner));
            if level > 0 && (is_smaller(cell) || is_smaller(beside)) {
                let middle = [0, 1, 2].map(|axis| usize::midpoint(from[axis], to[axis]));
                let middle = self.corner(middle);
                visit([first, second, ends[0], middle]);
                visit([first, second, middle, ends[1]]);
            } else {
                visit([first, second, ends[0], ends[1]]);
            }
        }
    }
}

/// Returns the positions in a cube of this edge.
fn cube([i, j, k]: [usize; 3], edge: usize) -> impl Iterator<Item = [usize; 3]> {
    (k..k + edge)
        .flat_map(move |k| (j..j + edge).flat_map(move |j| (i..i + edge).map(move |i| [i, j, k])))
}

#[cfg(test)]
mod tests {
    use super::{Cells, Side};
    use crate::geometry::{Aabb, Tetrahedron};
    use crate::mesh::TetMesh;
    use crate::mesh::solid::lattice::{Lattice, Node};
    use nalgebra::{Vector3, vector};
    use std::collections::HashMap;

    fn lattice(size: [f64; 3], spacing: f64) -> Lattice {
        let bounds = Aabb {
            lower: vector![0.1, -0.2, 0.3],
            upper: vector![0.1, -0.2, 0.3] + Vector3::from(size),
        };
        Lattice::around(&bounds, spacing).unwrap()
    }

    fn tets(cells: &Cells) -> Vec<[Node; 4]> {
        let mut tets = Vec::new();
        cells.visit_tets(|tet| tets.push(tet));
        tets
    }

    #[test]
    fn equal_cells_have_edges_of_the_two_kinds() {
        let lattice = lattice([2.0, 3.0, 1.0], 0.5);
        let sides = vec![Side::Outside; lattice.node_count()];
        for tet in tets(&Cells::joined(&lattice, &sides)) {
            let corners = tet.map(|node| lattice.position(node));
            let mut long = 0;
            for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                let length = (corners[a] - corners[b]).norm();
                let is_long = Lattice::is_long([tet[a], tet[b]]);
                let expected = if is_long { 0.5 } else { 0.5 * 0.75_f64.sqrt() };
                assert!((length - expected).abs() < 1e-12);
                assert!(lattice.neighbors(tet[0]).contains(&tet[b]) || a > 0);
                long += usize::from(is_long);
            }
            assert_eq!(long, 2);
        }
    }

    #[test]
    fn larger_cells_fill_the_same_space_without_gaps() {
        let lattice = lattice([24.0, 30.0, 27.0], 1.0);
        let equal = Cells::joined(&lattice, &vec![Side::Outside; lattice.node_count()]);
        let is_inside = |node: Node| {
            let center = lattice.point(lattice.counts.map(|count| count as f64 / 2.0));
            (lattice.position(node) - center).norm() < 13.0
        };
        let side = |node: Node| {
            if is_inside(node) {
                Side::Inside
            } else {
                Side::Outside
            }
        };
        let sides: Vec<_> = (0..).map(side).take(lattice.node_count()).collect();
        let graded = Cells::joined(&lattice, &sides);
        assert_eq!(graded.levels.iter().max(), Some(&2));
        let [equal, graded] = [tets(&equal), tets(&graded)];
        assert!(
            graded.len() < equal.len() - 12_000,
            "{} {}",
            equal.len(),
            graded.len()
        );
        let mesh = |tets: &[[Node; 4]]| {
            let mut vertices = HashMap::new();
            let mut positions = Vec::new();
            let mut vertex = |node: Node| {
                *vertices.entry(node).or_insert_with(|| {
                    positions.push(lattice.position(node));
                    positions.len() - 1
                })
            };
            let tets: Vec<_> = tets.iter().map(|tet| tet.map(&mut vertex)).collect();
            TetMesh::new(positions, tets).unwrap()
        };
        let [equal, graded] = [mesh(&equal), mesh(&graded)];
        // Up to the rounding errors of sums of 300,000 volumes.
        let growth = graded.volume() / equal.volume() - 1.0;
        assert!(growth.abs() < 1e-12, "{growth}");
        assert_eq!(
            equal.surface_triangles().len(),
            graded.surface_triangles().len()
        );
        let quality = |tet: usize| {
            let Tetrahedron {
                corners: [a, b, c, d],
            } = graded.tetrahedron(tet);
            let longest = [b - a, c - a, d - a, c - b, d - b, d - c].map(|edge| edge.norm());
            graded.tetrahedron(tet).signed_volume()
                / longest.into_iter().fold(0.0, f64::max).powi(3)
        };
        // Half pyramids of smaller cells are the flattest: their base is half a square of edge 1, and their height is 1/2.
        let least = (0..graded.tet_count())
            .map(quality)
            .fold(f64::INFINITY, f64::min);
        assert!(
            (least - 1.0 / 12.0 / 2.0_f64.powf(1.5)).abs() < 1e-12,
            "{least}"
        );
    }
}
