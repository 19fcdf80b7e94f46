"""States of many worlds as arrays, and their steps in one call."""

import pickle

import numpy as np
import pytest

import hydroelastic as he

PLAN = he.Plan(0.02, 3, he.Integrator.IMPLICIT_EULER)
PUSH = [he.Parameter.control("block", 0)]


def world():
    skin = he.Material(1e6, dissipation=5.0, friction=0.4)
    block = he.Body.dynamic("block", he.Shape.cuboid([0.1, 0.1, 0.06]), skin, 0.5, pose=he.pose([0.0, 0.0, 0.03]))
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    push = he.Control("block", 1e6, np.zeros((1, 6)))
    return he.World([block, table], gravity=-9.81, controls=[push])


def arm():
    ball, skin = he.Shape.icosphere(0.1, 1), he.Material(1e5)
    hinge = he.Joint.revolute("hinge", [0.0, 0.0, 1.0])
    socket = he.Joint.ball("socket", parent="arm", origin=he.pose([0.3, 0.0, 0.0]))
    arm = he.Body.dynamic("arm", ball, skin, 1.0, joint=hinge)
    return he.World([arm, he.Body.dynamic("head", ball, skin, 1.0, joint=socket)], gravity=-9.81)


def assert_equal(states, expected):
    for name in ("times", "poses", "twists", "joint_positions", "joint_velocities", "ball_joint_rotations", "ball_joint_velocities"):
        assert np.array_equal(getattr(states, name), getattr(expected, name)), name


def pushes(count):
    values = np.zeros((count, 6))
    values[:, 3:5] = np.random.default_rng(1).normal(0.0, 3.0, (count, 2))
    return values


def test_many_worlds_step_to_the_same_bits_as_single_rollouts():
    template, values = world(), pushes(20)
    states = he.States([template.initial_state] * 20)
    for _ in range(2):
        expected = [template.with_values(PUSH, row).rollout(PLAN, start=state).run()[-1] for state, row in zip(states, values, strict=True)]
        states, errors = he.Batch(PLAN).advance(template, states, PUSH, values)
        assert not errors and len(states) == 20
        assert_equal(states, he.States(expected))
    assert np.allclose(states.times, 0.12) and np.ptp(states.poses[:, 0, 0, 3]) > 0.01


def test_worlds_step_without_parameters():
    template = arm()
    start = he.States([template.initial_state] * 2).replace(joint_velocities=[[0.5], [-0.5]])
    states, errors = he.Batch(PLAN).advance(template, start)
    assert not errors and states.joint_positions[0] > 0.0 > states.joint_positions[1]


def test_arrays_are_replaced_and_rows_selected():
    template = arm()
    states = he.States([template.initial_state] * 3)
    turned = np.array([he.pose(rotation_vector=[0.1 * row, 0.0, 0.0])[:3, :3] for row in range(3)])[:, None]
    changed = states.replace(
        times=[1.0, 2.0, 3.0],
        poses=states.poses,
        twists=states.twists + 1.0,
        joint_positions=[[0.1], [0.2], [0.3]],
        joint_velocities=np.ones((3, 1)),
        ball_joint_rotations=turned,
        ball_joint_velocities=np.ones((3, 1, 3)),
    )
    assert changed.times.tolist() == [1.0, 2.0, 3.0] and changed.joint_positions[:, 0].tolist() == [0.1, 0.2, 0.3]
    assert np.array_equal(changed.ball_joint_rotations, turned) and (changed.twists == 1.0).all()
    mixed = states.replace_where(np.array([False, True, False]), changed)
    assert mixed.times.tolist() == [0.0, 2.0, 0.0]
    assert mixed[-2].joints[0] == (0.2, 1.0) and repr(mixed) == "States(3 of 2 bodies)"
    assert_equal(pickle.loads(pickle.dumps(mixed)), mixed)


def test_errors_name_the_copy_and_keep_the_last_state():
    template = world()
    states = he.States([template.initial_state] * 3)
    inside = states.poses
    inside[1, 0, 2, 3] = -5.0  # Below the table, so that the block is pushed out at a great speed or sinks through.
    masses = [he.Parameter.mass("block")]
    after, errors = he.Batch(PLAN).advance(template, states.replace(poses=inside), masses, [[1.0], [-1.0], [1.0]])
    assert list(errors) == [1] and "the mass of body" in str(errors[1])
    assert after.times.tolist() == [PLAN.time_step * 3, 0.0, PLAN.time_step * 3] and after.poses[1, 0, 2, 3] == -5.0


def test_invalid_states_are_refused():
    template = world()
    states = he.States([template.initial_state] * 2)
    with pytest.raises(he.HydroelasticError, match="at least one"):
        he.States([])
    with pytest.raises(he.HydroelasticError, match="state 1, counted from 0, has other numbers"):
        he.States([template.initial_state, arm().initial_state])
    with pytest.raises(he.HydroelasticError, match=r"poses must have the shape \(2, 2, 4, 4\)"):
        states.replace(poses=np.eye(4))
    with pytest.raises(he.HydroelasticError, match="ball_joint_rotations"):
        he.States([arm().initial_state]).replace(ball_joint_rotations=np.ones((1, 1, 3, 3)))
    with pytest.raises(he.HydroelasticError, match="rows"):
        states.replace_where([True], states)
    with pytest.raises(IndexError):
        states[2]
    with pytest.raises(he.HydroelasticError, match=r"need values: give an array of the shape \(2, 6\)"):
        he.Batch(PLAN).advance(template, states, PUSH)
    with pytest.raises(he.HydroelasticError, match=r"values must have the shape \(2, 6\)"):
        he.Batch(PLAN).advance(template, states, PUSH, np.zeros((2, 5)))
    for perturbed in (he.Batch(PLAN).rollouts_perturbed, he.Batch(PLAN).jacobians_perturbed):
        with pytest.raises(he.HydroelasticError, match=r"samples must have the shape \(n, 6\), but has \(2, 5\)"):
            perturbed(template, PUSH, np.zeros((2, 5)))
    for call in (he.Batch(PLAN).rollouts_perturbed, he.Batch(PLAN).jacobians_perturbed, he.Batch(PLAN).advance):
        with pytest.raises(he.HydroelasticError, match='no body is named "brick"'):
            call(template, *[states] * (call.__name__ == "advance"), [he.Parameter.mass("brick")], np.ones((2, 1)))
    _, errors = he.Batch(PLAN).advance(arm(), states)
    assert sorted(errors) == [0, 1]
