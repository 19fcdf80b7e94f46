"""What ``pin``, ``mujoco``, ``ray`` and ``view`` check of their arguments and results."""

from __future__ import annotations

import math
import operator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import HydroelasticError

Floats: TypeAlias = NDArray[np.float64]


def checked(array: Any, name: str, shape: tuple[int, ...], infinite: bool = False) -> Floats:
    """Numbers as an array of float64 of a shape: from such an array, from one of integers, or from a list. NaN is refused, and
    infinite numbers unless they are allowed."""
    found = np.asarray(array) if isinstance(array, list | tuple) else array
    if not isinstance(found, np.ndarray) or (found.dtype != np.float64 and found.dtype.kind not in "iu"):
        what = found.dtype if isinstance(found, np.ndarray) else type(array).__name__
        raise TypeError(f"{name} is {what}: expected an array of float64 or integers, or a list of numbers")
    if found.shape != shape:
        raise HydroelasticError(f"{name} has shape {found.shape}: expected {shape}")
    found = found.astype(np.float64, copy=False)
    numbers = found.ravel().tolist()
    if not all(map(math.isfinite, numbers)):
        for place, number in enumerate(numbers):
            if math.isnan(number) or (math.isinf(number) and not infinite):
                raise HydroelasticError(f"{name} must be finite, but number {place}, counted from 0, is {number}")
    return found


def check_count(count: Any, name: str, least: int = 0) -> int:
    """A whole number from the least on."""
    try:
        found = operator.index(count)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, but is {count!r}") from None
    if found < least:
        raise HydroelasticError(f"{name} must be at least {least}, but is {found}")
    return found


def checked_pose(given: Any) -> Floats:
    """The pose of a shape in its frame."""
    found = checked(given, "pose", (4, 4))
    rotation = found[:3, :3]
    if not (np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=1e-9) and np.linalg.det(rotation) > 0.0):
        raise HydroelasticError("the pose of a shape in its frame is not rigid")
    if not np.array_equal(found[3], [0.0, 0.0, 0.0, 1.0]):
        raise HydroelasticError("the last row of a pose must be (0, 0, 0, 1)")
    return found


def check_time_step(time_step: float) -> None:
    if not (math.isfinite(time_step) and time_step > 0.0):
        raise HydroelasticError(f"the time step is {time_step} s: expected a positive number")


def finite(values: Floats, name: str = "the acceleration") -> Floats:
    # One sum is cheaper than a look at each number. Finite numbers whose sum overflows are diverging too.
    if not math.isfinite(values.sum()):
        raise HydroelasticError(f"{name} is not finite: q, v, tau or the time step is too large, or the motion has diverged")
    return values
