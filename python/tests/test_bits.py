"""Values have the same bits as the library, on every platform: data/reference_bits.json is the output of
examples/reference_bits.rs.

NumPy's matrix products and powers have other bits on other processors, so no tested number depends on them.
"""

import json
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

# Round-off of a derivative with respect to a rotation that is passed to vjp as derivatives with respect to a matrix.
TURN_AS_MATRIX = 1e-13

REFERENCE = json.loads((Path(__file__).parent / "data" / "reference_bits.json").read_text())


def assert_same(name, actual, rounding=0.0):
    bits = np.array([int(number, 16) for number in REFERENCE[name]], dtype=np.uint64)
    actual = np.ascontiguousarray(actual, dtype=np.float64).ravel()
    assert actual.size == bits.size > 0
    expected = bits.view(np.float64)
    if rounding > 0.0:
        assert np.abs(actual - expected).max() <= rounding * np.abs(expected).max()
    else:
        assert np.array_equal(actual.view(np.uint64), bits), np.abs(actual - expected).max()


def test_contacts(ball_on_block, twists):
    pair, pose_a, pose_b = ball_on_block
    assert_same("wrench", pair.wrench(pose_a, pose_b))
    wrench, jacobian = pair.wrench_and_jacobian(pose_a, pose_b)
    assert wrench.shape == (12,) and jacobian.shape == (12, 14)
    assert_same("jacobian", jacobian)
    assert_same("wrench in motion", pair.wrench(pose_a, pose_b, *twists))
    wrench, jacobian = pair.linearized(pose_a, pose_b, *twists)
    assert wrench.shape == (12,) and jacobian.shape == (12, 28)
    assert_same("linearized wrench", wrench)
    assert_same("linearized jacobian", jacobian)
    assert_same("energy", pair.potential_energy(pose_a, pose_b))
    gradients = pair.shape_gradients(pose_a, pose_b, np.ldexp(1.0, -np.arange(12)), *twists)
    for gradient, name in zip(gradients, "AB"):
        assert_same(f"by vertices of {name}", gradient.by_vertices)
        assert_same(f"by extents of {name}", gradient.by_extents)


def test_contact_surface(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    surface = pair.surface(pose_a, pose_b)
    assert_same("area", surface.area)
    assert_same("corners", surface.vertices)
    assert_same("pressures", surface.pressures)
    assert len(surface) == len(surface.areas) == len(surface.offsets) - 1
    force = (surface.normals * (surface.mean_pressures * surface.areas)[:, None]).sum(axis=0)
    assert np.allclose(force, pair.wrench(pose_a, pose_b)[3:6], rtol=1e-12, atol=1e-12)
    assert np.allclose(surface.areas.sum(), surface.area, rtol=1e-14)


@pytest.mark.parametrize(
    ("name", "partner", "modulus", "height"),
    [
        ("half-space", he.HalfSpace(), None, 0.1),
        ("layer", he.HalfSpace(0.05), 1e6, 0.1),
        ("rigid block", he.RigidShape.around(he.Shape.cuboid([0.4, 0.4, 0.2])), None, 0.0),
    ],
)
def test_partners(ball_on_block, twists, name, partner, modulus, height):
    ball, pose_a, _ = ball_on_block
    pair = he.Pair(ball.shapes[0], partner, 1e5, modulus, ball.law)
    pose_b = he.pose([0.0, 0.0, height], [0.02, -0.03, 0.01])
    assert_same(name, pair.wrench(pose_a, pose_b))
    wrench, jacobian = pair.linearized(pose_a, pose_b, *twists)
    assert wrench.shape == (12,) and jacobian.shape == (12, 28)
    assert_same(f"{name} jacobian", jacobian)
    assert_same(f"{name} energy", pair.potential_energy(pose_a, pose_b))


def test_rigid_world(rigid_world):
    assert_same("rigid world", numbers(rigid_world.rollout(SDIRK3).run()))


def numbers(trajectory):
    rotations = trajectory.poses[..., :3, :3].reshape(*trajectory.poses.shape[:2], 9)
    return np.concatenate([rotations, trajectory.poses[..., :3, 3], trajectory.twists], axis=-1)


EXPLICIT = he.Plan(2e-4, 900, record_every=300)
EULER = he.Plan(2e-4, 900, he.Integrator.SYMPLECTIC_EULER, record_every=300)
SDIRK3 = he.Plan(5e-3, 40, he.Integrator.SDIRK3, record_every=20)
IMPLICIT = he.Plan(5e-3, 40, he.Integrator.IMPLICIT_EULER, record_every=20)


@pytest.mark.parametrize(
    ("name", "plan"),
    [("leapfrog", EXPLICIT), ("symplectic Euler", EULER), ("sdirk3", SDIRK3), ("implicit Euler", IMPLICIT)],
)
def test_rollouts(scene, name, plan):
    assert_same(name, numbers(scene.rollout(plan).run()))


def test_rollouts_with_forces_and_controls(driven):
    assert_same("forces, leapfrog", numbers(driven.rollout(EXPLICIT).run()))
    assert_same("forces, sdirk3", numbers(driven.rollout(SDIRK3).run()))


def test_jacobians(driven):
    by = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball"), he.Parameter.control("ball", 1)]
    trajectory, jacobian = driven.jacobian(he.Plan(5e-4, 300, record_every=300), by)
    # The library's FinalState has the position, the columns of the rotation, the velocity and the angular velocity.
    def end(poses, twists):
        columns = np.swapaxes(poses[:3, :3], 0, 1).reshape(9, *poses.shape[2:])
        return np.concatenate([poses[:3, 3], columns, twists[3:], twists[:3]])

    assert_same("end", end(trajectory.poses[-1, 0], trajectory.twists[-1, 0]))
    assert_same("end jacobian", end(jacobian.poses[-1, 0], jacobian.twists[-1, 0]))
    # Half the cross product matrix times the rotation has the given derivatives with respect to a rotation of the body.
    x, y, z = 0.5 * np.array([0.1, 0.2, 0.3])
    by_poses, by_twists = np.zeros((2, 3, 4, 4)), np.zeros((2, 3, 6))
    by_poses[1, 0, :3, :3] = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ trajectory.poses[-1, 0, :3, :3]
    by_poses[1, 0, :3, 3] = [1.0, -2.0, 3.0]
    by_twists[1, 0] = [0.01, 0.02, -0.03, -0.1, 0.4, 0.2]
    _, vjp = driven.vjp(he.Plan(5e-4, 300, record_every=300), by)
    actual = vjp(by_poses, by_twists)
    assert_same("pullback", actual, rounding=TURN_AS_MATRIX)
    _, a, b = driven.linearize(he.Plan(1e-3, 100), by)
    assert a.shape == (24, 24) and b.shape == (24, 10)
    assert_same("A", a)
    assert_same("B", b)
