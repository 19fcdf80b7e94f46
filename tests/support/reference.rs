//! Wrenches and Jacobians of posed mesh pairs from independent programs (`tests/data/reference`).

use hydroelastic::contact::{ContactBody, ContactPair, Shape};
use hydroelastic::mesh::{PressureField, TetMesh};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
struct MeshFile {
    vertices: Vec<[f64; 3]>,
    tets: Vec<[usize; 4]>,
    unit_pressure: Vec<f64>,
}

/// A case of `wrenches.json`.
#[derive(Deserialize)]
pub struct WrenchCase {
    pub name: String,
    #[serde(rename = "mesh_A")]
    pub mesh_a: String,
    #[serde(rename = "mesh_B")]
    pub mesh_b: String,
    #[serde(rename = "E_A")]
    pub modulus_a: f64,
    #[serde(rename = "E_B")]
    pub modulus_b: f64,
    #[serde(rename = "R_A")]
    pub rotation_a: [[f64; 3]; 3],
    #[serde(rename = "p_A")]
    pub position_a: [f64; 3],
    #[serde(rename = "R_B")]
    pub rotation_b: [[f64; 3]; 3],
    #[serde(rename = "p_B")]
    pub position_b: [f64; 3],
    pub degenerate: bool,
    pub wrench: ReferenceWrench,
    pub jacobian: Option<Vec<Vec<f64>>>,
    #[serde(rename = "dforce_A_dE_A")]
    pub force_a_by_modulus_a: Option<[f64; 3]>,
    #[serde(rename = "dforce_A_dE_B")]
    pub force_a_by_modulus_b: Option<[f64; 3]>,
}

#[derive(Deserialize)]
pub struct ReferenceWrench {
    #[serde(rename = "force_A")]
    pub force_a: [f64; 3],
    #[serde(rename = "torque_A")]
    pub torque_a: Option<[f64; 3]>,
    #[serde(rename = "force_B")]
    pub force_b: [f64; 3],
    #[serde(rename = "torque_B")]
    pub torque_b: Option<[f64; 3]>,
    pub area: Option<f64>,
}

/// A case of `jacobians.json`.
#[derive(Deserialize)]
pub struct JacobianCase {
    #[serde(rename = "A")]
    pub mesh_a: String,
    #[serde(rename = "B")]
    pub mesh_b: String,
    #[serde(rename = "EA")]
    pub modulus_a: f64,
    #[serde(rename = "EB")]
    pub modulus_b: f64,
    #[serde(rename = "RA")]
    pub rotation_a: [[f64; 3]; 3],
    #[serde(rename = "pA")]
    pub position_a: [f64; 3],
    #[serde(rename = "RB")]
    pub rotation_b: [[f64; 3]; 3],
    #[serde(rename = "pB")]
    pub position_b: [f64; 3],
    #[serde(rename = "wrench_FA_TA_FB_TB")]
    pub wrench: [f64; 12],
    pub area: f64,
    #[serde(rename = "J_12x14")]
    pub jacobian: Vec<Vec<f64>>,
}

/// A scene of `trajectory.json`: a ball thrown on a fixed unit cube.
#[derive(Deserialize)]
pub struct Scene {
    pub mesh: String,
    pub scale: f64,
    pub mass: f64,
    pub unit_inertia: f64,
    #[serde(rename = "E_ball")]
    pub modulus_ball: f64,
    #[serde(rename = "E_box")]
    pub modulus_box: f64,
    pub rows: Vec<Row>,
}

/// A state: quaternion w x y z, position, spin, velocity.
#[derive(Deserialize)]
pub struct Row {
    pub t: f64,
    pub x: [f64; 13],
}

#[derive(Deserialize)]
struct Scenes {
    scenes: Vec<Scene>,
}

#[derive(Deserialize)]
struct Cases<C> {
    cases: Vec<C>,
}

fn path(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/reference")
        .join(file)
}

pub fn read<D: DeserializeOwned>(file: &str) -> D {
    let text = std::fs::read_to_string(path(file)).unwrap();
    serde_json::from_str(&text).unwrap()
}

pub fn wrench_cases() -> Vec<WrenchCase> {
    read::<Cases<WrenchCase>>("wrenches.json").cases
}

pub fn scenes() -> Vec<Scene> {
    read::<Scenes>("trajectory.json").scenes
}

pub fn jacobian_cases() -> Vec<JacobianCase> {
    read::<Cases<JacobianCase>>("jacobians.json").cases
}

pub fn shape(mesh: &str) -> Shape {
    scaled_shape(mesh, 1.0)
}

pub fn scaled_shape(mesh: &str, scale: f64) -> Shape {
    let file: MeshFile = read(&format!("meshes/{mesh}.json"));
    let scaled = |vertex| Vector3::from(vertex) * scale;
    let vertices = file.vertices.into_iter().map(scaled).collect();
    let mesh = TetMesh::new(vertices, file.tets).unwrap();
    Shape::new(PressureField::with_inert_tets(mesh, file.unit_pressure).unwrap())
}

fn pose(rotation: &[[f64; 3]; 3], position: [f64; 3]) -> Pose {
    let rotation = Matrix3::from_fn(|i, j| rotation[i][j]);
    Pose::new(rotation, Vector3::from(position)).unwrap()
}

impl WrenchCase {
    pub fn pair<'a>(&self, a: &'a Shape, b: &'a Shape) -> ContactPair<'a> {
        let pose_a = pose(&self.rotation_a, self.position_a);
        let pose_b = pose(&self.rotation_b, self.position_b);
        ContactPair::new(
            ContactBody::new(a, pose_a, self.modulus_a).unwrap(),
            ContactBody::new(b, pose_b, self.modulus_b).unwrap(),
        )
    }
}

impl JacobianCase {
    pub fn pair<'a>(&self, a: &'a Shape, b: &'a Shape) -> ContactPair<'a> {
        let pose_a = pose(&self.rotation_a, self.position_a);
        let pose_b = pose(&self.rotation_b, self.position_b);
        ContactPair::new(
            ContactBody::new(a, pose_a, self.modulus_a).unwrap(),
            ContactBody::new(b, pose_b, self.modulus_b).unwrap(),
        )
    }
}
