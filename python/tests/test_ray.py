"""Batches and fits on a Ray cluster of two nodes on one machine. They have the same bits after the loss of workers and nodes."""

import concurrent.futures
import contextlib
import os
import signal
import time

import numpy as np
import pytest

import hydroelastic as he

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

# Object store memory of a raylet (bytes). The objects of these tests are small.
STORE = 100 << 20


@pytest.fixture(scope="module")
def heard_ctrl_c():
    """Restores the handler of Ctrl-C, because a shell makes background programs and their children ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def running_cluster():
    """A head without cores and two nodes of one core each."""
    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": STORE}
    cluster = cluster_utils.Cluster(initialize_head=True, head_node_args=head)
    cluster.ours = [cluster.add_node(num_cpus=1, object_store_memory=STORE) for _ in range(2)]
    ray.init(address=cluster.address, logging_level="ERROR", log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture(scope="module")
def cluster(heard_ctrl_c):
    with running_cluster() as cluster:
        yield cluster


@pytest.fixture
def new_cluster(cluster):
    """A new cluster. Ray 2.60 may end this process with a failed check of its own, if a node is lost after tasks were canceled."""
    ray.shutdown()
    cluster.shutdown()
    with running_cluster() as cluster:
        yield cluster


@pytest.fixture
def Batch(cluster):
    from hydroelastic.ray import Batch

    return Batch


def bits(result):
    """Returns the bytes of a trajectory, of a trajectory with its Jacobian, or of an exception."""
    if isinstance(result, he.RolloutError):
        return (str(result), bits(result.trajectory))
    if isinstance(result, Exception):
        return (type(result), str(result))
    if isinstance(result, tuple):
        return (bits(result[0]), result[1].poses.tobytes(), result[1].twists.tobytes())
    return None if result is None else (result.times.tobytes(), result.poses.tobytes(), result.twists.tobytes())


def same(actual, expected):
    assert [bits(result) for result in actual] == [bits(result) for result in expected]
    assert len({bits(result) for result in expected}) > 1


BY = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]


def throws(count):
    """Returns random changes of the velocity and the friction."""
    return np.random.default_rng(3).normal(size=(count, 4)) * [0.5, 0.5, 0.2, 0.0] + [0.0, 0.0, 0.0, 0.1]


def test_rollouts_with_joints_have_the_results_of_the_local_batch(Batch):
    hinge = he.Joint.revolute("hinge", [0.0, 1.0, 0.0], origin=he.pose([0.0, 0.0, 0.5], [0.5, 0.0, 0.0]), position=0.3)
    arm = he.Body.dynamic("arm", he.Shape.icosphere(0.1, 1), he.Material(1e5), 1.0, joint=hinge)
    world, by = he.World([arm], gravity=-9.81), [he.Parameter.joint("hinge", "initial_velocity")]
    plan, samples = he.Plan(5e-3, 4, he.Integrator.SDIRK3), np.array([[0.1], [0.2], [0.3]])
    here, there = (kind(plan).jacobians_perturbed(world, by, samples) for kind in (he.Batch, Batch))
    for (expected, derivatives), (trajectory, jacobian) in zip(here, there, strict=True):
        assert np.array_equal(trajectory.joint_positions, expected.joint_positions)
        assert np.array_equal(jacobian.joint_positions, derivatives.joint_positions)


def test_every_method_has_the_results_of_the_local_batch(Batch, bounce):
    world, plan = bounce
    samples = throws(7)
    samples[3, 3] = -1.0  # This friction coefficient is negative.
    worlds = [world.perturbed(BY, sample) for sample in np.delete(samples, 3, axis=0)]
    states = [other.initial_state for other in worlds]
    reports = []
    here, there = he.Batch(plan), Batch(plan, chunk=3, progress=lambda done, total: reports.append((done, total)))
    same(there.rollouts_perturbed(world, BY, samples), here.rollouts_perturbed(world, BY, samples))
    same(there.jacobians_perturbed(world, BY, samples), here.jacobians_perturbed(world, BY, samples))
    same(there.jacobians(worlds, BY), here.jacobians(worlds, BY))
    same(there.rollouts(worlds), here.rollouts(worlds))
    same(there.rollouts_from(world, states), here.rollouts_from(world, states))
    assert reports[:3][-1] == (7, 7) and reports[-1] == (6, 6) and len(reports) == 3 + 3 + 2 + 2 + 2
    assert isinstance(there.jacobians_perturbed(world, BY, samples)[3], he.HydroelasticError)
    assert there.rollouts([]) == [] and there.plan == plan


def test_rollouts_that_end_early_come_back_as_values(Batch, bounce):
    world, _ = bounce
    plan = he.Plan(5e-2, 60)  # This step is far above the stable step.
    samples = throws(4)
    expected = he.Batch(plan).rollouts_perturbed(world, BY, samples)
    assert any(isinstance(result, he.RolloutError) and len(result.trajectory) > 1 for result in expected)
    same(Batch(plan, chunk=1).rollouts_perturbed(world, BY, samples), expected)


def test_bad_arguments_are_refused_as_by_the_local_batch(Batch, bounce):
    world, plan = bounce
    small = he.State(0.0, np.eye(4)[None], np.zeros((1, 6)))
    calls = [
        lambda batch: batch.jacobians_perturbed(world, BY, throws(2).astype(np.complex128)),
        lambda batch: batch.jacobians_perturbed(world, BY, throws(2)[0]),
        lambda batch: batch.rollouts_perturbed(world, [3], throws(2)),
        lambda batch: batch.rollouts_perturbed(3, BY, throws(2)),
        lambda batch: batch.rollouts_from(world, [world.initial_state, small]),
    ]
    for call in calls:
        with pytest.raises((TypeError, ValueError)) as expected:
            call(he.Batch(plan))
        with pytest.raises(expected.type) as actual:
            call(Batch(plan))
        assert str(actual.value) == str(expected.value)
    with pytest.raises(TypeError, match="World"):
        Batch(plan).rollouts([3])
    with pytest.raises(TypeError, match="progress must be"):
        Batch(plan, progress=3).rollouts([world])
    for refused in ({"chunk": 0}, {"max_retries": -2}):
        with pytest.raises(he.HydroelasticError, match=next(iter(refused))):
            Batch(plan, **refused)


def long_batch(world):
    """Returns a plan and 48 throws, for 12 tasks of a few tenths of a second each."""
    return he.Plan(2e-4, 2500, record_every=500), throws(48)


def at_work(process):
    """Returns whether a process of Ray runs a part of a batch now. Its title is then the name of the task."""
    try:
        with open(f"/proc/{process}/cmdline", "rb") as file:
            return file.read().startswith(b"ray::hydroelastic")
    except (FileNotFoundError, ProcessLookupError):
        return False


def descendants(process):
    """Returns the children of a process, and their children."""
    children = []
    for task in os.listdir(f"/proc/{process}/task"):
        try:
            with open(f"/proc/{process}/task/{task}/children") as file:
                children += [int(child) for child in file.read().split()]
        except (FileNotFoundError, ProcessLookupError):
            continue
    for child in list(children):
        try:
            children += descendants(child)
        except (FileNotFoundError, ProcessLookupError):
            continue
    return children


def raylet(node):
    """Returns the process of a node that starts the workers of the node."""
    (information,) = node.all_processes["raylet"]
    return information.process.pid


def working(*nodes):
    """Returns the workers of nodes that run a part of a batch now."""
    return [worker for node in nodes for worker in descendants(raylet(node)) if at_work(worker)]


def wait_for(condition, seconds=60):
    """Waits until a condition is true, and returns its value."""
    for _ in range(100 * seconds):
        if value := condition():
            return value
        time.sleep(1e-2)
    raise AssertionError(f"the condition was not true within {seconds} s")


@contextlib.contextmanager
def meanwhile(function):
    """Runs a function in a thread during the with statement, and raises its exception at the end."""
    with concurrent.futures.ThreadPoolExecutor(1) as executor:
        future = executor.submit(function)
        yield
        future.result()


@pytest.fixture
def kill_worker(cluster):
    """Returns a function that waits for a worker at work and kills it."""
    return lambda: os.kill(wait_for(lambda: working(*cluster.ours))[0], signal.SIGKILL)


def test_a_killed_worker_costs_nothing_but_time(kill_worker, Batch, bounce):
    world, _ = bounce
    plan, samples = long_batch(world)
    expected = he.Batch(plan).jacobians_perturbed(world, BY, samples)
    with meanwhile(kill_worker):
        actual = Batch(plan, chunk=4).jacobians_perturbed(world, BY, samples)
    same(actual, expected)


def test_a_part_that_is_not_tried_again_is_lost_alone(kill_worker, Batch, bounce):
    world, _ = bounce
    plan, samples = long_batch(world)
    with meanwhile(kill_worker):
        actual = Batch(plan, chunk=4, max_retries=0).rollouts_perturbed(world, BY, samples)
    lost = [index for index, result in enumerate(actual) if isinstance(result, he.RolloutError)]
    assert len(lost) == 4 and lost[0] % 4 == 0 and lost[3] == lost[0] + 3
    assert "worker" in str(actual[lost[0]]) and isinstance(actual[lost[0]].__cause__, ray.exceptions.WorkerCrashedError)
    expected = he.Batch(plan).rollouts_perturbed(world, BY, samples)
    left = [index for index in range(len(actual)) if index not in lost]
    same([actual[index] for index in left], [expected[index] for index in left])


def test_workers_have_one_thread(cluster, Batch, bounce):
    world, _ = bounce
    plan, samples = long_batch(world)

    def look():
        for worker in wait_for(lambda: working(*cluster.ours)):
            with open(f"/proc/{worker}/environ", "rb") as file:
                assert b"RAYON_NUM_THREADS=1\0" in file.read()

    with meanwhile(look):
        Batch(plan, chunk=4).rollouts_perturbed(world, BY, samples)


def test_an_exception_of_the_progress_function_and_ctrl_c_end_the_batch(cluster, Batch):
    skin = he.Material(1e5, 0.2, 0.4)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, 1.0, pose=he.pose([0.0, 0.0, 0.2]))
    floor = he.Body.fixed("floor", he.Shape.cuboid([2.0, 2.0, 0.2]), skin)
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81])
    endless = Batch(he.Plan(2e-4, 10**9, record_every=10**9))

    def interrupt():
        wait_for(lambda: working(*cluster.ours))
        os.kill(os.getpid(), signal.SIGINT)

    with meanwhile(interrupt), pytest.raises(KeyboardInterrupt):
        endless.rollouts([world] * 4)
    wait_for(lambda: not working(*cluster.ours))

    def stop(done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        Batch(he.Plan(2e-4, 10), chunk=1, progress=stop).rollouts([world] * 4)


@pytest.fixture
def fit(cluster):
    from hydroelastic.ray import fit

    return fit


def identified(count, plan):
    """Returns an identification of modulus and friction, and measurements of tosses without noise."""
    skin, table = he.Material(1.5e5, 0.5, 0.3), he.Body.fixed("table", he.HalfSpace(), he.Material.rigid())
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.05, 1), skin, 0.2, pose=he.pose([0.0, 0.0, 0.1]))
    world = he.World([ball, table], gravity=[0.0, 0.0, -9.81])
    unknowns = [he.Unknown(parameter, logarithmic=True) for parameter in (he.Parameter.modulus("ball"), he.Parameter.friction("ball"))]
    velocity = he.Parameter.initial_velocity("ball")
    identification = he.Identification(world, plan, unknowns, nuisances=[(velocity, 0.02)], horizons=[0.15], cauchy=4.0)
    truth = world.perturbed([he.Parameter.modulus("ball"), he.Parameter.friction("ball")], [-5e4, -0.1])
    velocities = np.random.default_rng(2).normal(size=(count, 3)) * 0.2 + [0.8, 0.0, -0.9]
    return identification, [truth.perturbed([velocity], each).rollout(plan).run() for each in velocities]


TOSS = he.Plan(0.01, 30, integrator=he.Integrator.SDIRK3)


def fit_bits(fit):
    arrays = [fit.values, fit.intervals, fit.covariance, fit.sandwich_covariance, fit.costs, fit.checkpoint.nuisances]
    return [array.tobytes() for array in arrays] + [fit.cost, fit.iterations, fit.termination, fit.errors]


def test_a_fit_has_the_bits_and_errors_of_the_local_fit(fit):
    identification, trajectories = identified(5, TOSS)
    states = list(trajectories[1])
    states[0] = he.State(0.0, np.stack([he.pose([0.0, 0.0, -1.0]), np.eye(4)]), states[0].twists)
    trajectories[1] = he.Trajectory(states)
    expected = identification.fit(trajectories)
    assert fit_bits(fit(identification, trajectories, chunk=2)) == fit_bits(expected)
    assert expected.errors[1] and expected.termination == "converged"
    # A fit continues from the checkpoint of an iteration, on the cluster as on one machine.
    checkpoints = []
    fit(identification, trajectories, progress=lambda *iteration: checkpoints.append(iteration[3]) or len(checkpoints) == 3)
    assert len(checkpoints) == 3
    continued = fit(identification, trajectories, start=checkpoints[-1])
    assert fit_bits(continued) == fit_bits(identification.fit(trajectories, start=checkpoints[-1]))


def test_bad_arguments_of_a_fit_are_refused_as_by_the_local_fit(fit):
    identification, trajectories = identified(2, TOSS)
    calls = [
        lambda fit: fit([]),
        lambda fit: fit([3]),
        lambda fit: fit(trajectories, start=he.Checkpoint(2, np.zeros(2), np.zeros((2, 3)))),
        lambda fit: fit(trajectories, progress=lambda *_: 1 / 0),
    ]
    for call in calls:
        with pytest.raises((TypeError, ValueError, ZeroDivisionError)) as expected:
            call(identification.fit)
        with pytest.raises(expected.type) as actual:
            call(lambda *arguments, **keywords: fit(identification, *arguments, **keywords))
        assert str(actual.value) == str(expected.value)
    with pytest.raises(TypeError, match="Identification"):
        fit(3, trajectories)
    for refused in ({"chunk": 0}, {"max_retries": -2}):
        with pytest.raises(he.HydroelasticError, match=next(iter(refused))):
            fit(identification, trajectories, **refused)


def long_fit():
    """Returns a fit of a few seconds."""
    return identified(8, he.Plan(1e-3, 300, integrator=he.Integrator.SDIRK3))


def test_a_worker_that_is_killed_during_a_fit_costs_nothing_but_time(kill_worker, fit):
    identification, trajectories = long_fit()
    expected = identification.fit(trajectories)
    with meanwhile(kill_worker):
        actual = fit(identification, trajectories, chunk=2)
    assert fit_bits(actual) == fit_bits(expected)


def test_a_fit_whose_task_is_lost_raises_an_error(kill_worker, fit):
    identification, trajectories = long_fit()
    with meanwhile(kill_worker), pytest.raises(he.RolloutError, match="worker") as raised:
        fit(identification, trajectories, chunk=2, max_retries=0)
    assert isinstance(raised.value.__cause__, ray.exceptions.WorkerCrashedError)


def test_ctrl_c_ends_a_fit_and_its_tasks(cluster, fit):
    identification, trajectories = long_fit()

    def interrupt():
        wait_for(lambda: working(*cluster.ours))
        os.kill(os.getpid(), signal.SIGINT)

    with meanwhile(interrupt), pytest.raises(KeyboardInterrupt):
        fit(identification, trajectories, chunk=2)
    wait_for(lambda: not working(*cluster.ours))


# This test is the last, because it ends the cluster of the others.
def test_a_lost_node_costs_nothing_but_time(new_cluster, Batch, bounce):
    world, _ = bounce
    plan, samples = long_batch(world)
    expected = he.Batch(plan).jacobians_perturbed(world, BY, samples)

    def remove_node():
        new_cluster.remove_node(wait_for(lambda: next(filter(working, new_cluster.ours), None)), allow_graceful=False)

    with meanwhile(remove_node):
        actual = Batch(plan, chunk=4).jacobians_perturbed(world, BY, samples)
    same(actual, expected)
    # The head and one node remain. Ray searches for about 14 s before it declares a node dead.
    wait_for(lambda: sum(node["Alive"] for node in ray.nodes()) == 2)
