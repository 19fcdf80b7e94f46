use super::{Body, Joint, WorldBuilder, WorldError};

/// Bodies connected by joints, such as a robot, and the pairs of bodies without contact.
///
/// [`WorldBuilder::mechanism`] adds a mechanism to a world.
#[derive(Debug, Clone)]
pub struct Mechanism {
    bodies: Vec<Body>,
    ignored: Vec<[String; 2]>,
    warnings: Vec<String>,
}

impl Mechanism {
    /// Creates a mechanism from bodies, parents before children. All pairs can have a contact.
    #[must_use]
    pub fn new(bodies: Vec<Body>) -> Self {
        Self {
            bodies,
            ignored: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Adds warnings about the input that the bodies were made of.
    #[must_use]
    pub fn with_warnings(mut self, warnings: Vec<String>) -> Self {
        self.warnings.extend(warnings);
        self
    }

    /// Warnings about the input that the bodies were made of, such as a surface that was replaced by its convex hull.
    #[must_use]
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Adds a body, for example a tool that a joint connects to the mechanism.
    #[must_use]
    pub fn with_body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Bodies, parents before children.
    #[must_use]
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Joints that are not free, in the order of their bodies.
    pub fn joints(&self) -> impl Iterator<Item = &Joint> {
        self.bodies.iter().filter_map(Body::connecting_joint)
    }

    /// Names of the pairs of bodies that pass through each other without contact.
    #[must_use]
    pub fn ignored(&self) -> &[[String; 2]] {
        &self.ignored
    }

    /// Ignores contacts between all bodies that the mechanism has now.
    #[must_use]
    pub fn without_self_contact(self) -> Self {
        self.ignoring(|_, _| true)
    }

    /// Ignores pairs of bodies that cannot have a contact, because neither body is compliant with a mesh.
    #[must_use]
    pub fn without_rigid_self_contact(self) -> Self {
        self.ignoring(|first, second| !first.has_mesh() && !second.has_mesh())
    }

    fn ignoring(mut self, is_ignored: impl Fn(&Body, &Body) -> bool) -> Self {
        let bodies = self.bodies.iter().filter(|body| body.has_shape());
        let bodies: Vec<&Body> = bodies.collect();
        for (index, first) in bodies.iter().enumerate() {
            for second in &bodies[index + 1..] {
                if is_ignored(first, second) {
                    let names = [first, second].map(|body| body.name().to_owned());
                    self.ignored.push(names);
                }
            }
        }
        self
    }

    /// Changes the joint with this name, for example to add a servo:
    ///
    /// ```
    /// # use hydroelastic::dynamics::{Body, BodyShape, Joint, Mass, Material, Mechanism};
    /// # use hydroelastic::spatial::MassProperties;
    /// # use nalgebra::Vector3;
    /// # let mass = Mass::Properties(MassProperties::solid_ball(1.0, 0.1));
    /// # let arm = Body::dynamic("arm", BodyShape::None, Material::rigid(), mass)?
    /// #     .with_joint(Joint::revolute("shoulder", Vector3::y_axis()))?;
    /// let mechanism = Mechanism::new(vec![arm])
    ///     .with_joint("shoulder", |joint| joint.with_servo(200.0, 20.0).with_target(0.5, 0.0))?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// If no joint has this name.
    pub fn with_joint(
        mut self,
        name: &str,
        change: impl FnOnce(Joint) -> Joint,
    ) -> Result<Self, WorldError> {
        let mut joints = self
            .bodies
            .iter_mut()
            .filter_map(Body::connecting_joint_mut);
        if let Some(joint) = joints.find(|joint| joint.name() == name) {
            *joint = change(joint.clone());
            return Ok(self);
        }
        Err(WorldError::UnknownJoint {
            kind: "joint",
            name: name.to_owned(),
            known: self.joints().map(|joint| joint.name().to_owned()).collect(),
        })
    }

    /// Changes each revolute and prismatic joint that mimics no other joint.
    #[must_use]
    pub fn with_joints(mut self, change: impl Fn(Joint) -> Joint) -> Self {
        for joint in self
            .bodies
            .iter_mut()
            .filter_map(Body::connecting_joint_mut)
        {
            if joint.kind().is_scalar() && joint.mimic().is_none() {
                *joint = change(joint.clone());
            }
        }
        self
    }
}

impl WorldBuilder {
    /// Adds the bodies of a mechanism and its pairs of bodies without contact.
    pub fn mechanism(mut self, mechanism: Mechanism) -> Self {
        self.ignored.extend(mechanism.ignored);
        self.bodies(mechanism.bodies)
    }
}
