"""Computes the dynamics of random trees with Pinocchio, and writes them in the coordinates of this library.

The velocities of Pinocchio are v = P·u, with the velocities u of this library. P depends only on the rotations of ball joints and free
bodies. It also maps displacements. The generalized forces are τ = Pᵀ·τ_P, and the accelerations of Pinocchio are P·u̇ + Ṗ·u.

Links are numbered depth first. Otherwise Pinocchio returns wrong mass matrices and derivatives.

python make_reference.py trees.json
"""

import json
import pathlib
import sys

import numpy
import pinocchio

TREES = 200
LINK_COUNTS = [1, 1, 2, 2, 2, 3, 3, 4, 4, 8]
UNITS = numpy.eye(3)


def cross(vector):
    return pinocchio.skew(numpy.asarray(vector, float))


def random_link(random, index):
    def numbers(*shape, scale=1.0):
        return numpy.round(random.uniform(-scale, scale, shape), 2).tolist()

    kinds = ["revolute", "revolute", "revolute", "prismatic", "ball"] + ["free"] * (index == 0)
    kind = str(random.choice(kinds))
    size = {"free": 6, "ball": 3}.get(kind, 1)
    return {
        # The previous link or one of its ancestors, so that subtrees are contiguous.
        "parent": index - 1,
        "kind": kind,
        "axis": numbers(3),
        "origin_rotation": numbers(3, scale=2.0),
        "origin": numbers(3),
        "mass": round(random.uniform(0.5, 2.5), 2),
        "center_of_mass": numbers(3, scale=0.3),
        "inertia_rotation": numbers(3),
        "moments": numpy.round(random.uniform(0.11, 0.19, 3), 3).tolist(),
        "armature": 0.0 if kind == "free" else round(random.uniform(0.0, 1.0), 2),
        # Rotation vector; rotation vector and translation; or a number.
        "position": numbers(size),
        "velocity": numbers(size),
        "acceleration": numbers(size),
    }


def random_tree(random):
    links = []
    for index in range(random.choice(LINK_COUNTS)):
        link = random_link(random, index)
        for _ in range(random.choice([0, 0, 1, 2])):
            if link["parent"] > 0:
                link["parent"] = links[link["parent"]]["parent"]
        links.append(link)
    return {"gravity": numpy.round(random.uniform(-10, 10, 3), 1).tolist(), "links": links}


def joint_model(link):
    axis = numpy.array(link["axis"]) / numpy.linalg.norm(link["axis"])
    return {
        "revolute": lambda: pinocchio.JointModelRevoluteUnaligned(axis),
        "prismatic": lambda: pinocchio.JointModelPrismaticUnaligned(axis),
        "ball": pinocchio.JointModelSpherical,
        "free": pinocchio.JointModelFreeFlyer,
    }[link["kind"]]()


def model_of(tree):
    model = pinocchio.Model()
    model.gravity.linear = numpy.array(tree["gravity"])
    armature = []
    for index, link in enumerate(tree["links"]):
        origin = pinocchio.SE3(pinocchio.exp3(numpy.array(link["origin_rotation"])), numpy.array(link["origin"]))
        if link["kind"] == "free":
            origin = pinocchio.SE3.Identity()
        joint = model.addJoint(link["parent"] + 1, joint_model(link), origin, str(index))
        axes = pinocchio.exp3(numpy.array(link["inertia_rotation"]))
        tensor = axes @ numpy.diag(link["moments"]) @ axes.T
        inertia = pinocchio.Inertia(link["mass"], numpy.array(link["center_of_mass"]), tensor)
        model.appendBodyToJoint(joint, inertia, pinocchio.SE3.Identity())
        armature += [link["armature"]] * len(link["velocity"])
    model.armature = numpy.array(armature)
    return model


def joint_map(link, inverse, u):
    """P, Ṗ·u and its derivative with respect to u, which are linear in the inverse of the rotation."""
    if link["kind"] == "ball":
        return inverse.copy(), numpy.zeros(3), numpy.zeros((3, 3))
    spin, velocity = u[:3], u[3:]
    zero = numpy.zeros((3, 3))
    matrix = numpy.block([[cross(link["center_of_mass"]) @ inverse, inverse], [inverse, zero]])
    drift = numpy.concatenate([-inverse @ numpy.cross(spin, velocity), numpy.zeros(3)])
    slope = numpy.block([[inverse @ cross(velocity), -inverse @ cross(spin)], [zero, zero]])
    return matrix, drift, slope


class Map:
    """Matrices of all joints, and the derivatives of P and Ṗ·u with respect to displacements."""

    def __init__(self, links, u):
        size = len(u)
        self.matrix, self.drift, self.slope = numpy.eye(size), numpy.zeros(size), numpy.zeros((size, size))
        self.turned = []
        first = 0
        for link in links:
            width = len(link["velocity"])
            block = slice(first, first + width)
            if link["kind"] in ("ball", "free"):
                rotation = pinocchio.exp3(numpy.array(link["position"][:3]))
                values = joint_map(link, rotation.T, u[block])
                self.matrix[block, block], self.drift[block], self.slope[block, block] = values
                for k in range(3):
                    matrix, drift, _ = joint_map(link, -rotation.T @ cross(UNITS[k]), u[block])
                    self.turned.append((first + k, block, matrix, drift))
            first += width


def configuration(link):
    position = numpy.array(link["position"])
    if link["kind"] in ("revolute", "prismatic"):
        return position
    rotation = pinocchio.exp3(position[:3])
    quaternion = pinocchio.Quaternion(rotation).coeffs()
    return quaternion if link["kind"] == "ball" else numpy.concatenate([position[3:], quaternion])


def quantities(tree):
    links = tree["links"]
    model = model_of(tree)
    data = model.createData()
    q = numpy.concatenate([configuration(link) for link in links])
    u, acceleration = (numpy.concatenate([link[name] for link in links]) for name in ("velocity", "acceleration"))
    maps = Map(links, u)
    P = maps.matrix
    v, a = P @ u, P @ acceleration + maps.drift
    mass = pinocchio.crba(model, data, q)
    mass = numpy.triu(mass) + numpy.triu(mass, 1).T
    force = pinocchio.rnea(model, data, q, v, a).copy()
    bias = pinocchio.rnea(model, data, q, v, maps.drift).copy()
    by_q, by_v, by_a = (m.copy() for m in pinocchio.computeRNEADerivatives(model, data, q, v, a))
    by_a = numpy.triu(by_a) + numpy.triu(by_a, 1).T
    by_positions, by_velocities = P.T @ by_q @ P, P.T @ (by_v @ P + by_a @ maps.slope)
    for column, block, matrix, drift in maps.turned:
        by_positions[:, column] += P.T @ (by_v[:, block] @ (matrix @ u[block]))
        by_positions[:, column] += P.T @ (by_a[:, block] @ (matrix @ acceleration[block] + drift))
        by_positions[block, column] += matrix.T @ force[block]
    # Forces of the inverse dynamics minus the bias.
    applied = P.T @ force - P.T @ bias
    caused = pinocchio.aba(model, data, q, v, numpy.linalg.solve(P.T, applied))
    return {
        "mass_matrix": [row[: index + 1].tolist() for index, row in enumerate(P.T @ mass @ P)],
        "bias": (P.T @ bias).tolist(),
        "inverse_dynamics": (P.T @ force).tolist(),
        "forward_dynamics": numpy.linalg.solve(P, caused - maps.drift).tolist(),
        "by_positions": by_positions.tolist(),
        "by_velocities": by_velocities.tolist(),
    }


def main(output):
    random = numpy.random.default_rng(1)
    trees = [random_tree(random) for _ in range(TREES)]
    for tree in trees:
        tree.update(quantities(tree))
    lines = ",\n".join(json.dumps(tree, separators=(",", ":")) for tree in trees)
    pathlib.Path(output).write_text(f"[\n{lines}\n]\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
