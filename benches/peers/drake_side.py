"""Drake's side of `compare.py`: answers questions on stdin, one JSON line each, until stdin closes.

`wrench` and `jacobian` time `QueryObject.ComputeContactSurfaces(kPolygon)` alone, at poses that were set just before and that Drake has
not evaluated yet. The surfaces are integrated afterwards, outside the measured time. `steps` times `Simulator.AdvanceTo` of a discrete
`MultibodyPlant`.
"""

import json
import sys
import time

import numpy
from pydrake.autodiffutils import AutoDiffXd, ExtractGradient, ExtractValue, InitializeAutoDiff
from pydrake.common.value import Value
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Box,
    FramePoseVector_,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    HydroelasticContactRepresentation,
    Mesh,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform, RigidTransform_, RotationMatrix, RotationMatrix_
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.analysis import Simulator_
from pydrake.systems.framework import DiagramBuilder

POLYGON = HydroelasticContactRepresentation.kPolygon
DERIVATIVES = 12


def skin(modulus, dissipation=0.0, friction=0.0):
    """Returns the properties of a compliant body."""
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=dissipation,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    AddCompliantHydroelasticProperties(0.1, modulus, properties)
    return properties


class Pair:
    """Two meshes in a scene graph, for one scalar type."""

    def __init__(self, meshes, modulus):
        self.scene = SceneGraph()
        self.source = self.scene.RegisterSource("pair")
        self.frames, self.ids = [], []
        for name, path in zip("ab", meshes):
            frame = self.scene.RegisterFrame(self.source, GeometryFrame(name))
            shape = GeometryInstance(RigidTransform(), Mesh(path), name)
            shape.set_proximity_properties(skin(modulus))
            self.ids.append(self.scene.RegisterGeometry(self.source, frame, shape))
            self.frames.append(frame)
        self.posed = {float: Posed(self, float), AutoDiffXd: Posed(self, AutoDiffXd)}

    def answer(self, scalar, poses):
        """Returns times, wrenches on A about A's origin and, with derivatives, their Jacobians."""
        timed = [self.posed[scalar].timed_surfaces(both) for both in poses]
        reply = {"seconds": [seconds for seconds, _ in timed]}
        origins = [numpy.array(both[0][9:]) for both in poses]
        sums = [
            wrench_of(surfaces, self.ids[0], origin)
            for (_, surfaces), origin in zip(timed, origins)
        ]
        reply["wrenches"] = [wrench.tolist() for wrench, _, _ in sums]
        reply["jacobians"] = [jacobian.tolist() for _, jacobian, _ in sums]
        reply["polygons"] = [count for _, _, count in sums]
        return reply


class Posed:
    """A scene graph in a scalar type, with its context."""

    def __init__(self, pair, scalar):
        self.scalar, self.frames = scalar, pair.frames
        self.scene = pair.scene if scalar is float else pair.scene.ToAutoDiffXd()
        self.context = self.scene.CreateDefaultContext()
        self.port = self.scene.get_source_pose_port(pair.source)

    def timed_surfaces(self, poses):
        """Returns the contact surfaces at the poses, and their times (s)."""
        vector = FramePoseVector_[self.scalar]()
        for frame, pose in zip(self.frames, self.transforms(poses)):
            vector.set_value(frame, pose)
        self.port.FixValue(self.context, Value[FramePoseVector_[self.scalar]](vector))
        query = self.scene.get_query_output_port().Eval(self.context)
        start = time.perf_counter()
        surfaces = query.ComputeContactSurfaces(POLYGON)
        return time.perf_counter() - start, surfaces

    def transforms(self, poses):
        """Returns poses from 9 entries of the rotation, row by row, and 3 of the translation. Derivatives are with respect to the twists of
        A and then of B, angular before linear, in world axes."""
        if self.scalar is float:
            return [RigidTransform(*rotation_and_origin(pose)) for pose in poses]
        seeds = InitializeAutoDiff(numpy.zeros(DERIVATIVES)).reshape(2, 2, 3)
        return [seeded(pose, *twist) for pose, twist in zip(poses, seeds)]


def rotation_and_origin(pose):
    return RotationMatrix(numpy.reshape(pose[:9], (3, 3))), numpy.array(pose[9:])


def seeded(pose, angular, linear):
    """Returns the pose with derivatives with respect to a twist at zero."""
    rotation, origin = numpy.reshape(pose[:9], (3, 3)), numpy.array(pose[9:])
    x, y, z = angular
    turn = numpy.array([[0 * x, -z, y], [z, 0 * x, -x], [-y, x, 0 * x]])
    return RigidTransform_[AutoDiffXd](
        RotationMatrix_[AutoDiffXd](rotation + turn @ rotation), origin + linear
    )


def wrench_of(surfaces, id_a, origin):
    """Integrates pressure times normal exactly over the polygons. Returns torque about `origin` and force on A, with derivatives of the
    surface and of A's origin, and the number of polygons."""
    wrench, jacobian, count = numpy.zeros(6), numpy.zeros((6, DERIVATIVES)), 0
    for surface in surfaces:
        sign = 1.0 if surface.id_M() == id_a else -1.0
        points, pressures, triangles = triangulated(surface)
        value, derivative = integrals(points, pressures, triangles, origin)
        wrench += sign * value
        jacobian += sign * derivative
        count += surface.num_faces()
    return wrench, jacobian, count


def triangulated(surface):
    """Returns vertices and pressures, each with derivatives along a last axis, and triangles of vertex indices."""
    mesh, field = surface.poly_mesh_W(), surface.poly_e_MN()
    vertices = range(mesh.num_vertices())
    points = with_derivatives(numpy.array([mesh.vertex(v) for v in vertices]))
    pressures = with_derivatives(numpy.array([field.EvaluateAtVertex(v) for v in vertices]))
    faces, triangles, at = mesh.face_data(), [], 0
    while at < len(faces):
        polygon = faces[at + 1 : at + 1 + faces[at]]
        triangles += [(polygon[0], *edge) for edge in zip(polygon[1:], polygon[2:])]
        at += 1 + faces[at]
    return points, pressures, numpy.array(triangles)


def with_derivatives(numbers):
    """Returns values and their derivatives: [..., 0] is the value, [..., 1:] are the derivatives."""
    if numbers.dtype != object:
        return numpy.concatenate([numbers[..., None], numpy.zeros((*numbers.shape, 12))], axis=-1)
    flat = numbers.reshape(-1, 1)
    return numpy.hstack([ExtractValue(flat), ExtractGradient(flat)]).reshape(*numbers.shape, -1)


def integrals(points, pressures, triangles, origin):
    """Returns the wrench and its derivatives. The edge-midpoint rule is exact, because the integrand is quadratic."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    area = product(cross, b - a, c - a) / 2
    center = numpy.zeros((3, 1 + DERIVATIVES))
    center[:, 0], center[:, 4:7] = origin, numpy.eye(3)
    wrench = numpy.zeros((6, 1 + DERIVATIVES))
    for first, second in [(0, 1), (1, 2), (2, 0)]:
        pressure = (pressures[triangles[:, first]] + pressures[triangles[:, second]]) / 6
        lever = (points[triangles[:, first]] + points[triangles[:, second]]) / 2 - center
        force = product(numpy.multiply, pressure[:, None, :], area)
        wrench[3:] += force.sum(axis=0)
        wrench[:3] += product(cross, lever, force).sum(axis=0)
    return wrench[:, 0], wrench[:, 1:]


def cross(left, right):
    """Returns the cross product along the axis before the last."""
    return numpy.cross(left, right, axis=-2)


def product(bilinear, left, right):
    """Returns the product of two quantities with derivatives, by the product rule."""
    value = bilinear(left[..., :1], right[..., :1])
    derivative = bilinear(left[..., 1:], right[..., :1]) + bilinear(left[..., :1], right[..., 1:])
    return numpy.concatenate([value, derivative], axis=-1)


def hard_skin(dissipation, friction):
    """Returns the properties of a rigid body."""
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=dissipation,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    AddRigidHydroelasticProperties(1.0, properties)
    return properties


class BallOnFloor:
    """A compliant ball at rest on a floor that is fixed to the world, in discrete time."""

    def __init__(self, scene):
        self.time_step = scene["time_step"]
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(
            time_step=self.time_step,
            contact_model="hydroelastic_with_fallback",
            discrete_contact_approximation=scene["approximation"],
            contact_surface_representation="polygon",
        )
        self.plant, _ = AddMultibodyPlant(config, builder)
        self.add_bodies(scene)
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.simulator = Simulator_[float](self.diagram)
        # All times lie between two steps, so that rounding cannot add or drop a step.
        self.simulator.get_mutable_context().SetTime(-self.time_step / 2)
        context = self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        pose = RigidTransform(*rotation_and_origin(scene["start"]))
        self.plant.SetFreeBodyPose(context, self.plant.GetBodyByName("ball"), pose)
        self.advance(self.simulator, scene["settling_steps"])

    def add_bodies(self, scene):
        material = skin(scene["modulus"], scene["dissipation"], scene["friction"])
        inertia = SpatialInertia.SolidSphereWithMass(scene["mass"], scene["radius"])
        ball = self.plant.AddRigidBody("ball", inertia)
        self.plant.RegisterCollisionGeometry(
            ball, RigidTransform(), Mesh(scene["ball"]), "ball", material
        )
        hard = hard_skin(scene["dissipation"], scene["friction"])
        top = RigidTransform([0.0, 0.0, 0.5])
        pose, shape, skin_of_floor = {
            "soft box": (RigidTransform(), Mesh(scene["box"]), material),
            "rigid box": (RigidTransform(), Box(1.0, 1.0, 1.0), hard),
            "half-space": (top, HalfSpace(), hard),
        }[scene["floor"]]
        self.plant.RegisterCollisionGeometry(
            self.plant.world_body(), pose, shape, "floor", skin_of_floor
        )

    def advance(self, simulator, steps):
        """Returns the time (s) of the steps."""
        end = simulator.get_context().get_time() + steps * self.time_step
        start = time.perf_counter()
        simulator.AdvanceTo(end)
        return time.perf_counter() - start

    def answer(self, steps, derivatives):
        """Returns the time per step, without derivatives or with derivatives with respect to the state."""
        simulator = self.with_derivatives() if derivatives else self.simulator
        seconds = self.advance(simulator, steps) / steps
        context = self.plant.GetMyContextFromRoot(self.simulator.get_context())
        results = self.plant.get_contact_results_output_port().Eval(context)
        contacts = range(results.num_hydroelastic_contacts())
        surfaces = [results.hydroelastic_contact_info(i).contact_surface() for i in contacts]
        return {
            "seconds": seconds,
            "height": self.plant.GetPositions(context)[6],
            "polygons": sum(surface.num_faces() for surface in surfaces),
        }

    def with_derivatives(self):
        """Returns a simulator at the present state, with derivatives with respect to the state except one component of the quaternion."""
        diagram = self.diagram.ToAutoDiffXd()
        simulator = Simulator_[AutoDiffXd](diagram)
        root = simulator.get_mutable_context()
        root.SetTimeStateAndParametersFrom(self.simulator.get_context())
        plant = diagram.GetSubsystemByName(self.plant.get_name())
        context = plant.GetMyMutableContextFromRoot(root)
        state = ExtractValue(plant.GetPositionsAndVelocities(context)).ravel()
        seeds = InitializeAutoDiff(state[1:]).ravel()
        lifted = numpy.concatenate([[AutoDiffXd(state[0])], seeds])
        plant.SetPositionsAndVelocities(context, lifted)
        return simulator


class Answers:
    """Answers questions, and builds each scene on first use."""

    def __init__(self):
        self.scenes = {}

    def to(self, question):
        scene = question["scene"]
        key = json.dumps(scene)
        is_rollout = question["ask"] == "steps"
        if key not in self.scenes:
            self.scenes[key] = BallOnFloor(scene) if is_rollout else Pair(**scene)
        if is_rollout:
            return self.scenes[key].answer(question["steps"], question["derivatives"])
        scalar = {"wrench": float, "jacobian": AutoDiffXd}[question["ask"]]
        return self.scenes[key].answer(scalar, question["poses"])


if __name__ == "__main__":
    answers = Answers()
    for line in sys.stdin:
        print(json.dumps(answers.to(json.loads(line))), flush=True)
