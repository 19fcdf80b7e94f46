//! A soft block on the ground whose shape is variable at constant volume.

use hydroelastic::mesh::{MeshError, PressureField, TetMesh};
use hydroelastic::spatial::MassGradient;
use nalgebra::{Matrix3, Vector3};

/// Numbers of cells along each axis, and their edge (m).
const CELLS: [usize; 3] = [10, 10, 2];
const EDGE: f64 = 0.05;
/// Number of times that a gradient is averaged over neighbors.
const SMOOTHINGS: usize = 2;
/// Smallest fraction of its original volume that a tetrahedron may have.
const LEAST_VOLUME: f64 = 0.1;

/// A block of cells with six tetrahedra each. Its bottom is fixed.
#[derive(Clone)]
pub struct Cushion {
    mesh: TetMesh,
    extents: Vec<f64>,
    is_free: Vec<bool>,
    /// Volumes (m³) of the tetrahedra of the flat block, and of the whole block.
    volumes: Vec<f64>,
    volume: f64,
}

impl Cushion {
    /// Creates a flat block whose bottom is in the plane z = 0.
    pub fn flat() -> Result<Self, MeshError> {
        let field = PressureField::from_distance(&grid()?)?;
        let mesh = field.mesh().clone();
        Ok(Self {
            extents: field.extents().to_vec(),
            is_free: mesh.vertices().iter().map(|x| x.z > 0.5 * EDGE).collect(),
            volumes: volumes(&mesh),
            volume: mesh.volume(),
            mesh,
        })
    }

    /// Returns the pressure field. Each vertex keeps its extent.
    pub fn field(&self) -> Result<PressureField, MeshError> {
        PressureField::new(self.mesh.clone(), self.extents.clone())
    }

    /// Returns the number of variable coordinates.
    pub fn free_count(&self) -> usize {
        3 * self.is_free.iter().filter(|&&is_free| is_free).count()
    }

    pub fn volume(&self) -> f64 {
        self.mesh.volume()
    }

    /// Returns the smallest volume of a tetrahedron as a fraction of its volume in `flat`.
    pub fn thinnest(&self, flat: &Self) -> f64 {
        let ratios = volumes(&self.mesh).into_iter().zip(&flat.volumes);
        ratios
            .map(|(now, then)| now / then)
            .fold(f64::INFINITY, f64::min)
    }

    /// Returns the positions (x, z) of the vertices on top of the flat block, in the row nearest to a y.
    pub fn top_near(&self, y: f64, flat: &Self) -> Vec<(f64, f64)> {
        let [height, half] = [CELLS[2] as f64 * EDGE, 0.5 * EDGE];
        let pairs = self.mesh.vertices().iter().zip(flat.mesh.vertices());
        let row = pairs.filter(|(_, x)| x.z > height - 0.1 * EDGE && (x.y - y).abs() < half);
        let on_grid = row.filter(|(_, x)| ((x.x / EDGE).round() * EDGE - x.x).abs() < 0.1 * EDGE);
        let mut places: Vec<_> = on_grid.map(|(now, _)| (now.x, now.z)).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places
    }

    /// Returns a change of the vertices along a smoothed gradient: the mean over neighbors, projected to constant volume and scaled so that
    /// the largest change is 1 m.
    pub fn smoothed(&self, by_vertices: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut direction = by_vertices.to_vec();
        for _ in 0..SMOOTHINGS {
            self.hold(&mut direction);
            direction = self.averaged(&direction);
        }
        self.hold(&mut direction);
        let by_volume = self.by_volume();
        let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
        };
        let along = dot(&direction, &by_volume) / dot(&by_volume, &by_volume);
        for (change, by_vertex) in direction.iter_mut().zip(&by_volume) {
            *change -= by_vertex * along;
        }
        let largest = direction.iter().map(Vector3::norm).fold(0.0, f64::max);
        direction.iter().map(|change| change / largest).collect()
    }

    /// Returns the block moved by a distance along a direction, with its volume restored. Returns `None` if a tetrahedron becomes too thin.
    pub fn moved(&self, direction: &[Vector3<f64>], distance: f64) -> Option<Self> {
        let pairs = self.mesh.vertices().iter().zip(direction);
        let mut next = self.with_vertices(pairs.map(|(x, by)| x + by * distance).collect())?;
        // Newton's method on the volume.
        for _ in 0..4 {
            let by_volume = next.by_volume();
            let squared: f64 = by_volume.iter().map(Vector3::norm_squared).sum();
            let share = (self.volume - next.volume()) / squared;
            let pairs = next.mesh.vertices().iter().zip(&by_volume);
            next = next.with_vertices(pairs.map(|(x, by)| x + by * share).collect())?;
        }
        Some(next)
    }

    fn with_vertices(&self, vertices: Vec<Vector3<f64>>) -> Option<Self> {
        let tets = self.mesh.tets();
        let volume = |tet: &[usize; 4]| {
            let [o, a, b, c] = tet.map(|vertex| vertices[vertex]);
            (a - o).dot(&(b - o).cross(&(c - o))) / 6.0
        };
        let mut volumes = tets.iter().map(volume).zip(&self.volumes);
        if volumes.any(|(now, then)| now < LEAST_VOLUME * then) {
            return None;
        }
        let mesh = TetMesh::new(vertices, tets.to_vec()).ok()?;
        Some(Self {
            mesh,
            ..self.clone()
        })
    }

    /// Returns the derivative of the volume with respect to the variable vertices.
    fn by_volume(&self) -> Vec<Vector3<f64>> {
        let volume = MassGradient {
            by_mass: 1.0,
            by_center_of_mass: Vector3::zeros(),
            by_inertia: Matrix3::zeros(),
        };
        // A density of 1 kg/m³ is valid for every mesh.
        let by_volume = self.mesh.mass_gradient(1.0, &volume);
        let mut by_volume = by_volume.unwrap_or_default();
        self.hold(&mut by_volume);
        by_volume
    }

    fn hold(&self, change: &mut [Vector3<f64>]) {
        for (change, is_free) in change.iter_mut().zip(&self.is_free) {
            if !is_free {
                *change = Vector3::zeros();
            }
        }
    }

    fn averaged(&self, values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut sums: Vec<(Vector3<f64>, f64)> = values.iter().map(|value| (*value, 1.0)).collect();
        for tet in self.mesh.tets() {
            let mean = tet
                .iter()
                .map(|&vertex| values[vertex])
                .sum::<Vector3<f64>>()
                / 4.0;
            for &vertex in tet {
                sums[vertex].0 += mean;
                sums[vertex].1 += 1.0;
            }
        }
        sums.into_iter().map(|(sum, count)| sum / count).collect()
    }
}

fn volumes(mesh: &TetMesh) -> Vec<f64> {
    let tets = 0..mesh.tet_count();
    tets.map(|tet| mesh.tetrahedron(tet).signed_volume())
        .collect()
}

/// Returns a grid of cells with six tetrahedra each, one for each order of the three axes.
fn grid() -> Result<TetMesh, MeshError> {
    let [nx, ny, nz] = CELLS;
    let place = |[i, j, k]: [usize; 3]| (i * (ny + 1) + j) * (nz + 1) + k;
    let mut vertices = Vec::new();
    for (i, j, k) in triples([nx + 1, ny + 1, nz + 1]) {
        let [x, y] = [(i, nx), (j, ny)].map(|(at, count)| at as f64 - 0.5 * count as f64);
        vertices.push(Vector3::new(x, y, k as f64) * EDGE);
    }
    let mut tets = Vec::new();
    for (i, j, k) in triples(CELLS) {
        for [first, second] in [[0, 1], [0, 2], [1, 0], [1, 2], [2, 0], [2, 1]] {
            let (mut at, mut tet) = ([i, j, k], [place([i, j, k]); 4]);
            for (corner, axis) in (1..).zip([first, second, 3 - first - second]) {
                at[axis] += 1;
                tet[corner] = place(at);
            }
            tets.push(tet);
        }
    }
    TetMesh::new(vertices, tets)
}

fn triples([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..nx).flat_map(move |i| (0..ny).flat_map(move |j| (0..nz).map(move |k| (i, j, k))))
}
