"""hydroelastic.mujoco: contacts as passive forces. The world of the library, momentum and energy are the oracles."""

import threading

import numpy as np
import pytest

import hydroelastic as he

mujoco = pytest.importorskip("mujoco")

from hydroelastic import mujoco as soft  # noqa: E402

SKIN = he.Material(1e5, 0.2, 0.4)
SLIP = 1e-2
# Deviation of positions (m), velocities (m/s) and rotations from those of a world: the round-off of 1,000 steps of the
# same scheme.
WORLD = 1e-12
DROP = """
<mujoco>
  <option timestep="1e-4" gravity="0 0 -9.81" integrator="Euler"/>
  <worldbody>
    <geom name="block" type="box" size="1 1 .1"/>
    <body name="ball" pos=".01 .02 .21">
      <freejoint/>
      <geom name="ball" type="sphere" size=".1" mass="1"/>
      <site name="inside" pos=".01 .02 .03"/>
    </body>
  </worldbody>
  {more}
</mujoco>
"""
BLOCK = '<geom name="block" type="box" size="1 1 .1"/>'
PLANE = '<geom name="block" type="plane" pos="0 0 .1" size="1 1 1"/>'
EXCLUDE = '<contact><exclude body1="world" body2="ball"/></contact>'


@pytest.fixture(autouse=True)
def the_callback_is_cleared(monkeypatch, tmp_path):
    # MuJoCo writes its warnings to a file in the working directory.
    monkeypatch.chdir(tmp_path)
    assert mujoco.get_mjcb_passive() is None
    yield
    assert mujoco.get_mjcb_passive() is None


def ball_pair(law=None, order=2):
    law = SKIN.combined_with(SKIN, SLIP) if law is None else law
    return he.Pair(he.Shape.icosphere(0.1, order), he.Shape.cuboid([2.0, 2.0, 0.2]), 1e5, 1e5, law)


def drop(more=EXCLUDE, pair=None, ground=BLOCK, **keywords):
    model = mujoco.MjModel.from_xml_string(DROP.format(more=more).replace(BLOCK, ground))
    pair = pair or ball_pair(**keywords)
    return model, soft.PassiveContacts(model, [soft.ContactPair(pair, soft.geom("ball"), soft.geom("block"))])


def stepped(model, contacts, steps, velocity=(0.0,) * 6):
    data = mujoco.MjData(model)
    data.qvel[:] = velocity
    with contacts:
        mujoco.mj_step(model, data, steps)
    return data


def grounds():
    """Grounds that a ball is dropped on: geom, shape, material and pose."""
    hard = he.Material.rigid(0.6)
    slab = he.RigidShape.around(he.Shape.cuboid([2.0, 2.0, 0.2]))
    return {
        "soft block": (BLOCK, he.Shape.cuboid([2.0, 2.0, 0.2]), SKIN, he.pose()),
        "rigid block": (BLOCK, slab, hard, he.pose()),
        "plane": (PLANE, he.HalfSpace(), hard, he.pose([0.0, 0.0, 0.1])),
        "soft plane": (PLANE, he.HalfSpace(0.1), SKIN, he.pose([0.0, 0.0, 0.1])),
    }


@pytest.mark.parametrize("name", grounds())
def test_a_dropped_ball_agrees_with_a_world(name):
    """Compares a bounce with friction and spin. Both programs take symplectic Euler steps of the same length."""
    ground, shape, material, pose = grounds()[name]
    law = SKIN.combined_with(material, SLIP)
    pair = he.Pair(he.Shape.icosphere(0.1, 2), shape, SKIN.modulus, material.modulus, law)
    model, contacts = drop(pair=pair, ground=ground)
    velocity, spin, steps = [0.5, 0.1, -0.3], [0.5, -1.0, 2.0], 1000
    data = stepped(model, contacts, steps, [*velocity, *spin])
    pair = contacts.contacts[0].pair
    ball = he.Body.dynamic(
        "ball",
        pair.shapes[0],
        SKIN,
        1.0,
        center_of_mass=[0.0, 0.0, 0.0],
        inertia=np.diag(model.body_inertia[1]),
        pose=he.pose([0.01, 0.02, 0.21]),
        velocity=velocity,
        angular_velocity=spin,
    )
    floor = he.Body.fixed("floor", pair.shapes[1], material, pose=pose)
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=SLIP)
    end = world.rollout(he.Plan(1e-4, steps, he.Integrator.SYMPLECTIC_EULER, record_every=steps)).run()
    mujoco.mj_kinematics(model, data)
    # The ball has bounced, so it moves up.
    assert data.qvel[2] > 0.1
    assert np.abs(data.qpos[:3] - end.poses[-1, 0, :3, 3]).max() < WORLD
    assert np.abs(data.xmat[1].reshape(3, 3) - end.poses[-1, 0, :3, :3]).max() < WORLD
    assert np.abs(data.qvel[:3] - end.twists[-1, 0, 3:]).max() < WORLD


def two_balls(law, kind="Euler"):
    xml = f"""
    <mujoco>
      <option timestep="1e-4" gravity="0 0 0" integrator="{kind}"><flag contact="disable"/></option>
      <worldbody>
        <body name="first" pos="-.11 0 0"><freejoint/><geom type="sphere" size=".1" mass="1"/></body>
        <body name="second" pos=".1 .03 .02"><freejoint/><geom type="sphere" size=".1" mass="2"/></body>
      </worldbody>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    shape = he.Shape.icosphere(0.1, 2)
    offset = he.pose([0.003, -0.002, 0.001], [0.2, 0.1, 0.3])
    pair = soft.ContactPair(he.Pair(shape, shape, 1e5, 2e5, law), soft.body("first", offset), soft.body("second"))
    return model, soft.PassiveContacts(model, [pair])


def momentum(model, data):
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    return np.r_[data.subtree_linvel[0] * model.body_subtreemass[0], data.subtree_angmom[0]]


def energy(model, data, contacts):
    mujoco.mj_forward(model, data)
    moved = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, moved, data.qvel)
    return 0.5 * data.qvel @ moved + contacts.potential_energy(data)


def test_a_collision_keeps_momentum():
    model, contacts = two_balls(he.SurfaceLaw(0.3, 0.5, SLIP))
    velocity = np.r_[1.0, 0.1, 0.0, 0.5, 1.0, -0.5, -0.5, np.zeros(5)]
    data = mujoco.MjData(model)
    data.qvel[:] = velocity
    before = momentum(model, data)
    end = stepped(model, contacts, 600, velocity)
    assert np.abs(end.qvel[:3] - velocity[:3]).max() > 0.1
    after = momentum(model, end)
    # The angular momentum is about the common center of mass.
    assert np.abs(after - before).max() < 1e-12


def test_a_collision_keeps_energy_without_dissipation_and_friction():
    velocity = np.r_[1.0, np.zeros(5), -0.5, np.zeros(5)]
    gains = []
    for time_step in (1e-4, 5e-5):
        model, contacts = two_balls(he.SurfaceLaw())
        model.opt.timestep = time_step
        data = mujoco.MjData(model)
        data.qvel[:] = velocity
        before, gain, lowest = energy(model, data, contacts), 0.0, np.inf
        with contacts:
            for _ in range(12):
                mujoco.mj_step(model, data, round(5e-3 / time_step))
                gain = max(gain, abs(energy(model, data, contacts) - before))
                lowest = min(lowest, before - contacts.potential_energy(data))
        # The contact stored a large part of the energy.
        assert lowest < 0.9 * before
        gains.append(gain / before)
    # The scheme is of first order in the step.
    assert gains[0] < 5e-3 and gains[1] < 0.6 * gains[0], gains


def test_transition_differences_see_the_contact():
    model, contacts = drop()
    data = stepped(model, contacts, 200, [0.5, 0.0, -0.5, 0.0, 0.0, 0.0])
    size = 2 * model.nv
    with contacts:
        mujoco.mj_forward(model, data)
        assert contacts.wrenches(data).any()
        a = np.zeros((size, size))
        mujoco.mjd_transitionFD(model, data, 1e-6, True, a, None, None, None)
    without = np.zeros((size, size))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, without, None, None, None)
    # Derivative of the new upward velocity with respect to the height, from the stiffness in closed form.
    (pose_a, pose_b), time_step = contacts.poses(data)[0], model.opt.timestep
    twist = np.r_[data.xmat[1].reshape(3, 3) @ data.qvel[3:], data.qvel[:3]]
    _, jacobian = contacts.contacts[0].pair.linearized(pose_a, pose_b, twist)
    assert without[8, 2] == pytest.approx(0.0, abs=1e-9)
    assert a[8, 2] == pytest.approx(time_step * jacobian[5, 5], rel=1e-5)
    assert a[8, 8] == pytest.approx(1.0 + time_step * jacobian[5, 17], rel=1e-7)
    assert jacobian[5, 5] < -100.0


def test_generalized_forces_are_the_jacobian_transposed():
    model, contacts = two_balls(he.SurfaceLaw(0.3, 0.5, SLIP))
    data = mujoco.MjData(model)
    data.qpos[0] = -0.08
    data.qvel[:] = 0.1 * np.arange(12)
    mujoco.mj_forward(model, data)
    (pose_a, pose_b), wrenches = contacts.poses(data)[0], contacts.wrenches(data)[0]
    expected, twists = np.zeros(model.nv), []
    for index, pose, wrench in ((1, pose_a, wrenches[:6]), (2, pose_b, wrenches[6:])):
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, linear, angular, pose[:3, 3], index)
        expected += angular.T @ wrench[:3] + linear.T @ wrench[3:]
        twists.append(np.r_[angular @ data.qvel, linear @ data.qvel])
    by_pair = contacts.contacts[0].pair.wrench(pose_a, pose_b, *twists)
    assert np.abs(wrenches - by_pair).max() < 1e-10 * np.abs(by_pair).max()
    contacts.add_to(data)
    assert np.abs(expected).max() > 1.0
    assert np.abs(data.qfrc_passive - expected).max() < 1e-12 * np.abs(expected).max()


def test_carriers_are_where_mujoco_has_them():
    model, _ = drop()
    pair = ball_pair()
    attachments = [soft.geom("ball"), soft.body("ball"), soft.site("inside"), soft.body("ball", he.pose([0.1, 0.2, 0.3]))]
    pairs = [soft.ContactPair(pair, attachment, soft.body("world")) for attachment in attachments]
    contacts = soft.PassiveContacts(model, pairs)
    data = mujoco.MjData(model)
    data.qpos[3:] = [0.5, 0.5, 0.5, 0.5]
    mujoco.mj_forward(model, data)
    rotation, center = data.xmat[1].reshape(3, 3), data.xpos[1]
    positions = [center, center, center + rotation @ [0.01, 0.02, 0.03], center + rotation @ [0.1, 0.2, 0.3]]
    for (actual, world), position in zip(contacts.poses(data), positions, strict=True):
        assert np.abs(actual[:3, 3] - position).max() < 1e-12
        assert np.abs(actual[:3, :3] - rotation).max() < 1e-12
        assert np.array_equal(world, np.eye(4))


def test_models_are_told_apart_and_contexts_end_in_any_order():
    first, second = drop(), drop(order=1)
    alone = [stepped(*pair, 900).qpos.copy() for pair in (first, second)]
    assert not np.array_equal(*alone)
    data = [mujoco.MjData(model) for model, _ in (first, second)]
    first[1].__enter__()
    second[1].__enter__()
    for (model, _), state in zip((first, second), data, strict=True):
        mujoco.mj_step(model, state, 700)
    first[1].__exit__(None, None, None)
    mujoco.mj_step(second[0], data[1], 200)
    second[1].__exit__(None, None, None)
    assert np.array_equal(data[1].qpos, alone[1])
    # The first ball fell through the block after its context had ended.
    mujoco.mj_step(first[0], data[0], 200)
    assert data[0].qpos[2] < alone[0][2]


def test_another_callback_is_called_too_and_comes_back():
    model, contacts = drop()
    calls = []

    def mine(model, data):
        calls.append(data.time)

    mujoco.set_mjcb_passive(mine)
    try:
        stepped(model, contacts, 3)
        assert len(calls) == 3
        assert mujoco.get_mjcb_passive() is mine
    finally:
        mujoco.set_mjcb_passive(None)


def test_an_error_in_the_block_or_in_the_callback_clears_it():
    model, contacts = drop()
    with pytest.raises(RuntimeError, match="on the way"), contacts:
        raise RuntimeError("on the way")
    assert mujoco.get_mjcb_passive() is None
    data = mujoco.MjData(model)
    data.qpos[2], data.qvel[0] = 0.19, np.nan
    with pytest.raises(he.HydroelasticError), contacts:
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)


def test_threads_step_their_own_data():
    model, contacts = drop()
    expected = stepped(model, contacts, 300).qpos.copy()
    actual = [mujoco.MjData(model) for _ in range(3)]
    with contacts:
        threads = [threading.Thread(target=mujoco.mj_step, args=(model, data, 300)) for data in actual]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert all(np.array_equal(data.qpos, expected) for data in actual)


def test_contacts_of_both_kinds_at_once_are_refused_until_excluded():
    with pytest.raises(he.HydroelasticError, match="exclude it"):
        drop(more="")
    spec = mujoco.MjSpec.from_string(DROP.format(more=""))
    contact = soft.ContactPair(ball_pair(), soft.geom("ball"), soft.geom("block"))
    soft.exclude(spec, [contact, contact])
    assert len(spec.excludes) == 1
    model = spec.compile()
    contacts = soft.PassiveContacts(model, [contact])
    data = stepped(model, contacts, 600)
    assert data.ncon == 0 and contacts.wrenches(data).any()
    with pytest.raises(he.HydroelasticError, match="exclude it"):
        drop(more='<contact><pair geom1="ball" geom2="block"/></contact>')


# MuJoCo finds no contact for disjoint contact bits, for parent and child, and with contacts disabled. The check agrees.
@pytest.mark.parametrize(
    ("geoms", "flag", "expected"),
    [
        ("", "", 2),
        ('contype="2" conaffinity="4"', "", 0),
        ('contype="2" conaffinity="1"', "", 2),
        ("", '<option><flag contact="disable"/></option>', 0),
        ("", '<option><flag filterparent="disable"/></option>', 3),
    ],
)
def test_the_check_finds_what_mujoco_finds(geoms, flag, expected):
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco>{flag}
      <worldbody>
        <geom name="floor" type="box" size="1 1 .1"/>
        <body name="arm" pos="0 0 .15"><joint type="hinge" axis="0 1 0"/><geom type="sphere" size=".1" mass="1" {geoms}/>
          <body name="hand" pos=".05 0 0"><joint type="hinge" axis="0 1 0"/><geom type="sphere" size=".1" mass="1" {geoms}/>
          </body>
        </body>
      </worldbody>
    </mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pairs = {frozenset(int(model.geom_bodyid[g]) for g in contact.geom) for contact in data.contact}
    assert len(pairs) == expected
    for bodies in ((0, 1), (0, 2), (1, 2)):
        names = [soft.body(model.body(index).name) for index in bodies]
        contact = soft.ContactPair(ball_pair(), *names)
        if frozenset(bodies) in pairs:
            with pytest.raises(he.HydroelasticError, match="exclude it"):
                soft.PassiveContacts(model, [contact])
        else:
            soft.PassiveContacts(model, [contact])


EDGE, MODULUS = 0.2, 1e6
# Stiffness over mass (1/s²) of a cube of 1 kg that lies flat on a rigid plane.
RATE = MODULUS / (EDGE / 2) * EDGE**2
# Limits of the integrators, times the square root of RATE.
LIMITS = {"Euler": 2.0, "implicit": 2.0, "implicitfast": 2.0, "RK4": np.sqrt(8.0)}
# Relative tolerance of a limit in closed form. The limit of RK4 is searched in steps of 1/280 of the limit.
LIMIT = 5e-3


def cube_on_plane(time_step, law=None, height=EDGE / 2 - 3e-5, kind="Euler", gravity="0 0 -9.81", **keywords):
    """A cube on the plane z = 0, a little deeper than at rest, and its contacts."""
    xml = f"""
    <mujoco>
      <option timestep="{float(time_step)!r}" gravity="{gravity}" integrator="{kind}"><flag contact="disable"/></option>
      <worldbody>
        <geom name="floor" type="plane" size="1 1 1"/>
        <body name="cube" pos="0 0 {float(height)!r}"><freejoint/><geom name="cube" type="box" size=".1 .1 .1" mass="1"/></body>
      </worldbody>
    </mujoco>"""
    model = mujoco.MjModel.from_xml_string(xml)
    pair = he.Pair(he.Shape.cuboid([EDGE] * 3), he.HalfSpace(), MODULUS, None, law or he.SurfaceLaw())
    contacts = soft.PassiveContacts(model, [soft.ContactPair(pair, soft.geom("cube"), soft.geom("floor"))], **keywords)
    return model, mujoco.MjData(model), contacts


@pytest.mark.parametrize("kind", LIMITS)
def test_a_step_above_the_limit_raises_and_names_it(kind):
    limit = LIMITS[kind] / np.sqrt(RATE)
    model, data, contacts = cube_on_plane(1.25 * limit, kind=kind)
    with pytest.raises(soft.TimeStepError, match=r"exceeds .* s, the stability limit .* geom 'cube' and geom 'floor'") as caught, contacts:
        mujoco.mj_step(model, data, 100)
    error = caught.value
    assert error.limit == pytest.approx(limit, rel=LIMIT)
    assert error.time_step == model.opt.timestep and error.contact == "geom 'cube' and geom 'floor'"
    assert error.time == pytest.approx(error.step * model.opt.timestep) and 0 < error.step < 20
    for text in (f"step {error.step} (t = {error.time:.6g} s)", f"{error.time_step:.3g} s", f"{error.limit:.3g} s", "check_stability"):
        assert text in str(error)


@pytest.mark.parametrize("kind", LIMITS)
def test_a_step_below_the_limit_oscillates_as_the_scheme_does(kind):
    model, data, contacts = cube_on_plane(0.8 * LIMITS[kind] / np.sqrt(RATE), kind=kind)
    heights = []
    with contacts:
        for _ in range(2000):
            mujoco.mj_step(model, data)
            heights.append(data.qpos[2])
    # At h²k = 2.56, symplectic steps reach 1/√(1 − 0.64) times the initial amplitude, and RK4 damps the motion.
    rest = EDGE / 2 - 9.81 / RATE
    assert np.abs(np.array(heights) - rest).max() < 1.001 / 0.6 * (3e-5 - 9.81 / RATE)


@pytest.mark.parametrize("kind", LIMITS)
def test_joint_damping_raises_the_limit_if_it_is_implicit(kind):
    """A slide joint with the damping rate d: h²k ≤ 4 + 2hd if the damping is implicit, h²k + 2hd ≤ 4 if it is explicit.
    """
    rate = 400.0
    root = np.sqrt(rate**2 + 4.0 * RATE)
    limit = (rate + root) / RATE

    def run(time_step):
        model, _, contacts = cube_on_plane(time_step, kind=kind)
        spec = mujoco.MjSpec.from_string(f"""
        <mujoco><option timestep="{float(time_step)!r}" integrator="{kind}"><flag contact="disable"/></option><worldbody>
          <geom name="floor" type="plane" size="1 1 1"/>
          <body name="cube" pos="0 0 {EDGE / 2 - 2.5e-5!r}"><joint type="slide" axis="0 0 1" damping="{rate}"/>
            <geom name="cube" type="box" size=".1 .1 .1" mass="1"/></body>
        </worldbody></mujoco>""")
        model = spec.compile()
        contacts = soft.PassiveContacts(model, contacts.contacts)
        with contacts:
            mujoco.mj_step(model, mujoco.MjData(model), 300)

    if kind == "RK4":
        run(0.5 * limit)
        limit = 4.0 / (rate + root)
    else:
        run(0.8 * limit)
    with pytest.raises(soft.TimeStepError) as caught:
        run(1.25 * limit if kind != "RK4" else 2.0 * limit)
    assert kind == "RK4" or caught.value.limit == pytest.approx(limit, rel=LIMIT)


def test_steps_above_the_limit_are_taken_on_request():
    model, data, contacts = cube_on_plane(1.25 * 2.0 / np.sqrt(RATE), check_stability=False)
    with contacts:
        mujoco.mj_step(model, data, 100)
    assert data.time == pytest.approx(100 * model.opt.timestep)
    assert np.abs(data.qpos[2] - EDGE / 2) > 1e-3


# Relative tolerance of the creep speed. The initial motion decays over 2,000 steps.
CREEP = 1e-4
PRESS, WALL_LAW = 20.0, he.SurfaceLaw(0.5, 0.8, 1e-2)


def pressed_to_wall(time_step):
    """A cube that is pressed to a wall and carried by friction. Its weight acts at the wall, so that the cube does not
    turn."""
    model, data, contacts = cube_on_plane(time_step, WALL_LAW, EDGE / 2 - PRESS / RATE, gravity="0 0 0")
    data.xfrc_applied[1] = [-9.81, 0.0, -PRESS, 0.0, 9.81 * EDGE / 2, 0.0]
    return model, data, contacts


def sticking_limit(slip_tolerance):
    """Returns the largest stable step of the same cube in a world."""
    skin = he.Material(MODULUS, WALL_LAW.dissipation, WALL_LAW.friction)
    cube = he.Shape.cuboid([EDGE] * 3)
    body = he.Body.dynamic("cube", cube, skin, 1.0, pose=he.pose([0.0, 0.0, EDGE / 2 - PRESS / RATE]))
    hard = he.Material.rigid(WALL_LAW.friction)
    world = he.World([body, he.Body.fixed("wall", he.HalfSpace(), hard)], slip_tolerance=slip_tolerance)
    return world.largest_stable_step(world.initial_state)


def test_a_block_that_friction_carries_creeps_by_the_law_or_the_step_is_refused():
    load = 9.81 / (WALL_LAW.friction * PRESS)
    creep = WALL_LAW.slip_tolerance * load / np.sqrt(1.0 - load**2)
    model, data, contacts = pressed_to_wall(0.8 * sticking_limit(WALL_LAW.slip_tolerance))
    with contacts:
        mujoco.mj_step(model, data, 2000)
    assert -data.qvel[0] == pytest.approx(creep, rel=CREEP)
    limit = sticking_limit(soft._CHATTER * WALL_LAW.slip_tolerance)
    for excess in (1.25, 10.0):
        model, data, contacts = pressed_to_wall(excess * limit)
        with pytest.raises(soft.TimeStepError) as caught, contacts:
            mujoco.mj_step(model, data, 2000)
        # Far above the limit, the first steps have already changed the contact.
        assert excess > 2.0 or caught.value.limit == pytest.approx(limit, rel=0.1)
    # Between both limits, the cube chatters at a few slip tolerances.
    model, data, contacts = pressed_to_wall(0.8 * limit)
    with contacts:
        mujoco.mj_step(model, data, 2000)
    assert np.abs(data.qvel[:3]).max() < 3.0 * WALL_LAW.slip_tolerance


def test_a_contact_that_begins_deep_within_a_step_adds_no_energy():
    """The step is below the limit (h²k = 3), but contact begins early in the step, so the cube would leave at 1.9 times
    its speed."""
    time_step, speed = np.sqrt(3.0 / RATE), 0.01
    gap = 0.03 * time_step * speed
    model, data, contacts = cube_on_plane(time_step, height=EDGE / 2 + gap, gravity="0 0 0")
    data.qvel[2] = -speed
    with pytest.raises(soft.TimeStepError, match="returns more energy than it absorbs") as caught, contacts:
        mujoco.mj_step(model, data, 3)
    assert caught.value.step == 1
    assert caught.value.limit == pytest.approx(np.sqrt(2.0 / 0.97 / RATE), rel=0.01)
    # The same state raises no error if it was set.
    model, data, contacts = cube_on_plane(time_step, height=EDGE / 2 + 1.0, gravity="0 0 0")
    with contacts:
        mujoco.mj_step(model, data)
        data.qpos[2], data.qvel[2] = EDGE / 2 - 2.0 * time_step * speed, -speed
        mujoco.mj_step(model, data)


def test_evaluations_outside_a_step_raise_nothing():
    model, data, contacts = cube_on_plane(1.25 * 2.0 / np.sqrt(RATE))
    size = 2 * model.nv
    a = np.zeros((size, size))
    with pytest.raises(soft.TimeStepError), contacts:
        for height in (0.09, 0.05, EDGE / 2 - 2.5e-5):
            data.qpos[2] = height
            mujoco.mj_forward(model, data)
        mujoco.mjd_transitionFD(model, data, 1e-6, True, a, None, None, None)
        mujoco.mj_step(model, data)
        assert data.time == model.opt.timestep
        mujoco.mj_step(model, data)


@pytest.mark.parametrize("kind", LIMITS)
def test_a_motion_that_blows_up_names_step_time_body_and_contact(kind):
    """The plane throws the cube up in steps that are much too long, without the stability check."""
    model, data, contacts = cube_on_plane(1e7 / np.sqrt(RATE), kind=kind, gravity="0 0 0", check_stability=False)
    message = (
        r"after step \d+ \(t = .* s\) the motion has diverged, and MuJoCo resets the state: q\w+\[2\] was not finite or beyond "
        r"1e10. This is a number of the joint of body 'cube'. The contact of geom 'cube' and geom 'floor' was the last to act on it, "
        r"at t = 0 s, with a joint force of "
    )
    with pytest.raises(he.RolloutError, match=message), contacts:
        mujoco.mj_step(model, data, 300)


@pytest.mark.parametrize("kind", LIMITS)
@pytest.mark.parametrize("excess", [10.0, 1000.0])
def test_a_body_that_a_step_moves_into_the_ground_is_an_error(kind, excess):
    model, data, contacts = cube_on_plane(excess / np.sqrt(RATE), height=EDGE / 2 + 0.05, kind=kind)
    with pytest.raises(he.RolloutError, match=r"step \d+ .*geom 'cube' and geom 'floor'"), contacts:
        mujoco.mj_step(model, data, 2000)


def test_an_error_in_a_thread_of_mujoco_is_raised_at_the_end():
    rollout = pytest.importorskip("mujoco.rollout")
    model, data, contacts = cube_on_plane(1.25 * 2.0 / np.sqrt(RATE))
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    threads = [mujoco.MjData(model) for _ in range(2)]
    with pytest.raises(soft.TimeStepError, match="step 2"), contacts:
        states, _ = rollout.rollout(model, threads, np.stack([state] * 4), nstep=10)
    assert states.shape[:2] == (4, 10)
    # The next context starts a new history.
    with contacts:
        mujoco.mj_step(model, data)


def test_scenes_that_rest_raise_nothing_over_many_steps():
    law = he.SurfaceLaw(5.0, 0.6, 1e-2)
    model, data, contacts = cube_on_plane(1e-4, law, EDGE / 2 + 1e-3)
    alarms = []
    decided = soft.Watch._decided
    with pytest.MonkeyPatch.context() as patch, contacts:
        patch.setattr(soft.Watch, "_decided", lambda *all: alarms.append(1) or decided(*all))
        mujoco.mj_step(model, data, 20_000)
    assert np.abs(data.qvel).max() < 1e-9
    # Few derivatives are computed, because they would cost more than the steps.
    assert len(alarms) < 20


def test_a_state_that_is_not_finite_is_named_with_its_step():
    model, contacts = drop()
    data = mujoco.MjData(model)
    with pytest.raises(he.RolloutError, match=r"after step 4 \(t = 0.0004 s\) the motion has diverged.*qvel\[0\]"), contacts:
        mujoco.mj_step(model, data, 5)
        data.qvel[0] = np.nan
        mujoco.mj_step(model, data)
    data = mujoco.MjData(model)
    with pytest.raises(he.RolloutError, match=r"at the first step the motion has diverged.*qpos\[0\]"), contacts:
        data.qpos[0] = np.inf
        mujoco.mj_step(model, data)
    data = mujoco.MjData(model)
    data.time, data.qpos[2], data.qvel[0] = 3e-4, 0.19, np.nan
    with pytest.raises(he.RolloutError, match=r"step 3 \(t = 0.0003 s\): qvel\[0\] is not finite.*of body 'ball'"), contacts:
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)


@pytest.mark.parametrize(
    ("flag", "message"),
    [
        ("enable", r"after step 4 \(t = 0.0004 s\) the motion has diverged, .*qacc\[0\].*of body 1, on which no contact has acted"),
        ("disable", r"step 5 \(t = 0.0005 s\): qpos\[0\] is not finite.*of body 1, on which no contact has acted"),
    ],
)
def test_a_nan_of_a_body_without_contacts_is_an_error_without_a_stability_check(flag, message):
    body = '<body><joint type="slide"/><geom size=".1" mass="1"/></body>'
    xml = DROP.format(more=EXCLUDE).replace("<worldbody>", f"<worldbody>{body}")
    xml = xml.replace('integrator="Euler"/>', f'integrator="Euler"><flag autoreset="{flag}" contact="disable"/></option>')
    model = mujoco.MjModel.from_xml_string(xml)
    contact = soft.ContactPair(ball_pair(), soft.geom("ball"), soft.geom("block"))
    data = mujoco.MjData(model)
    with (
        pytest.raises(he.RolloutError, match=message),
        soft.PassiveContacts(model, [contact], check_stability=False),
    ):
        mujoco.mj_step(model, data, 4)
        data.xfrc_applied[1] = np.nan
        mujoco.mj_step(model, data, 3)


def test_shapes_of_geoms():
    model = mujoco.MjModel.from_xml_string("""
    <mujoco><worldbody>
      <geom name="ball" type="sphere" size=".1"/><geom name="box" type="box" size=".1 .2 .3"/>
      <geom name="rod" type="cylinder" size=".1 .2"/><geom name="egg" type="ellipsoid" size=".1 .2 .3"/>
      <geom name="ground" type="plane" size="1 1 1"/>
    </worldbody></mujoco>""")
    extents = {"ball": [0.1] * 3, "box": [0.1, 0.2, 0.3], "rod": [0.1, 0.1, 0.2], "egg": [0.1, 0.2, 0.3]}
    for name, expected in extents.items():
        vertices = soft.shape_from_geom(model, name).vertices
        assert np.allclose(vertices.max(axis=0), expected, rtol=1e-2), name
    with pytest.raises(he.HydroelasticError, match=r"is a plane, whose shape is hydroelastic.HalfSpace\(\)"):
        soft.shape_from_geom(model, "ground")


def test_refusals():
    model, contacts = drop()
    pair = ball_pair()

    def made(a, b, of=model):
        return soft.PassiveContacts(of, [soft.ContactPair(pair, a, b)])

    with pytest.raises(he.HydroelasticError, match="no geom 'cube'"):
        made(soft.geom("cube"), soft.geom("block"))
    with pytest.raises(he.HydroelasticError, match="fixed to each other"):
        made(soft.geom("ball"), soft.body("ball"))
    with pytest.raises(he.HydroelasticError, match="not rigid"):
        made(soft.geom("ball", np.diag([1.0, 1.0, -1.0, 1.0])), soft.geom("block"))
    with pytest.raises(TypeError, match="float64"):
        made(soft.geom("ball", np.eye(4, dtype=np.float32)), soft.geom("block"))
    with pytest.raises(he.HydroelasticError, match="act already"), contacts, contacts:
        pass
    still, _ = drop()
    still.opt.disableflags = soft._NO_PASSIVE_FORCES
    data = mujoco.MjData(still)
    calls = []
    mujoco.set_mjcb_passive(lambda model, data: calls.append(data.time))
    mujoco.mj_step(still, data)
    mujoco.set_mjcb_passive(None)
    assert not calls
    with pytest.raises(he.HydroelasticError, match="no passive forces"):
        made(soft.geom("ball"), soft.geom("block"), still)
    spec = mujoco.MjSpec.from_string(DROP.format(more="").replace('body name="ball"', "body"))
    with pytest.raises(he.HydroelasticError, match="has no name"):
        soft.exclude(spec, [soft.ContactPair(pair, soft.geom("ball"), soft.geom("block"))])
