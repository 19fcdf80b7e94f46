"""Batches, threads, signals and progress."""

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import hydroelastic as he


def long_world():
    skin = he.Material(1e5, 0.2, 0.4)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0.0, 0.0, 0.199]))
    floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
    return he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)


def test_a_batch_of_contacts_has_the_bits_of_a_loop(ball_on_block, twists):
    pair, pose_a, pose_b = ball_on_block
    poses = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-4 * index]) for index in range(40)])
    moduli = np.array([[1e5 + 1e3 * index, 1e6] for index in range(40)])
    wrenches, jacobians = pair.linearized(poses, pose_b, *twists, moduli=moduli)
    assert wrenches.shape == (40, 12) and jacobians.shape == (40, 12, 28)
    elastic, at_rest = pair.wrench_and_jacobian(poses, pose_b)
    energies = pair.potential_energy(poses, pose_b)
    for index in range(40):
        wrench, jacobian = pair.linearized(poses[index], pose_b, *twists, moduli=moduli[index])
        assert wrenches[index].tobytes() == wrench.tobytes()
        assert jacobians[index].tobytes() == jacobian.tobytes()
        wrench, jacobian = pair.wrench_and_jacobian(poses[index], pose_b)
        assert elastic[index].tobytes() == wrench.tobytes()
        assert at_rest[index].tobytes() == jacobian.tobytes()
        assert energies[index] == pair.potential_energy(poses[index], pose_b)
    assert len({wrench.tobytes() for wrench in wrenches}) == 40
    assert pair.wrench(np.zeros((0, 4, 4)), pose_b).shape == (0, 12)
    # Arrays that are not contiguous are read in the order of their indices.
    assert pair.wrench(poses[::2], pose_b).tobytes() == pair.wrench(poses[::2].copy(), pose_b).tobytes()


def test_batches_of_rollouts_have_the_bits_of_a_loop(bounce):
    world, plan = bounce
    by = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]
    samples = np.array([[0.1 * index, 0.0, -0.2 * index, 0.01 * index] for index in range(6)])
    told = []
    batch = he.Batch(plan, progress=lambda done, total: told.append((done, total)))
    trajectories = batch.rollouts_perturbed(world, by, samples)
    jacobians = batch.jacobians_perturbed(world, by, samples)
    worlds = [world.perturbed(by, sample) for sample in samples]
    for index, other in enumerate(worlds):
        expected = other.rollout(plan).run()
        assert trajectories[index].poses.tobytes() == expected.poses.tobytes()
        (trajectory, jacobian), (same, exact) = jacobians[index], other.jacobian(plan, by)
        assert trajectory.poses.tobytes() == same.poses.tobytes()
        assert jacobian.twists.tobytes() == exact.twists.tobytes()
    rollouts = batch.rollouts(worlds)
    assert all(a.twists.tobytes() == b.twists.tobytes() for a, b in zip(rollouts, trajectories, strict=True))
    starts = [other.initial_state for other in worlds[:1]]
    assert batch.rollouts_from(worlds[0], starts)[0].poses.tobytes() == trajectories[0].poses.tobytes()
    assert told.count((6, 6)) == 3


def test_a_sample_that_is_refused_leaves_the_others(bounce):
    world, plan = bounce
    by = [he.Parameter.friction("ball")]
    samples = np.array([[0.0], [-1.0], [0.1]])
    for results in (
        he.Batch(plan).rollouts_perturbed(world, by, samples),
        he.Batch(plan).jacobians_perturbed(world, by, samples),
    ):
        assert isinstance(results[1], he.HydroelasticError) and "friction" in str(results[1])
        assert not isinstance(results[0], Exception) and not isinstance(results[2], Exception)


@pytest.mark.parametrize(
    "work",
    [
        lambda world: world.rollout(he.Plan(2e-4, 8_000, record_every=8_000)).run(),
        lambda world: world.jacobian(he.Plan(2e-4, 3_000, record_every=3_000), [he.Parameter.gravity()]),
        lambda world: he.Batch(he.Plan(2e-4, 4_000, record_every=4_000)).rollouts([world] * 4),
        lambda world: world.linearize(he.Plan(2e-4, 2_000), [he.Parameter.gravity()]),
    ],
    ids=["rollout", "jacobian", "batch", "linearized"],
)
def test_other_threads_run_while_a_rollout_does(work):
    world, ticks, is_over = long_world(), [], threading.Event()

    def tick():
        while not is_over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(1e-3)

    thread = threading.Thread(target=tick)
    thread.start()
    start = time.perf_counter()
    work(world)
    end = time.perf_counter()
    is_over.set()
    thread.join()
    during = [tick for tick in ticks if start < tick < end]
    # A call that held the GIL would let the other thread run only at its start and end.
    assert end - start > 0.05 and len(during) > 10


ENDLESS = """
import hydroelastic as he, signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
skin = he.Material(1e5, 0.2, 0.4)
ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0.0, 0.0, 0.199]))
floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
plan = he.Plan(2e-4, 10**9, record_every=10**9)
print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


# A body of 1,000 t spins in a floor. One step has 128 substeps, and needs about 10 s of contact evaluations.
LONG_STEP = """
import hydroelastic as he, signal
signal.signal(signal.SIGINT, signal.default_int_handler)
egg, skin = he.Shape.ellipsoid([0.1, 0.11, 0.12], 5), he.Material(1e5, 0.2, 0.4)
egg = he.Body.dynamic("egg", egg, skin, 1e6, pose=he.pose([0.0, 0.0, 0.05]), angular_velocity=[1200.0, 900.0, 600.0])
world = he.World([egg, he.Body.fixed("floor", he.HalfSpace(), he.Material.rigid(0.5))])
plan = he.Plan(0.1, 1, he.Integrator.SDIRK3)
print("begun", flush=True)
try:
    {work}
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
# Maximum time (s) from Ctrl-C to the end: one evaluation of the contacts, and the exit of the interpreter.
AT_ONCE = 5.0


def assert_ctrl_c_ends(script):
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.3)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    try:
        output, errors = process.communicate(timeout=AT_ONCE)
    finally:
        process.kill()
    assert output == "interrupted\n", errors


@pytest.mark.parametrize(
    "work",
    [
        "world.rollout(plan).run()",
        "world.jacobian(plan, [he.Parameter.gravity()])",
        "he.Batch(plan).rollouts([world] * 8)",
        "he.Batch(plan).jacobians_perturbed(world, [he.Parameter.gravity()], __import__('numpy').zeros((8, 3)))",
    ],
)
def test_ctrl_c_ends_a_rollout_before_its_next_step(work):
    assert_ctrl_c_ends(ENDLESS.format(work=work))


@pytest.mark.parametrize(
    "work",
    [
        "world.rollout(plan).run()",
        "next(world.rollout(plan))",
        "world.step(world.initial_state, plan)",
        "world.kinks(plan)",
        "world.linearize(plan)",
        "he.Batch(plan).rollouts([world] * 3)",
    ],
)
def test_ctrl_c_ends_a_step_in_progress(work):
    assert_ctrl_c_ends(LONG_STEP.format(work=work))


def test_ctrl_c_ends_the_product_of_one_thread_only():
    _, vjp = long_world().vjp(he.Plan(2e-4, 4_000, record_every=4_000), [he.Parameter.gravity()], memory=0)
    by_states = np.ones((2, 2, 4, 4)), np.ones((2, 2, 6))
    results = []

    def pull_back():
        results.append(vjp(*by_states))

    thread = threading.Thread(target=pull_back)
    before = signal.signal(signal.SIGALRM, lambda *_: 1 / 0)
    try:
        thread.start()
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        with pytest.raises(ZeroDivisionError):
            vjp(*by_states)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        thread.join()
    assert results[0].tobytes() == vjp(*by_states).tobytes()


def test_a_stopped_rollout_can_go_on():
    rollout = long_world().rollout(he.Plan(2e-4, 2_000, record_every=2_000))
    with pytest.raises(ZeroDivisionError):
        rollout.run(progress=lambda done, total: 1 / 0)
    steps_taken = rollout.steps_taken
    assert 0 < steps_taken < 2_000
    rest = rollout.run()
    expected = long_world().rollout(he.Plan(2e-4, 2_000, record_every=2_000)).run()
    assert rollout.steps_taken == 2_000 and rest[-1].poses.tobytes() == expected[-1].poses.tobytes()


def test_a_progress_function_that_raises_ends_the_rollout():
    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        long_world().rollout(he.Plan(2e-4, 10**9, record_every=10**9)).run(progress=stop)
    with pytest.raises(TypeError, match="progress must be"):
        long_world().rollout(he.Plan(2e-4, 2)).run(progress=3)


def test_progress_bars_need_no_tqdm(bounce):
    world, plan = bounce
    assert len(world.rollout(plan).run(progress=True)) == 4


def test_a_rollout_in_use_by_another_thread_is_refused():
    rollout = long_world().rollout(he.Plan(1e-4, 100_000))
    began, refusals = threading.Event(), []

    def on_progress(done, total):
        began.set()
        if refusals:
            raise KeyboardInterrupt

    def record():
        with pytest.raises(KeyboardInterrupt):
            rollout.run(progress=on_progress)

    thread = threading.Thread(target=record)
    thread.start()
    assert began.wait(60.0)
    for use in (lambda: rollout.state, lambda: rollout.steps_taken, lambda: next(rollout), rollout.run, lambda: repr(rollout)):
        with pytest.raises(he.HydroelasticError, match="another thread is taking steps of this rollout"):
            use()
    refusals.append(True)
    thread.join()
    assert 0 < rollout.steps_taken < 100_000
