//! Wrenches and Jacobians of posed mesh pairs from independent programs (`tests/data/reference`).

use hydroelastic::contact::{ContactBody, ContactPair, HalfSpace, Partner, RigidShape, Shape};
use hydroelastic::mesh::{PressureField, TetMesh, TriangleSurface};
use hydroelastic::spatial::Pose;
use nalgebra::{Matrix3, Rotation3, SVector, UnitVector3, Vector3};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
struct MeshFile {
    vertices: Vec<[f64; 3]>,
    tets: Vec<[usize; 4]>,
    unit_pressure: Vec<f64>,
}

/// Two compliant meshes, their moduli (Pa) and poses (m), with the names of any of the files.
#[derive(Deserialize)]
pub struct PosedMeshes {
    #[serde(rename = "mesh_A", alias = "A")]
    mesh_a: String,
    #[serde(rename = "mesh_B", alias = "B")]
    mesh_b: String,
    #[serde(rename = "E_A", alias = "EA")]
    pub modulus_a: f64,
    #[serde(rename = "E_B", alias = "EB")]
    pub modulus_b: f64,
    #[serde(rename = "R_A", alias = "RA")]
    rotation_a: [[f64; 3]; 3],
    #[serde(rename = "p_A", alias = "pA")]
    position_a: [f64; 3],
    #[serde(rename = "R_B", alias = "RB")]
    rotation_b: [[f64; 3]; 3],
    #[serde(rename = "p_B", alias = "pB")]
    position_b: [f64; 3],
}

/// A case of `wrenches.json`.
#[derive(Deserialize)]
pub struct WrenchCase {
    pub name: String,
    #[serde(flatten)]
    pub posed: PosedMeshes,
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
    #[serde(flatten)]
    pub posed: PosedMeshes,
    #[serde(rename = "wrench_FA_TA_FB_TB")]
    pub wrench: [f64; 12],
    pub area: f64,
    #[serde(rename = "J_12x14")]
    pub jacobian: Vec<Vec<f64>>,
}

/// The cases of `partners.json`.
#[derive(Deserialize)]
pub struct PartnerCases {
    /// Derivatives with respect to the shapes of two compliant meshes.
    #[serde(rename = "shape")]
    pub compliant: Vec<CompliantCase>,
    pub rigid: Vec<RigidCase>,
}

/// Derivatives with respect to each vertex, or sums of them for a mesh with many vertices.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum ByVertices {
    All(Vec<[f64; 3]>),
    Some {
        norm: f64,
        sum: [f64; 3],
        rows: Vec<(usize, [f64; 3])>,
    },
}

/// Derivatives of the covector times the wrench on A, with respect to the shapes of two compliant meshes.
#[derive(Deserialize)]
pub struct CompliantCase {
    pub name: String,
    #[serde(flatten)]
    pub posed: PosedMeshes,
    pub covector: [f64; 6],
    #[serde(rename = "vertices_A")]
    pub by_vertices_a: ByVertices,
    #[serde(rename = "vertices_B")]
    pub by_vertices_b: ByVertices,
    #[serde(rename = "by_extent_A_inner")]
    pub by_extents_a: Vec<(usize, f64)>,
    #[serde(rename = "by_extent_B_inner")]
    pub by_extents_b: Vec<(usize, f64)>,
}

/// A compliant mesh against a rigid mesh or a half-space. Wrenches are on the compliant body about its origin, torque first. A half-space
/// rotates about `point`.
#[derive(Deserialize)]
pub struct RigidCase {
    pub name: String,
    compliant_mesh: String,
    #[serde(rename = "E")]
    modulus: f64,
    #[serde(rename = "R")]
    rotation: [[f64; 3]; 3],
    #[serde(rename = "p")]
    position: [f64; 3],
    rigid_mesh: Option<String>,
    #[serde(rename = "rigid_R")]
    rigid_rotation: Option<[[f64; 3]; 3]>,
    #[serde(rename = "rigid_p")]
    rigid_position: Option<[f64; 3]>,
    normal: Option<[f64; 3]>,
    point: Option<[f64; 3]>,
    pressure_per_depth: Option<f64>,
    pub wrench_on_compliant: [f64; 6],
    pub area: f64,
    pub by_own_pose: [[f64; 6]; 6],
    pub by_other_pose: [[f64; 6]; 6],
    pub by_modulus: [f64; 6],
    pub by_pressure_per_depth: Option<[f64; 6]>,
    pub covector: [f64; 6],
    pub vertices_compliant: ByVertices,
    pub vertices_rigid: Option<ByVertices>,
}

/// The shapes of a [`RigidCase`].
pub struct RigidCaseShapes {
    pub compliant: Shape,
    /// The mesh of the rigid body and its surface, or `None` for a half-space.
    pub rigid: Option<(Shape, RigidShape)>,
    layer: HalfSpace,
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

/// A state: quaternion w x y z, position, angular velocity, velocity.
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

pub fn partner_cases() -> PartnerCases {
    read("partners.json")
}

/// Converts a covector on the wrench on A to a covector on both wrenches.
pub fn by_wrenches(covector: &[f64; 6]) -> SVector<f64, 12> {
    SVector::from_fn(|i, _| if i < 6 { covector[i] } else { 0.0 })
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

impl PosedMeshes {
    /// Returns the shapes of A and B.
    pub fn shapes(&self) -> [Shape; 2] {
        [shape(&self.mesh_a), shape(&self.mesh_b)]
    }

    /// Returns the pair of the two shapes of these meshes.
    pub fn pair<'a>(&self, [a, b]: &'a [Shape; 2]) -> ContactPair<'a> {
        let pose_a = pose(&self.rotation_a, self.position_a);
        let pose_b = pose(&self.rotation_b, self.position_b);
        ContactPair::new(
            ContactBody::new(a, pose_a, self.modulus_a).unwrap(),
            ContactBody::new(b, pose_b, self.modulus_b).unwrap(),
        )
    }
}

impl RigidCase {
    pub fn shapes(&self) -> RigidCaseShapes {
        let rigid = self.rigid_mesh.as_deref().map(|mesh| {
            let mesh = shape(mesh);
            let surface = TriangleSurface::around(mesh.field().mesh()).unwrap();
            (mesh, RigidShape::new(surface))
        });
        RigidCaseShapes {
            compliant: shape(&self.compliant_mesh),
            rigid,
            layer: HalfSpace::layer(1.0).unwrap(),
        }
    }

    /// Returns the pair of the case's own shapes, the compliant shape first.
    pub fn pair<'s>(&self, shapes: &'s RigidCaseShapes) -> ContactPair<'s> {
        let pose_a = pose(&self.rotation, self.position);
        let body = ContactBody::new(&shapes.compliant, pose_a, self.modulus).unwrap();
        let partner = if let Some((_, rigid)) = &shapes.rigid {
            let rotation = self.rigid_rotation.as_ref().unwrap();
            Partner::rigid(rigid, pose(rotation, self.rigid_position.unwrap()))
        } else if let Some(slope) = self.pressure_per_depth {
            Partner::half_space(&shapes.layer, self.half_space(), slope)
        } else {
            Partner::rigid_half_space(self.half_space())
        };
        ContactPair::new(body, partner.unwrap())
    }

    /// Returns the pose of the half-space.
    fn half_space(&self) -> Pose {
        let normal = UnitVector3::new_normalize(Vector3::from(self.normal.unwrap()));
        let turn = Rotation3::rotation_between(&Vector3::z_axis(), &normal).unwrap();
        Pose::new(*turn.matrix(), self.point.unwrap().into()).unwrap()
    }
}
