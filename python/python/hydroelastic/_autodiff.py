"""Wrenches, images, clearances and rollouts as functions of rows of numbers, with Jacobians, for ``jax`` and ``torch``.

A row has the 16 entries of each pose first, then all other numbers. A Jacobian has 6 columns for each pose, which are a
twist in world axes, and one column for each other number. Poses among the outputs are 16 numbers each.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ._checks import check_class
from ._core import (
    Batch,
    HydroelasticError,
    Pair,
    Parameter,
    Plan,
    State,
    TaxelGrid,
    Trajectory,
    TrajectoryJacobian,
    World,
)

Floats = NDArray[np.float64]
Errors = dict[int, HydroelasticError]
_T = TypeVar("_T")

# Numbers of components of a pose, of a twist and of both wrenches.
POSE = 16
TWIST = 6
WRENCHES = 12

# Arrays of a state: attributes of State, Trajectory and TrajectoryJacobian.
ARRAYS = (
    "poses",
    "twists",
    "joint_positions",
    "joint_velocities",
    "ball_joint_rotations",
    "ball_joint_velocities",
)


class Function:
    """Function of rows, (m, numbers), with its Jacobian. The module describes the columns.

    If the library raises an exception for a row, the results of the row are NaN. The exceptions are returned by the
    index of the row.
    """

    name: str
    # True if reverse mode computes products with vectors, because a Jacobian would have many columns.
    sweeps_back = False
    # Number of poses at the start of a row, length of a row, and number of outputs.
    poses: int
    numbers: int
    outputs: int

    @property
    def columns(self) -> int:
        """Number of columns of the Jacobian."""
        return self.numbers - (POSE - TWIST) * self.poses

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        """Returns the outputs, (m, outputs) float64, and the errors."""
        raise NotImplementedError

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        """Returns the outputs, (m, outputs), and Jacobians, (m, outputs, columns), of float64, and the errors."""
        raise NotImplementedError

    def pushforwards(self, rows: Floats, tangents: Floats) -> tuple[Floats, Errors]:
        """Returns the products of the Jacobian of each row with c tangents, (m, c, columns): (m, c, outputs) float64.
        """
        _, jacobians, errors = self.values_and_jacobians(rows)
        return tangents @ jacobians.swapaxes(-1, -2), errors

    def pullbacks(self, rows: Floats, cotangents: Floats) -> tuple[Floats, Errors]:
        """Returns the products of c cotangents, (m, c, outputs), with the Jacobian of each row: (m, c, columns)
        float64."""
        _, jacobians, errors = self.values_and_jacobians(rows)
        return cotangents @ jacobians, errors


def moduli_of(pair: Pair) -> Floats:
    """Returns the moduli of a pair, (2,). The modulus of a rigid B is infinite."""
    modulus_a, modulus_b = pair.moduli
    return np.array([modulus_a, np.inf if modulus_b is None else modulus_b])


class Wrench(Function):
    """Both wrenches of a pair. A row has two poses and two moduli. In motion, a row has two poses, two twists, two
    moduli, the dissipation and the friction coefficient.
    """

    def __init__(self, pair: Pair, in_motion: bool) -> None:
        self.name = "wrench"
        self.poses = 2
        self.numbers = 2 * POSE + 2 + (2 * TWIST + 2 if in_motion else 0)
        self.outputs = WRENCHES
        self._pair = pair
        self._in_motion = in_motion

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        (values,), errors = self._results(rows, lambda *a, **k: (self._pair.wrench(*a, **k),), [(WRENCHES,)])
        return values, errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        call = self._pair.linearized if self._in_motion else self._pair.wrench_and_jacobian
        (values, jacobians), errors = self._results(rows, call, [(WRENCHES,), (WRENCHES, self.columns)])
        return values, jacobians, errors

    def _results(
        self, rows: Floats, call: Callable[..., tuple[Floats, ...]], shapes: Sequence[tuple[int, ...]]
    ) -> tuple[list[Floats], Errors]:
        """Calls a method of the pair with all rows as a batch, or with one row at a time if a row raises an exception.
        """
        count = len(rows)
        if count > 1:
            try:
                return list(self._called(call, rows)), {}
            except HydroelasticError:
                pass
        results, errors = [np.full((count, *shape), np.nan) for shape in shapes], Errors()
        for index in range(count):
            try:
                for result, of_row in zip(results, self._called(call, rows[index])):
                    result[index] = of_row
            except HydroelasticError as error:
                errors[index] = error
        return results, errors

    def _called(self, call: Callable[..., tuple[Floats, ...]], rows: Floats) -> tuple[Floats, ...]:
        lead = rows.shape[:-1]
        pose_a, pose_b = (rows[..., first : first + POSE].reshape(*lead, 4, 4) for first in (0, POSE))
        rest = rows[..., 2 * POSE :]
        if not self._in_motion:
            return call(pose_a, pose_b, moduli=rest)
        return call(pose_a, pose_b, rest[..., :6], rest[..., 6:12], moduli=rest[..., 12:14], law=rest[..., 14:])


class TactileImage(Wrench):
    """Forces on the taxels of a grid on a body of a pair, with the rows of ``Wrench``."""

    def __init__(self, pair: Pair, in_motion: bool, grid: TaxelGrid, body: str) -> None:
        super().__init__(pair, in_motion)
        self.name = "tactile_image"
        self.shape = (grid.rows, grid.columns, 3)
        self.outputs = math.prod(self.shape)
        self._grid, self._body = grid, body

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        def call(*arguments: Floats, **numbers: Floats) -> tuple[Floats, ...]:
            return (self._pair.tactile_image(self._grid, *arguments, body=self._body, **numbers),)

        (values,), errors = self._results(rows, call, [self.shape])
        return values.reshape(len(rows), self.outputs), errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        method = self._pair.linearized_tactile_image if self._in_motion else self._pair.tactile_image_and_jacobian
        call = functools.partial(method, self._grid, body=self._body)
        (values, jacobians), errors = self._results(rows, call, [self.shape, (*self.shape, self.columns)])
        flat = (len(rows), self.outputs)
        return values.reshape(flat), jacobians.reshape(*flat, self.columns), errors


class Clearance(Wrench):
    """Signed distance between the bodies of a pair. Rows are those of ``Wrench`` without motion."""

    def __init__(self, pair: Pair, in_motion: bool = False) -> None:
        super().__init__(pair, in_motion)
        self.name, self.outputs = "clearance", 1

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        values, _, errors = self.values_and_jacobians(rows)
        return values, errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        def call(*poses: Floats, **moduli: Floats) -> tuple[Floats, ...]:
            distances, _, gradients = self._pair.clearance(*poses, **moduli)
            return np.asarray(distances), gradients

        (values, jacobians), errors = self._results(rows, call, [(), (self.columns,)])
        return values[:, None], jacobians[:, None], errors


class Rollout(Function):
    """Recorded states of a world: the numbers of each array in ``ARRAYS``, for all states.

    A row has the changes of parameters. With an initial state, a row has the poses of the n bodies, the rotations of
    the ball joints as poses, the other arrays of the state, the changes, and the number of steps before the start.
    """

    def __init__(
        self, world: World, plan: Plan, parameters: Sequence[Parameter], *, from_state: bool, only_last: bool = False
    ) -> None:
        check_class(plan, Plan, "plan")
        if only_last:
            plan = _recording(plan, max(plan.steps, 1))
        self.name = "rollout"
        self.only_last = only_last
        self.width = sum(parameter.dimension for parameter in parameters)
        self.states = 1 if only_last else recorded_count(plan)
        # Shapes of the arrays of one state.
        start = world.initial_state
        self.shapes = [getattr(start, name).shape for name in ARRAYS]
        self.sizes = [self.states * math.prod(shape) for shape in self.shapes]
        self.outputs = sum(self.sizes)
        bodies, balls = self.shapes[0][0], self.shapes[4][0]
        self.poses = bodies + balls if from_state else 0
        # Lengths of the parts of the initial state in a row: poses and rotations, then the other arrays.
        others = [math.prod(self.shapes[which]) for which in (1, 2, 3, 5)]
        self.parts = [POSE * bodies, POSE * balls, *others] if from_state else []
        self.numbers = sum(self.parts) + self.width + (1 if from_state else 0)
        self._world, self._plan, self._parameters = world, plan, list(parameters)
        self._from_state = from_state
        self._initial = _initial_parameters(world) if from_state else []
        self._by = [parameter for parameter, _ in self._initial] + self._parameters
        # This raises an error if a parameter does not belong to the world.
        world.perturbed(self._parameters, np.zeros(self.width))
        self.sweeps_back = world._sweeps_back(plan, self._by)

    def values(self, rows: Floats) -> tuple[Floats, Errors]:
        values, errors = np.full((len(rows), self.outputs), np.nan), Errors()
        worlds = _each(self._started, rows, errors)
        results = Batch(self._plan).rollouts(list(worlds.values()))
        for index, result in zip(worlds, results):
            if isinstance(result, Trajectory):
                values[index] = self._value(result)
            else:
                errors[index] = result
        return values, errors

    def values_and_jacobians(self, rows: Floats) -> tuple[Floats, Floats, Errors]:
        values = np.full((len(rows), self.outputs), np.nan)
        jacobians, errors = np.full((*values.shape, self.columns), np.nan), Errors()
        worlds = _each(self._started, rows, errors)
        results = Batch(self._plan).jacobians(list(worlds.values()), self._by)
        for index, result in zip(worlds, results):
            if isinstance(result, tuple):
                values[index] = self._value(result[0])
                jacobians[index] = self._columns_of(self._rows_of(result[1]))
            else:
                errors[index] = result
        return values, jacobians, errors

    def pullbacks(self, rows: Floats, cotangents: Floats) -> tuple[Floats, Errors]:
        count = cotangents.shape[1]
        if not self._world._sweeps_back(self._plan, self._by, count):
            return super().pullbacks(rows, cotangents)
        gradients, errors = np.full((*cotangents.shape[:2], self.columns), np.nan), Errors()
        worlds = _each(self._started, rows, errors)
        if not worlds:
            return gradients, errors
        # Index of the row, and index of the cotangent.
        indices = [(row, cotangent) for row in worlds for cotangent in range(count)]
        of_pairs = np.array([cotangents[pair] for pair in indices]).reshape(-1, self.outputs)
        by_poses, by_twists, *by_joints = self._by_states(of_pairs)
        results = Batch(self._plan).vjps(
            [worlds[row] for row, _ in indices],
            self._by,
            by_poses,
            by_twists,
            by_joint_positions=by_joints[0],
            by_joint_velocities=by_joints[1],
            by_ball_joint_rotations=by_joints[2],
            by_ball_joint_velocities=by_joints[3],
        )
        for pair, result in zip(indices, results):
            if isinstance(result, HydroelasticError):
                errors[pair[0]] = result
            else:
                gradients[pair] = self._columns_of(result[None])[0]
        return gradients, errors

    def _by_states(self, cotangents: Floats) -> list[Floats]:
        """Returns the cotangents of the arrays of all recorded states. They are zero for states that are not among the
        outputs."""
        count, recorded = len(cotangents), recorded_count(self._plan)
        arrays = []
        for part, shape in zip(self.split(cotangents), self.shapes):
            array = np.zeros((count, recorded, *shape))
            array[:, -self.states :] = part.reshape(count, self.states, *shape)
            arrays.append(array)
        return arrays

    def split(self, outputs: Any) -> list[Any]:
        """Splits the last axis of outputs into the parts of the arrays."""
        ends = np.cumsum(self.sizes)
        return [outputs[..., end - size : end] for end, size in zip(ends.tolist(), self.sizes)]

    def _started(self, row: Floats) -> World:
        """Returns the world with the initial state and the changes of a row."""
        world, changes = self._world, row
        if self._from_state:
            *parts, changes, steps = np.split(row, np.cumsum([*self.parts, self.width]))
            if steps[0] < 0.0:
                raise HydroelasticError(f"start_step must be at least 0, but is {steps[0]:.0f}")
            poses, rotations, twists, positions, velocities, spins = parts
            scalars = iter(zip(positions, velocities))
            balls = iter(zip(rotations.reshape(-1, 4, 4)[:, :3, :3], spins.reshape(-1, 3)))
            kinds = [joint.kind for joint in world.joints if joint.kind != "fixed" and joint.mimic is None]
            joints = [next(balls if kind == "ball" else scalars) for kind in kinds]
            time = world.initial_state.time + steps[0] * self._plan.time_step
            world = world.replace(start=State(time, poses.reshape(-1, 4, 4), twists.reshape(-1, TWIST), joints))
        return world.perturbed(self._parameters, changes)

    def _value(self, trajectory: Trajectory) -> Floats:
        states = slice(-self.states, None)
        return np.concatenate([getattr(trajectory, name)[states].ravel() for name in ARRAYS])

    def _rows_of(self, jacobian: TrajectoryJacobian) -> Floats:
        states = slice(-self.states, None)
        arrays = [getattr(jacobian, name)[states] for name in ARRAYS]
        return np.concatenate([array.reshape(math.prod(array.shape[:-1]), array.shape[-1]) for array in arrays])

    def _columns_of(self, derivatives: Floats) -> Floats:
        """Expands derivatives with respect to the initial state and parameters to all columns."""
        if not self._from_state:
            return derivatives
        # Only free bodies use their part of the initial state, and the time has no derivative.
        columns = np.zeros((len(derivatives), self.columns))
        parameters = np.arange(self.columns - 1 - self.width, self.columns - 1)
        columns[:, np.concatenate([*(indices for _, indices in self._initial), parameters])] = derivatives
        return columns


def _initial_parameters(world: World) -> list[tuple[Parameter, NDArray[np.int_]]]:
    """Returns the parameters of the initial state of a world, with their columns.

    The columns are twists of the poses of bodies and ball joints, then the other numbers of a row. Bodies that are not
    free have no parameters.
    """
    names, joints, balls = world.names, world.joint_names, world.ball_joint_names
    twists = TWIST * (len(names) + len(balls))
    positions = twists + TWIST * len(names)
    velocities = positions + len(joints)
    spins = velocities + len(joints)
    found: list[tuple[Parameter, NDArray[np.int_]]] = []

    def add(parameter: Parameter, first: int) -> None:
        found.append((parameter, first + np.arange(parameter.dimension)))

    for index, body in enumerate(world.bodies):
        if body.mass is not None and body.joint is None:
            add(Parameter.initial_orientation(body.name), TWIST * index)
            add(Parameter.initial_position(body.name), TWIST * index + 3)
            add(Parameter.initial_angular_velocity(body.name), twists + TWIST * index)
            add(Parameter.initial_velocity(body.name), twists + TWIST * index + 3)
    for index, name in enumerate(joints):
        add(Parameter.joint(name, "initial_position"), positions + index)
        add(Parameter.joint(name, "initial_velocity"), velocities + index)
    for index, name in enumerate(balls):
        add(Parameter.joint(name, "initial_orientation"), TWIST * (len(names) + index))
        add(Parameter.joint(name, "initial_angular_velocity"), spins + 3 * index)
    return found


class Arrays(Protocol):
    """Operations of an array framework that ``wrench`` and ``states`` need: checks of arguments, and the evaluation of
    a function."""

    def floats(self, value: Any, name: str, shape: tuple[int, ...]) -> Any:
        """Converts an argument to an array of float64 whose last axes have a shape."""

    def count(self, value: Any) -> Any:
        """Converts an integer or an array of integers to float64."""

    def poses(self, rotations: Any) -> Any:
        """Converts rotations, (..., 3, 3), to poses, (..., 4, 4)."""

    def evaluated(self, function: Function, ranks: Sequence[int], parts: Sequence[Any]) -> Any:
        """Evaluates a function whose numbers are the concatenated parts. The rank is the number of axes of a part
        without additional leading axes."""


def wrench(
    arrays: Arrays,
    pair: Pair,
    poses: tuple[Any, Any],
    twists: tuple[Any, Any],
    moduli: Any,
    law: Any,
    function: Callable[[Pair, bool], Function] = Wrench,
) -> Any:
    """Computes both wrenches of a pair, (12,) with any leading axes, or another function of the same rows.

    The bodies are in motion if a twist is given. A twist that is None is zero, and moduli or a law that are None are
    those of the pair.
    """
    check_class(pair, Pair, "pair")
    in_motion = any(twist is not None for twist in twists)
    parts = [arrays.floats(pose, name, (4, 4)) for pose, name in zip(poses, ("pose_a", "pose_b"))]
    if in_motion:
        both = [np.zeros(TWIST) if twist is None else twist for twist in twists]
        parts += [arrays.floats(twist, name, (TWIST,)) for twist, name in zip(both, ("twist_a", "twist_b"))]
    parts.append(arrays.floats(moduli_of(pair) if moduli is None else moduli, "moduli", (2,)))
    # Without twists the law has no effect, but a wrong law raises an error.
    if law is not None or in_motion:
        of_pair = np.array([pair.law.dissipation, pair.law.friction])
        numbers = arrays.floats(of_pair if law is None else law, "law", (2,))
        parts += [numbers] if in_motion else []
    return arrays.evaluated(function(pair, in_motion), [2, 2, *[1] * (len(parts) - 2)], parts)


def tactile_image(
    arrays: Arrays,
    pair: Pair,
    grid: TaxelGrid,
    body: str,
    poses: tuple[Any, Any],
    twists: tuple[Any, Any],
    moduli: Any,
    law: Any,
) -> Any:
    """Computes the forces on the taxels of a grid on a body of a pair, (H, W, 3) with any leading axes."""
    check_class(grid, TaxelGrid, "grid")
    if body not in ("a", "b"):
        raise HydroelasticError(f'body must be "a" or "b", but is {body!r}')
    function = functools.partial(TactileImage, grid=grid, body=body)
    forces = wrench(arrays, pair, poses, twists, moduli, law, function)
    return forces.reshape((*forces.shape[:-1], grid.rows, grid.columns, 3))


def clearance(arrays: Arrays, pair: Pair, poses: tuple[Any, Any], moduli: Any) -> Any:
    """Computes the signed distance between the bodies of a pair, with the leading axes of the arguments."""
    return wrench(arrays, pair, poses, (None, None), moduli, None, Clearance)[..., 0]


# Quantities of a body in nested values, with their parameters and numbers of components (0 for a number).
QUANTITIES: dict[str, tuple[Callable[[str], Parameter], int]] = {
    "position": (Parameter.initial_position, 3),
    "velocity": (Parameter.initial_velocity, 3),
    "angular_velocity": (Parameter.initial_angular_velocity, 3),
    "modulus": (Parameter.modulus, 0),
    "dissipation": (Parameter.dissipation, 0),
    "friction": (Parameter.friction, 0),
    "mass": (Parameter.mass, 0),
}


def parameters_and_changes(
    arrays: Arrays, world: World, parameters: Sequence[Parameter] | Mapping[str, Any], changes: Any
) -> tuple[list[Parameter], list[Any]]:
    """Returns parameters, and the parts of their changes.

    A mapping has values: ``{body: {quantity: value}}``, ``{"joints": {joint: {quantity: value}}}``,
    ``{"gravity": value}`` and ``{force parameter: value}``. The change of a value is the difference from the value of
    the world.
    """
    check_class(world, World, "world")
    if not isinstance(parameters, Mapping):
        width, by = len(world.values(parameters)), list(parameters)
        return by, [arrays.floats(np.zeros(width) if changes is None else changes, "changes", (width,))]
    if changes is not None:
        raise HydroelasticError("values of parameters, as a mapping, need no changes")
    by, parts = [], []
    for name, kind, size, value in _leaves(world, parameters):
        parameter = kind(name) if callable(kind) else kind
        array = arrays.floats(value, name, (size,) if size else ())
        by.append(parameter)
        current = arrays.floats(world.values([parameter]), name, (max(size, 1),))
        parts.append((array if size else array[..., None]) - current)
    return by, parts or [arrays.floats(np.zeros(0), "changes", (0,))]


def _leaves(world: World, values: Mapping[str, Any]) -> Iterator[tuple[str, Any, int, Any]]:
    """Yields the names, parameters, sizes and values of nested values, in the order of sorted keys, as JAX orders them."""
    for name, value in sorted(values.items()):
        if name == "joints":
            for joint, quantities in sorted(_mapping(value, "joints").items()):
                for quantity, number in sorted(_mapping(quantities, f"joints[{joint!r}]").items()):
                    parameter = Parameter.joint(joint, quantity)
                    yield joint, parameter, parameter.dimension if parameter.dimension > 1 else 0, number
        elif isinstance(value, Mapping):
            world.index_of(name)
            for quantity, number in sorted(value.items()):
                if quantity not in QUANTITIES:
                    known = ", ".join(QUANTITIES)
                    raise HydroelasticError(f"body {name!r} has no quantity {quantity!r}: expected one of {known}")
                kind, size = QUANTITIES[quantity]
                yield name, kind, size, number
        elif name == "gravity":
            yield name, Parameter.gravity(), 3, value
        else:
            yield name, Parameter.force_parameter, 0, value


def _mapping(value: Any, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise TypeError(f'{name} is {type(value).__name__}: expected {{"joints": {{joint: {{quantity: value}}}}}}')
    return value


def states(
    arrays: Arrays,
    function: Rollout,
    changes: Sequence[Any],
    start: Sequence[Any] | None,
    start_step: Any,
) -> list[Any]:
    """Computes the arrays of the states of a rollout. The recorded states are the first axis, unless the function
    returns only the last state. An array of joints is None if it is empty."""
    if start is None:
        if not (isinstance(start_step, int) and start_step == 0):
            raise HydroelasticError("start_step needs start: without one, the rollout starts at the initial time of the world")
        outputs = arrays.evaluated(function, [1] * len(changes), changes)
    else:
        ranks, parts = _start_parts(arrays, function, start)
        ranks, parts = [*ranks, *[1] * len(changes), 1], [*parts, *changes, arrays.count(start_step)[..., None]]
        outputs = arrays.evaluated(function, ranks, parts)
    lead, recorded = outputs.shape[:-1], () if function.only_last else (function.states,)
    parts = [part.reshape(*lead, *recorded, *shape) for part, shape in zip(function.split(outputs), function.shapes)]
    return [part if which < 2 or shape[0] else None for which, (part, shape) in enumerate(zip(parts, function.shapes))]


def _start_parts(arrays: Arrays, function: Rollout, start: Sequence[Any]) -> tuple[list[int], list[Any]]:
    """Returns the ranks and the parts of a row that has an initial state."""
    if not isinstance(start, tuple) or len(start) != len(ARRAYS):
        raise TypeError(f"the initial state must be a State of hydroelastic.jax or hydroelastic.torch, but is {type(start).__name__}")
    read = []
    for name, value, shape in zip(ARRAYS, start, function.shapes):
        if value is None and shape[0]:
            raise HydroelasticError(f"start needs {name}, because the world has joints")
        read.append(arrays.floats(np.zeros(shape) if value is None else value, name, shape))
    poses, twists, positions, velocities, rotations, spins = read
    ranks, parts = [3, 2, 1, 1], [poses, twists, positions, velocities]
    if function.shapes[4][0]:
        ranks, parts = [3, 3, 2, 1, 1, 2], [poses, arrays.poses(rotations), twists, positions, velocities, spins]
    return ranks, parts


def initial_arrays(world: World) -> list[Floats | None]:
    """Returns the arrays of the initial state of a world. An array of joints is None if it is empty."""
    check_class(world, World, "world")
    start = world.initial_state
    found = [getattr(start, name) for name in ARRAYS]
    return [array if which < 2 or len(array) else None for which, array in enumerate(found)]


def paired(numbers: Floats, vectors: Floats) -> tuple[Floats, Floats, Callable[[Floats], Floats]]:
    """Groups vectors by the numbers that they belong to.

    Numbers and vectors have the same number of leading axes. A leading axis of numbers may have the length 1 instead of
    the length of the vectors. Returns the numbers as rows, (m, numbers), the c vectors of each row, (m, c, entries),
    and a function that restores the leading axes of results, (m, c, results).
    """
    front = vectors.shape[:-1]
    shared = [axis for axis, length in enumerate(front) if numbers.shape[axis] == length]
    repeated = [axis for axis in range(len(front)) if axis not in shared]
    order = [*shared, *repeated, len(front)]
    count = math.prod(front[axis] for axis in shared)
    each = math.prod(front[axis] for axis in repeated)

    def restored(results: Floats) -> Floats:
        axes = results.reshape(*(front[axis] for axis in order[:-1]), results.shape[-1])
        return axes.transpose(np.argsort(order))

    rows = numbers.reshape(count, numbers.shape[-1])
    return rows, vectors.transpose(order).reshape(count, each, vectors.shape[-1]), restored


def recorded_count(plan: Plan) -> int:
    """Returns the number of states that a plan records."""
    return 1 + -(-plan.steps // plan.record_every)


def one_step(plan: Plan) -> Plan:
    """Returns the plan of a single step."""
    check_class(plan, Plan, "plan")
    return _recording(plan, 1, steps=1)


def first_error(errors: Errors, count: int) -> HydroelasticError:
    """Returns the exception of the first invalid row. If there are several rows, its message has the index of the row.
    """
    index, error = min(errors.items())
    return error if count == 1 else type(error)(f"row {index} of {count}: {error}")


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
    """Returns the results of all rows that raise no exception, by the index of the row. Adds the exceptions to
    ``errors``."""
    results: dict[int, _T] = {}
    for index, row in enumerate(rows):
        try:
            results[index] = function(row)
        except HydroelasticError as error:
            errors[index] = error
    return results
