//! Conversion of a robot to bodies connected by joints.

use super::{
    Collision, Joint, JointKind, JointOptions, Link, Robot, ShapeOptions, UrdfError, UrdfWarning,
};
use crate::dynamics::{self, Body, BodyShape, Mass, Material, Mechanism};
use crate::spatial::{MassProperties, Pose};
use std::collections::BTreeMap;

/// Options of [`Robot::mechanism`].
#[derive(Debug, Clone)]
pub struct RobotOptions {
    /// Prefix of all names, empty by default. Robots in one world need different prefixes.
    pub prefix: String,
    /// Connection of the root link. The default is [`Base::Fixed`] at the origin.
    pub base: Base,
    /// Material of the collision geometries. The modulus and the dissipation have no effect on rigid shapes.
    pub material: Material,
    /// Materials of single links, by the name of the link in the file. They replace [`Self::material`].
    pub materials: BTreeMap<String, Material>,
    /// Options of the shapes.
    pub shapes: ShapeOptions,
    /// Options of the joints.
    pub joints: JointOptions,
    /// Whether links of the robot can touch each other, false by default. Links that a joint connects never touch each other.
    pub self_contact: bool,
}

/// Connection of the root link of a robot.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Base {
    /// The root link is fixed at a pose in the world.
    Fixed(Pose),
    /// The root link is free. It starts at a pose in the world, at rest.
    Free(Pose),
    /// A joint connects the root link to a body of the world or to the world.
    Joint(Box<dynamics::Joint>),
}

impl RobotOptions {
    /// Default options with this material for all collision geometries.
    #[must_use]
    pub fn new(material: Material) -> Self {
        Self {
            prefix: String::new(),
            base: Base::Fixed(Pose::identity()),
            material,
            materials: BTreeMap::new(),
            shapes: ShapeOptions::default(),
            joints: JointOptions::default(),
            self_contact: false,
        }
    }
}

impl Robot {
    /// Bodies of the links, connected by their joints. Each body has the name and the frame of its link.
    ///
    /// The first collision geometry of a link is the shape of its body. Each further geometry is the shape of a massless body that is
    /// welded to the body of the link. The names of massless bodies are the name of the link followed by `/2`, `/3` and so on. A link
    /// without collision geometries becomes a body without a shape.
    ///
    /// [`Mechanism::warnings`] reports changes and properties of the surfaces of meshes that may be mistakes, with their places in the file.
    ///
    /// If a link has rotational inertia but no mass, the inertia is added to the link to which it is welded.
    ///
    /// # Errors
    /// - If a joint is floating or planar.
    /// - If a geometry cannot become a shape: see [`Collision::shape`].
    /// - If the mass properties or the material of a link, or a number of a joint, are out of range.
    pub fn mechanism(&self, options: &RobotOptions) -> Result<Mechanism, UrdfError> {
        self.check_materials(options)?;
        let poses = self.fixed_poses(&options.base);
        let (mut bodies, mut warnings) = (Vec::new(), Vec::new());
        for (index, (link, inertia)) in self.links().iter().zip(self.inertias()).enumerate() {
            let converter = LinkBodies {
                link,
                name: format!("{}{}", options.prefix, link.name),
                pose: poses[index],
                options,
            };
            let joint = self.joint_of(index, options)?;
            bodies.push(converter.first(inertia, joint, &mut warnings)?);
            for number in 1..link.collisions.len() {
                bodies.extend(converter.further(number, &mut warnings)?);
            }
        }
        let warnings = warnings.iter().map(ToString::to_string).collect();
        let mechanism = Mechanism::new(bodies).with_warnings(warnings);
        Ok(if options.self_contact {
            mechanism.without_rigid_self_contact()
        } else {
            mechanism.without_self_contact()
        })
    }

    /// Checks that the materials of single links are those of links of the robot.
    fn check_materials(&self, options: &RobotOptions) -> Result<(), UrdfError> {
        let names = self.links().iter().map(|link| &link.name);
        let mut materials = options.materials.keys();
        match materials.find(|name| !names.clone().any(|known| known == *name)) {
            None => Ok(()),
            Some(name) => Err(UrdfError::UnknownMaterialLink {
                name: name.clone(),
                known: names.cloned().collect(),
            }),
        }
    }

    /// Poses in the world of the links that are welded to a fixed base.
    fn fixed_poses(&self, base: &Base) -> Vec<Option<Pose>> {
        let root = match base {
            Base::Fixed(pose) => Some(*pose),
            Base::Free(_) | Base::Joint(_) => None,
        };
        let mut poses = vec![root];
        for joint in self.joints() {
            let parent = self
                .index_of(&joint.parent)
                .and_then(|parent| poses[parent]);
            let is_fixed = joint.kind == JointKind::Fixed;
            poses.push(parent.filter(|_| is_fixed).map(|pose| pose * joint.origin));
        }
        poses
    }

    /// Index of the link with this name.
    fn index_of(&self, link: &str) -> Option<usize> {
        self.links().iter().position(|known| known.name == link)
    }

    /// Joint above a link, or the joint of the base. `None` for the root of a fixed or free robot.
    fn joint_of(
        &self,
        link: usize,
        options: &RobotOptions,
    ) -> Result<Option<dynamics::Joint>, UrdfError> {
        let Some(above) = link.checked_sub(1) else {
            return Ok(match &options.base {
                Base::Joint(joint) => Some((**joint).clone()),
                Base::Fixed(_) | Base::Free(_) => None,
            });
        };
        let mut joint = self.joints()[above].clone();
        let is_scalar = |joint: &Joint| joint.kind.is_scalar();
        let has_leader = joint.mimic.as_ref().is_some_and(|mimic| {
            let mut joints = self.joints().iter();
            joints.any(|leader| leader.name == mimic.joint && is_scalar(leader))
        });
        // The reader has warned about a leader that does not exist.
        if !has_leader || !is_scalar(&joint) {
            joint.mimic = None;
        }
        joint.prefixed(&options.prefix, &options.joints).map(Some)
    }

    /// Mass properties of the links. Rotational inertia of a massless link is moved to the link to which it is welded.
    fn inertias(&self) -> Vec<MassProperties> {
        let links = self.links().iter();
        let mut inertias: Vec<MassProperties> = links
            .map(|link| link.inertial.unwrap_or_else(MassProperties::zero))
            .collect();
        // Children come after parents.
        for child in (1..inertias.len()).rev() {
            let joint = &self.joints()[child - 1];
            let MassProperties { mass, inertia, .. } = inertias[child];
            let parent = self.index_of(&joint.parent);
            if let (JointKind::Fixed, Some(parent)) = (joint.kind, parent)
                && mass == 0.0
            {
                let rotation = joint.origin.rotation();
                inertias[parent].inertia += rotation * inertia * rotation.transpose();
                inertias[child] = MassProperties::zero();
            }
        }
        inertias
    }
}

/// Bodies of a link: its own, and those of its further geometries.
struct LinkBodies<'a> {
    link: &'a Link,
    name: String,
    /// Pose of a link that is welded to a fixed base.
    pose: Option<Pose>,
    options: &'a RobotOptions,
}

impl LinkBodies<'_> {
    /// Body of the link, with its first geometry.
    fn first(
        &self,
        inertia: MassProperties,
        joint: Option<dynamics::Joint>,
        warnings: &mut Vec<UrdfWarning>,
    ) -> Result<Body, UrdfError> {
        let (shape, material) = match self.link.collisions.first() {
            Some(collision) => shape_of(self.link, collision, self.options, warnings)?,
            None => (BodyShape::None, Material::rigid()),
        };
        self.body((&self.name, shape, material), inertia, joint)
    }

    /// Body of a further geometry, or `None` if the geometry has no shape.
    fn further(
        &self,
        number: usize,
        warnings: &mut Vec<UrdfWarning>,
    ) -> Result<Option<Body>, UrdfError> {
        let collision = &self.link.collisions[number];
        let (shape, material) = shape_of(self.link, collision, self.options, warnings)?;
        if let BodyShape::None = shape {
            return Ok(None);
        }
        let name = format!("{}/{}", self.name, number + 1);
        let weld = dynamics::Joint::fixed(&name).with_parent(&self.name);
        let body = self.body((&name, shape, material), MassProperties::zero(), Some(weld));
        body.map(Some)
    }

    fn body(
        &self,
        (name, shape, material): (&str, BodyShape, Material),
        inertia: MassProperties,
        joint: Option<dynamics::Joint>,
    ) -> Result<Body, UrdfError> {
        let body = match (self.pose, joint, &self.options.base) {
            (Some(pose), ..) => Body::fixed(name, shape, material).map(|body| body.with_pose(pose)),
            (None, joint, base) => Body::dynamic(name, shape, material, Mass::Link(inertia))
                .and_then(|body| match (joint, base) {
                    (Some(joint), _) => {
                        joint.check()?;
                        body.with_joint(joint)
                    }
                    (None, Base::Free(pose)) => Ok(body.with_pose(*pose)),
                    (None, Base::Fixed(_) | Base::Joint(_)) => Ok(body),
                }),
        };
        body.map_err(|source| UrdfError::Body {
            at: self.link.at.clone(),
            source: Box::new(source),
        })
    }
}

/// Shape of a geometry in the frame of its link, and its material.
fn shape_of(
    link: &Link,
    collision: &Collision,
    options: &RobotOptions,
    warnings: &mut Vec<UrdfWarning>,
) -> Result<(BodyShape, Material), UrdfError> {
    let (shape, found) = collision.shape(&options.shapes)?;
    warnings.extend(found);
    let material = options.materials.get(&link.name);
    let material = *material.unwrap_or(&options.material);
    let modulus = material.modulus.filter(|_| !shape.is_rigid());
    Ok((
        shape,
        Material {
            modulus,
            ..material
        },
    ))
}
