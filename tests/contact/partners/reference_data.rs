//! Wrenches and Jacobians against the numbers of an independent program (`tests/data/reference/partners.json`).

use crate::support::reference::{read, shape};
use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape};
use hydroelastic::mesh::{FieldTet, TriangleSurface};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Matrix6, Rotation3, UnitVector3, Vector3, Vector6};
use serde::Deserialize;

/// The program's numbers are exact to 2e-14 of the largest entry; poses are printed with 17 digits.
const EXACT: f64 = 1e-11;

#[derive(Deserialize)]
struct File {
    rigid: Vec<Case>,
}

/// A compliant body against a rigid mesh, or a half-space. Wrenches on the compliant body, about its origin, torque first;
/// a half-space turns about `point`.
#[derive(Deserialize)]
struct Case {
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
    wrench_on_compliant: [f64; 6],
    area: f64,
    by_own_pose: [[f64; 6]; 6],
    by_other_pose: [[f64; 6]; 6],
    by_modulus: [f64; 6],
    by_pressure_per_depth: Option<[f64; 6]>,
}

fn pose(rows: &[[f64; 3]; 3], position: [f64; 3]) -> Pose {
    let rotation = Matrix3::from_fn(|i, j| rows[i][j]);
    Pose::new(rotation, position.into()).unwrap()
}

fn matrix(rows: &[[f64; 6]; 6]) -> Matrix6<f64> {
    Matrix6::from_fn(|i, j| rows[i][j])
}

impl Case {
    /// The pose of the half-space, if it is one.
    fn half_space(&self) -> Option<Pose> {
        let normal = UnitVector3::new_normalize(Vector3::from(self.normal?));
        let turn = Rotation3::rotation_between(&Vector3::z_axis(), &normal)?;
        Some(Pose::new(*turn.matrix(), self.point?.into()).unwrap())
    }
}

#[test]
fn wrenches_and_jacobians_equal_those_of_an_independent_program() {
    let File { rigid: cases } = read("partners.json");
    assert_eq!(cases.len(), 10);
    let mut worst = 0.0_f64;
    for case in &cases {
        let (a, layer) = (shape(&case.compliant_mesh), HalfSpace::layer(1.0).unwrap());
        let pose_a = pose(&case.rotation, case.p);
        let body = ContactBody::new(&a, pose_a, case.modulus).unwrap();
        let rigid = case.rigid_mesh.as_deref().map(|mesh| {
            RigidShape::new(TriangleSurface::around(shape(mesh).field().mesh()).unwrap())
        });
        let partner = if let Some(rigid) = &rigid {
            let rotation = case.rigid_rotation.as_ref().unwrap();
            Partner::rigid(rigid, pose(rotation, case.rigid_p.unwrap()))
        } else if let Some(slope) = case.pressure_per_depth {
            Partner::half_space(&layer, case.half_space().unwrap(), slope)
        } else {
            Partner::rigid_half_space(case.half_space().unwrap())
        };
        let pair = ContactPair::new(body, partner.unwrap());
        let (wrench, jacobian) = pair.wrench_and_jacobian();
        let mut compare = |what: &str, error: f64, largest: f64| {
            worst = worst.max(error / largest);
            assert!(error <= EXACT * largest, "{} {what}: {error:e}", case.name);
        };
        let expected = Vector6::from(case.wrench_on_compliant);
        let error = (wrench.on_a.to_vector() - expected).amax();
        compare("wrench", error, expected.amax());
        // The program counts what has no pressure as well.
        if !a.field().tets().iter().any(FieldTet::is_inert) {
            compare("area", (pair.surface().area() - case.area).abs(), case.area);
        }
        let on_a = &jacobian.on_a;
        for (what, found, expected) in [
            ("by own pose", on_a.by_pose_a, matrix(&case.by_own_pose)),
            ("by other pose", on_a.by_pose_b, matrix(&case.by_other_pose)),
        ] {
            compare(what, (found - expected).amax(), expected.amax());
        }
        let by_modulus = Vector6::from(case.by_modulus);
        compare(
            "modulus",
            (on_a.by_modulus_a - by_modulus).amax(),
            by_modulus.amax(),
        );
        if let Some(expected) = case.by_pressure_per_depth.map(Vector6::from) {
            compare(
                "slope",
                (on_a.by_modulus_b - expected).amax(),
                expected.amax(),
            );
        }
    }
    println!("worst: {worst:.1e}");
}
