"""Prints times of calls, for comparison with examples/contact_times.rs: python tests/times.py."""

import subprocess
import sys
import time

import numpy as np

import hydroelastic as he


def least(function, count=3000):
    """Returns the minimum time of a function over ``count`` calls (µs)."""
    times = []
    for _ in range(count):
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return 1e6 * min(times)


code = "import numpy, time; t = time.perf_counter(); import hydroelastic; print(1e3 * (time.perf_counter() - t))"
imports = [float(subprocess.run([sys.executable, "-c", code], capture_output=True).stdout) for _ in range(10)]
print(f"import after numpy: {min(imports):.2f} ms, median {np.median(imports):.2f} ms")

block = he.Shape.cuboid([0.4, 0.4, 0.2])
pose_a = he.pose([0.013, 0.021, 0.1921], [0.3, -0.2, 0.5])
pose_b = he.pose([0.0, 0.0, 0.0], [0.02, -0.03, 0.01])
twist = np.array([0.1, 0.2, -0.3, 0.5, 0.1, -0.05])
for order in range(1, 5):
    pair = he.Pair(he.Shape.icosphere(0.1, order), block, 1e5, 1e6, he.SurfaceLaw(0.2, 0.4, 1e-2))
    times = [
        least(lambda: pair.wrench(pose_a, pose_b)),
        least(lambda: pair.wrench_and_jacobian(pose_a, pose_b)),
        least(lambda: pair.wrench(pose_a, pose_b, twist, twist)),
        least(lambda: pair.linearized(pose_a, pose_b, twist, twist)),
    ]
    names = ("wrench", "with Jacobian", "in motion", "linearized")
    print(f"order {order}:", ", ".join(f"{name} {time:.2f}" for name, time in zip(names, times)))
apart = he.pose([5.0, 0.0, 0.0])
print(f"bodies apart: {least(lambda: pair.wrench(apart, pose_b), 20_000):.2f}")

pair = he.Pair(he.Shape.icosphere(0.1, 3), block, 1e5, 1e6)
poses = np.stack([he.moved_pose(pose_a, [0, 0, 0, 0, 0, -1e-5 * index]) for index in range(400)])
batch = least(lambda: pair.wrench_and_jacobian(poses, pose_b), 30) / 400
loop = least(lambda: [pair.wrench_and_jacobian(pose, pose_b) for pose in poses], 30) / 400
print(f"400 contacts with Jacobians, each: loop {loop:.2f}, batch {batch:.2f}")
