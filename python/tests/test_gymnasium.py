"""Vector environment of Gymnasium."""

import importlib

import numpy as np
import pytest

import hydroelastic as he

gymnasium = pytest.importorskip("gymnasium")
soft = importlib.import_module("hydroelastic.gymnasium")
TARGET = np.array([0.3, 0.0])


def environment(count=4, **options):
    skin = he.Material(1e6, dissipation=5.0, friction=0.4)
    block = he.Body.dynamic("block", he.Shape.cuboid([0.1, 0.1, 0.06]), skin, 0.5, pose=he.pose([0.0, 0.0, 0.03]))
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    world = he.World([block, table], gravity=-9.81, controls=[he.Control("block", 1e6, np.zeros((1, 6)))])
    settings = {
        "actions": [he.Parameter.control("block", 0)],
        "action_space": gymnasium.spaces.Box(-1.0, 1.0, (2,)),
        "values": lambda actions: np.pad(5.0 * np.asarray(actions), ((0, 0), (3, 1))),
        "observation_space": gymnasium.spaces.Box(-np.inf, np.inf, (2,), dtype=np.float64),
        "observe": lambda states: states.poses[:, 0, :2, 3],
        "reward": lambda before, actions, after: -np.linalg.norm(after.poses[:, 0, :2, 3] - TARGET, axis=-1),
    }
    plan = he.Plan(0.02, 1, he.Integrator.IMPLICIT_EULER)
    return soft.WorldVectorEnv(world, plan, count, **settings | options)


def scattered(generator, states):
    poses = states.poses
    poses[:, 0, :2, 3] = generator.normal(0.0, 0.1, (len(states), 2))
    return states.replace(poses=poses)


def episode(seed, steps=8, **options):
    vector = environment(start=scattered, **options)
    observations, _ = vector.reset(seed=seed)
    vector.action_space.seed(seed)
    results = [(observations, *np.zeros((3, vector.num_envs)), {})]
    for _ in range(steps):
        results.append(vector.step(vector.action_space.sample()))
    assert all(result[0] in vector.observation_space for result in results)
    return [np.array(column) for column in zip(*[result[:4] for result in results], strict=True)]


def test_seeds_determine_episodes():
    first, second, other = (episode(seed) for seed in (1, 1, 2))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))
    assert not np.array_equal(first[0], other[0])
    observations, rewards, terminations, truncations = first
    assert np.allclose(rewards[1:], -np.linalg.norm(observations[1:] - TARGET, axis=-1))
    assert not terminations.any() and not truncations.any() and np.ptp(observations, axis=0).min() > 0.0


def test_an_episode_resets_in_the_step_after_its_end():
    observations, rewards, _, truncations = episode(1, max_steps=3)
    assert [step for step, truncated in enumerate(truncations) if truncated.all()] == [3, 7]
    assert (rewards[4] == 0.0).all() and (rewards[5] != 0.0).all()
    # The states in step 4 are new starts, far from the states before it.
    assert np.abs(observations[4] - observations[3]).max() > 0.01


def test_terminal_states_end_the_episodes_of_their_rows():
    vector = environment(terminated=lambda states: states.poses[:, 0, 0, 3] > 0.005)
    vector.reset()
    actions = np.array([[1.0, 0.0], [-1.0, 0.0]] * 2)
    ends = [vector.step(actions)[2].tolist() for _ in range(8)]
    assert [True, False, True, False] in ends and not any(row[1] or row[3] for row in ends)


def test_errors_of_the_simulation_truncate_their_rows():
    mass = [he.Parameter.mass("block")]
    vector = environment(actions=mass, values=lambda actions: actions)
    vector.reset()
    *_, truncations, infos = vector.step(np.array([[1.0], [-1.0], [1.0], [1.0]]))
    assert truncations.tolist() == infos["_error"].tolist() == [False, True, False, False]
    assert isinstance(infos["error"][1], he.HydroelasticError) and infos["error"][0] is None
    *_, truncations, infos = vector.step(np.ones((4, 1)))
    assert not truncations.any() and not infos


def test_results_of_other_shapes_are_refused():
    actions = np.zeros((4, 2))
    for name in ("reward", "terminated"):
        vector = environment(**{name: lambda *arguments: np.zeros((4, 1))})
        vector.reset()
        with pytest.raises(he.HydroelasticError, match=rf"{name} must return an array of the shape \(4,\)"):
            vector.step(actions)
    vector = environment(start=lambda generator, states: he.States([states[0]] * 3))
    with pytest.raises(he.HydroelasticError, match="start must return 4 states of 2 bodies, but returned 3 of 2 bodies"):
        vector.reset()


def test_results_of_other_types_are_refused():
    results = [("reward", np.array(["a"] * 4)), ("reward", np.zeros(4, complex)), ("terminated", np.array(["a"] * 4)), ("values", "a")]
    for name, result in [*results, ("values", np.zeros((4, 6), complex)), ("values", [[0.0], [0.0, 0.0]])]:
        vector = environment(**{name: lambda *arguments, result=result: result})
        vector.reset()
        with pytest.raises(TypeError, match=name):
            vector.step(np.zeros((4, 2)))
    with pytest.raises(TypeError, match="the result of start must be a States, but is list"):
        environment(start=lambda generator, states: list(states)).reset()


def test_arguments_of_other_types_are_refused():
    parameter = he.Parameter.control("block", 0)
    for name, value in {"observe": None, "reward": 1.0, "values": 1.0, "start": 1.0, "terminated": True, "actions": parameter}.items():
        with pytest.raises(TypeError, match=f"{name} must be a function|put it into a list"):
            environment(**{name: value})
    with pytest.raises(he.HydroelasticError, match='no body is named "brick"'):
        environment(actions=[he.Parameter.control("brick", 0)])


def test_counts_below_one_are_refused():
    for options in ({"count": 0}, {"max_steps": 0}):
        with pytest.raises(he.HydroelasticError, match="must be at least 1"):
            environment(**options)
