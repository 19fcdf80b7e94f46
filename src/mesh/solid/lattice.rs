//! The body-centered cubic lattice and its tetrahedra.

use crate::geometry::Aabb;
use nalgebra::Vector3;

/// Number of cells between the bounds of a region and the border of its lattice.
const MARGIN: f64 = 1.5;

/// Largest number of cells. The state of a larger lattice would take gigabytes.
const MAX_CELLS: f64 = 1e8;

/// A body-centered cubic lattice. Each cell of the cubic grid has two nodes: its lower corner (even index) and its center (odd index).
///
/// A *long* edge connects two corners or two centers at the distance `spacing`. A *short* edge connects a center with a corner of its
/// cell. Each tetrahedron has two long edges, which are opposite to each other, and four short ones.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// Position of the first node, over the spacing.
    first: Vector3<f64>,
    /// Edge of a cell (m).
    pub spacing: f64,
    /// Number of cells along each axis.
    pub counts: [usize; 3],
}

/// A node of a [`Lattice`].
pub(super) type Node = u32;

/// Nodes of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Site {
    Corner,
    Center,
}

impl Lattice {
    /// Creates a lattice around a box, such that all nodes in the box have all their neighbors. Coordinates of the nodes are multiples of
    /// half the spacing, so that the lattice stays in place if the box changes a little. Returns the number of cells instead, if it is
    /// too large.
    pub fn around(bounds: &Aabb, spacing: f64) -> Result<Self, f64> {
        let first = (bounds.lower / spacing).map(|lower| (lower - MARGIN).floor());
        let last = (bounds.upper / spacing).map(|upper| (upper + MARGIN).ceil());
        let cells = last - first;
        let count = cells.product();
        if count > MAX_CELLS || count.is_nan() {
            return Err(count);
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "at most 1e8, and positive"
        )]
        let counts = <[f64; 3]>::from(cells).map(|count| count as usize);
        Ok(Self {
            first,
            spacing,
            counts,
        })
    }

    /// Returns the number of nodes.
    pub fn node_count(&self) -> usize {
        2 * self.counts.iter().product::<usize>()
    }

    /// Returns the position of a node (m).
    pub fn position(&self, node: Node) -> Vector3<f64> {
        let (cell, site) = self.place(node);
        let shift = if site == Site::Center { 0.5 } else { 0.0 };
        self.point(cell.map(|index| index as f64 + shift))
    }

    /// Returns the point (m) with these coordinates in cells.
    pub fn point(&self, cells: [f64; 3]) -> Vector3<f64> {
        (self.first + Vector3::from(cells)) * self.spacing
    }

    /// Returns the corner and the center of a cell.
    pub fn nodes(&self, [i, j, k]: [usize; 3]) -> [Node; 2] {
        let [x_count, y_count, _] = self.counts;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "there are at most 1e8 cells"
        )]
        let corner = (2 * ((k * y_count + j) * x_count + i)) as Node;
        [corner, corner + 1]
    }

    fn place(&self, node: Node) -> ([usize; 3], Site) {
        let [x_count, y_count, _] = self.counts;
        let cell = node as usize / 2;
        let site = if node % 2 == 1 {
            Site::Center
        } else {
            Site::Corner
        };
        let indices = [
            cell % x_count,
            cell / x_count % y_count,
            cell / x_count / y_count,
        ];
        (indices, site)
    }

    /// Returns the neighbors of a node that is not on the border: 6 across long edges, then 8 across short ones.
    pub fn neighbors(&self, node: Node) -> [Node; 14] {
        let (cell, site) = self.place(node);
        let [x, y, z] = self.steps();
        let other = match site {
            Site::Corner => self.nodes(cell.map(|index| index - 1))[1],
            Site::Center => node - 1,
        };
        let mut neighbors = [0; 14];
        neighbors[..6].copy_from_slice(&[
            node - x,
            node + x,
            node - y,
            node + y,
            node - z,
            node + z,
        ]);
        for (bits, neighbor) in (0..8).zip(&mut neighbors[6..]) {
            *neighbor = other + (bits & 1) * x + (bits >> 1 & 1) * y + (bits >> 2) * z;
        }
        neighbors
    }

    /// Returns whether an edge is long.
    pub fn is_long([a, b]: [Node; 2]) -> bool {
        a % 2 == b % 2
    }

    /// Returns the differences of node numbers between neighboring cells along each axis.
    fn steps(&self) -> [Node; 3] {
        let [x_count, y_count, _] = self.counts;
        #[expect(
            clippy::cast_possible_truncation,
            reason = "there are at most 1e8 cells"
        )]
        [2, 2 * x_count as Node, (2 * x_count * y_count) as Node]
    }

    /// Calls a function with the tetrahedra at the three long edges from a corner in the directions of the axes: four around each
    /// edge. All corners of the lattice together have each tetrahedron once. The corner must not be on the border.
    pub fn visit_tets(&self, corner: Node, mut visit: impl FnMut([Node; 4])) {
        let steps = self.steps();
        for axis in 0..3 {
            let [along, u, v] = [0, 1, 2].map(|turn| steps[(axis + turn) % 3]);
            // The centers around the edge, in order.
            let center = corner + 1;
            let ring = [center - u - v, center - v, center, center - u];
            for (index, &first) in ring.iter().enumerate() {
                visit([corner, corner + along, first, ring[(index + 1) % 4]]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Lattice;
    use crate::geometry::{Aabb, Tetrahedron};
    use nalgebra::Vector3;

    #[test]
    fn tetrahedra_fill_the_lattice_and_have_edges_of_the_two_kinds() {
        let bounds = Aabb {
            lower: Vector3::zeros(),
            upper: Vector3::new(2.0, 3.0, 1.0),
        };
        let lattice = Lattice::around(&bounds, 0.5).unwrap();
        let (mut volume, mut cells) = (0.0, 0);
        let [x, y, z] = lattice.counts;
        for (i, j, k) in (1..x - 1)
            .flat_map(|i| (1..y - 1).flat_map(move |j| (1..z - 1).map(move |k| (i, j, k))))
        {
            cells += 1;
            lattice.visit_tets(lattice.nodes([i, j, k])[0], |tet| {
                let corners = tet.map(|node| lattice.position(node));
                volume += Tetrahedron { corners }.signed_volume().abs();
                for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
                    let length = (corners[a] - corners[b]).norm();
                    let is_long = Lattice::is_long([tet[a], tet[b]]);
                    let expected = if is_long { 0.5 } else { 0.5 * 0.75_f64.sqrt() };
                    assert!((length - expected).abs() < 1e-12);
                    assert!(lattice.neighbors(tet[0]).contains(&tet[b]));
                    assert_eq!(is_long, (a, b) == (0, 1) || (a, b) == (2, 3));
                }
            });
        }
        assert!((volume - f64::from(cells) * 0.125).abs() < 1e-12);
    }
}
