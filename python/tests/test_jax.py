"""Wrenches, steps and rollouts in JAX: derivatives in both modes, batches and errors."""

import importlib
import logging
import subprocess
import sys

import numpy as np
import pytest

import hydroelastic as he
from hydroelastic import _autodiff

jax = pytest.importorskip("jax")
hj = importlib.import_module("hydroelastic.jax")
jnp = jax.numpy
check_grads = importlib.import_module("jax.test_util").check_grads
# The module of this function depends on the version of JAX.
enable_x64 = (jax if hasattr(jax, "enable_x64") else importlib.import_module("jax.experimental")).enable_x64

# Round-off of fourth-order differences of wrenches, with no facet that begins or ends contact.
WRENCH = 1e-9
# Error of differences of rollouts through a bounce. The second derivatives jump as facets begin and end contact.
ROLLOUT = 1e-7
# Error with friction, whose law is curved within the slip tolerance.
FRICTION = 1e-6
# Round-off of the entries of a rotation, computed in another order.
ROTATION = 1e-15
# check_grads uses second-order differences.
CHECK = {"order": 1, "modes": ("fwd", "rev"), "atol": 1e-5, "rtol": 1e-5, "eps": 1e-6}


@pytest.fixture(autouse=True)
def precision():
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


@pytest.fixture(scope="module")
def start():
    """Rotation vectors and positions of A and B, twists of A and B, moduli in units of 1e5 Pa, and the law."""
    poses = [0.3, -0.2, 0.5, 0.013, 0.021, 0.1921, 0.02, -0.03, 0.01, 0.0, 0.0, 0.0]
    twists = [0.1, 0.2, -0.3, 0.5, 0.1, -0.05, 0.0, 0.0, 0.1, 0.0, -0.1, 0.0]
    return np.array(poses + twists + [1.0, 10.0, 0.2, 0.4])


def poses(numbers):
    return hj.pose(numbers[3:6], numbers[:3]), hj.pose(numbers[9:12], numbers[6:9])


def at_rest(pair):
    """Returns the wrenches at rest, in units of 10 N and 10 N m, as a function of 14 numbers."""
    return lambda numbers: hj.wrench(pair, *poses(numbers), moduli=1e5 * numbers[12:]) / 10


def in_motion(pair):
    """Returns the wrenches in motion as a function of 28 numbers."""

    def wrench(numbers):
        moduli, law = 1e5 * numbers[24:26], numbers[26:]
        return hj.wrench(pair, *poses(numbers), numbers[12:18], numbers[18:24], moduli=moduli, law=law) / 10

    return wrench


def differences(function, at, steps):
    """Computes the Jacobian by central differences of fourth order."""
    columns = []
    for column, step in enumerate(np.broadcast_to(steps, at.shape)):
        unit = step * np.eye(len(at))[column]
        near, far = (function(at + k * unit) - function(at - k * unit) for k in (1, 2))
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, -1)


def deviation(actual, expected, kinds=None):
    """Returns the largest deviation, relative to the largest entry of a column or of all columns of its kind."""
    kinds = np.arange(expected.shape[1]) if kinds is None else kinds
    largest = np.abs(expected).max(0)
    scale = np.array([largest[kinds == kind].max() for kind in kinds])
    return (np.abs(actual - expected).max(0) / scale).max()


# Kind of each number: rotation, translation, angular velocity, velocity, modulus, dissipation or friction. Rotations of
# a ball about its center have almost no effect, so each kind has one scale.
KINDS = np.repeat([0, 1, 0, 1, 2, 3, 2, 3, 4, 5, 6], [3, 3, 3, 3, 3, 3, 3, 3, 2, 1, 1])
# Numbers of a contact at rest.
REST = [*range(12), 24, 25]
STEPS = np.repeat([1e-5, 1e-4, 1e-3], [12, 12, 4])


@pytest.mark.parametrize("kind, columns", [(at_rest, REST), (in_motion, range(28))])
def test_wrench_has_the_derivatives_of_differences(ball_on_block, start, kind, columns):
    wrench, at, columns = kind(ball_on_block[0]), start[list(columns)], list(columns)
    forward, reverse = (np.asarray(jacobian(wrench)(at)) for jacobian in (jax.jacfwd, jax.jacrev))
    assert deviation(reverse, forward) < 1e-12
    assert deviation(differences(jax.jit(wrench), at, STEPS[columns]), forward, KINDS[columns]) < WRENCH
    check_grads(jax.jit(wrench), (at,), **CHECK)


def partners():
    """Partners of a ball, with their moduli and the height (m) of the frame that puts their top below the ball."""
    block = he.RigidShape.around(he.Shape.cuboid([0.4, 0.4, 0.2]))
    return {"half-space": (he.HalfSpace(), None, 0.1), "layer": (he.HalfSpace(0.05), 1e6, 0.1), "block": (block, None, 0.0)}


@pytest.mark.parametrize("kind, columns", [(at_rest, REST), (in_motion, range(28))])
@pytest.mark.parametrize("name", partners())
def test_wrench_on_partners_has_the_derivatives_of_differences(start, name, kind, columns):
    partner, modulus, height = partners()[name]
    wrench = kind(he.Pair(he.Shape.icosphere(0.1, 3), partner, 1e5, modulus))
    at, columns = start[list(columns)], list(columns)
    at[11] = height
    forward, reverse = (np.asarray(jacobian(wrench)(at)) for jacobian in (jax.jacfwd, jax.jacrev))
    assert deviation(reverse, forward, KINDS[columns]) < 1e-12
    # A rigid partner has no modulus.
    assert forward[:, columns.index(25)].any() == (modulus is not None)
    assert deviation(differences(jax.jit(wrench), at, STEPS[columns]), forward, KINDS[columns]) < WRENCH
    check_grads(jax.jit(wrench), (at,), **CHECK)


def test_the_modulus_that_a_rigid_partner_has_not_need_not_be_given():
    pair = he.Pair(he.Shape.icosphere(0.1, 2), he.HalfSpace(), 1e5)

    def lift(height):
        return hj.wrench(pair, hj.pose(jnp.array([0.0, 0.0, 1.0]) * height), hj.pose())[5]

    value, slope = jax.jit(jax.value_and_grad(lift))(0.095)
    assert value > 0.0 and slope < 0.0 and lift(0.095) == pair.wrench(he.pose([0.0, 0.0, 0.095]), he.pose())[5]
    check_grads(jax.jit(lift), (0.095,), **CHECK)


def test_wrench_has_the_bits_of_the_library(ball_on_block, twists):
    pair, pose_a, pose_b = ball_on_block
    assert np.array_equal(hj.wrench(pair, pose_a, pose_b), pair.wrench(pose_a, pose_b))
    expected = pair.wrench(pose_a, pose_b, *twists, moduli=[2e5, 1e6], law=[0.1, 0.3])
    arguments = {"moduli": np.array([2e5, 1e6]), "law": [0.1, 0.3]}
    actual = hj.wrench(pair, pose_a, pose_b, *twists, **arguments)
    assert np.array_equal(actual, expected)
    assert np.array_equal(jax.jit(lambda a: hj.wrench(pair, a, pose_b, *twists, **arguments))(pose_a), expected)
    assert np.array_equal(hj.wrench(pair, pose_a, pose_b, twists[0]), pair.wrench(pose_a, pose_b, twists[0]))


def test_a_batch_is_one_call_with_the_same_bits(ball_on_block, monkeypatch):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-4 * k]) for k in range(6)])
    expected = pair.wrench(many, pose_b)
    calls = counted(monkeypatch, _autodiff.Wrench)
    mapped = jax.jit(jax.vmap(lambda a: hj.wrench(pair, a, pose_b)))(many)
    assert np.array_equal(mapped, expected)
    assert calls == {"values": 1, "values_and_jacobians": 0, "pullbacks": 0}
    assert np.array_equal(hj.wrench(pair, many.reshape(2, 3, 4, 4), pose_b), expected.reshape(2, 3, 12))
    twice = jax.vmap(jax.vmap(lambda a: hj.wrench(pair, a, pose_b)))(many.reshape(2, 3, 4, 4))
    assert np.array_equal(twice, expected.reshape(2, 3, 12))
    slopes = jax.vmap(jax.jacrev(lambda a: hj.wrench(pair, a, pose_b)))(many)
    alone = jax.jacfwd(lambda a: hj.wrench(pair, a, pose_b))(many[4])
    assert np.allclose(slopes[4], alone, rtol=0, atol=1e-12 * np.abs(alone).max())


def counted(monkeypatch, function):
    """Counts the calls of the methods of a function."""
    calls = {"values": 0, "values_and_jacobians": 0, "pullbacks": 0}
    for name in calls:
        inner = getattr(function, name)

        def outer(self, *rows, name=name, inner=inner):
            calls[name] += 1
            return inner(self, *rows)

        monkeypatch.setattr(function, name, outer)
    return calls


@pytest.mark.parametrize("jit", [jax.jit, lambda function: function])
def test_no_needless_calls(ball_on_block, start, monkeypatch, jit):
    wrench = at_rest(ball_on_block[0])
    at = start[REST]

    def loss(numbers):
        return jnp.sum(wrench(numbers) ** 2)

    calls = counted(monkeypatch, _autodiff.Wrench)

    def calls_of(function, *arguments):
        calls.update(values=0, values_and_jacobians=0)
        jax.block_until_ready(function(*arguments))
        return calls["values"], calls["values_and_jacobians"]

    assert calls_of(jit(loss), at) == (1, 0)
    assert calls_of(jit(jax.value_and_grad(loss)), at) == (0, 1)
    assert calls_of(jit(jax.jacfwd(wrench)), at) == (0, 1)
    assert calls_of(jit(jax.jacrev(wrench)), at) == (0, 1)
    assert calls_of(jit(lambda x: jax.jvp(loss, (x,), (x,))), at) == (0, 1)
    # Arguments that are not differentiated need no derivative.
    assert calls_of(jit(jax.grad(lambda x: jnp.sum(x**2) * loss(at))), at) == (1, 0)


def test_a_cotangent_of_a_pose_is_that_of_its_twist(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    weights = np.linspace(-1.0, 1.0, 12)
    _, jacobian = pair.wrench_and_jacobian(pose_a, pose_b)
    by_twist = weights @ jacobian
    actual = jax.grad(lambda a: weights @ hj.wrench(pair, a, pose_b))(pose_a)
    x, y, z = by_twist[:3]
    expected = np.zeros((4, 4))
    expected[:3, :3] = 0.5 * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ pose_a[:3, :3]
    expected[:3, 3] = by_twist[3:6]
    assert np.allclose(actual, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    by_moved = jax.grad(lambda t: weights @ hj.wrench(pair, hj.moved_pose(pose_a, t), pose_b))(np.zeros(6))
    assert np.allclose(by_moved, by_twist[:6], rtol=0, atol=1e-12 * np.abs(by_twist[:6]).max())


def test_second_derivatives_are_refused(ball_on_block, start, bounce):
    wrench = at_rest(ball_on_block[0])
    at = start[REST]

    def loss(numbers):
        return jnp.sum(wrench(numbers) ** 2)

    for function in (
        jax.hessian(loss),
        jax.jit(jax.jacrev(jax.grad(loss))),
        lambda x: jax.jvp(jax.grad(loss), (x,), (x,)),
        jax.grad(lambda x: jax.jvp(wrench, (x,), (jnp.ones(14),))[1].sum()),
        lambda x: jax.jit(jax.vmap(jax.hessian(loss)))(np.stack([x, x])),
    ):
        with pytest.raises(NotImplementedError, match="wrench of hydroelastic has first derivatives only"):
            function(at)
    world, plan = bounce
    velocity = [he.Parameter.initial_velocity("ball")]
    with pytest.raises(NotImplementedError, match="rollout of hydroelastic has first derivatives only"):
        jax.hessian(lambda change: jnp.sum(hj.final_state(world, plan, velocity, change).poses ** 2))(np.zeros(3))
    # Functions that do not call the library have second derivatives.
    assert jax.hessian(lambda x: x**2 * loss(at))(2.0) == pytest.approx(2 * loss(at))


def test_transformations_go_together(ball_on_block, start):
    wrench = at_rest(ball_on_block[0])
    at = start[REST]

    @jax.jit
    def loss(numbers):
        return jnp.sum(wrench(numbers) ** 2)

    expected = jax.grad(loss)(at)
    scale = np.abs(expected).max()
    moved = jax.lax.scan(lambda x, _: (x - 1e-9 * jax.grad(loss)(x), None), at, None, 1)[0]
    for actual in (
        jax.grad(jax.checkpoint(loss))(at),
        jax.jit(jax.grad(jax.checkpoint(loss)))(at),
        jax.grad(lambda x: jax.lax.cond(x[0] > 0, loss, jnp.sum, x))(at),
        jax.grad(lambda x: jax.lax.map(loss, jnp.stack([x, 2 * x]))[0])(at),
        jax.linear_transpose(jax.linearize(loss, at)[1], at)(1.0)[0],
        jax.vmap(jax.grad(loss))(np.stack([at, at]))[1],
        (at - moved) / 1e-9,
    ):
        assert np.allclose(actual, expected, rtol=0, atol=1e-6 * scale)


def test_rows_that_are_refused_are_nan_with_a_reason(ball_on_block, caplog, monkeypatch):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([pose_a, pose_a, pose_a])
    many[1, 0, 0] = 2.0
    expected = pair.wrench(pose_a, pose_b)
    with pytest.raises(he.HydroelasticError, match="row 1 of 3"):
        hj.wrench(pair, many, pose_b)
    with pytest.raises(he.HydroelasticError):
        hj.wrench(pair, many[1], pose_b)

    def wrench(pose):
        return hj.wrench(pair, pose, pose_b)

    for function in (jax.jit(wrench), jax.jit(jax.vmap(wrench)), jax.vmap(wrench)):
        caplog.clear()
        actual = np.asarray(function(many))
        assert np.isnan(actual[1]).all()
        assert np.array_equal(actual[0], expected) and np.array_equal(actual[2], expected)
        (record,) = caplog.records
        assert (record.name, record.levelno) == ("hydroelastic.jax", logging.WARNING)
        assert "NaN in 1 of 3 rows: row 1 of 3" in record.getMessage()
    slopes = jax.jit(jax.vmap(jax.jacrev(wrench)))(many)
    # The last row of a pose has no effect, so its derivative is zero, or NaN for an invalid row.
    assert np.isnan(slopes[1][:, :3]).all() and np.isfinite(slopes[0]).all() and np.isfinite(slopes[2]).all()

    def broken(self, rows):
        raise RuntimeError("out of order")

    monkeypatch.setattr(_autodiff.Wrench, "values", broken)
    caplog.clear()
    assert np.isnan(jax.jit(wrench)(pose_a)).all()
    assert "out of order" in caplog.text


def test_what_is_not_of_float64_is_refused(ball_on_block, monkeypatch):
    pair, pose_a, pose_b = ball_on_block
    with pytest.raises(TypeError, match="pose_a must be an array of float64, but is one of float32"):
        hj.wrench(pair, pose_a.astype(np.float32), pose_b)
    with pytest.raises(TypeError, match="moduli must be an array of float64"):
        hj.wrench(pair, pose_a, pose_b, moduli=np.array([1, 2], dtype=np.float32))
    with enable_x64(False):
        for call in (
            lambda: hj.wrench(pair, pose_a, pose_b),
            lambda: hj.pose([0.0, 0.0, 0.0]),
            lambda: jax.grad(lambda x: hj.wrench(pair, x, pose_b).sum())(pose_a),
        ):
            with pytest.raises(TypeError, match="jax_enable_x64"):
                call()
    jax.config.update("jax_enable_x64", False)
    monkeypatch.setattr(hj, "_buffer_callback", None)
    with enable_x64(True), pytest.raises(TypeError, match="a context is of one thread"):
        jax.jit(lambda x: hj.wrench(pair, x, pose_b))(pose_a)


def test_without_callbacks_on_buffers_the_bits_are_the_same(ball_on_block, twists, monkeypatch):
    pair, pose_a, pose_b = ball_on_block

    def actual():
        function = jax.vmap(jax.jacobian(lambda a, t: hj.wrench(pair, a, pose_b, t), (0, 1)))
        return jax.tree.leaves(jax.jit(function)(np.stack([pose_a, pose_b]), np.stack(twists)))

    assert hj._buffer_callback is not None
    expected = actual()
    monkeypatch.setattr(hj, "_buffer_callback", None)
    for with_buffers, without in zip(expected, actual(), strict=True):
        assert np.array_equal(with_buffers, without)


def test_wrong_shapes_and_arguments_are_refused(ball_on_block, bounce):
    pair, pose_a, pose_b = ball_on_block
    world, plan = bounce
    with pytest.raises(he.HydroelasticError, match=r"pose_b must have the shape \(4, 4\)"):
        hj.wrench(pair, pose_a, pose_b[:3])
    with pytest.raises(he.HydroelasticError, match="law"):
        hj.wrench(pair, pose_a, pose_b, law=[0.1])
    with pytest.raises(he.HydroelasticError, match=r"changes must have the shape \(1,\)"):
        hj.rollout(world, plan, [he.Parameter.friction("ball")], np.zeros(2))
    with pytest.raises(he.HydroelasticError, match="nobody"):
        hj.rollout(world, plan, [he.Parameter.friction("nobody")])
    with pytest.raises(he.HydroelasticError, match="start_step needs start"):
        hj.rollout(world, plan, start_step=3)
    with pytest.raises(TypeError, match="start_step must be an integer"):
        hj.step(world, plan, hj.initial_state(world), start_step=0.5)
    with pytest.raises(he.HydroelasticError, match="poses must have the shape"):
        hj.step(world, plan, hj.State(np.eye(4)[None], np.zeros((1, 6))))
    with pytest.raises(he.HydroelasticError, match="leading axes of the arguments must be broadcastable"):
        hj.wrench(pair, np.stack([pose_a] * 2), np.stack([pose_b] * 3))
    for bad in ("a", None, [[1.0], [1.0, 2.0]], np.eye(4).astype(str)):
        with pytest.raises(TypeError, match="pose_a must be an array or a list of numbers"):
            hj.wrench(pair, bad, pose_b)
    for call, match in [
        (lambda: hj.wrench(world, pose_a, pose_b), "pair must be a Pair, but is World"),
        (lambda: hj.tactile_image(pair, pair, pose_a, pose_b), "grid must be a TaxelGrid"),
        (lambda: hj.rollout(pair, plan), "world must be a World"),
        (lambda: hj.initial_state(pair), "world must be a World"),
        (lambda: hj.final_state(world, 10), "plan must be a Plan"),
        (lambda: hj.step(world, 10, hj.initial_state(world)), "plan must be a Plan"),
        (lambda: hj.step(world, plan, world.initial_state), "the initial state must be a State of hydroelastic.jax or"),
        (lambda: hj.rollout(world, plan, he.Parameter.gravity()), "a single Parameter: put it into a list"),
    ]:
        with pytest.raises(TypeError, match=match):
            call()


def test_empty_batches_have_empty_results(ball_on_block):
    pair, _, pose_b = ball_on_block
    assert hj.wrench(pair, np.zeros((0, 4, 4)), pose_b).shape == (0, 12)
    assert hj.clearance(pair, np.zeros((0, 4, 4)), pose_b).shape == (0,)


def test_poses_are_those_of_the_library():
    for vector in ([0.0, 0.0, 0.0], [1e-5, 0.0, 0.0], [0.1, 0.2, 0.21], [0.1, 0.2, 0.23], [1.0, -2.0, 0.5]):
        turned = hj.pose([1.0, 2.0, 3.0], vector)
        assert np.allclose(turned, he.pose([1.0, 2.0, 3.0], vector), rtol=0, atol=ROTATION)
        twist = np.array([*vector, 0.1, 0.2, 0.3])
        assert np.allclose(
            hj.moved_pose(turned, twist), he.moved_pose(np.asarray(turned), twist), rtol=0, atol=ROTATION
        )
    many = hj.pose(np.zeros(3), np.zeros((5, 3)))
    assert many.shape == (5, 4, 4)


def test_poses_have_derivatives_at_zero_and_where_the_series_ends():
    def turned(vector):
        return hj.pose(np.zeros(3), vector)[:3, :3]

    second = jax.jit(jax.jacfwd(jax.jacrev(turned)))
    generators = -np.array(
        [[[0, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 0, -1], [0, 0, 0], [1, 0, 0]], [[0, 1, 0], [-1, 0, 0], [0, 0, 0]]]
    )
    products = np.einsum("aij,bjk->ikab", generators, generators)
    assert np.allclose(jax.jacfwd(turned)(np.zeros(3)), np.moveaxis(generators, 0, -1), rtol=0, atol=ROTATION)
    assert np.allclose(second(np.zeros(3)), 0.5 * (products + products.swapaxes(-1, -2)), rtol=0, atol=ROTATION)
    end = np.sqrt(0.1) * np.array([0.6, 0.0, 0.8])
    assert np.allclose(second((1 - 1e-13) * end), second((1 + 1e-13) * end), rtol=0, atol=1e-11)


def flat(state):
    return jnp.concatenate([state.poses.ravel(), state.twists.ravel()])


def without_friction(world):
    bodies = world.bodies
    smooth = [he.Parameter.friction(body.name) for body in bodies]
    return world.perturbed(smooth, np.array([-body.material.friction for body in bodies]))


@pytest.mark.parametrize("friction, tolerance", [(False, ROLLOUT), (True, FRICTION)])
def test_rollout_has_the_derivatives_of_differences(bounce, friction, tolerance):
    world, plan = bounce
    world = world if friction else without_friction(world)
    # The unit of the modulus is 1e5 Pa.
    by = [he.Parameter.initial_position("ball"), he.Parameter.initial_velocity("ball"), he.Parameter.modulus("ball")]
    by += [he.Parameter.dissipation("floor"), he.Parameter.mass("ball"), he.Parameter.gravity()]
    by += [he.Parameter.friction("floor")] if friction else []
    units = np.array([1.0] * 6 + [1e5] + [1.0] * 5 + [1.0] * friction)

    def run(numbers):
        return flat(hj.rollout(world, plan, by, units * numbers))

    zero = np.zeros(len(units))
    forward = np.asarray(jax.jit(jax.jacfwd(run))(zero))
    assert deviation(np.asarray(jax.jacrev(run)(zero)), forward) < 1e-12
    actual = differences(jax.jit(run), zero, 2e-6)
    assert deviation(actual, forward) < tolerance
    check_grads(jax.jit(run), (zero,), **CHECK)


def ground():
    """A ball that bounces off a half-space with friction, parameters, and their units: 1e5 Pa for the modulus."""
    skin = he.Material(1e5, 0.2, 0.4)
    start = he.pose([0.01, 0.02, 0.13], [0.1, 0.2, 0.3])
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=start, velocity=[0.5, 0.1, 0.0])
    floor = he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid(0.4))
    by = [he.Parameter.initial_position("ball"), he.Parameter.initial_velocity("ball"), he.Parameter.modulus("ball")]
    by += [he.Parameter.friction("ground"), he.Parameter.mass("ball"), he.Parameter.gravity()]
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
    return world, he.Plan(5e-4, 300, record_every=100), by, np.array([1.0] * 6 + [1e5] + [1.0] * 5)


def test_rollout_on_a_half_space_has_the_derivatives_of_differences():
    world, plan, by, units = ground()

    def run(numbers):
        return flat(hj.rollout(world, plan, by, units * numbers))

    zero = np.zeros(len(units))
    forward = np.asarray(jax.jit(jax.jacfwd(run))(zero))
    assert deviation(np.asarray(jax.jacrev(run)(zero)), forward) < 1e-12
    assert deviation(differences(jax.jit(run), zero, 2e-6), forward) < FRICTION
    check_grads(jax.jit(run), (zero,), **CHECK)


def test_nested_values_have_the_derivatives_of_changes():
    world, plan, _, _ = ground()
    values = {
        "ball": {"friction": 0.5, "mass": jnp.asarray(1.1), "modulus": 1.2e5, "velocity": jnp.array([0.4, 0.2, -0.1])},
        "gravity": jnp.array([0.0, 0.1, -9.0]),
    }
    by = [he.Parameter.friction("ball"), he.Parameter.mass("ball"), he.Parameter.modulus("ball")]
    by += [he.Parameter.initial_velocity("ball"), he.Parameter.gravity()]

    def loss(state):
        return state.poses[-1, 0, 0, 3] + 2.0 * state.twists[-1, 0, 5]

    def of_values(values):
        return loss(hj.rollout(world, plan, values))

    flat_values = np.array([0.5, 1.1, 1.2e5, 0.4, 0.2, -0.1, 0.0, 0.1, -9.0])
    changes = flat_values - world.values(by)
    expected = jax.jacfwd(lambda changes: loss(hj.rollout(world, plan, by, changes)))(changes)
    found = jax.jit(jax.grad(of_values))(jax.tree.map(jnp.asarray, values))
    ball = found["ball"]
    parts = [ball["friction"], ball["mass"], ball["modulus"], *ball["velocity"], *found["gravity"]]
    assert np.abs(np.array(parts) / expected - 1.0).max() < 1e-9
    assert float(of_values(values)) == pytest.approx(float(loss(hj.rollout(world, plan, by, changes))), rel=1e-12)
    mapped = jax.vmap(lambda friction: of_values({"ball": {"friction": friction}}))(jnp.array([0.1, 0.4]))
    assert float(mapped[1]) == pytest.approx(float(of_values({"ball": {"friction": 0.4}})), rel=1e-12)


def test_nested_values_that_do_not_fit_are_refused():
    world, plan, _, _ = ground()
    with pytest.raises(he.HydroelasticError, match="body 'ball' has no quantity 'weight': expected one of position"):
        hj.rollout(world, plan, {"ball": {"weight": 1.0}})
    with pytest.raises(he.HydroelasticError, match='no body is named "wall"'):
        hj.rollout(world, plan, {"wall": {"mass": 1.0}})
    with pytest.raises(he.HydroelasticError, match="stiffness"):
        hj.rollout(world, plan, {"stiffness": 1.0})
    with pytest.raises(he.HydroelasticError, match="need no changes"):
        hj.rollout(world, plan, {"gravity": np.zeros(3)}, np.zeros(3))
    assert hj.rollout(world, plan, {}).poses.shape == (4, 2, 4, 4)


def test_rollout_by_its_start_has_the_derivatives_of_differences(bounce):
    world, plan = bounce
    world = without_friction(world)
    state = hj.initial_state(world)

    def run(numbers):
        poses = jnp.stack([hj.moved_pose(state.poses[0], numbers[:6]), state.poses[1]])
        twists = state.twists.at[0].add(numbers[6:12])
        start = hj.State(poses, twists)
        return flat(hj.rollout(world, plan, [he.Parameter.modulus("ball")], 1e5 * numbers[12:], start=start))

    zero = np.zeros(13)
    forward = np.asarray(jax.jacfwd(run)(zero))
    assert deviation(np.asarray(jax.jit(jax.jacrev(run))(zero)), forward) < 1e-12
    assert deviation(differences(jax.jit(run), zero, 2e-6), forward) < ROLLOUT
    check_grads(jax.jit(run), (zero,), **CHECK)


def by_many(driven):
    """A rollout that depends on 13 numbers and on its start, so that reverse mode is used."""
    plan = he.Plan(5e-4, 300, record_every=150)
    by = [he.Parameter.friction("ball"), he.Parameter.mass("brick"), *he.Parameter.controls(["ball"], 2)]
    state = hj.initial_state(driven)

    def run(numbers, twists=state.twists):
        return flat(hj.rollout(driven, plan, by, numbers, start=hj.State(state.poses, twists)))

    def of_world(numbers):
        return flat(hj.rollout(driven, plan, by, numbers))

    return run, of_world, np.zeros(14)


def test_gradients_by_many_numbers_are_swept_back(driven, monkeypatch):
    run, of_world, at = by_many(driven)
    factors = np.random.default_rng(1).uniform(-1.0, 1.0, run(at).shape)
    twists = np.asarray(driven.initial_state.twists)
    by_numbers, by_twists = jax.jacfwd(run, (0, 1))(at, twists)
    calls = counted(monkeypatch, _autodiff.Rollout)
    for jit in (jax.jit, lambda function: function):
        calls.update(values=0, values_and_jacobians=0, pullbacks=0)
        value, actual = jit(jax.value_and_grad(lambda *x: factors @ run(*x), (0, 1)))(at, twists)
        assert calls == {"values": 1, "values_and_jacobians": 0, "pullbacks": 1}
        assert np.isclose(value, factors @ run(at), rtol=1e-12)
        for one, jacobian in zip(actual, (by_numbers, by_twists)):
            expected = np.tensordot(factors, jacobian, 1)
            assert np.abs(one - expected).max() <= 1e-10 * np.abs(expected).max()
    assert np.abs(jax.grad(lambda x: factors @ of_world(x))(at) - factors @ by_numbers).max() <= 1e-10 * np.abs(factors @ by_numbers).max()
    with pytest.raises(NotImplementedError, match="first derivatives only"):
        jax.hessian(lambda x: factors @ run(x))(at)
    with pytest.raises(NotImplementedError, match="first derivatives only"):
        jax.grad(lambda x: jnp.sum(jax.grad(lambda x: factors @ run(x))(x)))(at)


def test_jacobians_of_many_outputs_are_found_forwards(driven, monkeypatch):
    run, _, at = by_many(driven)
    calls = counted(monkeypatch, _autodiff.Rollout)
    forward = np.asarray(jax.jit(jax.jacfwd(run))(at))
    # One Jacobian has all columns and all rows.
    assert calls["values_and_jacobians"] == 1
    reverse = np.asarray(jax.jit(jax.jacrev(run))(at))
    assert calls["values_and_jacobians"] == 2
    assert deviation(reverse, forward) < 1e-12
    few = np.asarray(jax.jacrev(lambda x: run(x)[-2:])(at))
    assert calls["values_and_jacobians"] == 2
    assert np.abs(few - forward[-2:]).max() <= 1e-10 * np.abs(forward[-2:]).max()


def test_swept_gradients_pass_through_transformations(driven):
    run, _, at = by_many(driven)
    factors = np.random.default_rng(1).uniform(-1.0, 1.0, run(at).shape)

    def loss(numbers):
        return factors @ run(numbers)

    expected = np.asarray(jax.grad(loss)(at))
    near = 1e-10 * np.abs(expected).max()
    many = np.stack([at, at + 0.01])
    assert np.abs(jax.vmap(jax.grad(loss))(many)[1] - jax.grad(loss)(many[1])).max() <= near
    for actual in (
        jax.grad(jax.checkpoint(loss))(at),
        jax.jit(jax.grad(jax.checkpoint(loss)))(at),
        jax.grad(lambda x: jax.lax.cond(x[0] > -1, loss, jnp.sum, x))(at),
        jax.grad(lambda x: jax.lax.map(loss, jnp.stack([x, x + 0.01]))[0])(at),
        jax.linear_transpose(jax.linearize(loss, at)[1], at)(1.0)[0],
        jax.jit(jax.vmap(jax.grad(loss)))(many)[0],
        # Many losses of one rollout, and one loss for each of many rollouts.
        jax.vmap(jax.vmap(lambda x, y: jax.vjp(run, x)[1](y)[0], (None, 0)), (0, None))(many, np.stack([factors] * 2))[0, 1],
    ):
        assert np.abs(actual - expected).max() <= near
    check_grads(jax.jit(loss), (at,), **CHECK | {"atol": 1e-4, "rtol": 1e-4})


def test_swept_rows_that_are_refused_are_nan_with_a_reason(driven, caplog):
    plan = he.Plan(5e-4, 20)
    by = [*he.Parameter.controls(["ball"], 3), he.Parameter.mass("ball")]
    changes = np.zeros((2, 19))
    # A negative mass is invalid.
    changes[1, -1] = -2.0

    def end(change):
        return jnp.sum(hj.final_state(driven, plan, by, change).poses)

    slopes = jax.jit(jax.vmap(jax.grad(end)))(changes)
    assert np.isfinite(slopes[0]).all() and np.isnan(slopes[1]).all()
    assert [record.getMessage()[:29] for record in caplog.records] == ["rollout: NaN in 1 of 2 rows: "]
    assert np.isnan(jax.jit(jax.grad(end))(changes[1])).all()
    assert not any(record.exc_info for record in caplog.records)


def test_rollouts_have_the_bits_of_the_library(bounce):
    world, plan = bounce
    by = [he.Parameter.initial_velocity("ball")]
    changes = np.array([[0.0, 0.0, 0.0], [0.1, -0.2, 0.3], [1.0, 0.0, 0.0]])
    expected = he.Batch(plan).rollouts_perturbed(world, by, changes)
    actual = jax.jit(jax.vmap(lambda change: hj.rollout(world, plan, by, change)))(changes)
    last = hj.final_state(world, plan, by, changes)
    assert actual.poses.shape == (3, 4, 2, 4, 4) and last.twists.shape == (3, 2, 6)
    for i, trajectory in enumerate(expected):
        assert np.array_equal(actual.poses[i], trajectory.poses)
        assert np.array_equal(actual.twists[i], trajectory.twists)
        assert np.array_equal(last.poses[i], trajectory.poses[-1])
    many = hj.rollout(world, he.Plan(5e-4, 7, record_every=3))
    assert many.poses.shape == (4, 2, 4, 4)


def test_batches_of_rollouts_have_the_derivatives_of_single_ones(bounce):
    world, plan = bounce
    by = [he.Parameter.initial_velocity("ball")]
    changes = np.array([[0.0, 0.0, 0.0], [0.1, -0.2, 0.3], [1.0, 0.0, 0.0]])

    def end(change):
        return hj.final_state(world, plan, by, change).poses[0, :3, 3]

    assert np.array_equal(jax.vmap(jax.jacrev(end))(changes), np.stack([jax.jacrev(end)(change) for change in changes]))


def test_steps_by_scan_are_a_rollout(driven):
    """With controls and forces, the chain rule over 20 steps gives the derivative of the rollout."""
    # A single step does not have the substeps of the step before, so error control would divide it differently.
    undivided = he.Accuracy(1e9, 1e9)
    plan = he.Plan(5e-3, 20, he.Integrator.SDIRK3, record_every=20, accuracy=undivided)
    by = [he.Parameter.friction("ball"), he.Parameter.control("ball", 1)]
    state = hj.initial_state(driven)

    def stepped(start, changes):
        def step(state, start_step):
            return hj.step(driven, plan, state, by, changes, start_step=start_step), None

        return flat(jax.lax.scan(step, start, jnp.arange(20))[0])

    def rolled(start, changes):
        return flat(hj.final_state(driven, plan, by, changes, start=start))

    changes = np.zeros(7)
    assert np.allclose(stepped(state, changes), rolled(state, changes), rtol=0, atol=1e-12)
    for which in range(2):
        actual, expected = (jax.jit(jax.jacrev(end, which))(state, changes) for end in (stepped, rolled))
        for one, other in zip(jax.tree.leaves(actual), jax.tree.leaves(expected)):
            assert np.abs(other).max() > 1e-3
            assert np.allclose(one, other, rtol=0, atol=1e-9 * np.abs(other).max())


def test_the_last_control_acts_after_its_time(driven):
    plan = he.Plan(5e-3, 1)
    state = hj.initial_state(driven)

    def by_interval(interval, start_step):
        by = [he.Parameter.control("ball", interval)]
        return jax.jacfwd(lambda x: hj.step(driven, plan, state, by, x, start_step=start_step).twists[0])(np.zeros(6))

    assert np.abs(by_interval(1, 15)).max() > 1e-3
    assert np.abs(by_interval(1, 5)).max() == 0.0
    many = hj.step(driven, plan, state, start_step=np.array([5, 15]))
    assert not np.array_equal(many.twists[0], many.twists[1])


def test_a_fixed_body_ignores_its_state(bounce):
    world, plan = bounce
    state = hj.initial_state(world)
    moved = hj.State(state.poses.at[1, 2, 3].add(-0.1), state.twists)
    assert np.array_equal(hj.step(world, plan, moved).poses, hj.step(world, plan, state).poses)
    slopes = jax.jacrev(lambda poses: hj.final_state(world, plan, start=hj.State(poses, state.twists)).poses)(
        state.poses
    )
    assert np.abs(slopes[..., 1, :, :]).max() == 0.0
    assert np.abs(slopes[..., 0, :, :]).max() > 0.5


def test_rollouts_that_end_early_are_nan(bounce, caplog):
    world, _ = bounce
    # The stability check ends this rollout in contact.
    plan = he.Plan(4e-2, 20)
    by = [he.Parameter.initial_velocity("ball")]
    changes = np.array([[0.0, 0.0, 20.0], [0.0, 0.0, 0.0]])
    with pytest.raises(he.RolloutError, match="row 1 of 2"):
        hj.rollout(world, plan, by, changes)

    def end(change):
        return hj.final_state(world, plan, by, change).poses[0, :3, 3]

    actual, slopes = jax.jit(jax.vmap(end))(changes), jax.jit(jax.vmap(jax.jacrev(end)))(changes)
    assert np.isfinite(actual[0]).all() and np.isnan(actual[1]).all()
    assert np.isfinite(slopes[0]).all() and np.isnan(slopes[1]).all()
    assert "1 of 2 rows" in caplog.text


def test_value_of_a_rollout_takes_no_derivatives(bounce, monkeypatch):
    world, plan = bounce
    by = [he.Parameter.initial_velocity("ball")]

    def loss(change):
        return jnp.sum(hj.final_state(world, plan, by, change).poses ** 2)

    calls = counted(monkeypatch, _autodiff.Rollout)
    jax.block_until_ready(jax.jit(loss)(np.zeros(3)))
    assert calls == {"values": 1, "values_and_jacobians": 0, "pullbacks": 0}
    jax.block_until_ready(jax.jit(jax.value_and_grad(loss))(np.zeros(3)))
    assert calls == {"values": 1, "values_and_jacobians": 1, "pullbacks": 0}


def test_without_jax_it_is_said_what_to_install():
    code = "import sys; sys.modules['jax'] = None; import hydroelastic.jax"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert 'ImportError: hydroelastic.jax needs JAX: pip install "hydroelastic[jax]"' in done.stderr


def test_the_program_of_the_docstring_runs():
    program = "\n".join(line[4:] for line in hj.__doc__.splitlines() if line.startswith("    "))
    namespace = {}
    exec(program, namespace)
    wrench, jacobian = namespace["pair"].wrench_and_jacobian(he.pose([0.0, 0.0, 0.195]), he.pose())
    assert (namespace["force"], namespace["slope"]) == pytest.approx((wrench[5], jacobian[5, 5]), rel=1e-12)
