"""Joints: motion, states, derivatives, copies and errors."""

import copy
import importlib
import pickle

import numpy as np
import pytest

import hydroelastic as he

# Error of steps of 5 ms at the default tolerances, relative to the amplitude.
MOTION = 1e-4
# Round-off of reverse mode, relative to the largest derivative.
SAME = 1e-9
# Round-off of differences of rollouts.
DIFFERENCES = 1e-6
GRAVITY = 9.81


def link(name, joint, mass=1.0, length=0.3, skin=None):
    """A rod with a ball at its origin. Its center of mass is half its length below."""
    inertia = mass * length**2 / 12.0
    return he.Body.dynamic(
        name,
        he.Shape.icosphere(0.05, 1),
        skin or he.Material(1e6, 0.5, 0.5),
        mass,
        center_of_mass=[0.0, 0.0, -0.5 * length],
        inertia=np.diag([1.0, 1.1, 0.4]) * inertia,
        joint=joint,
    )


@pytest.fixture(scope="module")
def arm():
    """A ball joint, two hinges and a welded hand that rubs on the floor."""
    parts = [
        he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid(0.6)),
        link("upper", he.Joint.ball("socket", origin=he.pose([0.0, 0.0, 0.64]), angular_velocity=[0.2, 0.1, 0.5])),
        link(
            "lower",
            he.Joint.revolute(
                "elbow", [0, 2, 0], parent="upper", origin=he.pose([0.0, 0.0, -0.3]), position=0.1, damping=0.1, friction=0.2
            ),
        ),
        link(
            "wrist",
            he.Joint.prismatic(
                "slide",
                [0, 0, 1],
                parent="lower",
                origin=he.pose([0.0, 0.0, -0.25]),
                servo_stiffness=500.0,
                servo_damping=5.0,
                target_position=-0.02,
                armature=0.1,
            ),
            0.2,
            0.05,
        ),
        link("hand", he.Joint.fixed("weld", parent="wrist", origin=he.pose([0.0, 0.0, -0.04])), 0.1, 0.02),
    ]
    return he.World(parts, gravity=-GRAVITY, slip_tolerance=1e-2)


PLAN = he.Plan(5e-3, 20, he.Integrator.SDIRK3, record_every=5, solver_tolerance=1e-13)
# Steps of a constant length. Error control makes differences noisy.
STEADY = he.Plan(2e-3, 10, he.Integrator.IMPLICIT_EULER, solver_tolerance=1e-13)
ARRAYS = (
    "poses",
    "twists",
    "joint_positions",
    "joint_velocities",
    "ball_joint_rotations",
    "ball_joint_velocities",
)
OF_SCALARS = [
    "initial_position",
    "initial_velocity",
    "torque",
    "target_position",
    "target_velocity",
    "servo_stiffness",
    "servo_damping",
    "damping",
    "friction",
    "armature",
]
BY = [
    *(he.Parameter.joint("slide", quantity) for quantity in OF_SCALARS),
    he.Parameter.joint("elbow", "torque"),
    he.Parameter.joint("socket", "initial_orientation"),
    he.Parameter.joint("socket", "initial_angular_velocity"),
    he.Parameter.mass("hand"),
    he.Parameter.friction("hand"),
    he.Parameter.gravity(),
]


def oscillator(stiffness=8.0, damping=0.5):
    """An arm that a servo turns about a vertical axis, without gravity."""
    joint = he.Joint.revolute("hinge", [0, 0, 1], position=0.7, servo_stiffness=stiffness, damping=damping)
    return he.World([link("arm", joint)])


def oscillation(time, stiffness=8.0, damping=0.5):
    """The angle of the oscillator."""
    inertia = 0.4 * 0.3**2 / 12.0
    decay = damping / (2.0 * inertia)
    root = np.emath.sqrt(decay**2 - stiffness / inertia)
    return 0.7 * (np.exp(-decay * time) * (np.cosh(root * time) + decay * np.sinh(root * time) / root)).real


def test_a_servo_makes_a_damped_oscillation():
    for numbers in [(8.0, 0.01), (0.2, 0.1)]:
        plan = he.Plan(5e-3, 60, he.Integrator.SDIRK3)
        by = [he.Parameter.joint("hinge", "servo_stiffness"), he.Parameter.joint("hinge", "damping")]
        trajectory, jacobian = oscillator(*numbers).jacobian(plan, by)
        expected = oscillation(trajectory.times, *numbers)
        assert np.abs(trajectory.joint_positions[:, 0] - expected).max() < MOTION
        for column, step in enumerate(1e-5 * np.diag(numbers)):
            ends = [oscillation(trajectory.times, *(numbers + sign * step)) for sign in (1.0, -1.0)]
            slopes = (ends[0] - ends[1]) / (2.0 * step[column])
            error = np.abs(jacobian.joint_positions[:, 0, column] - slopes).max()
            assert error < 1e-2 * np.abs(slopes).max()


def test_a_pendulum_follows_its_equation_of_motion():
    hinge = he.Joint.revolute("hinge", [0, 1, 0], position=1.2)
    world = he.World([link("rod", hinge)], gravity=-GRAVITY)
    trajectory = world.rollout(he.Plan(5e-3, 200, he.Integrator.SDIRK3)).run()
    factor = -GRAVITY * 0.15 / (1.1 * 0.3**2 / 12.0 + 0.15**2)

    def rates(state):
        return np.array([state[1], factor * np.sin(state[0])])

    state, step = np.array([1.2, 0.0]), 1e-3
    for _ in range(1000):
        k1 = rates(state)
        k2 = rates(state + 0.5 * step * k1)
        k3 = rates(state + 0.5 * step * k2)
        k4 = rates(state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    assert abs(trajectory.joint_positions[-1, 0] - state[0]) < 10 * MOTION
    assert abs(trajectory.joint_velocities[-1, 0] - state[1]) < 100 * MOTION
    angle = trajectory.joint_positions[-1, 0]
    assert np.abs(trajectory.poses[-1, 0] - he.pose(rotation_vector=[0.0, angle, 0.0])).max() < 1e-12


def test_joints_show_their_numbers():
    stops = he.Stops((-1.0, 2.0), 100.0, 0.1)
    joint = he.Joint.revolute(
        "elbow",
        [0, 0, 2],
        parent="upper",
        origin=he.pose([0.0, 0.0, 0.4]),
        position=0.1,
        velocity=0.2,
        armature=0.3,
        damping=0.4,
        friction=0.5,
        slip_tolerance=0.01,
        stops=stops,
        servo_stiffness=10.0,
        servo_damping=1.0,
        target_position=0.6,
        target_velocity=0.7,
        torque=0.8,
        torque_limit=20.0,
    )
    assert (joint.name, joint.kind, joint.parent) == ("elbow", "revolute", "upper")
    assert np.array_equal(joint.axis, [0.0, 0.0, 1.0]) and joint.origin[2, 3] == 0.4
    numbers = [joint.position, joint.velocity, joint.armature, joint.damping, joint.friction, joint.slip_tolerance]
    assert numbers == [0.1, 0.2, 0.3, 0.4, 0.5, 0.01]
    assert [joint.servo_stiffness, joint.servo_damping, joint.target_position, joint.target_velocity] == [10.0, 1.0, 0.6, 0.7]
    assert (joint.torque, joint.torque_limit, joint.stops) == (0.8, 20.0, stops)
    assert (stops.range, stops.stiffness, stops.dissipation) == ((-1.0, 2.0), 100.0, 0.1)
    assert repr(joint) == 'Joint.revolute("elbow", [0.0, 0.0, 1.0], parent="upper")'
    assert repr(stops) == "Stops((-1.0, 2.0), 100.0, 0.1)"
    ball = he.Joint.ball("socket", rotation=he.pose(rotation_vector=[0.1, 0.2, 0.3])[:3, :3], angular_velocity=[1, 2, 3])
    assert ball.position is None and np.array_equal(ball.angular_velocity, [1.0, 2.0, 3.0])
    assert np.array_equal(ball.rotation, he.pose(rotation_vector=[0.1, 0.2, 0.3])[:3, :3])
    assert (repr(he.Joint.fixed("weld")), joint.rotation) == ('Joint.fixed("weld")', None)
    assert joint != ball and joint != he.Joint.revolute("elbow", [0, 0, 1], parent="upper")


def test_a_world_shows_its_joints(arm):
    assert [joint.name for joint in arm.joints] == ["socket", "elbow", "slide", "weld"]
    assert (arm.joint_names, arm.ball_joint_names) == (["elbow", "slide"], ["socket"])
    assert [arm.joint_index(name) for name in ("elbow", "slide", "socket")] == [0, 1, 0]
    assert [body.joint and body.joint.kind for body in arm.bodies] == [None, "ball", "revolute", "prismatic", "fixed"]
    assert 'Joint.revolute("elbow"' in repr(arm.bodies[2])


def test_states_have_joints(arm):
    state = arm.initial_state
    assert np.array_equal(state.joint_positions, [0.1, 0.0]) and np.array_equal(state.joint_velocities, [0.0, 0.0])
    assert np.array_equal(state.ball_joint_rotations, [np.eye(3)])
    assert np.array_equal(state.ball_joint_velocities, [[0.2, 0.1, 0.5]])
    (rotation, spin), elbow, _ = state.joints
    assert np.array_equal(rotation, np.eye(3)) and np.array_equal(spin, [0.2, 0.1, 0.5]) and elbow == (0.1, 0.0)
    assert repr(state) == "State(time=0.0 s, 5 bodies, 3 joints)"
    rebuilt = he.State(state.time, state.poses, state.twists, state.joints)
    for name in ARRAYS:
        assert np.array_equal(getattr(rebuilt, name), getattr(state, name))


def test_bodies_follow_changed_joints(arm):
    turned = he.pose(rotation_vector=[0.3, 0.0, 0.0])[:3, :3]
    moved = arm.state_with_joints({"elbow": 0.4, "socket": turned}, {"slide": 0.2, "socket": [0.0, 0.0, 1.0]})
    assert np.array_equal(moved.joint_positions, [0.4, 0.0]) and np.array_equal(moved.joint_velocities, [0.0, 0.2])
    assert np.array_equal(moved.ball_joint_rotations[0], turned)
    assert np.array_equal(moved.ball_joint_velocities[0], [0.0, 0.0, 1.0])
    relative = np.linalg.inv(moved.poses[1]) @ moved.poses[2]
    assert np.abs(relative - he.pose([0.0, 0.0, -0.3], [0.0, 0.4, 0.0])).max() < 1e-15
    # A rollout ignores the poses of bodies on joints.
    stale = he.State(0.0, arm.initial_state.poses, arm.initial_state.twists, moved.joints)
    ends = [arm.rollout(PLAN, start=start).run() for start in (moved, stale)]
    assert np.array_equal(ends[0].poses, ends[1].poses)
    again = arm.state_with_joints({"elbow": 0.1}, state=moved)
    assert np.array_equal(again.joint_positions, [0.1, 0.0]) and np.array_equal(again.joint_velocities, [0.0, 0.2])


def test_trajectories_have_joints(arm):
    trajectory = arm.rollout(PLAN).run()
    assert [getattr(trajectory, name).shape for name in ARRAYS[2:]] == [(5, 2), (5, 2), (5, 1, 3, 3), (5, 1, 3)]
    for record, state in enumerate(trajectory):
        for name in ARRAYS:
            assert np.array_equal(getattr(trajectory, name)[record], getattr(state, name))
    assert not trajectory.joint_positions.flags.writeable
    assert any(contact.bodies[0] == "hand" for contact in arm.contacts(trajectory[-1]))


def test_derivatives_are_those_of_differences(arm):
    assert arm.difference_check(STEADY, BY).best < DIFFERENCES


def test_a_pullback_is_a_product_with_the_jacobian(arm):
    trajectory, jacobian = arm.jacobian(PLAN, BY)
    recorded, vjp = arm.vjp(PLAN, BY)
    assert np.array_equal(recorded.joint_positions, trajectory.joint_positions)
    random = np.random.default_rng(1)
    by = {name: random.uniform(-1.0, 1.0, getattr(trajectory, name).shape) for name in ARRAYS}
    expected = sum(np.tensordot(by[name], getattr(jacobian, name), by[name].ndim) for name in ARRAYS)
    joints = {f"by_{name}": by[name] for name in ARRAYS[2:]}
    actual = vjp(by["poses"], by["twists"], **joints)
    assert np.abs(expected).min() > 0.0
    assert np.abs(actual - expected).max() <= SAME * np.abs(expected).max()
    batch = he.Batch(PLAN)
    (same,) = batch.vjps([arm], BY, *(by[name][None] for name in ARRAYS[:2]), **{name: of[None] for name, of in joints.items()})
    assert np.array_equal(same, actual)
    # Without derivatives with respect to joints, they are zero.
    assert not np.array_equal(vjp(by["poses"], by["twists"]), actual)


def test_a_linearized_arm_agrees_with_differences(arm):
    inputs = [he.Parameter.joint("slide", "torque"), he.Parameter.joint("elbow", "torque")]
    end, a, b = arm.linearize(STEADY, inputs)
    size = arm.tangent_dimension
    columns = [range(size)[arm.tangent_columns(name)] for name in ("floor", "upper", "lower", "wrist", "hand")]
    assert columns == [range(0), range(6), range(6, 8), range(8, 10), range(10, 10)]
    assert a.shape == (size, size) and b.shape == (size, 2)

    def slopes(changed, count, step):
        def column(index):
            ends = [changed(sign * step * np.eye(count)[index]).rollout(STEADY).run()[-1] for sign in (1.0, -1.0)]
            return (arm.difference(end, ends[0]) - arm.difference(end, ends[1])) / (2.0 * step)

        return np.stack([column(index) for index in range(count)], axis=1)

    by_start = slopes(lambda change: arm.replace(start=arm.integrate(arm.initial_state, change)), size, 1e-6)
    assert np.abs(by_start - a).max() < DIFFERENCES * np.abs(a).max()
    by_inputs = slopes(lambda change: arm.perturbed(inputs, change), 2, 1e-3)
    assert np.abs(by_inputs - b).max() < DIFFERENCES * np.abs(b).max()


def test_values_of_joint_parameters(arm):
    values = arm.values(BY)
    assert np.array_equal(values[:10], [0.0, 0.0, 0.0, -0.02, 0.0, 500.0, 5.0, 0.0, 0.0, 0.1])
    changed = arm.with_values(BY, values + 0.01)
    assert np.abs(changed.values(BY) - values - 0.01).max() < 1e-12
    perturbed = arm.perturbed([he.Parameter.joint("elbow", "initial_position")], [0.2])
    assert perturbed.initial_state.joint_positions[0] == pytest.approx(0.3)
    (body,) = (body for body in changed.bodies if body.name == "wrist")
    assert body.joint.servo_stiffness == pytest.approx(500.01) and body.joint.armature == pytest.approx(0.11)


def test_batches_have_joints(arm):
    samples = np.array([[0.0], [0.1]])
    by = [he.Parameter.joint("elbow", "initial_position")]
    for sample, result in zip(samples, he.Batch(PLAN).rollouts_perturbed(arm, by, samples)):
        single = arm.perturbed(by, sample).rollout(PLAN).run()
        assert np.array_equal(result.joint_positions, single.joint_positions)
    trajectory, jacobian = he.Batch(PLAN).jacobians_perturbed(arm, by, samples)[1]
    assert jacobian.joint_positions[0, 0, 0] == 1.0 and trajectory.joint_positions[0, 0] == pytest.approx(0.2)
    start = arm.state_with_joints({"elbow": 0.2})
    (result,) = he.Batch(PLAN).rollouts_from(arm, [start])
    assert np.array_equal(result.joint_positions, arm.rollout(PLAN, start=start).run().joint_positions)


def test_copies_keep_joints(arm):
    trajectory, jacobian = arm.jacobian(PLAN, BY)
    for again in (lambda value: pickle.loads(pickle.dumps(value)), copy.deepcopy):
        world, states, derivatives = (again(value) for value in (arm, trajectory, jacobian))
        assert world.joints == arm.joints and [joint for joint in map(again, arm.joints)] == arm.joints
        recorded = world.rollout(PLAN).run()
        for name in ARRAYS:
            assert np.array_equal(getattr(recorded, name), getattr(trajectory, name))
            assert np.array_equal(getattr(states, name), getattr(trajectory, name))
            assert np.array_equal(getattr(derivatives, name), getattr(jacobian, name))
        assert [again(body).joint for body in arm.bodies] == [body.joint for body in arm.bodies]
        assert he.World([again(body) for body in arm.bodies], gravity=-GRAVITY).joints == arm.joints
        assert [again(parameter) for parameter in BY] == BY
        assert again(he.Stops((0.0, 1.0), 2.0)) == he.Stops((0.0, 1.0), 2.0)
    assert repr(BY[0]) == 'Parameter.joint("slide", "initial_position")'


def test_wrong_joints_are_refused(arm):
    ball, skin, plan = he.Shape.icosphere(0.1, 1), he.Material(1e5), he.Plan(1e-3, 5)
    hinge = he.Joint.revolute("hinge", [0, 0, 1])
    state = arm.initial_state
    no_joints = he.State(0.0, state.poses, state.twists)
    unlike = he.State(0.0, state.poses, state.twists, [(0.0, 0.0)] * 3)
    _, vjp = arm.vjp(PLAN, BY)
    zero = [np.zeros((5, 5, 4, 4)), np.zeros((5, 5, 6))]
    cases = [
        (lambda: he.Joint.revolute("j", [0, 0, 0]), "the axis of a joint must not be zero"),
        (lambda: he.Joint.revolute("j", [0, 0, 1], damping=-1.0), 'the damping of joint "j" is -1, but must be not negative'),
        (lambda: he.Joint.revolute("j", [0, 0, 1], torque=np.inf), 'the torque of joint "j" is inf'),
        (lambda: he.Stops((1.0, 0.0), 1.0), "the largest position is 0, but must be at least the smallest position"),
        (lambda: he.Joint.ball("j", rotation=2.0 * np.eye(3)), "a rotation must be orthonormal"),
        (lambda: he.Body.dynamic("a", ball, skin, 1.0, pose=he.pose(), joint=hinge), 'body "a" is on a joint'),
        (lambda: he.World([he.Body.dynamic(name, ball, skin, 1.0, joint=hinge) for name in "ab"]), "two joints have the name"),
        (lambda: he.World([link("a", he.Joint.fixed("j", parent="b"))]), 'joint "j" connects body "a" to "b"'),
        (lambda: arm.rollout(plan).run(), 'explicit steps cannot integrate joints, but body "upper" has a joint: use Integrator.SDIRK3'),
        (lambda: arm.rollout(PLAN, start=no_joints), "the state has 0 joints, but the world has 3"),
        (lambda: arm.rollout(PLAN, start=unlike), 'the state of joint "socket" does not fit its kind'),
        (lambda: arm.state_with_joints({"weld": 0.1}), 'no joint with a position is named "weld"'),
        (lambda: arm.state_with_joints({"elbow": np.eye(3)}), 'the position of joint "elbow" must be a number'),
        (lambda: arm.state_with_joints({"socket": 2.0 * np.eye(3)}), 'the position of joint "socket": a rotation must be orthonormal'),
        (lambda: arm.state_with_joints(velocities={"socket": [1.0]}), r'the velocity of joint "socket" must have the shape \(3,\)'),
        (lambda: he.State(0.0, state.poses, state.twists, [(None, 0.0)]), "the position of a joint must be a number"),
        (lambda: arm.joint_index("knee"), 'no joint with a position is named "knee"'),
        (lambda: he.State(0.0, state.poses, state.twists, [(0.0,)]), "must be a position and a velocity"),
        (lambda: he.Trajectory([state, no_joints]), "the joints of state 1 of a trajectory differ"),
        (lambda: he.Parameter.joint("elbow", "color"), 'joints have no quantity "color": expected one of initial_position'),
        (lambda: arm.values([he.Parameter.joint("socket", "torque")]), 'no revolute or prismatic joint is named "socket"'),
        (lambda: arm.values([he.Parameter.initial_velocity("upper")]), 'a joint gives the state of body "upper"'),
        (lambda: vjp(*zero, by_joint_positions=np.zeros((5, 3))), r"by_joint_positions must have the shape \(5, 2\)"),
    ]
    for call, message in cases:
        with pytest.raises((he.HydroelasticError, TypeError), match=message):
            call()


@pytest.fixture
def jax():
    jax = pytest.importorskip("jax")
    before = jax.config.jax_enable_x64
    jax.config.update("jax_enable_x64", True)
    yield jax
    jax.config.update("jax_enable_x64", before)


def loss(jax, state):
    """A function of all numbers of a state."""
    weights = [jax.numpy.arange(1.0, 1.0 + array.size).reshape(array.shape) for array in state]
    return sum(jax.numpy.sin(array * weight).sum() for array, weight in zip(state, weights))


def test_jax_differentiates_with_respect_to_joint_parameters(arm, jax):
    hj, jnp = importlib.import_module("hydroelastic.jax"), jax.numpy
    by = [he.Parameter.joint("slide", "torque"), he.Parameter.joint("elbow", "initial_velocity")]
    _, jacobian = arm.jacobian(PLAN, by)
    by_states = jax.grad(lambda state: loss(jax, state))(hj.rollout(arm, PLAN, by))
    parts = [(np.asarray(one), getattr(jacobian, name)) for one, name in zip(by_states, ARRAYS)]
    expected = sum(np.tensordot(one, derivative, one.ndim) for one, derivative in parts)
    gradient = jax.jit(jax.grad(lambda x: loss(jax, hj.rollout(arm, PLAN, by, x))))(jnp.zeros(2))
    assert np.abs(gradient - expected).max() <= SAME * np.abs(expected).max()
    named = {"joints": {"slide": {"torque": 0.0}, "elbow": {"initial_velocity": 0.0}}}
    nested = jax.grad(lambda values: loss(jax, hj.rollout(arm, PLAN, values)))(named)["joints"]
    assert nested["slide"]["torque"] == gradient[0] and nested["elbow"]["initial_velocity"] == gradient[1]
    many = jax.vmap(lambda x: hj.final_state(arm, PLAN, by, x))(jnp.zeros((2, 2)))
    assert many.joint_positions.shape == (2, 2) and many.ball_joint_rotations.shape == (2, 1, 3, 3)


def test_jax_differentiates_with_respect_to_initial_joint_states(arm, jax):
    hj = importlib.import_module("hydroelastic.jax")
    start = hj.initial_state(arm)
    direction = np.random.default_rng(3).uniform(-1.0, 1.0, 10)

    def end(x):
        turned = hj.pose(rotation_vector=x * direction[:3])[:3, :3] @ start.ball_joint_rotations[0]
        moved = start._replace(
            joint_positions=start.joint_positions + x * direction[3:5],
            joint_velocities=start.joint_velocities + x * direction[5:7],
            ball_joint_rotations=turned[None],
            ball_joint_velocities=start.ball_joint_velocities + x * direction[7:],
        )
        return loss(jax, hj.final_state(arm, STEADY, start=moved))

    forward, reverse = jax.jvp(end, (0.0,), (1.0,))[1], jax.grad(end)(0.0)
    assert abs(forward - reverse) <= SAME * abs(forward)
    step = 1e-6
    assert abs((end(step) - end(-step)) / (2.0 * step) - forward) < DIFFERENCES * abs(forward)


def test_jax_sweeps_back_through_joints(arm, jax):
    hj = importlib.import_module("hydroelastic.jax")
    world = arm.replace(controls=[he.Control("hand", 1e-3, np.zeros((20, 6)))])
    by = he.Parameter.controls(["hand"], 20)
    states, vjp = world.vjp(STEADY, by)
    names = [f"by_{name}" for name in ARRAYS]
    by_states = jax.grad(lambda state: loss(jax, state))(hj.rollout(world, STEADY, by))
    expected = vjp(**{name: np.asarray(array) for name, array in zip(names, by_states)})
    gradient = jax.grad(lambda x: loss(jax, hj.rollout(world, STEADY, by, x)))(np.zeros(120))
    assert np.abs(gradient - expected).max() <= SAME * np.abs(expected).max() and len(states) == 11


def test_jax_scans_steps_with_joints(arm, jax):
    hj = importlib.import_module("hydroelastic.jax")
    start, one = hj.initial_state(arm), he.Plan(5e-3, 1, he.Integrator.IMPLICIT_EULER)
    last, _ = jax.lax.scan(lambda state, _: (hj.step(arm, one, state), None), start, None, length=2)
    assert jax.numpy.isfinite(last.joint_positions).all()
    with pytest.raises(he.HydroelasticError, match="start needs joint_positions"):
        hj.step(arm, one, hj.State(start.poses, start.twists))


def test_jax_differentiates_joints_that_mimic(jax):
    hj, jnp = importlib.import_module("hydroelastic.jax"), jax.numpy
    lead = link("lead", he.Joint.revolute("lead", [0, 1, 0], position=0.2))
    follow = link("follow", he.Joint.revolute("follow", [0, 1, 0], parent="lead", mimic=("lead", -2.0, 0.1)))
    world = he.World([lead, follow], gravity=-GRAVITY)
    start = hj.initial_state(world)

    def end(q):
        return hj.final_state(world, STEADY, start=start._replace(joint_positions=q)).joint_positions[0]

    slope = jax.jit(jax.grad(end))(start.joint_positions)[0]
    step = 1e-6
    assert abs((end(jnp.array([0.2 + step])) - end(jnp.array([0.2 - step]))) / (2.0 * step) - slope) < DIFFERENCES * abs(slope)
    with pytest.raises(he.HydroelasticError, match="finite"):
        end(jnp.array([jnp.nan]))
    with pytest.raises(TypeError, match="joints is float: expected"):
        hj.final_state(world, STEADY, {"joints": 1.0})
    with pytest.raises(TypeError, match=r"joints\['lead'\] is float: expected"):
        hj.final_state(world, STEADY, {"joints": {"lead": 1.0}})


def test_torch_differentiates_joints(arm):
    torch = pytest.importorskip("torch")
    ht = importlib.import_module("hydroelastic.torch")
    by = [he.Parameter.joint("slide", "torque"), he.Parameter.joint("elbow", "initial_velocity")]
    _, jacobian = arm.jacobian(PLAN, by)
    changes = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    ht.final_state(arm, PLAN, by, changes).joint_positions.sum().backward()
    expected = jacobian.joint_positions[-1].sum(0)
    assert np.abs(changes.grad.numpy() - expected).max() <= SAME * np.abs(expected).max()
    start = ht.initial_state(arm)
    velocities = start.joint_velocities.requires_grad_()
    ht.final_state(arm, PLAN, start=start).joint_positions.sum().backward()
    assert abs(velocities.grad[0] - expected[1]) <= SAME * abs(expected[1])
