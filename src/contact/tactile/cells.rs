//! Areas and loads of the parts of a convex outline in the cells between two families of lines.
//!
//! The integrals over a part are the sum over its edges of the integrals over the triangles between the origin and the edge. With p₀, p_a and
//! p_b the pressures at the corners 0, a and b of such a triangle, t = a₁b₂ − a₂b₁ and S = p₀ + p_a + p_b,
//!
//! ∫ dA = t/2,  ∫ p dA = t S/6,  ∫ p yᵢ dA = t/24 ((S + p_a) aᵢ + (S + p_b) bᵢ).
//!
//! An edge of a part belongs to an edge of the outline, or to a line. A walk around the outline divides its edges where they cross lines.
//! A line enters and leaves the outline at two of these crossings, and the lines of the other family divide it between them. Each segment
//! of a line counts once for the cell on one side, and once with the opposite sign for the cell on the other side.
//!
//! Only the walk decides which lines cross each other. Two lines cross if the crossings of one line separate the crossings of the other
//! line along the outline. Therefore the edges of every part close, and the integrals over all parts add up to the integrals over the
//! outline, regardless of round-off in the crossings.

use crate::contact::outline::{Outline, at};
use crate::friction::Affine;
use crate::scalar::{Scalar, lift, real_part};

/// A point: y₁, y₂ and the pressure.
type Point<T> = [T; 3];

/// A point at which a line crosses the outline, and the index of its cell along the line.
type Crossing<T> = (Point<T>, usize);

/// Integrals over a part of the outline.
#[derive(Clone, Copy)]
pub(super) struct Load<T> {
    /// ∫ dA (m²).
    pub area: T,
    /// ∫ p dA (N).
    pub total: T,
    /// ∫ p y₁ dA and ∫ p y₂ dA (N m).
    pub by_y: [T; 2],
}

/// A family of ordered lines, and their crossings with the outline. Line l is between the cells l and l + 1.
struct Family<T> {
    functions: Vec<Affine<T>>,
    /// The index in the grid of the first strip. Cell c is in strip `first_strip + c`.
    first_strip: usize,
    /// Strip of each corner of the outline.
    corner_strips: Vec<usize>,
    /// For each line l, the crossing of the outline from cell l to cell l + 1, and the crossing back.
    crossings: Vec<[Option<Crossing<T>>; 2]>,
}

/// The loads of all cells, row by row. The memory is reused for other outlines.
pub(super) struct Cells<T> {
    families: [Family<T>; 2],
    /// For each cell, 2 ∫ dA, 6 ∫ p dA, 24 ∫ p y₁ dA and 24 ∫ p y₂ dA.
    sums: Vec<[T; 4]>,
    /// Points at which lines of both families cross, row by row.
    points: Vec<Point<T>>,
    /// The pressure at the origin.
    at_origin: T,
}

impl<T: Scalar> Family<T> {
    fn empty() -> Self {
        Self {
            functions: Vec::new(),
            first_strip: 0,
            corner_strips: Vec::new(),
            crossings: Vec::new(),
        }
    }

    /// Returns the fraction of the segment between two points at which the segment crosses a line.
    fn fraction(&self, line: usize, [from, to]: [&Point<T>; 2]) -> T {
        let [before, after] = [from, to].map(|[y1, y2, _]| at(&self.functions[line], &[*y1, *y2]));
        let share = before / (before - after);
        // Round-off may put both points on the same side of the line, or on the line.
        let real = real_part(share);
        if (0.0..=1.0).contains(&real) {
            share
        } else if real.is_finite() {
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
            sums: Vec::new(),
            points: Vec::new(),
            at_origin: lift(0.0),
        }
    }

    /// Clears the list of the columns (family 0) or rows (family 1) of the corners of the outline, and returns it. The caller appends an index
    /// for each corner.
    pub fn cleared_corner_strips(&mut self, family: usize) -> &mut Vec<usize> {
        let strips = &mut self.families[family].corner_strips;
        strips.clear();
        strips
    }

    /// Sets the first column (family 0) or row (family 1) that contains a part of the outline, and the lines between this strip and the
    /// following ones. Each function is zero on its line.
    pub fn set_lines(
        &mut self,
        family: usize,
        first_strip: usize,
        functions: impl Iterator<Item = Affine<T>>,
    ) {
        let family = &mut self.families[family];
        family.first_strip = first_strip;
        family.functions.clear();
        family.functions.extend(functions);
    }

    /// Divides an outline under a pressure by the lines. Returns `None` if round-off makes a line cross the outline more than twice.
    pub fn divide(&mut self, outline: &Outline<T>, pressure: &Affine<T>) -> Option<()> {
        let nothing = lift::<T>(0.0);
        let [columns, rows] = self
            .families
            .each_ref()
            .map(|family| family.functions.len());
        for family in &mut self.families {
            family.crossings.clear();
            family.crossings.resize(family.functions.len(), [None; 2]);
        }
        self.sums.clear();
        self.sums.resize((columns + 1) * (rows + 1), [nothing; 4]);
        self.points.resize(columns * rows, [nothing; 3]);
        self.at_origin = pressure[0];
        self.add_outline(outline, pressure)?;
        self.add_lines();
        Some(())
    }

    /// Returns the column, the row and the load of each part whose area is not zero. The loads are multiplied by a weight.
    pub fn loads(&self, weight: f64) -> impl Iterator<Item = ([usize; 2], Load<T>)> {
        let [area_factor, total_factor, moment_factor] =
            [weight / 2.0, weight / 6.0, weight / 24.0];
        let columns = self.columns();
        let [first_column, first_row] = self.families.each_ref().map(|family| family.first_strip);
        let rows = (first_row..).zip(self.sums.chunks_exact(columns));
        let parts = rows.flat_map(move |(row, sums)| {
            (first_column..)
                .zip(sums)
                .map(move |(column, sums)| ([column, row], sums))
        });
        let parts = parts.filter(|(_, [area, ..])| real_part(*area).abs() > 0.0);
        parts.map(move |(cell, [area, total, by_y1, by_y2])| {
            let load = Load {
                area: *area * area_factor,
                total: *total * total_factor,
                by_y: [*by_y1 * moment_factor, *by_y2 * moment_factor],
            };
            (cell, load)
        })
    }

    fn columns(&self) -> usize {
        self.families[0].functions.len() + 1
    }

    /// Returns the sums of the triangle between the origin and two points.
    #[inline(always)]
    fn triangle(&self, [[a1, a2, pa], [b1, b2, pb]]: [Point<T>; 2]) -> [T; 4] {
        let cross = a1 * b2 - a2 * b1;
        let pressure = self.at_origin + pa + pb;
        let (of_a, of_b) = (pressure + pa, pressure + pb);
        [
            cross,
            cross * pressure,
            cross * (of_a * a1 + of_b * b1),
            cross * (of_a * a2 + of_b * b2),
        ]
    }

    fn add(&mut self, [column, row]: [usize; 2], ends: [Point<T>; 2]) {
        let triangle = self.triangle(ends);
        let cell = row * self.columns() + column;
        for (sum, number) in self.sums[cell].iter_mut().zip(triangle) {
            *sum += number;
        }
    }

    /// Adds a segment of a line between two cells.
    fn add_between(&mut self, cells: [[usize; 2]; 2], ends: [Point<T>; 2]) {
        let triangle = self.triangle(ends);
        let [behind, ahead] = cells.map(|[column, row]| row * self.columns() + column);
        for (sum, number) in self.sums[behind].iter_mut().zip(triangle) {
            *sum += number;
        }
        for (sum, number) in self.sums[ahead].iter_mut().zip(triangle) {
            *sum -= number;
        }
    }

    /// Adds the edges of the outline, and records their crossings with lines.
    fn add_outline(&mut self, outline: &Outline<T>, pressure: &Affine<T>) -> Option<()> {
        let corners = outline.corners();
        let corner = |cells: &Self, number: usize| {
            let families = cells.families.each_ref();
            let y = corners[number];
            let point = [y[0], y[1], at(pressure, &y)];
            let cell = |family: &Family<T>| family.corner_strips[number] - family.first_strip;
            (point, families.map(cell))
        };
        let mut before = corner(self, corners.len().checked_sub(1)?);
        for number in 0..corners.len() {
            let now = corner(self, number);
            self.add_edge(before, now)?;
            before = now;
        }
        Some(())
    }

    /// Adds an edge of the outline from a point in a cell to another.
    fn add_edge(
        &mut self,
        (from, mut cell): (Point<T>, [usize; 2]),
        (to, end): (Point<T>, [usize; 2]),
    ) -> Option<()> {
        let mut start = from;
        let mut next = [0, 1].map(|family| self.next_crossing(family, [&from, &to], [cell, end]));
        while cell != end {
            let family = match next {
                [Some((first, _)), Some((second, _))] => {
                    usize::from(real_part(second) < real_part(first))
                }
                [first, _] => usize::from(first.is_none()),
            };
            let (fraction, line) = next[family]?;
            let crossing = interpolated([&from, &to], fraction);
            self.add(cell, [start, crossing]);
            let is_back = end[family] < cell[family];
            let noted = &mut self.families[family].crossings[line][usize::from(is_back)];
            if noted.replace((crossing, cell[1 - family])).is_some() {
                return None;
            }
            cell[family] = if is_back { line } else { line + 1 };
            next[family] = self.next_crossing(family, [&from, &to], [cell, end]);
            start = crossing;
        }
        self.add(cell, [start, to]);
        Some(())
    }

    /// Returns the fraction of an edge at which it crosses the next line of a family, and the line. Returns `None` if it crosses no more
    /// lines of the family.
    fn next_crossing(
        &self,
        family: usize,
        ends: [&Point<T>; 2],
        [cell, end]: [[usize; 2]; 2],
    ) -> Option<(T, usize)> {
        (cell[family] != end[family]).then(|| {
            let line = cell[family] - usize::from(end[family] < cell[family]);
            (self.families[family].fraction(line, ends), line)
        })
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
        ends: [&Point<T>; 2],
    ) -> Point<T> {
        let columns = self.columns() - 1;
        if family == 1 {
            return self.points[line * columns + other];
        }
        let point = interpolated(ends, self.families[1].fraction(other, ends));
        self.points[other * columns + line] = point;
        point
    }
}

/// Returns the point at a fraction of the segment between two points.
fn interpolated<T: Scalar>([from, to]: [&Point<T>; 2], fraction: T) -> Point<T> {
    [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * fraction)
}
