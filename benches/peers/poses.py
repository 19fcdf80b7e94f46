"""Generic poses for both programs: nine entries of the rotation, row by row, then the position (m)."""

import numpy

DIFFERENCE = 1e-6  # m and rad, to either side


def random_poses(generator, distance):
    """Returns the poses of two randomly rotated bodies whose centers are a distance apart in a random direction."""
    center = generator.normal(size=3)
    apart = generator.normal(size=3)
    apart *= distance / numpy.linalg.norm(apart)
    turns = [rotation(generator.normal(size=3) * 2.0) for _ in range(2)]
    return [pose_numbers(turns[0], center), pose_numbers(turns[1], center + apart)]


def pose_numbers(turn, origin):
    return [*turn.ravel().tolist(), *origin.tolist()]


def rotation(vector):
    """Returns the rotation of a rotation vector (rad)."""
    angle = numpy.linalg.norm(vector)
    x, y, z = vector / angle
    axis = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return numpy.eye(3) + numpy.sin(angle) * axis + (1 - numpy.cos(angle)) * axis @ axis


def neighbors(poses):
    """Returns the poses with each of twelve coordinates decreased, then increased, by the difference."""
    moved = []
    for body in range(2):
        turn, origin = numpy.reshape(poses[body][:9], (3, 3)), numpy.array(poses[body][9:])
        for column in range(6):
            for step in (-DIFFERENCE, DIFFERENCE):
                by = step * numpy.eye(3)[column % 3]
                now = (rotation(by) @ turn, origin) if column < 3 else (turn, origin + by)
                both = list(poses)
                both[body] = pose_numbers(*now)
                moved.append(both)
    return moved
