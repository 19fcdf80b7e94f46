"""Tactile images: sums against wrenches, derivatives against differences, batches, worlds, pictures and pickles."""

import importlib
import pickle

import numpy as np
import pytest

import hydroelastic as he
from hydroelastic import view

# Round-off of a sum over taxels, and of a batch computed by another function.
SUM = 1e-12
# Error of second-order differences with steps of 1e-6.
DIFFERENCES = 1e-6
# Round-off of differences (N), for derivatives that are zero, as with respect to a turn of the pad about its normal.
ROUND_OFF = 1e-9

PAD = he.Shape.cuboid([0.04, 0.04, 0.01])
BALL = he.Shape.icosphere(0.02, 2)
TOP = he.pose([0.0, 0.0, 0.005])
GRID = he.TaxelGrid.flat([0.04, 0.04], 12, 10, TOP)
CAP = he.TaxelGrid.dome([2.0, 2.0], 6, 7, he.pose(rotation_vector=[np.pi, 0.0, 0.0]))
POSE = he.pose([0.0031, 0.0017, 0.0235], [0.2, 0.1, 0.3])
TWIST = np.array([0.3, 0.2, -0.1, 0.05, 0.02, -0.01])


@pytest.fixture(scope="module")
def pair():
    return he.Pair(PAD, BALL, 1e5, 3e5, he.SurfaceLaw(0.2, 0.5, 1e-2))


@pytest.mark.parametrize("twist", [None, TWIST])
def test_taxels_add_up_to_the_force(pair, twist):
    forces = pair.tactile_image(GRID, np.eye(4), POSE, None, twist)
    assert forces.shape == (10, 12, 3)
    wrench = pair.wrench(np.eye(4), POSE, None, twist)
    assert np.abs(forces.sum(axis=(0, 1)) - wrench[3:6]).max() < SUM * np.abs(wrench).max()
    on_ball = pair.tactile_image(CAP, np.eye(4), POSE, None, twist, body="b")
    in_body = np.einsum("hwij,hwj->i", CAP.axes, on_ball)
    assert np.abs(POSE[:3, :3] @ in_body - wrench[9:]).max() < SUM * np.abs(wrench).max()


def test_mean_tractions_are_pressures(pair):
    tractions = pair.tactile_image(GRID, np.eye(4), POSE, mean=True)
    forces = pair.tactile_image(GRID, np.eye(4), POSE)
    surface = pair.surface(np.eye(4), POSE)
    assert 0.0 < -tractions[..., 2].min() <= surface.pressures.max()
    assert np.array_equal(forces != 0.0, tractions != 0.0)


@pytest.mark.parametrize("body,grid", [("a", GRID), ("b", CAP)])
def test_derivatives_are_differences(pair, body, grid):
    poses, twists, moduli, law = [np.eye(4), POSE], [-TWIST, TWIST], np.array([1e5, 3e5]), np.array([0.2, 0.5])

    def image(change):
        changed = [he.moved_pose(pose, change[6 * i : 6 * i + 6]) for i, pose in enumerate(poses)]
        moving = [twist + change[12 + 6 * i : 18 + 6 * i] for i, twist in enumerate(twists)]
        materials = {"moduli": moduli * (1.0 + change[24:26]), "law": law + change[26:]}
        return pair.tactile_image(grid, *changed, *moving, body=body, **materials)

    forces, jacobian = pair.linearized_tactile_image(grid, *poses, *twists, body=body, moduli=moduli, law=law)
    assert jacobian.shape == (*forces.shape, 28)
    assert np.abs(forces - image(np.zeros(28))).max() < SUM
    jacobian[..., 24:26] *= moduli
    for column, step in enumerate(1e-6 * np.eye(28)):
        difference = (image(step) - image(-step)) / 2e-6
        allowed = DIFFERENCES * np.abs(jacobian[..., column]).max() + ROUND_OFF
        assert np.abs(difference - jacobian[..., column]).max() < allowed
    forces, at_rest = pair.tactile_image_and_jacobian(grid, *poses, body=body)
    assert at_rest.shape == (*forces.shape, 14)


@pytest.mark.parametrize("twists", [{}, {"twist_a": [0.3, -0.2, 0.1, 0.02, 0.05, 0.01]}])
@pytest.mark.parametrize("body,grid", [("a", GRID), ("b", CAP)])
def test_shape_gradients_are_differences(pair, body, grid, twists):
    random = np.random.default_rng(3)
    by_forces = random.normal(size=pair.tactile_image(grid, np.eye(4), POSE, body=body).shape)
    moves = random.normal(size=BALL.vertices.shape)

    def loss(step):
        ball = he.Shape(BALL.vertices + step * moves, BALL.tets, BALL.extents, inert_tets=True)
        changed = he.Pair(PAD, ball, 1e5, 3e5, he.SurfaceLaw(0.2, 0.5, 1e-2))
        return np.sum(by_forces * changed.tactile_image(grid, np.eye(4), POSE, body=body, **twists))

    _, gradient = pair.tactile_shape_gradients(grid, np.eye(4), POSE, by_forces, body=body, **twists)
    difference = (loss(1e-7) - loss(-1e-7)) / 2e-7
    size = np.abs(gradient.by_vertices * moves).sum()
    assert abs(difference - np.sum(gradient.by_vertices * moves)) < DIFFERENCES * size
    batch, _ = pair.tactile_shape_gradients(grid, np.eye(4), np.stack([POSE] * 2), np.stack([by_forces] * 2), body=body)
    assert np.array_equal(batch.by_vertices[0], batch.by_vertices[1])
    with pytest.raises(he.HydroelasticError, match="by_forces"):
        pair.tactile_shape_gradients(grid, np.eye(4), POSE, by_forces[1:], body=body)


def test_batches_have_the_bits_of_single_images(pair):
    poses = np.stack([he.moved_pose(POSE, [0.0, 0.0, 0.0, 1e-4 * k, 0.0, -1e-4 * k]) for k in range(9)])
    batch = pair.tactile_image(GRID, np.eye(4), poses)
    _, jacobians = pair.tactile_image_and_jacobian(GRID, np.eye(4), poses)
    assert batch.shape == (9, 10, 12, 3) and jacobians.shape == (9, 10, 12, 3, 14)
    for image, jacobian, pose in zip(batch, jacobians, poses):
        assert np.array_equal(image, pair.tactile_image(GRID, np.eye(4), pose))
        assert np.array_equal(jacobian, pair.tactile_image_and_jacobian(GRID, np.eye(4), pose)[1])


def test_worlds_add_the_contacts_of_a_body():
    skin = he.Material(1e5)
    pad = he.Body.fixed("pad", PAD, skin)
    places = {"left": [-0.01, 0.001, 0.024], "right": [0.011, 0.001, 0.024]}
    balls = [he.Body.dynamic(name, BALL, skin, 0.1, pose=he.pose(place)) for name, place in places.items()]
    world = he.World([pad, *balls])
    state = world.initial_state
    every = world.tactile_image(state, "pad", GRID)
    left, right = (world.tactile_image(state, "pad", GRID, partner=name) for name in ("left", "right"))
    assert np.abs(every - left - right).max() < SUM and np.any(left) and np.any(right)
    # The pad is the first body of its contacts, because it is the first in the list.
    total = sum(contact.wrench[3:6] for contact in world.contacts(state) if contact.bodies[0] == "pad")
    assert np.abs(every.sum(axis=(0, 1)) - total).max() < SUM * np.abs(total).max()
    for body, partner in (("pad", "pad"), ("nobody", None), ("pad", "nobody")):
        with pytest.raises(he.HydroelasticError):
            world.tactile_image(state, body, GRID, partner=partner)


def test_grids_are_pickled_and_bad_ones_refused(pair):
    planes = [[1.0, 0.0, 0.0, 0.01], [1.0, 0.0, 0.0, -0.01]], [[0.0, 2.0, 0.0, 0.01], [0.0, 1.0, 0.1, -0.01]]
    own = he.TaxelGrid(*planes, [-0.01] * 3, [0.01] * 3)
    for grid in (GRID, CAP, he.TaxelGrid.cylindrical(1.0, 0.02, 3, 4), own):
        again = pickle.loads(pickle.dumps(grid))
        assert np.array_equal(again.axes, grid.axes) and repr(again) == repr(grid)
    for refused in (
        lambda: he.TaxelGrid.flat([0.04, 0.04], 0, 3),
        lambda: he.TaxelGrid.dome([0.04, 3.2], 3, 3),
        lambda: he.TaxelGrid(planes[0][::-1], planes[1], [-0.1] * 3, [0.1] * 3),
        lambda: pair.tactile_image(GRID, np.eye(4), POSE, body="c"),
    ):
        with pytest.raises(he.HydroelasticError):
            refused()


def test_a_picture_has_a_square_for_each_taxel_and_arrows(pair):
    image = pair.tactile_image(GRID, np.eye(4), POSE, None, TWIST, mean=True)
    picture = view.of_tactile_image(image, size=(0.04, 0.04))
    assert "10 rows and 12 columns" in repr(picture) and len(picture.html) > 1000
    for bad in (image[..., :2], image * np.nan):
        with pytest.raises(he.HydroelasticError):
            view.of_tactile_image(bad)
    with pytest.raises(he.HydroelasticError):
        view.of_tactile_image(image, size=(0.0, 1.0))


def test_jax_differentiates_images(pair):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    hj = importlib.import_module("hydroelastic.jax")

    def loss(twist):
        forces = hj.tactile_image(pair, GRID, np.eye(4), hj.moved_pose(POSE, twist))
        return (forces**2).sum()

    gradient = jax.jit(jax.grad(loss))(np.zeros(6))
    forces, jacobian = pair.tactile_image_and_jacobian(GRID, np.eye(4), POSE)
    expected = 2.0 * np.einsum("hwi,hwij->j", forces, jacobian)[6:12]
    assert np.abs(gradient - expected).max() < SUM * np.abs(expected).max()
    poses = np.stack([POSE, he.moved_pose(POSE, 1e-3 * np.ones(6))])
    batch = jax.vmap(lambda pose: hj.tactile_image(pair, CAP, np.eye(4), pose, twist_b=TWIST, body="b"))(poses)
    assert np.array_equal(batch, pair.tactile_image(CAP, np.eye(4), poses, None, TWIST, body="b"))


@pytest.mark.torch
def test_torch_differentiates_images(pair):
    torch = pytest.importorskip("torch")
    ht = importlib.import_module("hydroelastic.torch")
    twist = torch.zeros(6, dtype=torch.float64, requires_grad=True)
    pose = ht.moved_pose(torch.from_numpy(POSE), twist)
    forces = ht.tactile_image(pair, GRID, torch.eye(4, dtype=torch.float64), pose)
    (forces**2).sum().backward()
    values, jacobian = pair.tactile_image_and_jacobian(GRID, np.eye(4), POSE)
    expected = 2.0 * np.einsum("hwi,hwij->j", values, jacobian)[6:12]
    assert np.abs(twist.grad.numpy() - expected).max() < SUM * np.abs(expected).max()
