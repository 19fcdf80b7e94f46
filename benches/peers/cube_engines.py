"""MuJoCo and Drake for `cube.py`: a cube that is tossed onto a table.

An engine has `parameters`, and its method `rollouts` simulates the cube from many initial states with values of the parameters. A state has
13 numbers: quaternion (w, x, y, z) of the cube in the world, position of its center (m), angular velocity in body axes (rad/s) and velocity
in world axes (m/s). A pose is the first seven of them.
"""

import dataclasses
import itertools

import mujoco
import mujoco.rollout
import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

FRAME_RATE = 148.0  # Hz
EDGE, MASS, MOMENT = 0.1048, 0.37, 8.1e-4  # m, kg, kg m²
CORNER_RADIUS = 1e-5  # m, radius of the spheres at the corners in Drake's point contact
HARD = 1e12  # N/m, the stiffness of the table in Drake's point contact
GRAVITY, HEIGHT, INERTIA = "gravity (m/s²)", "table height (m)", "moment of inertia (kg m²)"


@dataclasses.dataclass(frozen=True)
class Parameter:
    """A fitted number, with a guess and a typical change of its coordinate. The coordinate is the number, its logarithm or its logit."""

    name: str
    guess: float
    change: float
    scale: str = "logarithm"

    def coordinate(self):
        """Returns the coordinate of the guess."""
        if self.scale == "linear":
            return self.guess
        return np.log(self.guess if self.scale == "logarithm" else self.guess / (1 - self.guess))

    def value(self, coordinate):
        if self.scale == "linear":
            return coordinate
        return np.exp(coordinate) if self.scale == "logarithm" else 1 / (1 + np.exp(-coordinate))


FRICTION = Parameter("friction", 0.2, 0.3)
SCENE = [Parameter(HEIGHT, -0.001, 0.001, "linear"), Parameter(GRAVITY, -9.7, 0.1, "linear")]


class MuJoCo:
    """A box on a plane, with up to four contact points. The parameters are `solref`, `solimp` and sliding friction."""

    variant, substeps = "elliptic", 4

    def __init__(self, variant, substeps):
        self.variant, self.substeps = variant, substeps
        self.parameters = [
            FRICTION,
            Parameter("time constant (s)", 0.01, 0.7),
            Parameter("damping ratio", 0.5, 0.5),
            Parameter("d0", 0.8, 1.0, "logit"),
            Parameter("dwidth", 0.95, 1.0, "logit"),
            Parameter("width (m)", 1e-3, 1.0),
            *SCENE,
        ]

    def model(self, values):
        spec = mujoco.MjSpec()
        spec.option.timestep = 1 / (FRAME_RATE * self.substeps)
        spec.option.gravity = [0, 0, values[GRAVITY]]
        spec.option.cone = getattr(mujoco.mjtCone, f"mjCONE_{self.variant.upper()}")
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], pos=[0, 0, values[HEIGHT]])
        cube = spec.worldbody.add_body()
        cube.add_freejoint()
        cube.mass, cube.inertia, cube.explicitinertial = MASS, [values.get(INERTIA, MOMENT)] * 3, True
        cube.ipos, cube.iquat = [0.0] * 3, [1.0, 0.0, 0.0, 0.0]
        cube.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[EDGE / 2] * 3,
            # MuJoCo uses the contact parameters of the geometry with the higher priority.
            priority=1,
            friction=[values["friction"], 0.0, 0.0],
            solref=[values["time constant (s)"], values["damping ratio"]],
            # The last two entries are the defaults of midpoint and power.
            solimp=[values["d0"], values["dwidth"], values["width (m)"], 0.5, 2.0],
        )
        return spec.compile()

    def rollouts(self, values, states, frame_counts):
        """Returns the poses of the frames after each initial state."""
        model = self.model(values)
        states = staggered(states, values[GRAVITY], model.opt.timestep)
        start = np.zeros((len(states), mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
        # A full state begins with the time, the position and quaternion, and the velocity with the angular velocity in body axes.
        start[:, 1:14] = np.hstack([states[:, 4:7], states[:, :4], states[:, 10:], states[:, 7:10]])
        steps = max(frame_counts) * self.substeps
        paths, _ = mujoco.rollout.rollout(model, mujoco.MjData(model), start, nstep=steps)
        frames = paths[:, self.substeps - 1 :: self.substeps]
        return np.concatenate([frames[..., 4:8], frames[..., 1:4]], axis=-1)


class Drake:
    """A cube on a half-space in a discrete plant. The parameters are a stiffness, dissipation or relaxation time, and friction."""

    variant, substeps = "sap", 2

    def __init__(self, variant, substeps):
        self.variant, self.substeps = variant, substeps
        dissipation = Parameter("dissipation (s/m)", 10.0, 0.7)
        relaxation = Parameter("relaxation time (s)", 0.05, 0.7)
        self.parameters = [FRICTION, *SCENE, self.stiffness, relaxation if variant == "sap" else dissipation]

    def plant(self, values):
        """Returns a simulator and its plant."""
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(
            time_step=1 / (FRAME_RATE * self.substeps),
            contact_model=self.contact_model,
            discrete_contact_approximation=self.variant,
            contact_surface_representation="polygon",
        )
        plant, _ = AddMultibodyPlant(config, builder)
        plant.mutable_gravity_field().set_gravity_vector([0, 0, values[GRAVITY]])
        unit = UnitInertia.TriaxiallySymmetric(values.get(INERTIA, MOMENT) / MASS)
        cube = plant.AddRigidBody("cube", SpatialInertia(MASS, np.zeros(3), unit))
        for name, center, shape in self.shapes():
            plant.RegisterCollisionGeometry(cube, RigidTransform(center), shape, name, self.skin(values))
        table = RigidTransform([0, 0, values[HEIGHT]])
        plant.RegisterCollisionGeometry(plant.world_body(), table, HalfSpace(), "table", self.hard_skin(values))
        plant.Finalize()
        return Simulator(builder.Build()), plant

    def rollouts(self, values, states, frame_counts):
        """Returns the poses of the frames after each initial state."""
        simulator, plant = self.plant(values)
        paths = np.full((len(states), max(frame_counts), 7), np.nan)
        states = staggered(states, values[GRAVITY], plant.time_step())
        for state, path, frame_count in zip(states, paths, frame_counts):
            try:
                self.simulate(simulator, plant, state, path[:frame_count])
            except RuntimeError:
                # The contact solver did not converge. The rest of the path remains NaN.
                continue
        return paths

    def simulate(self, simulator, plant, state, path):
        """Writes the poses of the frames after the state into the path."""
        root, step = simulator.get_mutable_context(), plant.time_step()
        context = plant.GetMyMutableContextFromRoot(root)
        # Drake's angular velocities are in world axes.
        velocities = [rotated(state[:4], state[7:10]), state[10:]]
        plant.SetPositionsAndVelocities(context, np.concatenate([state[:7], *velocities]))
        # All times lie between two steps, so that rounding cannot add or drop a step.
        root.SetTime(-step / 2)
        simulator.Initialize()
        for frame in range(len(path)):
            simulator.AdvanceTo(((frame + 1) * self.substeps - 0.5) * step)
            path[frame] = plant.GetPositions(context)


class DrakeHydroelastic(Drake):
    """A compliant box with Drake's pressure field on a rigid half-space."""

    contact_model = "hydroelastic"
    stiffness = Parameter("modulus (Pa)", 1e7, 1.0)

    def shapes(self):
        return [("cube", [0.0] * 3, Box(EDGE, EDGE, EDGE))]

    def skin(self, values):
        properties = material(values, values.get("dissipation (s/m)", 0.0), values.get("relaxation time (s)", 0.0))
        AddCompliantHydroelasticProperties(EDGE, values["modulus (Pa)"], properties)
        return properties

    def hard_skin(self, values):
        properties = material(values, 0.0, 0.0)
        AddRigidHydroelasticProperties(properties)
        return properties


class DrakePoint(Drake):
    """Small spheres at the corners of the cube, because Drake has one contact point for a box on a half-space."""

    contact_model = "point"
    stiffness = Parameter("stiffness (N/m)", 1e4, 1.0)

    def shapes(self):
        center = EDGE / 2 - CORNER_RADIUS
        corners = itertools.product([-center, center], repeat=3)
        return [(f"corner {index}", corner, Sphere(CORNER_RADIUS)) for index, corner in enumerate(corners)]

    def skin(self, values):
        dissipation = values.get("dissipation (s/m)", 0.0), values.get("relaxation time (s)", 0.0)
        return material(values, *dissipation, point_stiffness=values["stiffness (N/m)"])

    def hard_skin(self, values):
        return material(values, 0.0, 0.0, point_stiffness=HARD)


ENGINES = {"mujoco": MuJoCo, "drake-hydroelastic": DrakeHydroelastic, "drake-point": DrakePoint}


def material(values, dissipation, relaxation_time, **stiffness):
    """Returns the contact properties of a body. `sap` uses the relaxation time (s), and `lagged` and `similar` use the dissipation
    (s/m)."""
    properties = ProximityProperties()
    friction = CoulombFriction(values["friction"], values["friction"])
    AddContactMaterial(dissipation=dissipation, friction=friction, properties=properties, **stiffness)
    properties.AddProperty("material", "relaxation_time", relaxation_time)
    return properties


def staggered(states, gravity, step):
    """Returns the states with the velocities of half a step earlier. The symplectic Euler method is then exact in free flight."""
    states = states.copy()
    states[:, :4] /= np.linalg.norm(states[:, :4], axis=1, keepdims=True)
    states[:, 12] -= gravity * step / 2
    return states


def rotated(quaternion, vector):
    """Returns the vector, rotated by the unit quaternion."""
    twice = 2 * np.cross(quaternion[1:], vector)
    return vector + quaternion[0] * twice + np.cross(quaternion[1:], twice)
