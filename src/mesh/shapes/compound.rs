use crate::bvh::Bvh;
use crate::geometry::{Aabb, EDGES};
use crate::mesh::{MeshError, PressureField, TetMesh};
use crate::spatial::Pose;
use nalgebra::Vector3;

/// Depth to which parts may overlap by rounding error, over the size of the compound.
const TOUCH: f64 = 1e-9;

/// Combines several fields into one. Each field comes with the pose of its frame in the body frame.
///
/// The parts may touch, but must not overlap. Each part has the extents, and therefore the pressure, that it has alone. Between parts that
/// touch, the extent is 0. For parts that do not touch, [`TriangleSurface::around`](crate::mesh::TriangleSurface::around) makes a rigid
/// surface of the mesh.
///
/// ```
/// use hydroelastic::mesh::shapes;
/// use hydroelastic::spatial::Pose;
/// use nalgebra::vector;
///
/// let (head, handle) = (shapes::cuboid([0.1, 0.03, 0.03])?, shapes::cylinder(0.01, 0.3, 16)?);
/// let below = Pose::from_translation(vector![0.0, 0.0, -0.165]);
/// let hammer = shapes::compound(&[(&head, Pose::identity()), (&handle, below)])?;
/// let volume = head.mesh().volume() + handle.mesh().volume();
/// assert!((hammer.mesh().volume() - volume).abs() < 1e-15);
/// # Ok::<(), hydroelastic::mesh::MeshError>(())
/// ```
///
/// # Errors
/// Returns an error if there are no parts, or if two parts overlap by more than 1e-9 of the size of the compound.
pub fn compound(parts: &[(&PressureField, Pose)]) -> Result<PressureField, MeshError> {
    let (mut vertices, mut tets, mut extents) = (Vec::new(), Vec::new(), Vec::new());
    for (field, pose) in parts {
        let (mesh, start) = (field.mesh(), vertices.len());
        vertices.extend(
            mesh.vertices()
                .iter()
                .map(|vertex| pose.transformed_point(vertex)),
        );
        tets.extend(
            mesh.tets()
                .iter()
                .map(|tet| tet.map(|vertex| start + vertex)),
        );
        extents.extend(field.extents());
    }
    let mesh = TetMesh::new(vertices, tets)?;
    check_parts(&mesh, parts)?;
    PressureField::with_inert_tets(mesh, extents)
}

/// Checks that no tetrahedra of different parts overlap.
fn check_parts(mesh: &TetMesh, parts: &[(&PressureField, Pose)]) -> Result<(), MeshError> {
    let counts = parts.iter().map(|(field, _)| field.mesh().tet_count());
    let part_of: Vec<usize> = counts
        .enumerate()
        .flat_map(|(part, count)| std::iter::repeat_n(part, count))
        .collect();
    let corners = |tet: usize| mesh.tetrahedron(tet).corners;
    let bvh = Bvh::new((0..mesh.tet_count()).map(|tet| (tet, corners(tet))));
    let touch = TOUCH * 2.0 * mesh.aabb().half_extents().norm();
    for tet in 0..mesh.tet_count() {
        let mut overlapping = None;
        let first = corners(tet);
        bvh.visit_overlapping(&Aabb::around(&first), |other| {
            if part_of[other] > part_of[tet] && overlapping.is_none() {
                let depth = overlap(&first, &corners(other), touch);
                overlapping = depth.map(|depth| (other, depth));
            }
        });
        if let Some((other, depth)) = overlapping {
            let center = first.iter().sum::<Vector3<f64>>() / 4.0;
            return Err(MeshError::OverlappingParts {
                parts: [part_of[tet], part_of[other]],
                depth,
                near: center.into(),
            });
        }
    }
    Ok(())
}

/// Returns the depth (m) to which two tetrahedra overlap, or `None` if it is at most `touch` (m), by the separating-axis theorem.
fn overlap(first: &[Vector3<f64>; 4], second: &[Vector3<f64>; 4], touch: f64) -> Option<f64> {
    let edges = |corners: &[Vector3<f64>; 4]| EDGES.map(|[from, to]| corners[to] - corners[from]);
    let normals = |edges: [Vector3<f64>; 6]| {
        [[0, 1], [0, 2], [1, 2], [3, 4]].map(|[one, other]| edges[one].cross(&edges[other]))
    };
    let [of_a, of_b] = [edges(first), edges(second)];
    let crossed = of_a
        .iter()
        .flat_map(|edge| of_b.map(|other| edge.cross(&other)));
    let axes = normals(of_a)
        .into_iter()
        .chain(normals(of_b))
        .chain(crossed);
    let mut depth = f64::INFINITY;
    for axis in axes {
        // Parallel edges span no axis.
        let Some(axis) = axis.try_normalize(1e-12 * touch * touch) else {
            continue;
        };
        let range = |corners: &[Vector3<f64>; 4]| {
            let heights = corners.map(|corner| corner.dot(&axis));
            heights
                .into_iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
                    (low.min(height), high.max(height))
                })
        };
        let ((low_a, high_a), (low_b, high_b)) = (range(first), range(second));
        depth = depth.min((high_a - low_b).min(high_b - low_a));
        if depth <= touch {
            return None;
        }
    }
    Some(depth)
}
