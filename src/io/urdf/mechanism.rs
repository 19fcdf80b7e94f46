//! Conversion of a robot to bodies connected by joints.

use super::{Collision, JointKind, JointOptions, Link, Robot, ShapeOptions, UrdfError};
use crate::dynamics::{self, Body, BodyShape, Mass, Material, Mechanism, WorldError};
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
    /// If a link has rotational inertia but no mass, the inertia is added to the link to which it is welded.
    ///
    /// # Errors
    /// - If a joint is floating or planar.
    /// - If a geometry cannot become a shape: see [`Collision::shape`].
    /// - If the mass properties or the material of a link are out of range.
    pub fn mechanism(&self, options: &RobotOptions) -> Result<Mechanism, UrdfError> {
        let inertias = self.inertias();
        let mut bodies = Vec::new();
        for (index, (link, inertia)) in self.links().iter().zip(inertias).enumerate() {
            let body = self.link_body((index, link), inertia, options)?;
            bodies.push(body);
            for (number, collision) in link.collisions.iter().enumerate().skip(1) {
                bodies.push(welded_body(link, (number, collision), options)?);
            }
        }
        let mechanism = Mechanism::new(bodies);
        Ok(if options.self_contact {
            mechanism.without_rigid_self_contact()
        } else {
            mechanism.without_self_contact()
        })
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
            let parent = self
                .links()
                .iter()
                .position(|link| link.name == joint.parent);
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

    fn link_body(
        &self,
        (index, link): (usize, &Link),
        inertia: MassProperties,
        options: &RobotOptions,
    ) -> Result<Body, UrdfError> {
        let name = format!("{}{}", options.prefix, link.name);
        let (shape, material) = match link.collisions.first() {
            Some(collision) => shape_of(link, collision, options)?,
            None => (BodyShape::None, Material::rigid()),
        };
        let in_world = |source| error(link, source);
        let dynamic = |shape| Body::dynamic(&name, shape, material, Mass::Link(inertia));
        let joint = match (index.checked_sub(1), &options.base) {
            (Some(above), _) => self.joints()[above].prefixed(&options.prefix, &options.joints)?,
            (None, Base::Joint(joint)) => (**joint).clone(),
            (None, Base::Fixed(pose)) => {
                let body = Body::fixed(&name, shape, material).map_err(in_world)?;
                return Ok(body.with_pose(*pose));
            }
            (None, Base::Free(pose)) => {
                return Ok(dynamic(shape).map_err(in_world)?.with_pose(*pose));
            }
        };
        let body = dynamic(shape).and_then(|body| body.with_joint(joint));
        body.map_err(in_world)
    }
}

/// Massless body of a collision geometry, welded to its link.
fn welded_body(
    link: &Link,
    (number, collision): (usize, &Collision),
    options: &RobotOptions,
) -> Result<Body, UrdfError> {
    let parent = format!("{}{}", options.prefix, link.name);
    let name = format!("{parent}/{}", number + 1);
    let (shape, material) = shape_of(link, collision, options)?;
    let joint = dynamics::Joint::fixed(&name).with_parent(&parent);
    Body::dynamic(&name, shape, material, Mass::Link(MassProperties::zero()))
        .and_then(|body| body.with_joint(joint))
        .map_err(|source| error(link, source))
}

/// Shape of a geometry in the frame of its link, and its material.
fn shape_of(
    link: &Link,
    collision: &Collision,
    options: &RobotOptions,
) -> Result<(BodyShape, Material), UrdfError> {
    let shape = collision.shape(&options.shapes)?;
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

fn error(link: &Link, source: WorldError) -> UrdfError {
    UrdfError::Body {
        at: link.at.clone(),
        source: Box::new(source),
    }
}
