"""With which velocity does a thrown ball hit a target after a bounce? JAX differentiates, and L-BFGS searches.

    pip install "hydroelastic[jax]"
    python throw_with_jax.py

The loss is the squared miss at the end, written in JAX. Its gradient goes through 5,000 steps and a bounce with
dissipation and friction. With steps of 0.25 ms, the loss has waves, because it depends on where in a step the ball
meets the floor. The search may end in a local minimum. With steps of 0.1 ms, the search finds the target from any start
nearby.
"""

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

import hydroelastic as he
import hydroelastic.jax as hj

jax.config.update("jax_enable_x64", True)

skin = he.Material(modulus=1e6, dissipation=0.1, friction=0.4)
ball = he.Body.dynamic(
    "ball", he.Shape.icosphere(0.1, 2), skin, mass=1.0, pose=he.pose([0.0, 0.0, 0.5]), velocity=[1.0, 0.0, -2.0]
)
floor = he.Body.fixed("floor", he.Shape.cuboid([4.0, 4.0, 0.2]), skin)
world = he.World([ball, floor], gravity=[0.0, 0.0, -9.81], slip_tolerance=1e-2)
plan = he.Plan(1e-4, 5000, record_every=125)
by = [he.Parameter.initial_velocity("ball")]
target = jnp.array([0.9, 0.3, 0.45])  # m, after 0.5 s


def miss(change):
    """Distance from the target (m)."""
    return jnp.linalg.norm(hj.final_state(world, plan, by, change).poses[0, :3, 3] - target)


def loss(change):
    """Squared distance from the target (m²)."""
    return miss(change) ** 2


# L-BFGS needs the value and the gradient together, which one rollout with its Jacobian computes.
value_and_gradient = jax.jit(jax.value_and_grad(loss))
result = minimize(value_and_gradient, np.zeros(3), jac=True, method="L-BFGS-B", options={"gtol": 1e-8, "ftol": 1e-16})

heights = hj.rollout(world, plan, by, result.x).poses[:, 0, 2, 3]
velocity = np.array([1.0, 0.0, -2.0]) + result.x
before, after = float(miss(np.zeros(3))), float(miss(result.x))
print(f"missed by {1e3 * before:.0f} mm at first, by {1e3 * after:.1e} mm after {result.nfev} rollouts with gradients")
print(f"velocity {velocity.round(4)} m/s, lowest recorded height of the center {1e3 * float(heights.min()):.1f} mm")
assert before > 0.1 and after < 1e-4
assert 0.15 < float(heights.min()) < 0.2 and float(heights[-1]) > 0.4, "the ball has bounced"
