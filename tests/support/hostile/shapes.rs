//! Bodies of hostile pairs: regular shapes, and slivers as flat as a mesh allows.

use crate::support::scenes::Random;
use hydroelastic::contact::Shape;
use hydroelastic::mesh::{MeshError, PressureField, TetMesh, TriangleSurface, shapes};
use nalgebra::Vector3;

/// Shapes of one size.
pub struct Pool {
    regular: Vec<Shape>,
    slivers: Vec<Shape>,
}

impl Pool {
    pub fn of(size: f64, random: &mut Random) -> Self {
        let mut lengths = || [0, 1, 2].map(|_| size * random.between(0.3, 1.5));
        let regular = [
            shapes::cuboid([size; 3]),
            shapes::cuboid(lengths()),
            shapes::distance_cuboid([size, 0.5 * size, 1.5 * size]),
            shapes::distance_cuboid(lengths()),
            shapes::icosphere(0.6 * size, 0),
            shapes::icosphere(0.6 * size, 1),
            shapes::cylinder(0.5 * size, size, 6),
            tetrahedron(
                [
                    [1.0, 1.0, 1.0],
                    [1.0, -1.0, -1.0],
                    [-1.0, 1.0, -1.0],
                    [-1.0, -1.0, 1.0],
                ],
                0.5 * size,
            ),
            tetrahedron(
                [
                    [0.0, 0.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [0.0, 0.0, 1.0],
                ],
                size,
            ),
        ];
        let slivers = SLIVERS.map(|make| sliver(make, size, random));
        Self {
            regular: regular.map(|field| Shape::new(field.unwrap())).into(),
            slivers: slivers.into_iter().map(Shape::new).collect(),
        }
    }

    pub fn shapes(&self) -> impl Iterator<Item = &Shape> {
        self.regular.iter().chain(&self.slivers)
    }

    pub fn any(&self, is_sliver: bool, random: &mut Random) -> &Shape {
        let shapes = if is_sliver {
            &self.slivers
        } else {
            &self.regular
        };
        &shapes[random.below(shapes.len())]
    }
}

/// Creates a single tetrahedron with the distance to its surface, scaled to a size (m).
fn tetrahedron(corners: [[f64; 3]; 4], size: f64) -> Result<PressureField, MeshError> {
    let corners = corners.map(|corner| Vector3::from(corner) * size).into();
    PressureField::from_distance(&TetMesh::new(corners, vec![[0, 1, 2, 3]])?)
}

/// Creates a shape of a size (m) and a thickness relative to the size.
type Sliver = fn(f64, f64) -> Result<PressureField, MeshError>;

const SLIVERS: [Sliver; 6] = [
    flat,
    needle,
    plate,
    rod,
    off_center,
    off_center_with_distance,
];

/// Creates the shape with a random thickness, or a larger thickness if the mesh is invalid.
fn sliver(make: Sliver, size: f64, random: &mut Random) -> PressureField {
    let mut exponent = random.between(-12.0, -1.0);
    loop {
        match make(size, 10_f64.powf(exponent)) {
            Ok(field) => return field,
            Err(_) => exponent += 0.25,
        }
    }
}

/// Creates a tetrahedron with one low corner.
fn flat(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    tetrahedron(
        [
            [-0.5, -0.4, 0.0],
            [0.6, -0.3, 0.0],
            [0.0, 0.7, 0.0],
            [0.1, 0.1, thickness],
        ],
        size,
    )
}

/// Creates a tetrahedron with one short edge.
fn needle(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    tetrahedron(
        [
            [0.0, 0.0, 0.0],
            [thickness, 0.0, 0.0],
            [0.3, 1.0, 0.0],
            [0.2, 0.1, 0.9],
        ],
        size,
    )
}

fn plate(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    shapes::distance_cuboid([size, 0.8 * size, size * thickness])
}

fn rod(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    shapes::cuboid([size, size * thickness, 2.0 * size * thickness])
}

/// Creates a tetrahedron of four parts around a vertex that nearly lies in a face and has all of the pressure.
pub fn off_center(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    PressureField::new(
        off_center_mesh(size, thickness)?,
        vec![0.0, 0.0, 0.0, 0.0, 1.0],
    )
}

/// Creates this mesh with another extent at the vertex, so the field is as steep in the sliver as beside it.
fn off_center_with_distance(size: f64, thickness: f64) -> Result<PressureField, MeshError> {
    PressureField::new(
        off_center_mesh(size, thickness)?,
        vec![0.0, 0.0, 0.0, 0.0, thickness],
    )
}

fn off_center_mesh(size: f64, thickness: f64) -> Result<TetMesh, MeshError> {
    let corners = [
        [-0.5, -0.4, 0.0],
        [0.6, -0.3, 0.0],
        [0.0, 0.7, 0.0],
        [0.1, 0.1, 0.8],
        [0.1, 0.0, thickness],
    ];
    let vertices = corners.map(|corner| Vector3::from(corner) * size).into();
    TetMesh::new(
        vertices,
        vec![[0, 1, 2, 4], [0, 1, 4, 3], [0, 4, 2, 3], [4, 1, 2, 3]],
    )
}

/// Number of edges that are divided one after the other.
const DIVISIONS: usize = 6;

/// Returns the surface with edges divided near an end, so that it has both huge and tiny triangles, or `None` if they become too thin.
pub fn graded(surface: &TriangleSurface, random: &mut Random) -> Option<TriangleSurface> {
    let mut vertices = surface.vertices().to_vec();
    let mut triangles = surface.triangles().to_vec();
    for _ in 0..DIVISIONS {
        let (triangle, edge) = (random.below(triangles.len()), random.below(3));
        let ends = [1, 2].map(|k| triangles[triangle][(edge + k) % 3]);
        let [start, end] = ends.map(|vertex| vertices[vertex]);
        let part = 10_f64.powf(random.between(-3.0, -0.3));
        vertices.push(start + (end - start) * part);
        let middle = vertices.len() - 1;
        let mut divided = Vec::new();
        for corners in &mut triangles {
            if ends.iter().all(|end| corners.contains(end)) {
                let second_half = corners.map(|v| if v == ends[0] { middle } else { v });
                *corners = corners.map(|v| if v == ends[1] { middle } else { v });
                divided.push(second_half);
            }
        }
        triangles.extend(divided);
    }
    TriangleSurface::new(vertices, triangles).ok()
}
