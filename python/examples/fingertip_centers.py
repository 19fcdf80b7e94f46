"""Can a fingertip center itself over a peg, with only a tactile image of 8×8 taxels?

    pip install "hydroelastic[gymnasium]"
    python fingertip_centers.py

Each of 32 soft fingertips presses on a peg with 1 N, at a random place up to 6 mm from its top. Two slides move the
fingertip over the peg with the velocity that the policy commands. The observation is the image of the forces on the
taxels. The policy moves the fingertip towards the center of pressure in the image, until it is in the middle of the pad.
For comparison, two other policies command zero and random velocities.
"""

import gymnasium
import numpy as np

import hydroelastic as he
import hydroelastic.gymnasium as hg

COUNT, STEPS, SIZE = 32, 50, 8
RADIUS, PEG, SPREAD = 0.015, 0.006, 0.006  # Radii of fingertip and peg, and largest start offset (m).
GAIN, SPEED = 15.0, 0.05  # Velocity per distance of the center of pressure (1/s), and its limit (m/s).

skin, law = he.Material(2e5, dissipation=1.0, friction=0.3), he.SurfaceLaw(1.0, 0.3)
tip, peg = he.Shape.icosphere(RADIUS, 3), he.RigidShape.around(he.Shape.icosphere(PEG, 2))
slides = [
    he.Body.dynamic("carriage", None, mass=0.1, joint=he.Joint.prismatic("x", [1.0, 0.0, 0.0], servo_damping=100.0)),
    he.Body.dynamic("bridge", None, mass=0.1, joint=he.Joint.prismatic("y", [0.0, 1.0, 0.0], parent="carriage", servo_damping=100.0)),
]
press = he.Joint.prismatic("z", [0.0, 0.0, 1.0], parent="bridge", damping=5.0, torque=-1.0)
finger = he.Body.dynamic("finger", tip, skin, mass=0.05, joint=press)
world = he.World([*slides, finger, he.Body.fixed("peg", peg, he.Material.rigid(friction=0.3))])

# The x axis of the grid is parallel to that of the world. Its y and z axes are opposite to those of the world.
grid = he.TaxelGrid.dome([1.6, 1.6], SIZE, SIZE, frame=he.pose([0.0, 0.0, 0.0], [np.pi, 0.0, 0.0]))
pair = he.Pair(tip, peg, 2e5, law=law)
angles = 1.6 * ((np.arange(SIZE) + 0.5) / SIZE - 0.5)


def image(states):
    """Forces (N) on the taxels of every fingertip."""
    (pose_a, pose_b), (twist_a, twist_b) = (np.moveaxis(each[:, 2:], 1, 0) for each in (states.poses, states.twists))
    return pair.tactile_image(grid, pose_a, pose_b, twist_a, twist_b)


def offset(states):
    """Horizontal distances (m) of the fingertips from the middle of the peg."""
    return np.linalg.norm(states.poses[:, 2, :2, 3], axis=-1)


def starts(random, states):
    """Fingertips that touch the peg at random places."""
    angle, distance = random.uniform(0.0, 2.0 * np.pi, len(states)), SPREAD * np.sqrt(random.uniform(0.1, 1.0, len(states)))
    x, y = distance * np.cos(angle), distance * np.sin(angle)
    height = np.sqrt((RADIUS + PEG) ** 2 - distance**2) - 2e-4
    return he.States([world.state_with_joints({"x": x, "y": y, "z": z}) for x, y, z in zip(x, y, height, strict=True)])


def centering(observations, _):
    """Velocities (m/s) towards the center of pressure."""
    pressing = np.maximum(-observations[..., 2], 0.0)
    total = np.maximum(pressing.sum(axis=(1, 2)), 1e-6)
    x = pressing.sum(axis=1) @ np.sin(angles) / total
    y = -(pressing.sum(axis=2) @ np.sin(angles)) / total
    return np.clip(GAIN * RADIUS * np.stack([x, y], axis=-1), -SPEED, SPEED)


environment = hg.WorldVectorEnv(
    world,
    he.Plan(0.01, 2, he.Integrator.IMPLICIT_EULER),
    COUNT,
    actions=[he.Parameter.joint(name, "target_velocity") for name in "xy"],
    action_space=gymnasium.spaces.Box(-SPEED, SPEED, (2,), dtype=np.float64),
    observation_space=gymnasium.spaces.Box(-np.inf, np.inf, (SIZE, SIZE, 3), dtype=np.float64),
    observe=image,
    reward=lambda before, actions, after: -offset(after),
    start=starts,
    max_steps=STEPS,
)


def offsets(policy):
    """Distances (m) of the fingertips from the middle of the peg at the start and at the end of an episode."""
    observations, _ = environment.reset(seed=1)
    environment.action_space.seed(2)
    start = offset(environment.states)
    for _ in range(STEPS):
        observations, _, _, truncations, infos = environment.step(policy(observations, environment.action_space))
        assert "error" not in infos
    assert truncations.all()
    return start, offset(environment.states)


policies = {
    "centered": centering,
    "still": lambda observations, _: np.zeros((COUNT, 2)),
    "random": lambda _, actions: actions.sample(),
}
results = {name: offsets(policy) for name, policy in policies.items()}
for name, (start, end) in results.items():
    print(f"{name}: mean distance {1e3 * start.mean():.2f} mm at the start, {1e3 * end.mean():.2f} mm at the end")
assert results["centered"][1].max() < 3e-4
assert all(results[name][1].mean() > results[name][0].mean() for name in ("still", "random"))
