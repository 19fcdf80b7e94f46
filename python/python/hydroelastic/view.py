"""Pictures of contact surfaces, worlds and trajectories, for notebooks and as stand-alone pages.

    pair.surface(pose_a, pose_b).show()
    world.show(state)
    world.rollout(plan).run().show(world)

A picture is one page of HTML that contains its data and its viewer (WebGL 2). It loads nothing, and needs no server,
network or package. It stays in a saved notebook. A content security policy in the page forbids all requests. Drag to
turn the picture, and drag with shift or the right button to move it. The wheel zooms after a click on the picture. A
double click resets the view. The z axis of the world points up.
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
from ._checks import check_count, checked

__all__ = ["Picture", "html", "of_surface", "of_tactile_image", "of_trajectory", "of_world", "picture", "save"]

_Floats = NDArray[np.float64]
_Whole = NDArray[np.integer[Any]]

# Perceptually uniform color map viridis of matplotlib (S. van der Walt, N. Smith; CC0), sampled at 16 points. Dark
# colors are low.
PRESSURE_COLORS = (
    "440154 481a6c 472f7d 414487 39568c 31688e 2a788e 23888e 1f988b 22a884 35b779 54c568 7ad151 a5db36 d2e21b fde725"
).split()
# Colors of moving bodies, in turn [Okabe 2008], and color of fixed bodies.
_BODY_COLORS = ("0072b2", "d55e00", "cc79a7", "56b4e9", "e69f00", "009e73")
_FIXED_COLOR = "8a8f98"
# Edges are drawn if the angle between their faces exceeds this angle.
_CREASE = math.radians(30.0)
# Thickness of the drawn part of a rigid half-space, relative to the diagonal of the box of the picture. A compliant
# half-space is drawn as thick as its layer.
_RIGID_THICKNESS = 0.01
# Size limit (bytes). A picture that is larger gets fewer frames.
_LARGEST = 1_000_000
# Largest integer coordinate in the box of a mesh or surface.
_GRID = 65535
_VIEWER = files("hydroelastic").joinpath("_viewer.html").read_text(encoding="utf-8")


class Picture:
    """Picture that can be turned. A notebook shows the picture as the output of a cell, and ``save`` writes it as a
    page.

    Parameters
    ----------
    page : str
        Page of HTML.
    height : int
        Height (pixels) in a notebook, at least 1.
    shows : str
        Description of the content.

    Raises
    ------
    HydroelasticError
        If the height is out of range.
    """

    def __init__(self, page: str, height: int, shows: str) -> None:
        self._page = page
        self._height = check_count(height, "height", 1)
        self._shows = shows

    @property
    def html(self) -> str:
        """Page of HTML, a complete document that loads nothing."""
        return self._page

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file, which any browser opens.

        Parameters
        ----------
        path : path-like
            File.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        with open(path, "w", encoding="utf-8") as file:
            file.write(self._page)

    def _repr_html_(self) -> str:
        """Returns the page in a sandboxed frame, which can neither access the notebook nor send requests."""
        return (
            f'<iframe sandbox="allow-scripts" srcdoc="{_html.escape(self._page)}" '
            f'style="width: 100%; height: {self._height}px; border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return f"Picture of {self._shows} ({len(self._page) / 1000:.0f} kB; save(path) writes a page that any browser opens)"


def picture(thing: Surface | World | Trajectory, **options: Any) -> Picture:
    """Draws a surface, a world or a trajectory.

    Parameters
    ----------
    thing : Surface, World or Trajectory
        Object to draw.
    **options
        Options of ``of_surface``, ``of_world`` or ``of_trajectory``.

    Returns
    -------
    Picture
        Picture of the object.

    Raises
    ------
    TypeError
        If the object has another type.
    """
    if isinstance(thing, Surface):
        return of_surface(thing, **options)
    if isinstance(thing, World):
        return of_world(thing, **options)
    if isinstance(thing, Trajectory):
        return of_trajectory(thing, **options)
    raise TypeError(f"there are pictures of Surface, World and Trajectory, but not of {type(thing).__name__}")


def html(thing: Surface | World | Trajectory, **options: Any) -> str:
    """Draws a surface, a world or a trajectory as a stand-alone page of HTML.

    Parameters
    ----------
    thing : Surface, World or Trajectory
        Object to draw.
    **options
        Options of ``of_surface``, ``of_world`` or ``of_trajectory``.

    Returns
    -------
    str
        Page of HTML.

    Raises
    ------
    TypeError
        If the object has another type.
    """
    return picture(thing, **options).html


def save(path: str | os.PathLike[str], thing: Surface | World | Trajectory, **options: Any) -> None:
    """Draws a surface, a world or a trajectory, and writes it as a stand-alone page of HTML.

    Parameters
    ----------
    path : path-like
        File.
    thing : Surface, World or Trajectory
        Object to draw.
    **options
        Options of ``of_surface``, ``of_world`` or ``of_trajectory``.

    Raises
    ------
    TypeError
        If the object has another type.
    OSError
        If the file cannot be written.
    """
    picture(thing, **options).save(path)


def of_surface(surface: Surface, *, pressure_limit: float | None = None, height: int = 420) -> Picture:
    """Draws the polygons of a contact surface, colored by pressure.

    Parameters
    ----------
    surface : Surface
        Contact surface.
    pressure_limit : float, optional
        Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    height : int
        Height (pixels) of the picture in a notebook.

    Returns
    -------
    Picture
        Picture of the surface.

    Raises
    ------
    HydroelasticError
        If a number is out of range.
    """
    _check(height, pressure_limit)
    scene = _Scene(pressure_limit)
    scene.add_frame(0.0, np.zeros((0, 4, 4)), [surface])
    return scene.picture(height, repr(surface))


def of_tactile_image(
    image: _Floats, *, size: Sequence[float] = (1.0, 1.0), pressure_limit: float | None = None, height: int = 420
) -> Picture:
    """Draws a tactile image: a rectangle for each taxel, colored by pressure, with an arrow along the shear.

    The picture is flat, even if the patch is curved. Columns follow each other along x, and rows along y. The longest
    arrow is as long as a taxel is wide. The pressure is minus the third component of the image, or 0 if this component
    is positive.

    Parameters
    ----------
    image : (H, W, 3) array_like
        Result of ``Pair.tactile_image`` or ``World.tactile_image``: mean tractions (Pa) or forces (N) on the taxels.
        For forces, the color bar has the unit N.
    size : (2,) array_like
        Lengths (m) of the picture along x and y, positive.
    pressure_limit : float, optional
        Value at the upper end of the color bar. Default: the largest value.
    height : int
        Height (pixels) of the picture in a notebook.

    Returns
    -------
    Picture
        Picture of the image.

    Raises
    ------
    HydroelasticError
        If a number is out of range or not finite, or the image has an unexpected shape.
    """
    _check(height, pressure_limit)
    shape = np.shape(image)
    if len(shape) != 3 or shape[2] != 3 or 0 in shape:
        raise HydroelasticError(f"image must have the shape (H, W, 3), but has {shape}")
    image, lengths = checked(image, "image", shape), checked(size, "size", (2,))
    if (lengths <= 0.0).any():
        raise HydroelasticError(f"size must be two positive lengths, but is {lengths.tolist()}")
    scene = _Scene(pressure_limit)
    widths = lengths / image.shape[1::-1]
    scene.add_frame(0.0, np.zeros((0, 4, 4)), [_taxels(image, widths)])
    scene.add_arrows(*_shear(image, widths))
    return scene.picture(height, f"Tactile image of {image.shape[0]} rows and {image.shape[1]} columns")


def of_world(
    world: World, state: State | None = None, *, pressure_limit: float | None = None, height: int = 420
) -> Picture:
    """Draws the translucent bodies of a world, and the contact surfaces between them, colored by pressure.

    Of a half-space, the picture shows the part of ``World.half_space_outlines``.

    Parameters
    ----------
    world : World
        World.
    state : State, optional
        State of the bodies. Default: the initial state.
    pressure_limit : float, optional
        Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    height : int
        Height (pixels) of the picture in a notebook.

    Returns
    -------
    Picture
        Picture of the world.

    Raises
    ------
    HydroelasticError
        If the state does not fit the world, or a number is out of range.
    """
    _check(height, pressure_limit)
    state = world.initial_state if state is None else state
    scene = _Scene(pressure_limit).with_bodies_of(world)
    scene.add_state(state, [contact.surface for contact in world.contacts(state)])
    return scene.picture(height, f"{world!r} at {state.time:g} s")


def of_trajectory(
    trajectory: Trajectory,
    world: World | None = None,
    *,
    frames: int = 100,
    pressure_limit: float | None = None,
    height: int = 420,
) -> Picture:
    """Draws a trajectory as an animation with a slider.

    Parameters
    ----------
    trajectory : Trajectory
        Trajectory.
    world : World, optional
        World of the trajectory. The picture then has its bodies and contact surfaces. Without a world, the picture has
        the frames of the bodies.
    frames : int
        Maximum number of drawn states. They are evenly spaced and include the first and the last state. There are fewer
        if the picture would exceed 1 MB.
    pressure_limit : float, optional
        Pressure (Pa) at the upper end of the color bar. Default: the largest pressure.
    height : int
        Height (pixels) of the picture in a notebook.

    Returns
    -------
    Picture
        Animation of the trajectory.

    Raises
    ------
    HydroelasticError
        If the trajectory does not fit the world, or a number is out of range.
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
        for index in np.unique(np.linspace(0, len(trajectory) - 1, count).round().astype(int)):
            state = trajectory[index]
            if world is not None and index not in surfaces:
                surfaces[index] = [contact.surface for contact in world.contacts(state)]
            scene.add_state(state, surfaces.get(index, []))
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
    """Arrays in one block of bytes. Each array starts at a multiple of four bytes."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._length = 0

    def add(self, values: NDArray[Any], kind: str) -> list[Any]:
        """Adds an array of a kind ("u1", "u2", "u4", "f4"). Returns its kind, first byte and length."""
        data = np.ascontiguousarray(values).astype("<" + kind).tobytes()
        reference = [kind, self._length, values.size]
        data += bytes(-len(data) % 4)
        self._parts.append(data)
        self._length += len(data)
        return reference

    def add_indices(self, values: _Whole, largest: int) -> list[Any]:
        """Adds indices from 0 to ``largest``."""
        return self.add(values, "u2" if largest <= _GRID else "u4")

    def add_points(self, points: _Floats) -> dict[str, Any]:
        """Adds points (n, 3), rounded to the grid of their box."""
        low, size = points.min(axis=0), np.ptp(points, axis=0)
        on_grid = np.round((points - low) / np.where(size > 0.0, size, 1.0) * _GRID)
        return {"points": self.add(on_grid, "u2"), "low": low.tolist(), "size": size.tolist()}

    def bytes(self) -> bytes:
        return b"".join(self._parts)


class _Scene:
    """Content of a picture, and the page that draws it."""

    def __init__(self, pressure_limit: float | None) -> None:
        self._limit = pressure_limit
        self._packed = _Packed()
        self._shapes: list[dict[str, Any]] = []
        self._bodies: list[dict[str, Any]] = []
        # Half-spaces by the index of the body.
        self._half_spaces: dict[int, HalfSpace] = {}
        self._world: World | None = None
        self._states: list[State] = []
        self._times: list[float] = []
        self._poses: list[_Floats] = []
        self._surfaces: list[tuple[int, Surface]] = []
        self._paths: list[dict[str, Any]] = []

    def with_bodies_of(self, world: World) -> Self:
        self._world = world
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
            if body.shape is None:
                self._bodies[-1]["reach"] = 0.0
                continue
            vertices, triangles = _outline(body.shape)
            key = (vertices.tobytes(), triangles.tobytes())
            if key not in known:
                known[key] = self._add_shape(vertices, triangles)
            reach = float(np.linalg.norm(vertices, axis=1).max())
            self._bodies[-1] |= {"shape": known[key], "reach": reach}
        return self

    def _add_shape(self, vertices: _Floats, triangles: _Whole) -> int:
        """Adds a mesh and returns its index."""
        mesh = self._packed.add_points(vertices)
        mesh["triangles"] = self._packed.add_indices(triangles, len(vertices) - 1)
        mesh["creases"] = self._packed.add_indices(creases(vertices, triangles), len(vertices) - 1)
        self._shapes.append(mesh)
        return len(self._shapes) - 1

    def _add_half_spaces(self, low: _Floats, high: _Floats) -> None:
        """Adds the visible parts of the half-spaces, as plates."""
        if self._world is None or not self._half_spaces:
            return
        outlines = self._world.half_space_outlines(self._states)
        rigid = _RIGID_THICKNESS * (float(np.linalg.norm(high - low)) or 1.0)
        for index, half_space in self._half_spaces.items():
            if len(outlines[index]):
                plate = _plate(outlines[index], half_space.thickness or rigid)
                self._bodies[index]["shape"] = self._add_shape(*plate)

    def add_paths(self, origins: _Floats) -> None:
        """Adds the paths of the origins, (t, n, 3)."""
        for body in range(origins.shape[1]):
            points = origins[:, body]
            if len(points) > 1 and np.ptp(points, axis=0).any():
                # 400 points are enough to look smooth.
                indices = np.unique(np.linspace(0, len(points) - 1, 400).round().astype(int))
                self._paths.append({"points": self._packed.add(points[indices], "f4"), "body": body})

    def add_arrows(self, tails: _Floats, vectors: _Floats) -> None:
        """Adds arrows in planes of constant z. Tails and vectors are (n, 3)."""
        aside = np.stack([-vectors[:, 1], vectors[:, 0], vectors[:, 2]], axis=1)
        heads = tails + vectors
        barbs = [heads - 0.3 * vectors + sign * 0.15 * aside for sign in (-1.0, 1.0)]
        for points in np.stack([tails, heads, barbs[0], heads, barbs[1]], axis=1):
            self._paths.append({"points": self._packed.add(points, "f4"), "body": 0})

    def add_state(self, state: State, surfaces: Sequence[Surface]) -> None:
        self._states.append(state)
        self.add_frame(state.time, state.poses, surfaces)

    def add_frame(self, time: float, poses: _Floats, surfaces: Sequence[Surface]) -> None:
        index = len(self._times)
        self._times.append(time)
        self._poses.append(poses[:, :3, :])
        self._surfaces += [(index, surface) for surface in surfaces if len(surface)]

    def page(self) -> str:
        greatest = max((float(surface.pressures.max()) for _, surface in self._surfaces), default=0.0)
        limit = self._limit or greatest or 1.0
        low, high = self._box()
        self._add_half_spaces(low, high)
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
        """Returns two corners of a box around all surfaces and the moving bodies in all frames. If no body moves, the
        box is around all bodies without half-spaces."""
        origins = np.array(self._poses)[..., 3]
        bounded = [index for index in range(len(self._bodies)) if index not in self._half_spaces]
        of_bodies = [index for index in bounded if self._bodies[index]["moves"]] or bounded
        points = [surface.vertices for _, surface in self._surfaces]
        for index in of_bodies:
            reach = self._bodies[index]["reach"]
            points += [origins[:, index] - reach, origins[:, index] + reach]
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


def _taxels(image: _Floats, widths: _Floats) -> Surface:
    """Returns the taxels of an image as rectangles of constant pressure in the plane z = 0."""
    rows, columns = image.shape[:2]
    count = rows * columns
    corners = _middles(image, widths)[:, None, :2] + 0.5 * widths * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    vertices = np.concatenate([corners, np.zeros((count, 4, 1))], axis=2)
    pressures = np.maximum(-image[..., 2].ravel(), 0.0)
    area = float(widths.prod())
    return Surface(
        vertices.reshape(-1, 3),
        np.arange(0, 4 * count + 1, 4),
        np.repeat(pressures, 4),
        np.tile([0.0, 0.0, 1.0], (count, 1)),
        np.full(count, area),
        vertices.mean(axis=1),
        pressures,
        np.zeros((count, 2), dtype=np.int64),
        area * count,
        None,
    )


def _middles(image: _Floats, widths: _Floats) -> _Floats:
    """Returns the centers of the taxels of a picture that is centered on the origin, (H W, 3)."""
    rows, columns = image.shape[:2]
    y, x = np.mgrid[:rows, :columns]
    places = np.stack([x.ravel(), y.ravel()], axis=1) - 0.5 * np.array([columns - 1, rows - 1])
    return np.concatenate([places * widths, np.zeros((rows * columns, 1))], axis=1)


def _shear(image: _Floats, widths: _Floats) -> tuple[_Floats, _Floats]:
    """Returns the tails and the vectors of arrows along the shear of taxels."""
    shear = image[..., :2].reshape(-1, 2)
    sizes = np.linalg.norm(shear, axis=1)
    greatest = sizes.max()
    # Shorter arrows would look like dots.
    shown = np.flatnonzero(sizes > 0.02 * greatest)
    vectors = np.zeros((len(shown), 3))
    vectors[:, :2] = shear[shown] * (widths.min() / greatest if greatest > 0.0 else 0.0)
    above = np.array([0.0, 0.0, 0.01 * widths.min()])
    return _middles(image, widths)[shown] - 0.5 * vectors + above, vectors


def _outline(shape: Shape | RigidShape) -> tuple[_Floats, _Whole]:
    """Returns the vertices and triangles of the surface of a shape."""
    if isinstance(shape, RigidShape):
        return shape.vertices, shape.triangles
    used, triangles = np.unique(shape.surface_triangles, return_inverse=True)
    return shape.vertices[used], triangles.reshape(-1, 3)


def _plate(corners: _Floats, thickness: float) -> tuple[_Floats, _Whole]:
    """Returns the vertices and triangles of a plate below a convex polygon, which is counter-clockwise seen from above."""
    count = len(corners)
    top = np.array([[0, i - 1, i] for i in range(2, count)])
    i, j = np.arange(count), (np.arange(count) + 1) % count
    sides = [np.stack([i + count, j + count, j], axis=1), np.stack([i + count, j, i], axis=1)]
    triangles = np.concatenate([top, top[:, ::-1] + count, *sides])
    return np.concatenate([corners, corners - [0.0, 0.0, thickness]]), triangles


def creases(vertices: _Floats, triangles: _Whole) -> _Whole:
    """Returns the edges, (m, 2), between triangles of a closed surface whose normals differ by more than 30 degrees."""
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owners = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owners = edges[order], owners[order]
    # After sorting, the two copies of an edge are adjacent.
    twin = np.flatnonzero((edges[1:] == edges[:-1]).all(axis=1))
    cosines = np.einsum("ij,ij->i", normals[owners[twin]], normals[owners[twin + 1]])
    sharp: _Whole = edges[twin[cosines < math.cos(_CREASE)]]
    return sharp
