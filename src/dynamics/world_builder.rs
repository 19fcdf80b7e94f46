use super::{Body, Control, LoopJoint, State, World, WorldError};
use nalgebra::Vector3;

/// Builder of a world: see [`World::builder`]. The methods can be called in any order, because [`Self::build`] checks all settings.
///
/// ```
/// use hydroelastic::contact::{HalfSpace, RigidShape};
/// use hydroelastic::dynamics::{Body, Material, World};
/// use hydroelastic::mesh::{TriangleSurface, shapes};
/// use nalgebra::vector;
///
/// let cube = shapes::cuboid([0.1; 3])?;
/// let gripper = RigidShape::new(TriangleSurface::around(cube.mesh())?);
/// let world = World::builder()
///     .body(Body::fixed("floor", HalfSpace::rigid(), Material::rigid())?)
///     .body(Body::fixed("gripper", gripper, Material::rigid())?)
///     .ignore("floor", "gripper") // rigid bodies cannot touch each other
///     .gravity(vector![0.0, 0.0, -9.81])
///     .slip_tolerance(1e-3)
///     .build()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
#[must_use]
pub struct WorldBuilder {
    bodies: Vec<Body>,
    pub(super) ignored: Vec<[String; 2]>,
    loop_joints: Vec<LoopJoint>,
    initial_state: Option<State>,
    gravity: Option<Vector3<f64>>,
    slip_tolerance: Option<f64>,
    controls: Vec<Control>,
    force_parameters: Vec<(String, f64)>,
}

impl World {
    /// Creates an empty builder.
    pub fn builder() -> WorldBuilder {
        WorldBuilder::default()
    }
}

impl WorldBuilder {
    /// Adds a body. States list the bodies in the order in which they were added.
    pub fn body(self, body: Body) -> Self {
        self.bodies([body])
    }

    /// Adds bodies.
    pub fn bodies(mut self, bodies: impl IntoIterator<Item = Body>) -> Self {
        self.bodies.extend(bodies);
        self
    }

    /// Lets two bodies pass through each other.
    pub fn ignore(mut self, first: &str, second: &str) -> Self {
        self.ignored.push([first, second].map(str::to_owned));
        self
    }

    /// Adds a joint that closes a loop of bodies. Its two bodies pass through each other.
    pub fn loop_joint(mut self, joint: LoopJoint) -> Self {
        self.loop_joints.push(joint);
        self
    }

    /// Sets the initial state and its time: see [`World::with_initial_state`].
    pub fn initial_state(mut self, state: State) -> Self {
        self.initial_state = Some(state);
        self
    }

    /// Sets gravity (m/s², zero by default).
    pub fn gravity(mut self, gravity: Vector3<f64>) -> Self {
        self.gravity = Some(gravity);
        self
    }

    /// Sets the slip tolerance (m/s): see [`World::with_slip_tolerance`].
    pub fn slip_tolerance(mut self, slip_tolerance: f64) -> Self {
        self.slip_tolerance = Some(slip_tolerance);
        self
    }

    /// Adds a control, or replaces the control of the same body.
    pub fn control(mut self, control: Control) -> Self {
        self.controls.push(control);
        self
    }

    /// Adds a number that forces can read: see [`World::with_force_parameter`].
    pub fn force_parameter(mut self, name: &str, value: f64) -> Self {
        self.force_parameters.push((name.to_owned(), value));
        self
    }

    /// Builds the world. [`World::with_forces`] adds other forces.
    ///
    /// # Errors
    /// - If two bodies have the same name, or an initial state is not valid.
    /// - [`WorldError::NoContact`] if two bodies are rigid or half-spaces, and at least one of them
    ///   is dynamic. [`Self::ignore`] lets these bodies pass through each other.
    /// - If an ignored pair names an unknown body, or the same body twice.
    /// - If a loop joint is not [valid](LoopJoint::check), names an unknown body, has the name of another joint, or connects no dynamic body.
    /// - [`WorldError::OpenLoop`] if the frames of a loop joint do not coincide in the initial state, to 1e-3 m and 1e-3 rad.
    /// - As for the `with_…` methods of [`World`].
    pub fn build(self) -> Result<World, WorldError> {
        let mut world = World::of_bodies(self.bodies, &self.ignored, &self.loop_joints)?;
        if let Some(gravity) = self.gravity {
            world = world.with_gravity(gravity)?;
        }
        if let Some(slip_tolerance) = self.slip_tolerance {
            world = world.with_slip_tolerance(slip_tolerance)?;
        }
        for control in self.controls {
            world = world.with_control(control)?;
        }
        for (name, value) in &self.force_parameters {
            world = world.with_force_parameter(name, *value)?;
        }
        if let Some(state) = &self.initial_state {
            return world.with_initial_state(state);
        }
        world.model.check_initial_loops()?;
        Ok(world)
    }
}
