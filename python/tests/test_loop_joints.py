"""Loop joints: motion, derivatives, copies and errors."""

import copy
import pickle

import numpy as np
import pytest

import hydroelastic as he

AXIS = [0.0, 1.0, 0.0]
CRANK, ROD = 0.1, 0.3
# Round-off of reverse mode, relative to the largest derivative.
SAME = 1e-9


def pin(first="rod", second="slider", offset=0.0):
    return he.LoopJoint.revolute("pin", AXIS, (first, he.pose([ROD, 0.0, offset])), (second, np.eye(4)))


def parts():
    """A crank that points upward, and a rod from its end to a slider on the x axis."""
    incline = np.arcsin(CRANK / ROD)
    joints = {
        "crank": he.Joint.revolute("drive", AXIS, position=-np.pi / 2, torque=0.2),
        "rod": he.Joint.revolute("knee", AXIS, parent="crank", origin=he.pose([CRANK, 0.0, 0.0]), position=incline + np.pi / 2),
        "slider": he.Joint.prismatic("slide", [1.0, 0.0, 0.0], position=ROD * np.cos(incline)),
    }
    inertia = 1e-3 * np.eye(3)
    return [he.Body.dynamic(name, None, mass=1.0, inertia=inertia, joint=joint) for name, joint in joints.items()]


@pytest.fixture(scope="module")
def engine():
    return he.World(parts(), loop_joints=[pin()])


PLAN = he.Plan(5e-3, 40, he.Integrator.SDIRK3)


def test_a_slider_crank_stays_closed(engine):
    angles, _, shifts = engine.rollout(PLAN).run().joint_positions.T
    exact = CRANK * np.cos(angles) + np.sqrt(ROD**2 - (CRANK * np.sin(angles)) ** 2)
    assert np.abs(shifts - exact).max() < 1e-5
    assert shifts[-1] > shifts[0] + 0.01


def test_both_modes_agree(engine):
    torque = [he.Parameter.joint("drive", "torque"), he.Parameter.mass("slider")]
    trajectory, jacobian = engine.jacobian(PLAN, torque)
    weights = np.zeros_like(trajectory.joint_positions)
    weights[-1] = [1.0, -0.5, 2.0]
    expected = weights[-1] @ jacobian.joint_positions[-1]
    _, vjp = engine.vjp(PLAN, torque)
    found = vjp(np.zeros_like(trajectory.poses), np.zeros_like(trajectory.twists), by_joint_positions=weights)
    assert np.abs(found - expected).max() < SAME * np.abs(expected).max()


def test_copies_keep_loop_joints(engine):
    for copied in (copy.deepcopy(engine), pickle.loads(pickle.dumps(engine))):
        (joint,) = copied.loop_joints
        assert (joint.name, joint.kind, joint.bodies) == ("pin", "revolute", ("rod", "slider"))
        assert np.array_equal(copied.rollout(PLAN).run().joint_positions, engine.rollout(PLAN).run().joint_positions)
    joint = pickle.loads(pickle.dumps(pin()))
    assert np.array_equal(joint.axis, AXIS) and np.array_equal(joint.frames, pin().frames)
    assert repr(joint) == 'LoopJoint.revolute("pin", between "rod" and "slider")'
    assert he.LoopJoint.ball("hook", ("a", np.eye(4)), ("b", np.eye(4))).axis is None


def test_open_loops_and_unknown_bodies_are_refused():
    with pytest.raises(he.HydroelasticError, match='the frames of loop joint "pin" are 2.0e-3 m'):
        he.World(parts(), loop_joints=[pin(offset=2e-3)])
    with pytest.raises(he.HydroelasticError, match='"piston"'):
        he.World(parts(), loop_joints=[pin(second="piston")])
    with pytest.raises(he.HydroelasticError, match="at least one of which is dynamic"):
        he.World(parts(), loop_joints=[pin(second="rod")])
    with pytest.raises(he.HydroelasticError, match="axis of a joint must not be zero"):
        he.LoopJoint.prismatic("pin", [0.0, 0.0, 0.0], ("a", np.eye(4)), ("b", np.eye(4)))
