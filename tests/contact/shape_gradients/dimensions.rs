//! Derivatives of contact wrenches with respect to the dimensions of built-in shapes, and with respect to the meshes from which distance
//! fields were computed.

use crate::support::moved_meshes::{moved_mesh, moved_vertices};
use crate::support::scenes::Random;
use crate::support::worlds::{cuboid, icosphere};
use hydroelastic::contact::{ContactBody, ContactPair, Partner, RigidShape, Shape};
use hydroelastic::mesh::{MeshError, PressureField, ShapeRates, TetMesh, TriangleSurface, shapes};
use hydroelastic::spatial::Pose;
use nalgebra::{SVector, Vector3, vector};

/// Error of central differences with the best of three steps, relative to the larger of the derivative and the value divided by the
/// dimension. If one step straddles a change of a polygon's topology or suffers from rounding, another step does not.
const DIFFERENCES: f64 = 1e-7;
const STEPS: [f64; 3] = [1e-4, 1e-5, 1e-6];

/// Rounding error of sums over polygons and vertices.
const SAME: f64 = 1e-12;

/// A shape as a function of its dimensions, and its rates.
struct Family {
    dimensions: Vec<f64>,
    shape: fn(&[f64]) -> Result<PressureField, MeshError>,
    rates: fn(&[f64]) -> Result<Vec<ShapeRates>, MeshError>,
}

fn three(dimensions: &[f64]) -> [f64; 3] {
    dimensions.try_into().unwrap()
}

fn families(scale: f64) -> Vec<Family> {
    let family = |dimensions: &[f64], shape, rates| Family {
        dimensions: dimensions.iter().map(|it| it * scale).collect(),
        shape,
        rates,
    };
    vec![
        family(
            &[0.7],
            |it| shapes::icosphere(it[0], 2),
            |it| shapes::icosphere_rates(it[0], 2).map(|it| vec![it]),
        ),
        family(
            &[0.6, 0.8, 0.5],
            |it| shapes::ellipsoid(three(it), 1),
            |it| shapes::ellipsoid_rates(three(it), 1).map(Vec::from),
        ),
        family(
            &[1.0, 1.0, 1.0],
            |it| shapes::cuboid(three(it)),
            |it| shapes::cuboid_rates(three(it)).map(Vec::from),
        ),
        family(
            &[1.0, 0.7, 1.3],
            |it| shapes::distance_cuboid(three(it)),
            |it| shapes::distance_cuboid_rates(three(it)).map(Vec::from),
        ),
        family(
            &[0.5, 1.6],
            |it| shapes::cylinder(it[0], it[1], 7),
            |it| shapes::cylinder_rates(it[0], it[1], 7).map(Vec::from),
        ),
        family(
            &[0.8, 0.9],
            |it| shapes::cylinder(it[0], it[1], 8),
            |it| shapes::cylinder_rates(it[0], it[1], 8).map(Vec::from),
        ),
    ]
}

/// Returns weights for a scalar from both wrenches. A length scales forces relative to torques.
fn weights(random: &mut Random, length: f64) -> SVector<f64, 12> {
    SVector::from_fn(|row, _| random.between(-1.0, 1.0) * if row % 6 < 3 { 1.0 } else { length })
}

fn compare(found: f64, dimension: f64, value: impl Fn(f64) -> f64) -> f64 {
    let size = found.abs().max(value(0.0).abs() / dimension);
    let error = |step: f64| {
        let step = step * dimension;
        ((value(step) - value(-step)) / (2.0 * step) - found).abs() / size
    };
    STEPS.map(error).into_iter().fold(f64::INFINITY, f64::min)
}

fn wrenches(a: &Shape, b: &Shape, poses: &[Pose; 2]) -> SVector<f64, 12> {
    let b = ContactBody::new(b, poses[1], 3e5).unwrap();
    numbers(a, b, &poses[0])
}

fn numbers<'a>(a: &'a Shape, b: impl Into<Partner<'a>>, pose: &Pose) -> SVector<f64, 12> {
    let a = ContactBody::new(a, *pose, 1e5).unwrap();
    crate::support::moving::numbers(&ContactPair::new(a, b).wrench())
}

/// The test differentiates two overlapping bodies at random poses with respect to all their dimensions.
#[test]
fn wrenches_by_dimensions_equal_differences_at_every_scale() {
    let mut worst = 0.0_f64;
    for scale in [1.0, 1e-6, 1e6] {
        let (families, mut random) = (families(scale), Random::new(81));
        for _ in 0..40 {
            let [a, b] = [0, 1].map(|_| &families[random.below(families.len())]);
            let poses = [Vector3::zeros(), random.direction() * 0.8 * scale]
                .map(|at| Pose::from_rotation_vector(&random.rotation_vector(), at));
            let shapes = [a, b].map(|it| Shape::new((it.shape)(&it.dimensions).unwrap()));
            let weights = weights(&mut random, scale);
            let bodies = [0, 1].map(|body| {
                ContactBody::new(&shapes[body], poses[body], [1e5, 3e5][body]).unwrap()
            });
            let gradients = ContactPair::new(bodies[0], bodies[1]).shape_gradients(&weights);
            for (body, family) in [a, b].into_iter().enumerate() {
                let rates = (family.rates)(&family.dimensions).unwrap();
                for (place, rates) in rates.iter().enumerate() {
                    let value = |change: f64| {
                        let mut dimensions = family.dimensions.clone();
                        dimensions[place] += change;
                        let changed = Shape::new((family.shape)(&dimensions).unwrap());
                        let [a, b] =
                            [0, 1].map(|it| if it == body { &changed } else { &shapes[it] });
                        weights.dot(&wrenches(a, b, &poses))
                    };
                    let found = gradients[body].along(rates).unwrap();
                    let error = compare(found, family.dimensions[place], value);
                    worst = worst.max(error);
                    assert!(
                        error <= DIFFERENCES,
                        "{:?} {place}: {error:e}",
                        family.dimensions
                    );
                }
            }
        }
    }
    println!("worst: {worst:.1e}");
}

/// The test differentiates a rigid box in a ball with respect to its edges.
#[test]
fn a_rigid_box_by_its_edges() {
    let (edges, mut random) = ([0.3, 0.4, 0.5], Random::new(82));
    let ball = icosphere(0.5, 2);
    let rigid = |edges: [f64; 3]| {
        let field = shapes::cuboid(edges).unwrap();
        RigidShape::new(TriangleSurface::around(field.mesh()).unwrap())
    };
    let mesh = shapes::cuboid(edges).unwrap().mesh().clone();
    let original = rigid(edges);
    for _ in 0..10 {
        let turn = random.rotation_vector();
        let pose = Pose::from_rotation_vector(&turn, random.direction() * 0.6);
        let weights = weights(&mut random, 1.0);
        let pair = ContactPair::new(
            ContactBody::new(&ball, Pose::identity(), 1e5).unwrap(),
            Partner::rigid(&original, pose).unwrap(),
        );
        let [_, by_box] = pair.shape_gradients(&weights);
        for (axis, rates) in shapes::cuboid_rates(edges).unwrap().iter().enumerate() {
            let found = by_box.along(&rates.around(&mesh).unwrap()).unwrap();
            let value = |change: f64| {
                let mut edges = edges;
                edges[axis] += change;
                let changed = rigid(edges);
                let partner = Partner::rigid(&changed, pose).unwrap();
                weights.dot(&numbers(&ball, partner, &Pose::identity()))
            };
            let error = compare(found, edges[axis], value);
            assert!(error <= DIFFERENCES, "{axis}: {error:e}");
            // The vertex of the core is not a vertex of the surface.
            assert!(by_box.along(rates).is_err());
        }
    }
}

/// The test differentiates a cube, flush on a rigid plane, with respect to its edges: F = κ(a²x − 2ax² + 4x³/3) with κ = 2E/a at the depth
/// x, where a is the length of all edges. The plane is fixed, so the depth grows by half the growth of the upright edge.
#[test]
fn a_cube_flush_on_a_plane_by_its_size() {
    for a in [0.2, 0.2e-6, 0.2e6] {
        let (modulus, x) = (1e6, 0.05 * a);
        let cube = cuboid([a; 3]);
        let above = Pose::from_translation(vector![0.0, 0.0, a / 2.0 - x]);
        let pair = ContactPair::new(
            ContactBody::new(&cube, above, modulus).unwrap(),
            Partner::rigid_half_space(Pose::identity()).unwrap(),
        );
        let [by_cube, _] = pair.shape_gradients(&super::row(5));
        let parts = shapes::cuboid_rates([a; 3]).unwrap();
        let found: f64 = parts.iter().map(|it| by_cube.along(it).unwrap()).sum();
        // F/2E = ax − 2x² + 4x³/(3a): ∂/∂a is x − 4x³/(3a²), and ∂/∂x is a − 4x + 4x²/a.
        let by_a = 2.0 * modulus * (x - 4.0 * x.powi(3) / (3.0 * a * a));
        let by_x = 2.0 * modulus * (a - 4.0 * x + 4.0 * x * x / a);
        let expected = by_a + by_x / 2.0;
        assert!(
            (found - expected).abs() <= SAME * expected,
            "{found} {expected}"
        );
    }
}

/// The field is computed from the distances of a mesh without symmetries, and differentiated with respect to the vertices of that mesh.
#[test]
fn wrenches_by_the_mesh_below_a_field_of_distances_equal_differences() {
    let mut random = Random::new(83);
    let mesh = shapes::ellipsoid([0.5, 0.6, 0.4], 1)
        .unwrap()
        .mesh()
        .clone();
    let jitter: Vec<_> = mesh.vertices().iter().map(|_| random.vector()).collect();
    let mesh = moved_mesh(&mesh, &jitter, 0.02);
    let other = Shape::new(shapes::distance_cuboid([0.7, 0.8, 0.9]).unwrap());
    for depth in [None, Some(0.07)] {
        let field = |mesh: &TetMesh| match depth {
            None => PressureField::linearized_from_distance(mesh).unwrap(),
            Some(depth) => PressureField::linearized_from_distance_up_to(mesh, depth).unwrap(),
        };
        let (made, distances) = field(&mesh);
        assert!(distances.ambiguous().is_empty());
        let shape = Shape::new(made);
        for _ in 0..10 {
            let poses = [Vector3::zeros(), random.direction() * 0.75]
                .map(|at| Pose::from_rotation_vector(&random.rotation_vector(), at));
            let (velocities, weights) = (
                mesh.vertices()
                    .iter()
                    .map(|_| random.vector())
                    .collect::<Vec<_>>(),
                weights(&mut random, 1.0),
            );
            let pair = ContactPair::new(
                ContactBody::new(&shape, poses[0], 1e5).unwrap(),
                ContactBody::new(&other, poses[1], 3e5).unwrap(),
            );
            let [by_shape, _] = pair.shape_gradients(&weights);
            let by_mesh = distances.pullback(&by_shape.by_vertices, &by_shape.by_extents);
            let by_mesh = by_mesh.unwrap().by_vertices;
            let pairs = by_mesh.iter().zip(&velocities);
            let found = pairs.map(|(by, velocity)| by.dot(velocity)).sum();
            let value = |time: f64| {
                let shape = Shape::new(field(&moved_mesh(&mesh, &velocities, time)).0);
                weights.dot(&wrenches(&shape, &other, &poses))
            };
            let error = compare(found, 1.0, value);
            assert!(error <= DIFFERENCES, "{depth:?}: {error:e}");
        }
    }
}

/// The inner vertex of a star-shaped solid is its center of volume, which moves with the surface.
#[test]
fn the_center_of_a_star_shaped_solid_follows_its_surface() {
    let mut random = Random::new(84);
    let (vertices, triangles) = {
        let field = shapes::icosphere(0.5, 1).unwrap();
        let surface = TriangleSurface::around(field.mesh()).unwrap();
        let vertices = surface
            .vertices()
            .iter()
            .map(|x| x + random.vector() * 0.03);
        (vertices.collect::<Vec<_>>(), surface.triangles().to_vec())
    };
    let velocities: Vec<_> = vertices.iter().map(|_| random.vector()).collect();
    let shape = |time: f64| {
        let vertices = moved_vertices(&vertices, &velocities, time);
        let surface = TriangleSurface::new(vertices, triangles.clone()).unwrap();
        Shape::new(shapes::star_shaped(&surface).unwrap())
    };
    let (original, other) = (shape(0.0), cuboid([0.8; 3]));
    let poses = [Vector3::zeros(), vector![0.2, 0.3, 0.6]]
        .map(|at| Pose::from_rotation_vector(&random.rotation_vector(), at));
    let weights = weights(&mut random, 1.0);
    let pair = ContactPair::new(
        ContactBody::new(&original, poses[0], 1e5).unwrap(),
        ContactBody::new(&other, poses[1], 3e5).unwrap(),
    );
    let [by_shape, _] = pair.shape_gradients(&weights);
    let (by_surface, by_center) = by_shape.by_vertices.split_at(vertices.len());
    let through_center = hydroelastic::spatial::MassGradient {
        by_mass: 0.0,
        by_center_of_mass: by_center[0],
        by_inertia: nalgebra::Matrix3::zeros(),
    };
    let through_center = original
        .field()
        .mesh()
        .mass_gradient(1.0, &through_center)
        .unwrap();
    let parts = by_surface.iter().zip(through_center).zip(&velocities);
    let found = parts
        .map(|((by, through), velocity)| (by + through).dot(velocity))
        .sum();
    let error = compare(found, 1.0, |time| {
        weights.dot(&wrenches(&shape(time), &other, &poses))
    });
    assert!(error <= DIFFERENCES, "{error:e}");
}
