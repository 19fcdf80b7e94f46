"""Prints the CPU time of Ray compared with the rollouts: python tests/ray_times.py [rollouts]

The program reads CPU seconds by process from /proc. For one and two workers and tasks of about 0.2 s, it prints the CPU
time of each worker, of rollouts on one thread without Ray, and of all other processes of Ray. Wall times are meaningful
only on free cores.
"""

import os
import sys
import time

import numpy as np
import ray

import hydroelastic as he
from hydroelastic.ray import _ENVIRONMENT, Batch

TICK = os.sysconf("SC_CLK_TCK")


def cpu_times():
    """Returns CPU seconds of this process and all its descendants: {pid: (name, seconds)}."""
    parents, times = {}, {}
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{process}/stat") as file:
                name, _, rest = file.read().partition("(")[2].rpartition(")")
        except (FileNotFoundError, ProcessLookupError):
            continue
        fields = rest.split()
        parents[int(process)] = int(fields[1])
        times[int(process)] = (name, (int(fields[11]) + int(fields[12])) / TICK)
    ours = {os.getpid()}
    for _ in range(10):
        ours |= {process for process, parent in parents.items() if parent in ours}
    return {process: times[process] for process in ours}


@ray.remote(num_cpus=1, runtime_env=_ENVIRONMENT)
def process_here():
    time.sleep(1.0)  # The delay gives each worker one task.
    return os.getpid()


def main():
    rollouts = int(sys.argv[1]) if len(sys.argv) > 1 else 240
    skin = he.Material(1e5, 0.2, 0.4)
    ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 2), skin, 1.0, pose=he.pose([0.0, 0.0, 0.3]))
    floor = he.Body.fixed("floor", he.Shape.cuboid([4.0, 4.0, 0.2]), skin)
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
    plan = he.Plan(2e-4, 2500, record_every=500)
    by = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]
    samples = np.random.default_rng(0).normal(size=(rollouts, 4)) * [0.5, 0.5, 0.2, 0.01]
    start = time.process_time()
    expected = he.Batch(plan).jacobians_perturbed(world, by, samples)
    alone = time.process_time() - start
    chunk = max(1, round(0.2 * rollouts / alone))
    print(
        f"{rollouts} rollouts with Jacobians without Ray: {alone:.2f} s of CPU; tasks of {chunk}: {alone / rollouts * chunk:.2f} s"
    )
    for cores in (1, 2):
        settings = {"include_dashboard": False, "logging_level": "ERROR", "log_to_driver": False}
        ray.init("local", num_cpus=cores, object_store_memory=200 << 20, **settings)
        Batch(plan, chunk=1).jacobians_perturbed(world, by, samples[: 2 * cores])
        workers = set(ray.get([process_here.remote() for _ in range(cores)]))
        before, start = cpu_times(), time.perf_counter()
        results = Batch(plan, chunk=chunk).jacobians_perturbed(world, by, samples)
        wall, after = time.perf_counter() - start, cpu_times()
        assert all(
            (a.poses == b.poses).all() and (j.poses == k.poses).all() for (a, j), (b, k) in zip(results, expected)
        )
        spent = {pid: (name, seconds - before.get(pid, ("", 0.0))[1]) for pid, (name, seconds) in after.items()}
        of_workers = sorted(seconds for pid, (_, seconds) in spent.items() if pid in workers)
        engine = {}
        for pid, (name, seconds) in spent.items():
            if pid not in workers and seconds > 0.0:
                engine[name] = engine.get(name, 0.0) + seconds
        whole = sum(of_workers) + sum(engine.values())
        print(
            f"{cores} workers: {wall:.2f} s; CPU by worker {', '.join(f'{seconds:.2f}' for seconds in of_workers)} s; all of Ray beside them "
            f"{sum(engine.values()):.2f} s, {100.0 * sum(engine.values()) / whole:.1f} % ({', '.join(f'{name} {seconds:.2f}' for name, seconds in sorted(engine.items()))}); "
            f"{whole:.2f} s in all; load {os.getloadavg()[0]:.1f}"
        )
        ray.shutdown()


if __name__ == "__main__":
    main()
