"""Can a neural network learn to throw a rolling ball so that the ball hits a target after a bounce?

    pip install "hydroelastic[jax]"
    python throw_policy.py

A ball rolls over the ground with a random velocity. For 0.2 s, a network with 1,027 weights reads its state and the
target every 10 ms and pushes it. Then the ball flies for 0.7 s, and bounces with friction. Adam minimizes the mean
squared miss. Reverse mode computes the gradient through 20 evaluations of the network and all 1,800 steps, contacts
included.
"""

import jax
import jax.numpy as jnp
import numpy as np

import hydroelastic as he
import hydroelastic.jax as hj

jax.config.update("jax_enable_x64", True)

INTERVALS, STEP, BATCH, ITERATIONS, RATE = 20, 5e-4, 8, 300, 0.01

skin = he.Material(modulus=1e5, dissipation=0.1, friction=0.5)
ball = he.Body.dynamic("ball", he.Shape.icosphere(0.1, 1), skin, mass=1.0, pose=he.pose([0.0, 0.0, 0.1]))
ground = he.Body.fixed("ground", he.HalfSpace(), he.Material.rigid(friction=0.5))
push = he.Control("ball", 1e-2, np.zeros((1, 6)))
world = he.World([ball, ground], gravity=[0.0, 0.0, -9.81], controls=[push], slip_tolerance=1e-2)
by = [he.Parameter.control("ball", 0)]
pushed, flight = he.Plan(STEP, round(1e-2 / STEP)), he.Plan(STEP, 1400, record_every=20)


def episodes(random, count):
    """Random rolling balls and targets: the states of both bodies, and the targets (m), (count, 3)."""
    velocity = random.uniform([-0.5, -0.5, 0.0], [0.5, 0.5, 0.0], (count, 3))
    spin = np.cross([0.0, 0.0, 1.0], velocity) / 0.1
    twists = np.zeros((count, 2, 6))
    twists[:, 0] = np.concatenate([spin, velocity], 1)
    poses = np.broadcast_to(world.initial_state.poses, (count, 2, 4, 4))
    return hj.State(poses, twists), random.uniform([0.6, -0.3, 0.15], [1.2, 0.3, 0.3], (count, 3))


def network(random):
    """Random initial weights and biases of each layer."""
    sizes = [13, 32, 16, 3]
    return [(random.normal(size=(m, n)) / np.sqrt(m), np.zeros(n)) for m, n in zip(sizes, sizes[1:])]


def policy(weights, state, target, time):
    """Force (N) on the ball."""
    twist, position = state.twists[:, 0], state.poses[:, 0, :3, 3]
    times = jnp.broadcast_to(time, (len(target), 1))
    layer = jnp.concatenate([position, 0.1 * twist[:, :3], twist[:, 3:], target, times], 1)
    for weight, bias in weights[:-1]:
        layer = jnp.tanh(layer @ weight + bias)
    weight, bias = weights[-1]
    return jnp.array([0.0, 0.0, 20.0]) + 5.0 * (layer @ weight + bias)


def thrown(weights, start, target):
    """States of the balls at their release."""

    def push_for_interval(state, time):
        force = policy(weights, state, target, time)
        wrench = jnp.concatenate([jnp.zeros_like(force), force], 1)
        return hj.final_state(world, pushed, by, wrench, start=state), None

    return jax.lax.scan(push_for_interval, start, jnp.linspace(-1.0, 1.0, INTERVALS))[0]


def loss(weights, start, target):
    """Mean squared miss (m²)."""
    last = hj.final_state(world, flight, start=thrown(weights, start, target))
    return jnp.mean(jnp.sum((last.poses[:, 0, :3, 3] - target) ** 2, 1))


@jax.jit
def improved(weights, moments, iteration, start, target):
    """Loss, and weights and moments after a step of Adam."""
    value, slopes = jax.value_and_grad(loss)(weights, start, target)
    means, squares = moments
    means = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, means, slopes)
    squares = jax.tree.map(lambda s, g: 0.99 * s + 0.01 * g * g, squares, slopes)
    unbiased = jnp.sqrt(1.0 - 0.99**iteration) / (1.0 - 0.9**iteration)
    rate = RATE * (1.0 - (iteration - 1) / ITERATIONS) * unbiased
    weights = jax.tree.map(lambda w, m, s: w - rate * m / (jnp.sqrt(s) + 1e-8), weights, means, squares)
    return value, weights, (means, squares)


random = np.random.default_rng(1)
weights = jax.tree.map(jnp.asarray, network(random))
moments = (jax.tree.map(jnp.zeros_like, weights),) * 2
unseen = episodes(np.random.default_rng(2), 32)
compiled_loss = jax.jit(loss)
before = float(compiled_loss(weights, *unseen))
for iteration in range(1, ITERATIONS + 1):
    value, weights, moments = improved(weights, moments, float(iteration), *episodes(random, BATCH))
    if iteration % 50 == 0:
        print(f"iteration {iteration}: misses by {1e3 * float(value) ** 0.5:.0f} mm")
after = float(compiled_loss(weights, *unseen))
count = sum(array.size for array in jax.tree.leaves(weights))
heights = hj.rollout(world, flight, start=thrown(weights, *unseen)).poses[:, :, 0, 2, 3]
bounced = int(np.sum((heights[:, 0] > 0.1) & (heights.min(1) < 0.1)))
print(f"{count} weights; root mean square miss of test throws:", end=" ")
print(f"{1e3 * before**0.5:.0f} mm before, {1e3 * after**0.5:.0f} mm after")
print(f"{bounced} of {len(heights)} balls are in the air at their release, and bounce")
assert after < before / 50 and bounced > 0.9 * len(heights)
