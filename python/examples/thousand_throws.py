"""Do the Jacobians of a thousand random throws agree with the throws themselves? The throws run on a Ray cluster.

    python examples/thousand_throws.py                          # on the cores of the local machine
    RAY_ADDRESS=head:6379 python examples/thousand_throws.py    # on a cluster: docs/python/cluster.md

A ball is thrown onto a floor. Its velocity and friction coefficient are normally distributed. By Stein's lemma, two
results then have the same expected value: the mean Jacobian of the final position, and the slope of the linear
regression of the final position on the drawn numbers. The mean Jacobian needs only derivatives, and the slope needs
only final positions.
"""

import time

import numpy as np

import hydroelastic as he

THROWS = 1000
# Standard deviations of the velocity (m/s) and of the friction coefficient.
SPREAD = np.array([0.3, 0.3, 0.1, 0.01])
# Tolerance of each of the twelve slopes in standard errors. Chance exceeds it in about 1 of 10,000 runs.
ERRORS = 4.5


def main() -> None:
    try:
        from hydroelastic.ray import Batch
    except ImportError as error:
        raise SystemExit(str(error)) from None

    skin = he.Material(modulus=1e5, dissipation=0.2, friction=0.1)
    shape, start = he.Shape.icosphere(0.1, 2), he.pose([0.0, 0.0, 0.3])
    ball = he.Body.dynamic("ball", shape, skin, mass=1.0, pose=start, velocity=[0.8, 0.0, 0.0])
    floor = he.Body.fixed("floor", he.Shape.cuboid([4.0, 4.0, 0.2]), skin)
    world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=0.05)
    plan = he.Plan(5e-4, 800, record_every=800)
    by = [he.Parameter.initial_velocity("ball"), he.Parameter.friction("ball")]
    drawn = np.random.default_rng(1).normal(size=(THROWS, 4)) * SPREAD

    began = time.perf_counter()
    results = Batch(plan, progress=True).jacobians_perturbed(world, by, drawn)
    print(f"{THROWS} throws with Jacobians in {time.perf_counter() - began:.1f} s")
    assert len(results) == THROWS and not any(isinstance(result, Exception) for result in results)
    # The local batch gives the same bits.
    local = he.Batch(plan).jacobians_perturbed(world, by, drawn[:3])
    for (trajectory, jacobian), (same, exact) in zip(results, local):
        assert (trajectory.poses == same.poses).all() and (jacobian.poses == exact.poses).all()

    ends = np.stack([trajectory.poses[-1, 0, :3, 3] for trajectory, _ in results])
    jacobians = np.stack([jacobian.poses[-1, 0, :3, 3] for _, jacobian in results])
    print("mean final position", ends.mean(axis=0).round(4), "m, standard deviation", ends.std(axis=0).round(4), "m")

    mean = jacobians.mean(axis=0)
    columns = np.column_stack([np.ones(THROWS), drawn])
    slope = np.linalg.lstsq(columns, ends, rcond=None)[0][1:].T
    # The residuals of the regression and the scatter of the Jacobians give the standard errors.
    residuals = ends - columns @ np.linalg.lstsq(columns, ends, rcond=None)[0]
    error = np.hypot(residuals.std(axis=0)[:, None] / SPREAD, jacobians.std(axis=0)) / np.sqrt(THROWS)
    print("mean Jacobian\n", mean.round(4), "\nslope of the regression\n", slope.round(4))
    deviation = np.abs(mean - slope) / error
    print(f"they differ by at most {deviation.max():.1f} standard errors")
    assert deviation.max() < ERRORS
    # The agreement is significant, because the slopes are many times their errors.
    assert mean[0, 0] > 20.0 * error[0, 0] and mean[0, 3] < -5.0 * error[0, 3]


if __name__ == "__main__":
    main()
