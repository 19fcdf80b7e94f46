//! Serde format of worlds.

use super::force::Control;
use super::inertia::PrincipalInertia;
use super::model::Model;
use super::{
    Body, BodyShape, BodyState, Force, Inertia, Joint, LoopJoint, Material, Motion, World,
    WorldError,
};
use crate::contact::{HalfSpace, RigidShape, Shape, ThicknessError};
use crate::mesh::{MeshError, PressureField, TetMesh, TriangleSurface};
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3, Vector6};
use serde::de::{Deserialize, Deserializer, Error as _};
use serde::ser::{Error as _, Serialize, Serializer};

/// Tolerance of the orthonormality of principal axes: rounding error of the eigenvalue solver, with a margin of about 1000.
const ORTHONORMAL: f64 = 1e-12;

/// Saved form of a world.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(rename = "World", deny_unknown_fields)]
struct WorldLayout<F> {
    gravity: [f64; 3],
    slip_tolerance: f64,
    /// Time of the initial state.
    start: f64,
    shapes: Vec<ShapeLayout>,
    bodies: Vec<BodyLayout>,
    ignored: Vec<[String; 2]>,
    #[serde(default)]
    loop_joints: Vec<LoopJoint>,
    controls: Vec<ControlLayout>,
    #[serde(default)]
    force_parameters: Vec<(String, f64)>,
    forces: F,
}

/// Saved form of a shape. Its trees are rebuilt.
#[derive(serde::Serialize, serde::Deserialize)]
enum ShapeLayout {
    Compliant(FieldLayout),
    Rigid(TriangleSurface),
    HalfSpace {
        /// Thickness of the soft layer (m), or `None` if the half-space is rigid.
        thickness: Option<f64>,
    },
    None,
}

/// Saved form of a mesh with its extents.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldLayout {
    vertices: Vec<[f64; 3]>,
    tets: Vec<[usize; 4]>,
    extents: Vec<f64>,
}

/// Saved form of a body. The shape is an index into the list of shapes. A body without inertia is fixed.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyLayout {
    name: String,
    shape: usize,
    material: Material,
    inertia: Option<InertiaLayout>,
    /// `None` for a body that is free or not dynamic.
    #[serde(default)]
    joint: Option<Joint>,
    initial: BodyState,
}

/// Saved form of an inertia: moments per mass, and axes as columns in the body frame.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct InertiaLayout {
    mass: f64,
    center_of_mass: [f64; 3],
    moments: [f64; 3],
    axes: [[f64; 3]; 3],
}

/// Saved form of a control.
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct ControlLayout {
    body: String,
    interval: f64,
    wrenches: Vec<[f64; 6]>,
}

/// Error of a loaded world.
#[derive(Debug, thiserror::Error)]
enum LoadError {
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("shape {shape}: {source}")]
    Shape { shape: usize, source: MeshError },
    #[error("shape {shape}: {source}")]
    Layer {
        shape: usize,
        source: ThicknessError,
    },
    #[error("body {body:?} has the shape {shape}, but there are {count} shapes")]
    NoShape {
        body: String,
        shape: usize,
        count: usize,
    },
    #[error(
        "the inertia of body {0:?} is invalid: moments must be finite, the smallest first, and axes orthonormal"
    )]
    Inertia(String),
}

impl<F: Serialize> Serialize for World<f64, F> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let model = &self.model;
        let (mut shapes, mut bodies) = (Vec::<&BodyShape>::new(), Vec::new());
        for body in &model.bodies {
            let shared = shapes.iter().position(|shape| shape.is_same(&body.shape));
            let shape = shared.unwrap_or_else(|| {
                shapes.push(&body.shape);
                shapes.len() - 1
            });
            let layout = BodyLayout::of(body, shape);
            bodies.push(layout.ok_or_else(|| {
                let name = &body.name;
                S::Error::custom(format!(
                    "body {name:?} follows a path, which is a function and cannot be saved"
                ))
            })?);
        }
        let name = |index: usize| model.bodies[index].name.clone();
        let ignored = model.ignored.iter();
        let layout = WorldLayout {
            gravity: model.gravity.into(),
            slip_tolerance: model.slip_tolerance,
            start: model.start,
            shapes: shapes.into_iter().map(ShapeLayout::of).collect(),
            bodies,
            ignored: ignored.map(|&(i, j)| [name(i), name(j)]).collect(),
            loop_joints: model
                .loop_joints
                .iter()
                .map(|existing| existing.joint.clone())
                .collect(),
            controls: model.controls.iter().map(ControlLayout::of).collect(),
            force_parameters: model.force_parameters.clone(),
            forces: &*self.forces,
        };
        layout.serialize(serializer)
    }
}

impl<'de, F: Force + Deserialize<'de>> Deserialize<'de> for World<f64, F> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let layout = WorldLayout::<F>::deserialize(deserializer)?;
        layout.world().map_err(D::Error::custom)
    }
}

impl<F: Force> WorldLayout<F> {
    fn world(self) -> Result<World<f64, F>, LoadError> {
        let mut shapes = Vec::new();
        for (shape, layout) in self.shapes.into_iter().enumerate() {
            shapes.push(layout.shape(shape)?);
        }
        let bodies: Result<_, _> = self
            .bodies
            .into_iter()
            .map(|layout| layout.body(&shapes))
            .collect();
        // `World::new` is not used, because it would orthonormalize the poses again.
        let mut world = World::without_forces(Model::starting_at(self.start, bodies?)?)
            .with_gravity(self.gravity.into())?
            .with_slip_tolerance(self.slip_tolerance)?;
        for [first, second] in &self.ignored {
            world = world.with_ignored(first, second)?;
        }
        for joint in &self.loop_joints {
            world.model.add_loop_joint(joint)?;
        }
        world.model.check_initial_loops()?;
        world.model.check_partners()?;
        for (name, value) in &self.force_parameters {
            world = world.with_force_parameter(name, *value)?;
        }
        let mut world = world.with_forces(self.forces)?;
        for control in self.controls {
            world = world.with_control(control.control()?)?;
        }
        Ok(world)
    }
}

impl ShapeLayout {
    fn of(shape: &BodyShape) -> Self {
        match shape {
            BodyShape::Compliant(shape) => Self::Compliant(FieldLayout::of(shape.field())),
            BodyShape::Rigid(shape) => Self::Rigid(shape.surface().clone()),
            BodyShape::HalfSpace(half_space) => Self::HalfSpace {
                thickness: half_space.thickness(),
            },
            BodyShape::None => Self::None,
        }
    }

    /// The shape. Errors name its index in the list.
    fn shape(self, shape: usize) -> Result<BodyShape, LoadError> {
        Ok(match self {
            Self::Compliant(layout) => {
                let field = layout.field();
                let field = field.map_err(|source| LoadError::Shape { shape, source })?;
                Shape::new(field).into()
            }
            Self::Rigid(surface) => RigidShape::new(surface).into(),
            Self::None => BodyShape::None,
            Self::HalfSpace { thickness: None } => HalfSpace::rigid().into(),
            Self::HalfSpace {
                thickness: Some(thickness),
            } => HalfSpace::layer(thickness)
                .map_err(|source| LoadError::Layer { shape, source })?
                .into(),
        })
    }
}

impl FieldLayout {
    fn of(field: &PressureField) -> Self {
        Self {
            vertices: field.mesh().vertices().iter().map(|&v| v.into()).collect(),
            tets: field.mesh().tets().to_vec(),
            extents: field.extents().to_vec(),
        }
    }

    fn field(self) -> Result<PressureField, MeshError> {
        let vertices = self.vertices.into_iter().map(Vector3::from).collect();
        PressureField::with_inert_tets(TetMesh::new(vertices, self.tets)?, self.extents)
    }
}

impl BodyLayout {
    /// Saved form of a body, or `None` for a kinematic body.
    fn of(body: &Body, shape: usize) -> Option<Self> {
        let inertia = match &body.motion {
            Motion::Dynamic { inertia, .. } => Some(InertiaLayout {
                mass: inertia.mass,
                center_of_mass: inertia.center_of_mass.into(),
                moments: inertia.principal.moments.into(),
                axes: inertia.principal.axes.into(),
            }),
            Motion::Fixed => None,
            Motion::Kinematic(_) => return None,
        };
        Some(Self {
            name: body.name.clone(),
            shape,
            material: body.material,
            inertia,
            joint: body.connecting_joint().cloned(),
            initial: body.initial,
        })
    }

    fn body(self, shapes: &[BodyShape]) -> Result<Body, LoadError> {
        let Some(shape) = shapes.get(self.shape) else {
            return Err(LoadError::NoShape {
                body: self.name,
                shape: self.shape,
                count: shapes.len(),
            });
        };
        let motion = match &self.inertia {
            Some(layout) => match layout.inertia() {
                Some(inertia) => Motion::Dynamic {
                    inertia,
                    joint: Box::new(self.joint.unwrap_or_else(Joint::free)),
                },
                None => return Err(LoadError::Inertia(self.name)),
            },
            None => Motion::Fixed,
        };
        let mut body = Body::new(&self.name, shape.clone(), self.material, motion)?;
        body.initial = self.initial;
        Ok(body)
    }
}

impl InertiaLayout {
    /// The inertia, if it is valid.
    fn inertia(&self) -> Option<Inertia> {
        let (moments, axes) = (Vector3::from(self.moments), Matrix3::from(self.axes));
        let principal = PrincipalInertia { moments, axes };
        let mut numbers = axes.iter().chain(&self.center_of_mass);
        let is_frame = (axes.tr_mul(&axes) - Matrix3::identity()).amax() <= ORTHONORMAL
            && axes.determinant() > 0.0;
        let is_valid = numbers.all(|x| x.is_finite()) && is_frame && principal.is_sorted();
        is_valid
            .then(|| Inertia::in_principal_axes(self.mass, self.center_of_mass.into(), principal))
    }
}

impl ControlLayout {
    fn of(control: &Control) -> Self {
        let wrenches = control.wrenches().iter();
        Self {
            body: control.body().to_owned(),
            interval: control.interval(),
            wrenches: wrenches.map(|wrench| wrench.to_vector().into()).collect(),
        }
    }

    fn control(self) -> Result<Control, WorldError> {
        let wrenches = self.wrenches.into_iter().map(Vector6::from);
        let wrenches = wrenches.map(|numbers| Wrench::from_vector(&numbers));
        Control::new(&self.body, self.interval, wrenches.collect())
    }
}
