"""Many rollouts on many machines: the interface of ``hydroelastic.Batch`` over a cluster of Ray.

    from hydroelastic.ray import Batch

    results = Batch(plan).jacobians_perturbed(world, parameters, samples)

Results are those of the local ``Batch``, in the same order and with the same bits, where the machines have the same build of
this package and the same mathematical library. ``docs/python/cluster.md`` says how to run it on a cluster.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _core, _progress
from ._core import HydroelasticError, Parameter, Plan, RolloutError, State, Trajectory, TrajectoryJacobian, World
from ._pin_checks import check_count

try:
    import ray  # type: ignore[import-not-found, unused-ignore]
    from ray import exceptions  # type: ignore[import-not-found, unused-ignore]
except ImportError as _error:
    raise ImportError('hydroelastic.ray needs Ray: pip install "hydroelastic[ray]"') from _error

__all__ = ["Batch"]

# One rollout has one thread; Ray runs as many tasks on a machine as it has cores.
_ENVIRONMENT = {"env_vars": {"RAYON_NUM_THREADS": "1"}}
# Parts for each core, so that cores that are free early find work, and how many rollouts a part has at most.
_PARTS_PER_CORE = 8
_LONGEST_PART = 32
# How many tasks are looked at together, since ray.wait takes longer for more.
_WINDOW = 256
# What remains of a task that the engine has tried for the last time.
_LOST = (
    exceptions.WorkerCrashedError,
    exceptions.NodeDiedError,
    exceptions.OutOfMemoryError,
    exceptions.ObjectLostError,
)


class _Sliced(Protocol):
    """What belongs to the results, one for each: a list, or the rows of an array."""

    def __len__(self) -> int: ...
    def __getitem__(self, places: slice, /) -> Any: ...


# What the parts of the batch that this worker works for have in common, by its bytes.
_HELD: dict[bytes, tuple[Any, ...]] = {}


def _loaded(common: bytes) -> tuple[Any, ...]:
    """What parts have in common, loaded once in each worker: for a world of 20,000 tetrahedra, that takes some 60 ms."""
    if common not in _HELD:
        _HELD.clear()
        _HELD[common] = pickle.loads(common)
    return _HELD[common]


def _results(version: str, plan: Plan, method: str, common: bytes, part: Any) -> list[Any]:
    """What the local batch gives for a part, on the machine where this runs."""
    if version != _core.__version__:
        raise RuntimeError(f"this worker has hydroelastic {_core.__version__}, but was sent work of {version}")
    function, shared = getattr(_core.Batch(plan), method), _loaded(common)
    # Worlds come before the parameters of their derivatives; all else that belongs to results comes last.
    return function(part, *shared) if method == "jacobians" else function(*shared, part)  # type: ignore[no-any-return]


class Batch:
    """Many independent rollouts by one plan, over a cluster of Ray. Methods and results are those of ``hydroelastic.Batch``:
    results come in the order of what they belong to, with the bits of rollouts one by one, and in the place of the result of
    one that fails is its exception.

    Worlds are sent once to each machine that needs them. Parts of the batch are tasks, which Ray runs again elsewhere where a
    worker or a machine is lost, with the same result. Where that happens too often, a RolloutError, whose cause is Ray's
    exception, is in the place of each result of the part.

    Parameters
    ----------
    plan : of each rollout.
    progress : True for a progress bar of tqdm, if that is installed; or a function of (done, total) rollouts.
    chunk : how many rollouts a task has; None for eight tasks for each core of the cluster, of 32 rollouts at most. Tasks of
        less than 50 ms spend more than a few percent of their time in Ray.
    max_retries : how often a task is begun again after a loss; -1 for without end.

    Where Ray has not been started, ``ray.init()`` starts it or finds the cluster. Ctrl-C, or an exception of the progress
    function, ends the batch: tasks that run end before their next step.

    Raises
    ------
    HydroelasticError if chunk or max_retries are out of range.
    ray.exceptions.RayError where the workers cannot run at all, such as without this package, or in another version.
    """

    def __init__(
        self,
        plan: Plan,
        *,
        progress: bool | Callable[[int, int], object] | None = None,
        chunk: int | None = None,
        max_retries: int = 5,
    ) -> None:
        if not isinstance(plan, Plan):
            raise TypeError(f"plan must be a Plan, but is {plan!r}")
        if chunk is not None:
            chunk = check_count(chunk, "chunk", 1)
        # -1 means no limit.
        max_retries = check_count(max_retries, "max_retries", -1)
        self._plan = plan
        self._progress = progress
        self._chunk = chunk
        self._max_retries = max_retries

    @property
    def plan(self) -> Plan:
        """The plan."""
        return self._plan

    def rollouts_from(self, world: World, states: Sequence[State]) -> list[Trajectory | RolloutError]:
        """The trajectory of a world from each of a list of states."""
        for state in states:
            world.rollout(self._plan, start=state)  # Refuses a state that does not fit the world.
        return self._over_the_cluster("rollouts_from", (world,), list(states))

    def rollouts(self, worlds: Sequence[World]) -> list[Trajectory | RolloutError]:
        """The trajectory of each of a list of worlds from its initial state."""
        _check_worlds(worlds)
        return self._over_the_cluster("rollouts", (), list(worlds))

    def rollouts_perturbed(
        self, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[Trajectory | HydroelasticError]:
        """The trajectory of a world after each of n changes of its parameters: samples (n, p) float64, as of World.perturbed."""
        return self._after("rollouts_perturbed", world, parameters, samples)

    def jacobians_perturbed(
        self, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[tuple[Trajectory, TrajectoryJacobian] | HydroelasticError]:
        """World.jacobian of a world after each of n changes of its parameters: samples (n, p) float64, as of World.perturbed.
        Each result is a Trajectory and its TrajectoryJacobian, or an exception."""
        return self._after("jacobians_perturbed", world, parameters, samples)

    def jacobians(
        self, worlds: Sequence[World], parameters: Sequence[Parameter]
    ) -> list[tuple[Trajectory, TrajectoryJacobian] | HydroelasticError]:
        """World.jacobian of each of a list of worlds, from its initial state: for many starts. Each result is a Trajectory and
        its TrajectoryJacobian, or an exception."""
        _check_worlds(worlds)
        _core.Batch(self._plan).jacobians([], parameters)
        return self._over_the_cluster("jacobians", (list(parameters),), list(worlds))

    def _after(
        self, method: str, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[Any]:
        """Either of the two methods above, whose arguments the local batch refuses here, as far as it does without running."""
        samples = np.asarray(samples) if isinstance(samples, list | tuple) else samples
        has_rows = isinstance(samples, np.ndarray) and samples.ndim == 2
        getattr(_core.Batch(self._plan), method)(world, parameters, samples[:0] if has_rows else samples)
        return self._over_the_cluster(method, (world, list(parameters)), samples)

    def _over_the_cluster(self, method: str, common: tuple[Any, ...], items: _Sliced) -> list[Any]:
        """The results of a method of the local batch for items, in parts; what the parts have in common is sent once."""
        progress = self._progress
        told = None if progress is None or progress is False else _progress.shown(progress, len(items))
        tasks: dict[ray.ObjectRef[Any], slice] = {}
        results: list[Any] = [None] * len(items)
        try:
            if len(items):
                tasks.update(self._tasks(method, common, items))
            done = 0
            for task in _as_they_end(list(tasks)):
                part = tasks.pop(task)
                count = len(results[part])
                results[part] = _result(task, count)
                done += count
                if told is not None:
                    told(done)
        finally:
            # What is left after Ctrl-C or an exception.
            for task in tasks:
                ray.cancel(task)
            if told is not None:
                told.close()
        return results

    def _tasks(self, method: str, common: tuple[Any, ...], items: _Sliced) -> dict[ray.ObjectRef[Any], slice]:
        """A task of Ray for each part of the items, and where its results belong."""
        if not ray.is_initialized():
            ray.init()
        length = self._chunk or _part_length(len(items))
        parts = [slice(first, min(first + length, len(items))) for first in range(0, len(items), length)]
        function = ray.remote(_results).options(
            name=f"hydroelastic {method}", num_cpus=1, max_retries=self._max_retries, runtime_env=_ENVIRONMENT
        )
        shared = ray.put(pickle.dumps(common))
        return {function.remote(_core.__version__, self._plan, method, shared, items[part]): part for part in parts}

    def __repr__(self) -> str:
        return f"hydroelastic.ray.Batch({self._plan!r})"


def _check_worlds(worlds: Sequence[World]) -> None:
    for world in worlds:
        if not isinstance(world, World):
            raise TypeError(f"worlds must be of World, but one is {world!r}")


def _part_length(count: int) -> int:
    """How many rollouts a task has, if the caller does not say."""
    resources: dict[str, float] = ray.cluster_resources()  # type: ignore[no-untyped-call, unused-ignore]
    cores = max(1, int(resources.get("CPU", 1)))
    return min(_LONGEST_PART, -(-count // (_PARTS_PER_CORE * cores)))


def _as_they_end(tasks: list[ray.ObjectRef[Any]]) -> Iterator[ray.ObjectRef[Any]]:
    """Tasks that were begun in this order, as they end."""
    while tasks:
        window, rest = tasks[:_WINDOW], tasks[_WINDOW:]
        ray.wait(window, num_returns=1)
        ended, others = ray.wait(window, num_returns=len(window), timeout=0)
        yield from ended
        tasks = others + rest


def _result(task: ray.ObjectRef[Any], count: int) -> list[Any]:
    """The results of a task that has ended, or an exception for each of them where the engine has lost it too often."""
    try:
        found: list[Any] = ray.get(task)
        return found
    except _LOST as lost:
        return [_lost(lost) for _ in range(count)]


def _lost(cause: Exception) -> RolloutError:
    error = RolloutError(f"the rollout was lost with its worker, more often than it is tried again: {cause}")
    error.__cause__ = cause
    return error
