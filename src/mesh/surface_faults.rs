use nalgebra::Vector3;
use std::fmt;

/// Faults of triangles that are not a closed surface.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct SurfaceFaults {
    /// Edges that belong to one triangle only. The surface has a hole, or vertices at the same position are not merged.
    pub open: Option<Fault<2>>,
    /// Edges of two triangles with inconsistent orientations.
    pub inconsistent: Option<Fault<2>>,
    /// Edges of more than two triangles, with unequal numbers of triangles in the two directions.
    pub unbalanced: Option<Fault<2>>,
    /// Triangles without area, to within rounding error.
    pub thin: Option<Fault<3>>,
    /// Triangles that repeat another one with the same orientation. The other faults do not count them.
    pub repeated: Option<Fault<3>>,
}

/// A kind of fault: the number of edges (N = 2) or triangles (N = 3), and the first of them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Fault<const N: usize> {
    /// Number of edges or triangles.
    pub count: usize,
    /// Corners (m) of the first edge or triangle, in the order of the triangle.
    pub first: [Vector3<f64>; N],
}

impl<const N: usize> Fault<N> {
    /// Counts edges or triangles.
    pub(super) fn of(mut corners: impl Iterator<Item = [Vector3<f64>; N]>) -> Option<Self> {
        let first = corners.next()?;
        let count = 1 + corners.count();
        Some(Self { count, first })
    }
}

impl fmt::Display for SurfaceFaults {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edges = [
            (&self.open, "edges belong to one triangle only"),
            (
                &self.inconsistent,
                "edges have two triangles of inconsistent orientation",
            ),
            (
                &self.unbalanced,
                "edges have more than two triangles of unbalanced orientations",
            ),
        ];
        let edges = edges.into_iter().filter_map(|(fault, kind)| {
            let Fault { count, first } = (*fault)?;
            Some(format!("{count} {kind}, the first {}", path(&first)))
        });
        let triangles = [
            (&self.thin, "triangles have no area"),
            (
                &self.repeated,
                "triangles repeat others with the same orientation",
            ),
        ];
        let triangles = triangles.into_iter().filter_map(|(fault, kind)| {
            let Fault { count, first } = (*fault)?;
            Some(format!("{count} {kind}, the first {}", path(&first)))
        });
        let all: Vec<String> = edges.chain(triangles).collect();
        formatter.write_str(&all.join("; "))
    }
}

fn path(points: &[Vector3<f64>]) -> String {
    let points = points.iter().map(point);
    format!("from {} m", points.collect::<Vec<_>>().join(" to "))
}

/// Returns the coordinates of a point for a message.
pub(super) fn point(point: &Vector3<f64>) -> String {
    format!("({}, {}, {})", point.x, point.y, point.z)
}
