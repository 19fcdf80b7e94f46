//! Random and deliberately degenerate scenes, the same in every run.

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::{PressureField, TetMesh, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::Vector3;
use proptest::test_runner::{RngAlgorithm, TestRng};
use rand::RngExt;

/// A random number generator with its own seed.
pub struct Random(TestRng);

impl Random {
    pub fn new(seed: u8) -> Self {
        Self(TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]))
    }

    /// Creates one of 2⁶⁴ generators.
    pub fn numbered(number: u64) -> Self {
        let mut seed = [0; 32];
        seed[..8].copy_from_slice(&number.to_le_bytes());
        Self(TestRng::from_seed(RngAlgorithm::ChaCha, &seed))
    }

    /// Returns a uniform number in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// Returns a uniform vector in the cube [−1, 1)³.
    pub fn vector(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.between(-1.0, 1.0))
    }

    pub fn direction(&mut self) -> Vector3<f64> {
        loop {
            let vector = self.vector();
            if (0.1..1.0).contains(&vector.norm()) {
                return vector.normalize();
            }
        }
    }

    /// Returns the rotation vector of a rotation by up to half a turn.
    pub fn rotation_vector(&mut self) -> Vector3<f64> {
        self.direction() * self.between(0.0, std::f64::consts::PI)
    }
}

/// Returns shapes of about radius 1: star-shaped, layered and non-convex shapes.
pub fn mixed_shapes() -> Vec<Shape> {
    let fields = [
        shapes::icosphere(1.0, 0),
        shapes::icosphere(1.0, 1),
        shapes::icosphere(1.0, 2),
        shapes::ellipsoid([0.6, 0.8, 1.1], 1),
        shapes::cuboid([1.2, 1.4, 1.0]),
        shapes::distance_cuboid([1.0, 1.3, 1.7]),
        shapes::cylinder(0.8, 1.5, 7),
        shapes::cylinder(0.9, 0.7, 9),
        grid(&[3, 3, 3], 0.45, |_| true),
        grid(&[3, 3, 2], 0.6, |[i, j, _]| i == 0 || j == 0),
    ];
    fields.map(|field| Shape::new(field.unwrap())).into()
}

/// Returns the cubes of the given edge, in a grid centered on the origin, for which `keep` is true. Each has six tetrahedra, and the field
/// is the distance to the surface.
pub fn grid(
    counts: &[usize; 3],
    edge: f64,
    keep: impl Fn([usize; 3]) -> bool,
) -> Result<PressureField, hydroelastic::mesh::MeshError> {
    let [nx, ny, nz] = *counts;
    let index = |i: usize, j: usize, k: usize| (i * (ny + 1) + j) * (nz + 1) + k;
    let mut tets = Vec::new();
    for (i, j, k) in cells([nx, ny, nz]).filter(|&(i, j, k)| keep([i, j, k])) {
        // Kuhn's triangulation: one tetrahedron for each order of the axes.
        for [first, second] in [[0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1]] {
            let (mut at, mut tet) = ([i, j, k], vec![index(i, j, k)]);
            for axis in [first, second, 3 - first - second] {
                at[axis] += 1;
                tet.push(index(at[0], at[1], at[2]));
            }
            tets.push([tet[0], tet[1], tet[2], tet[3]]);
        }
    }
    let corner = |(i, j, k): (usize, usize, usize)| {
        let half = Vector3::new(nx as f64, ny as f64, nz as f64) * 0.5;
        (Vector3::new(i as f64, j as f64, k as f64) - half) * edge
    };
    let vertices: Vec<_> = cells([nx + 1, ny + 1, nz + 1]).map(corner).collect();
    let (vertices, tets) = without_unused(&vertices, &tets);
    PressureField::from_distance(&TetMesh::new(vertices, tets)?)
}

/// Returns an icosphere with a shell of vertices halfway inside, with these extents of its center and of the shell. If the center has the
/// smaller extent, the field has a dent there.
pub fn dented_ball(radius: f64, order: usize, extents: [f64; 2]) -> PressureField {
    layered(&shapes::icosphere(radius, order).unwrap(), extents)
}

/// Returns a star-shaped solid about the origin with a shell of vertices halfway inside, with these extents of its center and of the shell.
pub fn layered(solid: &PressureField, extents: [f64; 2]) -> PressureField {
    let (mesh, mut vertices) = (solid.mesh(), solid.mesh().vertices().to_vec());
    let count = vertices.len();
    let center = (0..count).find(|&v| !mesh.is_on_surface(v)).unwrap();
    vertices.extend(mesh.vertices().iter().map(|vertex| vertex * 0.5));
    let mut tets = Vec::new();
    for triangle in mesh.surface_triangles() {
        let mut outer = *triangle;
        // Both prisms at a face are divided consistently, by the order of their vertices.
        outer.sort_unstable();
        let [a, b, c] = outer.map(|vertex| vertex + count);
        tets.push([center, a, b, c]);
        tets.push([a, b, c, outer[2]]);
        tets.push([a, b, outer[1], outer[2]]);
        tets.push([a, outer[0], outer[1], outer[2]]);
    }
    let (vertices, tets) = without_unused(&vertices, &tets);
    let mesh = TetMesh::new(vertices, tets).unwrap();
    let extent = |v: usize| match mesh.vertices()[v].norm() {
        0.0 => extents[0],
        _ if mesh.is_on_surface(v) => 0.0,
        _ => extents[1],
    };
    let extents = (0..mesh.vertex_count()).map(extent).collect();
    PressureField::new(mesh, extents).unwrap()
}

fn cells([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..nx).flat_map(move |i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k))))
}

fn without_unused(
    vertices: &[Vector3<f64>],
    tets: &[[usize; 4]],
) -> (Vec<Vector3<f64>>, Vec<[usize; 4]>) {
    let mut used: Vec<usize> = tets.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let new_index = |vertex: usize| used.binary_search(&vertex).unwrap();
    let kept = used.iter().map(|&vertex| vertices[vertex]).collect();
    (kept, tets.iter().map(|tet| tet.map(new_index)).collect())
}

/// Returns a random pair with a large overlap, at generic poses, with moduli within a factor of a hundred.
pub fn random_pair<'a>(shapes: &'a [Shape], random: &mut Random) -> ContactPair<'a> {
    let (a, b) = (random.below(shapes.len()), random.below(shapes.len()));
    let pose_wa = Pose::from_rotation_vector(&random.rotation_vector(), random.vector());
    let apart = random.direction() * random.between(0.3, 1.3);
    let position = pose_wa.translation() + apart;
    let pose_wb = Pose::from_rotation_vector(&random.rotation_vector(), position);
    let moduli = [random.between(0.0, 2.0), random.between(0.0, 2.0)].map(|x| 10_f64.powf(x));
    pair(
        (&shapes[a], pose_wa, moduli[0]),
        (&shapes[b], pose_wb, moduli[1]),
    )
}

/// Returns a pair of bodies (shape, pose, modulus).
pub fn pair<'a>(a: (&'a Shape, Pose, f64), b: (&'a Shape, Pose, f64)) -> ContactPair<'a> {
    ContactPair::new(
        ContactBody::new(a.0, a.1, a.2).unwrap(),
        ContactBody::new(b.0, b.1, b.2).unwrap(),
    )
}
