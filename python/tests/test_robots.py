"""Robots from URDF, their actuators, and the equations of motion."""

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

ROBOTS = Path(__file__).parents[2] / "tests" / "data" / "robots"
GRAVITY = 9.81
# Round-off of sums of a few products.
ROUND_OFF = 1e-9
# Error of steps of 5 ms at the default tolerances (rad or m).
MOTION = 1e-5
# Error of central differences with a step of 1e-6, relative to the largest derivative.
DIFFERENCES = 1e-6
SKIN = he.Material(1e6, 0.5, 0.5)

# Two links, each with a point mass at its end, 0.4 m from its joint.
ARM = """
<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.4 0 0"/><mass value="2"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.4 0 0"/><mass value="0.5"/>
    <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint>
</robot>
"""
GRIPPER = """
<robot name="gripper">
  <link name="palm"/>
  <link name="left"><inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.02 0.02 0.04"/></geometry></collision></link>
  <link name="right"><inertial><mass value="0.3"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.02 0.02 0.04"/></geometry></collision></link>
  <joint name="drive" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0 0.05 0"/><axis xyz="0 1 0"/>
    <limit lower="-0.04" upper="0.01" effort="40" velocity="1"/></joint>
  <joint name="follower" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0 -0.05 0"/><axis xyz="0 -1 0"/>
    <limit lower="-0.04" upper="0.01" effort="40" velocity="1"/><mimic joint="drive" multiplier="1" offset="0"/></joint>
</robot>
"""


def again(value):
    return pickle.loads(pickle.dumps(value))


def arm(**shoulder):
    mechanism = he.Robot.parse(ARM).mechanism(SKIN)
    return mechanism.with_joint("shoulder", **shoulder) if shoulder else mechanism


@pytest.fixture
def world():
    return he.World([], mechanisms=[arm()], gravity=-GRAVITY)


def test_a_file_becomes_bodies_and_joints(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    robot = he.Robot.read(path)
    assert robot.name == "arm" and robot.warnings == []
    assert robot.link_names == ["base", "upper", "lower"] and robot.joint_names == ["shoulder", "elbow"]
    mechanism = robot.mechanism(SKIN, prefix="a/")
    assert [body.name for body in mechanism.bodies] == ["a/base", "a/upper", "a/lower"]
    assert all(body.shape is None for body in mechanism.bodies)
    assert [body.mass for body in mechanism.bodies] == [None, 2.0, 0.5]
    assert mechanism.joint_names == ["a/shoulder", "a/elbow"]
    assert mechanism.joints[1].parent == "a/upper" and mechanism.joints[1].kind == "revolute"
    assert "a/shoulder" in repr(mechanism) and "arm" in repr(robot)


def test_published_robots_are_read():
    panda = he.Robot.read(ROBOTS / "panda.urdf")
    mechanism = panda.mechanism(SKIN, meshes="none", pose=he.pose([0.0, 0.0, 0.5]))
    world = he.World([], mechanisms=[mechanism], gravity=-GRAVITY)
    # The second finger mimics the first.
    assert world.joint_names == [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1"]
    fingers = {joint.name: joint for joint in world.joints}
    assert fingers["panda_finger_joint2"].mimic == ("panda_finger_joint1", 1.0, 0.0)
    assert fingers["panda_joint1"].torque_limit == 87.0 and fingers["panda_joint1"].stops.stiffness == 1e3
    # In the equations of motion, both fingers have a velocity.
    assert world.kinetics().mass_matrix.shape == (9, 9)
    humanoid = he.Robot.read(ROBOTS / "simple_humanoid.urdf")
    free = he.World([], mechanisms=[humanoid.mechanism(SKIN, base="free", meshes="none")])
    assert free.kinetics().columns(free.names[0]) == slice(0, 6, 1)


def test_errors_say_what_is_wrong(tmp_path):
    with pytest.raises(FileNotFoundError, match="nothing.urdf"):
        he.Robot.read(tmp_path / "nothing.urdf")
    with pytest.raises(he.HydroelasticError, match="world"):
        he.Robot.parse("<world/>")
    robot = he.Robot.parse(ARM)
    with pytest.raises(he.HydroelasticError, match='base must be "fixed", "free" or a Joint'):
        robot.mechanism(SKIN, base="floating")
    with pytest.raises(he.HydroelasticError, match="leave out pose"):
        robot.mechanism(SKIN, base=he.Joint.fixed("mount"), pose=he.pose())
    with pytest.raises(he.HydroelasticError, match="meshes must be"):
        robot.mechanism(SKIN, meshes="convex")
    with pytest.raises(he.HydroelasticError, match='no link is named "hand"'):
        robot.mechanism(SKIN, materials={"hand": SKIN})
    with pytest.raises(he.HydroelasticError, match='no joint is named "wrist"'):
        arm().with_joint("wrist", torque=1.0)
    with pytest.raises(he.HydroelasticError, match="stiffness of the servo"):
        arm(servo_stiffness=-1.0)
    with pytest.raises(he.HydroelasticError, match="interval"):
        he.Joint.revolute("hinge", [0, 0, 1], torques=(0.0, [1.0]))
    with pytest.raises(he.HydroelasticError, match="no material"):
        he.Body.fixed("floor", he.HalfSpace())
    with pytest.raises(he.HydroelasticError, match="needs the index"):
        he.Parameter.joint("elbow", "scheduled_torque")
    with pytest.raises(he.HydroelasticError, match="has no index"):
        he.Parameter.joint("elbow", "torque", 1)
    two = [arm(), arm()]
    with pytest.raises(he.HydroelasticError, match="base"):
        he.World([], mechanisms=two)


LEADER = 'mimic must be the name of a leader, a multiplier and an offset, but '
STOPS = "the law of stops must be a stiffness and a dissipation, or None, but "


def test_arguments_of_wrong_form_say_what_is_expected(tmp_path):
    path = tmp_path / "gripper.urdf"
    path.write_text(GRIPPER)
    gripper = he.Robot.parse(GRIPPER)

    def hinge(**numbers):
        return he.Joint.revolute("hinge", [0, 0, 1], **numbers)

    def servos(servo):
        return he.World.from_urdf(path, SKIN, servos={"drive": servo})

    cases = [
        (lambda: servos((1.0, 2.0, 3.0)), he.HydroelasticError, 'the servo of joint "drive" must be a stiffness and a damping, but has 3 parts'),
        (lambda: servos(1.0), TypeError, "must be a stiffness and a damping, but is <class 'float'>"),
        (lambda: servos("ab"), TypeError, "must be a stiffness and a damping, but is <class 'str'>"),
        (lambda: servos((None, 1.0)), TypeError, 'the stiffness of the servo of joint "drive" must be a number, but is'),
        (lambda: servos((np.nan, 1.0)), he.HydroelasticError, "is NaN, but must be not negative and finite"),
        (lambda: gripper.mechanism(SKIN, revolute_stops=(1.0,)), he.HydroelasticError, STOPS + "has 1 parts"),
        (lambda: gripper.mechanism(SKIN, revolute_stops=3.0), TypeError, STOPS + "is"),
        # The gripper has no revolute joints, but the numbers are checked.
        (lambda: gripper.mechanism(SKIN, revolute_stops=(np.nan, 1.0)), he.HydroelasticError, "the stiffness of stops is NaN"),
        (lambda: gripper.mechanism(SKIN, prismatic_stops=(1.0, -1.0)), he.HydroelasticError, "the dissipation of stops is -1"),
        (lambda: gripper.mechanism(SKIN, pose=[0.0, 0.0, 1.0]), he.HydroelasticError, r"pose must have the shape \(4, 4\), but has \(3,\)"),
        (lambda: hinge(torques=(0.1,)), he.HydroelasticError, "a schedule must be an interval and its values, but has 1 parts"),
        (lambda: hinge(targets=3.0), TypeError, "a schedule must be an interval and its values, but is"),
        (lambda: hinge(mimic=("lead",)), he.HydroelasticError, LEADER + "has 1 parts"),
        (lambda: hinge(mimic="lead"), TypeError, LEADER + "is"),
        (lambda: hinge(mimic=("lead", 1.0, 0.0), position=0.1), he.HydroelasticError, 'joint "hinge" mimics "lead", which gives its position'),
        (
            lambda: gripper.mechanism(SKIN).with_joint("follower", position=0.1),
            he.HydroelasticError,
            'joint "follower" mimics "drive", which gives its position and velocity',
        ),
        (lambda: he.Mechanism([], ignoring=[("a", "b", "c")]), he.HydroelasticError, "must be two names of bodies, but has 3 parts"),
        (lambda: he.World([], ignoring=["ab"]), TypeError, "must be two names of bodies, but is <class 'str'>"),
        (lambda: he.Body.dynamic("a", None, density=1.0), he.HydroelasticError, "a body without a shape has no volume"),
    ]
    for call, kind, message in cases:
        with pytest.raises(kind, match=message):
            call()
    # Lists and arrays have parts too.
    for servo in ([5.0, 2.0], np.array([5.0, 2.0])):
        assert servos(servo).joints[0].servo_stiffness == 5.0


def test_terms_beyond_the_range_of_floats_are_errors(world):
    kinetics = world.kinetics()
    fast = world.kinetics(world.state_with_joints(velocities={"shoulder": 1e160, "elbow": 1e160}))
    for call in (
        lambda: fast.bias,
        lambda: fast.bias_acceleration("lower", [0.4, 0.0, 0.0]),
        lambda: kinetics.inverse_dynamics_derivatives([1e308, 1e308]),
        lambda: kinetics.generalized_forces({"lower": np.full(6, 1e308), "upper": np.full(6, 1e308)}),
    ):
        with pytest.raises(he.HydroelasticError, match="finite"):
            call()


def test_gravity_bias_holds_the_arm(world):
    kinetics = world.kinetics()
    torques = kinetics.inverse_dynamics([0.0, 0.0])
    # A positive torque about y would lower the arm.
    expected = -GRAVITY * np.array([2.0 * 0.4 + 0.5 * 0.8, 0.5 * 0.4])
    assert np.abs(torques - expected).max() < ROUND_OFF
    assert np.abs(kinetics.gravity_bias - expected).max() < ROUND_OFF
    held = arm(torque=torques[0]).with_joint("elbow", torque=torques[1])
    held = he.World([], mechanisms=[held], gravity=-GRAVITY)
    assert np.abs(held.kinetics().joint_forces - expected).max() < ROUND_OFF
    trajectory = held.rollout(he.Plan(1e-2, 50, he.Integrator.SDIRK3)).run()
    assert np.abs(trajectory.joint_positions).max() < ROUND_OFF


def test_the_mass_matrix_has_its_closed_form(world):
    for elbow in (0.0, 0.7, -2.0):
        kinetics = world.kinetics(world.state_with_joints({"elbow": elbow}))
        square = 0.4**2
        coupling = 0.5 * square * np.cos(elbow)
        expected = [[2.5 * square + 0.5 * square + 2.0 * coupling, 0.5 * square + coupling], [0.5 * square + coupling, 0.5 * square]]
        assert np.abs(kinetics.mass_matrix - expected).max() < ROUND_OFF


def test_dynamics_are_inverse_and_have_derivatives(world):
    def at(positions, velocities):
        names = world.joint_names
        return world.kinetics(world.state_with_joints(dict(zip(names, positions)), dict(zip(names, velocities))))

    q, u, accelerations = np.array([0.3, 0.9]), np.array([0.5, -1.2]), np.array([2.0, -1.0])
    kinetics = at(q, u)
    assert np.array_equal(kinetics.velocities, u)
    forces = kinetics.inverse_dynamics(accelerations)
    assert np.abs(forces - kinetics.mass_matrix @ accelerations - kinetics.bias).max() < ROUND_OFF
    assert np.abs(kinetics.forward_dynamics(forces) - accelerations).max() < ROUND_OFF
    derivatives = kinetics.inverse_dynamics_derivatives(accelerations)
    forward = kinetics.forward_dynamics_derivatives(forces)
    assert np.abs(forward[2] @ kinetics.mass_matrix - np.eye(2)).max() < ROUND_OFF
    for which, step in enumerate(1e-6 * np.eye(2)):
        moved = [(at(q + sign * step, u), at(q, u + sign * step)) for sign in (1.0, -1.0)]
        for by in (0, 1):
            slopes = [sides[by].inverse_dynamics(accelerations) for sides in moved]
            error = derivatives[by][:, which] - (slopes[0] - slopes[1]) / 2e-6
            assert np.abs(error).max() < DIFFERENCES * np.abs(derivatives[by]).max()
            slopes = [sides[by].forward_dynamics(forces) for sides in moved]
            error = forward[by][:, which] - (slopes[0] - slopes[1]) / 2e-6
            assert np.abs(error).max() < DIFFERENCES * np.abs(forward[by]).max()


def test_jacobians_give_velocities_and_forces(world):
    kinetics = world.kinetics(world.state_with_joints({"shoulder": 0.2, "elbow": 0.5}))
    jacobian = kinetics.jacobian("lower", [0.4, 0.0, 0.0])
    angles = np.array([0.2, 0.7])
    # A rotation about y by a moves the x axis to (cos a, 0, −sin a).
    along = -0.4 * np.stack([np.sin(angles), 0.0 * angles, np.cos(angles)])
    expected = np.stack([along.sum(axis=1), along[:, 1]], axis=1)
    assert np.abs(jacobian[3:] - expected).max() < ROUND_OFF
    assert np.abs(jacobian[:3] - [[0, 0], [1, 1], [0, 0]]).max() < ROUND_OFF
    force = np.array([1.0, 2.0, -3.0])
    wrench = np.concatenate([np.cross(world.state_with_joints({"shoulder": 0.2, "elbow": 0.5}).poses[2, :3, 0] * 0.4, force), force])
    generalized = kinetics.generalized_forces({"lower": wrench})
    assert np.abs(generalized - jacobian[3:].T @ force).max() < ROUND_OFF
    assert np.abs(kinetics.bias_acceleration("lower", [0.4, 0.0, 0.0])).max() == 0.0
    assert kinetics.columns("lower") == slice(1, 2, 1) and kinetics.columns("base") == slice(0, 0, 1)
    with pytest.raises(he.HydroelasticError, match='no body is named "hand"'):
        kinetics.columns("hand")


def test_coupled_fingers_move_as_one():
    gripper = he.Robot.parse(GRIPPER).mechanism(SKIN)
    closing = gripper.with_joint("drive", torque=-1.0)
    world = he.World([], mechanisms=[closing])
    assert world.joint_names == ["drive"]
    # The force moves both masses. The velocity of the follower is that of the drive.
    coupling = np.ones((2, 1))
    assert abs(coupling.T @ world.kinetics().mass_matrix @ coupling - 0.5).max() < ROUND_OFF
    trajectory = world.rollout(he.Plan(5e-3, 20, he.Integrator.SDIRK3)).run()
    expected = -0.5 * (1.0 / 0.5) * trajectory.times**2
    assert np.abs(trajectory.joint_positions[:, 0] - expected).max() < MOTION
    left, right = trajectory.poses[:, 1, 1, 3], trajectory.poses[:, 2, 1, 3]
    assert np.abs(left + right).max() < ROUND_OFF


def test_scheduled_torques_and_targets_are_parameters():
    slide = he.Joint.prismatic("slide", [1, 0, 0], torques=(0.1, [2.0, -1.0]))
    world = he.World([he.Body.dynamic("mass", None, mass=2.0, joint=slide)])
    plan = he.Plan(1e-2, 20, he.Integrator.IMPLICIT_EULER, solver_tolerance=1e-13)
    by = [he.Parameter.joint("slide", "scheduled_torque", index) for index in (0, 1)]
    trajectory, jacobian = world.jacobian(plan, by)
    # Each force acts on 2 kg during 0.1 s.
    assert abs(trajectory.joint_velocities[-1, 0] - 0.05) < ROUND_OFF
    assert np.abs(jacobian.joint_velocities[-1, 0] - 0.05).max() < ROUND_OFF
    servo = he.Joint.prismatic("slide", [1, 0, 0], servo_stiffness=1e5, servo_damping=1e3, targets=(0.1, [0.0, 0.01, 0.03]))
    world = he.World([he.Body.dynamic("mass", None, mass=2.0, joint=servo)])
    by = [he.Parameter.joint("slide", "scheduled_target", index) for index in range(3)]
    trajectory, jacobian = world.jacobian(he.Plan(1e-2, 40, he.Integrator.SDIRK3), by)
    assert abs(trajectory.joint_positions[-1, 0] - 0.03) < MOTION
    assert np.abs(jacobian.joint_positions[-1, 0] - [0.0, 0.0, 1.0]).max() < 1e-3
    assert repr(by[1]) == "Parameter.joint('slide', \"scheduled_target\", 1)".replace("'", '"')
    assert by[1] != by[2] and again(by[1]) == by[1]


def test_joints_keep_their_schedules():
    joint = he.Joint.revolute("hinge", [0, 0, 1], torques=(0.1, [1.0, 2.0]), targets=(0.2, [3.0]), mimic=("other", 2.0, 0.5))
    for copied in (joint, again(joint), copy.deepcopy(joint)):
        assert copied == joint and repr(copied) == repr(joint)
        assert copied.torques[0] == 0.1 and copied.torques[1].tolist() == [1.0, 2.0]
        assert copied.targets[0] == 0.2 and copied.targets[1].tolist() == [3.0]
        assert copied.mimic == ("other", 2.0, 0.5) and copied.position is None
    assert joint != he.Joint.revolute("hinge", [0, 0, 1], torques=(0.1, [1.0, 2.5]), targets=(0.2, [3.0]), mimic=("other", 2.0, 0.5))
    free = he.Joint.revolute("hinge", [0, 0, 1])
    assert free.torques is None and free.targets is None and free.mimic is None


def test_settings_of_a_joint_that_are_not_named_stay():
    changed = arm(servo_stiffness=50.0, damping=0.3).with_joint("shoulder", servo_damping=5.0, position=0.4)
    joint = changed.joints[0]
    assert (joint.servo_stiffness, joint.servo_damping, joint.damping, joint.position) == (50.0, 5.0, 0.3, 0.4)


def test_mechanisms_are_pickled():
    gripper = he.Robot.parse(GRIPPER).mechanism(SKIN, base="free", pose=he.pose([0.0, 0.0, 1.0]))
    loaded = again(gripper)
    assert repr(loaded) == repr(gripper) and loaded.ignored == gripper.ignored == [("left", "right")]
    for one, other in zip(gripper.bodies, loaded.bodies, strict=True):
        assert one.joint == other.joint and one.mass == other.mass and np.array_equal(one.pose, other.pose)
    worlds = [he.World([], mechanisms=[mechanism], gravity=-GRAVITY) for mechanism in (gripper, loaded)]
    plan = he.Plan(5e-3, 10, he.Integrator.SDIRK3)
    ends = [each.rollout(plan).run()[-1] for each in (*worlds, again(worlds[0]))]
    assert all(np.array_equal(end.poses, ends[0].poses) for end in ends)


def test_a_world_of_one_robot(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(ARM)
    floor = he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid())
    servos = {"shoulder": (500.0, 50.0), "elbow": (100.0, 10.0)}
    world = he.World.from_urdf(path, SKIN, pose=he.pose([0.0, 0.0, 1.0]), servos=servos, bodies=[floor], gravity=-GRAVITY)
    assert world.names == ["floor", "base", "upper", "lower"] and world.initial_state.poses[1, 2, 3] == 1.0
    assert [(joint.servo_stiffness, joint.servo_damping) for joint in world.joints] == list(servos.values())
    with pytest.raises(he.HydroelasticError, match='no joint is named "wrist"'):
        he.World.from_urdf(path, SKIN, servos={"wrist": (1.0, 1.0)})


def test_a_base_may_be_on_a_joint():
    rail = he.Joint.prismatic("rail", [1, 0, 0], parent="table")
    table = he.Body.fixed("table", None, pose=he.pose([0.0, 0.0, 1.0]))
    world = he.World([table], mechanisms=[he.Robot.parse(ARM).mechanism(SKIN, base=rail)])
    assert world.joint_names == ["rail", "shoulder", "elbow"]
    assert world.initial_state.poses[1, 2, 3] == 1.0
    assert abs(world.kinetics().mass_matrix[0, 0] - 2.5) < ROUND_OFF
