"""Batches over a cluster of two nodes on one machine: the same bits, whatever is lost on the way."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import hydroelastic as he

ray = pytest.importorskip("ray")
cluster_utils = pytest.importorskip("ray.cluster_utils")

# What a raylet takes for objects; these are small.
STORE = 100 << 20


@pytest.fixture(scope="module")
def cluster():
    """A head without cores and two nodes of one core each."""
    head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": STORE}
    cluster = cluster_utils.Cluster(initialize_head=True, head_node_args=head)
    cluster.ours = [cluster.add_node(num_cpus=1, object_store_memory=STORE) for _ in range(2)]
    ray.init(address=cluster.address, logging_level="ERROR", log_to_driver=False)
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture
def Batch(cluster):
    from hydroelastic.ray import Batch

    return Batch


def bits(result):
    """The bytes of a result: of a trajectory, of one with its Jacobian, or of an exception."""
    if isinstance(result, he.RolloutError):
        return (str(result), bits(result.trajectory))
    if isinstance(result, Exception):
        return (type(result), str(result))
    if isinstance(result, tuple):
        return (bits(result[0]), result[1].poses.tobytes(), result[1].twists.tobytes())
    return None if result is None else (result.times.tobytes(), result.poses.tobytes(), result.twists.tobytes())


def same(found, expected):
    assert [bits(result) for result in found] == [bits(result) for result in expected]
    assert len({bits(result) for result in expected}) > 1


BY = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]


def throws(count):
    """Changes of the velocity and the friction."""
    return np.random.default_rng(3).normal(size=(count, 4)) * [0.5, 0.5, 0.2, 0.0] + [0.0, 0.0, 0.0, 0.1]


def test_every_method_has_the_results_of_the_local_batch(Batch, bounce):
    world, plan = bounce
    samples = throws(7)
    samples[3, 3] = -1.0  # A friction coefficient below zero.
    worlds = [world.changed(BY, sample) for sample in np.delete(samples, 3, axis=0)]
    states = [other.initial_state for other in worlds]
    told = []
    here, there = he.Batch(plan), Batch(plan, chunk=3, progress=lambda done, total: told.append((done, total)))
    same(there.trajectories_after(world, BY, samples), here.trajectories_after(world, BY, samples))
    same(there.jacobians_after(world, BY, samples), here.jacobians_after(world, BY, samples))
    same(there.of_worlds(worlds), here.of_worlds(worlds))
    same(there.starting_from(world, states), here.starting_from(world, states))
    assert told[:3][-1] == (7, 7) and told[-1] == (6, 6) and len(told) == 3 + 3 + 2 + 2
    assert isinstance(there.jacobians_after(world, BY, samples)[3], he.HydroelasticError)
    assert there.of_worlds([]) == [] and there.plan == plan


def test_rollouts_that_end_early_come_back_as_values(Batch, bounce):
    world, _ = bounce
    plan = he.Plan(5e-2, 60)  # Far above the stable step.
    samples = throws(4)
    expected = he.Batch(plan).trajectories_after(world, BY, samples)
    assert any(isinstance(result, he.RolloutError) and len(result.trajectory) > 1 for result in expected)
    same(Batch(plan, chunk=1).trajectories_after(world, BY, samples), expected)


def test_bad_arguments_are_refused_as_by_the_local_batch(Batch, bounce):
    world, plan = bounce
    small = he.State(0.0, np.eye(4)[None], np.zeros((1, 6)))
    calls = [
        lambda batch: batch.jacobians_after(world, BY, throws(2).astype(np.float32)),
        lambda batch: batch.jacobians_after(world, BY, throws(2)[0]),
        lambda batch: batch.trajectories_after(world, [3], throws(2)),
        lambda batch: batch.trajectories_after(3, BY, throws(2)),
        lambda batch: batch.starting_from(world, [world.initial_state, small]),
    ]
    for call in calls:
        with pytest.raises((TypeError, ValueError)) as expected:
            call(he.Batch(plan))
        with pytest.raises(expected.type) as found:
            call(Batch(plan))
        assert str(found.value) == str(expected.value)
    with pytest.raises(TypeError, match="World"):
        Batch(plan).of_worlds([3])
    with pytest.raises(TypeError, match="progress must be"):
        Batch(plan, progress=3).of_worlds([world])
    for refused in ({"chunk": 0}, {"max_retries": -2}):
        with pytest.raises(he.HydroelasticError, match=next(iter(refused))):
            Batch(plan, **refused)
