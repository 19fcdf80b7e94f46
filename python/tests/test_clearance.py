"""Clearances of pairs and worlds, against closed forms and differences."""

import importlib

import numpy as np
import pytest

import hydroelastic as he

STEP = 1e-6
# Round-off of the chain rule, relative to gradients of size 1.
ROUND_OFF = 1e-12


def ball_and_floor(velocity):
    skin = he.Material(1e5)
    pose = he.pose([0.0, 0.0, 0.5])
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, mass=1.0, pose=pose, velocity=velocity)
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())
    return he.World([ball, floor], gravity=[0.0, 0.0, -9.81])


# Heights of a cuboid whose lowest edge crosses the highest edge of another cuboid: apart, and overlapping.
HEIGHTS = [0.6, 0.55]


def crossed_cuboids(height):
    """A pair with poses. If it overlaps, a corner of the contact surface is deepest, so the depth depends on the moduli."""
    pair = he.Pair(he.Shape.cuboid([0.4, 0.2, 0.2]), he.Shape.cuboid([0.2, 0.4, 0.2]), 1e5, 3e5)
    pose_b = he.pose([0.11, 0.21, height], [0.02, np.pi / 4 - 0.04, 0.03])
    return pair, he.pose([0.1, 0.2, 0.3], [np.pi / 4 + 0.03, 0.02, 0.01]), pose_b


@pytest.mark.parametrize("height", HEIGHTS)
def test_derivatives_of_the_distance_are_differences(height):
    pair, *poses = crossed_cuboids(height)
    distance, points, gradient = pair.clearance(*poses)
    overlap = height == HEIGHTS[1]
    assert (distance < 0.0) == overlap and gradient[12:].any() == overlap
    assert overlap or abs(np.linalg.norm(points[1] - points[0]) - distance) < 1e-12

    def changed(change):
        moved = [he.moved_pose(pose, change[6 * i : 6 * i + 6]) for i, pose in enumerate(poses)]
        return pair.clearance(*moved, moduli=np.array([1e5, 3e5]) * (1.0 + change[12:]))[0]

    for column, step in enumerate(STEP * np.eye(14)):
        unit = [1e5, 3e5][column - 12] if column >= 12 else 1.0
        assert abs((changed(step) - changed(-step)) / (2.0 * STEP) - unit * gradient[column]) < 1e-7


def test_batches_have_the_distances_of_single_pairs():
    pair = he.Pair(he.Shape.icosphere(0.1, 1), he.HalfSpace(), 1e5)
    poses = np.array([he.pose([0.0, 0.0, z]) for z in (0.05, 0.3, 1.0)])
    distances, points, gradients = pair.clearance(poses, np.eye(4))
    assert distances.shape == (3,) and points.shape == (3, 2, 3) and gradients.shape == (3, 14)
    assert distances[0] < 0.0
    assert [pair.clearance(pose, np.eye(4))[0] for pose in poses] == list(distances)


def test_the_clearance_of_a_world_has_a_gradient_before_contact():
    world, plan = ball_and_floor([0.0, 0.0, 0.0]), he.Plan(1e-3, 100)
    clearance, gradient = world.clearance(plan, [he.Parameter.initial_velocity("ball")], "ball", "floor")
    least, _ = world.clearance(plan, [], "floor", "ball", least=True)
    assert clearance == least > 0.0
    assert np.allclose(gradient, [0.0, 0.0, 0.1], atol=1e-12)


def test_the_time_of_first_contact_is_the_time_of_the_fall():
    parameters = [he.Parameter.initial_velocity("ball")]
    time, clearance, gradient = ball_and_floor([0.0, 0.0, 0.0]).first_contact(he.Plan(1e-4, 3500), parameters, "ball", "floor")
    assert abs(time - np.sqrt(2.0 * 0.4 / 9.81)) < 1e-4 and clearance == 0.0
    assert abs(gradient[2] - 1.0 / 9.81) < 1e-3
    time, clearance, gradient = ball_and_floor([0.0, 0.0, 9.0]).first_contact(he.Plan(1e-3, 100), parameters, "ball", "floor")
    assert time == 0.0 and abs(clearance - 0.4) < 1e-12


def test_the_time_of_first_contact_of_a_turning_box_has_the_slope_of_differences():
    box = he.Body.dynamic(
        "box",
        he.Shape.cuboid([0.2, 0.3, 0.4]),
        he.Material(1e4),
        1.0,
        pose=he.pose([0.0, 0.0, 0.6], [0.3, 0.4, 0.5]),
        velocity=[0.0, 0.0, -1.0],
        angular_velocity=[6.0, 0.0, 4.0],
    )
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())
    world = he.World([box, floor], ignoring=[("box", "floor")])
    plan = he.Plan(1e-2, 64, record_every=16)
    parameters = [he.Parameter.initial_position("box"), he.Parameter.initial_orientation("box")]

    def time_after(changes):
        return world.perturbed(parameters, changes).first_contact(plan, [], "box", "floor")[0]

    _, _, gradient = world.first_contact(plan, parameters, "box", "floor")
    differences = [(time_after(change) - time_after(-change)) / 2e-6 for change in 1e-6 * np.eye(6)]
    assert np.allclose(gradient, differences, atol=1e-7)


@pytest.mark.parametrize("height", HEIGHTS)
def test_jax_differentiates_distances(height):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    hj = importlib.import_module("hydroelastic.jax")
    pair, *poses = crossed_cuboids(height)

    def distance(change):
        moved = [hj.moved_pose(pose, change[6 * i : 6 * i + 6]) for i, pose in enumerate(poses)]
        return hj.clearance(pair, *moved, moduli=np.array([1e5, 3e5]) + change[12:])

    expected, _, gradient = pair.clearance(*poses)
    assert hj.clearance(pair, *poses) == expected
    for of in (jax.grad, jax.jacfwd):
        assert np.abs(jax.jit(of(distance))(np.zeros(14)) - gradient).max() < ROUND_OFF
    batch = np.stack([he.moved_pose(poses[1], [0.0, 0.0, 0.0, 0.0, x, 0.0]) for x in (0.0, 0.01, 0.02)])
    distances, _, gradients = pair.clearance(poses[0], batch)
    assert np.array_equal(jax.vmap(lambda pose: hj.clearance(pair, poses[0], pose))(batch), distances)
    by_batch = jax.grad(lambda batch: hj.clearance(pair, poses[0], batch).sum())(batch)
    assert np.abs(by_batch[:, :3, 3] - gradients[:, 9:12]).max() < ROUND_OFF
    with pytest.raises(TypeError, match="pair must be a Pair, but is World"):
        hj.clearance(ball_and_floor([0.0, 0.0, 0.0]), *poses)


@pytest.mark.torch
@pytest.mark.parametrize("height", HEIGHTS)
def test_torch_differentiates_distances(height):
    torch = pytest.importorskip("torch")
    ht = importlib.import_module("hydroelastic.torch")
    pair, *poses = crossed_cuboids(height)
    change = torch.zeros(14, dtype=torch.float64, requires_grad=True)
    moved = [ht.moved_pose(pose, change[6 * i : 6 * i + 6]) for i, pose in enumerate(poses)]
    distance = ht.clearance(pair, *moved, moduli=torch.tensor([1e5, 3e5], dtype=torch.float64) + change[12:])
    distance.backward()
    expected, _, gradient = pair.clearance(*poses)
    assert distance.item() == expected and np.abs(change.grad.numpy() - gradient).max() < ROUND_OFF
    batch = torch.from_numpy(np.stack([he.moved_pose(poses[1], [0.0, 0.0, 0.0, 0.0, x, 0.0]) for x in (0.0, 0.01, 0.02)]))
    distances, _, gradients = pair.clearance(poses[0], batch.numpy())
    assert np.array_equal(torch.func.vmap(lambda pose: ht.clearance(pair, poses[0], pose))(batch), distances)
    by_batch = torch.func.grad(lambda batch: ht.clearance(pair, poses[0], batch).sum())(batch)
    assert np.abs(by_batch[:, :3, 3].numpy() - gradients[:, 9:12]).max() < ROUND_OFF


def test_bodies_without_a_clearance_are_refused():
    world = ball_and_floor([0.0, 0.0, 0.0])
    for names in (("ball", "ball"), ("ball", "wall")):
        with pytest.raises(he.HydroelasticError):
            world.clearance(he.Plan(1e-3, 1), [], *names)
