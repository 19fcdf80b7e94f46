"""Five scenes for all programs as plain numbers, the parameters of their slopes, and the measured bodies.

A body with a mass falls, a body with moves follows a path, any other body is fixed. A body without a mesh is
a rigid half-space. Lengths are in m, times in s, masses in kg, moduli in Pa. The dissipation is
Hunt and Crossley's. Drake's `sap` has a relaxation time instead, and MuJoCo has `solref`.
"""

import copy
import math

import meshes
import numpy
from poses import pose_numbers, rotation

MODULUS = 1e7
GRAVITY = 9.81
SLIP_TOLERANCE = 1e-3  # m/s; in Drake the stiction tolerance
TURNED = rotation(numpy.array([0.3, 0.2, 0.1]))
LEVEL = numpy.eye(3)
CUBES = 5
CELLS = 2  # Drake has one contact point per polygon, and a brick needs several points.
# Time constants (s) and damping ratios of MuJoCo's contacts.
SOFT, BOUNCING, STIFF = [0.02, 0.3], [0.002, 0.3], [0.002, 1.0]


class Builder:
    """Builds scenes and writes their mesh files."""

    def __init__(self, folder):
        self.folder = folder
        folder.mkdir(exist_ok=True)

    def scenes(self):
        """Returns the scenes by name."""
        return {
            "CENIC's ball": self.soft_ball(),
            "stiff ball": self.stiff_ball(),
            "flat cube": self.flat_cube(),
            "stack of five cubes": self.stack(),
            "grasp": self.grasp(),
        }

    def soft_ball(self):
        """Returns a compliant ball that is thrown on a floor, slides and rolls."""
        ball = self.ball(0.1, [0.0, 0.0, 0.3], LEVEL, 1e5)
        ball["velocity"] = [0.5, 0.0, 0.0]
        laws = {"dissipation": 1.0, "relaxation_time": 1e-2, "friction": 0.5, "solref": SOFT}
        slopes = [parameter("velocity", 0), parameter("friction")]
        return scene([ball, half_space()], laws, 1.0, ([0], [0]), slopes, [3.2e-3, 3.2e-4, 3.2e-6])

    def stiff_ball(self):
        """Returns the ball of chapter 6 of the guide, which bounces once."""
        ball = self.ball(0.05, [0.013, 0.017, 0.25], LEVEL, 1e9)
        ball["velocity"] = [0.3, 0.1, 0.0]
        floor = self.box([2.0, 2.0, 0.4], [0.0, 0.0, -0.2], 1e9)
        laws = {"dissipation": 0.3, "relaxation_time": 4.4e-5, "friction": 0.4, "solref": BOUNCING}
        slopes = [parameter("velocity", 2), parameter("friction")]
        return scene([ball, floor], laws, 0.3, ([0], [0, 2]), slopes)

    def flat_cube(self):
        """Returns a cube that falls flat on a floor and bounces."""
        cube = self.brick([0.1] * 3, [0.0, 0.0, 0.15], 1e9, LEVEL)
        laws = {"dissipation": 0.3, "relaxation_time": 4.4e-5, "friction": 0.0, "solref": BOUNCING}
        return scene([cube, half_space()], laws, 0.3, ([0], [2]), [parameter("position", 2)])

    def stack(self):
        """Returns a stack of cubes, each slightly rotated and 0.1 mm above the cube below. Their moduli differ, so that no two fields
        coincide."""
        cubes = []
        for k in range(CUBES):
            height = 0.05 + 0.1 * k + 1e-4 * (k + 1)
            place = [0.004 * math.sin(1.7 * k), 0.003 * math.cos(k), height]
            turn = rotation(numpy.array([0.0, 0.0, 0.2 * k + 0.1]))
            cubes.append(self.brick([0.1] * 3, place, MODULUS * (1 + 0.17 * k), turn))
        floor = self.box([1.0, 1.0, 0.4], [0.011, 0.007, -0.2], 2 * MODULUS)
        laws = {"dissipation": 0.5, "relaxation_time": 2e-5, "friction": 0.5, "solref": STIFF}
        measured = (list(range(CUBES)), [0, 1, 2])
        slopes = [parameter("velocity", 0, body=CUBES - 1)]
        # Only short explicit steps resolve its bounces of micrometers.
        return scene([*cubes, floor], laws, 1.0, measured, slopes, our_reference="leapfrog")

    def grasp(self):
        """Returns a ball on a table, squeezed by 2.1 mm from 50 ms on and lifted from 0.1 to 0.6 s."""
        modulus = 1.3 * MODULUS
        ball = self.ball(0.1, [0.0, 0.0, 0.5], TURNED, MODULUS)
        table = self.box([1.0, 1.0, 0.4], [0.02, 0.01, 0.2], modulus)
        fingers = []
        for side in (-1, 1):
            finger = self.box([0.1, 0.2, 0.16], [side * 0.1505, 0.003, 0.5], modulus)
            squeeze = {"by": [-side * 0.0026, 0.0, 0.0], "from": 0.0, "until": 0.05}
            lift = {"by": [0.0, 0.0, 0.1], "from": 0.1, "until": 0.6}
            fingers.append({**finger, "moves": [squeeze, lift]})
        laws = {"dissipation": 0.5, "relaxation_time": 5e-4, "friction": 0.5, "solref": STIFF}
        slopes = [parameter("mass"), parameter("friction")]
        return scene([ball, *fingers, table], laws, 1.0, ([0], [2]), slopes)

    def ball(self, radius, place, turn, modulus):
        mesh = meshes.icosphere(radius, 2)
        return self.body(f"icosphere_{radius}", mesh, turn, place, modulus, [radius], mass=1.0)

    def box(self, lengths, place, modulus):
        """Returns a box of twelve tetrahedra."""
        name = "cuboid_" + "_".join(map(str, lengths))
        return self.body(name, meshes.cuboid(lengths), LEVEL, place, modulus, lengths)

    def brick(self, lengths, place, modulus, turn):
        """Returns a box of 1 kg with CELLS² squares per face."""
        name = "brick_" + "_".join(map(str, lengths))
        mesh = meshes.cuboid(lengths, CELLS)
        return self.body(name, mesh, turn, place, modulus, lengths, mass=1.0)

    def body(self, name, mesh, turn, place, modulus, size, mass=None):
        """Returns a body. Its size is the radius of a ball or the lengths of a box."""
        path = self.folder / f"{name}.vtk"
        meshes.write_vtk(path, mesh)
        pose = pose_numbers(turn, numpy.array(place))
        body = {"mesh": str(path), "pose": pose, "modulus": modulus, "size": size}
        return {**body, "mass": mass, "moments": meshes.moments(mesh, mass)} if mass else body


def half_space():
    """Returns a rigid floor whose surface is z = 0."""
    return {"mesh": None, "pose": pose_numbers(LEVEL, numpy.zeros(3)), "modulus": 0.0}


def parameter(kind, axis=None, body=0):
    return {"kind": kind, "axis": axis, "body": body}


def scene(
    bodies, laws, duration, measured, parameters, allowed=(1e-3, 1e-4, 1e-5), our_reference="sdirk3"
):
    """Returns a scene that refers to bodies by index. `allowed` are the errors (m) in the tables, and `our_reference` is the method of our
    converged motion."""
    friction = laws.pop("friction")
    defaults = {"friction": friction, "velocity": [0.0] * 3}
    bodies = [{**defaults, **body, "name": f"body {i}"} for i, body in enumerate(bodies)]
    constants = {"slip_tolerance": SLIP_TOLERANCE, "gravity": GRAVITY}
    return {
        "question": {"bodies": bodies, **laws, **constants},
        "duration": duration,
        "measured": measured,
        "parameters": parameters,
        "allowed": allowed,
        "our_reference": our_reference,
    }


def changed(question, parameter, change):
    """Returns the question with one parameter changed (in its SI unit)."""
    question = copy.deepcopy(question)
    body, axis = question["bodies"][parameter["body"]], parameter["axis"]
    if parameter["kind"] == "position":
        body["pose"][9 + axis] += change
    elif parameter["kind"] == "velocity":
        body["velocity"][axis] += change
    elif parameter["kind"] == "friction":
        body["friction"] += change
    else:
        ratio = 1 + change / body["mass"]
        body["mass"] *= ratio
        body["moments"] = [ratio * moment for moment in body["moments"]]
    return question


def displacement(moves, now):
    """Returns the sum of the moves (m) up to a time (s). Each move follows 3s² − 2s³, where s is the elapsed fraction of its interval."""
    total = numpy.zeros(3)
    for move in moves:
        over = (now - move["from"]) / (move["until"] - move["from"])
        over = min(max(over, 0.0), 1.0)
        total += numpy.array(move["by"]) * over * over * (3 - 2 * over)
    return total


def measured_rows(scene, rows):
    """Returns the measured rows of an array with three rows per body."""
    bodies, axes = scene["measured"]
    return numpy.array(rows)[[3 * body + axis for body in bodies for axis in axes]]
