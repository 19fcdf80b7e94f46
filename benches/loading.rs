//! Stages from a mesher's mesh to a body: CPU time and wall time on all threads.
//!
//! Helps to decide whether loading a fine mesh takes noticeable time, and in which stage. The meshes have about 20,000, 250,000 and 600,000
//! tetrahedra. One is a bent, L-shaped bracket. The other is a ball, a hard case for distances, because its center is equally far from its
//! whole surface. Run `cargo bench --bench loading`.

use cpu_time::ProcessTime;
use hydroelastic::contact::Shape;
use hydroelastic::mesh::{PressureField, TetMesh};
use nalgebra::{Vector3, vector};
use std::hint::black_box;
use std::time::Instant;

/// Numbers of cells along an edge of the bracket and of the ball.
const BRACKETS: [usize; 3] = [16, 38, 51];
const BALLS: [usize; 3] = [15, 35, 46];

/// The six orders of the axes in Kuhn's triangulation of a cell.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [0, 2, 1],
    [1, 0, 2],
    [1, 2, 0],
    [2, 0, 1],
    [2, 1, 0],
];

fn main() {
    println!("CPU s / wall s       tets      mesh   distance field     shape");
    for count in BRACKETS {
        let in_bracket = |[i, j, _]: [usize; 3]| 2 * i < count || 2 * j < count;
        measure("bracket", lattice(count, in_bracket, bent));
    }
    for count in BALLS {
        measure("ball", lattice(count, |_| true, rounded));
    }
}

fn measure(name: &str, (vertices, tets): (Vec<Vector3<f64>>, Vec<[usize; 4]>)) {
    let count = tets.len();
    let (mesh, of_mesh) = timed(|| TetMesh::new(vertices, tets).unwrap());
    let (field, of_field) = timed(|| PressureField::from_distance(&mesh).unwrap());
    let (shape, of_shape) = timed(|| Shape::new(field));
    black_box(shape);
    println!("{name:10} {count:14}   {of_mesh}   {of_field}   {of_shape}");
}

/// Returns the result of the work, with its CPU time and wall time as text.
fn timed<O>(work: impl FnOnce() -> O) -> (O, String) {
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let made = work();
    let seconds = [cpu.elapsed(), wall.elapsed()].map(|time| time.as_secs_f64());
    (made, format!("{:.3} / {:.3}", seconds[0], seconds[1]))
}

/// Creates a lattice on the cube [−1, 1]³ from the cells for which `keeps` is true, with six tetrahedra per cell, and maps its vertices.
fn lattice(
    count: usize,
    keeps: impl Fn([usize; 3]) -> bool,
    map: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> (Vec<Vector3<f64>>, Vec<[usize; 4]>) {
    let side = count + 1;
    let unpacked =
        |index: usize, side: usize| [index / side / side, index / side % side, index % side];
    let mut indices = vec![usize::MAX; side.pow(3)];
    let (mut vertices, mut tets) = (Vec::new(), Vec::new());
    let mut index_of = |at: [usize; 3]| {
        let index = &mut indices[(at[0] * side + at[1]) * side + at[2]];
        if *index == usize::MAX {
            *index = vertices.len();
            let position = Vector3::from(at.map(|i| 2.0 * i as f64 / count as f64 - 1.0));
            vertices.push(map(position));
        }
        *index
    };
    let cells = (0..count.pow(3)).map(|index| unpacked(index, count));
    for cell in cells.filter(|&cell| keeps(cell)) {
        for order in ORDERS {
            let mut at = cell;
            let mut corner = |axis: usize| {
                at[axis] += 1;
                index_of(at)
            };
            let others = order.map(&mut corner);
            tets.push([index_of(cell), others[0], others[1], others[2]]);
        }
    }
    (vertices, tets)
}

fn bent(at: Vector3<f64>) -> Vector3<f64> {
    let swing = 0.1 * vector![at.y * at.z, at.z * at.x, at.x * at.y];
    at + swing
}

/// Maps the cube to the ball: each cube about the center becomes a sphere.
fn rounded(at: Vector3<f64>) -> Vector3<f64> {
    at * (at.amax() / at.norm().max(f64::MIN_POSITIVE))
}
