"""Worlds: attributes, paths, reports and files."""

import numpy as np
import pytest

import hydroelastic as he


def test_a_world_tells_what_it_is_made_of(driven):
    assert driven.names == ["ball", "brick", "floor"] and driven.index_of("brick") == 1
    ball, brick, floor = driven.bodies
    assert (ball.mass, floor.mass) == (1.0, None) and brick.mass == pytest.approx(800 * 0.006)
    assert ball.material == he.Material(1e5, 0.2, 0.4) and ball.shape.tets.shape == (320, 4)
    assert np.array_equal(ball.twist, [0.0, 1.0, 0.5, 0.5, 0.0, 0.0])
    assert [type(force) for force in driven.forces] == [he.Spring, he.Drag, he.Thruster]
    assert driven.forces[0].stiffness == 20.0 and driven.controls[0].wrenches.shape == (3, 6)
    assert np.array_equal(driven.gravity, [0.0, 0.0, -9.81])
    assert "Body(\"ball\", dynamic, 1.0 kg" in repr(ball) and "3 forces, 1 controls" in repr(driven)


def test_steps_and_rollouts_agree(scene):
    plan = he.Plan(1e-3, 5)
    rollout = scene.rollout(plan)
    states = list(rollout)
    assert len(states) == rollout.steps_taken == 5 and rollout.step_report is None
    recorded = scene.rollout(plan).run()
    assert len(recorded) == 6 and [state.time for state in recorded] == list(recorded.times)
    assert recorded[-1].poses.tobytes() == states[-1].poses.tobytes()
    assert scene.step(scene.initial_state, plan).poses.tobytes() == states[0].poses.tobytes()
    assert not recorded.poses.flags.writeable
    with pytest.raises(IndexError):
        recorded[6]


def test_implicit_steps_report_what_they_took(scene):
    rollout = scene.rollout(he.Plan(5e-3, 60, he.Integrator.SDIRK3))
    reports = [rollout.step_report for _ in rollout]
    total = rollout.total_step_report
    assert sum(report.evaluations for report in reports) == total.evaluations > 0
    assert total.rejections > 0 and total.failures == 0 and total.islands >= 60
    loss = total.given + total.acting - total.kinetic
    assert total.numerical_loss == pytest.approx(loss)
    assert abs(total.numerical_loss) < 0.05 * abs(total.given)
    summed = reports[0]
    for report in reports[1:]:
        summed += report
    assert summed == total
    assert total.missed_by_body == [0, 0, 0]
    for errors in (total.errors_of_values, total.errors_of_slopes):
        assert errors.shape == (3,) and 0.0 < errors[0] < 0.5 and errors[2] == 0.0


def test_energies_contacts_and_stable_steps(bounce):
    world, _ = bounce
    pressed = he.State(0.0, np.stack([he.pose([0.0, 0.0, 0.19]), he.pose()]), np.zeros((2, 6)))
    report = world.diagnostics(pressed)
    assert report.kinetic_energy == 0.0 and report.contact_energy > 0.0
    assert report.gravitational_energy == pytest.approx(9.81 * 0.19)
    (contact,) = world.contacts(pressed)
    assert contact.bodies == ("ball", "floor") and contact.wrench[5] > 0.0
    assert len(contact.surface) == world.topology(pressed).polygon_count
    assert world.topology(pressed).touches(0, 1)
    assert world.topology(pressed).changes_since(world.topology(world.initial_state)) == len(contact.surface)
    step = world.largest_stable_step(pressed)
    # Friction determines this limit, but the check ignores friction.
    assert 1e-5 < step < 1.0 and world.largest_stable_step(world.initial_state) is None
    with pytest.raises(he.RolloutError, match="the stability limit of the contacts"):
        world.rollout(he.Plan(32 * step, 3), start=pressed).run()


def test_paths_go_through_their_poses_with_consistent_twists():
    times = np.array([0.0, 0.1, 0.3, 0.4])
    poses = np.stack([he.pose([t, t * t, 0.0], [t, -0.5 * t, 3 * t * t]) for t in times])
    path = he.Path(times, poses)
    for time, pose in zip(times[:-1], poses, strict=False):
        assert np.allclose(path.at(time)[0], pose, atol=1e-14)
    for time in np.linspace(0.01, 0.39, 20):
        step = 1e-6
        (before, _), (pose, twist), (after, _) = (path.at(time + change) for change in (-step, 0.0, step))
        rate = (after - before) / (2 * step)
        spin = rate[:3, :3] @ pose[:3, :3].T
        assert np.allclose([spin[2, 1], spin[0, 2], spin[1, 0]], twist[:3], atol=1e-7)
        assert np.allclose(rate[:3, 3], twist[3:], atol=1e-7)
    assert np.array_equal(path.at(9.0)[1], np.zeros(6)) and np.array_equal(path.at(-1.0)[1], np.zeros(6))


def test_a_path_arrives_with_its_twist_and_rests_after_it():
    push = np.array([0.1, 0.2, 0.3, 1.0, 0.5, 0.0])
    path = he.Path([0.0, 0.5], np.stack([he.pose(), he.pose([0.2, 0.1, 0.0])]), np.stack([np.zeros(6), push]))
    (before, arriving), (end, at_end) = path.at(0.5 - 1e-9), path.at(0.5)
    assert np.allclose(at_end, arriving, atol=1e-6) and np.allclose(before, end, atol=1e-8)
    assert np.array_equal(at_end, push)
    after, rest = path.at(np.nextafter(0.5, 1.0))
    assert np.array_equal(after, end) and np.array_equal(rest, np.zeros(6))
    # A path with a single pose is at rest.
    assert np.array_equal(he.Path([0.0], he.pose()[None], push[None]).at(0.0)[1], np.zeros(6))


def test_a_conveyor_carries_a_box():
    skin = he.Material(1e6, 0.5, 0.5)
    belt = he.Path.steady(he.pose([0.0, 0.0, -0.05]), [0.0, 0.0, 0.0, 0.5, 0.0, 0.0])
    box = he.Body.dynamic("box", he.Shape.cuboid([0.2, 0.2, 0.05]), skin, 1.0, pose=he.pose([0.0, 0.0, 0.025]))
    belt = he.Body.kinematic("belt", he.Shape.cuboid([4.0, 1.0, 0.1]), skin, belt)
    world = he.World([box, belt], gravity=[0.0, 0.0, -9.81])
    end = world.rollout(he.Plan(5e-3, 100, he.Integrator.SDIRK3)).run()[-1]
    assert end.twists[0, 3] == pytest.approx(0.5, abs=1e-3)


def test_files(scene, ball_on_block, tmp_path):
    trajectory = scene.rollout(he.Plan(1e-3, 100, record_every=10)).run()
    scene.write_recording(
        tmp_path / "scene.glb",
        trajectory,
        slowdown=2.0,
        targets={"goal": ([0.1, 0.0, 0.2], 0.02)},
        paths={"way": trajectory.poses[:, 0, :3, 3]},
        camera=([1.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
    )
    assert (tmp_path / "scene.glb").read_bytes()[:4] == b"glTF"
    scene.write_trajectory(tmp_path / "scene.csv", trajectory)
    assert len((tmp_path / "scene.csv").read_text().splitlines()) == 1 + 11 * 3
    pair, pose_a, pose_b = ball_on_block
    pair.write_surface(tmp_path / "surface.vtp", pose_a, pose_b)
    assert b"VTKFile" in (tmp_path / "surface.vtp").read_bytes()
    with pytest.raises(he.HydroelasticError, match="glb"):
        scene.write_recording(tmp_path / "scene.obj", trajectory)


def test_shapes():
    ball = he.Shape.icosphere(0.1, 2)
    again = he.Shape(ball.vertices, ball.tets, ball.extents)
    assert again.vertices.tobytes() == ball.vertices.tobytes() and np.array_equal(again.tets, ball.tets)
    mass, center, inertia = ball.mass_properties(2.0)
    assert mass == pytest.approx(2.0 * ball.volume) and np.abs(center).max() < 1e-15
    assert inertia[0, 0] == pytest.approx(0.4 * mass * 0.01, rel=0.05)
    distance = he.Shape(ball.vertices, ball.tets)
    assert distance.extents.max() == 1.0
    hull = he.Shape.star_shaped(ball.vertices[ball.surface_triangles].reshape(-1, 3), np.arange(960).reshape(-1, 3))
    assert hull.volume == pytest.approx(ball.volume)
    for shape in (
        he.Shape.ellipsoid([0.1, 0.2, 0.3], 1),
        he.Shape.distance_cuboid([0.1, 0.2, 0.3]),
        he.Shape.cylinder(0.1, 0.3, 16),
    ):
        assert shape.volume > 0.0 and shape.extents.max() == pytest.approx(1.0)
        assert repr(shape).startswith("Shape(")
