"""Vector environment of Gymnasium: many copies of a world, which step together on all cores.

    import gymnasium, numpy as np, hydroelastic as he, hydroelastic.gymnasium as hg
    skin = he.Material(1e6, dissipation=5.0, friction=0.4)
    block = he.Body.dynamic("block", he.Shape.cuboid([0.1, 0.1, 0.06]), skin, 0.5, pose=he.pose([0.0, 0.0, 0.03]))
    table = he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    push = he.Control("block", 1e6, np.zeros((1, 6)))  # one interval, which is longer than any episode
    world = he.World([block, table], gravity=-9.81, controls=[push])
    environment = hg.WorldVectorEnv(
        world, he.Plan(0.02, 1, he.Integrator.IMPLICIT_EULER), 1000,
        actions=[he.Parameter.control("block", 0)],
        action_space=gymnasium.spaces.Box(-1.0, 1.0, (2,)),
        values=lambda actions: np.pad(5.0 * actions, ((0, 0), (3, 1))),  # a horizontal force (N)
        observation_space=gymnasium.spaces.Box(-np.inf, np.inf, (2,)),
        observe=lambda states: states.poses[:, 0, :2, 3],
        reward=lambda before, actions, after: -np.linalg.norm(after.poses[:, 0, :2, 3] - [0.3, 0.0], axis=-1),
        max_steps=100,
    )
    observations, _ = environment.reset(seed=1)
    observations, rewards, terminations, truncations, infos = environment.step(environment.action_space.sample())

The functions that define the task receive the ``States`` of all environments at once, whose attributes are arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError as error:
    raise ImportError('hydroelastic.gymnasium needs Gymnasium: pip install "hydroelastic[gymnasium]"') from error

from ._checks import check_class, check_count
from ._core import Batch, HydroelasticError, Parameter, Plan, States, World

__all__ = ["WorldVectorEnv"]

_Array: TypeAlias = "np.ndarray[Any, np.dtype[Any]]"


class WorldVectorEnv(VectorEnv[Any, _Array, _Array]):
    """Vector environment of n copies of a world.

    A step sets parameters of each copy from its action, and runs the plan from the current state of the copy. Environments reset
    in the step after an episode ends (``AutoresetMode.NEXT_STEP``). That step ignores the action, and its reward is 0.

    If the simulation of a copy ends early, the episode of the copy is truncated at its last state, ``infos["error"]`` has the error, and
    ``infos["_error"]`` is True for this copy.

    Parameters
    ----------
    world : World
        World that is copied. Its initial state is the default start of an episode.
    plan : Plan
        Time steps of one step of an environment.
    num_envs : int
        Number n of copies.
    actions : sequence of Parameter
        Parameters that actions set, with p components in total, for example the wrench of a control with one long interval.
    action_space : gymnasium.Space
        Actions of one environment.
    observation_space : gymnasium.Space
        Observations of one environment.
    observe : function
        Function of States that returns observations (n, ...).
    reward : function
        Function of the States before a step, the actions, and the States after the step. It returns rewards (n,).
    values : function, optional
        Function of actions that returns values (n, p) of the parameters. By default, the values are the actions.
    start : function, optional
        Function of a NumPy random generator and the default States. It returns the States at the start of episodes. Default: the default
        States.
    terminated : function, optional
        Function of States that returns booleans (n,). They are True if the episode has ended in a terminal state. Default: always False.
    max_steps : int, optional
        Number of steps after which an episode is truncated. Default: no limit.

    Raises
    ------
    HydroelasticError
        If a number is not positive, or a parameter of the actions does not belong to the world.
    TypeError
        If an argument has an unexpected type.
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        world: World,
        plan: Plan,
        num_envs: int,
        *,
        actions: Sequence[Parameter],
        action_space: gymnasium.Space[Any],
        observation_space: gymnasium.Space[Any],
        observe: Callable[[States], Any],
        reward: Callable[[States, Any, States], Any],
        values: Callable[[Any], Any] | None = None,
        start: Callable[[np.random.Generator, States], States] | None = None,
        terminated: Callable[[States], Any] | None = None,
        max_steps: int | None = None,
    ) -> None:
        check_class(world, World, "world")
        world.values(actions)  # This raises an error if a parameter does not belong to the world.
        functions = {"observe": observe, "reward": reward, "values": values, "start": start, "terminated": terminated}
        for name, function in functions.items():
            if not callable(function) and (function is not None or name in ("observe", "reward")):
                raise TypeError(f"{name} must be a function, but is {type(function).__name__}")
        self.num_envs = num_envs = check_count(num_envs, "num_envs", 1)
        if max_steps is not None:
            max_steps = check_count(max_steps, "max_steps", 1)
        self.single_action_space, self.single_observation_space = action_space, observation_space
        self.action_space, self.observation_space = (batch_space(space, num_envs) for space in (action_space, observation_space))
        self._world, self._batch, self._parameters = world, Batch(plan), list(actions)
        self._observe, self._reward, self._values = observe, reward, values
        self._start, self._terminated, self._max_steps = start, terminated, max_steps
        self._default = States([world.initial_state] * num_envs)
        self.states = self._default
        self._steps = np.zeros(num_envs, dtype=int)
        self._ended = np.zeros(num_envs, dtype=bool)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Starts an episode in every environment.

        Parameters
        ----------
        seed : int, optional
            Seed of the random generator.
        options : dict, optional
            Not used.

        Returns
        -------
        observations : (n, ...) array_like
            Observations of the starts.
        infos : dict
            Empty.
        """
        super().reset(seed=seed, options=options)
        self.states = self._starts()
        self._steps[:] = 0
        self._ended[:] = False
        return self._observe(self.states), {}

    def step(self, actions: _Array) -> tuple[Any, _Array, _Array, _Array, dict[str, Any]]:
        """Steps every environment, or resets it if its episode has ended.

        Parameters
        ----------
        actions : (n, ...) array_like
            Actions.

        Returns
        -------
        observations : (n, ...) array_like
            Observations after the step.
        rewards : (n,) ndarray of float64
            Rewards.
        terminations : (n,) ndarray of bool
            True if the episode has ended in a terminal state.
        truncations : (n,) ndarray of bool
            True if the episode has reached its number of steps, or its simulation has ended early.
        infos : dict
            Errors, if there are any.
        """
        resets = self._ended
        before = self.states.replace_where(resets.tolist(), self._starts()) if resets.any() else self.states
        values = actions if self._values is None else self._values(actions)
        # Lists are not converted here, because errors of Batch.advance describe them better.
        values = values if isinstance(values, list | tuple) else np.asarray(values)
        after, errors = self._batch.advance(self._world, before, self._parameters, values)
        if resets.any():
            after = after.replace_where(resets.tolist(), before)
        failed = np.isin(np.arange(self.num_envs), list(errors)) & ~resets
        self._steps = np.where(resets, 0, self._steps + 1)
        terminations = np.zeros(self.num_envs, dtype=bool)
        if self._terminated is not None:
            terminations = self._of_rows("terminated", self._terminated(after)).astype(bool) & ~resets
        truncations = failed if self._max_steps is None else failed | (self._steps >= self._max_steps)
        rewards = np.where(resets, 0.0, self._of_rows("reward", self._reward(before, actions, after)))
        self.states, self._ended = after, terminations | truncations
        infos: dict[str, Any] = {}
        if failed.any():
            infos = {"error": np.array([errors.get(row) for row in range(self.num_envs)]), "_error": failed}
        return self._observe(after), rewards, terminations, truncations, infos

    def _starts(self) -> States:
        """Returns the states at the start of episodes."""
        if self._start is None:
            return self._default
        states = self._start(self.np_random, self._default)
        check_class(states, States, "the result of start")
        if states.poses.shape != self._default.poses.shape:
            (count, bodies), (found, found_bodies) = self._default.poses.shape[:2], states.poses.shape[:2]
            raise HydroelasticError(
                f"start must return {count} states of {bodies} bodies, but returned {found} of {found_bodies} bodies"
            )
        return states

    def _of_rows(self, name: str, result: Any) -> _Array:
        """Checks that a function returned a number for each environment."""
        array = np.asarray(result)
        if array.dtype.kind not in "biuf":
            raise TypeError(f"{name} must return numbers, but returned {array.dtype}")
        if array.shape != (self.num_envs,):
            raise HydroelasticError(f"{name} must return an array of the shape ({self.num_envs},), but returned {array.shape}")
        return array
