"""What ``pin`` checks of its arguments and results."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import HydroelasticError

Floats: TypeAlias = NDArray[np.float64]


def check_array(array: Any, name: str, shape: tuple[int, ...]) -> None:
    if not isinstance(array, np.ndarray) or array.dtype != np.float64:
        what = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        raise TypeError(f"{name} is {what}: expected an array of float64")
    if array.shape != shape:
        raise HydroelasticError(f"{name} has shape {array.shape}: expected {shape}")


def checked(array: Any, name: str, shape: tuple[int, ...]) -> Floats:
    check_array(array, name, shape)
    return array  # type: ignore[no-any-return]


def check_time_step(time_step: float) -> None:
    if not (math.isfinite(time_step) and time_step > 0.0):
        raise HydroelasticError(f"the time step is {time_step} s: expected a positive number")


def finite(values: Floats, name: str = "the acceleration") -> Floats:
    if not all(map(math.isfinite, values.ravel().tolist())):
        raise HydroelasticError(f"{name} is not finite: q, v or tau is not, or the motion has diverged")
    return values
