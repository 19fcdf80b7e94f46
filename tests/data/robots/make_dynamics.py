"""Computes the dynamics of robots on a fixed base with Pinocchio, at random joint states, and writes them.

The states of mimicking joints follow their leaders, but the dynamics treat all joints as independent.

python make_dynamics.py OUTPUT.json FOLDER
"""

import json
import pathlib
import sys
import xml.etree.ElementTree as tree

import numpy
import pinocchio

KINDS = {"revolute", "continuous", "prismatic", "fixed"}


def random_states(robot, random):
    """Position, velocity and acceleration of each joint, by name."""
    states = {}
    for joint in robot.findall("joint"):
        if joint.get("type") not in KINDS:
            raise ValueError(f"joint type {joint.get('type')}")
        scale = 0.1 if joint.get("type") == "prismatic" else 1.0
        states[joint.get("name")] = numpy.round(random.uniform(-scale, scale, 3), 3).tolist()
    for joint in robot.findall("joint"):
        for mimic in joint.findall("mimic"):
            multiplier, offset = float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))
            position, velocity, acceleration = states[mimic.get("joint")]
            states[joint.get("name")] = [multiplier * position + offset, multiplier * velocity, multiplier * acceleration]
    return states


def quantities(path, random):
    robot = tree.parse(path).getroot()
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    states = random_states(robot, random)
    model = pinocchio.buildModelFromXML(tree.tostring(robot, encoding="unicode"))
    data = model.createData()
    names = list(model.names)[1:]
    q = pinocchio.neutral(model)
    for joint, name in zip(list(model.joints)[1:], names):
        angle = states[name][0]
        q[joint.idx_q : joint.idx_q + joint.nq] = [numpy.cos(angle), numpy.sin(angle)] if joint.nq == 2 else angle
    v, a = (numpy.array([states[name][index] for name in names]) for index in (1, 2))
    by_q, by_v, mass = (m.copy() for m in pinocchio.computeRNEADerivatives(model, data, q, v, a))
    mass = numpy.triu(mass) + numpy.triu(mass, 1).T
    return {
        "states": {name: states[name] for name in names},
        "joints": names,
        "mass_matrix": [row[: index + 1].tolist() for index, row in enumerate(mass)],
        "bias": pinocchio.nonLinearEffects(model, data, q, v).tolist(),
        "inverse_dynamics": pinocchio.rnea(model, data, q, v, a).tolist(),
        "by_positions": by_q.tolist(),
        "by_velocities": by_v.tolist(),
    }


def main(output, folder):
    folder = pathlib.Path(folder)
    robots = {}
    for path in sorted(folder.rglob("*.urdf")):
        try:
            robots[path.relative_to(folder).as_posix()] = quantities(path, numpy.random.default_rng(1))
        except Exception as error:
            print(f"{path}: {error}", file=sys.stderr)
    pathlib.Path(output).write_text(json.dumps(robots, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
