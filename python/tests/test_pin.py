"""hydroelastic.pin: a Pinocchio model and a world of the same robot. Each program is the oracle of the other."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import hydroelastic as he

pinocchio = pytest.importorskip("pinocchio")

from hydroelastic.pin import Adapter  # noqa: E402

ROBOTS = Path(__file__).parents[2] / "tests" / "data" / "robots"
SKIN = he.Material(1e5, 0.3, 0.5)
GRAVITY = -9.81
# Difference of both programs, relative to the largest entry: the round-off of sums over a tree.
SAME = 1e-12
# Error of derivatives, relative to the largest entry. Central differences with steps of 1e-6 have a round-off of at
# least 1e-10.
DERIVATIVE = 1e-8
STEP = 1e-6

# A walker: a hip with a leg of three joints, a wheel, and a gripper with a mimicking finger. The sole is a second
# collision geometry. The hip has a center of mass that is not at its origin.
WALKER = """
<robot name="walker">
  <link name="hip"><inertial><origin xyz="0.02 -0.01 0.03" rpy="0.1 0.2 0.3"/><mass value="3"/>
    <inertia ixx="0.03" iyy="0.05" izz="0.04" ixy="0.002" ixz="0.001" iyz="0"/></inertial></link>
  <link name="thigh"><inertial><origin xyz="0 0 -0.1"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="shank"><inertial><origin xyz="0 0 -0.1"/><mass value="0.7"/>
    <inertia ixx="0.008" iyy="0.008" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0.01 -0.2"/><geometry><sphere radius="0.05"/></geometry></collision>
    <collision><origin xyz="0.06 0 -0.2" rpy="0.2 0.1 0.4"/><geometry><box size="0.06 0.06 0.1"/></geometry></collision></link>
  <link name="wheel"><inertial><mass value="0.4"/>
    <inertia ixx="1e-3" iyy="2e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.06"/></geometry></collision></link>
  <link name="left"><inertial><mass value="0.2"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="right"><inertial><mass value="0.2"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="swing" type="revolute"><parent link="hip"/><child link="thigh"/><origin xyz="0.05 0 -0.05" rpy="0.1 0 0.2"/>
    <axis xyz="0.3 1 0"/><limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
  <joint name="slide" type="prismatic"><parent link="thigh"/><child link="shank"/><origin xyz="0 0 -0.2"/><axis xyz="0 0.1 1"/>
    <limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
  <joint name="axle" type="continuous"><parent link="hip"/><child link="wheel"/><origin xyz="-0.15 0.02 -0.44"/><axis xyz="0 1 0"/></joint>
  <joint name="drive" type="prismatic"><parent link="hip"/><child link="left"/><origin xyz="0 0.05 0.1"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
  <joint name="follower" type="prismatic"><parent link="hip"/><child link="right"/><origin xyz="0 -0.05 0.1"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" effort="100" velocity="9"/><mimic joint="drive" multiplier="2" offset="0.01"/></joint>
</robot>"""


def walker(base, material=SKIN, prefix=""):
    """The walker in both programs, with a ground below it and a free ball beside its foot."""
    mechanism = he.Robot.parse(WALKER).mechanism(material, base=base, prefix=prefix)
    ground = he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid(0.4), pose=he.pose([0.0, 0.0, -0.49]))
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.06, 1), material, 0.3, pose=he.pose([0.04, 0.125, -0.45]), velocity=[0.1, 0.2, 0.0])
    world = he.World([ground, ball], mechanisms=[mechanism], gravity=GRAVITY, slip_tolerance=1e-2)
    root = [pinocchio.JointModelFreeFlyer()] if base == "free" else []
    return Adapter(world, pinocchio.buildModelFromXML(WALKER, *root), prefix)


def configuration(model, seed=1, size=0.1):
    """A configuration near the neutral one, at which the follower of the walker follows."""
    rng = np.random.default_rng(seed)
    v = rng.uniform(-1.0, 1.0, model.nv)
    q = pinocchio.integrate(model, pinocchio.neutral(model), size * rng.uniform(-1.0, 1.0, model.nv))
    if model.existJointName("follower"):
        drive, follower = (model.joints[model.getJointId(name)] for name in ("drive", "follower"))
        q[follower.idx_q], v[follower.idx_v] = 2.0 * q[drive.idx_q] + 0.01, 2.0 * v[drive.idx_v]
    return q, v


def deviation(actual, expected):
    assert actual.shape == expected.shape
    return np.abs(actual - expected).max() / np.abs(expected).max()


def drift(robot, q, v):
    """Returns Ṗ·u. Only free bodies have a nonzero part: −Rᵀ(ω × v_com)."""
    u, change = robot.world.kinetics(robot.state(q, v)).velocities, np.zeros(robot.model.nv)
    if robot.model.joints[1].shortname() == "JointModelFreeFlyer":
        root = robot.model.frames[2].name
        spin, velocity = np.split(u[robot.world.kinetics().columns(root)], 2)
        rotation = robot.state(q, v).poses[robot.world.index_of(root), :3, :3]
        change[:3] = -rotation.T @ np.cross(spin, velocity)
    return change


def assert_same_dynamics(robot, q, v):
    model, data = robot.model, robot.model.createData()
    state = robot.state(q, v)
    kinetics, to_model = robot.world.kinetics(state), robot.velocity_map(q)
    # Columns of the robot, without those of other free bodies.
    of_robot = np.flatnonzero(to_model.any(axis=0))
    to_model = to_model[:, of_robot]
    assert deviation(to_model @ kinetics.velocities[of_robot], v) < SAME
    upper = np.triu(pinocchio.crba(model, data, q))
    mass = upper + np.triu(upper, 1).T
    assert deviation(kinetics.mass_matrix[np.ix_(of_robot, of_robot)], to_model.T @ mass @ to_model) < SAME
    change = drift(robot, q, v)
    bias = to_model.T @ (pinocchio.nonLinearEffects(model, data, q, v) + mass @ change)
    assert deviation(kinetics.bias[of_robot], bias) < SAME
    gravity = to_model.T @ pinocchio.computeGeneralizedGravity(model, data, q)
    assert deviation(kinetics.gravity_bias[of_robot], gravity) < SAME
    accelerations = np.zeros(len(kinetics.velocities))
    accelerations[of_robot] = np.linspace(-2.0, 3.0, len(of_robot))
    forces = pinocchio.rnea(model, data, q, v, to_model @ accelerations[of_robot] + change)
    assert deviation(kinetics.inverse_dynamics(accelerations)[of_robot], to_model.T @ forces) < SAME
    for name in robot.world.names:
        if model.existFrame(name, pinocchio.FrameType.BODY):
            frame = model.getFrameId(name, pinocchio.FrameType.BODY)
            jacobian = pinocchio.computeFrameJacobian(model, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED) @ to_model
            if jacobian.any():
                assert deviation(kinetics.jacobian(name, [0.0, 0.0, 0.0])[:, of_robot], np.roll(jacobian, 3, axis=0)) < SAME


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_the_kinetics_of_a_world_agree_with_pinocchio(base):
    robot = walker(base)
    for seed in range(5):
        assert_same_dynamics(robot, *configuration(robot.model, seed, size=1.0))


@pytest.mark.parametrize(("name", "base"), [("panda", "fixed"), ("simple_humanoid", "fixed"), ("simple_humanoid", "free")])
def test_the_kinetics_of_published_robots_agree_with_pinocchio(name, base):
    path = ROBOTS / f"{name}.urdf"
    world = he.World.from_urdf(path, SKIN, base=base, meshes="none", gravity=GRAVITY)
    root = [pinocchio.JointModelFreeFlyer()] if base == "free" else []
    model = pinocchio.buildModelFromUrdf(str(path), *root)
    robot = Adapter(world, model)
    q, v = configuration(model, size=0.3)
    if name == "panda":
        # The second finger mimics the first.
        q[-1], v[-1] = q[-2], v[-2]
    assert_same_dynamics(robot, q, v)


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_states_are_converted_back(base):
    robot = walker(base)
    q, v = configuration(robot.model, size=1.0)
    state = robot.state(q, v)
    same_q, same_v = robot.q_and_v(state)
    assert np.abs(pinocchio.difference(robot.model, q, same_q)).max() < SAME and np.abs(v - same_v).max() < SAME
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, q)
    for name in ("hip", "shank", "wheel", "right"):
        placement = data.oMf[robot.model.getFrameId(name, pinocchio.FrameType.BODY)].homogeneous
        assert np.abs(state.poses[robot.world.index_of(name)] - placement).max() < SAME
    # The ball keeps its initial state, or that of ``start``.
    at = robot.world.index_of("ball")
    assert np.array_equal(state.twists[at], robot.world.initial_state.twists[at])
    later = robot.world.rollout(he.Plan(5e-3, 2, he.Integrator.IMPLICIT_EULER)).run()[-1]
    moved = robot.state(q, v, start=later)
    assert moved.time == later.time and np.abs(moved.poses[at] - later.poses[at]).max() < SAME


def test_ball_joints_are_spherical_joints():
    socket = he.Joint.ball("socket", origin=he.pose([0.1, 0.2, 0.3], [0.2, -0.1, 0.4]))
    inertia = np.array([[0.02, 0.001, 0.0], [0.001, 0.03, 0.002], [0.0, 0.002, 0.025]])
    body = he.Body.dynamic("arm", None, mass=1.5, center_of_mass=[0.1, -0.2, 0.05], inertia=inertia, joint=socket)
    model = pinocchio.Model()
    joint = model.addJoint(0, pinocchio.JointModelSpherical(), pinocchio.SE3(he.pose([0.1, 0.2, 0.3], [0.2, -0.1, 0.4])), "socket")
    model.appendBodyToJoint(joint, pinocchio.Inertia(1.5, np.array([0.1, -0.2, 0.05]), inertia), pinocchio.SE3.Identity())
    model.addBodyFrame("arm", joint, pinocchio.SE3.Identity(), 0)
    robot = Adapter(he.World([body], gravity=GRAVITY), model)
    q, v = configuration(model, size=1.0)
    assert_same_dynamics(robot, q, v)
    same_q, same_v = robot.q_and_v(robot.state(q, v))
    assert np.abs(pinocchio.difference(model, q, same_q)).max() < SAME and np.abs(v - same_v).max() < SAME


def slopes(function, count):
    """Computes central differences of a function of a vector at zero. Columns are the last axis."""
    actual = [(function(STEP * unit) - function(-STEP * unit)) / (2.0 * STEP) for unit in np.eye(count)]
    return np.stack(actual, axis=-1)


def fingers(model):
    """Velocities of the fingers, which touch nothing. States in which the second finger does not follow do not exist."""
    return [model.joints[model.getJointId(name)].idx_v for name in ("drive", "follower")]


def touching(base):
    """The walker with its wheel, foot and sole in contact with the ground and the ball."""
    robot = walker(base)
    q, v = configuration(robot.model, size=0.01)
    contacts = {frozenset(contact.bodies) for contact in robot.world.contacts(robot.state(q, v))}
    expected = [{"ground", "wheel"}, {"ground", "shank"}, {"ground", "shank/2"}, {"ball", "shank"}]
    assert contacts >= {frozenset(pair) for pair in expected}, contacts
    return robot, q, v


def contact_forces(robot, q, v):
    """Generalized forces of the contacts in the world."""
    state = robot.state(q, v)
    wrenches = {name: np.zeros(6) for name in robot.world.names}
    for contact in robot.world.contacts(state):
        for name, wrench in zip(contact.bodies, np.split(contact.wrench, 2), strict=True):
            wrenches[name] += wrench
    return robot.world.kinetics(state).generalized_forces(wrenches)


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_contact_torques_agree_with_the_world_and_with_differences(base):
    robot, q, v = touching(base)
    model, to_model = robot.model, robot.velocity_map(q)
    of_robot = np.flatnonzero(to_model.any(axis=0))
    tau, expected = robot.contact_torques(q, v), contact_forces(robot, q, v)[of_robot]
    assert np.abs(expected).max() > 1.0
    assert deviation(to_model[:, of_robot].T @ tau, expected) < SAME
    exact = robot.linearized_contact_torques(q, v)
    assert deviation(exact.tau, tau) < SAME
    free = np.delete(np.arange(model.nv), fingers(model))
    assert not exact.by_q[:, fingers(model)].any() and not exact.by_v[:, fingers(model)].any()

    def moved(change, of_q):
        whole = change @ np.eye(model.nv)[free]
        return robot.contact_torques(pinocchio.integrate(model, q, whole), v) if of_q else robot.contact_torques(q, v + whole)

    assert deviation(exact.by_q[:, free], slopes(lambda change: moved(change, True), len(free))) < DERIVATIVE
    assert deviation(exact.by_v[:, free], slopes(lambda change: moved(change, False), len(free))) < DERIVATIVE


def test_derivatives_of_elastic_contact_torques_are_symmetric():
    """Torques of elastic contact are the gradient of an energy with respect to the coordinates of a fixed base."""
    robot = walker("fixed", he.Material(1e5))
    q, v = configuration(robot.model, size=0.01)
    contact = robot.linearized_contact_torques(q, np.zeros_like(v))
    assert np.abs(contact.by_q).max() > 100.0
    assert deviation(contact.by_q, contact.by_q.T) < 1e-10
    free = np.delete(np.arange(robot.model.nv), fingers(robot.model))

    def energy(change):
        moved = robot.state(pinocchio.integrate(robot.model, q, change @ np.eye(robot.model.nv)[free]), np.zeros_like(v))
        return robot.world.diagnostics(moved).contact_energy

    assert deviation(contact.tau[free], -slopes(energy, len(free))) < DERIVATIVE


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_accelerations_in_contact_agree_with_the_world(base):
    robot, q, v = touching(base)
    acceleration = pinocchio.aba(robot.model, robot.model.createData(), q, v, robot.contact_torques(q, v))
    kinetics = robot.world.kinetics(robot.state(q, v))
    # In Pinocchio, the second finger moves by itself, so the coupled forward dynamics of the world do not apply.
    change = np.linalg.solve(kinetics.mass_matrix, contact_forces(robot, q, v) - kinetics.bias)
    # The mass matrix multiplies the round-off by its condition number.
    tolerance = SAME * np.linalg.cond(kinetics.mass_matrix)
    assert deviation(robot.velocity_map(q) @ change + drift(robot, q, v), acceleration) < tolerance


def test_robots_of_one_world_have_prefixes_and_adapters_are_pickled():
    robot = walker("free", prefix="a/")
    q, v = configuration(robot.model, size=0.05)
    plain = walker("free").contact_torques(q, v)
    assert np.abs(plain).max() > 1.0
    for same in (robot, pickle.loads(pickle.dumps(robot))):
        assert np.array_equal(same.contact_torques(q, v), plain)


def test_without_contact_there_are_no_torques():
    robot = walker("free")
    q, v = configuration(robot.model)
    q[2] += 1.0
    contact = robot.linearized_contact_torques(q, v)
    assert not contact.tau.any() and not contact.by_q.any() and not contact.by_v.any()


def test_wrong_arguments_are_refused():
    robot = walker("free")
    world, model = robot.world, robot.model
    q, v = configuration(model)
    other = pinocchio.buildModelFromXML(WALKER.replace('name="slide"', 'name="lift"'), pinocchio.JointModelFreeFlyer())
    moved = pinocchio.buildModelFromXML(WALKER.replace("0.05 0 -0.05", "0.06 0 -0.05"), pinocchio.JointModelFreeFlyer())
    planar = pinocchio.buildModelFromXML(WALKER, pinocchio.JointModelPlanar())
    mimic = pinocchio.buildModelFromXML(WALKER, pinocchio.JointModelFreeFlyer(), True)
    apart = q.copy()
    apart[model.joints[model.getJointId("follower")].idx_q] += 0.1
    cases = [
        (lambda: Adapter(model, world), TypeError, "world is Model: expected a hydroelastic.World"),
        (lambda: Adapter(world, world), TypeError, "model is World: expected a pinocchio.Model"),
        (lambda: Adapter(world, other), he.HydroelasticError, "no joint has the name of joint 'lift'"),
        (lambda: Adapter(world, model, "a/"), he.HydroelasticError, "prefix is 'a/'"),
        (lambda: Adapter(world, moved), he.HydroelasticError, "body 'thigh' has a different"),
        (lambda: Adapter(world, planar), he.HydroelasticError, "no joint has the name of joint 'root_joint'"),
        (lambda: Adapter(world, mimic), he.HydroelasticError, "mimic=False"),
        (lambda: Adapter(walker("fixed").world, model), he.HydroelasticError, "no free body has the frame of joint 'root_joint'"),
        (lambda: robot.state(q[:3], v), he.HydroelasticError, r"q has shape \(3,\): expected \(13,\)"),
        (lambda: robot.state(q, np.full_like(v, np.nan)), he.HydroelasticError, "v must be finite, but number 0"),
        (lambda: robot.state(q.astype(np.float32), v), TypeError, "q is float32"),
        (lambda: robot.state(2.0 * q, v), he.HydroelasticError, "not normalized"),
        (lambda: robot.state(apart, v), he.HydroelasticError, "joint 'follower' mimics"),
        (lambda: robot.state(q, v, start=he.State(0.0, np.eye(4)[None], np.zeros((1, 6)))), he.HydroelasticError, "start has 1 bodies"),
        (lambda: robot.contact_torques(q, v, start=q), TypeError, "start is ndarray: expected a hydroelastic.State"),
        (lambda: robot.q_and_v(he.State(0.0, np.eye(4)[None], np.zeros((1, 6)))), he.HydroelasticError, "1"),
    ]
    for call, kind, message in cases:
        with pytest.raises(kind, match=message):
            call()
