"""Drake's side of `accuracy.py`: answers questions on stdin, a JSON line each, until it closes.

Timed is `Simulator.AdvanceTo` of a discrete `MultibodyPlant`, in processor time. A body on a path is
one on prismatic joints, without gravity. Before each step, outside the time, it is put where the path
is, with the mean velocity of the step, and stiff controllers on the joints, which Drake treats
implicitly, hold it to that. TAMSI has no such controllers: there the body is so heavy that contacts
change its velocity by 1e-6 m/s in 10 ms. (The others converge relative to the momentum of *all*
bodies: heavy ones that move let them end before they have found the forces on a light one.)
"""

import json
import sys
import time

import numpy
from drake_side import rotation_and_origin, skin
from pydrake.geometry import Mesh
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
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

HEAVY, LIGHT = 1e6, 1.0  # kg
STIFFNESS = 1e9  # N/m


class Rollout:
    """A scene at its start, to be stepped by a contact approximation."""

    def __init__(self, scene, approximation, time_step):
        self.time_step, self.bodies = time_step, scene["bodies"]
        self.is_controlled = approximation != "tamsi"
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(
            time_step=time_step,
            contact_model="hydroelastic_with_fallback",
            discrete_contact_approximation=approximation,
            contact_surface_representation="polygon",
            stiction_tolerance=scene["slip_tolerance"],
        )
        self.plant, _ = AddMultibodyPlant(config, builder)
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -scene["gravity"]])
        self.joints = {}
        for body in self.bodies:
            self.add(body, scene)
        self.plant.Finalize()
        self.simulator = Simulator(builder.Build())
        root = self.simulator.get_mutable_context()
        # Between two steps, here and later: rounding cannot add or drop one.
        root.SetTime(-time_step / 2)
        self.context = self.plant.GetMyMutableContextFromRoot(root)
        for body in self.bodies:
            self.start(body)

    def add(self, body, scene):
        """The body of the plant with its joints, if any, and its shape."""
        link, place = self.plant.world_body(), pose(body)
        if body.get("moves"):
            link, place = self.moved_link(body), RigidTransform()
        elif body.get("mass"):
            unit = UnitInertia(*(numpy.array(body["moments"]) / body["mass"]))
            inertia = SpatialInertia(body["mass"], numpy.zeros(3), unit)
            link, place = self.plant.AddRigidBody(body["name"], inertia), RigidTransform()
        material = skin(body["modulus"], scene["dissipation"], scene["friction"])
        material.AddProperty("material", "relaxation_time", scene["relaxation_time"])
        self.plant.RegisterCollisionGeometry(
            link, place, Mesh(body["mesh"]), body["name"], material
        )

    def moved_link(self, body):
        """A body on a prismatic joint for each axis that its moves have."""
        model = self.plant.AddModelInstance(body["name"])
        axes = numpy.flatnonzero(numpy.any([move["by"] for move in body["moves"]], axis=0))
        link, joints = self.plant.world_body(), []
        for axis in axes:
            mass = LIGHT if self.is_controlled else HEAVY
            inertia = SpatialInertia.SolidSphereWithMass(mass, 1.0)
            name = f"{body['name']}, {'xyz'[axis]}"
            frame = pose(body) if not joints else None
            child = self.plant.AddRigidBody(name, model, inertia)
            unit = numpy.eye(3)[axis]
            joint = PrismaticJoint(name, self.frame(link, frame, name), child.body_frame(), unit)
            joints.append((axis, self.plant.AddJoint(joint)))
            if self.is_controlled:
                actuator = self.plant.AddJointActuator(name, joints[-1][1])
                actuator.set_controller_gains(PdControllerGains(p=STIFFNESS, d=0.0))
            link = child
        self.plant.set_gravity_enabled(model, False)
        self.joints[body["name"]] = joints
        return link

    def frame(self, link, offset, name):
        if offset is None:
            return link.body_frame()
        return self.plant.AddFrame(FixedOffsetFrame(f"{name}, start", link.body_frame(), offset))

    def start(self, body):
        if not body.get("mass"):
            return
        link = self.plant.GetBodyByName(body["name"])
        self.plant.SetFreeBodyPose(self.context, link, pose(body))
        velocity = SpatialVelocity(numpy.zeros(3), numpy.array(body.get("velocity", [0.0] * 3)))
        self.plant.SetFreeBodySpatialVelocity(self.context, link, velocity)

    def answer(self, steps):
        """The processor time (s) that the steps take, and where the bodies are then."""
        reply = {"seconds": 0.0, "positions": None, "failure": None}
        # Bodies on paths are moved before every step.
        at_once = 1 if self.joints else steps
        try:
            for done in range(0, steps, at_once):
                self.prescribe(done * self.time_step)
                end = (done + at_once - 0.5) * self.time_step
                start = time.process_time()
                self.simulator.AdvanceTo(end)
                reply["seconds"] += time.process_time() - start
        except RuntimeError as error:
            return {**reply, "failure": str(error)}
        positions = numpy.array([self.position(body) for body in self.bodies])
        if not numpy.isfinite(positions).all():
            return {**reply, "failure": "not finite"}
        return {**reply, "positions": positions.tolist()}

    def prescribe(self, now):
        """Puts the bodies on paths where they are, with the mean velocity of the step."""
        for body in self.bodies:
            if not body.get("moves"):
                continue
            here = displacement(body["moves"], now)
            there = displacement(body["moves"], now + self.time_step)
            velocity = (there - here) / self.time_step
            for axis, joint in self.joints[body["name"]]:
                joint.set_translation(self.context, here[axis])
                joint.set_translation_rate(self.context, velocity[axis])
            if self.is_controlled:
                self.control(body["name"], there, velocity)

    def control(self, name, position, velocity):
        """Tells the controllers of a body where it shall be at the end of the step."""
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


def displacement(moves, now):
    """Sum of the moves (m) until a time (s): 3s² − 2s³ of each, where s is the part of its interval
    that is over."""
    total = numpy.zeros(3)
    for move in moves:
        over = (now - move["from"]) / (move["until"] - move["from"])
        over = min(max(over, 0.0), 1.0)
        total += numpy.array(move["by"]) * over * over * (3 - 2 * over)
    return total


if __name__ == "__main__":
    for line in sys.stdin:
        question = json.loads(line)
        rollout = Rollout(question["scene"], question["method"], question["time_step"])
        print(json.dumps(rollout.answer(question["steps"])), flush=True)
