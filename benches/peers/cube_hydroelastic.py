"""This library for `cube.py`: a compliant cube on a rigid half-space."""

import hydroelastic as he
import numpy as np
from cube_engines import EDGE, FRAME_RATE, FRICTION, GRAVITY, HEIGHT, INERTIA, MASS, MOMENT, SCENE, Parameter, rotated

ACCURACY = he.Accuracy(0.05, 0.5)


class Hydroelastic:
    """A compliant cube. The parameters are the modulus, dissipation and friction."""

    variant, substeps = "sdirk3", 1

    def __init__(self, variant, substeps):
        self.variant, self.substeps = variant, substeps
        self.parameters = [FRICTION, *SCENE, Parameter("modulus (Pa)", 1e7, 1.0), Parameter("dissipation (s/m)", 10.0, 0.7)]

    def world(self, values):
        skin = he.Material(values["modulus (Pa)"], dissipation=values["dissipation (s/m)"], friction=values["friction"])
        inertia = values.get(INERTIA, MOMENT) * np.eye(3)
        shape, center = he.Shape.cuboid([EDGE] * 3), [0.0] * 3
        cube = he.Body.dynamic("cube", shape, skin, MASS, center_of_mass=center, inertia=inertia, pose=he.pose([0, 0, 1]))
        table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid(), pose=he.pose([0, 0, values[HEIGHT]]))
        return he.World([cube, table], gravity=values[GRAVITY])

    def rollouts(self, values, states, frame_counts):
        """Returns the poses of the frames after each initial state."""
        world, frames = self.world(values), max(frame_counts)
        plan = he.Plan(1 / (FRAME_RATE * self.substeps), frames * self.substeps, self.variant, record_every=self.substeps, accuracy=ACCURACY)
        paths = np.full((len(states), frames, 7), np.nan)
        starts = [start(world.initial_state, state) for state in states]
        for path, result in zip(paths, he.Batch(plan).rollouts_from(world, starts)):
            # The path of a failed rollout remains NaN.
            if isinstance(result, he.Trajectory):
                poses = result.poses[1:, 0]
                path[:, :4], path[:, 4:] = quaternions(poses[:, :3, :3]), poses[:, :3, 3]
        return paths


def start(initial, state):
    """Returns the initial state of the world, with the cube in the given state of 13 numbers."""
    unit = state[:4] / np.linalg.norm(state[:4])
    poses, twists = initial.poses, initial.twists
    poses[0, :3, :3] = np.stack([rotated(unit, axis) for axis in np.eye(3)], axis=1)
    poses[0, :3, 3] = state[4:7]
    twists[0] = [*rotated(unit, state[7:10]), *state[10:]]
    return he.State(0.0, poses, twists)


def quaternions(rotations):
    """Returns the unit quaternions (w, x, y, z) of rotation matrices, as eigenvectors of the largest eigenvalues of symmetric matrices."""
    matrices = np.zeros((len(rotations), 4, 4))
    trace = np.trace(rotations, axis1=1, axis2=2)
    symmetric = rotations + rotations.transpose(0, 2, 1)
    matrices[:, 0, 0] = trace
    matrices[:, 1:, 1:] = symmetric - trace[:, None, None] * np.eye(3)
    skew = rotations - rotations.transpose(0, 2, 1)
    matrices[:, 0, 1:] = matrices[:, 1:, 0] = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1)
    return np.linalg.eigh(matrices)[1][:, :, -1]
