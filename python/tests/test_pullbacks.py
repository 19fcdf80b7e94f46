"""Gradients of rollouts in reverse mode, compared with the Jacobian of the same steps."""

import pickle

import numpy as np
import pytest

import hydroelastic as he

# Round-off of derivatives over hundreds of steps, relative to the largest derivative with respect to a parameter.
SAME = 1e-10

PLAN = he.Plan(2e-4, 900, record_every=250)


def everything(world):
    """Parameters of all kinds in the driven scene."""
    p = he.Parameter
    starts = (p.initial_position, p.initial_orientation, p.initial_velocity, p.initial_angular_velocity, p.mass)
    skins = (p.modulus, p.dissipation, p.friction)
    by = [kind(name) for name in ("ball", "brick") for kind in starts]
    by += [kind(name) for name in world.names for kind in skins]
    return [*by, p.initial_position("floor"), p.gravity(), *p.controls(["ball"], 3)]


def covectors(trajectory, seed=1):
    random = np.random.default_rng(seed)
    return [random.uniform(-1.0, 1.0, array.shape) for array in (trajectory.poses, trajectory.twists)]


def product(by_poses, by_twists, jacobian):
    return np.tensordot(by_poses, jacobian.poses, 4) + np.tensordot(by_twists, jacobian.twists, 3)


def assert_same(actual, expected, by):
    assert actual.shape == expected.shape
    ends = np.cumsum([parameter.dimension for parameter in by])
    for parameter, one, other in zip(by, np.split(actual, ends), np.split(expected, ends)):
        assert np.abs(other).max() > 0.0, parameter
        assert np.abs(one - other).max() <= SAME * np.abs(other).max(), parameter


@pytest.mark.parametrize(
    "plan",
    [
        PLAN,
        he.Plan(2e-4, 900, he.Integrator.SYMPLECTIC_EULER, record_every=250),
        he.Plan(5e-3, 36, he.Integrator.SDIRK3, record_every=10, solver_tolerance=1e-13),
    ],
)
def test_a_pullback_is_a_product_with_the_jacobian(driven, plan):
    by = everything(driven)
    trajectory, jacobian = driven.jacobian(plan, by)
    assert len(trajectory) == 5
    recorded, vjp = driven.vjp(plan, by)
    assert np.array_equal(recorded.poses, driven.rollout(plan).run().poses)
    for seed in range(2):
        by_states = covectors(trajectory, seed)
        assert_same(vjp(*by_states), product(*by_states, jacobian), by)


@pytest.mark.parametrize("integrator", [he.Integrator.LEAPFROG, he.Integrator.SDIRK3])
def test_steps_that_do_not_go_into_memory_are_taken_again_with_the_same_bits(driven, integrator):
    plan = he.Plan(1e-3, 100, integrator)
    by = everything(driven)
    by_states = covectors(driven.rollout(plan).run())
    expected = driven.vjp(plan, by)[1](*by_states)
    for memory in (0, 30_000):
        _, vjp = driven.vjp(plan, by, memory=memory)
        assert np.array_equal(vjp(*by_states), expected)


def test_kinks_on_the_way_are_told():
    skin = he.Material(1e5)
    block = he.Shape.cuboid([0.2, 0.15, 0.1])
    within = he.World([he.Body.dynamic("body", block, skin, mass=1.0), he.Body.fixed("block", block, skin)])
    plan = he.Plan(1e-4, 5)
    kinks = {kink.kind: kink for kink in within.kinks(plan)}
    assert kinks["equal fields"] == he.Kink("equal fields", ["body", "block"], steps=5, first_step=1, last_step=5)
    alone = he.World([he.Body.dynamic("body", block, skin, mass=1.0)])
    assert alone.kinks(plan) == []


def test_worlds_of_a_batch_have_the_bits_of_each(driven):
    by = everything(driven)
    worlds = [driven.perturbed([he.Parameter.friction("ball")], [change]) for change in (0.0, 0.1, -0.1)]
    trajectory = driven.rollout(PLAN).run()
    by_poses, by_twists = (np.stack(arrays) for arrays in zip(*(covectors(trajectory, seed) for seed in range(3))))
    actual = he.Batch(PLAN).vjps(worlds, by, by_poses, by_twists)
    for world, one, *by_states in zip(worlds, actual, by_poses, by_twists):
        assert np.array_equal(one, world.vjp(PLAN, by)[1](*by_states))
    assert not np.array_equal(actual[0], actual[1])


@pytest.mark.parametrize(
    "integrator, most",
    [
        (he.Integrator.LEAPFROG, 12),
        (he.Integrator.SYMPLECTIC_EULER, 12),
        (he.Integrator.SDIRK3, 96),
        (he.Integrator.IMPLICIT_EULER, 96),
    ],
)
def test_reverse_mode_begins_at_as_many_numbers_as_in_the_library(driven, integrator, most):
    # tests/gradient/trajectory_gradients.rs has the same numbers.
    plan, by = he.Plan(1e-3, 2, integrator), [he.Parameter.mass("ball")]
    assert not driven._sweeps_back(plan, by * most)
    assert driven._sweeps_back(plan, by * (most + 1))
    # Two reverse sweeps take about as long as a rollout with 96 derivatives.
    assert driven._sweeps_back(plan, by * 97, 4) and not driven._sweeps_back(plan, by * 97, 5)


def test_controls_of_bodies_over_time_are_an_array():
    by = he.Parameter.controls(["a", "b"], 3)
    assert [repr(parameter) for parameter in by[:3]] == [
        'Parameter.control("a", 0)',
        'Parameter.control("b", 0)',
        'Parameter.control("a", 1)',
    ]
    assert sum(parameter.dimension for parameter in by) == 3 * 2 * 6


def test_what_does_not_fit_is_refused(driven):
    by = [he.Parameter.gravity()]
    poses, twists = np.zeros((5, 3, 4, 4)), np.zeros((5, 3, 6))
    _, vjp = driven.vjp(PLAN, by)
    assert np.array_equal(vjp(poses, twists), np.zeros(3))
    with pytest.raises(he.HydroelasticError, match=r"by_poses must have the shape \(5, 3, 4, 4\), but has \(4, 3, 4, 4\)"):
        vjp(poses[1:], twists)
    with pytest.raises(he.HydroelasticError, match=r"by_twists must have the shape \(5, 3, 6\)"):
        vjp(poses, twists[0])
    with pytest.raises(he.HydroelasticError, match="nobody"):
        driven.vjp(PLAN, [he.Parameter.friction("nobody")])
    twists[2, 1, 4] = np.nan
    with pytest.raises(he.HydroelasticError, match='state of body "brick" before step 501 is not finite'):
        vjp(poses, twists)
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(vjp)
    long = he.Plan(0.1, 20)
    (actual,) = he.Batch(long).vjps([driven], by, np.zeros((1, 21, 3, 4, 4)), np.zeros((1, 21, 3, 6)))
    assert isinstance(actual, he.RolloutError)
