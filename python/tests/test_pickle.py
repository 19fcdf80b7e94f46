"""Pickled objects keep all bits."""

import copy
import pickle

import numpy as np
import pytest

import hydroelastic as he


def again(value):
    return pickle.loads(pickle.dumps(value))


def same(a, b):
    assert a.dtype == b.dtype and a.shape == b.shape
    assert a.tobytes() == b.tobytes()


def test_worlds(driven):
    plan = he.Plan(2e-4, 600, record_every=200)
    # These are not the numbers of the constructor, so any loss of bits shows.
    start = list(driven.rollout(he.Plan(3e-4, 3)))[-1]
    world = driven.replace(start=start).perturbed([he.Parameter.mass("brick")], [0.1 / 3])
    loaded = again(world)
    expected, actual = (each.rollout(plan).run() for each in (world, loaded))
    same(expected.poses, actual.poses)
    same(expected.twists, actual.twists)
    same(expected.times, actual.times)
    assert repr(loaded) == repr(world) and loaded.slip_tolerance == world.slip_tolerance
    by = [he.Parameter.control("ball", 1)]
    same(world.jacobian(plan, by)[1].poses, loaded.jacobian(plan, by)[1].poses)


def test_worlds_with_paths():
    skin = he.Material(1e5, 0.1, 0.5)
    times = np.linspace(0.0, 1.0, 11)
    poses = np.stack([he.pose([0.3 * t, 0.1 * np.sin(t), -0.005 * t], [0.0, 0.1 * t, t]) for t in times])
    belt = he.Body.kinematic("belt", he.Shape.cuboid([1.0, 1.0, 0.2]), skin, he.Path(times, poses))
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=he.pose([0.0, 0.0, 0.195]))
    disk = he.Path.steady(he.pose([3.0, 0.0, 0.0]), [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    table = he.Body.kinematic("table", he.Shape.cylinder(0.5, 0.1, 24), skin, disk)
    world = he.World([ball, belt, table], gravity=[0.0, 0.0, -9.81], ignoring=[("ball", "table")])
    plan = he.Plan(5e-4, 200)
    expected, actual = (each.rollout(plan).run() for each in (world, again(world)))
    same(expected.poses, actual.poses)
    same(expected.twists, actual.twists)
    assert again(world).ignored == [("ball", "table")]
    assert abs(expected.poses[-1, 1, 0, 3] - 0.03) < 1e-4 and expected.poses[-1, 0, 0, 3] > 1e-3


def test_bodies_of_a_world_at_a_later_time():
    skin = he.Material(1e5)
    path = he.Path.steady(he.pose([0.0, 0.0, -0.1]), [0.0, 0.0, 0.0, 0.5, 0.0, 0.0])
    belt = he.Body.kinematic("belt", he.Shape.cuboid([1.0, 1.0, 0.2]), skin, path)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=he.pose([0.0, 0.0, 0.2]))
    world = he.World([ball, belt])
    world = world.replace(start=world.rollout(he.Plan(1e-3, 10)).run()[-1])
    for body, pickled, copied in zip(world.bodies, again(world.bodies), copy.deepcopy(world.bodies), strict=True):
        for other in (pickled, copied):
            same(body.pose, other.pose)
            same(body.twist, other.twist)
    # A new world starts at time 0, where the path begins.
    assert world.bodies[1].pose[0, 3] == 0.005
    for bodies in (world.bodies, again(world.bodies)):
        assert he.World(bodies).initial_state.poses[1, 0, 3] == 0.0
        same(he.World(bodies, start=world.initial_state).initial_state.poses, world.initial_state.poses)


def test_free_bodies_without_mass_keep_their_motion():
    pose = he.pose([0.1, 0.2, 0.3], [0.3, -0.2, 0.1])
    hub = he.Body.dynamic("hub", None, mass=0.0, pose=pose, velocity=[1.0, 2.0, 3.0], angular_velocity=[0.4, 0.5, 0.6])
    inertia = np.diag([0.1, 0.2, 0.3])
    load = he.Body.dynamic("load", None, mass=2.0, inertia=inertia, joint=he.Joint.fixed("weld", parent="hub"))
    for bodies in ([hub, load], again([hub, load]), again(he.Mechanism([hub, load])).bodies, copy.deepcopy([hub, load])):
        same(bodies[0].pose, pose)
        same(bodies[0].twist, np.array([0.4, 0.5, 0.6, 1.0, 2.0, 3.0]))
        assert bodies[0].joint is None and bodies[0].mass == 0.0
        # The center of mass of the hub is at its origin, and the load moves with it.
        same(he.World(bodies).initial_state.twists[1], he.World([hub, load]).initial_state.twists[1])


def test_states_and_trajectories(scene):
    trajectory = scene.rollout(he.Plan(2e-4, 500, record_every=100)).run()
    loaded = again(trajectory)
    assert len(loaded) == 6
    for name in ("times", "poses", "twists"):
        same(getattr(trajectory, name), getattr(loaded, name))
    state = trajectory[-2]
    rebuilt = he.State(state.time, state.poses, state.twists)
    plan = he.Plan(2e-4, 50)
    ends = [scene.rollout(plan, start=start).run()[-1] for start in (state, again(state), rebuilt)]
    for end in ends[1:]:
        same(ends[0].poses, end.poses)
        same(ends[0].twists, end.twists)


def test_pairs_surfaces_and_derivatives(ball_on_block, bounce):
    pair, pose_a, pose_b = ball_on_block
    same(again(pair).linearized(pose_a, pose_b)[1], pair.linearized(pose_a, pose_b)[1])
    surface = pair.surface(pose_a, pose_b)
    same(again(surface).pressures, surface.pressures)
    same(again(surface).tets, surface.tets)
    world, plan = bounce
    _, jacobian = world.jacobian(plan, [he.Parameter.gravity()])
    same(again(jacobian).twists, jacobian.twists)
    report = world.diagnostics(world.initial_state)
    assert again(report).total_energy == report.total_energy


INTEGRATORS = [
    he.Integrator.SYMPLECTIC_EULER,
    he.Integrator.LEAPFROG,
    he.Integrator.SDIRK3,
    he.Integrator.IMPLICIT_EULER,
]
PARAMETERS = [
    he.Parameter.initial_position("ball"),
    he.Parameter.initial_orientation("ball"),
    he.Parameter.initial_velocity("ball"),
    he.Parameter.initial_angular_velocity("ball"),
    he.Parameter.modulus("ball"),
    he.Parameter.dissipation("ball"),
    he.Parameter.friction("ball"),
    he.Parameter.mass("ball"),
    he.Parameter.control("ball", 3),
    he.Parameter.gravity(),
    he.Parameter.force_parameter("ball"),
]


@pytest.mark.parametrize(
    "value",
    [
        he.Plan(1e-3, 7, he.Integrator.SDIRK3, record_every=3, check_stability=False, solver_tolerance=1e-9),
        he.Accuracy(0.1 / 3, 1e-4, 0.2),
        he.Plan(5e-3, 7, he.Integrator.SDIRK3, accuracy=he.Accuracy(slopes=0.1 / 3)),
        he.Material(1e5, 0.1 / 3, 0.4),
        he.SurfaceLaw(0.1 / 3, 0.4, 1e-2),
        *INTEGRATORS,
        *PARAMETERS,
    ],
    ids=repr,
)
def test_settings(value):
    assert again(value) == value == copy.deepcopy(value)
    assert repr(again(value)) == repr(value)


def test_integrators_and_parameters_differ_from_one_another():
    for values in (INTEGRATORS, PARAMETERS):
        assert len(set(values)) == len(values) == len(set(map(repr, values)))
        assert set(map(again, values)) == set(values)
        assert [eval(repr(value), {"Integrator": he.Integrator, "Parameter": he.Parameter}) for value in values] == values
    assert [he.Plan(1e-3, 1, integrator).integrator for integrator in INTEGRATORS] == INTEGRATORS
    assert he.Plan(1e-3, 1).integrator == he.Integrator.LEAPFROG
    assert [parameter.body for parameter in PARAMETERS] == ["ball"] * 9 + [None, None]


def test_forces_by_name(driven):
    spring = he.Spring(("ball", "brick"), ([0.0] * 3, [0.0, 0.1, 0.0]), 0.5, "k", "c")
    world = driven.replace(force_parameters={"k": 20.0, "c": 0.1 / 3, "d": 0.2}, forces=[spring, he.Drag("ball", "d")])
    loaded = again(world)
    assert loaded.force_parameters == world.force_parameters == {"k": 20.0, "c": 0.1 / 3, "d": 0.2}
    assert repr(loaded.forces) == repr(again(world.forces)) == repr(world.forces)
    actual = again(spring)
    assert (actual.rest_length, actual.stiffness, actual.damping) == (0.5, "k", "c")
    assert 'stiffness="k"' in repr(spring) and loaded.forces[1].linear == "d"
    plan, by = he.Plan(5e-4, 20), [he.Parameter.force_parameter("c")]
    same(world.jacobian(plan, by)[1].poses, loaded.jacobian(plan, by)[1].poses)
    assert world.perturbed(by, [0.5]).force_parameters["c"] == 0.1 / 3 + 0.5


def test_bodies(driven, bounce):
    skin = he.Material(1e5, 0.1 / 3, 0.5)
    path = he.Path.steady(he.pose([0.0, 0.0, -0.1]), [0.0, 0.0, 1.0, 0.1 / 3, 0.0, 0.0])
    belt = he.Body.kinematic("belt", he.Shape.cuboid([1.0, 1.0, 0.2]), skin, path)
    bodies = [*driven.bodies, belt]
    for body, loaded in zip(bodies, again(bodies), strict=True):
        assert repr(loaded) == repr(body) and loaded.material == body.material
        same(loaded.pose, body.pose)
        same(loaded.twist, body.twist)
        same(loaded.shape.vertices, body.shape.vertices)
    plan = he.Plan(5e-4, 200, record_every=200)
    expected, actual = (
        he.World(each, gravity=[0.0, 0.0, -9.81]).rollout(plan).run() for each in (bodies, again(bodies))
    )
    same(expected.poses, actual.poses)
    same(again(belt).path.at(0.3)[0], path.at(0.3)[0])


def test_topologies_and_difference_checks(bounce):
    world, plan = bounce
    pressed = world.rollout(plan).run()[-1]
    states = [he.State(0.0, np.stack([he.pose([0.0, 0.0, z]), he.pose()]), np.zeros((2, 6))) for z in (0.19, 0.195, 0.5)]
    topologies = [world.topology(state) for state in (*states, pressed)]
    assert again(topologies) == topologies and topologies[0] != topologies[2]
    assert again(topologies[0]).changes_since(topologies[2]) == topologies[0].polygon_count > 0
    check = world.difference_check(he.Plan(5e-4, 20), [he.Parameter.gravity(), he.Parameter.modulus("ball")])
    assert str(again(check)) == str(check) and again(check).numbers == check.numbers
    same(again(check).errors, check.errors)
    same(again(check).steps, check.steps)
    coarse = he.Plan(5e-3, 20, he.Integrator.SDIRK3, accuracy=he.Accuracy(1e3, 1e3))
    check = world.derivative_check(coarse, [he.Parameter.gravity()])
    assert again(check).verdicts == check.verdicts and again(check).is_right == check.is_right
    assert str(again(check)) == str(check) and again(check).first_mismatch == check.first_mismatch
    same(again(check).errors, check.errors)
    same(again(check).widths, check.widths)


def test_batches_travel_and_rollouts_say_why_not(bounce):
    world, plan = bounce
    same(again(he.Batch(plan)).rollouts([world])[0].poses, world.rollout(plan).run().poses)
    with pytest.raises((AttributeError, pickle.PicklingError), match="lambda"):
        pickle.dumps(he.Batch(plan, progress=lambda done, total: None))
    with pytest.raises(TypeError, match="world.rollout.plan, start=state. goes on from there"):
        pickle.dumps(world.rollout(plan))


def test_reports_and_exceptions(bounce):
    world, _ = bounce
    rollout = world.rollout(he.Plan(5e-3, 30, he.Integrator.SDIRK3))
    rollout.run()
    assert again(rollout.total_step_report) == rollout.total_step_report
    error = he.RolloutError("ended")
    error.trajectory = world.rollout(he.Plan(1e-3, 2)).run()
    assert len(again(error).trajectory) == 3 and str(again(error)) == "ended"
