use crate::mesh::TriangleSoup;
use nalgebra::{Matrix4, Vector3};

/// Number of triangles that a scene may have in addition to the size of its file (bytes). A small file can repeat a part many times.
const MAX_EXTRA_COUNT: usize = 1_000_000;

/// Depth limit of the tree of nodes.
pub(super) const MAX_DEPTH: usize = 64;

/// Triangles of a file whose parts have transforms.
pub(super) struct Scene {
    pub soup: TriangleSoup,
    /// Number of triangles or vertices that may still be read or added.
    remaining: usize,
}

impl Scene {
    /// Creates an empty scene for a file of this size (bytes).
    pub fn of_file(size: usize) -> Self {
        Self {
            soup: TriangleSoup::default(),
            remaining: MAX_EXTRA_COUNT + size,
        }
    }

    /// Reduces the number of triangles or vertices that may still be read or added.
    ///
    /// # Errors
    /// Returns the cause if the scene becomes too large.
    pub fn charge(&mut self, count: usize) -> Result<(), &'static str> {
        let remaining = self.remaining.checked_sub(count);
        self.remaining = remaining.ok_or("repeated parts make more than a million triangles")?;
        Ok(())
    }

    /// Adds a part. A mirrored part has its triangles reversed.
    ///
    /// # Errors
    /// Returns the cause if the scene becomes too large.
    pub fn add(
        &mut self,
        part: &TriangleSoup,
        transform: &Matrix4<f64>,
    ) -> Result<(), &'static str> {
        self.charge(part.triangles.len().max(part.vertices.len()) + 1)?;
        let start = self.soup.vertices.len();
        let position = |point: &Vector3<f64>| (transform * point.push(1.0)).xyz();
        self.soup
            .vertices
            .extend(part.vertices.iter().map(position));
        let is_mirrored = transform.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        let triangles = part.triangles.iter().map(|&[a, b, c]| {
            let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
            corners.map(|corner| start.saturating_add(corner))
        });
        self.soup.triangles.extend(triangles);
        Ok(())
    }
}

/// Triangles of a strip of corners: every corner after the second makes a triangle with the two before it.
pub(super) fn strip(corners: &[usize]) -> impl Iterator<Item = [usize; 3]> {
    let triangles = corners.windows(3).enumerate();
    triangles.map(|(index, corners)| {
        let [a, b, c] = [corners[0], corners[1], corners[2]];
        if index % 2 == 0 { [a, b, c] } else { [a, c, b] }
    })
}

/// Triangles of a fan around the first corner.
pub(super) fn fan(corners: &[usize]) -> impl Iterator<Item = [usize; 3]> {
    let pairs = corners.get(1..).unwrap_or_default().windows(2);
    pairs.map(|pair| [corners[0], pair[0], pair[1]])
}
