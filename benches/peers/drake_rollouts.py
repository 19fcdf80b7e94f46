"""Drake's side of `accuracy.py`: answers questions on stdin, one JSON line each, until stdin closes.

The time is processor time of `Simulator.AdvanceTo`. With an accuracy, the plant is continuous and its integrator is CENIC; otherwise the
plant is discrete. A body on a path has prismatic joints with stiff controllers, and no gravity. CENIC reads the path from a
`TrajectorySource`. Before each discrete step, outside the measured time, the script puts the body on the path with the mean velocity of
the step, and the controllers hold it there.
"""

import json
import sys
import time

import numpy
from drake_side import hard_skin, rotation_and_origin, skin
from pydrake.geometry import HalfSpace, Mesh
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PdControllerGains,
    PrismaticJoint,
    SpatialInertia,
    UnitInertia,
)
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
from rollout_scenes import displacement

FINGER = 1.0  # kg
STIFFNESS, DAMPING = 1e9, 2 * (1e9 * FINGER) ** 0.5  # N/m, N s/m


class Rollout:
    """A scene in its initial state, with a method that advances it."""

    def __init__(self, scene, method, time_step, accuracy):
        self.time_step, self.bodies = time_step, scene["bodies"]
        self.is_continuous = accuracy is not None
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(
            time_step=0.0 if self.is_continuous else time_step,
            contact_model="hydroelastic_with_fallback",
            discrete_contact_approximation="lagged" if self.is_continuous else method,
            contact_surface_representation="polygon",
            stiction_tolerance=scene["slip_tolerance"],
        )
        self.plant, _ = AddMultibodyPlant(config, builder)
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -scene["gravity"]])
        self.joints = {}
        for body in self.bodies:
            self.add(body, scene)
        self.plant.Finalize()
        if self.is_continuous:
            self.connect_paths(builder)
        self.simulator = Simulator(builder.Build())
        root = self.simulator.get_mutable_context()
        if self.is_continuous:
            integrator = {"integration_scheme": method, "accuracy": accuracy}
            ApplySimulatorConfig(SimulatorConfig(**integrator, max_step_size=0.1), self.simulator)
        else:
            # All times lie between two steps, so that rounding cannot add or drop a step.
            root.SetTime(-time_step / 2)
        self.context = self.plant.GetMyMutableContextFromRoot(root)
        for body in self.bodies:
            self.start(body)

    def add(self, body, scene):
        """Adds the body to the plant, with its joints, if any, and its shape."""
        link, place = self.plant.world_body(), pose(body)
        if body.get("moves"):
            link, place = self.moved_link(body), RigidTransform()
        elif body.get("mass"):
            unit = UnitInertia(*(numpy.array(body["moments"]) / body["mass"]))
            inertia = SpatialInertia(body["mass"], numpy.zeros(3), unit)
            link, place = self.plant.AddRigidBody(body["name"], inertia), RigidTransform()
        shape, material = HalfSpace(), hard_skin(0.0, body["friction"])
        if body["mesh"]:
            shape = Mesh(body["mesh"])
            material = skin(body["modulus"], scene["dissipation"], body["friction"])
        relaxation_time = scene["relaxation_time"] if body["mesh"] else 0.0
        material.AddProperty("material", "relaxation_time", relaxation_time)
        self.plant.RegisterCollisionGeometry(link, place, shape, body["name"], material)

    def moved_link(self, body):
        """Adds a body with a prismatic joint for each axis of its moves."""
        model = self.plant.AddModelInstance(body["name"])
        axes = numpy.flatnonzero(numpy.any([move["by"] for move in body["moves"]], axis=0))
        link, joints = self.plant.world_body(), []
        for axis in axes:
            inertia = SpatialInertia.SolidSphereWithMass(FINGER, 1.0)
            name = f"{body['name']}, {'xyz'[axis]}"
            frame = pose(body) if not joints else None
            child = self.plant.AddRigidBody(name, model, inertia)
            unit = numpy.eye(3)[axis]
            joint = PrismaticJoint(name, self.frame(link, frame, name), child.body_frame(), unit)
            joints.append((axis, self.plant.AddJoint(joint)))
            actuator = self.plant.AddJointActuator(name, joints[-1][1])
            actuator.set_controller_gains(PdControllerGains(p=STIFFNESS, d=DAMPING))
            link = child
        self.plant.set_gravity_enabled(model, False)
        self.joints[body["name"]] = joints
        return link

    def frame(self, link, offset, name):
        if offset is None:
            return link.body_frame()
        return self.plant.AddFrame(FixedOffsetFrame(f"{name}, start", link.body_frame(), offset))

    def connect_paths(self, builder):
        """Connects the controllers to the paths: cubic polynomials with zero velocity at both ends of each move."""
        for body in self.bodies:
            if not body.get("moves"):
                continue
            ends = {move[end] for move in body["moves"] for end in ("from", "until")}
            times = sorted({0.0, *ends, 1e3})
            axes = [axis for axis, _ in self.joints[body["name"]]]
            positions = numpy.array([displacement(body["moves"], now)[axes] for now in times]).T
            path = PiecewisePolynomial.CubicHermite(times, positions, numpy.zeros_like(positions))
            source = builder.AddSystem(TrajectorySource(path, output_derivative_order=1))
            model = self.plant.GetModelInstanceByName(body["name"])
            port = self.plant.get_desired_state_input_port(model)
            builder.Connect(source.get_output_port(), port)

    def start(self, body):
        if not body.get("mass"):
            return
        link = self.plant.GetBodyByName(body["name"])
        self.plant.SetFreeBodyPose(self.context, link, pose(body))
        velocity = SpatialVelocity(numpy.zeros(3), numpy.array(body["velocity"]))
        self.plant.SetFreeBodySpatialVelocity(self.context, link, velocity)

    def answer(self, steps):
        """Returns the processor time (s) of the steps and the final positions of the bodies."""
        reply = {"seconds": 0.0, "positions": None, "failure": None}
        is_prescribed = bool(self.joints) and not self.is_continuous
        # Bodies on paths are moved before every discrete step.
        at_once, offset = 1 if is_prescribed else steps, 0.0 if self.is_continuous else 0.5
        try:
            for done in range(0, steps, at_once):
                if is_prescribed:
                    self.prescribe(done * self.time_step)
                end = (done + at_once - offset) * self.time_step
                start = time.process_time()
                self.simulator.AdvanceTo(end)
                reply["seconds"] += time.process_time() - start
        except RuntimeError as error:
            return {**reply, "failure": str(error)}
        positions = numpy.concatenate([self.position(body) for body in self.bodies])
        if not numpy.isfinite(positions).all():
            return {**reply, "failure": "not finite"}
        return {**reply, "positions": positions.tolist()}

    def prescribe(self, now):
        """Puts the bodies on their paths, with the mean velocity of the step."""
        for body in self.bodies:
            if not body.get("moves"):
                continue
            here = displacement(body["moves"], now)
            there = displacement(body["moves"], now + self.time_step)
            velocity = (there - here) / self.time_step
            for axis, joint in self.joints[body["name"]]:
                joint.set_translation(self.context, here[axis])
                joint.set_translation_rate(self.context, velocity[axis])
            self.control(body["name"], there, velocity)

    def control(self, name, position, velocity):
        """Sets the target of a body's controllers: its position at the end of the step."""
        axes = [axis for axis, _ in self.joints[name]]
        port = self.plant.get_desired_state_input_port(self.plant.GetModelInstanceByName(name))
        port.FixValue(self.context, numpy.concatenate([position[axes], velocity[axes]]))

    def position(self, body):
        if not body.get("mass"):
            return [0.0] * 3
        link = self.plant.GetBodyByName(body["name"])
        return self.plant.EvalBodyPoseInWorld(self.context, link).translation()


def pose(body):
    return RigidTransform(*rotation_and_origin(body["pose"]))


if __name__ == "__main__":
    for line in sys.stdin:
        question = json.loads(line)
        names = ("scene", "method", "time_step", "accuracy")
        rollout = Rollout(*(question[name] for name in names))
        print(json.dumps(rollout.answer(question["steps"])), flush=True)
