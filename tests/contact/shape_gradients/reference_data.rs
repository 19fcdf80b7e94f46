//! Shape gradients against the numbers of an independent program (`tests/data/reference/partners.json`).

use crate::support::reference::{ByVertices, PartnerCases, by_wrenches, partner_cases};
use hydroelastic::contact::{RigidShape, Shape, ShapeGradient};
use nalgebra::Vector3;

/// Tolerance. The program's numbers are exact to 2e-13 of the largest entry, and poses are printed with 17 digits.
const EXACT: f64 = 1e-11;

/// Returns the largest difference, relative to the largest entry.
fn error(gradient: &[Vector3<f64>], expected: &ByVertices) -> f64 {
    let largest = gradient.iter().map(Vector3::amax).fold(0.0, f64::max);
    assert!(largest > 0.0);
    let differs = |(vertex, expected): (usize, [f64; 3])| {
        (gradient[vertex] - Vector3::from(expected)).amax() / largest
    };
    match expected {
        ByVertices::All(rows) => {
            assert_eq!(rows.len(), gradient.len());
            let rows = rows.iter().copied().enumerate();
            rows.map(differs).fold(0.0, f64::max)
        }
        ByVertices::Some { norm, sum, rows } => {
            assert_eq!(rows.len(), 8);
            let squares: f64 = gradient.iter().map(Vector3::norm_squared).sum();
            let total: Vector3<f64> = gradient.iter().sum();
            let rows = rows.iter().copied().map(differs);
            rows.fold(0.0, f64::max)
                .max((squares.sqrt() - norm).abs() / norm)
                .max((total - Vector3::from(*sum)).amax() / norm)
        }
    }
}

fn extent_error(extents: &[f64], expected: &[(usize, f64)]) -> f64 {
    let largest = expected.iter().map(|(_, by)| by.abs()).fold(0.0, f64::max);
    let differs = |&(vertex, by): &(usize, f64)| (extents[vertex] - by).abs() / largest;
    expected.iter().map(differs).fold(0.0, f64::max)
}

#[test]
fn two_compliant_bodies() {
    let PartnerCases {
        compliant: cases, ..
    } = partner_cases();
    assert_eq!(cases.len(), 6);
    for case in &cases {
        let shapes = case.posed.shapes();
        let pair = case.posed.pair(&shapes);
        let [by_a, by_b] = pair.shape_gradients(&by_wrenches(&case.covector));
        let errors = [
            error(&by_a.by_vertices, &case.by_vertices_a),
            error(&by_b.by_vertices, &case.by_vertices_b),
            extent_error(&by_a.by_extents, &case.by_extents_a),
            extent_error(&by_b.by_extents, &case.by_extents_b),
        ];
        println!("{}: {errors:?}", case.name);
        assert!(
            errors.iter().all(|&e| e <= EXACT),
            "{}: {errors:?}",
            case.name
        );
    }
}

/// Returns the derivatives with respect to a rigid surface for each vertex of its mesh, as in the program: 0 for inner vertices.
fn on_all_vertices(
    rigid: &RigidShape,
    mesh: &Shape,
    gradient: &ShapeGradient,
) -> Vec<Vector3<f64>> {
    let of_vertex = |vertex: &Vector3<f64>| {
        let mut vertices = rigid.surface().vertices().iter();
        let index = vertices.position(|candidate| candidate == vertex);
        index.map_or(Vector3::zeros(), |index| gradient.by_vertices[index])
    };
    mesh.field()
        .mesh()
        .vertices()
        .iter()
        .map(of_vertex)
        .collect()
}

#[test]
fn a_compliant_body_and_a_rigid_one_or_a_half_space() {
    let PartnerCases { rigid: cases, .. } = partner_cases();
    assert_eq!(cases.len(), 10);
    for case in &cases {
        let shapes = case.shapes();
        let pair = case.pair(&shapes);
        let [by_a, by_b] = pair.shape_gradients(&by_wrenches(&case.covector));
        let mut worst = error(&by_a.by_vertices, &case.vertices_compliant);
        if let Some((mesh, rigid)) = &shapes.rigid {
            let gradient = on_all_vertices(rigid, mesh, &by_b);
            worst = worst.max(error(&gradient, case.vertices_rigid.as_ref().unwrap()));
        } else {
            assert!(by_b.by_vertices.is_empty());
        }
        println!("{}: {worst:.1e}", case.name);
        assert!(worst <= EXACT, "{}: {worst:e}", case.name);
    }
}
