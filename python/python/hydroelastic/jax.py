"""Wrenches, steps and rollouts as differentiable functions of JAX: ``jit``, ``vmap``, ``grad``, ``jvp`` and their like.

    import jax, hydroelastic as he, hydroelastic.jax as hj
    jax.config.update("jax_enable_x64", True)
    pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    def lift(height):
        return hj.wrench(pair, hj.pose(jax.numpy.array([0.0, 0.0, 1.0]) * height), hj.pose())[5]
    force, slope = jax.jit(jax.value_and_grad(lift))(0.195)  # N, N/m

The contact is computed by the library on the CPU, with its own Jacobians: JAX does not trace it. What is computed is
the value alone where no derivative is taken, and where one is, value and Jacobian in one call: the value may then
differ by round-off. Gradients of rollouts by many numbers take the steps back instead, at about the same cost whatever
the numbers are: see ``rollout``.

Arrays are of float64; arrays of integers are converted. ``jax_enable_x64`` must be on, because contact in float32 has no accurate
digits. Arguments may have any axes in front, which are broadcast against each other, and then so has the result; ``jax.vmap`` makes such a
batch too. All cores compute a batch.

Derivatives by poses. Poses are (4, 4). A tangent dT of a pose counts as the twist (ω, v) in world axes by which it
moves the pose: [ω]× is the skew part of dR Rᵀ, and v is the last column. What is not skew in dR Rᵀ would leave the
rotations, and does not count; nor does the last row. The cotangent of a pose is the transpose: with g the derivative by
the angular part of that twist and f by the linear part, ½ [g]× R is its rotation block and f its last column. So by the
chain rule through anything that makes rotations (``pose``, ``moved_pose``, quaternions, kinematics) derivatives are
right, and a step along a cotangent itself leads off the rotations: optimize over vectors, and make poses of them.

What the library refuses (a pose that is not rigid, a number that is not finite, a rollout that ends early). A call
without a transformation raises HydroelasticError. Inside ``jit``, ``vmap``, ``grad`` and their like an exception would
be undefined behavior of JAX: rows that are refused are NaN, the others are right, and the reason is a warning of the
logger ``hydroelastic.jax``.

Second derivatives do not exist, and to ask for them (``jax.hessian``, ``grad`` of ``grad``) raises NotImplementedError.
For least squares, JᵀJ of ``jax.jacobian`` takes their place.
"""

from __future__ import annotations

import functools
import logging
import math
import threading
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, NoReturn, TypeAlias

import numpy as np

try:
    import jax
    import jax.numpy as jnp
    from jax.extend.core import Primitive
    from jax.interpreters import ad, batching, mlir
except ImportError as error:
    raise ImportError('hydroelastic.jax needs JAX: pip install "hydroelastic[jax]"') from error

try:
    # Hands over the buffers of the program as they are: some 60 µs less a call than pure_callback, which copies them.
    from jax.experimental.buffer_callback import buffer_callback as _buffer_callback
except ImportError:
    _buffer_callback = None  # type: ignore[assignment, unused-ignore]

from . import _autodiff
from ._core import HydroelasticError, Pair, Parameter, Plan, World

__all__ = ["State", "final_state", "initial_state", "moved_pose", "pose", "rollout", "step", "wrench"]

Array: TypeAlias = jax.Array
# What an argument may be: an array of JAX or numpy, or a list of numbers.
_Array: TypeAlias = Any

_log = logging.getLogger(__name__)


class State(NamedTuple):
    """The n bodies of a world at one time, in the order of the world's; recorded states have k in front.

    poses : (n, 4, 4), poses of the body frames in the world.
    twists : (n, 6): spin (rad/s), and velocity of the center of mass (m/s), world axes.
    """

    poses: Array
    twists: Array


def pose(translation: _Array = (0.0, 0.0, 0.0), rotation_vector: _Array = (0.0, 0.0, 0.0)) -> Array:
    """The pose of a frame: a 4×4 homogeneous matrix.

    Parameters
    ----------
    translation : (3,) position of the frame's origin (m).
    rotation_vector : (3,) axis times angle (rad) by which the frame is turned. At zero too, derivatives of all orders
        are right.

    Returns
    -------
    (4, 4) float64.
    """
    translation = _finite(_floats(translation, "translation", (3,)), "translation")
    vector = _finite(_floats(rotation_vector, "rotation_vector", (3,)), "rotation_vector")
    return _finite(_posed(vector, translation), "the pose")


def moved_pose(pose: _Array, twist: _Array) -> Array:
    """A pose after a small motion in world axes: the frame turns about its own origin by the angular part of a twist
    (rad), and its origin moves by the linear part (m).

    Parameters
    ----------
    pose : (4, 4).
    twist : (6,) angular, linear.

    Returns
    -------
    (4, 4) float64.
    """
    pose = _finite(_floats(pose, "pose", (4, 4)), "pose")
    twist = _finite(_floats(twist, "twist", (6,)), "twist")
    return _finite(_moved(pose, twist), "the pose")


def wrench(
    pair: Pair,
    pose_a: _Array,
    pose_b: _Array,
    twist_a: _Array | None = None,
    twist_b: _Array | None = None,
    *,
    moduli: _Array | None = None,
    law: _Array | None = None,
) -> Array:
    """The wrenches of a contact. Without twists those of bodies at rest; with them, dissipation and friction take part.

    Parameters
    ----------
    pair : the shapes; no derivative.
    pose_a, pose_b : (4, 4).
    twist_a, twist_b : (6,) angular (rad/s), linear (m/s, of the body's origin), world axes; None for zero.
    moduli : (2,) of A and B (Pa), in place of those of the pair; where B is rigid, the second has no effect.
    law : (2,) dissipation (s/m) and friction coefficient, in place of those of the pair; without twists they do not
        matter.

    Returns
    -------
    (12,): torque (N m) and force (N) on A, about A's origin, then those on B, about B's.
    """
    found: Array = _autodiff.wrench(_Arrays(), pair, (pose_a, pose_b), (twist_a, twist_b), moduli, law)
    return found


def initial_state(world: World) -> State:
    """The state that rollouts of a world start from."""
    _check_precision()
    state = world.initial_state
    return State(jnp.asarray(state.poses), jnp.asarray(state.twists))


def rollout(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] = (),
    changes: _Array | None = None,
    *,
    start: State | None = None,
    start_step: _Array | int = 0,
) -> State:
    """The recorded states of a rollout, by its initial state and by changes of parameters of the world.

    Parameters
    ----------
    world : no derivative but by its parameters.
    plan : the steps, and which states are recorded.
    parameters : what changes, p numbers together.
    changes : (p,), added to what is in the world, as by World.perturbed; None for zeros.
    start : initial state; None for that of the world, which then has no derivative but by parameters: faster with few
        of them. Bodies that forces do not move stay as they are in the world, so that their part of it has no effect.
    start_step : integer, how many time steps after the initial time of the world the rollout starts: only with start, for
        worlds with controls and paths. An integer has no derivatives.

    Returns
    -------
    State with k recorded states in front: poses (k, n, 4, 4), twists (k, n, 6).

    Gradients by more than 12 numbers (96 over implicit steps) are found by a sweep back, in a time that does not depend on p;
    12 numbers for each body that forces move count too if there is a start. Else, and in forward mode, the Jacobian is
    found, whose time grows with them.
    """
    return _states(world, plan, parameters, changes, start, start_step, only_last=False)


def final_state(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] = (),
    changes: _Array | None = None,
    *,
    start: State | None = None,
    start_step: _Array | int = 0,
) -> State:
    """The last state of a rollout: arguments as those of rollout."""
    return _states(world, plan, parameters, changes, start, start_step, only_last=True)


def step(
    world: World,
    plan: Plan,
    state: State,
    parameters: Sequence[Parameter] = (),
    changes: _Array | None = None,
    *,
    start_step: _Array | int = 0,
) -> State:
    """The state one time step of the plan after another one: arguments as those of rollout. For controls, take
    Parameter.control of the interval that the step is in.
    """
    return _states(world, _autodiff.one_step(plan), parameters, changes, state, start_step, only_last=True)


def _states(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter],
    changes: _Array | None,
    start: State | None,
    start_step: _Array | int,
    *,
    only_last: bool,
) -> State:
    function = _autodiff.Rollout(world, plan, parameters, from_state=start is not None, only_last=only_last)
    given = None if start is None else (start.poses, start.twists)
    return State(*_autodiff.states(_Arrays(), function, changes, given, start_step))


class _Arrays:
    """What JAX brings to _autodiff.wrench and _autodiff.states."""

    def floats(self, value: _Array, name: str, shape: tuple[int, ...]) -> Array:
        return _floats(value, name, shape)

    def count(self, value: _Array | int) -> Array:
        return _count(value)

    def evaluated(self, function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Array]) -> Array:
        return _evaluated(function, ranks, parts)


def _check_precision() -> None:
    if not getattr(jax.config, "jax_enable_x64"):
        raise TypeError(
            "hydroelastic computes in float64 alone, and JAX makes float32 of every array until "
            'jax.config.update("jax_enable_x64", True) is called: rounded to float32, poses lose the depth of a contact'
        )


def _check_precision_of_threads() -> None:
    """JAX calls back from threads of its own, whose arrays are float32 if jax_enable_x64 is on in this thread alone."""
    found: list[bool] = []
    thread = threading.Thread(target=lambda: found.append(getattr(jax.config, "jax_enable_x64")))
    thread.start()
    thread.join()
    if found != [True]:
        raise TypeError(
            'hydroelastic needs jax.config.update("jax_enable_x64", True) inside jit, grad and their like: jax.enable_x64 '
            "as a context is of one thread, and the library is called from others, which would round its arrays to float32"
        )


def _rows_of(function: _autodiff.Function, numbers: Any) -> _autodiff.Floats:
    """Numbers with any axes in front as rows."""
    count = math.prod(numbers.shape[:-1])
    return np.asarray(numbers).reshape(count, function.numbers)


def _floats(value: _Array, name: str, shape: tuple[int, ...]) -> Array:
    """An argument as a float64 array that ends in a shape."""
    _check_precision()
    array = _array(value, name)
    if jnp.issubdtype(array.dtype, jnp.integer):
        array = array.astype(jnp.float64)
    if array.dtype != jnp.float64:
        raise TypeError(
            f"{name} must be an array of float64, but is one of {array.dtype}: contact is computed in float64 alone, and "
            "a conversion would hide lost digits (array.astype(jax.numpy.float64) makes one)"
        )
    if array.ndim < len(shape) or array.shape[array.ndim - len(shape) :] != shape:
        raise HydroelasticError(f"{name} must have the shape {shape}, or end in it, but has {array.shape}")
    return array


def _array(value: _Array | int, name: str) -> Array:
    try:
        return jnp.asarray(value)
    except OverflowError as error:
        raise HydroelasticError(f"{name} has a number that is too large: {error}") from None


def _finite(array: Array, name: str) -> Array:
    """Returns the array. Raises an error if a number is not finite, except inside transformations, where it propagates."""
    if not isinstance(array, jax.core.Tracer) and not np.isfinite(np.asarray(array)).all():
        raise HydroelasticError(f"{name} must be finite, but is {np.asarray(array).tolist()}")
    return array


def _count(start_step: _Array | int) -> Array:
    array = _array(start_step, "start_step")
    if not jnp.issubdtype(array.dtype, jnp.integer):
        raise TypeError(f"start_step must be an integer or an array of integers, but is of {array.dtype}")
    return array.astype(jnp.float64)


def _evaluated(function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Array]) -> Array:
    """A function of the numbers of some arrays, each with so many axes of its own, of which those of the poses come first."""
    numbers = _joined(tuple(ranks), parts)
    if isinstance(numbers, jax.core.Tracer):
        return _values(function, numbers)
    # No transformation: an exception may go through.
    rows = _rows_of(function, numbers)
    values, errors = function.values(rows)
    if errors:
        raise _autodiff.first_error(errors, len(rows))
    return jnp.asarray(values.reshape(*numbers.shape[:-1], function.outputs))


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _values(function: _autodiff.Function, numbers: Array) -> Array:
    lead = numbers.shape[:-1]
    (values,) = _called_back(function, function.values, [(*lead, function.outputs)], numbers)
    return values


@_values.defjvp
def _values_jvp(function: _autodiff.Function, primals: tuple[Array], tangents: tuple[Array]) -> tuple[Array, Array]:
    (numbers,), (tangent,) = primals, tangents
    if function.sweeps_back:
        return _values(function, numbers), _pushforward(function, numbers, _local(function.poses, numbers, tangent))
    values, jacobian = _values_and_jacobian(function, numbers)
    # Linear in the tangent, which is what lets JAX transpose it.
    return values, _along(function.poses, jacobian, numbers, tangent)


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _values_and_jacobian(function: _autodiff.Function, numbers: Array) -> tuple[Array, Array]:
    shape = (*numbers.shape[:-1], function.outputs)
    shapes = [shape, (*shape, function.columns)]
    values, jacobian = _called_back(function, function.values_and_jacobians, shapes, numbers)
    return values, jacobian


@_values_and_jacobian.defjvp
def _no_second_derivatives(function: _autodiff.Function, primals: tuple[Array], tangents: tuple[Array]) -> NoReturn:
    raise _second_derivative(function)


def _second_derivative(function: _autodiff.Function) -> NotImplementedError:
    return NotImplementedError(
        f"the {function.name} of hydroelastic has first derivatives only, and a second one was asked for (by jax.hessian, "
        "or grad or jvp of grad): for least squares, J.T @ J of jax.jacobian takes its place"
    )


@functools.partial(jax.jit, static_argnums=0)
def _along(poses: int, jacobian: Array, numbers: Array, tangent: Array) -> Array:
    """The Jacobian times a tangent of numbers that start with so many poses."""
    return jnp.einsum("...ij,...j->...i", jacobian, _local(poses, numbers, tangent))


@functools.partial(jax.jit, static_argnums=0)
def _local(poses: int, numbers: Array, tangent: Array) -> Array:
    """A tangent of numbers that start with so many poses, by the columns of a Jacobian: those of poses as twists."""
    if poses:
        lead, entries = numbers.shape[:-1], poses * _autodiff.POSE
        at, moved = (it[..., :entries].reshape(*lead, poses, 4, 4) for it in (numbers, tangent))
        turn = jnp.einsum("...ik,...jk->...ij", moved[..., :3, :3], at[..., :3, :3])
        skew = 0.5 * (turn - jnp.swapaxes(turn, -1, -2))
        angular = jnp.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
        twists = jnp.concatenate([angular, moved[..., :3, 3]], -1).reshape(*lead, -1)
        tangent = jnp.concatenate([twists, tangent[..., entries:]], -1)
    return tangent


# Products of a Jacobian with vectors, without the Jacobian: linear in the vectors, and each the transpose of the other. Numbers
# and vectors have as many axes in front, and one of the numbers may have the length 1.
_pushforward_p = Primitive("hydroelastic_pushforward")
_pullback_p = Primitive("hydroelastic_pullback")


def _pushforward(function: _autodiff.Function, numbers: Array, tangents: Array) -> Array:
    """The Jacobian times vectors."""
    found: Array = _pushforward_p.bind(numbers, tangents, function=function)
    return found


def _pushed(numbers: Array, tangents: Array, *, function: _autodiff.Function) -> Array:
    return _product_called_back(function, function.pushforwards, function.outputs, numbers, tangents)


def _pulled(numbers: Array, cotangents: Array, *, function: _autodiff.Function) -> Array:
    return _product_called_back(function, function.pullbacks, function.columns, numbers, cotangents)


def _make_linear(primitive: Any, transposed: Any, evaluated: Callable[..., Array], width: Callable[..., int]) -> None:
    """Tells JAX what a product is, how it is differentiated and transposed, and how batches of it are made."""

    def shape(_numbers: Any, vectors: Any, *, function: _autodiff.Function) -> Any:
        return jax.core.ShapedArray((*vectors.shape[:-1], width(function)), vectors.dtype)

    def tangent(primals: Sequence[Any], tangents: Sequence[Any], *, function: _autodiff.Function) -> tuple[Any, Any]:
        numbers, vectors = primals
        if type(tangents[0]) is not ad.Zero:
            raise _second_derivative(function)
        return tuple(primitive.bind(numbers, it, function=function) for it in (vectors, tangents[1]))

    def cotangent(given: Any, numbers: Any, _vectors: Any, *, function: _autodiff.Function) -> list[Any]:
        nothing = type(given) is ad.Zero
        return [None, None if nothing else transposed.bind(numbers, given, function=function)]

    def batch(args: Sequence[Any], dims: Sequence[int | None], *, function: _autodiff.Function) -> tuple[Any, int]:
        size = next(arg.shape[dim] for arg, dim in zip(args, dims) if dim is not None)
        numbers, vectors = (arg[None] if dim is None else jnp.moveaxis(arg, dim, 0) for arg, dim in zip(args, dims))
        vectors = jnp.broadcast_to(vectors, (size, *vectors.shape[1:]))
        return primitive.bind(numbers, vectors, function=function), 0

    primitive.def_impl(evaluated)
    primitive.def_abstract_eval(shape)
    mlir.register_lowering(primitive, mlir.lower_fun(evaluated, multiple_results=False))
    ad.primitive_jvps[primitive] = tangent
    ad.primitive_transposes[primitive] = cotangent
    batching.primitive_batchers[primitive] = batch


_make_linear(_pushforward_p, _pullback_p, _pushed, lambda function: function.outputs)
_make_linear(_pullback_p, _pushforward_p, _pulled, lambda function: function.columns)


def _product_called_back(
    function: _autodiff.Function,
    call: Callable[[_autodiff.Floats, _autodiff.Floats], tuple[_autodiff.Floats, _autodiff.Errors]],
    width: int,
    numbers: Array,
    vectors: Array,
) -> Array:
    """What a call of the library gives for rows of numbers and the vectors of each, when the program runs."""

    def host(numbers: Any, vectors: Any) -> tuple[_autodiff.Floats, ...]:
        numbers, vectors = np.asarray(numbers), np.asarray(vectors)
        rows, of_rows, restored = _autodiff.paired(numbers, vectors)
        found = _checked(function, lambda: call(rows, of_rows), len(rows))
        return (np.full((*vectors.shape[:-1], width), np.nan) if found is None else restored(found[0]),)

    (found,) = _on_host(host, [(*vectors.shape[:-1], width)], numbers, vectors)
    return found


def _checked(function: _autodiff.Function, call: Callable[[], tuple[Any, ...]], count: int) -> list[Any] | None:
    """The results of a call for so many rows; what is refused is logged. None if the call failed."""
    try:
        *found, errors = call()
    except Exception:
        # An exception that went on from here would be undefined behavior.
        _log.exception("%s: NaN, since the call failed", function.name)
        return None
    if errors:
        why = _autodiff.first_error(errors, count)
        _log.warning("%s: NaN in %d of %d rows: %s", function.name, len(errors), count, why)
    return found


def _called_back(
    function: _autodiff.Function,
    call: Callable[[_autodiff.Floats], tuple[Any, ...]],
    shapes: Sequence[tuple[int, ...]],
    numbers: Array,
) -> tuple[Array, ...]:
    """The arrays that a call of the library gives for rows of numbers, when the program runs."""
    lead = numbers.ndim - 1

    def host(numbers: Any) -> tuple[_autodiff.Floats, ...]:
        numbers = np.asarray(numbers)
        front = numbers.shape[:-1]
        rows = _rows_of(function, numbers)
        tails = [shape[lead:] for shape in shapes]
        found = _checked(function, lambda: call(rows), len(rows))
        if found is None:
            return tuple(np.full((*front, *tail), np.nan) for tail in tails)
        return tuple(it.reshape(*front, *tail) for it, tail in zip(found, tails))

    return _on_host(host, shapes, numbers)


def _on_host(
    host: Callable[..., tuple[_autodiff.Floats, ...]], shapes: Sequence[tuple[int, ...]], *arrays: Array
) -> tuple[Array, ...]:
    """The results, of such shapes, of a function of arrays, when the program runs."""

    def into_buffers(_context: Any, results: Sequence[Any], *arrays: Any) -> None:
        for result, values in zip(results, host(*arrays)):
            np.asarray(result)[...] = values

    struct: Callable[..., Any] = jax.ShapeDtypeStruct
    out = tuple(struct(shape, jnp.float64) for shape in shapes)
    found: tuple[Array, ...]
    if _buffer_callback is not None and jax.default_backend() == "cpu":
        found = _buffer_callback(into_buffers, out, vmap_method="broadcast_all")(*arrays)
        return found
    _check_precision_of_threads()
    found = jax.pure_callback(host, out, *arrays, vmap_method="broadcast_all")
    return found


@functools.partial(jax.jit, static_argnums=0)
def _joined(ranks: tuple[int, ...], parts: Sequence[Array]) -> Array:
    """Arrays with any axes in front of so many of their own, as numbers with the common axes in front."""
    flat = [part.reshape(*part.shape[: part.ndim - rank], -1) for part, rank in zip(parts, ranks)]
    lead = jnp.broadcast_shapes(*(part.shape[:-1] for part in flat))
    return jnp.concatenate([jnp.broadcast_to(part, lead + part.shape[-1:]) for part in flat], -1)


@jax.jit
def _posed(vector: Array, translation: Array) -> Array:
    return _homogeneous(_rotation(vector), translation)


@jax.jit
def _moved(pose: Array, twist: Array) -> Array:
    return _homogeneous(_rotation(twist[..., :3]) @ pose[..., :3, :3], pose[..., :3, 3] + twist[..., 3:])


def _rotation(vector: Array) -> Array:
    """The rotation by a rotation vector, (3, 3): I + sin θ/θ K + (1 − cos θ)/θ² K², with both factors as functions of
    θ², so that all derivatives are right at zero.
    """
    square = jnp.sum(vector * vector, -1)[..., None, None]
    small = square < 0.1
    angle = jnp.sqrt(jnp.where(small, 1.0, square))
    # Taylor series to θ¹⁰: below 0.1, the next term is under 1e-15.
    sine = _series(square, (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800))
    cosine = _series(square, (1 / 2, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600))
    first = jnp.where(small, sine, jnp.sin(angle) / angle)
    second = jnp.where(small, cosine, 0.5 * (jnp.sin(0.5 * angle) / (0.5 * angle)) ** 2)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    zero = jnp.zeros_like(x)
    cross = jnp.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*vector.shape[:-1], 3, 3)
    return jnp.eye(3) + first * cross + second * (cross @ cross)


def _series(square: Array, factors: Sequence[float]) -> Array:
    total = jnp.zeros_like(square)
    for factor in reversed(factors):
        total = total * square + factor
    return total


def _homogeneous(rotation: Array, translation: Array) -> Array:
    lead = jnp.broadcast_shapes(rotation.shape[:-2], translation.shape[:-1])
    top = jnp.concatenate(
        [jnp.broadcast_to(rotation, (*lead, 3, 3)), jnp.broadcast_to(translation, (*lead, 3))[..., None]], -1
    )
    last = jnp.broadcast_to(jnp.array([[0.0, 0.0, 0.0, 1.0]]), (*lead, 1, 4))
    return jnp.concatenate([top, last], -2)
