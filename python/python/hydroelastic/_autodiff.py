"""Wrenches and rollouts as functions of rows of numbers, with their Jacobians: what ``jax`` and ``torch`` share.

A row starts with the entries of poses, 16 each, and other numbers follow. The columns of a Jacobian are 6 for each
pose, a twist in world axes, and one for each other number. Poses among the outputs are numbers like all others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._core import Batch, HydroelasticError, Pair, Parameter, Plan, State, Trajectory, TrajectoryJacobian, World

Floats = NDArray[np.float64]
Errors = dict[int, HydroelasticError]
_T = TypeVar("_T")

# Entries of a pose, numbers of a twist and of both wrenches.
POSE = 16
TWIST = 6
WRENCHES = 12


class Function:
    """A function of rows, (m, numbers), with its Jacobian by the columns of the module.

    What the library refuses gives rows of NaN, and an exception each, by the place of the row.
    """

    name: str
    # Whether products with vectors take the place of Jacobians: there are many columns, and the outputs are swept back.
    sweeps_back = False
    # How many poses a row starts with, its length, that of the outputs, and the number of columns.
    poses: int
    numbers: int
    outputs: int

    @property
    def columns(self) -> int:
        return self.numbers - (POSE - TWIST) * self.poses

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        """(m, outputs) float64."""
        raise NotImplementedError

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        """(m, outputs) and (m, outputs, columns) float64."""
        raise NotImplementedError

    def pushforwards(self, rows: Floats, tangents: Floats) -> tuple[Floats, Errors]:
        """The Jacobian of each row times c vectors of its own, (m, c, columns): (m, c, outputs) float64."""
        _, jacobians, errors = self.values_and_jacobians(rows)
        return tangents @ jacobians.swapaxes(-1, -2), errors

    def pullbacks(self, rows: Floats, cotangents: Floats) -> tuple[Floats, Errors]:
        """c vectors for each row, (m, c, outputs), times its Jacobian: (m, c, columns) float64."""
        _, jacobians, errors = self.values_and_jacobians(rows)
        return cotangents @ jacobians, errors


def moduli_of(pair: Pair) -> Floats:
    """(2,): the moduli of a pair; that of a rigid B is infinite."""
    modulus_a, modulus_b = pair.moduli
    return np.array([modulus_a, np.inf if modulus_b is None else modulus_b])


class Wrench(Function):
    """Both wrenches of a pair: of two poses and two moduli; in motion of two twists, before the moduli, and of
    dissipation and friction too.
    """

    def __init__(self, pair: Pair, in_motion: bool) -> None:
        self.name = "wrench"
        self.poses = 2
        self.numbers = 2 * POSE + 2 + (2 * TWIST + 2 if in_motion else 0)
        self.outputs = WRENCHES
        self._pair = pair
        self._in_motion = in_motion

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        (found,), errors = self._found(rows, lambda *a, **k: (self._pair.wrench(*a, **k),), [(WRENCHES,)])
        return found, errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        call = self._pair.linearized if self._in_motion else self._pair.wrench_and_jacobian
        (values, jacobians), errors = self._found(rows, call, [(WRENCHES,), (WRENCHES, self.columns)])
        return values, jacobians, errors

    def _found(
        self, rows: Floats, call: Callable[..., tuple[Floats, ...]], shapes: Sequence[tuple[int, ...]]
    ) -> tuple[list[Floats], Errors]:
        """The results of a call for all rows at once; one by one if a row is refused."""
        count = len(rows)
        if count > 1:
            try:
                return list(self._called(call, rows)), {}
            except HydroelasticError:
                pass
        results, errors = [np.full((count, *shape), np.nan) for shape in shapes], Errors()
        for place in range(count):
            try:
                for result, found in zip(results, self._called(call, rows[place])):
                    result[place] = found
            except HydroelasticError as error:
                errors[place] = error
        return results, errors

    def _called(self, call: Callable[..., tuple[Floats, ...]], rows: Floats) -> tuple[Floats, ...]:
        lead = rows.shape[:-1]
        pose_a, pose_b = (rows[..., first : first + POSE].reshape(*lead, 4, 4) for first in (0, POSE))
        rest = rows[..., 2 * POSE :]
        if not self._in_motion:
            return call(pose_a, pose_b, moduli=rest)
        return call(pose_a, pose_b, rest[..., :6], rest[..., 6:12], moduli=rest[..., 12:14], law=rest[..., 14:])


class Rollout(Function):
    """The recorded states of a world, all poses, then all twists: of changes of parameters; with an initial state of
    its n poses and n twists, before the changes, and of the number of steps taken before, which is the last number.
    """

    def __init__(
        self, world: World, plan: Plan, parameters: Sequence[Parameter], *, from_state: bool, only_last: bool = False
    ) -> None:
        if only_last:
            plan = _recording(plan, max(plan.steps, 1))
        self.name = "rollout"
        self.bodies = len(world.names)
        self.only_last = only_last
        self.width = sum(parameter.dimension for parameter in parameters)
        self.states = 1 if only_last else recorded_count(plan)
        self.poses = self.bodies if from_state else 0
        self.numbers = (self.bodies * (POSE + TWIST) + 1 if from_state else 0) + self.width
        self.outputs = self.states * self.bodies * (POSE + TWIST)
        self._world, self._plan, self._parameters = world, plan, list(parameters)
        self._from_state = from_state
        self._dynamic = [place for place, body in enumerate(world.bodies) if body.mass is not None]
        # Refuses what is not a parameter of the world.
        world.perturbed(self._parameters, np.zeros(self.width))
        self.sweeps_back = world._sweeps_back(plan, self._initial_parameters() + self._parameters)

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        values, errors = np.full((len(rows), self.outputs), np.nan), Errors()
        worlds = _each(self._started, rows, errors)
        found = Batch(self._plan).rollouts(list(worlds.values()))
        for place, trajectory in zip(worlds, found):
            if isinstance(trajectory, Trajectory):
                values[place] = self._value(trajectory)
            else:
                errors[place] = trajectory
        return values, errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        values = np.full((len(rows), self.outputs), np.nan)
        jacobians, errors = np.full((*values.shape, self.columns), np.nan), Errors()
        by = self._initial_parameters() + self._parameters

        worlds = _each(self._started, rows, errors)
        found = Batch(self._plan).jacobians(list(worlds.values()), by)
        for place, result in zip(worlds, found):
            if isinstance(result, tuple):
                values[place] = self._value(result[0])
                jacobians[place] = self._columns_of(self._rows_of(result[1]))
            else:
                errors[place] = result
        return values, jacobians, errors

    def pullbacks(self, rows: Floats, cotangents: Floats) -> tuple[Floats, Errors]:
        by = self._initial_parameters() + self._parameters
        count = cotangents.shape[1]
        if not self._world._sweeps_back(self._plan, by, count):
            return super().pullbacks(rows, cotangents)
        found, errors = np.full((*cotangents.shape[:2], self.columns), np.nan), Errors()
        worlds = _each(self._started, rows, errors)
        if not worlds:
            return found, errors
        places = [(place, which) for place in worlds for which in range(count)]
        by_poses, by_twists = self._by_states(np.array([cotangents[it] for it in places]).reshape(-1, self.outputs))
        results = Batch(self._plan).vjps([worlds[place] for place, _ in places], by, by_poses, by_twists)
        for at, result in zip(places, results):
            if isinstance(result, HydroelasticError):
                errors[at[0]] = result
            else:
                found[at] = self._columns_of(result[None])[0]
        return found, errors

    def _by_states(self, cotangents: Floats) -> tuple[Floats, Floats]:
        """The cotangents of all recorded poses and twists, where those of all but the last may have no part in outputs."""
        count, recorded = len(cotangents), recorded_count(self._plan)
        by_poses = np.zeros((count, recorded, self.bodies, 4, 4))
        by_twists = np.zeros((count, recorded, self.bodies, TWIST))
        entries = self.states * self.bodies * POSE
        by_poses[:, -self.states :] = cotangents[:, :entries].reshape(count, self.states, self.bodies, 4, 4)
        by_twists[:, -self.states :] = cotangents[:, entries:].reshape(count, self.states, self.bodies, TWIST)
        return by_poses, by_twists

    def _started(self, row: Floats) -> World:
        """The world with the initial state and the changes of a row."""
        world, changes = self._world, row
        if self._from_state:
            entries, twists = self.bodies * POSE, self.bodies * TWIST
            poses = row[:entries].reshape(self.bodies, 4, 4)
            twists_of_bodies = row[entries : entries + twists].reshape(self.bodies, TWIST)
            if row[-1] < 0.0:
                raise HydroelasticError(f"start_step must be at least 0, but is {row[-1]:.0f}")
            time = self._world.initial_state.time + row[-1] * self._plan.time_step
            world = world.replace(start=State(time, poses, twists_of_bodies))
            changes = row[entries + twists : -1]
        return world.perturbed(self._parameters, changes)

    def _initial_parameters(self) -> list[Parameter]:
        """The initial states of all dynamic bodies: poses, then twists, angular parts first."""
        if not self._from_state:
            return []
        names = [self._world.names[place] for place in self._dynamic]
        poses = [kind(name) for name in names for kind in (Parameter.initial_orientation, Parameter.initial_position)]
        return poses + [kind(name) for name in names for kind in (Parameter.initial_angular_velocity, Parameter.initial_velocity)]

    def _value(self, trajectory: Trajectory) -> Floats:
        states = slice(-self.states, None)
        return np.concatenate([trajectory.poses[states].ravel(), trajectory.twists[states].ravel()])

    def _rows_of(self, jacobian: TrajectoryJacobian) -> Floats:
        states = slice(-self.states, None)
        width = jacobian.poses.shape[-1]
        return np.concatenate([it[states].reshape(-1, width) for it in (jacobian.poses, jacobian.twists)])

    def _columns_of(self, found: Floats) -> Floats:
        """Derivatives by all columns, from rows of those by the initial states of dynamic bodies and by parameters."""
        if not self._from_state:
            return found
        # Bodies that forces do not move ignore their part of the initial state, and the time has no derivative.
        columns, dynamic = np.zeros((len(found), self.columns)), len(self._dynamic) * TWIST
        moved = (TWIST * np.array(self._dynamic, dtype=int)[:, None] + np.arange(TWIST)).ravel()
        columns[:, moved] = found[:, :dynamic]
        columns[:, self.bodies * TWIST + moved] = found[:, dynamic : 2 * dynamic]
        columns[:, 2 * self.bodies * TWIST : -1] = found[:, 2 * dynamic :]
        return columns


class Arrays(Protocol):
    """What jax and torch bring to wrench and states: how they check arguments, and how they evaluate a function."""

    def floats(self, value: Any, name: str, shape: tuple[int, ...]) -> Any:
        """An argument as an array of float64 that ends in a shape."""

    def count(self, value: Any) -> Any:
        """A whole number, or an array of them, as float64."""

    def evaluated(self, function: Function, ranks: Sequence[int], parts: Sequence[Any]) -> Any:
        """The outputs for numbers that consist of parts, each with so many axes of its own, and any axes in front."""


def wrench(
    arrays: Arrays,
    pair: Pair,
    poses: tuple[Any, Any],
    twists: tuple[Any, Any],
    moduli: Any,
    law: Any,
) -> Any:
    """Both wrenches of a pair, (12,) with any axes in front: in motion if a twist is given. What is None is zero, or that
    of the pair.
    """
    in_motion = any(twist is not None for twist in twists)
    parts = [arrays.floats(pose, name, (4, 4)) for pose, name in zip(poses, ("pose_a", "pose_b"))]
    if in_motion:
        given = [np.zeros(TWIST) if twist is None else twist for twist in twists]
        parts += [arrays.floats(twist, name, (TWIST,)) for twist, name in zip(given, ("twist_a", "twist_b"))]
    parts.append(arrays.floats(moduli_of(pair) if moduli is None else moduli, "moduli", (2,)))
    # Without twists a law does not matter, but a wrong one is refused all the same.
    if law is not None or in_motion:
        of_pair = np.array([pair.law.dissipation, pair.law.friction])
        numbers = arrays.floats(of_pair if law is None else law, "law", (2,))
        parts += [numbers] if in_motion else []
    return arrays.evaluated(Wrench(pair, in_motion), [2, 2, *[1] * (len(parts) - 2)], parts)


def states(
    arrays: Arrays,
    function: Rollout,
    changes: Any,
    start: tuple[Any, Any] | None,
    start_step: Any,
) -> tuple[Any, Any]:
    """The poses and twists that a rollout gives, with the recorded states in front unless only the last is asked for."""
    count = function.bodies
    numbers = arrays.floats(np.zeros(function.width) if changes is None else changes, "changes", (function.width,))
    if start is None:
        if not (isinstance(start_step, int) and start_step == 0):
            raise HydroelasticError("start_step needs start: without one, the rollout starts at the initial time of the world")
        found = arrays.evaluated(function, [1], [numbers])
    else:
        poses, twists = start
        parts = [arrays.floats(poses, "poses", (count, 4, 4)), arrays.floats(twists, "twists", (count, 6))]
        found = arrays.evaluated(function, [3, 2, 1, 1], [*parts, numbers, arrays.count(start_step)[..., None]])
    lead, recorded = found.shape[:-1], () if function.only_last else (function.states,)
    entries = function.states * count * POSE
    return (
        found[..., :entries].reshape(*lead, *recorded, count, 4, 4),
        found[..., entries:].reshape(*lead, *recorded, count, TWIST),
    )


def paired(numbers: Floats, vectors: Floats) -> tuple[Floats, Floats, Callable[[Floats], Floats]]:
    """Numbers and vectors with as many axes in front, of which those of numbers may have the length 1: as rows (m, numbers)
    and the vectors of each, (m, c, entries). And what gives results for each vector, (m, c, results), the axes in front.
    """
    front = vectors.shape[:-1]
    shared = [axis for axis, length in enumerate(front) if numbers.shape[axis] == length]
    own = [axis for axis in range(len(front)) if axis not in shared]
    order = [*shared, *own, len(front)]
    count = math.prod(front[axis] for axis in shared)
    each = math.prod(front[axis] for axis in own)

    def restored(found: Floats) -> Floats:
        axes = found.reshape(*(front[axis] for axis in order[:-1]), found.shape[-1])
        return axes.transpose(np.argsort(order))

    rows = numbers.reshape(count, numbers.shape[-1])
    return rows, vectors.transpose(order).reshape(count, each, vectors.shape[-1]), restored


def recorded_count(plan: Plan) -> int:
    """How many states a plan records: the initial one, every so many-th after it and the last."""
    return 1 + -(-plan.steps // plan.record_every)


def one_step(plan: Plan) -> Plan:
    """The plan of a single step."""
    return _recording(plan, 1, steps=1)


def first_error(errors: Errors, count: int) -> HydroelasticError:
    """The exception for rows that were refused: the first, with the place of its row if there are several rows."""
    place, error = min(errors.items())
    return error if count == 1 else type(error)(f"row {place} of {count}: {error}")


def _recording(plan: Plan, every: int, steps: int | None = None) -> Plan:
    return Plan(
        plan.time_step,
        plan.steps if steps is None else steps,
        plan.integrator,
        record_every=every,
        check_stability=plan.check_stability,
        solver_tolerance=plan.solver_tolerance,
        accuracy=plan.accuracy,
    )


def _each(function: Callable[[Floats], _T], rows: Floats, errors: Errors) -> dict[int, _T]:
    """The results of the rows that are not refused, by their places."""
    found: dict[int, _T] = {}
    for place, row in enumerate(rows):
        try:
            found[place] = function(row)
        except HydroelasticError as error:
            errors[place] = error
    return found
