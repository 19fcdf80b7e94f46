"""Solids: tetrahedra inside surfaces, triangles with holes, and distance functions, with their derivatives."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

FIELD_FILES = Path(__file__).parents[2] / "tests" / "data" / "field_files"

# Error of central differences of forces with steps of 1e-7 m, over the derivative.
DIFFERENCES = 1e-5
# Round-off of sums in another order.
ROUNDING = 1e-12

CENTER = np.array([0.003, -0.005, 0.002])  # Off the nodes of the lattice.


def ball_of(radius):
    return lambda points: np.linalg.norm(points - CENTER, axis=1) - radius


def of_ball(radius=0.1, **resolution):
    return he.Solid.of_distance(ball_of(radius), [-0.12] * 3, [0.12] * 3, **resolution or {"spacing": 0.04})


def distance_of_unit_ball(points):
    """A distance that can be pickled."""
    return np.linalg.norm(points, axis=1) - 1.0


def force_on(shape):
    """Returns the force along z on a shape of about 10 cm that is pressed into the ground, and its gradient."""
    pair, pose = he.Pair(shape, he.HalfSpace(), 1e5), he.pose([0.0, 0.0, 0.09])
    gradient, _ = pair.shape_gradients(pose, he.pose(), np.eye(12)[5])
    return pair.wrench(pose, he.pose())[5], gradient


def test_solids_fill_surfaces_and_unite_parts():
    surface = he.RigidShape.around(he.Shape.icosphere(0.1, 2))
    solid = he.Solid.of_surface(surface, distance_error=0.05)
    assert 0.0 < solid.distance_error <= 0.05 and 0.0 < solid.volume_error <= 0.01
    assert solid.volume_error == pytest.approx(abs(solid.shape.volume / surface.volume - 1.0))
    assert solid.vertices.shape[1] == 3 and solid.tets.shape[1] == 4 and np.array_equal(solid.surface_vertices, surface.vertices)
    assert 1.0 < solid.shape.extents.max() < 1.05 and (solid.shape.extents[solid.boundary_vertices] == 0.0).all()
    coarse = he.Solid.of_surface(surface, spacing=0.04)
    assert coarse.spacing == 0.04 > solid.spacing and coarse.distance_error is None
    inwards = he.Solid.of_triangles(surface.vertices, surface.triangles[:, ::-1], spacing=coarse.spacing)
    assert inwards.volume_error is None and np.array_equal(inwards.tets, coarse.tets)
    # The parts of 1 m³ overlap by half.
    assert he.Solid.read(FIELD_FILES / "overlap.stl", spacing=0.2).shape.volume == pytest.approx(1.5, rel=0.05)


def test_small_holes_are_closed():
    surface = he.RigidShape.around(he.Shape.icosphere(0.1, 2))
    whole, holed = (he.Solid.of_triangles(surface.vertices, surface.triangles[k:], spacing=0.04) for k in (0, 1))
    assert np.array_equal(whole.tets, holed.tets)
    assert len(holed.ambiguous) >= len(whole.ambiguous)


def test_files_are_placed_with_warnings_about_their_unit(recwarn):
    pose = he.pose([0.0, 0.0, 3.0])
    solid = he.Solid.read(FIELD_FILES / "tetrahedron.off", 0.1, scale=[-1.0, 2.0, 1.0], pose=pose, spacing=0.02)
    assert solid.shape.volume == pytest.approx(1e-3 / 3, rel=0.2)
    assert solid.vertices[:, 2].min() > 2.99 and solid.vertices[:, 0].max() < 0.01
    assert solid.volume_error == pytest.approx(abs(3e3 * solid.shape.volume - 1.0))  # The file is closed.
    solid = he.Solid.read(FIELD_FILES / "polygons.vtk", unit=1e3, spacing=200.0)
    assert not recwarn
    with pytest.warns(UserWarning, match="tetrahedron.off: the surface is 1.000e3 m large.*unit=1.0 reads meters"):
        he.Solid.read(FIELD_FILES / "tetrahedron.off", scale=[1e3] * 3, spacing=200.0)
    with pytest.raises(FileNotFoundError, match="nothing.stl"):
        he.Solid.read("nothing.stl")
    with pytest.raises(he.HydroelasticError, match="points.obj: a solid needs triangles with a positive area, but there are none"):
        he.Solid.read(FIELD_FILES / "points.obj")


def test_moving_surfaces_equal_differences():
    solid = he.Shape.icosphere(0.1, 1)
    surface = he.RigidShape.around(solid)
    velocities = np.random.default_rng(1).uniform(-1.0, 1.0, surface.vertices.shape)
    vertices = surface.vertices + 1e-3 * velocities + CENTER  # A shape without symmetries.

    def filled(time):
        return he.Solid.of_triangles(vertices + time * velocities, surface.triangles, spacing=0.04)

    solid = filled(0.0)
    assert solid.ambiguous == []
    _, gradient = force_on(solid.shape)
    derivative = np.sum(solid.pullback(gradient.by_vertices, gradient.by_extents) * velocities)
    assert gradient.along(solid.rates(velocities)) == pytest.approx(derivative, rel=ROUNDING)
    ends = [force_on(filled(time).shape)[0] for time in (-1e-7, 1e-7)]
    assert (ends[1] - ends[0]) / 2e-7 == pytest.approx(derivative, rel=DIFFERENCES)


def test_parameters_of_distance_functions_equal_differences():
    solid = of_ball()
    assert solid.ambiguous == []
    offsets = solid.vertices[solid.boundary_vertices] - CENTER
    assert np.allclose(np.linalg.norm(offsets, axis=1), 0.1, rtol=ROUNDING)
    _, gradient = force_on(solid.shape)
    derivative = gradient.along(solid.rates_of_distance(offsets / 0.1, np.full(len(offsets), -1.0)))
    ends = [force_on(of_ball(0.1 + change).shape)[0] for change in (-1e-7, 1e-7)]
    assert (ends[1] - ends[0]) / 2e-7 == pytest.approx(derivative, rel=DIFFERENCES)
    assert solid.surface_vertices.shape == (0, 3)
    assert solid.pullback(gradient.by_vertices, gradient.by_extents).shape == (0, 3)


def test_exceptions_of_distance_functions_are_raised_unchanged():
    failure = KeyError("mine")

    def raising(points):
        raise failure

    with pytest.raises(KeyError) as caught:
        he.Solid.of_distance(raising, [-1.0] * 3, [1.0] * 3)
    assert caught.value is failure

    def interrupted(points):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        he.Solid.of_distance(interrupted, [-1.0] * 3, [1.0] * 3)
    refusals = {
        "returned 1 values for": lambda points: np.zeros(1),
        "the result of the distance function must have the shape (n,)": lambda points: np.zeros((len(points), 1)),
        "the distance function is NaN at": lambda points: np.full(len(points), np.nan),
        "on or outside of the bounds": lambda points: np.full(len(points), -1.0),
    }
    for reason, distances in refusals.items():
        with pytest.raises(he.HydroelasticError) as caught:
            he.Solid.of_distance(distances, [-1.0] * 3, [1.0] * 3)
        assert reason in str(caught.value)
    for result in (None, "text"):
        with pytest.raises(TypeError, match="the result of the distance function must be a numpy array"):
            he.Solid.of_distance(lambda points: result, [-1.0] * 3, [1.0] * 3)
    with pytest.raises(he.HydroelasticError, match="several were given: spacing=0.1, volume_error=0.1"):
        of_ball(spacing=0.1, volume_error=0.1)


def test_solids_can_be_pickled():
    surface = he.RigidShape.around(he.Shape.icosphere(0.1, 1))
    for solid in (
        he.Solid.of_surface(surface, volume_error=0.1),
        he.Solid.of_triangles(surface.vertices, surface.triangles, spacing=0.05),
        he.Solid.of_distance(distance_of_unit_ball, [-1.1] * 3, [1.1] * 3, spacing=0.5),
    ):
        loaded = pickle.loads(pickle.dumps(solid))
        assert repr(loaded) == repr(solid) and loaded.volume_error == solid.volume_error
        assert np.array_equal(loaded.vertices, solid.vertices) and np.array_equal(loaded.shape.extents, solid.shape.extents)
        ones = np.ones(solid.surface_vertices.shape)
        assert np.array_equal(loaded.rates(ones).vertices, solid.rates(ones).vertices)
