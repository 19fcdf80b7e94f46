use crate::mesh::PressureField;
use nalgebra::Vector3;

/// Fraction of the neighbors' sensitivities below which a jump of the gradient is ignored. The
/// fields of two bodies count as equal up to a difference ten times as large. So an ignored crease
/// or peak has no contact polygons around it, unless many such jumps follow one another.
const FLATNESS: f64 = 1e-10;

/// An edge of a tetrahedron, on a path from a peak of the field to the surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathEdge {
    /// Index of a tetrahedron that has the edge.
    pub tet: usize,
    /// The two corners of the tetrahedron that the edge joins.
    pub corners: [usize; 2],
}

/// Finds paths from the peaks of a concave field to the body's surface, and returns their edges. A
/// *closed* component of a contact surface has no boundary curve. If both bodies have such paths,
/// every closed component crosses a path of one body. Returns `None` if the field is not concave,
/// or if the body's surface is not connected.
///
/// The contact surface is part of {f = 0}, f = p_A − p_B. The proof has five steps.
///
/// 1. A closed component encloses a region inside both bodies, because the surface of each body is
///    connected.
/// 2. In the region, f is not 0 everywhere. Suppose that f has a maximum there, on a compact set M.
///    For a minimum, exchange A and B.
/// 3. Let x be an extreme point of M, so that no segment around x lies in M. Consider a line
///    through x on which p_A is linear. On this line f is convex, because p_B is concave. Because f
///    has a maximum at x, it is constant on the line near x. So M contains a segment around x,
///    which is a contradiction.
/// 4. Hence there is no such line. So x is a vertex of A at which the gradients of p_A span all
///    directions, a *peak*.
/// 5. The region therefore contains a peak of one body. A path of edges from the peak to that
///    body's surface leaves the region, and crosses the component.
pub(super) fn peak_paths(field: &PressureField) -> Option<Vec<PathEdge>> {
    (is_concave(field) && is_surface_connected(field)).then(|| edges_from(field, &peaks(field)))
}

/// Returns whether any two vertices of the surface are joined by a path over edges of the surface.
fn is_surface_connected(field: &PressureField) -> bool {
    let triangles = field.mesh().surface_triangles();
    let mut parent: Vec<usize> = (0..field.mesh().vertex_count()).collect();
    for [a, b, c] in triangles {
        for vertex in [b, c] {
            let (root, vertex) = (root_of(&mut parent, *a), root_of(&mut parent, *vertex));
            parent[vertex] = root;
        }
    }
    let root = root_of(&mut parent, triangles[0][0]);
    triangles
        .iter()
        .all(|triangle| root_of(&mut parent, triangle[0]) == root)
}

/// Returns the representative of a vertex's set (union-find). Halves the path for later calls.
fn root_of(parent: &mut [usize], mut vertex: usize) -> usize {
    while parent[vertex] != vertex {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    vertex
}

/// Returns whether the slope of the extent, across each face, does not increase.
fn is_concave(field: &PressureField) -> bool {
    field.tets().iter().enumerate().all(|(index, tet)| {
        (0..4).all(|corner| {
            let neighbor = field.mesh().neighbor(index, corner);
            // Each face is tested once, from the tetrahedron with the smaller index.
            let Some(neighbor_index) = neighbor.filter(|&neighbor_index| neighbor_index > index)
            else {
                return true;
            };
            let neighbor = &field.tets()[neighbor_index];
            let least = FLATNESS * tet.sensitivity.min(neighbor.sensitivity);
            let jump = neighbor.extent.gradient - tet.extent.gradient;
            let outward = -tet.barycentric[corner].gradient / tet.barycentric_steepness[corner];
            jump.dot(&outward) <= least
        })
    })
}

/// Returns the inner vertices through which there is no line along which the field is linear.
fn peaks(field: &PressureField) -> Vec<usize> {
    let mesh = field.mesh();
    let mut gradients: Vec<Vec<Vector3<f64>>> = vec![Vec::new(); mesh.vertex_count()];
    let mut least = vec![f64::INFINITY; mesh.vertex_count()];
    for (tet, vertices) in mesh.tets().iter().enumerate() {
        for &vertex in vertices
            .iter()
            .filter(|&&vertex| !mesh.is_on_surface(vertex))
        {
            let field_tet = &field.tets()[tet];
            gradients[vertex].push(field_tet.extent.gradient);
            least[vertex] = least[vertex].min(FLATNESS * field_tet.sensitivity);
        }
    }
    (0..mesh.vertex_count())
        .filter(|&vertex| !gradients[vertex].is_empty())
        .filter(|&vertex| span_space(&gradients[vertex], least[vertex]))
        .collect()
}

/// Returns whether the differences of the vectors have components above `least` in all directions.
fn span_space(vectors: &[Vector3<f64>], least: f64) -> bool {
    let mut differences: Vec<Vector3<f64>> = vectors.iter().map(|v| v - vectors[0]).collect();
    for _ in 0..3 {
        let longest = differences
            .iter()
            .copied()
            .max_by(|a, b| a.norm().total_cmp(&b.norm()));
        let Some(direction) = longest.and_then(|vector| vector.try_normalize(least)) else {
            return false;
        };
        for difference in &mut differences {
            *difference -= direction * difference.dot(&direction);
        }
    }
    true
}

/// Returns the edges of shortest paths from vertices to the surface, each edge once.
fn edges_from(field: &PressureField, starts: &[usize]) -> Vec<PathEdge> {
    let toward_surface = steps_to_surface(field);
    let mut is_done = vec![false; toward_surface.len()];
    let mut edges = Vec::new();
    for &start in starts {
        let mut vertex = start;
        while let Some(edge) = toward_surface[vertex].filter(|_| !is_done[vertex]) {
            is_done[vertex] = true;
            edges.push(edge);
            vertex = field.mesh().tets()[edge.tet][edge.corners[1]];
        }
    }
    edges
}

/// Returns, for each inner vertex, the first edge of a shortest path to the surface.
fn steps_to_surface(field: &PressureField) -> Vec<Option<PathEdge>> {
    let mesh = field.mesh();
    let mut tets_at: Vec<Vec<u32>> = vec![Vec::new(); mesh.vertex_count()];
    for (tet, vertices) in (0_u32..).zip(mesh.tets()) {
        for &vertex in vertices {
            tets_at[vertex].push(tet);
        }
    }
    let mut steps = vec![None; mesh.vertex_count()];
    let mut reached: Vec<usize> = (0..mesh.vertex_count())
        .filter(|&v| mesh.is_on_surface(v))
        .collect();
    let mut next = 0;
    while let Some(&vertex) = reached.get(next) {
        next += 1;
        for tet in tets_at[vertex].iter().map(|&tet| tet as usize) {
            let vertices = mesh.tets()[tet];
            let end_corner = vertices.iter().position(|&neighbor| neighbor == vertex);
            for (corner, &neighbor) in vertices.iter().enumerate() {
                if steps[neighbor].is_none() && !mesh.is_on_surface(neighbor) {
                    steps[neighbor] = end_corner.map(|to| PathEdge {
                        tet,
                        corners: [corner, to],
                    });
                    reached.push(neighbor);
                }
            }
        }
    }
    steps
}
