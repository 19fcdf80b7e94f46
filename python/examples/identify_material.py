"""How accurately does the recorded motion of a ball determine its modulus and friction coefficient?

    pip install hydroelastic
    python identify_material.py

A ball falls on a floor while it slides and spins. Its position and angular velocity are recorded 200 times in 0.5 s,
with the noise of a camera and a gyroscope. The Gauss-Newton method uses the Jacobian of the rollout. It finds the
modulus and the friction coefficient from a guess that is wrong by a factor of two, and the standard deviations of both.
"""

import numpy as np

import hydroelastic as he

TRUTH = {"modulus": 1.3e5, "friction": 0.25}
NOISE = np.array([2e-4] * 3 + [2e-2] * 3)  # m, rad/s


def thrown(modulus, friction):
    """A world with a ball of a modulus and a friction coefficient above a floor."""
    skin = he.Material(modulus, dissipation=0.2, friction=friction)
    ball = he.Body.dynamic(
        "ball",
        he.Shape.icosphere(0.1, 2),
        skin,
        mass=1.0,
        pose=he.pose([0.0, 0.0, 0.25]),
        velocity=[1.5, 0.0, 0.0],
        angular_velocity=[0.0, -5.0, 2.0],
    )
    floor = he.Body.fixed("floor", he.Shape.cuboid([4.0, 4.0, 0.2]), he.Material(1e7, dissipation=0.2, friction=0.8))
    return he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)


plan = he.Plan(2.5e-4, 2000, record_every=10)
by = [he.Parameter.modulus("ball"), he.Parameter.friction("ball")]


def measured(trajectory):
    """Positions and angular velocities of the ball without the initial state, (200, 6)."""
    return np.concatenate([trajectory.poses[1:, 0, :3, 3], trajectory.twists[1:, 0, :3]], 1)


def residuals(numbers, record):
    """Residuals in standard deviations of the noise, and their Jacobian with respect to the logarithms of the numbers.
    """
    trajectory, jacobian = thrown(*numbers).jacobian(plan, by)
    slopes = np.concatenate([jacobian.poses[1:, 0, :3, 3], jacobian.twists[1:, 0, :3]], 1)
    deviations = (measured(trajectory) - record) / NOISE
    return deviations.ravel(), (slopes / NOISE[:, None] * numbers).reshape(-1, 2)


random = np.random.default_rng(1)
exact = measured(thrown(*TRUTH.values()).rollout(plan).run())
record = exact + NOISE * random.normal(size=exact.shape)

numbers = np.array([6e4, 0.5])
for iteration in range(30):
    deviations, slopes = residuals(numbers, record)
    change = np.linalg.lstsq(slopes, -deviations)[0]
    # A step is limited to a factor of 1.5, because the linearization is inaccurate far from the solution.
    numbers = numbers * np.exp(np.clip(change, -0.4, 0.4))
    if np.abs(change).max() < 1e-8:
        break

deviations, slopes = residuals(numbers, record)
relative = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
truth = np.array(list(TRUTH.values()))
errors = np.abs(numbers / truth - 1)
print(f"{iteration + 1} iterations; the residuals are {np.std(deviations):.3f} of the noise")
for name, number, error, deviation in zip(TRUTH, numbers, errors, relative):
    print(f"{name}: {number:.6g}, off by {100 * error:.3f} %, standard deviation {100 * deviation:.3f} %")
assert np.abs(change).max() < 1e-8, "Gauss-Newton has converged"
assert (relative < 5e-3).all(), "the record determines both numbers to half a percent"
assert (errors < 4 * relative).all(), "the true numbers are within four standard deviations"
assert abs(np.std(deviations) - 1) < 0.1, "the residuals are the noise"
