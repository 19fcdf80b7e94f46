"""Derivatives compared with central differences."""

import numpy as np

import hydroelastic as he

# Error of central differences of wrenches with steps of 1e-6, from round-off and curvature.
CONTACT = 1e-6
# Error of central differences of a rollout through a bounce on facets.
ROLLOUT = 1e-6


def difference(function, step):
    return (function(step) - function(-step)) / (2 * step)


def columns(pair, pose_a, pose_b, twists):
    """Returns the wrench as a function of a change of one of the 28 numbers."""
    moduli, law = np.array(pair.moduli), np.array([pair.law.dissipation, pair.law.friction])

    def changed(column, step):
        unit = np.zeros(28)
        unit[column] = step
        return pair.wrench(
            he.moved_pose(pose_a, unit[:6]),
            he.moved_pose(pose_b, unit[6:12]),
            twists[0] + unit[12:18],
            twists[1] + unit[18:24],
            moduli=moduli + unit[24:26],
            law=law + unit[26:],
        )

    return changed


def test_contact_in_motion(ball_on_block, twists):
    pair, pose_a, pose_b = ball_on_block
    _, jacobian = pair.linearized(pose_a, pose_b, *twists)
    changed = columns(pair, pose_a, pose_b, twists)
    for column in range(28):
        step = 1.0 if column in (24, 25) else 1e-6
        actual = difference(lambda change: changed(column, change), step)
        # Three columns of one kind have one scale, because rotations of a ball about its center have almost no effect.
        first = 3 * (column // 3) if column < 24 else column
        scale = np.abs(jacobian[:, first : first + (3 if column < 24 else 1)]).max()
        assert np.abs(actual - jacobian[:, column]).max() <= CONTACT * scale, column


def test_contact_at_rest_is_the_first_columns(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    wrench, jacobian = pair.wrench_and_jacobian(pose_a, pose_b)
    _, whole = pair.linearized(pose_a, pose_b)
    scale = np.abs(jacobian).max()
    assert np.abs(whole[:, :12] - jacobian[:, :12]).max() <= 1e-12 * scale
    assert np.abs(whole[:, 24:26] - jacobian[:, 12:]).max() <= 1e-12 * np.abs(wrench).max()


def test_energy_has_the_wrench_as_its_slope(ball_on_block):
    pair, pose_a, pose_b = ball_on_block
    wrench = pair.wrench(pose_a, pose_b)
    for axis in range(6):
        unit = np.eye(6)[axis]
        slope = difference(lambda step: pair.potential_energy(he.moved_pose(pose_a, step * unit), pose_b), 1e-6)
        assert abs(slope + wrench[axis]) <= 1e-5 * np.abs(wrench).max()


def test_rollout_by_every_parameter(bounce):
    world, plan = bounce
    numbers = {"length": 0.3, "stiffness": 5.0, "damping": 0.1, "drag": 0.2, "brake": 1e-3}
    spring = he.Spring(("ball", "floor"), ([0.0, 0.05, 0.0], [0.2, 0.0, 0.0]), "length", "stiffness", "damping")
    world = world.replace(
        controls=[he.Control("ball", 0.05, np.ones((3, 6)) * 0.1)],
        force_parameters=numbers,
        forces=[spring, he.Drag("ball", "drag", angular="brake")],
    )
    by = [
        he.Parameter.initial_position("ball"),
        he.Parameter.initial_orientation("ball"),
        he.Parameter.initial_velocity("ball"),
        he.Parameter.initial_angular_velocity("ball"),
        he.Parameter.modulus("ball"),
        he.Parameter.dissipation("floor"),
        he.Parameter.friction("ball"),
        he.Parameter.mass("ball"),
        he.Parameter.gravity(),
        he.Parameter.control("ball", 1),
        *map(he.Parameter.force_parameter, numbers),
    ]
    trajectory, jacobian = world.jacobian(plan, by)
    width = sum(parameter.dimension for parameter in by)
    assert jacobian.poses.shape == (*trajectory.poses.shape, width)
    assert jacobian.twists.shape == (*trajectory.twists.shape, width)
    check = world.difference_check(plan, by)
    assert len(check.numbers) == width == check.errors.shape[1]
    assert check.best < ROLLOUT, str(check)

    derivatives = world.derivative_check(plan, by[:2])
    # A rotation about the vertical axis hardly moves the ball, so that noise exceeds 3 % of the slope.
    assert derivatives.verdicts == ["right"] * 5 + ["noisy"], str(derivatives)
    assert derivatives.errors[:5].max() < 0.03 < derivatives.errors[5] and not derivatives.is_right
    assert (derivatives.widths > 0.0).all()
    assert world.derivative_check(plan, by[:1]).is_right
    assert derivatives.numbers == check.numbers[: len(derivatives.numbers)] and not any(derivatives.first_mismatch)

    # One derivative is checked explicitly: the last position with respect to the initial velocity.
    def end(step):
        changes = np.zeros(width)
        changes[6] = step
        return world.perturbed(by, changes).rollout(plan).run().poses[-1, 0]

    actual = difference(end, 1e-5)
    exact = jacobian.poses[-1, 0, ..., 6]
    assert np.abs(actual - exact).max() <= 1e-5 * np.abs(exact).max()
    assert np.abs(exact[:3, 3]).max() > 0.1

    # Every parameter has an effect. Force parameters give the same motion as constants.
    assert np.abs(jacobian.twists[-1, 0]).max(axis=0).min() > 0.0
    constants = [
        he.Spring(spring.bodies, spring.points, *(numbers[name] for name in ("length", "stiffness", "damping"))),
        he.Drag("ball", numbers["drag"], numbers["brake"]),
    ]
    same = world.replace(forces=constants).rollout(plan).run()
    assert same.twists.tobytes() == world.rollout(plan).run().twists.tobytes()


def test_a_step_to_first_order(bounce):
    world, _ = bounce
    plan = he.Plan(1e-3, 1)
    # The ball is pressed into the floor and slides.
    state = he.State(0.0, np.stack([he.pose([0.01, 0.02, 0.19]), he.pose()]), np.array([[0.1] * 6, [0.0] * 6]))
    control = he.Parameter.control("ball", 0)
    world = world.replace(controls=[he.Control("ball", 1.0, np.zeros((1, 6)))], start=state)
    last, a, b = world.linearize(plan, [control])
    end = world.step(state, plan)
    assert last.time == end.time and np.array_equal(last.poses, end.poses) and np.array_equal(last.twists, end.twists)

    def after(column):
        def displaced(step):
            return world.difference(end, world.step(world.integrate(state, step * np.eye(12)[column]), plan))

        return displaced

    for column in range(12):
        assert np.abs(difference(after(column), 1e-6) - a[:, column]).max() < 1e-6 * np.abs(a).max()

    def pushed(step):
        other = world.perturbed([control], step * np.eye(6)[3])
        return world.difference(end, other.step(state, plan))

    assert np.abs(difference(pushed, 1e-3) - b[:, 3]).max() < 1e-8
    assert b[9, 3] > 0.9e-3


def test_displacement_is_undone(scene):
    states = list(scene.rollout(he.Plan(1e-3, 5)))
    change = scene.difference(states[0], states[-1])
    assert change.shape == (24,)
    again = scene.integrate(states[0], change)
    assert np.allclose(again.poses, states[-1].poses, atol=1e-14)
    assert np.allclose(again.twists, states[-1].twists, atol=1e-14)


def test_jacobians_of_many_worlds_are_those_of_each(bounce):
    world, plan = bounce
    state = world.initial_state
    worlds = [
        world.replace(start=he.State(0.0, state.poses, state.twists + np.array([[0, 0, 0, 0.1 * index, 0, 0], [0] * 6])))
        for index in range(3)
    ]
    by = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]
    actual = he.Batch(plan).jacobians(worlds, by)
    for one, (trajectory, jacobian) in zip(worlds, actual, strict=True):
        expected, derivatives = one.jacobian(plan, by)
        assert np.array_equal(trajectory.poses, expected.poses) and np.array_equal(trajectory.twists, expected.twists)
        assert np.array_equal(jacobian.poses, derivatives.poses) and np.array_equal(jacobian.twists, derivatives.twists)
    (error,) = he.Batch(plan).jacobians(worlds[:1], [he.Parameter.mass("floor")])
    assert isinstance(error, he.HydroelasticError) and "the mass of \"floor\" has no effect" in str(error)


def test_progress_of_derivatives_ends_at_the_number_of_steps(bounce):
    world, _ = bounce
    plan = he.Plan(2e-5, 20_000, record_every=20_000)
    seen = []

    def progress(done, total):
        seen.append((done, total))

    world.jacobian(plan, [he.Parameter.gravity()], progress=progress)
    assert len(seen) > 1 and seen == sorted(seen) and seen[-1] == (20_000, 20_000)
    seen.clear()
    world.linearize(he.Plan(2e-5, 100), progress=progress)
    assert seen[-1] == (100, 100)
    # The rollout runs once for every 96 numbers.
    seen.clear()
    controls = [he.Control("ball", 1e-3, np.zeros((17, 6)))]
    by = [he.Parameter.control("ball", interval) for interval in range(17)]
    world.replace(controls=controls).jacobian(he.Plan(2e-5, 100), by, progress=progress)
    assert seen[-1] == (200, 200)
