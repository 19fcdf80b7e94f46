"""Wrenches, steps and rollouts in PyTorch: derivatives in both modes, batches and errors."""

import importlib
import subprocess
import sys

import numpy as np
import pytest

import hydroelastic as he
from hydroelastic import _autodiff

torch = pytest.importorskip("torch")
ht = importlib.import_module("hydroelastic.torch")
forward_ad = torch.autograd.forward_ad

pytestmark = pytest.mark.torch

# Round-off of fourth-order differences of wrenches, with no facet that begins or ends contact.
WRENCH = 1e-9
# Error of differences of rollouts through a bounce. The second derivatives jump as facets begin and end contact.
ROLLOUT = 1e-7
# Error with friction, whose law is curved within the slip tolerance.
FRICTION = 1e-6
# Round-off of the entries of a rotation, computed in another order.
ROTATION = 1e-15
# gradcheck uses second-order differences.
CHECK = {"eps": 1e-6, "atol": 1e-5, "rtol": 1e-5, "check_forward_ad": True}

# Kind of each number: rotation, translation, angular velocity, velocity, modulus, dissipation or friction. Rotations of
# a ball about its center have almost no effect, so each kind has one scale.
KINDS = np.repeat([0, 1, 0, 1, 2, 3, 2, 3, 4, 5, 6], [3, 3, 3, 3, 3, 3, 3, 3, 2, 1, 1])
# Numbers of a contact at rest.
REST = [*range(12), 24, 25]
STEPS = np.repeat([1e-5, 1e-4, 1e-3], [12, 12, 4])


@pytest.fixture(scope="module")
def start():
    """Rotation vectors and positions of A and B, twists of A and B, moduli in units of 1e5 Pa, and the law."""
    poses = [0.3, -0.2, 0.5, 0.013, 0.021, 0.1921, 0.02, -0.03, 0.01, 0.0, 0.0, 0.0]
    twists = [0.1, 0.2, -0.3, 0.5, 0.1, -0.05, 0.0, 0.0, 0.1, 0.0, -0.1, 0.0]
    return np.array(poses + twists + [1.0, 10.0, 0.2, 0.4])


def variable(numbers):
    return torch.tensor(numbers, dtype=torch.float64, requires_grad=True)


def poses(numbers):
    return ht.pose(numbers[..., 3:6], numbers[..., :3]), ht.pose(numbers[..., 9:12], numbers[..., 6:9])


def at_rest(pair):
    """Returns the wrenches at rest, in units of 10 N and 10 N m, as a function of 14 numbers."""
    return lambda numbers: ht.wrench(pair, *poses(numbers), moduli=1e5 * numbers[..., 12:]) / 10


def in_motion(pair):
    """Returns the wrenches in motion as a function of 28 numbers."""

    def wrench(numbers):
        moduli, law = 1e5 * numbers[..., 24:26], numbers[..., 26:]
        return ht.wrench(pair, *poses(numbers), numbers[..., 12:18], numbers[..., 18:24], moduli=moduli, law=law) / 10

    return wrench


def differences(function, at, steps):
    """Computes the Jacobian by central differences of fourth order."""
    columns = []
    for column, step in enumerate(np.broadcast_to(steps, at.shape)):
        unit = step * np.eye(len(at))[column]
        near, far = (
            function(torch.from_numpy(at + k * unit)).numpy() - function(torch.from_numpy(at - k * unit)).numpy()
            for k in (1, 2)
        )
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, -1)


def deviation(actual, expected, kinds=None):
    """Returns the largest deviation, relative to the largest entry of a column or of all columns of its kind."""
    kinds = np.arange(expected.shape[1]) if kinds is None else kinds
    largest = np.abs(expected).max(0)
    scale = np.array([largest[kinds == kind].max() for kind in kinds])
    return (np.abs(actual - expected).max(0) / scale).max()


def jacobians(function, at):
    """Computes the Jacobian in forward and in reverse mode."""
    at = torch.from_numpy(at)
    return torch.func.jacfwd(function)(at).numpy(), torch.func.jacrev(function)(at).numpy()


@pytest.mark.parametrize("kind, columns", [(at_rest, REST), (in_motion, range(28))])
def test_wrench_has_the_derivatives_of_differences(ball_on_block, start, kind, columns):
    wrench, at, columns = kind(ball_on_block[0]), start[list(columns)], list(columns)
    forward, reverse = jacobians(wrench, at)
    assert deviation(reverse, forward) < 1e-12
    assert deviation(differences(wrench, at, STEPS[columns]), forward, KINDS[columns]) < WRENCH
    assert torch.autograd.gradcheck(wrench, variable(at), check_batched_grad=True, **CHECK)


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
    forward, reverse = jacobians(wrench, at)
    assert deviation(reverse, forward, KINDS[columns]) < 1e-12
    assert forward[:, columns.index(25)].any() == (modulus is not None)
    assert deviation(differences(wrench, at, STEPS[columns]), forward, KINDS[columns]) < WRENCH
    assert torch.autograd.gradcheck(wrench, variable(at), **CHECK)


def test_the_modulus_that_a_rigid_partner_has_not_need_not_be_given():
    pair = he.Pair(he.Shape.icosphere(0.1, 2), he.HalfSpace(), 1e5)
    height = variable(0.095)
    ht.wrench(pair, ht.pose(torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64) * height), ht.pose())[5].backward()
    assert height.grad == pair.wrench_and_jacobian(he.pose([0.0, 0.0, 0.095]), he.pose())[1][5, 5] < 0.0


def test_wrench_has_the_bits_of_the_library(ball_on_block, twists):
    pair, pose_a, pose_b = ball_on_block
    assert np.array_equal(ht.wrench(pair, pose_a, pose_b), pair.wrench(pose_a, pose_b))
    expected = pair.wrench(pose_a, pose_b, *twists, moduli=[2e5, 1e6], law=[0.1, 0.3])
    actual = ht.wrench(pair, torch.from_numpy(pose_a), pose_b, *twists, moduli=[2e5, 1e6], law=[0.1, 0.3])
    assert np.array_equal(actual, expected)
    assert np.array_equal(ht.wrench(pair, pose_a, pose_b, twists[0]), pair.wrench(pose_a, pose_b, twists[0]))


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


def test_a_batch_is_one_call_with_the_same_bits(ball_on_block, monkeypatch):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-4 * k]) for k in range(6)])
    expected = pair.wrench(many, pose_b)
    calls = counted(monkeypatch, _autodiff.Wrench)
    assert np.array_equal(ht.wrench(pair, many.reshape(2, 3, 4, 4), pose_b), expected.reshape(2, 3, 12))
    assert calls == {"values": 1, "values_and_jacobians": 0, "pullbacks": 0}

    def wrench(pose):
        return ht.wrench(pair, pose, pose_b)

    tensors = torch.from_numpy(many)
    for axis in (0, 2):
        moved = tensors.movedim(0, axis)
        assert np.array_equal(torch.func.vmap(wrench, in_dims=axis)(moved), expected)
    assert calls == {"values": 3, "values_and_jacobians": 0, "pullbacks": 0}
    alone = torch.func.jacfwd(wrench)(tensors[4]).numpy()
    calls.update(values=0, values_and_jacobians=0)
    slopes = torch.func.vmap(torch.func.jacrev(wrench))(tensors).numpy()
    assert calls == {"values": 0, "values_and_jacobians": 1, "pullbacks": 0}
    assert np.allclose(slopes[4], alone, rtol=0, atol=1e-12 * np.abs(alone).max())
    swapped = torch.func.jacrev(torch.func.vmap(wrench))(tensors).numpy()
    assert np.allclose(swapped[4, :, 4], alone, rtol=0, atol=1e-12 * np.abs(alone).max())


def test_no_needless_calls(ball_on_block, start, monkeypatch):
    wrench, at = at_rest(ball_on_block[0]), start[REST]
    calls = counted(monkeypatch, _autodiff.Wrench)

    def calls_of(function):
        calls.update(values=0, values_and_jacobians=0)
        function()
        return calls["values"], calls["values_and_jacobians"]

    def without():
        with torch.no_grad():
            wrench(variable(at))

    def dual():
        with forward_ad.dual_level():
            wrench(forward_ad.make_dual(torch.from_numpy(at), torch.ones(14, dtype=torch.float64)))

    assert calls_of(lambda: wrench(torch.from_numpy(at))) == (1, 0)
    assert calls_of(without) == (1, 0)
    assert calls_of(lambda: wrench(variable(at)).sum().backward()) == (0, 1)
    assert calls_of(dual) == (0, 1)
    assert calls_of(lambda: torch.func.grad(lambda x: wrench(x).sum())(torch.from_numpy(at))) == (0, 1)
    assert calls_of(lambda: torch.func.jvp(wrench, (torch.from_numpy(at),), (torch.from_numpy(at),))) == (0, 1)


def test_a_gradient_of_a_pose_is_that_of_its_twist(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    weights = np.linspace(-1.0, 1.0, 12)
    _, jacobian = pair.wrench_and_jacobian(pose_a, pose_b)
    by_twist = weights @ jacobian
    at = variable(pose_a)
    (torch.from_numpy(weights) @ ht.wrench(pair, at, pose_b)).backward()
    x, y, z = by_twist[:3]
    expected = np.zeros((4, 4))
    expected[:3, :3] = 0.5 * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ pose_a[:3, :3]
    expected[:3, 3] = by_twist[3:6]
    assert np.allclose(at.grad, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    twist = variable(np.zeros(6))
    (torch.from_numpy(weights) @ ht.wrench(pair, ht.moved_pose(pose_a, twist), pose_b)).backward()
    assert np.allclose(twist.grad, by_twist[:6], rtol=0, atol=1e-12 * np.abs(by_twist[:6]).max())


def test_second_derivatives_are_refused(ball_on_block, start, bounce):
    wrench, at = at_rest(ball_on_block[0]), torch.from_numpy(start[REST])

    def loss(numbers):
        return (wrench(numbers) ** 2).sum()

    def twice_backward():
        x = variable(start[REST])
        (slope,) = torch.autograd.grad(loss(x), x, create_graph=True)
        slope.sum().backward()

    def forward_over_reverse():
        with forward_ad.dual_level():
            x = forward_ad.make_dual(variable(start[REST]), torch.ones(14, dtype=torch.float64))
            torch.autograd.grad(loss(x), x)

    def reverse_over_forward():
        x = variable(start[REST])
        with forward_ad.dual_level():
            dual = forward_ad.make_dual(x, torch.ones(14, dtype=torch.float64))
            forward_ad.unpack_dual(loss(dual)).tangent.backward()

    for function in (
        twice_backward,
        forward_over_reverse,
        reverse_over_forward,
        lambda: torch.func.hessian(loss)(at),
        lambda: torch.func.jacrev(torch.func.jacrev(loss))(at),
        lambda: torch.func.jacrev(torch.func.jacfwd(loss))(at),
        lambda: torch.func.jacfwd(torch.func.jacfwd(loss))(at),
        lambda: torch.autograd.functional.hessian(loss, at),
    ):
        with pytest.raises(NotImplementedError, match="wrench of hydroelastic has first derivatives only"):
            function()
    world, plan = bounce
    velocity = [he.Parameter.initial_velocity("ball")]
    with pytest.raises(NotImplementedError, match="rollout of hydroelastic has first derivatives only"):
        torch.func.hessian(lambda x: (ht.final_state(world, plan, velocity, x).poses ** 2).sum())(at[:3])
    # Functions that do not call the library have second derivatives.
    two = torch.tensor(2.0, dtype=torch.float64)
    assert torch.func.hessian(lambda x: x**2 * loss(at))(two).item() == pytest.approx(2 * loss(at).item())


def test_what_is_refused_raises(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    many = np.stack([pose_a, pose_a, pose_a])
    many[1, 0, 0] = 2.0
    with pytest.raises(he.HydroelasticError, match="row 1 of 3"):
        ht.wrench(pair, variable(many), pose_b)
    with pytest.raises(he.HydroelasticError):
        ht.wrench(pair, many[1], pose_b)
    with pytest.raises(TypeError, match="pose_a must be a tensor of float64, but is one of torch.float32"):
        ht.wrench(pair, torch.eye(4), pose_b)
    with pytest.raises(TypeError, match="moduli must be a tensor of float64"):
        ht.wrench(pair, pose_a, pose_b, moduli=np.array([1, 2], dtype=np.float32))
    with pytest.raises(TypeError, match="must be on the CPU"):
        ht.wrench(pair, torch.eye(4, dtype=torch.float64, device="meta"), pose_b)
    with pytest.raises(he.HydroelasticError, match=r"pose_b must have the shape \(4, 4\)"):
        ht.wrench(pair, pose_a, pose_b[:3])
    with pytest.raises(he.HydroelasticError, match="law"):
        ht.wrench(pair, pose_a, pose_b, law=[0.1])


def test_arguments_of_rollouts_that_are_refused(bounce):
    world, plan = bounce
    with pytest.raises(he.HydroelasticError, match=r"changes must have the shape \(1,\)"):
        ht.rollout(world, plan, [he.Parameter.friction("ball")], np.zeros(2))
    with pytest.raises(he.HydroelasticError, match="nobody"):
        ht.rollout(world, plan, [he.Parameter.friction("nobody")])
    with pytest.raises(he.HydroelasticError, match="start_step needs start"):
        ht.rollout(world, plan, start_step=3)
    with pytest.raises(TypeError, match="start_step must be an integer"):
        ht.step(world, plan, ht.initial_state(world), start_step=0.5)
    # The stability check ends this rollout in contact.
    coarse = he.Plan(4e-2, 20)
    changes = variable([[0.0, 0.0, 20.0], [0.0, 0.0, 0.0]])
    with pytest.raises(he.RolloutError, match="row 1 of 2"):
        ht.rollout(world, coarse, [he.Parameter.initial_velocity("ball")], changes)


def test_arguments_of_other_types_and_batches_are_refused(ball_on_block, bounce):
    pair, pose_a, pose_b = ball_on_block
    world, plan = bounce
    with pytest.raises(he.HydroelasticError, match="leading axes of the arguments must be broadcastable"):
        ht.wrench(pair, np.stack([pose_a] * 2), np.stack([pose_b] * 3))
    for bad in ("a", None, [[1.0], [1.0, 2.0]], np.eye(4).astype(str)):
        with pytest.raises(TypeError, match="pose_a must be a tensor or a list of numbers"):
            ht.wrench(pair, bad, pose_b)
    for call, match in [
        (lambda: ht.wrench(world, pose_a, pose_b), "pair must be a Pair, but is World"),
        (lambda: ht.tactile_image(pair, pair, pose_a, pose_b), "grid must be a TaxelGrid"),
        (lambda: ht.rollout(pair, plan), "world must be a World"),
        (lambda: ht.initial_state(pair), "world must be a World"),
        (lambda: ht.final_state(world, 10), "plan must be a Plan"),
        (lambda: ht.step(world, 10, ht.initial_state(world)), "plan must be a Plan"),
        (lambda: ht.step(world, plan, world.initial_state), "the initial state must be a State of hydroelastic.jax or"),
        (lambda: ht.rollout(world, plan, he.Parameter.gravity()), "a single Parameter: put it into a list"),
    ]:
        with pytest.raises(TypeError, match=match):
            call()


def test_empty_batches_have_empty_results(ball_on_block):
    pair, _, pose_b = ball_on_block
    assert ht.wrench(pair, np.zeros((0, 4, 4)), pose_b).shape == (0, 12)
    assert ht.clearance(pair, np.zeros((0, 4, 4)), pose_b).shape == (0,)


def test_poses_are_those_of_the_library():
    for vector in ([0.0, 0.0, 0.0], [1e-5, 0.0, 0.0], [0.1, 0.2, 0.21], [0.1, 0.2, 0.23], [1.0, -2.0, 0.5]):
        turned = ht.pose([1.0, 2.0, 3.0], vector)
        assert np.allclose(turned, he.pose([1.0, 2.0, 3.0], vector), rtol=0, atol=ROTATION)
        twist = np.array([*vector, 0.1, 0.2, 0.3])
        assert np.allclose(ht.moved_pose(turned, twist), he.moved_pose(turned.numpy(), twist), rtol=0, atol=ROTATION)
        at = variable([1.0, 2.0, 3.0, *vector])
        assert torch.autograd.gradcheck(lambda x: ht.pose(x[:3], x[3:]), at, check_forward_ad=True)
        assert torch.autograd.gradgradcheck(lambda x: ht.pose(x[:3], x[3:]), at)
    assert ht.pose(np.zeros(3), np.zeros((5, 3))).shape == (5, 4, 4)


def flat(state):
    return torch.cat([state.poses.ravel(), state.twists.ravel()])


def without_friction(world):
    bodies = world.bodies
    smooth = [he.Parameter.friction(body.name) for body in bodies]
    return world.perturbed(smooth, np.array([-body.material.friction for body in bodies]))


@pytest.mark.parametrize("friction, tolerance", [(False, ROLLOUT), (True, FRICTION)])
def test_rollout_has_the_derivatives_of_differences(bounce, friction, tolerance):
    world, plan = bounce
    world = world if friction else without_friction(world)
    by = [he.Parameter.initial_position("ball"), he.Parameter.initial_velocity("ball"), he.Parameter.modulus("ball")]
    by += [he.Parameter.dissipation("floor"), he.Parameter.mass("ball"), he.Parameter.gravity()]
    by += [he.Parameter.friction("floor")] if friction else []
    # The unit of the modulus is 1e5 Pa.
    units = torch.tensor([1.0] * 6 + [1e5] + [1.0] * 5 + [1.0] * friction, dtype=torch.float64)

    def run(numbers):
        return flat(ht.rollout(world, plan, by, units * numbers))

    zero = np.zeros(len(units))
    forward, reverse = jacobians(run, zero)
    assert deviation(reverse, forward) < 1e-12
    assert deviation(differences(run, zero, 2e-6), forward) < tolerance
    assert torch.autograd.gradcheck(run, variable(zero), **CHECK)


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
        return flat(ht.rollout(world, plan, by, torch.from_numpy(units) * numbers))

    zero = np.zeros(len(units))
    forward, reverse = jacobians(run, zero)
    assert deviation(reverse, forward) < 1e-12
    assert deviation(differences(run, zero, 2e-6), forward) < FRICTION
    assert torch.autograd.gradcheck(run, variable(zero), **CHECK)


def test_nested_values_have_the_derivatives_of_changes():
    world, plan, _, _ = ground()
    friction, velocity = variable(np.array(0.5)), variable(np.array([0.4, 0.2, -0.1]))
    end = ht.final_state(world, plan, {"ball": {"friction": friction, "velocity": velocity}})
    end.poses[0, 0, 3].backward()
    by = [he.Parameter.friction("ball"), he.Parameter.initial_velocity("ball")]
    changes = variable(np.array([0.5, 0.4, 0.2, -0.1]) - world.values(by))
    ht.final_state(world, plan, by, changes).poses[0, 0, 3].backward()
    found = np.array([float(friction.grad), *velocity.grad.tolist()])
    assert np.abs(found - changes.grad.numpy()).max() < 1e-12


def test_rollout_by_its_start_has_the_derivatives_of_differences(bounce):
    world, plan = bounce
    world = without_friction(world)
    state = ht.initial_state(world)

    def run(numbers):
        poses = torch.stack([ht.moved_pose(state.poses[0], numbers[:6]), state.poses[1]])
        start = ht.State(poses, torch.stack([state.twists[0] + numbers[6:12], state.twists[1]]))
        return flat(ht.rollout(world, plan, [he.Parameter.modulus("ball")], 1e5 * numbers[12:], start=start))

    zero = np.zeros(13)
    forward, reverse = jacobians(run, zero)
    assert deviation(reverse, forward) < 1e-12
    assert deviation(differences(run, zero, 2e-6), forward) < ROLLOUT
    assert torch.autograd.gradcheck(run, variable(zero), **CHECK)


def test_gradients_by_many_numbers_are_swept_back(driven, monkeypatch):
    plan = he.Plan(5e-4, 300, record_every=150)
    by = [he.Parameter.friction("ball"), he.Parameter.mass("brick"), *he.Parameter.controls(["ball"], 2)]
    state = ht.initial_state(driven)

    def run(numbers):
        return flat(ht.rollout(driven, plan, by, numbers, start=state))

    at = torch.zeros(14, dtype=torch.float64)
    factors = torch.from_numpy(np.random.default_rng(1).uniform(-1.0, 1.0, run(at).shape))
    calls = counted(monkeypatch, _autodiff.Rollout)
    forward = torch.func.jacfwd(run)(at).numpy()
    calls.update(values=0, values_and_jacobians=0, pullbacks=0)
    numbers = variable(at)
    (factors @ run(numbers)).backward()
    assert calls == {"values": 1, "values_and_jacobians": 0, "pullbacks": 1}
    expected = factors.numpy() @ forward
    near = 1e-10 * np.abs(expected).max()
    assert np.abs(numbers.grad.numpy() - expected).max() <= near
    assert np.abs(torch.func.grad(lambda x: factors @ run(x))(at).numpy() - expected).max() <= near
    many = torch.stack([at, at + 0.01])
    slopes = torch.func.vmap(torch.func.grad(lambda x: factors @ run(x)))(many).numpy()
    assert np.abs(slopes[0] - expected).max() <= near
    calls.update(values=0, values_and_jacobians=0, pullbacks=0)
    assert deviation(torch.func.jacrev(run)(at).numpy(), forward) < 1e-12
    assert calls["values_and_jacobians"] == 1
    with pytest.raises(NotImplementedError, match="first derivatives only"):
        torch.func.hessian(lambda x: factors @ run(x))(at)


def test_rollouts_have_the_bits_of_the_library(bounce):
    world, plan = bounce
    by = [he.Parameter.initial_velocity("ball")]
    changes = np.array([[0.0, 0.0, 0.0], [0.1, -0.2, 0.3], [1.0, 0.0, 0.0]])
    expected = he.Batch(plan).rollouts_perturbed(world, by, changes)
    actual = ht.rollout(world, plan, by, changes)
    # The other attributes are None, which vmap refuses.
    last = torch.func.vmap(lambda change: ht.final_state(world, plan, by, change)[:2])(torch.from_numpy(changes))
    assert actual.poses.shape == (3, 4, 2, 4, 4) and last[1].shape == (3, 2, 6)
    for i, trajectory in enumerate(expected):
        assert np.array_equal(actual.poses[i], trajectory.poses)
        assert np.array_equal(actual.twists[i], trajectory.twists)
        assert np.array_equal(last[0][i], trajectory.poses[-1])
    assert ht.rollout(world, he.Plan(5e-4, 7, record_every=3)).poses.shape == (4, 2, 4, 4)


def test_steps_are_a_rollout(driven):
    """With controls and forces, the chain rule over 20 steps gives the derivative of the rollout."""
    # A single step does not have the substeps of the step before, so error control would divide it differently.
    undivided = he.Accuracy(1e9, 1e9)
    plan = he.Plan(5e-3, 20, he.Integrator.SDIRK3, record_every=20, accuracy=undivided)
    by = [he.Parameter.friction("ball"), he.Parameter.control("ball", 1)]
    weights = torch.linspace(-1.0, 1.0, 66, dtype=torch.float64)

    def gradients(end):
        state = ht.State(*(tensor.requires_grad_() for tensor in ht.initial_state(driven)[:2]))
        changes = variable(np.zeros(7))
        (weights @ flat(end(state, changes))).backward()
        return [state.poses.grad, state.twists.grad, changes.grad]

    def stepped(state, changes):
        for start_step in range(20):
            state = ht.step(driven, plan, state, by, changes, start_step=start_step)
        return state

    def rolled(state, changes):
        return ht.final_state(driven, plan, by, changes, start=state)

    for one, other in zip(gradients(stepped), gradients(rolled)):
        assert other.abs().max() > 1e-3
        assert np.allclose(one, other, rtol=0, atol=1e-9 * other.abs().max().item())


def test_compiled_functions_call_the_library(ball_on_block):
    pair, pose_a, pose_b = ball_on_block

    def loss(pose):
        return (ht.wrench(pair, pose, pose_b) ** 2).sum()

    expected, actual = variable(pose_a), variable(pose_a)
    loss(expected).backward()
    torch.compile(loss, backend="eager")(actual).backward()
    assert np.array_equal(actual.grad, expected.grad)


def test_without_torch_it_is_said_what_to_install():
    code = "import sys; sys.modules['torch'] = None; import hydroelastic.torch"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert 'ImportError: hydroelastic.torch needs PyTorch: pip install "hydroelastic[torch]"' in done.stderr


def test_the_program_of_the_docstring_runs():
    program = "\n".join(line[4:] for line in ht.__doc__.splitlines() if line.startswith("    "))
    namespace = {}
    exec(program, namespace)
    _, jacobian = namespace["pair"].wrench_and_jacobian(he.pose([0.0, 0.0, 0.195]), he.pose())
    assert namespace["height"].grad.item() == pytest.approx(jacobian[5, 5], rel=1e-12)
