"""Does the Jacobian of a contact agree with central differences? Also shows its surface, its energy and a batch.

    python python/examples/contact_and_jacobian.py

A ball is pressed into a block and slides on it.
"""

import numpy as np

import hydroelastic as he

ball = he.Shape.icosphere(0.1, 3)  # radius (m), subdivisions
block = he.Shape.cuboid([0.4, 0.4, 0.2])  # edges (m)
law = he.SurfaceLaw(dissipation=0.2, friction=0.4, slip_tolerance=1e-2)
pair = he.Pair(ball, block, 1e5, 1e6, law)  # moduli (Pa)

on_block = he.pose([0.013, 0.021, 0.192], [0.3, -0.2, 0.5])  # 8 mm deep and rotated
at_origin = he.pose()
sliding = np.array([0.1, 0.2, -0.3, 0.5, 0.1, -0.05])  # angular velocity (rad/s), velocity (m/s)
still = np.zeros(6)

wrench, jacobian = pair.linearized(on_block, at_origin, sliding, still)  # (12,), (12, 28)
print("on the ball: torque (N m)", wrench[:3].round(5), "force (N)", wrench[3:6].round(3))

# Columns 0 to 5 are derivatives with respect to a motion of the ball: a rotation about its center (rad), and a
# translation (m).
step = 1e-6
moved = [
    [pair.wrench(he.moved_pose(on_block, sign * step * unit), at_origin, sliding, still) for sign in (1, -1)]
    for unit in np.eye(6)
]
differences = np.array([(plus - minus) / (2 * step) for plus, minus in moved]).T
error = np.abs(jacobian[:, :6] - differences).max() / np.abs(jacobian[:, :6]).max()
print(f"pose columns of the Jacobian: central differences deviate by {error:.0e} of the largest entry")
assert error < 1e-7

# The friction force is at most the coefficient times the normal force, and it opposes the slip.
normal, tangential = wrench[5], wrench[3:5]
assert 0 < np.linalg.norm(tangential) <= 0.4 * normal
assert tangential @ sliding[3:5] < 0

# At rest, the force is minus the slope of the energy.
energies = [pair.potential_energy(he.moved_pose(on_block, [0, 0, 0, 0, 0, dz]), at_origin) for dz in (step, -step)]
force = pair.wrench(on_block, at_origin)[5]
print(f"at rest: force {force:.4f} N, minus the slope of the energy {-(energies[0] - energies[1]) / (2 * step):.4f} N")
assert np.isclose(force, -(energies[0] - energies[1]) / (2 * step), rtol=1e-6)

surface = pair.surface(on_block, at_origin)
print(f"contact surface: {len(surface)} polygons, {1e4 * surface.area:.1f} cm², up to {surface.pressures.max():.0f} Pa")
assert surface.area > 0

# All cores compute a batch, with the same bits as single calls.
heights = np.linspace(0.19, 0.2, 1000)
poses = np.stack([he.pose([0.0, 0.0, height]) for height in heights])
forces = pair.wrench(poses, at_origin)[:, 5]
assert np.all(np.diff(forces) < 0) and forces[0] == pair.wrench(poses[0], at_origin)[5]
print(f"{len(heights)} depths at once: from {forces[0]:.2f} N to {forces[-1]:.2f} N")
