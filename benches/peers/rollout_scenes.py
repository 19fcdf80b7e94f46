"""Four scenes for both programs, told by numbers, with what is measured of each.

A body with a mass falls, one with moves follows a path, any other is fixed. Lengths are in m, times
in s, masses in kg, moduli in Pa. `measured`: bodies and axes whose positions make up the error;
scenes of one group are variants whose errors go together. The dissipation is Hunt and Crossley's;
Drake's `sap` has a relaxation time instead, by which the ball rebounds as high as with the others.
"""

import math

import meshes
import numpy
from poses import pose_numbers, rotation

MODULUS = 1e7
GRAVITY = 9.81
SLIP_TOLERANCE = 1e-3  # m/s; in Drake the stiction tolerance
TURNED = rotation(numpy.array([0.3, 0.2, 0.1]))
LEVEL = numpy.eye(3)
OUR_REFERENCE = 2e-6  # s
CUBES = 5
CELLS = 2  # Drake's points of contact, one a polygon, must be many enough to carry a brick.
DROPS = [0.2, 0.203, 0.206]
SLIDING_SPEED, SLIDING_FRICTION = 0.69, 0.2
BRICK = [0.2, 0.2, 0.1]


class Builder:
    """Makes scenes, and writes the mesh files they read."""

    def __init__(self, folder):
        self.folder = folder
        folder.mkdir(exist_ok=True)

    def groups(self):
        """Scenes of each group, by its name."""
        return {
            "ball drop": [self.drop(height) for height in DROPS],
            "slide to a stop": [self.slide()],
            "stack of five cubes": [self.stack()],
            "grasp": [self.grasp()],
        }

    def drop(self, height):
        """A ball falls onto a box; measured near the top of its rebound."""
        ball = self.ball(0.05, [0.013, 0.021, 0.05 + height])
        box = self.box([1.0, 1.0, 0.4], [0.0, 0.0, -0.2], MODULUS)
        laws = {"dissipation": 0.3, "relaxation_time": 4.4e-4, "friction": 0.0}
        return scene([ball, box], laws, 0.35, ([0], [2]), drake_reference=2e-6)

    def slide(self):
        """A brick that starts at rest in height comes to a stop."""
        depth = GRAVITY / (BRICK[0] * BRICK[1]) * (0.05 + 0.2) / MODULUS
        brick = self.brick(BRICK, [-0.1, 0.021, 0.05 - depth], MODULUS, LEVEL)
        brick["velocity"] = [SLIDING_SPEED, 0.0, 0.0]
        floor = self.box([2.0, 2.0, 0.4], [0.0, 0.0, -0.2], MODULUS)
        laws = {"dissipation": 0.5, "relaxation_time": 3e-6, "friction": SLIDING_FRICTION}
        return scene([brick, floor], laws, 0.4, ([0], [0]), drake_reference=5e-6)

    def stack(self):
        """Cubes, each a little turned and 0.1 mm above the one below; their moduli differ, so that
        no two fields coincide."""
        cubes = []
        for k in range(CUBES):
            height = 0.05 + 0.1 * k + 1e-4 * (k + 1)
            place = [0.004 * math.sin(1.7 * k), 0.003 * math.cos(k), height]
            turn = rotation(numpy.array([0.0, 0.0, 0.2 * k + 0.1]))
            cubes.append(self.brick([0.1] * 3, place, MODULUS * (1 + 0.17 * k), turn))
        floor = self.box([1.0, 1.0, 0.4], [0.011, 0.007, -0.2], 2 * MODULUS)
        laws = {"dissipation": 0.5, "relaxation_time": 2e-5, "friction": 0.5}
        measured = (list(range(CUBES)), [0, 1, 2])
        return scene([*cubes, floor], laws, 1.0, measured, drake_reference=2e-5)

    def grasp(self):
        """A ball on a table, squeezed by 2.1 mm from 50 ms on and lifted from 0.1 to 0.6 s."""
        modulus = 1.3 * MODULUS
        ball = self.ball(0.1, [0.0, 0.0, 0.5])
        table = self.box([1.0, 1.0, 0.4], [0.02, 0.01, 0.2], modulus)
        fingers = []
        for side in (-1, 1):
            finger = self.box([0.1, 0.2, 0.16], [side * 0.1505, 0.003, 0.5], modulus)
            squeeze = {"by": [-side * 0.0026, 0.0, 0.0], "from": 0.0, "until": 0.05}
            lift = {"by": [0.0, 0.0, 0.1], "from": 0.1, "until": 0.6}
            fingers.append({**finger, "moves": [squeeze, lift]})
        laws = {"dissipation": 0.5, "relaxation_time": 5e-4, "friction": 0.5}
        bodies = [ball, *fingers, table]
        return scene(bodies, laws, 1.0, ([0], [2]), drake_reference=2e-5)

    def ball(self, radius, place):
        mesh = meshes.icosphere(radius, 2)
        return self.body(f"icosphere_{radius}", mesh, TURNED, place, MODULUS, mass=1.0)

    def box(self, lengths, place, modulus):
        """A box of twelve tetrahedra."""
        name = "cuboid_" + "_".join(map(str, lengths))
        return self.body(name, meshes.cuboid(lengths), LEVEL, place, modulus)

    def brick(self, lengths, place, modulus, turn):
        """A box of 1 kg with CELLS² squares a face."""
        name = "brick_" + "_".join(map(str, lengths))
        return self.body(name, meshes.cuboid(lengths, CELLS), turn, place, modulus, mass=1.0)

    def body(self, name, mesh, turn, place, modulus, mass=None):
        path = self.folder / f"{name}.vtk"
        meshes.write_vtk(path, mesh)
        pose = pose_numbers(turn, numpy.array(place))
        body = {"mesh": str(path), "pose": pose, "modulus": modulus}
        return {**body, "mass": mass, "moments": meshes.moments(mesh, mass)} if mass else body


def scene(bodies, laws, duration, measured, drake_reference):
    """A scene whose bodies are named by their places in the list; the last is the step (s) of
    Drake's reference."""
    bodies = [{**body, "name": f"body {place}"} for place, body in enumerate(bodies)]
    constants = {"slip_tolerance": SLIP_TOLERANCE, "gravity": GRAVITY}
    question = {"bodies": bodies, **laws, **constants}
    return {
        "question": question,
        "duration": duration,
        "measured": measured,
        "reference_steps": {"ours": OUR_REFERENCE, "drake": drake_reference},
    }


def measured_positions(scene, positions):
    """The coordinates (m) that the error is made of, body by body."""
    bodies, axes = scene["measured"]
    return numpy.array(positions)[numpy.ix_(bodies, axes)]
