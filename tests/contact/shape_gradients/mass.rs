//! Derivatives of mass properties with respect to vertices.

use super::rigid_reshaped;
use crate::partners::Shapes;
use crate::support::moved_meshes::moved_mesh;
use crate::support::reference::shape;
use crate::support::scenes::Random;
use hydroelastic::spatial::{MassGradient, MassProperties};
use nalgebra::{Matrix3, Vector3};

const NONE: MassGradient = MassGradient {
    by_mass: 0.0,
    by_center_of_mass: Vector3::new(0.0, 0.0, 0.0),
    by_inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
};

const EXACT: f64 = 1e-15;

/// Error of central differences with a step of 1e-5 for numbers of order 1: rounding and curvature.
const DIFFERENCES: f64 = 1e-8;
const STEP: f64 = 1e-5;

/// Returns a symmetric matrix for one entry of the inertia.
fn entry(i: usize, j: usize) -> Matrix3<f64> {
    let mut matrix = Matrix3::zeros();
    matrix[(i, j)] += 0.5;
    matrix[(j, i)] += 0.5;
    matrix
}

#[test]
fn two_corners_of_a_cube() {
    let cube = shape("cube");
    let mesh = cube.field().mesh();
    let vertex = |x: [f64; 3]| {
        let mut vertices = mesh.vertices().iter();
        vertices
            .position(|v| (v - Vector3::from(x)).amax() < 1e-12)
            .unwrap()
    };
    let corners = [vertex([0.5, 0.5, 0.5]), vertex([0.5, 0.5, -0.5])];
    let expect = |gradient: MassGradient, expected: [[f64; 3]; 2]| {
        let by_vertices = mesh.mass_gradient(1.0, &gradient).unwrap();
        for (corner, expected) in corners.iter().zip(expected) {
            let error = (by_vertices[*corner] - Vector3::from(expected)).amax();
            assert!(error <= EXACT, "{error:e}");
        }
    };
    let by_mass = MassGradient {
        by_mass: 1.0,
        ..NONE
    };
    let third = 1.0 / 3.0;
    expect(by_mass, [[third; 3], [third / 2.0, third / 2.0, -third]]);
    let by_center_of_mass = MassGradient {
        by_center_of_mass: Vector3::x(),
        ..NONE
    };
    let (sixth, part) = (1.0 / 6.0, 1.0 / 24.0);
    expect(
        by_center_of_mass,
        [[sixth, part, part], [sixth / 2.0, part, -part]],
    );
    let xx = MassGradient {
        by_inertia: entry(0, 0),
        ..NONE
    };
    let most = 13.0 / 120.0;
    expect(xx, [[0.05, most, most], [1.0 / 30.0, 7.0 / 120.0, -most]]);
    let xy = MassGradient {
        by_inertia: entry(0, 1),
        ..NONE
    };
    let [across, along] = [-1.0 / 48.0, 1.0 / 120.0];
    expect(xy, [[across, across, -along], [across, across, along]]);
}

fn random_gradient(random: &mut Random) -> MassGradient {
    MassGradient {
        by_mass: random.between(-1.0, 1.0),
        by_center_of_mass: random.vector(),
        by_inertia: Matrix3::from_fn(|_, _| random.between(-1.0, 1.0)),
    }
}

fn value(gradient: &MassGradient, properties: &MassProperties) -> f64 {
    gradient.by_mass * properties.mass
        + gradient.by_center_of_mass.dot(&properties.center_of_mass)
        + gradient.by_inertia.dot(&properties.inertia)
}

/// Compares the derivative along velocities with a central difference.
fn check(by_vertices: &[Vector3<f64>], velocities: &[Vector3<f64>], value: impl Fn(f64) -> f64) {
    let pairs = by_vertices.iter().zip(velocities);
    let slope: f64 = pairs.map(|(by, velocity)| by.dot(velocity)).sum();
    let difference = (value(STEP) - value(-STEP)) / (2.0 * STEP);
    let error = (slope - difference).abs() / (1.0 + slope.abs());
    assert!(error <= DIFFERENCES, "{error:e}");
}

#[test]
fn meshes_and_surfaces_against_differences() {
    let (shapes, mut random) = (Shapes::mixed(), Random::new(77));
    for (compliant, rigid) in shapes.compliant.iter().zip(&shapes.rigid) {
        let (mesh, gradient) = (compliant.field().mesh(), random_gradient(&mut random));
        let mut velocities = |count: usize| (0..count).map(|_| random.vector()).collect::<Vec<_>>();
        let velocities_of_mesh = velocities(mesh.vertex_count());
        let moved = |time: f64| moved_mesh(mesh, &velocities_of_mesh, time);
        check(
            &mesh.mass_gradient(1.3, &gradient).unwrap(),
            &velocities_of_mesh,
            |time| value(&gradient, &moved(time).mass_properties(1.3).unwrap()),
        );
        let surface = rigid.surface();
        let velocities_of_surface = velocities(surface.vertices().len());
        check(
            &surface.mass_gradient(1.3, &gradient).unwrap(),
            &velocities_of_surface,
            |time| {
                let moves = velocities_of_surface.iter().map(|velocity| velocity * time);
                let moved = rigid_reshaped(rigid, &moves.collect::<Vec<_>>());
                value(&gradient, &moved.surface().mass_properties(1.3).unwrap())
            },
        );
    }
}

#[test]
fn inner_vertices_count_for_nothing() {
    let (shapes, mut random) = (Shapes::mixed(), Random::new(78));
    for shape in &shapes.compliant {
        let mesh = shape.field().mesh();
        let by_vertices = mesh
            .mass_gradient(1.3, &random_gradient(&mut random))
            .unwrap();
        let largest = by_vertices.iter().map(Vector3::amax).fold(0.0, f64::max);
        let inner = (0..mesh.vertex_count()).filter(|&vertex| !mesh.is_on_surface(vertex));
        for vertex in inner {
            assert!(by_vertices[vertex].amax() <= 1e-14 * largest);
        }
    }
}
