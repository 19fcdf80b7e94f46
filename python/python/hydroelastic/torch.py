"""Wrenches, steps and rollouts as differentiable functions of PyTorch: ``backward``, forward mode and ``torch.func``.

    import torch, hydroelastic as he, hydroelastic.torch as ht
    pair = he.Pair(he.Shape.icosphere(0.1, 3), he.Shape.cuboid([0.4, 0.4, 0.2]), 1e5, 1e6)
    height = torch.tensor(0.195, dtype=torch.float64, requires_grad=True)
    up = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    ht.wrench(pair, ht.pose(up * height), ht.pose())[5].backward()  # N
    print(height.grad)  # N/m

The contact is computed by the library on the CPU, with its own Jacobians: autograd does not trace it. What is computed
is the value alone where no derivative can be asked for, and else value and Jacobian in one call: the value may then
differ by round-off. Gradients of rollouts by many numbers take the steps back instead, for one gradient at about the
same cost whatever the numbers are: see ``rollout``.

Tensors are of float64 and on the CPU: others are refused, since a contact of float32 numbers has no digits left.
Arguments may have any axes in front, which are broadcast against each other, and then so has the result;
``torch.func.vmap`` makes such a batch too. All cores compute a batch.

Derivatives by poses. Poses are (4, 4). A tangent dT of a pose counts as the twist (ω, v) in world axes by which it
moves the pose: [ω]× is the skew part of dR Rᵀ, and v is the last column. What is not skew in dR Rᵀ would leave the
rotations, and does not count; nor does the last row. The gradient of a pose is the transpose: with g the derivative by
the angular part of that twist and f by the linear part, ½ [g]× R is its rotation block and f its last column. So by the
chain rule through anything that makes rotations (``pose``, ``moved_pose``, quaternions, kinematics) derivatives are
right, and a step along a gradient itself leads off the rotations: optimize over vectors, and make poses of them.

What the library refuses (a pose that is not rigid, a number that is not finite, a rollout that ends early) raises
HydroelasticError, in a batch too, with the place of the first such row.

Second derivatives do not exist, and to ask for them (a backward pass through ``create_graph=True``,
``torch.func.hessian``) raises NotImplementedError. For least squares, JᵀJ of ``torch.func.jacrev`` takes their place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

try:
    import torch
except ImportError as error:
    raise ImportError('hydroelastic.torch needs PyTorch: pip install "hydroelastic[torch]"') from error

from torch.autograd import forward_ad

from . import _autodiff
from ._core import HydroelasticError, Pair, Parameter, Plan, World

__all__ = ["State", "final_state", "initial_state", "moved_pose", "pose", "rollout", "step", "wrench"]

Tensor: TypeAlias = torch.Tensor
# What an argument may be: a tensor, an array of numpy, or a list of numbers.
_Tensor: TypeAlias = Any


class State(NamedTuple):
    """The n bodies of a world at one time, in the order of the world's; recorded states have k in front.

    poses : (n, 4, 4), poses of the body frames in the world.
    twists : (n, 6): spin (rad/s), and velocity of the center of mass (m/s), world axes.
    """

    poses: Tensor
    twists: Tensor


def pose(translation: _Tensor = (0.0, 0.0, 0.0), rotation_vector: _Tensor = (0.0, 0.0, 0.0)) -> Tensor:
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
    return _finite(_homogeneous(_rotation(vector), translation), "the pose")


def moved_pose(pose: _Tensor, twist: _Tensor) -> Tensor:
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
    moved = _homogeneous(_rotation(twist[..., :3]) @ pose[..., :3, :3], pose[..., :3, 3] + twist[..., 3:])
    return _finite(moved, "the pose")


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
    found: Tensor = _autodiff.wrench(_Arrays(), pair, (pose_a, pose_b), (twist_a, twist_b), moduli, law)
    return found


def initial_state(world: World) -> State:
    """The state that rollouts of a world start from."""
    state = world.initial_state
    return State(torch.from_numpy(state.poses), torch.from_numpy(state.twists))


def rollout(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] = (),
    changes: _Tensor | None = None,
    *,
    start: State | None = None,
    start_step: Tensor | int = 0,
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

    Backward passes by more than 12 numbers (96 over implicit steps) sweep back, in a time that does not depend on p; 12 numbers
    for each body that forces move count too if there is a start. Else, and in forward mode, the Jacobian is found, whose
    time grows with them.
    """
    return _states(world, plan, parameters, changes, start, start_step, only_last=False)


def final_state(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter] = (),
    changes: _Tensor | None = None,
    *,
    start: State | None = None,
    start_step: Tensor | int = 0,
) -> State:
    """The last state of a rollout: arguments as those of rollout."""
    return _states(world, plan, parameters, changes, start, start_step, only_last=True)


def step(
    world: World,
    plan: Plan,
    state: State,
    parameters: Sequence[Parameter] = (),
    changes: _Tensor | None = None,
    *,
    start_step: Tensor | int = 0,
) -> State:
    """The state one time step of the plan after another one: arguments as those of rollout. For controls, take
    Parameter.control of the interval that the step is in.
    """
    return _states(world, _autodiff.one_step(plan), parameters, changes, state, start_step, only_last=True)


def _states(
    world: World,
    plan: Plan,
    parameters: Sequence[Parameter],
    changes: _Tensor | None,
    start: State | None,
    start_step: Tensor | int,
    *,
    only_last: bool,
) -> State:
    function = _autodiff.Rollout(world, plan, parameters, from_state=start is not None, only_last=only_last)
    given = None if start is None else (start.poses, start.twists)
    return State(*_autodiff.states(_Arrays(), function, changes, given, start_step))


class _Arrays:
    """What PyTorch brings to _autodiff.wrench and _autodiff.states."""

    def floats(self, value: _Tensor, name: str, shape: tuple[int, ...]) -> Tensor:
        return _floats(value, name, shape)

    def count(self, value: Tensor | int) -> Tensor:
        return _count(value)

    def evaluated(self, function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Tensor]) -> Tensor:
        return _evaluated(function, ranks, parts)


def _floats(value: _Tensor, name: str, shape: tuple[int, ...]) -> Tensor:
    """An argument as a tensor of float64 on the CPU that ends in a shape."""
    try:
        if isinstance(value, list | tuple):
            value = torch.tensor(value, dtype=torch.float64)
        elif not isinstance(value, torch.Tensor):
            value = torch.from_numpy(np.array(value))
    except OverflowError as error:
        raise HydroelasticError(f"{name} has a number that is too large: {error}") from None
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
    found: Tensor = value
    return found


def _finite(value: Tensor, name: str) -> Tensor:
    """Returns the tensor. Raises an error if a number is not finite, except inside transformations and compiled functions, where it
    propagates."""
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
    found: Tensor = start_step.to(torch.float64)
    return found


def _evaluated(function: _autodiff.Function, ranks: Sequence[int], parts: Sequence[Tensor]) -> Tensor:
    """A function of the numbers of some tensors, with so many axes of their own; those of the poses come first."""
    lead = _broadcast(*(part.shape[: part.ndim - rank] for part, rank in zip(parts, ranks)))
    flat = [part.expand(*lead, *part.shape[part.ndim - rank :]).flatten(len(lead)) for part, rank in zip(parts, ranks)]
    found: Tensor = _called(function, torch.cat(flat, -1))
    return found


def _broadcast(*shapes: Sequence[int]) -> Sequence[int]:
    found: Sequence[int] = torch.broadcast_shapes(*shapes)  # type: ignore[no-untyped-call, unused-ignore]
    return found


@torch.compiler.disable  # type: ignore[untyped-decorator, unused-ignore]
def _called(function: _autodiff.Function, numbers: Tensor) -> Tensor:
    values: Tensor = _Values.apply(numbers, function, _is_differentiated(numbers))[0]
    return values


def _is_differentiated(numbers: Tensor) -> bool:
    """Whether a derivative by numbers can be asked for, in either mode."""
    if numbers.requires_grad and torch.is_grad_enabled():
        return True
    # Tensors of torch.func are layers around a tensor, one for each transformation; all but those of vmap are
    # differentiated.
    layers = torch._C._functorch
    while layers.is_functorch_wrapped_tensor(numbers):
        if layers.is_gradtrackingtensor(numbers):
            return True
        numbers = layers.get_unwrapped(numbers)
    dual: Any = forward_ad.unpack_dual(numbers)  # type: ignore[no-untyped-call, unused-ignore]
    return dual.tangent is not None


class _Values(torch.autograd.Function):
    """The outputs of a function for numbers with any axes in front, and its Jacobian: empty if nobody needs it, or products
    with vectors take its place.
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
    """The Jacobian of a function times vectors, or vectors times it if it is transposed, without the Jacobian. Numbers and
    vectors have as many axes in front, and one of the numbers may have the length 1.
    """

    @staticmethod
    def forward(numbers: Tensor, vectors: Tensor, function: _autodiff.Function, transposed: bool) -> Tensor:
        rows, of_rows, restored = _autodiff.paired(numbers.detach().numpy(), vectors.detach().numpy())
        found, errors = (function.pullbacks if transposed else function.pushforwards)(rows, of_rows)
        if errors:
            raise _autodiff.first_error(errors, len(rows))
        return torch.from_numpy(np.ascontiguousarray(restored(found)))

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
            it.unsqueeze(0) if dim is None else it.movedim(dim, 0) for it, dim in zip((numbers, vectors), in_dims)
        )
        vectors = vectors.expand(info.batch_size, *vectors.shape[1:])
        return _Product.apply(numbers, vectors, function, transposed), 0


class _Constant(torch.autograd.Function):
    """The Jacobian as a function of the numbers, whose derivative is refused: zero would be wrong."""

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
    """A tangent of numbers that start with so many poses, by the columns of a Jacobian: those of poses as twists."""
    if not poses:
        return tangent
    lead, entries = numbers.shape[:-1], poses * _autodiff.POSE
    at, moved = (it[..., :entries].reshape(*lead, poses, 4, 4) for it in (numbers, tangent))
    turn = moved[..., :3, :3] @ at[..., :3, :3].mT
    skew = 0.5 * (turn - turn.mT)
    angular = torch.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], -1)
    twists = torch.cat([angular, moved[..., :3, 3]], -1).reshape(*lead, poses * _autodiff.TWIST)
    return torch.cat([twists, tangent[..., entries:]], -1)


def _cotangent(poses: int, numbers: Tensor, local: Tensor) -> Tensor:
    """The transpose of _local."""
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
    """The matrix of a cross product, (3, 3)."""
    x, y, z = vector.unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack([zero, -z, y, z, zero, -x, -y, x, zero], -1).reshape(*vector.shape[:-1], 3, 3)


def _rotation(vector: Tensor) -> Tensor:
    """The rotation by a rotation vector, (3, 3): I + sin θ/θ K + (1 − cos θ)/θ² K², with both factors as functions of
    θ², so that all derivatives are right at zero.
    """
    square = (vector * vector).sum(-1)[..., None, None]
    small = square < 0.1
    angle = torch.where(small, 1.0, square).sqrt()
    # Taylor series to θ¹⁰: below 0.1, the next term is under 1e-15.
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
