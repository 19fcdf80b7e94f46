"""Derivatives of contacts with respect to shapes, compared with differences and with each other."""

import pickle

import numpy as np
import pytest

import hydroelastic as he

# Error of second-order differences of wrenches of about 10 N with steps of 1e-7 m.
DIFFERENCES = 1e-6
# Round-off of sums in another order.
ROUNDING = 1e-12


def reshaped(shape, moves, changes):
    """Returns the shape with moved vertices and changed extents."""
    return he.Shape(shape.vertices + moves, shape.tets, shape.extents + changes, inert_tets=True)


@pytest.fixture(scope="module")
def by_wrenches():
    return np.random.default_rng(1).uniform(-1.0, 1.0, 12)


@pytest.mark.parametrize("moving", [False, True])
def test_gradients_are_those_of_differences(ball_on_block, twists, by_wrenches, moving):
    pair, pose_a, pose_b = ball_on_block
    motion = twists if moving else (None, None)
    gradients = pair.shape_gradients(pose_a, pose_b, by_wrenches, *motion)
    random = np.random.default_rng(2)
    for side in range(2):
        shape, actual = pair.shapes[side], gradients[side]
        assert actual.by_vertices.shape == shape.vertices.shape and actual.by_extents.shape == shape.extents.shape
        moves = random.uniform(-1.0, 1.0, shape.vertices.shape)
        # The extents of the surface stay 0.
        changes = np.where(shape.extents > 0.0, random.uniform(-1.0, 1.0, shape.extents.shape), 0.0)
        for along, step, expected in (
            ((moves, 0.0 * changes), 1e-7, np.sum(moves * actual.by_vertices)),
            ((0.0 * moves, changes), 1e-6, np.sum(changes * actual.by_extents)),
        ):

            def value(sign):
                shapes = list(pair.shapes)
                shapes[side] = reshaped(shape, *(sign * step * direction for direction in along))
                return by_wrenches @ he.Pair(*shapes, *pair.moduli, pair.law).wrench(pose_a, pose_b, *motion)

            difference = (value(1.0) - value(-1.0)) / (2.0 * step)
            assert abs(difference) > 0.0
            assert abs(difference - expected) < DIFFERENCES * np.abs(actual.by_vertices).sum()


@pytest.mark.parametrize("moving", [False, True])
def test_jacobians_by_vertices_are_rows_of_the_gradients(ball_on_block, twists, by_wrenches, moving):
    pair, pose_a, pose_b = ball_on_block
    motion = twists if moving else (None, None)
    gradients = pair.shape_gradients(pose_a, pose_b, by_wrenches, *motion)
    touched = [np.flatnonzero(np.abs(gradient.by_vertices).max(1))[:5] for gradient in gradients]
    assert all(len(vertices) > 2 for vertices in touched)
    jacobians = pair.vertex_jacobians(pose_a, pose_b, *touched, *motion)
    for vertices, jacobian, gradient in zip(touched, jacobians, gradients):
        assert jacobian.shape == (len(vertices), 12, 3)
        expected = gradient.by_vertices[vertices]
        assert np.allclose(by_wrenches @ jacobian, expected, rtol=0, atol=ROUNDING * np.abs(expected).max())
    of_a, of_b = pair.vertex_jacobians(pose_a, pose_b, [int(touched[0][0])])
    assert of_a.shape == (1, 12, 3) and of_b.shape == (0, 12, 3)


def test_batches_have_the_bits_of_single_calls(ball_on_block, twists, by_wrenches):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-4 * k]) for k in range(6)])
    covectors = np.stack([(k + 1) * by_wrenches for k in range(6)])
    actual = pair.shape_gradients(many, pose_b, covectors, *twists)
    jacobians = pair.vertex_jacobians(many, pose_b, [0, 1], [2], *twists)
    for k in range(6):
        expected = pair.shape_gradients(many[k], pose_b, covectors[k], *twists)
        for one, other in zip(actual, expected):
            assert np.array_equal(one.by_vertices[k], other.by_vertices)
            assert np.array_equal(one.by_extents[k], other.by_extents)
        for one, other in zip(jacobians, pair.vertex_jacobians(many[k], pose_b, [0, 1], [2], *twists)):
            assert np.array_equal(one[k], other)


def test_empty_batches_and_no_vertices_give_empty_arrays(ball_on_block, by_wrenches):
    pair, pose_a, pose_b = ball_on_block
    empty = np.zeros((0, 4, 4))
    for poses, shape in ((pose_a, ()), (np.stack([pose_a] * 5), (5,)), (empty, (0,))):
        for actual in pair.vertex_jacobians(poses, pose_b):
            assert actual.shape == (*shape, 0, 12, 3)
        by_a, by_b = pair.vertex_jacobians(poses, pose_b, [0, 1])
        assert by_a.shape == (*shape, 2, 12, 3) and by_b.shape == (*shape, 0, 12, 3)
    for call in (pair.wrench, pair.potential_energy, pair.linearized, pair.wrench_and_jacobian):
        actual = call(empty, pose_b)
        assert all(len(array) == 0 for array in (actual if isinstance(actual, tuple) else (actual,)))
    for gradient in pair.shape_gradients(empty, pose_b, by_wrenches):
        assert gradient.by_vertices.shape[0] == gradient.by_extents.shape[0] == 0


def test_partners_have_the_vertices_of_their_kind(ball_on_block, by_wrenches):
    pair, pose_a, _ = ball_on_block
    ball, block = pair.shapes
    rigid = he.RigidShape.around(block)
    for partner, modulus, height, vertices in (
        (rigid, None, 0.0, len(rigid.vertices)),
        (he.HalfSpace(), None, 0.1, 0),
        (he.HalfSpace(0.05), 1e6, 0.1, 0),
    ):
        pose_b = he.pose([0.0, 0.0, height])
        on_ball, on_partner = he.Pair(ball, partner, 1e5, modulus).shape_gradients(pose_a, pose_b, by_wrenches)
        assert on_partner.by_vertices.shape == (vertices, 3) and on_partner.by_extents.shape == (0,)
        assert np.abs(on_ball.by_vertices).max() > 0.0
        assert (np.abs(on_partner.by_vertices).max(initial=0.0) > 0.0) == (vertices > 0)


@pytest.mark.parametrize("kind", [lambda shape: shape, he.RigidShape.around])
def test_mass_gradient_is_that_of_differences(kind):
    shape = kind(he.Shape.ellipsoid([0.1, 0.2, 0.3], 1))
    random = np.random.default_rng(3)
    by_mass, by_center, by_inertia = 0.7, random.normal(size=3), random.normal(size=(3, 3))
    actual = shape.mass_gradient(500.0, by_mass, by_center, by_inertia)
    moves = random.uniform(-1.0, 1.0, shape.vertices.shape)

    def value(step):
        vertices = shape.vertices + step * moves
        if isinstance(shape, he.RigidShape):
            moved = he.RigidShape(vertices, shape.triangles)
        else:
            moved = he.Shape(vertices, shape.tets, shape.extents)
        mass, center, inertia = moved.mass_properties(500.0)
        return by_mass * mass + by_center @ center + np.sum(by_inertia * inertia)

    difference = (value(1e-6) - value(-1e-6)) / 2e-6
    assert abs(np.sum(actual * moves) - difference) < DIFFERENCES * abs(difference)


def test_what_does_not_fit_is_refused(ball_on_block, by_wrenches):
    pair, pose_a, pose_b = ball_on_block
    with pytest.raises(he.HydroelasticError, match=r"by_wrenches must have the shape \(12,\)"):
        pair.shape_gradients(pose_a, pose_b, by_wrenches[:6])
    with pytest.raises(he.HydroelasticError, match="pose_a is a batch of 2, but by_wrenches one of 3"):
        pair.shape_gradients(np.stack([pose_a] * 2), pose_b, np.stack([by_wrenches] * 3))
    count = len(pair.shapes[0].vertices)
    with pytest.raises(he.HydroelasticError, match=str(count)):
        pair.vertex_jacobians(pose_a, pose_b, [count])
    with pytest.raises(he.HydroelasticError, match=r"by_inertia must have the shape \(3, 3\)"):
        pair.shapes[0].mass_gradient(1.0, 1.0, np.zeros(3), np.zeros((2, 3)))


def test_gradients_can_be_pickled(ball_on_block, by_wrenches):
    pair, pose_a, pose_b = ball_on_block
    gradient, _ = pair.shape_gradients(pose_a, pose_b, by_wrenches)
    loaded = pickle.loads(pickle.dumps(gradient))
    assert np.array_equal(loaded.by_vertices, gradient.by_vertices)
    assert np.array_equal(loaded.by_extents, gradient.by_extents)
    count = len(pair.shapes[0].vertices)
    assert repr(loaded) == f"ShapeGradient(by_vertices ({count}, 3), by_extents ({count},))"


MADE_OF = {
    "icosphere": (lambda x: he.Shape.icosphere(x[0], 2), lambda x: he.Shape.icosphere_rates(x[0], 2), [0.1]),
    "ellipsoid": (lambda x: he.Shape.ellipsoid(x, 1), lambda x: he.Shape.ellipsoid_rates(x, 1), [0.1, 0.12, 0.11]),
    "cuboid": (he.Shape.cuboid, he.Shape.cuboid_rates, [0.2, 0.2, 0.2]),
    "distance_cuboid": (he.Shape.distance_cuboid, he.Shape.distance_cuboid_rates, [0.2, 0.25, 0.3]),
    "capsule": (lambda x: he.Shape.capsule(*x, 7), lambda x: he.Shape.capsule_rates(*x, 7), [0.1, 0.01]),
    "torus": (lambda x: he.Shape.torus(*x, 7, 6), lambda x: he.Shape.torus_rates(*x, 7, 6), [0.15, 0.06]),
    "lathe": (
        lambda x: he.Shape.lathe(np.reshape(x, (-1, 2)), 7, 0.05),
        lambda x: he.Shape.lathe_rates(np.reshape(x, (-1, 2)), 7, 0.05),
        [0.05, -0.1, 0.15, -0.095, 0.1, 0.1],
    ),
    "extrusion": (
        lambda x: he.Shape.extrusion(np.reshape(x[:-1], (-1, 2)), x[-1], 0.1),
        lambda x: he.Shape.extrusion_rates(np.reshape(x[:-1], (-1, 2)), x[-1], 0.1),
        [-0.1, -0.1, 0.11, -0.09, 0.0, 0.12, 0.2],
    ),
    "cylinder": (lambda x: he.Shape.cylinder(*x, 7), lambda x: he.Shape.cylinder_rates(*x, 7), [0.1, 0.3]),
}


@pytest.mark.parametrize("kind", MADE_OF)
def test_dimensions_of_shapes_equal_differences(kind, ball_on_block, by_wrenches):
    make, rates_of, dimensions = MADE_OF[kind]
    pair, pose_a, pose_b = ball_on_block
    block = pair.shapes[1]
    shape, rates = make(dimensions), rates_of(dimensions)
    count = len(dimensions)
    assert rates.vertices.shape == (count, *shape.vertices.shape) and rates.extents.shape == (count, len(shape.extents))
    # The farthest vertices of a solid of revolution stay equally far. Vertices at kinks of the distance have several closest points.
    assert rates.ambiguous == [] or kind in ("lathe", "extrusion")
    gradient, of_block = he.Pair(shape, block, *pair.moduli).shape_gradients(pose_a, pose_b, by_wrenches)
    actual = gradient.along(rates)
    assert actual.shape == (count,)
    for index in range(count):

        def value(change):
            changed = np.array(dimensions)
            changed[index] += change
            return by_wrenches @ he.Pair(make(list(changed)), block, *pair.moduli).wrench(pose_a, pose_b)

        difference = (value(1e-7) - value(-1e-7)) / 2e-7
        assert abs(difference) > 0.0
        assert abs(difference - actual[index]) < DIFFERENCES * np.abs(gradient.by_vertices).sum()
    with pytest.raises(he.HydroelasticError, match="the vertices of the rates must have the shape"):
        of_block.along(he.ShapeRates(np.zeros((4, 3)), np.zeros(4)))


def test_rates_of_batches_and_rates_of_one_number(ball_on_block, by_wrenches):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-4 * k]) for k in range(4)])
    gradients, _ = pair.shape_gradients(many, pose_b, by_wrenches)
    rates = he.Shape.ellipsoid_rates([0.1, 0.1, 0.1], 3)
    actual = gradients.along(rates)
    assert actual.shape == (4, 3)
    one = he.ShapeRates(rates.vertices[1], rates.extents[1])
    assert np.allclose(gradients.along(one), actual[:, 1], rtol=ROUNDING, atol=0.0)
    single, _ = pair.shape_gradients(many[2], pose_b, by_wrenches)
    assert np.allclose(single.along(one), actual[2, 1], rtol=ROUNDING, atol=0.0)
    assert he.Shape.distance_cuboid_rates([0.2, 0.2, 0.2]).ambiguous == [8]


@pytest.mark.parametrize("depth", [None, 0.03])
def test_meshes_below_fields_of_distances_equal_differences(ball_on_block, by_wrenches, depth):
    pair, pose_a, pose_b = ball_on_block
    block = pair.shapes[1]
    random = np.random.default_rng(5)
    solid = he.Shape.icosphere(0.1, 1)
    # The shape has no symmetries.
    vertices = solid.vertices + 1e-3 * random.uniform(-1.0, 1.0, solid.vertices.shape)
    made = he.LinearizedShape(vertices, solid.tets, depth)
    assert made.ambiguous == []
    gradient, _ = he.Pair(made.shape, block, *pair.moduli).shape_gradients(pose_a, pose_b, by_wrenches)
    by_mesh, by_depth = made.pullback(gradient.by_vertices, gradient.by_extents)
    assert by_mesh.shape == vertices.shape and (by_depth == 0.0) == (depth is None)
    velocities = random.uniform(-1.0, 1.0, vertices.shape)

    def value(time, change=0.0):
        shape = he.LinearizedShape(vertices + time * velocities, solid.tets, None if depth is None else depth + change).shape
        return by_wrenches @ he.Pair(shape, block, *pair.moduli).wrench(pose_a, pose_b)

    difference = (value(1e-7) - value(-1e-7)) / 2e-7
    scale = DIFFERENCES * np.abs(gradient.by_vertices).sum()
    actual = np.sum(by_mesh * velocities)
    assert abs(difference - actual) < scale
    assert np.isclose(gradient.along(made.rates(velocities)), actual, rtol=0.0, atol=1e-6 * scale)
    difference = (value(0.0, 1e-7) - value(0.0, -1e-7)) / 2e-7
    assert abs(difference - by_depth) < scale
    assert np.isclose(gradient.along(made.rates_by_depth()), by_depth, rtol=0.0, atol=1e-6 * scale)


def test_refined_meshes_have_the_same_derivatives_in_both_modes():
    solid = he.Shape.cuboid([0.2, 0.3, 0.25])
    made = he.LinearizedShape(solid.vertices, solid.tets, tolerance=0.02)
    refined = he.Shape(solid.vertices, solid.tets, tolerance=0.02)
    assert np.array_equal(made.shape.extents, refined.extents) and len(refined.extents) > len(solid.extents)
    random = np.random.default_rng(6)
    by_vertices, by_extents = random.normal(size=refined.vertices.shape), random.normal(size=refined.extents.shape)
    velocities = random.normal(size=solid.vertices.shape)
    by_mesh, by_depth = made.pullback(by_vertices, by_extents)
    along = he.ShapeGradient(by_vertices, by_extents).along(made.rates(velocities))
    assert by_depth == 0.0 and np.isclose(np.sum(by_mesh * velocities), along, rtol=1e-10)
    assert repr(pickle.loads(pickle.dumps(made))) == repr(made)
    with pytest.raises(he.HydroelasticError, match="a shape with a skin has no tolerance"):
        he.LinearizedShape(solid.vertices, solid.tets, 0.01, 0.01)
    with pytest.raises(he.HydroelasticError, match="a tolerance is that of distances, but extents were given"):
        he.Shape(solid.vertices, solid.tets, solid.extents, tolerance=0.01)


def test_rates_and_linearized_shapes_can_be_pickled():
    rates = he.Shape.distance_cuboid_rates([0.2, 0.2, 0.2])
    loaded = pickle.loads(pickle.dumps(rates))
    assert np.array_equal(loaded.vertices, rates.vertices) and loaded.ambiguous == rates.ambiguous
    assert repr(loaded) == repr(rates) == "ShapeRates(vertices (3, 9, 3), extents (3, 9), 1 ambiguous)"
    solid = he.Shape.icosphere(0.1, 1)
    made = he.LinearizedShape(solid.vertices, solid.tets, 0.03)
    loaded = pickle.loads(pickle.dumps(made))
    assert repr(loaded) == repr(made)
    velocities = np.ones(solid.vertices.shape)
    assert np.array_equal(loaded.rates(velocities).vertices, made.rates(velocities).vertices)
