"""Initial states of tosses, fitted to the flight before the first contact, without a model of contact.

In flight the cube follows a parabola, and its angular velocity is constant because all its moments of inertia are equal. The initial state
is fitted to the flight by weighted least squares, with the standard deviations of the measurements below.
"""

import numpy as np
from cube_engines import EDGE, FRAME_RATE, rotated

GAP = 4e-3  # m, smallest height of a corner in flight
FEWEST = 4  # smallest number of frames of a flight to which a state is fitted
APPARENT_GRAVITY = -9.61  # m/s², the median of the measured accelerations in flight
POSITION, ROTATION, VELOCITY, SPIN = 1e-3, 0.01, 0.03, 0.1  # m, rad, m/s, rad/s: standard deviations of the measurements
CORNERS = EDGE / 2 * np.stack(np.meshgrid([-1, 1], [-1, 1], [-1, 1]), axis=-1).reshape(-1, 3)


def improved_start(toss):
    """Returns the initial state of a toss that fits its flight. A toss with a short flight keeps its measured initial state."""
    start = toss[0].copy()
    start[:4] /= np.linalg.norm(start[:4])
    frames = flight(toss)
    if len(frames) >= FEWEST:
        times = np.arange(len(frames)) / FRAME_RATE
        move_along_parabola(start, frames, times)
        turn_steadily(start, frames, times)
    return start


def flight(toss):
    """Returns the frames before the lowest corner first comes closer to the table than the gap."""
    heights = [min(frame[6] + rotated(frame[:4], corner)[2] for corner in CORNERS) for frame in toss]
    return toss[: next((index for index, height in enumerate(heights) if height < GAP), len(toss))]


def move_along_parabola(start, frames, times):
    """Fits the position and the velocity of the start."""
    fall = APPARENT_GRAVITY * times**2 / 2
    matrix = np.stack([np.ones_like(times), times], axis=1) / POSITION
    matrix = np.vstack([matrix, [0.0, 1 / VELOCITY]])
    for axis in range(3):
        path = start[4 + axis] + start[10 + axis] * times + (fall if axis == 2 else 0.0)
        deviations = np.append((frames[:, 4 + axis] - path) / POSITION, 0.0)
        change = np.linalg.lstsq(matrix, deviations, rcond=None)[0]
        start[[4 + axis, 10 + axis]] += change


def turn_steadily(start, frames, times):
    """Fits the orientation and the angular velocity of the start by the Gauss–Newton method."""
    measured_spin = start[7:10].copy()
    for _ in range(5):
        # The unknowns are a rotation before the motion and a change of the angular velocity, both in body axes of the start.
        deviations, rows = [], []
        for time, frame in zip(times, frames):
            turn = start[7:10] * time
            predicted = product(start[:4], quaternion(turn))
            deviations.append(vector(product(conjugate(predicted), frame[:4])) / ROTATION)
            rows.append(np.hstack([rotation(turn).T, time * right_jacobian(turn)]) / ROTATION)
        deviations.append((measured_spin - start[7:10]) / SPIN)
        rows.append(np.hstack([np.zeros((3, 3)), np.eye(3)]) / SPIN)
        change = np.linalg.lstsq(np.vstack(rows), np.concatenate(deviations), rcond=None)[0]
        start[:4] = product(start[:4], quaternion(change[:3]))
        start[7:10] += change[3:]


def rotation(turn):
    """Returns the rotation matrix of a rotation vector."""
    return np.stack([rotated(quaternion(turn), axis) for axis in np.eye(3)], axis=1)


def right_jacobian(turn):
    """Returns the right Jacobian of SO(3): the derivative of a rotation with respect to its rotation vector, in the rotated axes."""
    angle, skew = np.linalg.norm(turn), np.cross(np.eye(3), turn)
    if angle < 1e-6:
        return np.eye(3) - skew / 2
    return np.eye(3) - (1 - np.cos(angle)) / angle**2 * skew + (angle - np.sin(angle)) / angle**3 * skew @ skew


def product(first, second):
    """Returns the product of two quaternions."""
    scalar = first[0] * second[0] - first[1:] @ second[1:]
    return np.array([scalar, *(first[0] * second[1:] + second[0] * first[1:] + np.cross(first[1:], second[1:]))])


def conjugate(quaternion):
    return quaternion * [1, -1, -1, -1]


def quaternion(turn):
    """Returns the unit quaternion of a rotation vector."""
    half = np.linalg.norm(turn) / 2
    return np.array([np.cos(half), *(turn / 2 * np.sinc(half / np.pi))])


def vector(unit):
    """Returns the rotation vector of a unit quaternion."""
    unit = unit * np.copysign(1.0, unit[0])
    sine = np.linalg.norm(unit[1:])
    return 2 * unit[1:] if sine < 1e-9 else 2 * np.arctan2(sine, unit[0]) / sine * unit[1:]
