"""Pictures of contact surfaces, worlds and trajectories, for notebooks and as stand-alone pages.

    pair.surface(pose_a, pose_b).show()
    world.show(state)
    world.rollout(plan).run().show(world)

A picture is one page of HTML with its data and its viewer (WebGL 2) in it: it loads nothing, needs no server, no network and no
package, stays in a saved notebook, and a rule in the page forbids it to send any request. Drag to turn it, with shift or the
right button to move it; the wheel zooms once it was clicked; a double click resets the view. World z points up.
"""

from __future__ import annotations

import base64
import html as _html
import json
import math
import os
import sys
import warnings
import zlib
from collections.abc import Sequence
from importlib.resources import files
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ._core import HalfSpace, HydroelasticError, RigidShape, Shape, State, Surface, Trajectory, World
from ._pin_checks import check_count

__all__ = ["Picture", "html", "of_surface", "of_trajectory", "of_world", "picture", "save"]

_Floats = NDArray[np.float64]
_Whole = NDArray[np.integer[Any]]

# The perceptually uniform map viridis of matplotlib (S. van der Walt, N. Smith; CC0), at 16 places: dark is low.
PRESSURE_COLORS = (
    "440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e 1f988b 22a884 35b779 54c568 7ad151 a5db36 d2e21b fde725"
).split()
# The colors of bodies that move, in turn [Okabe 2008], and of those that do not.
_BODY_COLORS = ("0072b2", "d55e00", "cc79a7", "56b4e9", "e69f00", "009e73")
_FIXED_COLOR = "8a8f98"
# Edges between faces that turn by more than this are drawn.
_CREASE = math.radians(30.0)
# A half-space is drawn as a tile, which reaches so many diagonals of the picture's box to each side; a rigid one has this part of
# the diagonal as its thickness, that of a soft one is its layer's.
_TILE = 1.0
_RIGID_TILE = 0.01
# Pictures are kept below this (bytes), where fewer frames do it.
_LARGEST = 1_000_000
# Coordinates are whole numbers up to this within a box of each mesh or surface.
_GRID = 65535
# Of the corners of a tile, whose z changes fastest and whose x slowest; counter-clockwise seen from outside.
_TILE_TRIANGLES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)
_VIEWER = files("hydroelastic").joinpath("_viewer.html").read_text(encoding="utf-8")


class Picture:
    """A picture that can be turned. A notebook shows it where it is the value of a cell; ``save`` writes it as a page."""

    def __init__(self, page: str, height: int, shows: str) -> None:
        self._page = page
        self._height = check_count(height, "height", 1)
        self._shows = shows

    @property
    def html(self) -> str:
        """The page: a whole document, which loads nothing."""
        return self._page

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file, which any browser opens."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._page)

    def _repr_html_(self) -> str:
        """The page in a frame of its own, which can neither reach the notebook nor send requests."""
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{_html.escape(self._page)}" '
            f'style="width: 100%; height: {self._height}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Picture of {self._shows} ({len(self._page) / 1000:.0f} kB; save(path) writes a page that any browser opens)"


def picture(thing: Surface | World | Trajectory, **options: Any) -> Picture:
    """The picture of a surface, a world or a trajectory, with the options of ``of_surface``, ``of_world`` or ``of_trajectory``."""
    if isinstance(thing, Surface):
        return of_surface(thing, **options)
    if isinstance(thing, World):
        return of_world(thing, **options)
    if isinstance(thing, Trajectory):
        return of_trajectory(thing, **options)
    raise TypeError(f"there are pictures of Surface, World and Trajectory, but not of {type(thing).__name__}")


def html(thing: Surface | World | Trajectory, **options: Any) -> str:
    """The picture as a stand-alone page of HTML."""
    return picture(thing, **options).html


def save(path: str | os.PathLike[str], thing: Surface | World | Trajectory, **options: Any) -> None:
    """Writes the picture as a stand-alone page of HTML."""
    picture(thing, **options).save(path)


def of_surface(surface: Surface, *, pressure_limit: float | None = None, height: int = 420) -> Picture:
    """The polygons of a contact surface, colored by pressure.

    Parameters
    ----------
    pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    height : of the picture in a notebook (pixels).
    """
    _check(height, pressure_limit)
    scene = _Scene(pressure_limit)
    scene.add_frame(0.0, np.zeros((0, 4, 4)), [surface])
    return scene.picture(height, repr(surface))


def of_world(
    world: World, state: State | None = None, *, pressure_limit: float | None = None, height: int = 420
) -> Picture:
    """The bodies of a world, translucent, and the contact surfaces between them, colored by pressure. Half-spaces are large tiles.

    Parameters
    ----------
    state : where the bodies are; None for the initial state.
    pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    height : of the picture in a notebook (pixels).

    Raises
    ------
    HydroelasticError if the state does not fit the world.
    """
    _check(height, pressure_limit)
    state = world.initial_state if state is None else state
    scene = _Scene(pressure_limit).with_bodies_of(world)
    scene.add_frame(state.time, state.poses, [contact.surface for contact in world.contacts(state)])
    return scene.picture(height, f"{world!r} at {state.time:g} s")


def of_trajectory(
    trajectory: Trajectory,
    world: World | None = None,
    *,
    frames: int = 100,
    pressure_limit: float | None = None,
    height: int = 420,
) -> Picture:
    """A trajectory that plays, with a slider.

    Parameters
    ----------
    world : whose trajectory it is. Its bodies are drawn with their contact surfaces; without it, the frames of the bodies are.
    frames : how many states are drawn at most, evenly chosen, the first and the last among them. There are fewer where the
        picture would take more than 1 MB.
    pressure_limit : the pressure (Pa) at the upper end of the color bar; None for the greatest that is there.
    height : of the picture in a notebook (pixels).

    Raises
    ------
    HydroelasticError if the trajectory is not one of this world, or frames is below 1.
    """
    _check(height, pressure_limit)
    frames = check_count(frames, "frames", 1)
    bodies = trajectory.poses.shape[1]
    if world is not None and len(world.names) != bodies:
        raise HydroelasticError(f"a trajectory of {bodies} bodies is not one of a world of {len(world.names)}")
    count = min(frames, len(trajectory))
    surfaces: dict[int, list[Surface]] = {}
    while True:
        scene = _Scene(pressure_limit)
        if world is not None:
            scene.with_bodies_of(world)
        scene.add_paths(trajectory.poses[..., :3, 3])
        for place in np.unique(np.linspace(0, len(trajectory) - 1, count).round().astype(int)):
            state = trajectory[place]
            if world is not None and place not in surfaces:
                surfaces[place] = [contact.surface for contact in world.contacts(state)]
            scene.add_frame(state.time, state.poses, surfaces.get(place, []))
        drawn = scene.page()
        if len(drawn) <= _LARGEST or count <= 2:
            return scene.picture(height, repr(trajectory), drawn)
        count = max(2, count // 2)


def _check(height: int, pressure_limit: float | None) -> None:
    check_count(height, "height", 1)
    if isinstance(pressure_limit, bool):
        raise TypeError(f"pressure_limit must be a number, but is {pressure_limit}")
    if pressure_limit is not None and not 0.0 < pressure_limit <= sys.float_info.max:
        raise HydroelasticError(f"pressure_limit must be above 0 and finite, but is {pressure_limit}")


class _Packed:
    """Arrays one after another, each at a multiple of four bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, values: NDArray[Any], kind: str) -> list[Any]:
        """Where an array of a kind ("u1", "u2", "u4", "f4") is: its kind, first byte and length."""
        data = np.ascontiguousarray(values).astype("<" + kind).tobytes()
        place = [kind, self._length, values.size]
        data += bytes(-len(data) % 4)
        self._parts.append(data)
        self._length += len(data)
        return place

    def add_places(self, values: _Whole, largest: int) -> list[Any]:
        """Whole numbers up to the largest."""
        return self.add(values, "u2" if largest <= _GRID else "u4")

    def add_points(self, points: _Floats) -> dict[str, Any]:
        """Points (n, 3) on the grid of their box."""
        low, size = points.min(axis=0), np.ptp(points, axis=0)
        on_grid = np.round((points - low) / np.where(size > 0.0, size, 1.0) * _GRID)
        return {"points": self.add(on_grid, "u2"), "low": low.tolist(), "size": size.tolist()}

    def bytes(self) -> bytes:
        return b"".join(self._parts)


class _Scene:
    """What is drawn, and the page that draws it."""

    def __init__(self, pressure_limit: float | None) -> None:
        self._limit = pressure_limit
        self._packed = _Packed()
        self._shapes: list[dict[str, Any]] = []
        self._bodies: list[dict[str, Any]] = []
        # By the places of their bodies.
        self._half_spaces: dict[int, HalfSpace] = {}
        self._times: list[float] = []
        self._poses: list[_Floats] = []
        self._surfaces: list[tuple[int, Surface]] = []
        self._paths: list[dict[str, Any]] = []

    def with_bodies_of(self, world: World) -> Self:
        known: dict[tuple[bytes, bytes], int] = {}
        moving = 0
        for body in world.bodies:
            moves = body.mass is not None or body.path is not None
            color = _BODY_COLORS[moving % len(_BODY_COLORS)] if moves else _FIXED_COLOR
            moving += moves
            self._bodies.append({"name": body.name, "color": color, "moves": moves})
            if isinstance(body.shape, HalfSpace):
                self._half_spaces[len(self._bodies) - 1] = body.shape
                continue
            vertices, triangles = _outline(body.shape)
            key = (vertices.tobytes(), triangles.tobytes())
            if key not in known:
                known[key] = self._add_shape(vertices, triangles)
            reach = float(np.linalg.norm(vertices, axis=1).max())
            self._bodies[-1] |= {"shape": known[key], "reach": reach}
        return self

    def _add_shape(self, vertices: _Floats, triangles: _Whole) -> int:
        """The place of a new mesh."""
        mesh = self._packed.add_points(vertices)
        mesh["triangles"] = self._packed.add_places(triangles, len(vertices) - 1)
        mesh["creases"] = self._packed.add_places(creases(vertices, triangles), len(vertices) - 1)
        self._shapes.append(mesh)
        return len(self._shapes) - 1

    def _add_tiles(self, low: _Floats, high: _Floats) -> None:
        """The tiles of the half-spaces, each below the middle of the box in the first frame."""
        diagonal = float(np.linalg.norm(high - low)) or 1.0
        for place, half_space in self._half_spaces.items():
            pose = self._poses[0][place]
            x, y, _ = pose[:, :3].T @ (0.5 * (low + high) - pose[:, 3])
            width, thickness = _TILE * diagonal, half_space.thickness or _RIGID_TILE * diagonal
            corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 0)])
            vertices = np.array([x, y, 0.0]) + corners * np.array([width, width, thickness])
            self._bodies[place]["shape"] = self._add_shape(vertices, _TILE_TRIANGLES)

    def add_paths(self, origins: _Floats) -> None:
        """The paths of the origins: (t, n, 3)."""
        for body in range(origins.shape[1]):
            points = origins[:, body]
            if len(points) > 1 and np.ptp(points, axis=0).any():
                # Some hundred points are enough to look smooth.
                places = np.unique(np.linspace(0, len(points) - 1, 400).round().astype(int))
                self._paths.append({"points": self._packed.add(points[places], "f4"), "body": body})

    def add_frame(self, time: float, poses: _Floats, surfaces: Sequence[Surface]) -> None:
        place = len(self._times)
        self._times.append(time)
        self._poses.append(poses[:, :3, :])
        self._surfaces += [(place, surface) for surface in surfaces if len(surface)]

    def page(self) -> str:
        greatest = max((float(surface.pressures.max()) for _, surface in self._surfaces), default=0.0)
        limit = self._limit or greatest or 1.0
        low, high = self._box()
        self._add_tiles(low, high)
        content = {
            "times": self._times,
            "shapes": self._shapes,
            "bodies": self._bodies,
            "count": self._poses[0].shape[0],
            "poses": self._packed.add(np.array(self._poses), "f4"),
            "paths": self._paths,
            "patches": [self._patch(frame, surface, limit) for frame, surface in self._surfaces],
            "limit": limit,
            "exceeded": greatest > limit,
            "colors": PRESSURE_COLORS,
            "low": low.tolist(),
            "high": high.tolist(),
        }
        head = json.dumps(content, separators=(",", ":")).encode()
        head += b" " * (-len(head) % 4)
        data = len(head).to_bytes(4, "little") + head + self._packed.bytes()
        return _VIEWER.replace("@DATA@", base64.b64encode(zlib.compress(data, 9)).decode())

    def _patch(self, frame: int, surface: Surface, limit: float) -> dict[str, Any]:
        patch = self._packed.add_points(surface.vertices)
        shares = np.clip(surface.pressures / limit, 0.0, 1.0)
        patch["shares"] = self._packed.add(np.round(shares * _GRID), "u2")
        patch["sizes"] = self._packed.add(np.diff(surface.offsets), "u1")
        patch["frame"] = frame
        return patch

    def _box(self) -> tuple[_Floats, _Floats]:
        """The corners of a box around the bodies that move, in all frames, or else around all that there is."""
        origins = np.array(self._poses)[..., 3]
        bounded = [place for place in range(len(self._bodies)) if place not in self._half_spaces]
        of_bodies = [place for place in bounded if self._bodies[place]["moves"]] or bounded
        points = [surface.vertices for _, surface in self._surfaces]
        for place in of_bodies:
            reach = self._bodies[place]["reach"]
            points += [origins[:, place] - reach, origins[:, place] + reach]
        if not self._bodies and origins.size:
            points.append(origins.reshape(-1, 3))
        if not points:
            return np.zeros(3), np.ones(3)
        every = np.concatenate(points)
        return every.min(axis=0), every.max(axis=0)

    def picture(self, height: int, shows: str, page: str | None = None) -> Picture:
        page = self.page() if page is None else page
        if len(page) > _LARGEST:
            warnings.warn(f"the picture takes {len(page) / 1e6:.1f} MB: its meshes are large", stacklevel=4)
        return Picture(page, height, shows)


def _outline(shape: Shape | RigidShape) -> tuple[_Floats, _Whole]:
    """The vertices and triangles of its surface."""
    if isinstance(shape, RigidShape):
        return shape.vertices, shape.triangles
    used, triangles = np.unique(shape.surface_triangles, return_inverse=True)
    return shape.vertices[used], triangles.reshape(-1, 3)


def creases(vertices: _Floats, triangles: _Whole) -> _Whole:
    """The edges (m, 2) between triangles of a closed surface that turn by more than 30 degrees from one to the other."""
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owners = edges[order], owners[order]
    # The edges of two triangles are one after another.
    twin = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    cosines = np.einsum("ij,ij->i", normals[owners[twin]], normals[owners[twin + 1]])
    found: _Whole = edges[twin[cosines < math.cos(_CREASE)]]
    return found
