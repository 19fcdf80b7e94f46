//! Data sets of VTK files: unstructured grids, and polygons as cells.

use super::file_contents::{Cell, FileContents, PointData};
use super::polygons::add_polygon;
use super::scene::strip;
use crate::mesh::TriangleSoup;
use nalgebra::Vector3;
use std::iter::repeat_n;

/// Types of faces with straight edges.
const TRIANGLE: i64 = 5;
pub(super) const STRIP: i64 = 6;
pub(super) const POLYGON: i64 = 7;
const PIXEL: i64 = 8;
const QUADRILATERAL: i64 = 9;

/// Lists of vertex indices.
#[derive(Debug, Default)]
pub(super) struct Lists {
    vertices: Vec<i64>,
    /// End of each list in the vertices.
    ends: Vec<usize>,
}

/// Contents of a VTK file.
#[derive(Debug, Default)]
pub(super) struct DataSet {
    /// True for a surface of polygons (PolyData), and false for an unstructured grid.
    pub is_poly_data: bool,
    pub points: Vec<f64>,
    pub cells: Lists,
    /// Type of each cell.
    pub types: Vec<i64>,
    /// Arrays with one component. Their lengths may be wrong.
    pub point_data: PointData,
}

impl Lists {
    /// Splits a list in which the number of vertices precedes the vertices of each cell.
    pub fn from_counted(mut list: &[i64]) -> Result<Self, String> {
        let mut lists = Self::default();
        while let Some((&count, rest)) = list.split_first() {
            let split = usize::try_from(count)
                .ok()
                .and_then(|count| rest.split_at_checked(count));
            let (vertices, rest) = split
                .ok_or_else(|| format!("cell {} cannot have {count} vertices", lists.ends.len()))?;
            lists.vertices.extend(vertices);
            lists.ends.push(lists.vertices.len());
            list = rest;
        }
        Ok(lists)
    }

    /// Splits a list at `ends`, which must not decrease.
    pub fn from_ends(vertices: Vec<i64>, ends: &[i64]) -> Result<Self, String> {
        let mut previous = 0;
        let mut checked = Vec::with_capacity(ends.len());
        for (cell, &end) in ends.iter().enumerate() {
            let valid = usize::try_from(end)
                .ok()
                .filter(|end| (previous..=vertices.len()).contains(end));
            previous = valid.ok_or_else(|| {
                let count = vertices.len();
                format!("cell {cell} cannot end at {end} in a list of {count} vertices")
            })?;
            checked.push(previous);
        }
        Ok(Self {
            vertices,
            ends: checked,
        })
    }

    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Appends lists, and adds `first_vertex` to their indices.
    pub fn append(&mut self, other: &Self, first_vertex: i64) {
        let start = self.vertices.len();
        let vertices = other
            .vertices
            .iter()
            .map(|v| v.saturating_add(first_vertex));
        self.vertices.extend(vertices);
        self.ends.extend(other.ends.iter().map(|end| end + start));
    }

    fn iter(&self) -> impl Iterator<Item = &[i64]> {
        let starts = [0].into_iter().chain(self.ends.iter().copied());
        let ranges = starts.zip(self.ends.iter().copied());
        ranges.map(|(start, end)| &self.vertices[start..end])
    }
}

impl DataSet {
    /// Adds cells of one type, and adds `first_vertex` to their indices.
    pub fn add_cells(&mut self, cells: &Lists, first_vertex: i64, kind: i64) {
        self.cells.append(cells, first_vertex);
        self.types.extend(repeat_n(kind, cells.len()));
    }

    fn vertices(&self) -> Vec<Vector3<f64>> {
        let points = self.points.as_chunks::<3>().0;
        points.iter().map(|&point| point.into()).collect()
    }

    /// Returns true if there are solid cells, such as tetrahedra.
    pub fn has_solids(&self) -> bool {
        let is_solid = |kind| matches!(kind, Cell::Tet | Cell::HigherTet | Cell::Solid(_));
        self.types.iter().copied().filter_map(cell).any(is_solid)
    }

    /// Returns true for polygons, and for a grid of faces without solid cells.
    pub fn is_surface(&self) -> bool {
        let mut cells = self.types.iter().copied().filter_map(cell);
        self.is_poly_data || (cells.any(|cell| cell == Cell::Face) && !self.has_solids())
    }

    /// Checks that each cell of a grid has a type.
    fn check_types(&self) -> Result<(), String> {
        match (self.types.len(), self.cells.len()) {
            (types, cells) if types == cells => Ok(()),
            (types, cells) => Err(format!(
                "there are {cells} cells, but {types} types of cells"
            )),
        }
    }

    /// Returns the cells and the point data of a grid.
    pub fn into_contents(self) -> Result<FileContents, String> {
        self.check_types()?;
        let mut contents = FileContents::default();
        contents.vertices = self.vertices();
        let count = contents.vertices.len();
        let arrays = self.point_data.into_iter();
        contents.point_data = arrays.filter(|(_, values)| values.len() == count).collect();
        for (index, (&kind, vertices)) in self.types.iter().zip(self.cells.iter()).enumerate() {
            let unknown = || format!("cell {index} has the unknown type {kind}");
            if !contents.add(cell(kind).ok_or_else(unknown)?, vertices) {
                let count = vertices.len();
                return Err(format!(
                    "cell {index} of type {kind} cannot have {count} vertices"
                ));
            }
        }
        Ok(contents)
    }

    /// Returns the triangles of polygons and strips, which may be cells of a grid. Points and lines are ignored.
    pub fn triangles(&self) -> Result<TriangleSoup, String> {
        self.check_types()?;
        let vertices = self.vertices();
        let count = vertices.len();
        let index = |&vertex: &i64| {
            let index = usize::try_from(vertex).ok().filter(|&index| index < count);
            index.ok_or_else(|| format!("vertex {vertex} is not one of the {count} vertices"))
        };
        let mut soup = TriangleSoup {
            vertices,
            triangles: Vec::new(),
        };
        for (number, (&kind, cell)) in self.types.iter().zip(self.cells.iter()).enumerate() {
            let corners = cell.iter().map(index).collect::<Result<Vec<_>, _>>();
            let added = corners.and_then(|corners| add_cell(&mut soup, kind, &corners));
            added.map_err(|cause| format!("cell {number}: {cause}"))?;
        }
        Ok(soup)
    }
}

/// Adds the triangles of a cell of this type.
///
/// # Errors
/// Returns the cause if the cell has curved edges or an unknown type. Also returns the errors of [`add_polygon`].
fn add_cell(soup: &mut TriangleSoup, kind: i64, corners: &[usize]) -> Result<(), String> {
    match (kind, corners) {
        (TRIANGLE | POLYGON | QUADRILATERAL, _) => Ok(add_polygon(soup, corners)?),
        // A pixel is a rectangle whose corners are sorted by their coordinates.
        (PIXEL, &[a, b, c, d]) => Ok(add_polygon(soup, &[a, b, d, c])?),
        (STRIP, _) => {
            soup.triangles.extend(strip(corners));
            Ok(())
        }
        _ if cell(kind) == Some(Cell::Line) => Ok(()),
        _ => Err(format!(
            "type {kind} with {} vertices is not a triangle, strip or polygon with straight edges",
            corners.len()
        )),
    }
}

/// Kind of a cell type of VTK.
fn cell(kind: i64) -> Option<Cell> {
    Some(match kind {
        10 => Cell::Tet,
        24 | 55 | 64 | 71 | 78 => Cell::HigherTet,
        0..=4 | 21 | 35 | 51 | 60 | 68 | 75 => Cell::Line,
        5..=9 | 22 | 23 | 28 | 30 | 34 | 36 | 52..=54 | 61..=63 | 69 | 70 | 76 | 77 => Cell::Face,
        11 | 12 | 25 | 29 | 33 | 56 | 67 | 72 | 79 => Cell::Solid("hexahedron"),
        13 | 26 | 31 | 32 | 65 | 73 | 80 => Cell::Solid("prism"),
        14 | 27 | 37 | 66 | 74 | 81 => Cell::Solid("pyramid"),
        15 | 16 | 41 | 42 => Cell::Solid("polyhedron"),
        _ => return None,
    })
}
