"""Checks of arguments, which the Python modules share."""

from __future__ import annotations

import math
import operator
import sys
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._core import HydroelasticError

Floats: TypeAlias = NDArray[np.float64]


def checked(array: Any, name: str, shape: tuple[int, ...]) -> Floats:
    """Converts an array of float64 or integers, or a list, to a float64 array.

    Raises an error if the shape is unexpected or a number is not finite.
    """
    values = np.asarray(array) if isinstance(array, list | tuple) else array
    if not isinstance(values, np.ndarray) or (values.dtype != np.float64 and values.dtype.kind not in "iu"):
        kind = values.dtype if isinstance(values, np.ndarray) else type(array).__name__
        raise TypeError(f"{name} is {kind}: expected an array of float64 or integers, or a list of numbers")
    if values.shape != shape:
        raise HydroelasticError(f"{name} has shape {values.shape}: expected {shape}")
    values = values.astype(np.float64, copy=False)
    for index, number in enumerate(values.ravel().tolist()):
        if not math.isfinite(number):
            raise HydroelasticError(f"{name} must be finite, but number {index}, counted from 0, is {number}")
    return values


def check_class(value: Any, expected: type, name: str) -> None:
    """Raises an error if a value is not an instance of a class."""
    if not isinstance(value, expected):
        raise TypeError(f"{name} must be a {expected.__name__}, but is {type(value).__name__}")


def check_count(count: Any, name: str, least: int = 0) -> int:
    """Returns an integer. Raises an error if it is a bool, below ``least``, or too large."""
    if isinstance(count, bool):
        raise TypeError(f"{name} must be an integer, but is {count!r}")
    try:
        value = operator.index(count)
    except TypeError:
        raise TypeError(f"{name} must be an integer, but is {count!r}") from None
    if value < least:
        raise HydroelasticError(f"{name} must be at least {least}, but is {value}")
    if value > sys.maxsize:
        raise HydroelasticError(f"{name} must be at most {sys.maxsize}")
    return value


def checked_pose(argument: Any) -> Floats:
    """Converts the pose of a shape in its frame. Raises an error if the pose is not rigid."""
    pose = checked(argument, "pose", (4, 4))
    rotation = pose[:3, :3]
    if not (np.allclose(rotation @ rotation.T, np.eye(3), rtol=0.0, atol=1e-9) and np.linalg.det(rotation) > 0.0):
        raise HydroelasticError("the pose of a shape in its frame is not rigid")
    if not np.array_equal(pose[3], [0.0, 0.0, 0.0, 1.0]):
        raise HydroelasticError("the last row of a pose must be (0, 0, 0, 1)")
    return pose
