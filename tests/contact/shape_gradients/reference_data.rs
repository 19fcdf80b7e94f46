//! Against the numbers of an independent program (`tests/data/reference/partners.json`).

use crate::support::reference::{read, shape};
use hydroelastic::contact::{
    ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape, ShapeGradient,
};
use hydroelastic::mesh::TriangleSurface;
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Rotation3, SVector, UnitVector3, Vector3};
use serde::Deserialize;

/// The program's numbers are exact to 2e-13 of the largest entry; poses are printed with 17 digits.
const EXACT: f64 = 1e-11;

#[derive(Deserialize)]
struct File {
    shape: Vec<CompliantCase>,
    rigid: Vec<RigidCase>,
}

/// By each vertex, or what sums up those of a mesh with many.
#[derive(Deserialize)]
#[serde(untagged)]
enum ByVertices {
    All(Vec<[f64; 3]>),
    Some {
        norm: f64,
        sum: [f64; 3],
        rows: Vec<(usize, [f64; 3])>,
    },
}

/// Two compliant meshes.
#[derive(Deserialize)]
struct CompliantCase {
    name: String,
    #[serde(rename = "mesh_A")]
    mesh_a: String,
    #[serde(rename = "mesh_B")]
    mesh_b: String,
    #[serde(rename = "E_A")]
    modulus_a: f64,
    #[serde(rename = "E_B")]
    modulus_b: f64,
    #[serde(rename = "R_A")]
    rotation_a: [[f64; 3]; 3],
    #[serde(rename = "p_A")]
    position_a: [f64; 3],
    #[serde(rename = "R_B")]
    rotation_b: [[f64; 3]; 3],
    #[serde(rename = "p_B")]
    position_b: [f64; 3],
    covector: [f64; 6],
    #[serde(rename = "vertices_A")]
    by_vertices_a: ByVertices,
    #[serde(rename = "vertices_B")]
    by_vertices_b: ByVertices,
    #[serde(rename = "by_extent_A_inner")]
    by_extents_a: Vec<(usize, f64)>,
    #[serde(rename = "by_extent_B_inner")]
    by_extents_b: Vec<(usize, f64)>,
}

/// A compliant mesh against a rigid one, or a half-space.
#[derive(Deserialize)]
struct RigidCase {
    name: String,
    compliant_mesh: String,
    #[serde(rename = "E")]
    modulus: f64,
    #[serde(rename = "R")]
    rotation: [[f64; 3]; 3],
    p: [f64; 3],
    rigid_mesh: Option<String>,
    #[serde(rename = "rigid_R")]
    rigid_rotation: Option<[[f64; 3]; 3]>,
    rigid_p: Option<[f64; 3]>,
    normal: Option<[f64; 3]>,
    point: Option<[f64; 3]>,
    pressure_per_depth: Option<f64>,
    covector: [f64; 6],
    vertices_compliant: ByVertices,
    vertices_rigid: Option<ByVertices>,
}

fn pose(rows: &[[f64; 3]; 3], position: [f64; 3]) -> Pose {
    let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
    Pose::new(rotation, position.into()).unwrap()
}

/// The covector on the wrench on A.
fn by_wrenches(covector: &[f64; 6]) -> SVector<f64, 12> {
    SVector::from_fn(|i, _| if i < 6 { covector[i] } else { 0.0 })
}

/// The largest difference, relative to the largest entry.
fn error(found: &[Vector3<f64>], expected: &ByVertices) -> f64 {
    let largest = found.iter().map(Vector3::amax).fold(0.0, f64::max);
    assert!(largest > 0.0);
    let differs = |(vertex, expected): (usize, [f64; 3])| {
        (found[vertex] - Vector3::from(expected)).amax() / largest
    };
    match expected {
        ByVertices::All(rows) => {
            assert_eq!(rows.len(), found.len());
            let rows = rows.iter().copied().enumerate();
            rows.map(differs).fold(0.0, f64::max)
        }
        ByVertices::Some { norm, sum, rows } => {
            assert_eq!(rows.len(), 8);
            let squares: f64 = found.iter().map(Vector3::norm_squared).sum();
            let total: Vector3<f64> = found.iter().sum();
            let rows = rows.iter().copied().map(differs);
            rows.fold(0.0, f64::max)
                .max((squares.sqrt() - norm).abs() / norm)
                .max((total - Vector3::from(*sum)).amax() / norm)
        }
    }
}

fn extent_error(found: &[f64], expected: &[(usize, f64)]) -> f64 {
    let largest = expected.iter().map(|(_, by)| by.abs()).fold(0.0, f64::max);
    let differs = |&(vertex, by): &(usize, f64)| (found[vertex] - by).abs() / largest;
    expected.iter().map(differs).fold(0.0, f64::max)
}

#[test]
fn two_compliant_bodies() {
    let File { shape: cases, .. } = read("partners.json");
    assert_eq!(cases.len(), 6);
    for case in &cases {
        let (a, b) = (shape(&case.mesh_a), shape(&case.mesh_b));
        let pose_a = pose(&case.rotation_a, case.position_a);
        let pose_b = pose(&case.rotation_b, case.position_b);
        let pair = ContactPair::new(
            ContactBody::new(&a, pose_a, case.modulus_a).unwrap(),
            ContactBody::new(&b, pose_b, case.modulus_b).unwrap(),
        );
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

/// For each vertex of a mesh its place in the surface, of which the program counts all vertices of the mesh.
fn on_all_vertices(
    rigid: &RigidShape,
    mesh: &Shape,
    gradient: &ShapeGradient,
) -> Vec<Vector3<f64>> {
    let of_vertex = |vertex: &Vector3<f64>| {
        let mut vertices = rigid.surface().vertices().iter();
        let place = vertices.position(|other| other == vertex);
        place.map_or(Vector3::zeros(), |place| gradient.by_vertices[place])
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
    let File { rigid: cases, .. } = read("partners.json");
    assert_eq!(cases.len(), 10);
    let layer = HalfSpace::layer(1.0).unwrap();
    for case in &cases {
        let compliant = shape(&case.compliant_mesh);
        let pose_a = pose(&case.rotation, case.p);
        let body = ContactBody::new(&compliant, pose_a, case.modulus).unwrap();
        let mesh = case.rigid_mesh.as_deref().map(shape);
        let rigid = mesh
            .as_ref()
            .map(|mesh| RigidShape::new(TriangleSurface::around(mesh.field().mesh()).unwrap()));
        let half_space = || {
            let normal = UnitVector3::new_normalize(Vector3::from(case.normal.unwrap()));
            let turn = Rotation3::rotation_between(&Vector3::z_axis(), &normal).unwrap();
            Pose::new(*turn.matrix(), case.point.unwrap().into()).unwrap()
        };
        let partner = if let Some(rigid) = &rigid {
            let rotation = case.rigid_rotation.as_ref().unwrap();
            Partner::rigid(rigid, pose(rotation, case.rigid_p.unwrap()))
        } else if let Some(slope) = case.pressure_per_depth {
            Partner::half_space(&layer, half_space(), slope)
        } else {
            Partner::rigid_half_space(half_space())
        };
        let pair = ContactPair::new(body, partner.unwrap());
        let [by_a, by_b] = pair.shape_gradients(&by_wrenches(&case.covector));
        let mut worst = error(&by_a.by_vertices, &case.vertices_compliant);
        if let (Some(rigid), Some(mesh)) = (&rigid, &mesh) {
            let found = on_all_vertices(rigid, mesh, &by_b);
            worst = worst.max(error(&found, case.vertices_rigid.as_ref().unwrap()));
        } else {
            assert!(by_b.by_vertices.is_empty());
        }
        println!("{}: {worst:.1e}", case.name);
        assert!(worst <= EXACT, "{}: {worst:e}", case.name);
    }
}
