"""Clearances of pairs and worlds, against closed forms and differences."""

import numpy as np
import pytest

import hydroelastic as he

STEP = 1e-6


def ball_and_floor(velocity):
    skin = he.Material(1e5)
    pose = he.pose([0.0, 0.0, 0.5])
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, mass=1.0, pose=pose, velocity=velocity)
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())
    return he.World([ball, floor], gravity=[0.0, 0.0, -9.81])


def test_derivatives_of_the_distance_are_differences():
    pair = he.Pair(he.Shape.cuboid([0.2, 0.3, 0.4]), he.Shape.icosphere(0.1, 2), 1e5, 1e5)
    pose_a, pose_b = he.pose([0.1, 0.2, 0.3], [0.3, 0.2, 0.1]), he.pose([0.5, 0.1, 0.2])
    distance, points, by_poses = pair.clearance(pose_a, pose_b)
    assert abs(np.linalg.norm(points[1] - points[0]) - distance) < 1e-12
    for column in range(6):
        twist = STEP * np.eye(6)[column]
        ahead, behind = (pair.clearance(he.moved_pose(pose_a, side * twist), pose_b)[0] for side in (1.0, -1.0))
        assert abs((ahead - behind) / (2.0 * STEP) - by_poses[column]) < 1e-7


def test_batches_have_the_distances_of_single_pairs():
    pair = he.Pair(he.Shape.icosphere(0.1, 1), he.HalfSpace(), 1e5)
    poses = np.array([he.pose([0.0, 0.0, z]) for z in (0.05, 0.3, 1.0)])
    distances, points, by_poses = pair.clearance(poses, np.eye(4))
    assert distances.shape == (3,) and points.shape == (3, 2, 3) and by_poses.shape == (3, 12)
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


def test_bodies_without_a_clearance_are_refused():
    world = ball_and_floor([0.0, 0.0, 0.0])
    for names in (("ball", "ball"), ("ball", "wall")):
        with pytest.raises(he.HydroelasticError):
            world.clearance(he.Plan(1e-3, 1), [], *names)
