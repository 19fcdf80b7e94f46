"""Wrenches, clearances, steps and rollouts as differentiable functions of JAX, for ``jit``, ``vmap``, ``grad``, ``jvp``.

    import jax, hydroelastic as he, hydroelastic.jax as hj
    jax.config.update("jax_enable_x64", True)
    pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    def lift(height):
        return hj.wrench(pair, hj.pose(jax.numpy.array([0.0, 0.0, 1.0]) * height), hj.pose())[5]
    force, slope = jax.jit(jax.value_and_grad(lift))(0.195)  # N, N/m

The library computes the contact on the CPU, with its own Jacobians. JAX does not trace it. If no derivative is taken,
only the value is computed. Otherwise, one call computes the value and the Jacobian, and the value may differ by
round-off. Gradients of rollouts with respect to many numbers use reverse mode instead, whose cost does not depend on
how many numbers there are. See ``rollout``.

Arrays are of float64. Arrays of integers are converted. ``jax_enable_x64`` must be on, because contact in float32 has
no accurate digits. Arguments may have additional leading axes, which are broadcast against each other and which the
result then has too. ``jax.vmap`` creates such a batch too. All cores compute a batch.

Derivatives with respect to poses. Poses are (4, 4). A tangent dT of a pose counts as the twist (ω, v) in world axes
that moves the pose: [ω]× is the skew part of dR Rᵀ, and v is the last column of dT. The symmetric part of dR Rᵀ would
leave the rotations, so it has no effect. The last row of dT has no effect either. The cotangent of a pose is the
transpose. Let g be the derivative with respect to the angular part of that twist, and f the derivative with respect to
the linear part. The cotangent has the rotation block ½ [g]× R and the last column f. So derivatives are correct by the
chain rule through any function that makes rotations (``pose``, ``moved_pose``, quaternions, kinematics). A step along a
cotangent itself leaves the rotations: optimize over vectors, and compute poses from them.

Errors (a pose that is not rigid, a number that is not finite, a rollout that ends early) raise HydroelasticError in a
call without a transformation. Inside ``jit``, ``vmap``, ``grad`` and similar transformations, an exception would be
undefined behavior of JAX. There, the result of an invalid row is NaN, the other rows are correct, and the logger
``hydroelastic.jax`` writes a warning with the reason.

Second derivatives are not available. ``jax.hessian`` and ``grad`` of ``grad`` raise NotImplementedError. For least
squares, use JᵀJ of ``jax.jacobian`` instead.
"""

from __future__ import annotations

import functools
import logging
import math
import threading
from collections.abc import Callable, Mapping, Sequence
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
    # This callback gets the buffers of the program without a copy. A call takes about 60 µs less than pure_callback.
    from jax.experimental.buffer_callback import buffer_callback as _buffer_callback
except ImportError:
    _buffer_callback = None  # type: ignore[assignment, unused-ignore]

from . import _autodiff
from ._autodiff_docs import documented
from ._core import HydroelasticError, Pair, Parameter, Plan, TaxelGrid, World

__all__ = [
    "State",
    "clearance",
    "final_state",
    "initial_state",
    "moved_pose",
    "pose",
    "rollout",
    "step",
    "tactile_image",
    "wrench",
]

Array: TypeAlias = jax.Array
# Type of an argument: an array of JAX or NumPy, or a list of numbers.
_Array: TypeAlias = Any

_log = logging.getLogger(__name__)
_documented = documented("jax.Array")


@_documented
class State(NamedTuple):
    poses: Array
    twists: Array
    joint_positions: Array | None = None
    joint_velocities: Array | None = None
    ball_joint_rotations: Array | None = None
    ball_joint_velocities: Array | None = None


@_documented
def pose(translation: _Array = (0.0, 0.0, 0.0), rotation_vector: _Array = (0.0, 0.0, 0.0)) -> Array:
    translation = _finite(_floats(translation, "translation", (3,)), "translation")
    vector = _finite(_floats(rotation_vector, "rotation_vector", (3,)), "rotation_vector")
    return _finite(_posed(vector, translation), "the pose")


@_documented
def moved_pose(pose: _Array, twist: _Array) -> Array:
    pose = _finite(_floats(pose, "pose", (4, 4)), "pose")
    twist = _finite(_floats(twist, "twist", (6,)), "twist")
    return _finite(_moved(pose, twist), "the pose")


@_documented
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
    wrenches: Array = _autodiff.wrench(_Arrays(), pair, (pose_a, pose_b), (twist_a, twist_b), moduli, law)
    return wrenches


@_documented
def tactile_image(
    pair: Pair,
    grid: TaxelGrid,
    pose_a: _Array,
    pose_b: _Array,
    twist_a: _Array | None = None,
    twist_b: _Array | None = None,
    *,
    body: str = "a",
    moduli: _Array | None = None,
    law: _Array | None = None,
) -> Array:
    poses, twists = (pose_a, pose_b), (twist_a, twist_b)
    forces: Array = _autodiff.tactile_image(_Arrays(), pair, grid, body, poses, twists, moduli, law)
    return forces


@_documented
def clearance(pair: Pair, pose_a: _Array, pose_b: _Array, *, moduli: _Array | None = None) -> Array:
    distance: Array = _autodiff.clearance(_Arrays(), pair, (pose_a, pose_b), moduli)
    return distance


@_documented
def initial_state(world: World) -> State:
    _check_precision()
    arrays: list[Any] = [None if array is None else jnp.asarray(array) for array in _autodiff.initial_arrays(world)]
    return State(*arrays)


@_documented
def rollout(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Array | None = None,
    *,
    start: State | None = None,
    start_step: _Array | int = 0,
) -> State:
    return _states(world, plan, parameters, changes, start, start_step, only_last=False)


@_documented
def final_state(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Array | None = None,
    *,
    start: State | None = None,
    start_step: _Array | int = 0,
) -> State:
    return _states(world, plan, parameters, changes, start, start_step, only_last=True)


@_documented
def step(
    world: World,
    plan: Plan,
    state: State,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Array | None = None,
    *,
    start_step: _Array | int = 0,
) -> State:
    return _states(world, _autodiff.one_step(plan), parameters, changes, state, start_step, only_last=True)


def _states(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any],
    changes: _Array | None,
    start: State | None,
    start_step: _Array | int,
    *,
    only_last: bool,
) -> State:
    by, parts = _autodiff.parameters_and_changes(_Arrays(), world, parameters, changes)
    function = _autodiff.Rollout(world, plan, by, from_state=start is not None, only_last=only_last)
    return State(*_autodiff.states(_Arrays(), function, parts, start, start_step))


class _Arrays:
    """Operations of JAX for ``_autodiff.wrench`` and ``_autodiff.states``."""

    def floats(self, value: _Array, name: str, shape: tuple[int, ...]) -> Array:
        return _floats(value, name, shape)

    def count(self, value: _Array | int) -> Array:
        return _count(value)

    def poses(self, rotations: Array) -> Array:
        return _homogeneous(rotations, jnp.zeros(3))

    def evaluated(self, function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Array]) -> Array:
        return _evaluated(function, ranks, parts)


def _check_precision() -> None:
    if not getattr(jax.config, "jax_enable_x64"):
        raise TypeError(
            "hydroelastic computes in float64 alone, and JAX makes float32 of every array until "
            'jax.config.update("jax_enable_x64", True) is called: rounded to float32, poses lose the depth of a contact'
        )


def _check_precision_of_threads() -> None:
    """Checks the precision in other threads. JAX runs callbacks in its own threads, whose arrays are float32 if
    jax_enable_x64 is on in this thread only."""
    settings: list[bool] = []
    thread = threading.Thread(target=lambda: settings.append(getattr(jax.config, "jax_enable_x64")))
    thread.start()
    thread.join()
    if settings != [True]:
        raise TypeError(
            'hydroelastic needs jax.config.update("jax_enable_x64", True) inside jit, grad and their like: jax.enable_x64 '
            "as a context is of one thread, and the library is called from others, which would round its arrays to float32"
        )


def _rows_of(function: _autodiff.Function, numbers: Any) -> _autodiff.Floats:
    """Reshapes numbers with any leading axes to rows."""
    count = math.prod(numbers.shape[:-1])
    return np.asarray(numbers).reshape(count, function.numbers)


def _floats(value: _Array, name: str, shape: tuple[int, ...]) -> Array:
    """Converts an argument to a float64 array whose last axes have a shape."""
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
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be an array or a list of numbers: {error}") from None


def _finite(array: Array, name: str) -> Array:
    """Returns the array. Raises an error if a number is not finite. Inside transformations, the number propagates
    instead."""
    if not isinstance(array, jax.core.Tracer) and not np.isfinite(np.asarray(array)).all():
        raise HydroelasticError(f"{name} must be finite, but is {np.asarray(array).tolist()}")
    return array


def _count(start_step: _Array | int) -> Array:
    array = _array(start_step, "start_step")
    if not jnp.issubdtype(array.dtype, jnp.integer):
        raise TypeError(f"start_step must be an integer or an array of integers, but is of {array.dtype}")
    return array.astype(jnp.float64)


def _evaluated(function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Array]) -> Array:
    """Evaluates a function of the concatenated numbers of arrays, poses first. The rank is the number of axes of an
    array without additional leading axes."""
    try:
        numbers = _joined(tuple(ranks), parts)
    except ValueError as error:
        raise HydroelasticError(f"the leading axes of the arguments must be broadcastable: {error}") from None
    if isinstance(numbers, jax.core.Tracer):
        return _values(function, numbers)
    # Outside transformations, an exception may be raised.
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
    # The product is linear in the tangent, so JAX can transpose it.
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
    """Multiplies the Jacobian with a tangent of numbers whose first ``poses`` items are poses."""
    return jnp.einsum("...ij,...j->...i", jacobian, _local(poses, numbers, tangent))


@functools.partial(jax.jit, static_argnums=0)
def _local(poses: int, numbers: Array, tangent: Array) -> Array:
    """Converts a tangent of numbers, whose first ``poses`` items are poses, to the columns of a Jacobian: the tangents
    of poses become twists."""
    if poses:
        lead, entries = numbers.shape[:-1], poses * _autodiff.POSE
        at, moved = (array[..., :entries].reshape(*lead, poses, 4, 4) for array in (numbers, tangent))
        turn = jnp.einsum("...ik,...jk->...ij", moved[..., :3, :3], at[..., :3, :3])
        skew = 0.5 * (turn - jnp.swapaxes(turn, -1, -2))
        angular = jnp.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
        twists = jnp.concatenate([angular, moved[..., :3, 3]], -1).reshape(*lead, -1)
        tangent = jnp.concatenate([twists, tangent[..., entries:]], -1)
    return tangent


# Products of a Jacobian with vectors, computed without the Jacobian. They are linear in the vectors, and each is the
# transpose of the other. Numbers and vectors have the same number of leading axes. A leading axis of the numbers may
# have the length 1.
_pushforward_p = Primitive("hydroelastic_pushforward")
_pullback_p = Primitive("hydroelastic_pullback")


def _pushforward(function: _autodiff.Function, numbers: Array, tangents: Array) -> Array:
    """Multiplies the Jacobian with tangents."""
    products: Array = _pushforward_p.bind(numbers, tangents, function=function)
    return products


def _pushed(numbers: Array, tangents: Array, *, function: _autodiff.Function) -> Array:
    return _product_called_back(function, function.pushforwards, function.outputs, numbers, tangents)


def _pulled(numbers: Array, cotangents: Array, *, function: _autodiff.Function) -> Array:
    return _product_called_back(function, function.pullbacks, function.columns, numbers, cotangents)


def _make_linear(primitive: Any, transposed: Any, evaluated: Callable[..., Array], width: Callable[..., int]) -> None:
    """Registers a product with JAX: its evaluation, derivative, transpose and batching."""

    def shape(_numbers: Any, vectors: Any, *, function: _autodiff.Function) -> Any:
        return jax.core.ShapedArray((*vectors.shape[:-1], width(function)), vectors.dtype)

    def tangent(primals: Sequence[Any], tangents: Sequence[Any], *, function: _autodiff.Function) -> tuple[Any, Any]:
        numbers, vectors = primals
        if type(tangents[0]) is not ad.Zero:
            raise _second_derivative(function)
        return tuple(primitive.bind(numbers, vector, function=function) for vector in (vectors, tangents[1]))

    def cotangent(of_product: Any, numbers: Any, _vectors: Any, *, function: _autodiff.Function) -> list[Any]:
        is_zero = type(of_product) is ad.Zero
        return [None, None if is_zero else transposed.bind(numbers, of_product, function=function)]

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
    """Calls the library with rows of numbers and the vectors of each row, when the program runs."""

    def host(numbers: Any, vectors: Any) -> tuple[_autodiff.Floats, ...]:
        numbers, vectors = np.asarray(numbers), np.asarray(vectors)
        rows, of_rows, restored = _autodiff.paired(numbers, vectors)
        results = _checked(function, lambda: call(rows, of_rows), len(rows))
        return (np.full((*vectors.shape[:-1], width), np.nan) if results is None else restored(results[0]),)

    (products,) = _on_host(host, [(*vectors.shape[:-1], width)], numbers, vectors)
    return products


def _checked(function: _autodiff.Function, call: Callable[[], tuple[Any, ...]], count: int) -> list[Any] | None:
    """Returns the results of a call for ``count`` rows, or None if the call failed. Logs the errors."""
    try:
        *results, errors = call()
    except Exception:
        # If the exception propagated from here, the behavior would be undefined.
        _log.exception("%s: NaN, since the call failed", function.name)
        return None
    if errors:
        why = _autodiff.first_error(errors, count)
        _log.warning("%s: NaN in %d of %d rows: %s", function.name, len(errors), count, why)
    return results


def _called_back(
    function: _autodiff.Function,
    call: Callable[[_autodiff.Floats], tuple[Any, ...]],
    shapes: Sequence[tuple[int, ...]],
    numbers: Array,
) -> tuple[Array, ...]:
    """Calls the library with rows of numbers, when the program runs. Returns arrays with the given shapes."""
    lead = numbers.ndim - 1

    def host(numbers: Any) -> tuple[_autodiff.Floats, ...]:
        numbers = np.asarray(numbers)
        front = numbers.shape[:-1]
        rows = _rows_of(function, numbers)
        tails = [shape[lead:] for shape in shapes]
        results = _checked(function, lambda: call(rows), len(rows))
        if results is None:
            return tuple(np.full((*front, *tail), np.nan) for tail in tails)
        return tuple(result.reshape(*front, *tail) for result, tail in zip(results, tails))

    return _on_host(host, shapes, numbers)


def _on_host(
    host: Callable[..., tuple[_autodiff.Floats, ...]], shapes: Sequence[tuple[int, ...]], *arrays: Array
) -> tuple[Array, ...]:
    """Calls a function of arrays, when the program runs. Returns arrays with the given shapes."""

    def into_buffers(_context: Any, results: Sequence[Any], *arrays: Any) -> None:
        for result, values in zip(results, host(*arrays)):
            np.asarray(result)[...] = values

    struct: Callable[..., Any] = jax.ShapeDtypeStruct
    out = tuple(struct(shape, jnp.float64) for shape in shapes)
    results: tuple[Array, ...]
    if _buffer_callback is not None and jax.default_backend() == "cpu":
        results = _buffer_callback(into_buffers, out, vmap_method="broadcast_all")(*arrays)
        return results
    _check_precision_of_threads()
    results = jax.pure_callback(host, out, *arrays, vmap_method="broadcast_all")
    return results


@functools.partial(jax.jit, static_argnums=0)
def _joined(ranks: tuple[int, ...], parts: Sequence[Array]) -> Array:
    """Concatenates arrays to numbers with the common leading axes. The rank is the number of axes of an array without
    leading axes."""
    leads = [part.shape[: part.ndim - rank] for part, rank in zip(parts, ranks)]
    flat = [part.reshape(*lead, math.prod(part.shape[len(lead) :])) for part, lead in zip(parts, leads)]
    lead = jnp.broadcast_shapes(*(part.shape[:-1] for part in flat))
    return jnp.concatenate([jnp.broadcast_to(part, lead + part.shape[-1:]) for part in flat], -1)


@jax.jit
def _posed(vector: Array, translation: Array) -> Array:
    return _homogeneous(_rotation(vector), translation)


@jax.jit
def _moved(pose: Array, twist: Array) -> Array:
    return _homogeneous(_rotation(twist[..., :3]) @ pose[..., :3, :3], pose[..., :3, 3] + twist[..., 3:])


def _rotation(vector: Array) -> Array:
    """Computes the rotation matrix of a rotation vector, (3, 3): I + sin θ/θ K + (1 − cos θ)/θ² K².

    Both factors are functions of θ², so that all derivatives are correct at zero.
    """
    square = jnp.sum(vector * vector, -1)[..., None, None]
    small = square < 0.1
    angle = jnp.sqrt(jnp.where(small, 1.0, square))
    # Taylor series up to θ¹⁰. If θ² is below 0.1, the next term is below 1e-15.
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
