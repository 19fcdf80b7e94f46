//! Derivatives of distance fields with respect to the mesh: against differences, rigid motions and scaling, and at points without a
//! derivative.

use super::sample_meshes::{grid, l_shape, meshes, transformed};
use crate::moved_meshes::moved_mesh;
use hydroelastic::mesh::{
    LinearizedDistances, MeshError, PressureField, ShapeRates, TetMesh, shapes,
};
use nalgebra::{Vector3, vector};

/// Error of central differences with the best of three steps, for rates of order 1: the rounding error divided by the step, and the squared
/// step.
const DIFFERENCES: f64 = 1e-8;
const STEPS: [f64; 3] = [1e-4, 1e-5, 1e-6];

/// Rounding error of sums over a few dozen vertices, for numbers of order 1 or relative to their largest.
const SAME: f64 = 1e-13;

/// Step so short that curvature and tilt of faces are negligible. The error of rates is about ten steps, and round-off divided by the step.
const SHORT_STEP: f64 = 1e-8;
const FIRST_ORDER: f64 = 1e-6;

/// Returns pseudorandom numbers in [−1, 1].
fn scattered(number: usize) -> f64 {
    (1.0 + 7.3 * number as f64).sin()
}

fn velocities(count: usize) -> Vec<Vector3<f64>> {
    let velocity = |vertex: usize| Vector3::from_fn(|axis, _| scattered(3 * vertex + axis));
    (0..count).map(velocity).collect()
}

/// Returns meshes without symmetries. Every vertex of the samples is moved by about a twentieth of the shortest edge.
fn generic_meshes() -> Vec<(&'static str, TetMesh)> {
    let samples = meshes().into_iter();
    let samples = samples.map(|(name, mesh)| {
        let shortest = (0..mesh.tet_count())
            .flat_map(|tet| {
                let corners = mesh.tetrahedron(tet).corners;
                [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
                    .map(|(i, j)| (corners[i] - corners[j]).norm())
            })
            .fold(f64::INFINITY, f64::min);
        let mesh = moved_mesh(&mesh, &velocities(mesh.vertex_count()), 0.05 * shortest);
        (name, mesh)
    });
    samples.collect()
}

type Linearized = (PressureField, LinearizedDistances);

/// Returns the linearized field relative to the largest distance, and with skins of several depths, each with its depth.
fn linearized(mesh: &TetMesh) -> Vec<(Option<f64>, Linearized)> {
    let plain = PressureField::linearized_from_distance(mesh).unwrap();
    let deepest = 1.0 / plain.0.steepest();
    let skins = [0.237, 0.613].map(|share| share * deepest).map(|depth| {
        let skin = PressureField::linearized_from_distance_up_to(mesh, depth).unwrap();
        (Some(depth), skin)
    });
    std::iter::once((None, plain)).chain(skins).collect()
}

fn field(mesh: &TetMesh, depth: Option<f64>) -> PressureField {
    match depth {
        None => PressureField::from_distance(mesh),
        Some(depth) => PressureField::from_distance_up_to(mesh, depth),
    }
    .unwrap()
}

/// Returns the largest error of rates against a difference of two fields, relative to the largest rate.
fn error(rates: &ShapeRates, fields: &[PressureField; 2], step: f64) -> f64 {
    let [ahead, behind] = fields;
    assert_eq!(ahead.mesh().tets(), behind.mesh().tets());
    let pairs = ahead.mesh().vertices().iter().zip(behind.mesh().vertices());
    let vertices = pairs.zip(&rates.vertices);
    let vertices = vertices.map(|((a, b), rate)| ((a - b) / (2.0 * step) - rate).amax());
    let pairs = ahead.extents().iter().zip(behind.extents());
    let extents = pairs.zip(&rates.extents);
    let extents = extents.map(|((a, b), rate)| ((a - b) / (2.0 * step) - rate).abs());
    let largest = rates
        .extents
        .iter()
        .fold(1.0_f64, |most, rate| most.max(rate.abs()));
    let largest = rates
        .vertices
        .iter()
        .fold(largest, |most, rate| most.max(rate.amax()));
    vertices.chain(extents).fold(0.0, f64::max) / largest
}

#[test]
fn fields_change_as_differences_say() {
    let mut worst = 0.0_f64;
    for (name, mesh) in generic_meshes() {
        let velocities = velocities(2 * mesh.vertex_count()).split_off(mesh.vertex_count());
        for (depth, (made, distances)) in linearized(&mesh) {
            assert_eq!(made.extents(), field(&mesh, depth).extents());
            assert_eq!(
                made.mesh().vertices(),
                field(&mesh, depth).mesh().vertices()
            );
            // Two edge midpoints above the same triangle are equally far from it for every motion of the mesh. They may be the farthest
            // points.
            if depth.is_some() {
                assert_eq!(distances.ambiguous(), [0; 0], "{name} {depth:?}");
            }
            let rates = distances.rates(&velocities).unwrap();
            let errors = STEPS.map(|step| {
                let fields =
                    [step, -step].map(|time| field(&moved_mesh(&mesh, &velocities, time), depth));
                error(&rates, &fields, step)
            });
            let least = errors.into_iter().fold(f64::INFINITY, f64::min);
            worst = worst.max(least);
            assert!(least <= DIFFERENCES, "{name} {depth:?}: {errors:?}");
            if let Some(depth) = depth {
                let step = 1e-5 * depth;
                let fields = [step, -step].map(|change| field(&mesh, Some(depth + change)));
                let error = error(&distances.rates_by_depth(), &fields, step);
                assert!(error <= DIFFERENCES, "{name} {depth}: {error:e}");
            }
        }
    }
    println!("worst: {worst:.1e}");
}

#[test]
fn refined_fields_change_as_differences_say() {
    for (name, mesh) in generic_meshes() {
        let refined =
            |mesh: &TetMesh| PressureField::from_distance_within(mesh, 0.01, None).unwrap();
        let made = PressureField::linearized_from_distance_within(&mesh, 0.01, None);
        let (_, distances) = made.unwrap();
        let velocities = velocities(mesh.vertex_count());
        let rates = distances.rates(&velocities).unwrap();
        let fields =
            [SHORT_STEP, -SHORT_STEP].map(|step| refined(&moved_mesh(&mesh, &velocities, step)));
        let error = error(&rates, &fields, SHORT_STEP);
        assert!(error < 1e-6, "{name}: {error}");
    }
}

#[test]
fn the_pullback_is_the_transpose_of_the_rates() {
    for (name, mesh) in generic_meshes().into_iter().chain(meshes()) {
        for (depth, (made, distances)) in linearized(&mesh) {
            let count = made.extents().len();
            let by_vertices = velocities(count);
            let by_extents: Vec<f64> = (0..count).map(|index| scattered(index + 100_000)).collect();
            let gradient = distances.pullback(&by_vertices, &by_extents).unwrap();
            assert_eq!(gradient.by_vertices.len(), mesh.vertex_count());
            let product = |rates: &ShapeRates| {
                let vertices = by_vertices.iter().zip(&rates.vertices);
                let extents = by_extents.iter().zip(&rates.extents);
                let vertices = vertices.map(|(by, rate)| by.dot(rate));
                let parts = vertices.chain(extents.map(|(by, rate)| by * rate));
                parts.fold((0.0, 0.0), |(sum, size): (f64, f64), part| {
                    (sum + part, size + part.abs())
                })
            };
            let velocities = velocities(mesh.vertex_count());
            let (expected, size) = product(&distances.rates(&velocities).unwrap());
            let pairs = gradient.by_vertices.iter().zip(&velocities);
            let sum: f64 = pairs.map(|(by, velocity)| by.dot(velocity)).sum();
            assert!(
                (sum - expected).abs() <= SAME * size,
                "{name} {depth:?}: {sum} {expected}"
            );
            let (expected, size) = product(&distances.rates_by_depth());
            let error = (gradient.by_depth - expected).abs();
            assert!(error <= SAME * size, "{name} {depth:?}: {error:e}");
        }
    }
}

/// The meshes are symmetric and generic. The mean over equally near points moves as each of these points does.
#[test]
fn rigid_motions_change_no_extent_and_a_change_of_size_changes_distances() {
    let turn = |x: &Vector3<f64>| vector![0.3, -0.4, 0.2].cross(x) + vector![0.5, 0.1, -0.7];
    for (name, original) in generic_meshes().into_iter().chain(meshes()) {
        for scale in [1.0, 1e-6, 1e6] {
            let mesh = transformed(&original, |x| x * scale);
            for (depth, (made, distances)) in linearized(&mesh) {
                let vertices = made.mesh().vertices();
                let rates = |velocity: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
                    let velocities: Vec<_> = mesh.vertices().iter().map(velocity).collect();
                    distances.rates(&velocities).unwrap()
                };
                let rigid = rates(&|x| turn(&(x / scale)));
                let grown = rates(&|x| *x);
                let steep = made.steepest() * scale;
                for (vertex, x) in vertices.iter().enumerate() {
                    let error = (rigid.vertices[vertex] - turn(&(x / scale))).amax();
                    assert!(error <= SAME * steep, "{name} {depth:?}: {error:e}");
                    let error = rigid.extents[vertex].abs() * scale;
                    assert!(error <= SAME * steep, "{name} {depth:?}: {error:e}");
                }
                // If the field has a skin, its depth is scaled too.
                let by_depth = distances.rates_by_depth();
                let depth = depth.unwrap_or(0.0);
                for (vertex, x) in vertices.iter().enumerate() {
                    let velocity = grown.vertices[vertex] + by_depth.vertices[vertex] * depth;
                    let error = (velocity - x).amax() / scale;
                    assert!(error <= SAME * steep, "{name} {depth:?}: {error:e}");
                    let rate = grown.extents[vertex] + by_depth.extents[vertex] * depth;
                    assert!(rate.abs() <= SAME * steep, "{name} {depth:?}: {rate:e}");
                }
            }
        }
    }
}

/// The box is 1 × 1.5 × 2. The listed vertices have several nearest faces, or the largest distance of 1/2.
#[test]
fn the_medial_axis_of_a_box_is_told_and_two_faces_give_the_mean() {
    let (counts, spacing) = ([4, 6, 8], 0.25);
    let mesh = grid(counts, spacing, |_| true);
    let upper = Vector3::from(counts.map(|count| count as f64 * spacing));
    let (made, distances) = PressureField::linearized_from_distance(&mesh).unwrap();
    // Returns the number of nearest faces of an inner vertex.
    let near = |x: &Vector3<f64>| {
        let below = upper - x;
        let heights = x.iter().chain(&below).copied();
        let heights: Vec<f64> = heights.collect();
        let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
        if least <= 0.0 {
            return 0;
        }
        heights.iter().filter(|&&height| height <= least).count()
    };
    let vertices = made.mesh().vertices();
    let expected = (0..vertices.len()).filter(|&vertex| near(&vertices[vertex]) > 1);
    assert_eq!(distances.ambiguous(), expected.collect::<Vec<_>>());
    // With a skin, extents do not depend on the farthest vertices.
    let depth = 0.3;
    let (skin, distances) = PressureField::linearized_from_distance_up_to(&mesh, depth).unwrap();
    let velocities = velocities(mesh.vertex_count());
    let rates = distances.rates(&velocities).unwrap();
    let fields = [SHORT_STEP, -SHORT_STEP]
        .map(|time| field(&moved_mesh(&mesh, &velocities, time), Some(depth)));
    let (mut unique_count, mut ambiguous_count) = (0, 0);
    for (vertex, x) in skin
        .mesh()
        .vertices()
        .iter()
        .enumerate()
        .take(mesh.vertex_count())
    {
        let count = near(x);
        if count == 1 || count == 2 {
            let change = fields[0].extents()[vertex] - fields[1].extents()[vertex];
            let error = (change / (2.0 * SHORT_STEP) - rates.extents[vertex]).abs();
            assert!(error <= FIRST_ORDER, "{count} faces: {error:e}");
            (unique_count, ambiguous_count) = if count == 1 {
                (unique_count + 1, ambiguous_count)
            } else {
                (unique_count, ambiguous_count + 1)
            };
        }
    }
    assert!(
        unique_count > 20 && ambiguous_count > 20,
        "{unique_count} {ambiguous_count}"
    );
}

#[test]
fn ends_of_skins_and_inward_edges() {
    // Every second vertex of the grid is at the depth of the skin and counts as its boundary. A vertex deeper by 5e-4 of the depth would
    // count too.
    let mesh = grid([8, 8, 8], 0.125, |_| true);
    for depth in [0.25, 0.250_1] {
        let (skin, distances) =
            PressureField::linearized_from_distance_up_to(&mesh, depth).unwrap();
        let rates = distances.rates(mesh.vertices()).unwrap();
        for (vertex, x) in mesh.vertices().iter().enumerate() {
            let depth_of_vertex = x.min().min((Vector3::repeat(1.0) - x).min());
            if depth_of_vertex >= 0.25 {
                assert_eq!((skin.extents()[vertex], rates.extents[vertex]), (1.0, 0.0));
            }
            if (depth_of_vertex - 0.25).abs() < 1e-3 {
                assert!(distances.ambiguous().contains(&vertex));
            }
        }
    }
    // A concave edge is a single nearest point, although triangles on both sides of it are equally near.
    let mesh = l_shape(4);
    let (made, distances) = PressureField::linearized_from_distance(&mesh).unwrap();
    let vertex_at = |position: Vector3<f64>| {
        let mut vertices = made.mesh().vertices().iter();
        vertices
            .position(|x| (x - position).amax() < 1e-12)
            .unwrap()
    };
    // The edge is at x = y = 1.
    let by_edge = vertex_at(vector![0.75, 0.75, 1.0]);
    assert!(!distances.ambiguous().contains(&by_edge));
    assert!(
        distances
            .ambiguous()
            .contains(&vertex_at(vector![0.5, 0.5, 1.0]))
    );
}

#[test]
fn what_does_not_pair_up_is_refused() {
    let field = shapes::cuboid([1.0, 1.0, 1.0]).unwrap();
    let mesh = field.mesh();
    let (_, distances) = PressureField::linearized_from_distance(mesh).unwrap();
    let count = |name, found| MeshError::RateCount {
        name,
        found,
        expected: 9,
    };
    let zeros = [Vector3::zeros(); 9];
    let refused = distances.pullback(&zeros[1..], &[0.0; 9]);
    assert_eq!(refused.unwrap_err(), count("vertices", 8));
    let refused = distances.pullback(&zeros, &[0.0; 10]);
    assert_eq!(refused.unwrap_err(), count("extents", 10));
    assert_eq!(distances.rates(&[]).unwrap_err(), count("vertices", 0));
    let infinite = [Vector3::repeat(f64::INFINITY); 9];
    let refused = MeshError::NonFiniteRate {
        name: "vertices",
        index: 0,
        value: f64::INFINITY,
    };
    assert_eq!(distances.rates(&infinite).unwrap_err(), refused);
    let refused = PressureField::linearized_from_distance_up_to(mesh, -1.0);
    assert!(matches!(
        refused.err(),
        Some(MeshError::InvalidDimension { .. })
    ));
}
