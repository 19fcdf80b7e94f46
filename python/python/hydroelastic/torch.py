"""Wrenches, clearances, steps and rollouts as differentiable functions of PyTorch, for ``backward``, forward mode and
``torch.func``.

    import torch, hydroelastic as he, hydroelastic.torch as ht
    pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    height = torch.tensor(0.195, dtype=torch.float64, requires_grad=True)
    up = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    ht.wrench(pair, ht.pose(up * height), ht.pose())[5].backward()  # N
    print(height.grad)  # N/m

The library computes the contact on the CPU, with its own Jacobians. Autograd does not trace it. If no derivative can be
requested, only the value is computed. Otherwise, one call computes the value and the Jacobian, and the value may differ
by round-off. Gradients of rollouts with respect to many numbers use reverse mode instead. One gradient then costs about
the same for any number of numbers. See ``rollout``.

Tensors are of float64 and on the CPU. Tensors of integers are converted. Other types and devices raise TypeError,
because contact in float32 has no accurate digits. Arguments may have additional leading axes, which are broadcast
against each other and which the result then has too. ``torch.func.vmap`` also creates a batch. Its
function must return tensors, so it must return single attributes of a ``State``. All cores compute a batch.

Derivatives with respect to poses. Poses are (4, 4). A tangent dT of a pose counts as the twist (ω, v) in world axes
that moves the pose: [ω]× is the skew part of dR Rᵀ, and v is the last column of dT. The symmetric part of dR Rᵀ would
leave the rotations, so it has no effect. The last row of dT has no effect either. The gradient of a pose is the
transpose. Let g be the derivative with respect to the angular part of that twist, and f the derivative with respect to
the linear part. The gradient has the rotation block ½ [g]× R and the last column f. So derivatives are correct by the
chain rule through any function that makes rotations (``pose``, ``moved_pose``, quaternions, kinematics). A step along a
gradient itself leaves the rotations: optimize over vectors, and compute poses from them.

Errors (a pose that is not rigid, a number that is not finite, a rollout that ends early) raise HydroelasticError. In a
batch, the message has the index of the first invalid row.

Second derivatives are not available. A backward pass through ``create_graph=True`` and ``torch.func.hessian`` raise
NotImplementedError. For least squares, use JᵀJ of ``torch.func.jacrev`` instead.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

try:
    import torch
except ImportError as error:
    raise ImportError('hydroelastic.torch needs PyTorch: pip install "hydroelastic[torch]"') from error

from torch.autograd import forward_ad

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

Tensor: TypeAlias = torch.Tensor
# Type of an argument: a tensor, a NumPy array, or a list of numbers.
_Tensor: TypeAlias = Any
_documented = documented("torch.Tensor")


@_documented
class State(NamedTuple):
    poses: Tensor
    twists: Tensor
    joint_positions: Tensor | None = None
    joint_velocities: Tensor | None = None
    ball_joint_rotations: Tensor | None = None
    ball_joint_velocities: Tensor | None = None


@_documented
def pose(translation: _Tensor = (0.0, 0.0, 0.0), rotation_vector: _Tensor = (0.0, 0.0, 0.0)) -> Tensor:
    translation = _finite(_floats(translation, "translation", (3,)), "translation")
    vector = _finite(_floats(rotation_vector, "rotation_vector", (3,)), "rotation_vector")
    return _finite(_homogeneous(_rotation(vector), translation), "the pose")


@_documented
def moved_pose(pose: _Tensor, twist: _Tensor) -> Tensor:
    pose = _finite(_floats(pose, "pose", (4, 4)), "pose")
    twist = _finite(_floats(twist, "twist", (6,)), "twist")
    moved = _homogeneous(_rotation(twist[..., :3]) @ pose[..., :3, :3], pose[..., :3, 3] + twist[..., 3:])
    return _finite(moved, "the pose")


@_documented
def wrench(
    pair: Pair,
    pose_a: _Tensor,
    pose_b: _Tensor,
    twist_a: _Tensor | None = None,
    twist_b: _Tensor | None = None,
    *,
    moduli: _Tensor | None = None,
    law: _Tensor | None = None,
) -> Tensor:
    wrenches: Tensor = _autodiff.wrench(_Arrays(), pair, (pose_a, pose_b), (twist_a, twist_b), moduli, law)
    return wrenches


@_documented
def tactile_image(
    pair: Pair,
    grid: TaxelGrid,
    pose_a: _Tensor,
    pose_b: _Tensor,
    twist_a: _Tensor | None = None,
    twist_b: _Tensor | None = None,
    *,
    body: str = "a",
    moduli: _Tensor | None = None,
    law: _Tensor | None = None,
) -> Tensor:
    poses, twists = (pose_a, pose_b), (twist_a, twist_b)
    forces: Tensor = _autodiff.tactile_image(_Arrays(), pair, grid, body, poses, twists, moduli, law)
    return forces


@_documented
def clearance(pair: Pair, pose_a: _Tensor, pose_b: _Tensor, *, moduli: _Tensor | None = None) -> Tensor:
    distance: Tensor = _autodiff.clearance(_Arrays(), pair, (pose_a, pose_b), moduli)
    return distance


@_documented
def initial_state(world: World) -> State:
    arrays: list[Any] = [None if array is None else torch.from_numpy(array) for array in _autodiff.initial_arrays(world)]
    return State(*arrays)


@_documented
def rollout(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Tensor | None = None,
    *,
    start: State | None = None,
    start_step: Tensor | int = 0,
) -> State:
    return _states(world, plan, parameters, changes, start, start_step, only_last=False)


@_documented
def final_state(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Tensor | None = None,
    *,
    start: State | None = None,
    start_step: Tensor | int = 0,
) -> State:
    return _states(world, plan, parameters, changes, start, start_step, only_last=True)


@_documented
def step(
    world: World,
    plan: Plan,
    state: State,
    parameters: Sequence[Parameter] | Mapping[str, Any] = (),
    changes: _Tensor | None = None,
    *,
    start_step: Tensor | int = 0,
) -> State:
    return _states(world, _autodiff.one_step(plan), parameters, changes, state, start_step, only_last=True)


def _states(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] | Mapping[str, Any],
    changes: _Tensor | None,
    start: State | None,
    start_step: Tensor | int,
    *,
    only_last: bool,
) -> State:
    by, parts = _autodiff.parameters_and_changes(_Arrays(), world, parameters, changes)
    function = _autodiff.Rollout(world, plan, by, from_state=start is not None, only_last=only_last)
    return State(*_autodiff.states(_Arrays(), function, parts, start, start_step))


class _Arrays:
    """Operations of PyTorch for ``_autodiff.wrench`` and ``_autodiff.states``."""

    def floats(self, value: _Tensor, name: str, shape: tuple[int, ...]) -> Tensor:
        return _floats(value, name, shape)

    def count(self, value: Tensor | int) -> Tensor:
        return _count(value)

    def poses(self, rotations: Tensor) -> Tensor:
        return _homogeneous(rotations, torch.zeros(3, dtype=torch.float64))

    def evaluated(self, function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Tensor]) -> Tensor:
        return _evaluated(function, ranks, parts)


def _floats(value: _Tensor, name: str, shape: tuple[int, ...]) -> Tensor:
    """Converts an argument to a tensor of float64 on the CPU whose last axes have a shape."""
    try:
        if isinstance(value, list | tuple) and any(isinstance(item, torch.Tensor) for item in value):
            # torch.tensor would detach them.
            value = torch.stack([torch.as_tensor(item, dtype=torch.float64) for item in value])
        elif isinstance(value, list | tuple):
            value = torch.tensor(value, dtype=torch.float64)
        elif not isinstance(value, torch.Tensor):
            value = torch.from_numpy(np.array(value))
    except OverflowError as error:
        raise HydroelasticError(f"{name} has a number that is too large: {error}") from None
    except (RuntimeError, TypeError, ValueError) as error:
        raise TypeError(f"{name} must be a tensor or a list of numbers: {error}") from None
    if not (value.dtype.is_floating_point or value.dtype.is_complex or value.dtype == torch.bool):
        value = value.to(torch.float64)
    if value.dtype != torch.float64:
        raise TypeError(
            f"{name} must be a tensor of float64, but is one of {value.dtype}: contact is computed in float64 alone, and "
            "a conversion would hide lost digits (tensor.double() makes one)"
        )
    if value.device.type != "cpu":
        raise TypeError(f"{name} must be on the CPU, where contact is computed, but is on {value.device}")
    if value.ndim < len(shape) or value.shape[value.ndim - len(shape) :] != shape:
        raise HydroelasticError(f"{name} must have the shape {shape}, or end in it, but has {tuple(value.shape)}")
    tensor: Tensor = value
    return tensor


def _finite(value: Tensor, name: str) -> Tensor:
    """Returns the tensor. Raises an error if a number is not finite. Inside transformations and compiled functions, the
    number propagates instead."""
    is_traced = torch.compiler.is_compiling() or torch._C._functorch.is_functorch_wrapped_tensor(value)
    if not is_traced and not bool(torch.isfinite(value.detach()).all()):
        raise HydroelasticError(f"{name} must be finite, but is {value.tolist()}")
    return value


def _count(start_step: Tensor | int) -> Tensor:
    try:
        start_step = torch.as_tensor(start_step)
    except (RuntimeError, TypeError, ValueError) as error:
        raise TypeError(f"start_step must be an integer or a tensor of integers: {error}") from None
    if start_step.dtype.is_floating_point or start_step.dtype.is_complex or start_step.dtype == torch.bool:
        raise TypeError(f"start_step must be an integer or a tensor of integers, but is of {start_step.dtype}")
    count: Tensor = start_step.to(torch.float64)
    return count


def _evaluated(function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Tensor]) -> Tensor:
    """Evaluates a function of the concatenated numbers of tensors, poses first. The rank is the number of axes of a
    tensor without additional leading axes."""
    try:
        lead = _broadcast(*(part.shape[: part.ndim - rank] for part, rank in zip(parts, ranks)))
    except RuntimeError as error:
        raise HydroelasticError(f"the leading axes of the arguments must be broadcastable: {error}") from None
    flat = [part.expand(*lead, *part.shape[part.ndim - rank :]).flatten(len(lead)) for part, rank in zip(parts, ranks)]
    outputs: Tensor = _called(function, torch.cat(flat, -1))
    return outputs


def _broadcast(*shapes: Sequence[int]) -> Sequence[int]:
    shape: Sequence[int] = torch.broadcast_shapes(*shapes)  # type: ignore[no-untyped-call, unused-ignore]
    return shape


@torch.compiler.disable  # type: ignore[untyped-decorator, unused-ignore]
def _called(function: _autodiff.Function, numbers: Tensor) -> Tensor:
    values: Tensor = _Values.apply(numbers, function, _is_differentiated(numbers))[0]
    return values


def _is_differentiated(numbers: Tensor) -> bool:
    """Returns whether a derivative with respect to numbers can be requested, in forward or reverse mode."""
    if numbers.requires_grad and torch.is_grad_enabled():
        return True
    # Tensors of torch.func are layers around a tensor, one for each transformation. All transformations except vmap
    # differentiate.
    layers = torch._C._functorch
    while layers.is_functorch_wrapped_tensor(numbers):
        if layers.is_gradtrackingtensor(numbers):
            return True
        numbers = layers.get_unwrapped(numbers)
    dual: Any = forward_ad.unpack_dual(numbers)  # type: ignore[no-untyped-call, unused-ignore]
    return dual.tangent is not None


class _Values(torch.autograd.Function):
    """Outputs and Jacobian of a function for numbers with any leading axes. The Jacobian is empty if it is not needed,
    or if products with vectors replace it.
    """

    @staticmethod
    def forward(numbers: Tensor, function: _autodiff.Function, differentiated: bool) -> tuple[Tensor, Tensor]:
        lead = numbers.shape[:-1]
        rows = numbers.detach().reshape(math.prod(lead), function.numbers).numpy()
        jacobians = np.empty(0)
        if differentiated and not function.sweeps_back:
            values, jacobians, errors = function.values_and_jacobians(rows)
            jacobians = jacobians.reshape(*lead, function.outputs, function.columns)
        else:
            values, errors = function.values(rows)
        if errors:
            raise _autodiff.first_error(errors, len(rows))
        return torch.from_numpy(values.reshape(*lead, function.outputs)), torch.from_numpy(jacobians)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: tuple[Tensor, Tensor]) -> None:
        numbers, ctx.function, _ = inputs
        jacobian = output[1]
        ctx.mark_non_differentiable(jacobian)
        ctx.save_for_backward(numbers, jacobian)
        ctx.save_for_forward(numbers, jacobian)

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> tuple[Tensor, None, None]:
        numbers, jacobian = ctx.saved_tensors
        if ctx.function.sweeps_back:
            local = _Product.apply(numbers, cotangents[0], ctx.function, True)
        else:
            local = (cotangents[0].unsqueeze(-2) @ _Constant.apply(jacobian, numbers, ctx.function.name)).squeeze(-2)
        return _cotangent(ctx.function.poses, numbers, local), None, None

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> tuple[Tensor, None]:
        numbers, jacobian = ctx.saved_tensors
        local = _local(ctx.function.poses, numbers, tangents[0])
        if ctx.function.sweeps_back:
            return _Product.apply(numbers, local, ctx.function, False), None
        return (_Constant.apply(jacobian, numbers, ctx.function.name) @ local.unsqueeze(-1)).squeeze(-1), None

    @staticmethod
    def vmap(
        info: Any, in_dims: tuple[int | None, ...], numbers: Tensor, function: _autodiff.Function, differentiated: bool
    ) -> tuple[tuple[Tensor, Tensor], tuple[int, int | None]]:
        numbers = numbers.movedim(in_dims[0] or 0, 0)
        has_jacobian = differentiated and not function.sweeps_back
        return _Values.apply(numbers, function, differentiated), (0, 0 if has_jacobian else None)


class _Product(torch.autograd.Function):
    """Products of the Jacobian of a function with vectors, or of its transpose, computed without the Jacobian.

    Numbers and vectors have the same number of leading axes. A leading axis of the numbers may have the length 1.
    """

    @staticmethod
    def forward(numbers: Tensor, vectors: Tensor, function: _autodiff.Function, transposed: bool) -> Tensor:
        rows, of_rows, restored = _autodiff.paired(numbers.detach().numpy(), vectors.detach().numpy())
        products, errors = (function.pullbacks if transposed else function.pushforwards)(rows, of_rows)
        if errors:
            raise _autodiff.first_error(errors, len(rows))
        return torch.from_numpy(np.ascontiguousarray(restored(products)))

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        ctx.name = inputs[2].name

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        raise _no_second_derivatives(ctx.name)

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> Any:
        raise _no_second_derivatives(ctx.name)

    @staticmethod
    def vmap(
        info: Any,
        in_dims: tuple[int | None, ...],
        numbers: Tensor,
        vectors: Tensor,
        function: _autodiff.Function,
        transposed: bool,
    ) -> tuple[Tensor, int]:
        numbers, vectors = (
            array.unsqueeze(0) if dim is None else array.movedim(dim, 0)
            for array, dim in zip((numbers, vectors), in_dims)
        )
        vectors = vectors.expand(info.batch_size, *vectors.shape[1:])
        return _Product.apply(numbers, vectors, function, transposed), 0


class _Constant(torch.autograd.Function):
    """Jacobian as a function of the numbers. Its derivative raises an error, because zero would be wrong."""

    generate_vmap_rule = True

    @staticmethod
    def forward(jacobian: Tensor, numbers: Tensor, name: str) -> Tensor:
        return jacobian.view_as(jacobian)

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: Tensor) -> None:
        ctx.name = inputs[2]

    @staticmethod
    def backward(ctx: Any, *cotangents: Tensor) -> Any:
        raise _no_second_derivatives(ctx.name)

    @staticmethod
    def jvp(ctx: Any, *tangents: Any) -> Any:
        raise _no_second_derivatives(ctx.name)


def _no_second_derivatives(name: str) -> NotImplementedError:
    return NotImplementedError(
        f"the {name} of hydroelastic has first derivatives only, and a second one was asked for (by a backward pass through "
        "create_graph=True, or torch.func.hessian): for least squares, J.T @ J of torch.func.jacrev takes its place"
    )


def _local(poses: int, numbers: Tensor, tangent: Tensor) -> Tensor:
    """Converts a tangent of numbers, whose first ``poses`` items are poses, to the columns of a Jacobian: the tangents
    of poses become twists."""
    if not poses:
        return tangent
    lead, entries = numbers.shape[:-1], poses * _autodiff.POSE
    at, moved = (array[..., :entries].reshape(*lead, poses, 4, 4) for array in (numbers, tangent))
    turn = moved[..., :3, :3] @ at[..., :3, :3].mT
    skew = 0.5 * (turn - turn.mT)
    angular = torch.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
    twists = torch.cat([angular, moved[..., :3, 3]], -1).reshape(*lead, poses * _autodiff.TWIST)
    return torch.cat([twists, tangent[..., entries:]], -1)


def _cotangent(poses: int, numbers: Tensor, local: Tensor) -> Tensor:
    """Applies the transpose of ``_local``."""
    if not poses:
        return local
    lead, columns = local.shape[:-1], poses * _autodiff.TWIST
    at = numbers[..., : poses * _autodiff.POSE].reshape(*numbers.shape[:-1], poses, 4, 4)
    by_twists = local[..., :columns].reshape(*lead, poses, _autodiff.TWIST)
    rotation = 0.5 * _cross(by_twists[..., :3]) @ at[..., :3, :3]
    top = torch.cat([rotation, by_twists[..., 3:].unsqueeze(-1)], -1)
    whole = torch.cat([top, torch.zeros_like(top[..., :1, :])], -2)
    return torch.cat([whole.reshape(*lead, poses * _autodiff.POSE), local[..., columns:]], -1)


def _cross(vector: Tensor) -> Tensor:
    """Returns the matrix of a cross product, (3, 3)."""
    x, y, z = vector.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*vector.shape[:-1], 3, 3)


def _rotation(vector: Tensor) -> Tensor:
    """Computes the rotation matrix of a rotation vector, (3, 3): I + sin θ/θ K + (1 − cos θ)/θ² K².

    Both factors are functions of θ², so that all derivatives are correct at zero.
    """
    square = (vector * vector).sum(-1)[..., None, None]
    small = square < 0.1
    angle = torch.where(small, 1.0, square).sqrt()
    # Taylor series up to θ¹⁰. If θ² is below 0.1, the next term is below 1e-15.
    sine = _series(square, (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800))
    cosine = _series(square, (1 / 2, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600))
    first = torch.where(small, sine, angle.sin() / angle)
    second = torch.where(small, cosine, 0.5 * ((0.5 * angle).sin() / (0.5 * angle)) ** 2)
    cross = _cross(vector)
    return torch.eye(3, dtype=torch.float64) + first * cross + second * (cross @ cross)


def _series(square: Tensor, factors: Sequence[float]) -> Tensor:
    total = torch.zeros_like(square)
    for factor in reversed(factors):
        total = total * square + factor
    return total


def _homogeneous(rotation: Tensor, translation: Tensor) -> Tensor:
    lead = _broadcast(rotation.shape[:-2], translation.shape[:-1])
    top = torch.cat([rotation.expand(*lead, 3, 3), translation.expand(*lead, 3)[..., None]], -1)
    last = torch.tensor([[0.0, 0.0, 0.0, 1.0]], dtype=torch.float64).expand(*lead, 1, 4)
    return torch.cat([top, last], -2)
