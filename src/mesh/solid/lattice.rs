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

/// Side of the boundary on which a node lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Side {
    Inside,
    Outside,
    /// The node has moved onto the boundary, to a cut.
    On(u32),
}

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

    /// Returns the position of the first cell, over the spacing, modulo a number.
    pub fn first_within(&self, modulus: u8) -> [usize; 3] {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "from 0 up to the modulus"
        )]
        <[f64; 3]>::from(self.first).map(|first| first.rem_euclid(f64::from(modulus)) as usize)
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
}
