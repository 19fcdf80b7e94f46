"""Batches of rollouts and fits on a Ray cluster, with the interfaces of ``hydroelastic.Batch`` and ``Identification.fit``.

    from hydroelastic.ray import Batch, fit

    results = Batch(plan).jacobians_perturbed(world, parameters, samples)
    estimates = fit(identification, trajectories).values

If all machines have the same version of this package, the results are those of the local machine, in the same order
and with the same bits. Only implicit steps of 16 or more bodies may differ in the last bits, between processors with
and without fused multiply-add. ``docs/python/cluster.md`` describes how to start a cluster.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import _core, _progress
from ._core import (
    Checkpoint,
    Fit,
    HydroelasticError,
    Identification,
    Parameter,
    Plan,
    RolloutError,
    State,
    Trajectory,
    TrajectoryJacobian,
    World,
)
from ._checks import check_count

try:
    import ray  # type: ignore[import-not-found, unused-ignore]
    from ray import exceptions  # type: ignore[import-not-found, unused-ignore]
except ImportError as _error:
    raise ImportError('hydroelastic.ray needs Ray: pip install "hydroelastic[ray]"') from _error

__all__ = ["Batch", "fit"]

# Each task has one thread, because Ray runs one task for each core of a machine.
_ENVIRONMENT = {"env_vars": {"RAYON_NUM_THREADS": "1"}}
# Number of parts for each core. With several parts, cores that finish early get more work.
_PARTS_PER_CORE = 8
# Maximum number of rollouts in a part.
_LONGEST_PART = 32
# Number of tasks in one call of ray.wait, which takes longer for more tasks.
_WINDOW = 256
# Exceptions of a task that was lost in all its attempts.
_LOST = (
    exceptions.WorkerCrashedError,
    exceptions.NodeDiedError,
    exceptions.OutOfMemoryError,
    exceptions.ObjectLostError,
)


class _Sliced(Protocol):
    """Inputs, one for each result: a list, or the rows of an array."""

    def __len__(self) -> int: ...
    def __getitem__(self, indices: slice, /) -> Any: ...


# Common data of the parts of the current batch or fit in this worker, by its pickled bytes.
_HELD: dict[bytes, Any] = {}


def _loaded(common: bytes) -> Any:
    """Returns the common data of parts. Each worker unpickles it once, because a world of 20,000 tetrahedra takes about
    60 ms."""
    if common not in _HELD:
        _HELD.clear()
        _HELD[common] = pickle.loads(common)
    return _HELD[common]


def _check_version(version: str) -> None:
    if version != _core.__version__:
        raise RuntimeError(f"this worker has hydroelastic {_core.__version__}, but was sent work of {version}")


def _results(version: str, plan: Plan, method: str, common: bytes, part: Any) -> list[Any]:
    """Runs a method of the local batch for a part, in a worker."""
    _check_version(version)
    function, shared = getattr(_core.Batch(plan), method), _loaded(common)
    # The worlds of ``jacobians`` are its first argument. Other inputs are the last argument.
    return function(part, *shared) if method == "jacobians" else function(*shared, part)  # type: ignore[no-any-return]


class Batch:
    """Batch of independent rollouts with one plan, on a Ray cluster.

    The methods and results are those of ``hydroelastic.Batch``. Results have the order of the inputs and the same bits
    as single rollouts. If a rollout fails, its result is the exception.

    Worlds are sent once to each machine that needs them. Parts of the batch are tasks. If a worker or a machine is
    lost, Ray runs its tasks again on another one, with the same result. If a task is lost too often, each of its
    results is a RolloutError whose cause is Ray's exception.

    If Ray is not running, ``ray.init()`` starts it or connects to the cluster. Ctrl-C, or an exception of the progress
    function, ends the batch: running tasks end before their next step. A method raises ``ray.exceptions.RayError`` if
    the workers cannot run at all, for example because they do not have this package.

    Parameters
    ----------
    plan : Plan
        Plan of each rollout.
    progress : bool or callable, optional
        True for a progress bar of tqdm if tqdm is installed, or a function of (done, total) rollouts.
    chunk : int, optional
        Number of rollouts in a task. Default: eight tasks for each core of the cluster, with at most 32 rollouts each.
        Tasks of less than 50 ms spend more than a few percent of their time in Ray.
    max_retries : int
        Number of times that a task is started again after a loss. -1 means no limit.

    Raises
    ------
    HydroelasticError
        If chunk or max_retries is out of range.
    TypeError
        If plan is not a Plan.
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
        """Plan of each rollout."""
        return self._plan

    def rollouts_from(self, world: World, states: Sequence[State]) -> list[Trajectory | RolloutError]:
        """Runs a rollout of one world from each of several states.

        Parameters
        ----------
        world : World
            World of all rollouts.
        states : sequence of State
            Initial state of each rollout.

        Returns
        -------
        list of Trajectory or RolloutError
            Result of each rollout.

        Raises
        ------
        HydroelasticError
            If a state does not fit the world.
        """
        for state in states:
            world.rollout(self._plan, start=state)  # This raises an error if the state does not fit the world.
        return self._over_the_cluster("rollouts_from", (world,), list(states))

    def rollouts(self, worlds: Sequence[World]) -> list[Trajectory | RolloutError]:
        """Runs a rollout of each of several worlds from its initial state.

        Parameters
        ----------
        worlds : sequence of World
            World of each rollout.

        Returns
        -------
        list of Trajectory or RolloutError
            Result of each rollout.

        Raises
        ------
        TypeError
            If an item is not a World.
        """
        _check_worlds(worlds)
        return self._over_the_cluster("rollouts", (), list(worlds))

    def rollouts_perturbed(
        self, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[Trajectory | HydroelasticError]:
        """Runs a rollout of one world at each of n perturbations of its parameters.

        Parameters
        ----------
        world : World
            World before the perturbation.
        parameters : sequence of Parameter
            Parameters to perturb, with p components in total.
        samples : (n, p) array_like
            Changes that are added to the parameters, as in ``World.perturbed``.

        Returns
        -------
        list of Trajectory or HydroelasticError
            Result of each rollout.

        Raises
        ------
        HydroelasticError
            If samples does not have two axes.
        TypeError
            If samples is not an array of numbers.
        """
        return self._perturbed("rollouts_perturbed", world, parameters, samples)

    def jacobians_perturbed(
        self, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[tuple[Trajectory, TrajectoryJacobian] | HydroelasticError]:
        """Runs ``World.jacobian`` for one world at each of n perturbations of its parameters.

        Parameters
        ----------
        world : World
            World before the perturbation.
        parameters : sequence of Parameter
            Parameters to perturb and to differentiate with respect to, with p components in total.
        samples : (n, p) array_like
            Changes that are added to the parameters, as in ``World.perturbed``.

        Returns
        -------
        list of (Trajectory, TrajectoryJacobian) or HydroelasticError
            Result of each rollout.

        Raises
        ------
        HydroelasticError
            If samples does not have two axes.
        TypeError
            If samples is not an array of numbers.
        """
        return self._perturbed("jacobians_perturbed", world, parameters, samples)

    def jacobians(
        self, worlds: Sequence[World], parameters: Sequence[Parameter]
    ) -> list[tuple[Trajectory, TrajectoryJacobian] | HydroelasticError]:
        """Runs ``World.jacobian`` for each of several worlds from its initial state.

        Parameters
        ----------
        worlds : sequence of World
            World of each rollout.
        parameters : sequence of Parameter
            Parameters to differentiate with respect to.

        Returns
        -------
        list of (Trajectory, TrajectoryJacobian) or HydroelasticError
            Result of each rollout.

        Raises
        ------
        TypeError
            If an item is not a World or a Parameter.
        """
        _check_worlds(worlds)
        _core.Batch(self._plan).jacobians([], parameters)
        return self._over_the_cluster("jacobians", (list(parameters),), list(worlds))

    def _perturbed(
        self, method: str, world: World, parameters: Sequence[Parameter], samples: NDArray[np.float64]
    ) -> list[Any]:
        """Runs one of the two methods for perturbations. The local batch first checks the arguments with no samples."""
        samples = np.asarray(samples) if isinstance(samples, list | tuple) else samples
        has_rows = isinstance(samples, np.ndarray) and samples.ndim == 2
        getattr(_core.Batch(self._plan), method)(world, parameters, samples[:0] if has_rows else samples)
        return self._over_the_cluster(method, (world, list(parameters)), samples)

    def _over_the_cluster(self, method: str, common: tuple[Any, ...], items: _Sliced) -> list[Any]:
        """Runs a method of the local batch for items, in parts. The common data of the parts is sent once."""
        progress = self._progress
        report = None if progress is None or progress is False else _progress.shown(progress, len(items))
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
                if report is not None:
                    report(done)
        finally:
            # Tasks remain only after Ctrl-C or an exception.
            for task in tasks:
                ray.cancel(task)
            if report is not None:
                report.close()
        return results

    def _tasks(self, method: str, common: tuple[Any, ...], items: _Sliced) -> dict[ray.ObjectRef[Any], slice]:
        """Starts a Ray task for each part of the items. Returns the slice of the results of each task."""
        _start_ray()
        length = self._chunk or _part_length(len(items))
        parts = [slice(first, min(first + length, len(items))) for first in range(0, len(items), length)]
        function = _remote(_results, method, self._max_retries)
        shared = ray.put(pickle.dumps(common))
        return {function.remote(_core.__version__, self._plan, method, shared, items[part]): part for part in parts}

    def __repr__(self) -> str:
        return f"hydroelastic.ray.Batch({self._plan!r})"


def fit(
    identification: Identification,
    trajectories: Sequence[Trajectory],
    *,
    start: Checkpoint | None = None,
    progress: Callable[[int, float, NDArray[np.float64], Checkpoint], object] | None = None,
    chunk: int | None = None,
    max_retries: int = 5,
) -> Fit:
    """Fits the unknowns of an identification to measurements, on a Ray cluster.

    The result is bitwise identical to that of ``identification.fit``. The minimizer runs in this process. In each
    iteration, tasks simulate parts of the measurements. The identification and the measurements are sent once to each
    machine that needs them. After that, only coordinates, costs and normal equations are sent, whose sizes do not
    depend on the number of states.

    If Ray is not running, ``ray.init()`` starts it or connects to the cluster. Ctrl-C, or an exception of the progress
    function, ends the fit and its tasks. If the checkpoint of each iteration is saved, a fit can continue after a loss
    of this process.

    Parameters
    ----------
    identification : Identification
        World, plan, unknowns and nuisances.
    trajectories : sequence of Trajectory
        Measurements.
    start : Checkpoint, optional
        Checkpoint from which the fit continues. Default: the initial guess.
    progress : callable, optional
        Function of (index, cost, values, checkpoint), called at the beginning of each iteration. If it returns True,
        the fit ends with its present result.
    chunk : int, optional
        Number of measurements in a task. Default: eight tasks for each core of the cluster, with at most 32
        measurements each.
    max_retries : int
        Number of times that a task is started again after a loss. -1 means no limit.

    Returns
    -------
    Fit
        Estimates and their uncertainty.

    Raises
    ------
    HydroelasticError
        If chunk or max_retries is out of range, a trajectory does not fit the world or the time step, or no
        measurement can be simulated.
    RolloutError
        If a task is lost too often. The cause is Ray's exception.
    TypeError
        If identification is not an Identification, or an item of trajectories is not a Trajectory.
    """
    if not isinstance(identification, Identification):
        raise TypeError(f"identification must be an Identification, but is {identification!r}")
    evaluator = _Evaluator(identification, list(trajectories), chunk, max_retries)
    return identification._fit_with(trajectories, evaluator, start, progress)


class _Evaluator:
    """Evaluator that simulates the measurements of a fit in Ray tasks."""

    def __init__(
        self, identification: Identification, trajectories: list[Trajectory], chunk: int | None, max_retries: int
    ) -> None:
        self._identification = identification
        self._trajectories = trajectories
        self._chunk = None if chunk is None else check_count(chunk, "chunk", 1)
        self._max_retries = check_count(max_retries, "max_retries", -1)
        # Pickled identification, and pickled measurements of each part. None before the first evaluation.
        self._sent: tuple[ray.ObjectRef[bytes], list[ray.ObjectRef[bytes]]] | None = None

    def costs(self, checkpoint: Checkpoint, indices: list[int]) -> list[Any]:
        """Returns the cost of each measurement at a checkpoint, or the text of an error."""
        return self._evaluated("_costs", checkpoint, indices)

    def equations(self, checkpoint: Checkpoint, indices: list[int]) -> list[Any]:
        """Returns the pickled equations of each measurement at a checkpoint, or the text of an error."""
        return self._evaluated("_equations", checkpoint, indices)

    def _evaluated(self, method: str, checkpoint: Checkpoint, indices: list[int]) -> list[Any]:
        tasks: dict[ray.ObjectRef[Any], list[int]] = {}
        results: dict[int, Any] = {}
        try:
            tasks.update(self._tasks(method, checkpoint, indices))
            for task in _as_they_end(list(tasks)):
                part = tasks.pop(task)
                values = _result(task, len(part))
                if isinstance(values[0], RolloutError):
                    raise values[0]
                results.update(zip(part, values, strict=True))
        finally:
            # Tasks remain only after Ctrl-C or an exception.
            for task in tasks:
                ray.cancel(task)
        return [results[index] for index in indices]

    def _tasks(
        self, method: str, checkpoint: Checkpoint, indices: list[int]
    ) -> dict[ray.ObjectRef[Any], list[int]]:
        """Starts a task for each part of the measurements. Returns the indices of the measurements of each task."""
        _start_ray()
        count = len(self._trajectories)
        length = self._chunk = self._chunk or _part_length(count)
        if self._sent is None:
            parts = [self._trajectories[first : first + length] for first in range(0, count, length)]
            self._sent = ray.put(pickle.dumps(self._identification)), [ray.put(pickle.dumps(part)) for part in parts]
        function = _remote(_evaluations, "fit", self._max_retries)
        members: dict[int, list[int]] = {}
        for index in indices:
            members.setdefault(index // length, []).append(index)
        nuisances, tasks = checkpoint.nuisances, {}
        for part, indices_of_part in members.items():
            point = Checkpoint(checkpoint.horizon, checkpoint.unknowns, nuisances[indices_of_part])
            local_indices = [index - part * length for index in indices_of_part]
            task = function.remote(_core.__version__, method, self._sent[0], self._sent[1][part], local_indices, point)
            tasks[task] = indices_of_part
        return tasks


def _evaluations(
    version: str, method: str, identification: bytes, part: bytes, indices: list[int], point: Checkpoint
) -> list[Any]:
    """Evaluates some measurements of a part at a point, in a worker."""
    _check_version(version)
    trajectories = pickle.loads(part)
    function = getattr(_loaded(identification), method)
    return function([trajectories[index] for index in indices], point)  # type: ignore[no-any-return]


def _start_ray() -> None:
    if not ray.is_initialized():
        ray.init()


def _remote(function: Callable[..., Any], name: str, max_retries: int) -> Any:
    """Returns the remote function of tasks with one core."""
    return ray.remote(function).options(
        name=f"hydroelastic {name}", num_cpus=1, max_retries=max_retries, runtime_env=_ENVIRONMENT
    )


def _check_worlds(worlds: Sequence[World]) -> None:
    for world in worlds:
        if not isinstance(world, World):
            raise TypeError(f"worlds must be of World, but one is {world!r}")


def _part_length(count: int) -> int:
    """Returns the default number of rollouts in a task."""
    resources: dict[str, float] = ray.cluster_resources()  # type: ignore[no-untyped-call, unused-ignore]
    cores = max(1, int(resources.get("CPU", 1)))
    return min(_LONGEST_PART, -(-count // (_PARTS_PER_CORE * cores)))


def _as_they_end(tasks: list[ray.ObjectRef[Any]]) -> Iterator[ray.ObjectRef[Any]]:
    """Yields tasks as they end. The tasks were started in the order of the list."""
    while tasks:
        window, rest = tasks[:_WINDOW], tasks[_WINDOW:]
        ray.wait(window, num_returns=1)
        ended, others = ray.wait(window, num_returns=len(window), timeout=0)
        yield from ended
        tasks = others + rest


def _result(task: ray.ObjectRef[Any], count: int) -> list[Any]:
    """Returns the results of a task that has ended. If Ray has lost the task too often, each result is an exception."""
    try:
        results: list[Any] = ray.get(task)
        return results
    except _LOST as lost:
        return [_lost(lost) for _ in range(count)]


def _lost(cause: Exception) -> RolloutError:
    error = RolloutError(f"the rollout was lost with its worker, more often than it is tried again: {cause}")
    error.__cause__ = cause
    return error
