//! Moments of the parts of a convex outline in the cells between two families of lines.
//!
//! The moments of a part are the sum over its edges of the moments of the triangles between the origin and the edge. An edge of a part
//! belongs to an edge of the outline, or to a line. A walk around the outline divides its edges where they cross lines. A line enters and
//! leaves the outline at two of these crossings, and the lines of the other family divide it between them. Each segment of a line counts
//! once for the cell on one side, and once with the opposite sign for the cell on the other side.
//!
//! Only the walk decides which lines cross each other. Two lines cross if the crossings of one line separate the crossings of the other
//! line along the outline. Therefore the edges of every part close, and the moments of all parts add up to the moments of the outline,
//! regardless of round-off in the crossings.

use crate::contact::outline::{Outline, at};
use crate::friction::{Affine, ends};
use crate::geometry::{PER_TRIANGLE, add_triangle};
use crate::scalar::{Scalar, lift, real_part};

/// Moments up to degree 2 (see [`Outline::moments`]).
type Moments<T> = [T; 6];

/// A point at which a line crosses the outline, and the index of its cell along the line.
type Crossing<T> = ([T; 2], usize);

/// A family of ordered lines, and their crossings with the outline. Line l is between the cells l and l + 1.
struct Family<T> {
    functions: Vec<Affine<T>>,
    /// Cell of each corner of the outline.
    corners: Vec<usize>,
    /// For each line l, the crossing of the outline from cell l to cell l + 1, and the crossing back.
    crossings: Vec<[Option<Crossing<T>>; 2]>,
}

/// The moments of all cells, row by row. The memory is reused for other outlines.
pub(super) struct Cells<T> {
    families: [Family<T>; 2],
    moments: Vec<Moments<T>>,
    /// Points at which lines of both families cross, row by row.
    points: Vec<[T; 2]>,
}

impl<T: Scalar> Family<T> {
    fn empty() -> Self {
        Self {
            functions: Vec::new(),
            corners: Vec::new(),
            crossings: Vec::new(),
        }
    }

    /// Returns the fraction of the segment between two points at which the segment crosses a line.
    fn share(&self, line: usize, [from, to]: [&[T; 2]; 2]) -> T {
        let [before, after] = [from, to].map(|y| at(&self.functions[line], y));
        let share = before / (before - after);
        // Round-off may put both points on the same side of the line, or on the line.
        let real = real_part(share);
        if real.is_finite() {
            share + (real.clamp(0.0, 1.0) - real)
        } else {
            lift(0.5)
        }
    }
}

impl<T: Scalar> Cells<T> {
    pub fn empty() -> Self {
        Self {
            families: [Family::empty(), Family::empty()],
            moments: Vec::new(),
            points: Vec::new(),
        }
    }

    /// Sets the lines of the columns (family 0) or the rows (family 1), on which the functions are zero, and the cell of each corner of the
    /// outline.
    pub fn set_lines(
        &mut self,
        family: usize,
        functions: impl Iterator<Item = Affine<T>>,
        corners: impl Iterator<Item = usize>,
    ) {
        let family = &mut self.families[family];
        family.functions.clear();
        family.functions.extend(functions);
        family.corners.clear();
        family.corners.extend(corners);
    }

    /// Divides an outline by the lines. Returns `None` if round-off makes a line cross the outline more than twice.
    pub fn divide(&mut self, outline: &Outline<T>) -> Option<()> {
        let nothing = lift::<T>(0.0);
        let [columns, rows] = self
            .families
            .each_ref()
            .map(|family| family.functions.len());
        for family in &mut self.families {
            family.crossings.clear();
            family.crossings.resize(family.functions.len(), [None; 2]);
        }
        self.moments.clear();
        self.moments
            .resize((columns + 1) * (rows + 1), [nothing; 6]);
        self.points.resize(columns * rows, [nothing; 2]);
        self.add_outline(outline)?;
        self.add_lines();
        Some(())
    }

    /// Returns the columns, the rows and the moments of the parts whose area is not zero.
    pub fn moments(&self) -> impl Iterator<Item = ([usize; 2], Moments<T>)> {
        let columns = self.columns();
        let parts = self.moments.iter().enumerate();
        let parts = parts.filter(|(_, moments)| real_part(moments[0]).abs() > 0.0);
        parts.map(move |(index, moments)| {
            let mut moments = *moments;
            for (moment, factor) in moments.iter_mut().zip(PER_TRIANGLE) {
                *moment *= factor;
            }
            ([index % columns, index / columns], moments)
        })
    }

    fn columns(&self) -> usize {
        self.families[0].functions.len() + 1
    }

    fn add(&mut self, [column, row]: [usize; 2], [from, to]: [[T; 2]; 2]) {
        let cell = row * self.columns() + column;
        let factors = [lift(0.5), lift(1.0 / 3.0)];
        add_triangle(&mut self.moments[cell], from, to, factors);
    }

    /// Adds a segment of a line between two cells.
    fn add_between(&mut self, cells: [[usize; 2]; 2], [from, to]: [[T; 2]; 2]) {
        let mut triangle = [lift::<T>(0.0); 6];
        add_triangle(&mut triangle, from, to, [lift(0.5), lift(1.0 / 3.0)]);
        let [behind, ahead] = cells.map(|[column, row]| row * self.columns() + column);
        for (k, moment) in triangle.into_iter().enumerate() {
            self.moments[behind][k] += moment;
            self.moments[ahead][k] -= moment;
        }
    }

    /// Adds the edges of the outline, and records their crossings with lines.
    fn add_outline(&mut self, outline: &Outline<T>) -> Option<()> {
        let corners = outline.corners();
        let cell_of = |cells: &Self, corner: usize| {
            cells
                .families
                .each_ref()
                .map(|family| family.corners[corner])
        };
        for edge in 0..corners.len() {
            let next = if edge + 1 == corners.len() {
                0
            } else {
                edge + 1
            };
            let cells = [edge, next].map(|corner| cell_of(self, corner));
            self.add_edge(ends(corners, edge), cells)?;
        }
        Some(())
    }

    /// Adds an edge of the outline from one cell to another.
    fn add_edge(
        &mut self,
        [from, to]: [[T; 2]; 2],
        [mut cell, end]: [[usize; 2]; 2],
    ) -> Option<()> {
        let mut start = from;
        while cell != end {
            let share = |family: usize| {
                (cell[family] != end[family]).then(|| {
                    let line = cell[family] - usize::from(end[family] < cell[family]);
                    (
                        self.families[family].share(line, [&from, &to]),
                        line,
                        family,
                    )
                })
            };
            let (share, line, family) = match (share(0), share(1)) {
                (Some(first), Some(second)) if real_part(second.0) < real_part(first.0) => second,
                (first, second) => first.or(second)?,
            };
            let crossing = [0, 1].map(|i| from[i] + (to[i] - from[i]) * share);
            self.add(cell, [start, crossing]);
            let is_back = end[family] < cell[family];
            let noted = &mut self.families[family].crossings[line][usize::from(is_back)];
            if noted.replace((crossing, cell[1 - family])).is_some() {
                return None;
            }
            cell[family] = if is_back { line } else { line + 1 };
            start = crossing;
        }
        self.add(cell, [start, to]);
        Some(())
    }

    /// Adds the lines between the cells.
    fn add_lines(&mut self) {
        for family in 0..2 {
            for line in 0..self.families[family].crossings.len() {
                let [Some(start), Some(end)] = self.families[family].crossings[line] else {
                    continue;
                };
                self.add_line([family, line], [start, end]);
            }
        }
    }

    /// Adds a line, from the crossing of the outline into the cells in front of the line to the crossing back.
    fn add_line(&mut self, [family, line]: [usize; 2], [start, end]: [Crossing<T>; 2]) {
        let cells = |along: usize| {
            [line, line + 1].map(|across| {
                if family == 0 {
                    [across, along]
                } else {
                    [along, across]
                }
            })
        };
        let (mut point, mut cell) = start;
        while cell != end.1 {
            let is_back = end.1 < cell;
            let other = if is_back { cell - 1 } else { cell };
            let crossing = self.point([family, line], other, [&start.0, &end.0]);
            self.add_between(cells(cell), [point, crossing]);
            point = crossing;
            cell = if is_back { other } else { other + 1 };
        }
        self.add_between(cells(cell), [point, end.0]);
    }

    /// Returns the point at which a line between two points crosses a line of the other family. The lines of the columns compute the point,
    /// and the lines of the rows reuse it.
    fn point(
        &mut self,
        [family, line]: [usize; 2],
        other: usize,
        [from, to]: [&[T; 2]; 2],
    ) -> [T; 2] {
        let columns = self.columns() - 1;
        if family == 1 {
            return self.points[line * columns + other];
        }
        let share = self.families[1].share(other, [from, to]);
        let point = [0, 1].map(|i| from[i] + (to[i] - from[i]) * share);
        self.points[other * columns + line] = point;
        point
    }
}
