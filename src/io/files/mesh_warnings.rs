use super::FileWarning;
use crate::geometry::Tetrahedron;
use crate::mesh::{TetMesh, unusual_size};

/// Smallest height of a tetrahedron divided by its longest edge, below which the tetrahedron is thin.
const THIN: f64 = 1e-3;

/// Warnings about the size and the tetrahedra of a mesh that was read with a unit (m).
pub(super) fn of(mesh: &TetMesh, unit: f64) -> Vec<FileWarning> {
    let mut warnings = Vec::new();
    if let Some(size) = unusual_size(&mesh.aabb()) {
        warnings.push(FileWarning::Size { size, unit });
    }
    let ratios = (0..mesh.tet_count()).map(|tet| (thinness(&mesh.tetrahedron(tet)), tet));
    let thin: Vec<(f64, usize)> = ratios.filter(|(ratio, _)| *ratio < THIN).collect();
    if let Some((ratio, worst)) = thin.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0)) {
        warnings.push(FileWarning::ThinTetrahedra {
            count: thin.len(),
            ratio,
            at: mesh.tetrahedron(worst).corners[0],
        });
    }
    warnings
}

/// Smallest height of a tetrahedron divided by its longest edge.
fn thinness(tetrahedron: &Tetrahedron) -> f64 {
    let fields = tetrahedron.barycentric_fields();
    let steepest = fields
        .iter()
        .map(|field| field.gradient.norm())
        .fold(0.0, f64::max);
    1.0 / (steepest * tetrahedron.longest_edge())
}
