"""Scenes that several tests share."""

import inspect

import numpy as np
import pytest

import hydroelastic as he


def pytest_collection_modifyitems(items):
    """Marks the tests that need an optional package, because they skip themselves without it."""
    for item in items:
        heads = inspect.getsource(item.module).split("\ndef ")[0], inspect.getsource(item.function)
        if any("importorskip(" in source for source in heads):
            item.add_marker("optional")


@pytest.fixture(scope="session")
def ball_on_block():
    """A rotated ball of order 3 that is pressed into a block, with a surface law: the pair and both poses."""
    ball = he.Shape.icosphere(0.1, 3)
    block = he.Shape.cuboid([0.4, 0.4, 0.2])
    pair = he.Pair(ball, block, 1e5, 1e6, he.SurfaceLaw(0.2, 0.4, 1e-2))
    pose_a = he.pose([0.013, 0.021, 0.1921], [0.3, -0.2, 0.5])
    pose_b = he.pose([0.0, 0.0, 0.0], [0.02, -0.03, 0.01])
    return pair, pose_a, pose_b


TWISTS = (np.array([0.1, 0.2, -0.3, 0.5, 0.1, -0.05]), np.array([0.0, 0.0, 0.1, 0.0, -0.1, 0.0]))


@pytest.fixture
def twists():
    return TWISTS


@pytest.fixture(scope="session")
def scene():
    """A ball and a brick above a floor."""
    skin = he.Material(1e5, dissipation=0.2, friction=0.4)
    ball = he.Body.dynamic(
        "ball",
        he.Shape.icosphere(0.1, 2),
        skin,
        1.0,
        pose=he.pose([-0.3, 0.0, 0.25]),
        velocity=[0.5, 0.0, 0.0],
        angular_velocity=[0.0, 1.0, 0.5],
    )
    tilted = he.pose([0.3, 0.0, 0.26], [0.1, 0.3, -0.2])
    brick = he.Body.dynamic("brick", he.Shape.cuboid([0.1, 0.2, 0.3]), skin, density=800.0, pose=tilted)
    floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
    return he.World([ball, brick, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)


@pytest.fixture(scope="session")
def driven(scene):
    """The scene with forces of every kind and a control."""
    push = np.array([0.0, 0.0, 0.05, 0.5, 0.0, 0.0])
    return scene.replace(
        forces=[
            he.Spring(("ball", "brick"), ([0.0, 0.0, 0.0], [0.01, 0.02, 0.1]), 0.5, 20.0, 0.1),
            he.Drag("ball", 0.3, 0.01),
            he.Thruster("brick", [0.0, 0.1, 0.0], [1.0, 0.0, 0.5]),
        ],
        controls=[he.Control("ball", 0.05, np.stack([push, -push, push]))],
    )


@pytest.fixture(scope="session")
def rigid_world():
    """A ball that rolls over a half-space and is pushed by a rigid block."""
    skin, hard = he.Material(1e5, 0.2, 0.4), he.Material.rigid(0.5)
    block = he.RigidShape.around(he.Shape.cuboid([0.4, 0.4, 0.2]))
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0.0, 0.0, 0.12]))
    pusher = he.Body.dynamic(
        "block", block, hard, density=100.0, pose=he.pose([-0.31, 0.0, 0.1]), velocity=[0.5, 0.0, 0.5]
    )
    ground = he.Body.fixed("ground", he.HalfSpace(), hard)
    return he.World([ball, pusher, ground], gravity=[0.0, 0.0, -9.81], ignoring=[("block", "ground")])


@pytest.fixture(scope="session")
def bounce():
    """A ball that bounces off a floor: the world, and a plan for the fall and the bounce."""
    skin = he.Material(1e5, 0.2, 0.4)
    ball = he.Body.dynamic(
        "ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=he.pose([0.01, 0.02, 0.22]), velocity=[0.5, 0.1, 0.0]
    )
    floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
    return world, he.Plan(5e-4, 300, record_every=100)
